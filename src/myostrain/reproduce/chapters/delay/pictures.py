"""Courses of potential and shortening, delay and length of every law, and what the laws' times do."""

from __future__ import annotations

from typing import Any

from myostrain.output.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION, new_figure
from myostrain.reproduce.chapters.delay import jobs
from myostrain.reproduce.chapters.delay import numbers as of
from myostrain.reproduce.chapters.delay.text import label
from myostrain.reproduce.content import Measured

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

COLOURS = {"viscosity": BLUE, "relaxing": VERMILION, "rossi": GREEN}
#: Runs whose courses are drawn, with their colours and lines.
SHOWN = {
    "BOCF": (("at once", "black", "-"), ("viscous 20", BLUE, "-"), ("viscous 100", PURPLE, "-"),
             ("relaxing", VERMILION, "-"), ("rossi", GREEN, "-")),
    "FHN": (("at once", "black", "-"), ("viscous 0.02", BLUE, "-"), ("viscous 0.2", PURPLE, "-"),
            ("relaxing", VERMILION, "-")),
}  # fmt: skip
ENDS = {"BOCF": (-20.0, 600.0), "FHN": (-0.05, 1.1)}
#: Of the picture of all laws.
LONGEST = 2.9


def _courses(measured: Measured) -> Figure:
    figure = new_figure(7.8, 5.4)
    axes = figure.subplots(2, 2, sharex="col")
    for column, (membrane, shown) in zip(axes.T, SHOWN.items(), strict=True):
        for law, colour, style in shown:
            one = measured.found[f"{membrane} {law}"]
            times = one.arrays["times"] - one.numbers["upstroke"]
            text = label(f"{membrane} {law}")
            column[1].plot(times, one.arrays["shortening"], style, color=colour, lw=1.5, label=text)
            if law == "at once":
                column[0].plot(times, one.arrays["excitation"], color="black", lw=1.5)
        column[0].axhline(0, color=GREY, lw=0.6, zorder=0)
        column[1].axhline(0, color=GREY, lw=0.6, zorder=0)
        column[0].set_title(jobs.MEMBRANES[membrane][1])
        column[1].set_xlim(*ENDS[membrane])
        column[1].legend(loc="upper right", fontsize=7.5)
    axes[1, 0].set_xlabel("time after the upstroke [ms]")
    axes[1, 1].set_xlabel("time after the upstroke")
    axes[0, 0].set_ylabel("excitation")
    axes[1, 0].set_ylabel("shortening 1 − λ")
    return figure


def _laws(measured: Measured) -> Figure:
    figure = new_figure(7.8, 4.0)
    low, high = (value / of.REPOLARIZATION for value in of.DELAY)
    for ax, membrane in zip(figure.subplots(1, 2, sharey=True), ("BOCF", "FHN"), strict=True):
        arrays = measured.found[f"{membrane} map"].arrays
        box = Rectangle((low, of.OUTLASTING), high - low, LONGEST, color=ORANGE, alpha=0.25, lw=0, zorder=0)
        ax.add_patch(box)
        for family, colour in COLOURS.items():
            if f"{family} peak" in arrays:
                share, length = (arrays[f"{family} {key}"].ravel() for key in ("delay_share", "tenth_length"))
                name = "Rossi 2014, μ and α" if family == "rossi" else family
                ax.plot(share, length, ".", ms=3, color=colour, alpha=0.7, label=name)
        for name, row in measured.numbers["rows"].items():
            law = name.partition(" ")[2].split(",")[0]
            if name.startswith(membrane) or (membrane == "BOCF" and name.startswith("TTP06")):
                sheet, real = name.endswith("sheet"), name.startswith("TTP06")
                colour = next((c for f, c in COLOURS.items() if law.startswith(f[:5])), "black")
                shape = "s" if sheet else "^" if real else "o"
                ax.plot(
                    row["delay_share"], row["tenth_length"], shape, ms=7, mec="black", mfc=colour, zorder=3
                )
        ax.axhline(1, color=GREY, lw=0.6, zorder=0)
        ax.set(title=jobs.MEMBRANES[membrane][1], xlim=(-0.02, 1.45), ylim=(0.8, LONGEST))
        ax.set_xlabel("delay of the peak over repolarisation")
        ax.legend(loc="center right", fontsize=8)
    figure.axes[0].set_ylabel("end of contraction over repolarisation")
    return figure


def _times(measured: Measured) -> Figure:
    figure = new_figure(7.8, 3.9)
    left, right = figure.subplots(1, 2)
    settings, arrays = jobs.map_settings("BOCF", measured.quick), measured.found["BOCF map"].arrays
    elastic = measured.numbers["rows"]["BOCF at once"]["peak"]
    curves: Any = (
        ("viscosity", settings["relaxation"], lambda a: a, BLUE, "viscosity, λ"),
        ("relaxing", settings["rise"], lambda a: a[0, :, 0], VERMILION, "relaxing, rise time"),
    )
    for family, times, pick, colour, text in curves:
        left.semilogx(times, pick(arrays[f"{family} peak_delay"]), color=colour, label=text)
        shares = pick(arrays[f"{family} peak"]) / elastic
        left.semilogx(times, 300 * shares, "--", color=colour, lw=1.2)
    left.axhspan(*of.DELAY, color=ORANGE, alpha=0.25, lw=0)
    left.set(xlabel="time constant [ms]", ylabel="delay of the peak [ms]", ylim=(0, 310))
    second = left.secondary_yaxis("right", functions=(lambda y: y / 300, lambda y: y * 300))
    second.set_ylabel("shortening over that at once (dashed)")
    left.legend(loc="upper left", fontsize=8)
    for threshold, index, style in zip(settings["thresholds"], (0, 1), ("-", "--"), strict=True):
        rises = np.array(settings["rise"])
        for rise, colour in ((5.0, GREEN), (20.0, VERMILION), (60.0, PURPLE)):
            row = int(np.argmin(np.abs(np.log(rises / rise))))
            text = f"rise {rises[row]:.0f} ms, threshold {threshold:g}"
            length = arrays["relaxing tenth_length"][index, row]
            right.plot(settings["fall"], length, style, color=colour, lw=1.4, label=text)
    right.axhline(of.OUTLASTING, color=ORANGE, lw=1)
    right.set(xlabel="fall time [ms]", ylabel="end of contraction over repolarisation", ylim=(0.9, 2.6))
    right.legend(loc="upper left", fontsize=7.5)
    return figure


PICTURES = {"delay-courses": _courses, "delay-laws": _laws, "delay-times": _times}
