"""A pacemaker as it begins, the excited share over time, and arrivals and delays."""

from __future__ import annotations

from typing import Any

from myostrain.output.figures.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    POTENTIAL,
    SEQUENTIAL,
    VERMILION,
    new_figure,
)
from myostrain.reproduce.chapters.stretch_feedback import jobs
from myostrain.reproduce.content import Measured

import numpy as np
from matplotlib.figure import Figure

SHOWN: dict[str, tuple[str, Any]] = {
    "quick strain 3": ("strain along the fibre, g = 3", (GREY, "-")),
    "quick strain in plane 2": ("strain in plane, g = 2", (BLUE, ":")),
    "quick strain in plane 3": ("strain in plane, g = 3", (BLUE, "-")),
    "quick stress in plane 2": ("stress in plane, g = 2", (VERMILION, "-")),
    "quick stress, held in plane 2": ("stress in plane matched held, g = 2", (ORANGE, "--")),
}


def _squares(measured: Measured) -> Figure:
    figure = new_figure(7.8, 4.6)
    parts: Any = figure.subfigures(2, 1, height_ratios=(1, 1.05))
    above, below = parts
    one = measured.found["quick strain in plane 3"].arrays
    axes = above.subplots(1, 4)
    drawn: Any = None
    for ax, time, values in zip(axes, one["frame_times"], one["frames"], strict=True):
        drawn = ax.tripcolor(
            *one["X"].T, one["cells"], values, vmin=POTENTIAL[0], vmax=POTENTIAL[1], cmap=SEQUENTIAL,
            shading="gouraud", rasterized=True,
        )  # fmt: skip
        ax.set(aspect="equal", title=f"t = {time:.0f}")
        ax.set_axis_off()
    above.colorbar(drawn, ax=axes, label="v", shrink=0.8)
    ax = below.subplots()
    for name, (label, (colour, style)) in SHOWN.items():
        arrays = measured.found[name].arrays
        ax.plot(arrays["times"], arrays["excited"], style, color=colour, lw=1.3, label=label)
    ax.set(
        xlabel="time", ylabel="excited share", xlim=(0, jobs.ends(measured.quick)["sheet"]), ylim=(0, 0.75)
    )
    ax.legend(ncols=2, loc="upper right", fontsize=8)
    return figure


def _window(measured: Measured) -> Figure:
    figure = new_figure(7.8, 3.2)
    left, right = figure.subplots(1, 2)
    lines = measured.numbers["lines"]
    left.plot(
        [float(g) for g in lines], [one["middle"] for one in lines.values()], "o-", color=BLUE, ms=5, lw=1.2
    )
    left.set(xlabel="conductance g", ylabel="wave in the middle of a clamped line", ylim=(0, None))
    for name, colour, label in (("slow", BLUE, "Aliev–Panfilov"), ("quick", GREEN, "quick recovery")):
        arrays, one = measured.found[f"window {name}"].arrays, measured.numbers["window"][name]
        right.plot(arrays["times"], arrays["potential"], color=colour, lw=1.4, label=label)
        for drive, earliest in zip(one["drives"], one["earliest"], strict=True):
            if earliest is not None:
                right.plot([earliest], [drive], "v", color=colour, ms=7)
    right.plot([], [], "v", color=GREY, label="excited again from here on,\nby this g (λ − 1)")
    right.set(xlabel="time after the upstroke", ylabel="potential v", xlim=(0, 60), ylim=(-0.05, 1.6))
    right.legend(loc="upper right")
    return figure


def _spirals(measured: Measured) -> Figure:
    rows = measured.numbers["spirals"]["strain"]
    shown = [g for g in ("0", "0.5", "1") if g in rows]
    figure = new_figure(2.6 * len(shown) + 0.8, 2.8)
    axes = np.atleast_1d(figure.subplots(1, len(shown)))
    drawn: Any = None
    for ax, g in zip(axes, shown, strict=True):
        arrays = measured.found[f"spiral strain {g}"].arrays
        drawn = ax.tripcolor(
            *arrays["X"].T, arrays["cells"], arrays["potential"], vmin=POTENTIAL[0], vmax=POTENTIAL[1],
            cmap=SEQUENTIAL, shading="gouraud", rasterized=True,
        )  # fmt: skip
        if len(path := arrays["path"]):
            late = path[path[:, 0] > 40]
            ax.plot(late[:, 1], late[:, 2], color=VERMILION, lw=1.2)
        ax.set(aspect="equal", title=f"g = {g}")
        ax.set_axis_off()
    figure.colorbar(drawn, ax=axes, label="v")
    return figure


PICTURES = {
    "stretch-feedback-squares": _squares,
    "stretch-feedback-window": _window,
    "stretch-feedback-spirals": _spirals,
}
