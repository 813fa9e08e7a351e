"""Figure 2, and the largest potential over time."""

from __future__ import annotations

from myostrain.output.figures.style import BLUE, GREEN, GREY, SEQUENTIAL, VERMILION, new_figure
from myostrain.reproduce.chapters.figure_2.jobs import KINDS, PRINTED
from myostrain.reproduce.content import Measured

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

#: Times that are drawn.
DRAWN = (0.01, 0.05, 0.1, 0.2, 0.3, 0.4)


def _profiles(measured: Measured) -> Figure:
    figure = new_figure(6.0, 5.0)
    colours = mpl.colormaps[SEQUENTIAL](np.linspace(0.0, 0.88, len(DRAWN)))
    titles = ("(a) coupled", "(b) held at $x'$ = 1 for $t$ < 0.01")
    for axes, kind, title in zip(figure.subplots(2, 1, sharex=True), KINDS, titles, strict=True):
        arrays = measured.found[f"paper, {kind}"].arrays
        X = np.concatenate([-arrays["X"][:0:-1], arrays["X"]])
        axes.plot(X, np.where(np.abs(X) <= 1, 0.6, 0.0), ":", color=GREY, label="0")
        for time, colour in zip(DRAWN, colours, strict=True):
            v = arrays["potential"][int(np.argmin(np.abs(arrays["times"] - time)))]
            axes.plot(X, np.concatenate([v[:0:-1], v]), color=colour, label=f"{time:g}")
        axes.set(ylim=(-0.25, 1.0), xlim=(-42, 30), ylabel="potential $v$")
        axes.set_title(title, loc="right")
    figure.axes[0].legend(loc="upper left", title="$t$", ncols=2)
    figure.axes[1].set_xlabel("material coordinate $X$")
    return figure


def _peaks(measured: Measured) -> Figure:
    figure = new_figure(6.0, 3.8)
    axes = figure.subplots()
    shown = {
        "paper": ("Δx = 1, three nodes", "black"),
        "sampled": ("fine, half-width 1.5", VERMILION),
        "printed": ("fine, half-width 1", BLUE),
    }
    for name, (text, colour) in shown.items():
        for kind, line, label in (("held", "-", text), ("coupled", "--", None)):
            arrays = measured.found[f"{name}, {kind}"].arrays
            peaks = [PRINTED[1], *arrays["potential"].max(axis=1)]
            axes.plot([0, *arrays["times"]], peaks, line, color=colour, label=label)
    axes.axhline(0.1, color=GREEN, linewidth=0.8, zorder=0)
    axes.annotate(r"$\alpha$", (0.3, 0.1), (0, 3), textcoords="offset points", color=GREEN)
    axes.set(xlim=(0, 0.31), ylim=(0, 1.0), xlabel="time $t$", ylabel="largest $v$")
    axes.legend(loc="center right")
    return figure


PICTURES = {"figure-2": _profiles, "figure-2-meshes": _peaks}
