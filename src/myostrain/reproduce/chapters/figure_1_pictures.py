"""Pictures of the chapter on figure 1."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from myostrain.output.figures.style import BLUE, GREEN, ORANGE, PURPLE, VERMILION, new_figure
from myostrain.reproduce.content import Picture
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.page import number

from matplotlib.figure import Figure


def pictures(found: Mapping[str, Found], step: float) -> list[Picture]:
    """The pictures, from the runs with Δx = 1 and this time step."""
    settings = f"Δx = 1, Δt = {number(step)}, t = 5"
    return [
        Picture(
            "figure-1",
            f"The paper's figure 1: potential against spatial coordinate, conservative line as printed. {settings}.",
            "Two pulses against x: the coupled one is ahead of the rigid one and a little wider.",
            partial(_figure, found),
        ),
        Picture(
            "figure-1-readings",
            f"The same with all readings, moved so that the fronts meet. {settings}.",
            "Five pulses with their fronts at one place: the viscoelastic one is the shortest, the conservative "
            "one the widest.",
            partial(_figure_readings, found),
        ),
    ]


def _figure(found: Mapping[str, Found]) -> Figure:
    figure = new_figure(6.0, 3.5)
    axes = figure.subplots()
    for row, line, text in (("rigid", "--", "rigid"), ("conservative", "-", "coupled")):
        x, v = found[row].arrays["x"][-1], found[row].arrays["potential"][-1]
        axes.plot(x, v, line, color="black" if row == "rigid" else BLUE, label=text)
    axes.set(xlim=(170, 330), ylim=(-0.25, 1.0), xlabel="spatial coordinate $x$", ylabel="potential $v$")
    axes.legend(loc="upper left")
    return figure


def _figure_readings(found: Mapping[str, Found]) -> Figure:
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
        x, v = found[row].arrays["x"][-1], found[row].arrays["potential"][-1]
        axes.plot(x - found[row].numbers["front_spatial"], v, line, color=colour, label=text)
    axes.axhline(0.5, color=ORANGE, linewidth=0.8, zorder=0)
    axes.set(xlim=(-62, 22), ylim=(-0.25, 1.0), xlabel="$x$ − front", ylabel="potential $v$")
    axes.legend(loc="upper left")
    return figure
