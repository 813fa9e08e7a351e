"""Human pulses over space, what a delay leaves of the celerity's gain, and the front of a held line."""

from __future__ import annotations

from typing import Any

from myostrain.output.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION, new_figure
from myostrain.reproduce.chapters.human_pulse import jobs
from myostrain.reproduce.content import Measured

import numpy as np
from matplotlib.figure import Figure

SHOWN: dict[str, tuple[str, str]] = {
    "rigid": ("black", "--"),
    "conservative": (BLUE, "-"),
    "advective": (GREEN, "-"),
    "relaxing": (VERMILION, "-"),
    "rossi": (PURPLE, "-"),
}


def _behind(arrays: Any, numbers: Any) -> Any:
    """Places in x behind the front of a steady pulse, from what passes one place."""
    times, stretch = arrays["times"], 1 - arrays["shortening"]
    passed = np.concatenate([[0.0], np.cumsum(np.diff(times) * (stretch[1:] + stretch[:-1]) / 2)])
    return -numbers["celerity"] * (passed - np.interp(numbers["upstroke"], times, passed))


def _pulses(measured: Measured) -> Figure:
    figure = new_figure(7.8, 5.6)
    axes = figure.subplots(2, 2, sharey=True)
    for column, (m, name) in zip(axes.T, jobs.HUMAN.items(), strict=True):
        for kind, (colour, style) in SHOWN.items():
            one = measured.found[f"{m} {kind}"]
            for ax in column:
                places, text = _behind(one.arrays, one.numbers), jobs.KINDS[kind]
                ax.plot(places, one.arrays["excitation"], style, color=colour, lw=1.4, label=text)
        column[0].set(title=name, xlim=(-250, 20))
        column[1].set(xlim=(-0.8, 2.2), xlabel="$x$ − front [mm]")
        column[0].axhline(0.5, color=ORANGE, lw=0.8, zorder=0)
    for ax in axes[:, 0]:
        ax.set_ylabel("excitation")
    axes[1, 1].legend(loc="upper right", fontsize=7.5)
    return figure


def _left(measured: Measured) -> Figure:
    figure = new_figure(7.8, 3.8)
    left, right = figure.subplots(1, 2)
    n = measured.numbers
    rise = np.geomspace(0.02, 60, 200)
    left.semilogx(rise, 1 / (1 + rise / n["foot"]), "-", color=GREY, label="$1/(1 + τc_0^2/D)$")
    for (balance, rows), colour in zip(n["sweep"].items(), (BLUE, GREEN), strict=False):
        left.semilogx(*([row[key] for row in rows] for key in ("rise", "left")), "o", color=colour, ms=5,
                      label=balance)  # fmt: skip
    left.axhline(0, color=GREY, lw=0.6, zorder=0)
    left.set(xlabel="rise time of the contraction [ms]", ylabel="share of the celerity's gain that is left")
    left.legend(loc="upper right")
    rigid = n["rows"]["BOCF"]["rigid"]["celerity"]
    for name, colour, text in (("held", VERMILION, "relaxing"), ("held at once", BLUE, "at once")):
        X, arrival, stretch = (measured.found[name].arrays[key] for key in ("X", "arrival", "front_stretch"))
        places = np.arange(4.0, 22.1, 1.0)
        speeds = 1 / np.diff(np.interp(places, X, arrival)) / rigid
        middle = (places[1:] + places[:-1]) / 2
        right.plot(middle, speeds, "o", ms=4, color=colour, label=f"{text}: celerity in $X$")
        if name == "held":
            right.plot(middle, 1 / np.interp(middle, X, stretch), "-", color=colour, lw=1.2,
                       label="relaxing: 1 over the stretch there")  # fmt: skip
    right.axhline(1, color="black", lw=0.8, ls="--", zorder=0)
    right.set(xlabel="$X$ [mm]", ylabel="over the rigid line's celerity")
    right.legend(loc="upper right", fontsize=8)
    return figure


PICTURES = {"human-pulse": _pulses, "human-pulse-delay": _left}
