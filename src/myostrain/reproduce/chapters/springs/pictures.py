"""Forces of springs, and the difference in (1.12) over the strain."""

from __future__ import annotations

from myostrain.output.figures.style import BLUE, GREEN, GREY, VERMILION, new_figure
from myostrain.reproduce.chapters.springs.jobs import SIZES
from myostrain.reproduce.content import Measured

import numpy as np
from matplotlib.figure import Figure


def _forces(measured: Measured) -> Figure:
    linear, cubic = (measured.found[name].arrays for name in ("linear", "cubic"))
    figure = new_figure(6.0, 5.6)
    above, below = figure.subplots(2, 1, sharex=True)
    length, best = cubic["length"], measured.numbers["cubic"]["best_constant"][0]
    above.plot(length, linear["needed"], color=GREY, label="linear spring")
    above.plot(length, cubic["needed"], color=BLUE, label="cubic spring")
    above.axhline(best, color=VERMILION, linestyle="--", label="best constant, cubic spring")
    above.set_ylabel("active force $f_a$ needed")
    above.legend(loc="upper center")
    below.plot(length, cubic["active_strain"], color=BLUE, label="active strain (1.10)")
    label = "active stress (1.9), best constant"
    below.plot(length, cubic["active_stress"], color=VERMILION, linestyle="--", label=label)
    below.axhline(0, color=GREY, linewidth=0.7)
    below.set(xlabel="length $\\ell$", ylabel="force $f$ of the cubic spring")
    below.legend(loc="upper left")
    return figure


def _small_strains(measured: Measured) -> Figure:
    figure = new_figure(6.0, 4.2)
    axes = figure.subplots()
    shown = {
        "neo_hookean_residual": (VERMILION, "energy alone: residual stress"),
        "neo_hookean": (BLUE, "without residual stress"),
        "neo_hookean_pulled_back": (GREEN, "the same, pulled back (1.6)"),
    }
    for name, (colour, label) in shown.items():
        sizes, differences = (measured.found[name].arrays[key] for key in ("sizes", "differences"))
        ends = differences.min(axis=0), differences.max(axis=0)
        axes.fill_between(sizes, *ends, color=colour, alpha=0.18, lw=0)
        axes.plot(sizes, np.median(differences, axis=0), "o-", markersize=4, color=colour, label=label)
    guide = np.array([SIZES[-1], SIZES[2]])
    axes.plot(guide, 3 * guide**2, color=GREY, linestyle=":", label="slope 2")
    axes.set(xscale="log", yscale="log", xlabel="strain ε", ylabel="norm of the difference in (1.12)")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.91))
    return figure


PICTURES = {"springs-forces": _forces, "springs-small-strains": _small_strains}
