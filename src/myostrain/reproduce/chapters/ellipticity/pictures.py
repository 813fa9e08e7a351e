"""Borders of ellipticity, maps of the least eigenvalue, and the slab."""

from __future__ import annotations

from typing import Any

from myostrain.output.figures.style import (
    BLUE,
    DIVERGING,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    VERMILION,
    new_figure,
)
from myostrain.reproduce.chapters.ellipticity import jobs
from myostrain.reproduce.content import Measured

import numpy as np
from matplotlib.figure import Figure

LINES: dict[str, tuple[str, str, str]] = {
    "fibre": (BLUE, "-", "strain, $F_o$ along the fibre"),
    "transversely isotropic": (GREEN, "-", "strain, transversely isotropic"),
    "orthotropic": (ORANGE, "-", "strain, orthotropic"),
    "tension": (VERMILION, "--", "stress, matched tension"),
}
NAMES = {
    "uniaxial": "stretch λ, equal sides",
    "plane": "stretch λ, sheet gives way",
    "shear": "shear along the fibre",
}
SHORT = {
    "NeoHookean": "neo-Hookean",
    "Guccione1995": "Guccione 1995",
    "Usyk2002": "Usyk 2002",
    "HolzapfelOgden2009": "Holzapfel–Ogden 2009",
}


def _borders(measured: Measured) -> Figure:
    figure = new_figure(8.4, 7.6)
    axes = figure.subplots(3, 3, sharex=True, sharey="col")
    for number, (row, name) in enumerate(zip(axes, jobs.EXPONENTIAL, strict=True)):
        arrays = measured.found[name].arrays
        gamma = arrays["gamma"]
        for ax, family in zip(row, jobs.FAMILIES, strict=True):
            for approach, (colour, style, label) in LINES.items():
                # A push, γ > 0, is no tension of a muscle.
                shown = gamma <= (1e-9 if approach == "tension" else np.inf)
                for side in ("below", "above"):
                    values = arrays[f"{approach} {family} {side}"]
                    ax.plot(gamma[shown], values[shown], style, color=colour, lw=1.6,
                            label=label if side == "below" else None)  # fmt: skip
            if family != "shear":
                ax.plot(gamma, arrays["free"], ":", color=GREY, label="free contraction")
                ax.set_ylim(0.4, 1.6)
            else:
                ax.set_ylim(0.0, 1.25)
            if ax is row[0]:
                ax.set_ylabel(SHORT[name])
            if number == 0:
                ax.set_title(NAMES[family])
    for ax in axes[-1]:
        ax.set_xlabel("active strain γ")
    axes[2, 0].legend(loc="upper left", fontsize=7.5)
    return figure


def _mapped(ax: Any, x: Any, y: Any, values: Any) -> Any:
    """Least eigenvalues from −1 to 1; those beyond have the colours of the ends."""
    return ax.pcolormesh(
        x,
        y,
        np.clip(values, -1, 1),
        cmap=DIVERGING.removesuffix("_r"),
        vmin=-1,
        vmax=1,
        shading="nearest",
        rasterized=True,
    )


def _map(measured: Measured) -> Figure:
    figure = new_figure(7.6, 3.6)
    axes = figure.subplots(1, 2, sharey=True)
    arrays = measured.found["Guccione1995"].arrays
    grid = np.array(jobs.grids(measured.quick)["plane"])
    drawn: Any = None
    for ax, approach, title in zip(
        axes, ("fibre", "tension"), ("active strain", "active stress"), strict=True
    ):
        keep = arrays["gamma"] <= 1e-9
        drawn = _mapped(ax, arrays["gamma"][keep], grid, arrays[f"{approach} plane least"][keep].T)
        ax.plot(arrays["gamma"][keep], arrays["free"][keep], ":", color="black", lw=1.2)
        ax.plot(arrays["gamma"][keep], arrays[f"{approach} plane below"][keep], color="black", lw=1.4)
        ax.set(title=title, xlabel="active strain γ" if approach == "fibre" else "γ that the tension matches")
    axes[0].set_ylabel("stretch λ, sheet gives way")
    figure.colorbar(drawn, ax=axes, label="least a·Q(m)a over the modulus", extend="both")
    return figure


def _following(measured: Measured) -> Figure:
    shown = ("NeoHookean", "Guccione1995", "HolzapfelOgden2009")
    figure = new_figure(7.8, 5.6)
    axes = figure.subplots(2, 3, sharex=True, sharey=True)
    drawn: Any = None
    for column, name in zip(axes.T, shown, strict=True):
        arrays = measured.found[f"{name} following"].arrays
        for ax, approach in zip(column, ("strain", "stress"), strict=True):
            drawn = _mapped(ax, arrays["stretch"], arrays["gamma"], arrays[approach])
            if (arrays[approach] <= 0).any():
                # Of the sign's size only: the values beyond the border grow by powers of ten.
                sign = np.clip(arrays[approach], -0.05, 0.05)
                ax.contour(arrays["stretch"], arrays["gamma"], sign, levels=[0.0], colors="black")
            ax.axvline(measured.numbers["curve_peak"], color=GREY, lw=0.8, ls=":")
        column[0].set_title(SHORT[name])
        column[1].set_xlabel("stretch λ")
    axes[0, 0].set_ylabel("active strain: γ at λ = 1")
    axes[1, 0].set_ylabel("active stress: γ matched")
    figure.colorbar(drawn, ax=axes, label="least a·Q(m)a over the modulus", extend="both")
    return figure


def _slab(measured: Measured) -> Figure:
    figure = new_figure(7.8, 5.4)
    axes, below = figure.subplots(2, 3)
    shades = (GREEN, BLUE, PURPLE)
    for ax, (approach, one) in zip(axes, measured.numbers["slab"].items(), strict=True):
        arrays = measured.found[f"slab {approach}"].arrays
        for spacing, values, colour in zip(one["spacings"], arrays["slab"], shades, strict=False):
            ax.plot(
                arrays["stretch"], values, "o-", ms=3, lw=1.2, color=colour, label=f"mesh 1/{1 / spacing:.0f}"
            )
        ax.plot(arrays["stretch"], arrays["acoustic"], "k-", lw=1.4, label="acoustic tensor")
        ax.axhline(0, color=GREY, lw=0.8)
        ax.set(title={"strain": "active strain", "tension": "active stress"}.get(approach, approach))
        ax.set_xlabel("stretch λ")
        ax.invert_xaxis()
    for ax, approach in zip(below, measured.numbers["slab"], strict=True):
        run = measured.found[f"run {approach}"]
        for values, colour in zip(run.arrays["away"], shades, strict=False):
            ax.plot(run.arrays["stretch"], values, "o-", ms=3, lw=1.2, color=colour)
            lost = np.isnan(values)
            if lost.any() and not lost.all():
                last = np.flatnonzero(~lost)[-1]
                ax.plot(run.arrays["stretch"][last], values[last], "x", color=colour, ms=9, mew=2)
        ax.axvline(measured.numbers["slab"][approach]["border"], color="black", lw=1)
        ax.invert_xaxis()
        ax.set_xlabel("stretch λ")
    below[0].set_ylabel("away from the affine state")
    axes[0].set_ylabel("least second variation")
    axes[0].legend(loc="lower left", fontsize=8)
    return figure


PICTURES = {
    "ellipticity-borders": _borders,
    "ellipticity-map": _map,
    "ellipticity-following": _following,
    "ellipticity-slab": _slab,
}
