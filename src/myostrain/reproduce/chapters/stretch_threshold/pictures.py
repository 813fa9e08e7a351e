"""Threshold stretches over the conductance, points that are held, and slow, brief and small stretches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from myostrain.output.figures.style import BLUE, GREEN, GREY, ORANGE, VERMILION, new_figure
from myostrain.reproduce.content import Measured

import numpy as np
from matplotlib.figure import Figure

COLOURS = {"AlievPanfilov1996": BLUE, "FitzHughNagumo": VERMILION}
TICKS = (0.5, 1, 2, 5, 10, 20, 40)
NAMES = {"AlievPanfilov1996": "Aliev–Panfilov", "FitzHughNagumo": "FitzHugh–Nagumo, the paper's"}


def _thresholds(measured: Measured) -> Figure:
    figure = new_figure(7.8, 3.4)
    left, right = figure.subplots(1, 2)
    curve = np.linspace(0.3, 3.2, 200)
    for name, colour in COLOURS.items():
        one = measured.numbers["thresholds"][name]
        left.plot(curve, 1 + one["mean_drive"] / curve, "-", color=colour, lw=1.2)
        left.plot(curve, 1 + one["estimate"] / curve, ":", color=colour, lw=1.4)
        left.plot(one["conductances"], one["stretch"], "o", color=colour, ms=5, label=NAMES[name])
    left.plot([], [], ":", color=GREY, label="estimate, states at rest")
    left.set(xlabel="conductance g", ylabel="stretch λ that excites", ylim=(1.0, 3.0), xlim=(0.3, 3.2))
    left.legend(loc="upper right")
    held = measured.found["held"].arrays
    drives, wanted = held["drives"], (0.04, 0.05, 0.06, 0.1, 0.4, 2.0)
    for number, drive in enumerate(wanted):
        row = int(np.abs(drives - drive).argmin())
        shade = (GREY, GREY, BLUE, GREEN, ORANGE, VERMILION)[number]
        right.plot(held["times"], held["potential"][:, row], color=shade, lw=1.3, label=f"{drives[row]:.2g}")
    right.set(xlabel="time after the stretch", ylabel="potential v", xlim=(0, 60), ylim=(-0.05, 1.45))
    right.legend(title="g (λ − 1)", loc="upper right", ncols=3)
    return figure


def _slow(measured: Measured) -> Figure:
    figure = new_figure(7.8, 3.2)
    left, right = figure.subplots(1, 2)
    n = measured.numbers
    drive = n["thresholds"]["AlievPanfilov1996"]["mean_drive"]
    for way, colour, label in (
        ("ramp", BLUE, "reached in this time, then held"),
        ("brief", VERMILION, "held for this time, then let go"),
    ):
        stretch = np.array(n[way]["stretch"], dtype=float)
        left.plot(n[way]["times"], stretch, "o-", color=colour, ms=5, lw=1.2, label=label)
    left.axhline(1 + drive, color=GREY, ls=":", label="at once, for ever")
    left.set(xscale="log", xlabel="time", ylabel="stretch λ that excites, g = 1")
    _plain(left, [time for time in TICKS if time <= max(n["ramp"]["times"])])
    _headroom(left, 0.4)
    left.legend(loc="upper right")
    right.plot(n["segments"]["halves"], n["segments"]["drive"], "o-", color=GREEN, ms=5, lw=1.2)
    right.axhline(drive, color=GREY, ls=":", label="all of the line")
    right.set(
        xscale="log", xlabel="half length of the part with the current", ylabel="g (λ − 1) that starts a wave"
    )
    _plain(right, n["segments"]["halves"])
    right.legend(loc="upper right")
    return figure


def _headroom(ax: Any, share: float) -> None:
    """Room for a legend above what is drawn, as a share of its height."""
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + share * (high - low))


def _plain(ax: Any, ticks: Sequence[float]) -> None:
    """Ticks of a logarithmic axis as plain numbers."""
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.minorticks_off()


PICTURES = {"stretch-threshold": _thresholds, "stretch-threshold-slow": _slow}
