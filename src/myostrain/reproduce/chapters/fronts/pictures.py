"""Rates of homogeneous states, speeds over β, a front in X and x, and the limit αβ = 1/2."""

from __future__ import annotations

from typing import Any

from myostrain.output.figures.style import BLUE, COLOURS, GREEN, GREY, VERMILION, new_figure
from myostrain.reproduce.chapters.fronts import jobs as setup
from myostrain.reproduce.content import Measured
from myostrain.theory import profile, speed

import numpy as np
from matplotlib.figure import Figure


def _rates(measured: Measured) -> Figure:
    figure = new_figure(6.0, 3.8)
    axes = figure.subplots()
    axes.axhline(0, color=GREY, linewidth=0.7)
    v = np.linspace(-0.1, 1.1, 200)
    cell = -setup.RATE * v * (v - setup.ALPHA) * (v - 1)
    factor = (1 - setup.BETA * v) / (1 - 2 * setup.BETA * v)
    axes.plot(v, factor * cell, color=BLUE, label="conservative, exact")
    axes.plot(v, cell, color=VERMILION, label="rigid, exact")
    looks: dict[str, tuple[str, dict[str, Any]]] = {
        "conservative": ("conservative, simulated", {"color": BLUE}),
        "rigid": ("rigid, simulated", {"color": VERMILION}),
        "advective": ("advective, simulated", {"color": GREEN, "marker": "x", "markersize": 7, "zorder": 3}),
    }
    for model, (label, look) in looks.items():
        arrays = measured.found[f"temporal_variation_{model}"].arrays
        marker: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 4} | look
        axes.plot(arrays["potential"], arrays["rate"], label=label, **marker)
    for place in setup.EQUILIBRIA["without_recovery"]:
        axes.plot(place, 0, "o", color="#222222", markersize=6, markerfacecolor="white", zorder=3)
    axes.set_xlabel("potential $v$")
    axes.set_ylabel(r"$\partial v/\partial t$")
    axes.legend(loc="lower left")
    return figure


def _speeds(measured: Measured) -> Figure:
    figure = new_figure(6.0, 4.8)
    axes = figure.subplots()
    s = setup.settings(measured.quick)
    betas = np.linspace(0, 0.499, 200)
    axes.axhline(0, color=GREY, linewidth=0.7)
    alphas = s.alphas if measured.quick else tuple(a for a in s.alphas if a != 0.2)
    for alpha, colour in zip(alphas, COLOURS, strict=False):
        advance = np.asarray(speed(alpha, betas, diffusivity=setup.RATE, A=setup.RATE))
        axes.plot(betas, advance, color=colour)
        pairs = [(a, b) for a, b in s.fronts if a == alpha]
        speeds = [-measured.found[setup.name(*pair)].numbers["c"] for pair in pairs]
        axes.plot([b for _, b in pairs], speeds, "o", markersize=5, color=colour)
        axes.annotate(
            f"α = {alpha}", (0.503, advance[-1]), color=colour, va="center", annotation_clip=False, fontsize=9
        )
    axes.axvline(0.5, color=GREY, linestyle=":")
    axes.set_xlim(-0.008, 0.5)
    axes.set_xlabel("contraction β at $v$ = 1")
    axes.set_ylabel("speed of the excited state's advance")
    return figure


def _profile(measured: Measured) -> Figure:
    figure = new_figure(6.0, 5.6)
    above, below = figure.subplots(2, 1)
    arrays = measured.found[setup.name(setup.ALPHA, setup.BETA)].arrays
    half = float(np.interp(0.5, arrays["v_exact"], arrays["X"]))
    tangent = np.asarray(profile(arrays["X"] - half, setup.ALPHA, diffusivity=setup.RATE, A=setup.RATE))
    dots = slice(None, None, 2 if len(arrays["X"]) < 300 else 4)
    for axes, place, label in ((above, "X", "material $X$"), (below, "x", "space $x$")):
        exact = arrays["X"] if place == "X" else arrays["x_exact"]
        middle = float(np.interp(0.5, arrays["v_exact"], exact))
        rigid_place = arrays["X"] - half
        axes.plot(rigid_place, tangent, color=VERMILION, linestyle="--", label="rigid line (tanh)")
        axes.plot(exact - middle, arrays["v_exact"], color=BLUE, label="exact, (4.9) and (4.12)")
        axes.plot(
            arrays[place][dots] - middle, arrays["v"][dots], "o", color=BLUE, markersize=4, label="simulated"
        )
        axes.set_xlim(-8, 8)
        axes.set_xlabel(f"{label} from where $v$ = 1/2")
        axes.set_ylabel("potential $v$")
    above.legend(loc="upper left")
    return figure


def _limit(measured: Measured) -> Figure:
    points = measured.numbers["limit"]
    figure = new_figure(6.0, 3.8)
    axes = figure.subplots()
    line = np.array([0.0, 0.5])
    axes.plot(line, 1 - 2 * line, color=GREY, label="1 − 2αβ of (4.10), (4.11)")
    axes.plot(
        points["product"], points["from_steepness"], "o", color=BLUE, label=r"$2D(1-\beta)\,a^2/A$, measured"
    )
    axes.plot(
        points["product"],
        points["from_speed"],
        "x",
        color=VERMILION,
        markersize=8,
        label=r"$DA(1-2\alpha)^2/(2(1-\beta)\,c^2)$, measured",
    )
    axes.axvspan(0.5, 0.56, color=GREY, alpha=0.25, lw=0)
    axes.text(0.53, 0.5, "no front", rotation=90, ha="center", va="center", color="#444444")
    axes.set_xlim(-0.01, 0.56)
    axes.set_ylim(0, 1.04)
    axes.set_xlabel("αβ")
    axes.legend(loc="lower left")
    return figure


PICTURES = {
    "fronts-homogeneous": _rates,
    "fronts-speed": _speeds,
    "fronts-profile": _profile,
    "fronts-limit": _limit,
}
