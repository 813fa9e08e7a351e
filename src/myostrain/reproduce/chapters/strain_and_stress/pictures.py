"""Force over length, pressure over volume, twist, and the length from step to step."""

from __future__ import annotations

from typing import Any

from myostrain.output.figures.style import BLUE, GREEN, GREY, ORANGE, VERMILION, new_figure
from myostrain.reproduce.chapters.strain_and_stress import jobs
from myostrain.reproduce.content import Measured

import numpy as np
from matplotlib.figure import Figure

LINES = {
    "strain": (BLUE, "-", "strain"),
    "stress": (VERMILION, "--", "stress, same contraction"),
    "force": (ORANGE, "-.", "stress, same force"),
}


def _force_length(measured: Measured) -> Figure:
    figure = new_figure(8.2, 5.6)
    above, below = figure.subplots(2, 3, sharex=True)
    for number, (name, *axes) in enumerate(zip(jobs.LAWS, above, below, strict=True)):
        arrays, one = measured.found[f"{name} strip"].arrays, measured.numbers["laws"][name]
        lam, passive = arrays["stretch"], arrays["passive"]
        strip = one["strip"]["fibre"]
        forces = {
            "strain": arrays["fibre force"],
            "stress": passive + strip["tension"] * lam,
            "force": passive + strip["isometric"] * lam,
        }
        unit = strip["isometric"]
        for approach, (colour, style, label) in LINES.items():
            axes[0].plot(lam, forces[approach] / unit, style, color=colour, label=label)
            added = forces[approach] - passive
            axes[1].plot(lam, added / np.interp(1.0, lam, added), style, color=colour)
        axes[0].plot(lam, passive / unit, ":", color=GREY, label="passive")
        axes[0].set_ylim(-1.0, 4.0)
        axes[0].set_title(jobs.NAMES[name])
        axes[1].set_ylim(0, 4)
        axes[1].set_xlabel("stretch λ")
        if number == 0:
            axes[0].set_ylabel("force / isometric force\nof the strain")
            axes[1].set_ylabel("force that activation adds,\nover that at λ = 1")
            axes[0].legend(fontsize=7.5, loc="upper left")
    return figure


def _chamber(measured: Measured) -> Figure:
    figure = new_figure(8.2, 5.6)
    above, below = figure.subplots(2, 3, sharex=True)
    for number, (name, *axes) in enumerate(zip(jobs.LAWS, above, below, strict=True)):
        arrays, one = measured.found[f"{name} tube"].arrays, measured.numbers["laws"][name]["tube"]
        V = arrays["volume"]
        axes[0].plot(V, arrays["passive pressure"] / one["strain"]["pressure"], ":", color=GREY,
                     label="passive")  # fmt: skip
        rest = float(np.interp(jobs.FILLED, V, arrays["passive twist"]))
        for approach, (colour, style, label) in LINES.items():
            axes[0].plot(V, arrays[f"fibre {approach} pressure"] / one["strain"]["pressure"], style,
                         color=colour, label=label)  # fmt: skip
            twist = (arrays[f"fibre {approach} twist"] - rest) * jobs.RADII[1]
            axes[1].plot(V, twist, style, color=colour)
        axes[0].set(title=jobs.NAMES[name], ylim=(-0.5, 2.0))
        axes[0].axvline(jobs.FILLED, color=GREY, lw=0.7)
        axes[1].axvline(jobs.FILLED, color=GREY, lw=0.7)
        axes[1].set_xlabel("volume / reference volume")
        if number == 0:
            axes[0].set_ylabel("pressure / that of the filled\nchamber with strain")
            axes[1].set_ylabel("twist per length × outer radius")
            axes[0].legend(fontsize=7.5, loc="upper left")
    return figure


def _velocity(measured: Measured) -> Figure:
    figure = new_figure(7.6, 3.2)
    left, right = figure.subplots(1, 2)
    arrays = measured.found["Guccione1995 strip"].arrays
    load = arrays["load"]
    top = float(arrays["fibre stress velocity"][0])
    left.plot(load, arrays["fibre velocity"] / top, "-", color=BLUE, label="strain, viscous")
    left.plot(load, arrays["fibre stress velocity"] / top, "--", color=VERMILION, label="stress, viscous")
    left.plot(load, (1 - load) / (1 + load / measured.numbers["hill_shape"]), ":", color=GREY,
              label="Hill, $a/P_0$ = ¼")  # fmt: skip
    left.set(xlabel="load / isometric force", ylabel="velocity / largest of stress")
    left.legend(fontsize=8)
    for name, colour in zip(jobs.LAWS, (BLUE, GREEN, ORANGE), strict=True):
        one = measured.found[f"{name} released"].arrays
        right.plot(one["load"], 1000 * one["velocity"], color=colour, label=jobs.NAMES[name])
    right.axhline(0, color=GREY, lw=0.7)
    right.set(xlabel="load / isometric force", ylabel="velocity, lengths per 1000 s", ylim=(-20, 6))
    right.legend(fontsize=8, loc="lower right")
    return figure


def _staggering(measured: Measured) -> Figure:
    figure = new_figure(8.2, 5.8)
    rows = figure.subplots(2, 3, sharex=True)
    schemes = {"staggered": (VERMILION, "o-"), "second-order": (ORANGE, "s-"), "implicit": (BLUE, "-")}
    for axes, approach in zip(rows, ("stress", "strain"), strict=True):
        for ax, name in zip(axes, jobs.LAWS, strict=True):
            arrays = measured.found[f"{name} {approach} swings"].arrays
            for scheme, (colour, mark) in schemes.items():
                away = arrays[scheme][-1] - arrays["equilibrium"][-1]
                shown = slice(0, 25)
                ax.plot(np.clip(away[shown], -0.6, 0.6), mark, ms=2.5, lw=1, color=colour, label=scheme)
            gain = measured.numbers["laws"][name]["swings"][approach]["gain"][-1]
            ax.set_title(f"{jobs.NAMES[name].split()[0]}: {approach}, k = {gain:.2f}", fontsize=8.5)
            ax.set_yscale("symlog", linthresh=1e-4)
            ax.set_ylim(-1, 1)
    for ax in rows[1]:
        ax.set_xlabel("step")
    for axes in rows:
        axes[0].set_ylabel("λ − λ* of the equilibrium")
    rows[1][0].legend(fontsize=8)
    return figure


PICTURES: dict[str, Any] = {
    "strain-stress-force-length": _force_length,
    "strain-stress-velocity": _velocity,
    "strain-stress-chamber": _chamber,
    "strain-stress-staggering": _staggering,
}
