"""Which bumps fire beside (5.2), and what is missing in (5.1) over the time step."""

from __future__ import annotations

from typing import Any

from myostrain.output.figures.style import BLUE, GREEN, GREY, VERMILION, new_figure
from myostrain.reproduce.chapters.startup.jobs import DENSE, FAMILIES
from myostrain.reproduce.chapters.startup.text import settings
from myostrain.reproduce.content import Measured

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

#: Colour and marker of a line.
LOOKS = {"coupled": (BLUE, "o"), "held": (VERMILION, "s"), "rigid": (GREEN, "^")}
MARKERS = {"second-order": "o", "implicit": "s", "staggered": "^"}
#: Body, form of the identity, colour and name of what is drawn.
DEFECTS = (
    ("line", "printed", VERMILION, "line, as printed"),
    ("line", "whole", BLUE, "line, with $J$ and $J_t$"),
    ("sheet", "printed", GREEN, "sheet, as printed"),
)


def _maps(measured: Measured) -> Figure:
    figure = new_figure(6.4, 9.0)
    families = [family for family in FAMILIES if FAMILIES[family][3]]
    for axes, family in zip(figure.subplots(len(families), 1, sharex=True), families, strict=True):
        _draw_map(axes, measured, family)
    axes.set_xlabel("half-width $R$")
    lines = [Line2D([], [], color=c, marker=m, label=mode) for mode, (c, m) in LOOKS.items()]
    figure.legend(handles=lines, loc="outside lower center", ncols=3)
    return figure


def _draw_map(axes: Any, measured: Measured, family: str) -> None:
    dense = measured.found[f"(5.2) {family} dense"].numbers
    low, high = (np.array(dense[name], dtype=float) for name in ("from", "to"))
    axes.fill_between(DENSE, low, high, color=GREY, alpha=0.3, linewidth=0)
    if np.isfinite(low).any():
        axes.text(26, 0.62, "(5.2) holds", color="#444444", ha="center")
    for mode, (colour, marker) in LOOKS.items():
        rows = [r for r in measured.numbers["map"] if (r["family"], r["mode"]) == (family, mode)]
        x = [r["half_width"] for r in rows]
        y = np.array([r["threshold"] for r in rows], dtype=float)
        axes.plot(x, y, color=colour, marker=marker, markersize=5, linewidth=1.4, label=mode)
    if FAMILIES[family][0] == "step":
        axes.plot(1, 0.6, "x", color="black", markersize=8, markeredgewidth=2)
    axes.set(xscale="log", ylim=(0, 1.02), ylabel="height of the bump", title=settings(family))
    axes.set_xticks([1, 2, 3, 5, 10, 20, 40], ["1", "2", "3", "5", "10", "20", "40"], minor=False)
    axes.minorticks_off()
    axes.set_xlim(0.9, 44)


def _defects(measured: Measured) -> Figure:
    figure = new_figure(6.4, 4.4)
    axes = figure.subplots()
    for body, form, colour, _ in DEFECTS:
        for scheme, marker in MARKERS.items():
            values = np.abs(measured.found[f"energy {body} {scheme}"].numbers[form])
            steps = 4e-4 / 2.0 ** np.arange(len(values))
            axes.loglog(steps, values, color=colour, marker=marker, linestyle="-", markersize=5)
    handles = [Line2D([], [], color=colour, label=name) for _, _, colour, name in DEFECTS]
    handles += [
        Line2D([], [], color="#444444", marker=marker, linestyle="none", label=name)
        for name, marker in MARKERS.items()
    ]
    figure.legend(handles=handles, ncols=2, loc="outside lower center")
    axes.set_xticks(steps, [f"{step:g}" for step in steps])
    axes.minorticks_off()
    axes.set(xlabel="time step", ylabel="relative defect of (5.1)")
    return figure


PICTURES = {"startup-map": _maps, "startup-energy": _defects}
