"""Figure 1, and the same with all readings."""

from __future__ import annotations

from myostrain.output.figures.style import BLUE, GREEN, ORANGE, PURPLE, VERMILION, new_figure
from myostrain.reproduce.content import Measured

from matplotlib.figure import Figure


def _paper(measured: Measured) -> Figure:
    figure = new_figure(6.0, 3.5)
    axes = figure.subplots()
    for row, line, text, colour in (
        ("rigid", "--", "rigid", "black"),
        ("conservative", "-", "coupled", BLUE),
    ):
        arrays = measured.found[row].arrays
        axes.plot(arrays["x"][-1], arrays["potential"][-1], line, color=colour, label=text)
    axes.set(xlim=(170, 330), ylim=(-0.25, 1.0), xlabel="spatial coordinate $x$", ylabel="potential $v$")
    axes.legend(loc="upper left")
    return figure


def _readings(measured: Measured) -> Figure:
    figure = new_figure(6.0, 3.8)
    axes = figure.subplots()
    styles = {
        "rigid": ("rigid", "black", "--"),
        "conservative": ("conservative, β = 0.3", BLUE, "-"),
        "beta_01": ("conservative, β = 0.1", PURPLE, "-"),
        "advective": ("advective", GREEN, "-."),
        "viscous": ("viscoelastic, λ = 0.4 τ", VERMILION, "-"),
    }
    for row, (text, colour, line) in styles.items():
        arrays, front = measured.found[row].arrays, measured.numbers["rows"][row]["front_spatial"]
        axes.plot(arrays["x"][-1] - front, arrays["potential"][-1], line, color=colour, label=text)
    axes.axhline(0.5, color=ORANGE, linewidth=0.8, zorder=0)
    axes.set(xlim=(-62, 22), ylim=(-0.25, 1.0), xlabel="$x$ − front", ylabel="potential $v$")
    axes.legend(loc="upper left")
    return figure


PICTURES = {"figure-1": _paper, "figure-1-readings": _readings}
