"""Tables of borders, and the maps as columns."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.chapters.ellipticity import jobs
from myostrain.reproduce.content import Measured, Rows
from myostrain.reproduce.words import fixed

import numpy as np

#: Families of deformations, and which side is asked for.
SHOWN = {"uniaxial": ("below", "above"), "plane": ("below", "above"), "shear": ("above",)}


def words(measured: Measured) -> dict[str, Any]:
    """What the words name beside the numbers."""
    grids = jobs.grids(measured.quick)
    return {
        "laws": measured.numbers["laws"],
        "grid": f"{len(jobs.gammas(measured.quick))} × {len(grids['plane'])}",
        "zip": zip,
        "same_place": all(
            one["strain_gamma"] == one["ordinary_gamma"] for one in measured.numbers["following"].values()
        ),
        "samples": 150 if measured.quick else 1000,
    }


def tables(measured: Measured) -> dict[str, Rows]:
    """The rows of the tables."""
    laws, following = measured.numbers["laws"], measured.numbers["following"]
    borders = []
    for name in jobs.EXPONENTIAL:
        rows = laws[name]["borders"]
        first = [name, "passive"]
        first += [_border(rows[f"fibre {f}"][f"passive_{s}"]) for f, sides in SHOWN.items() for s in sides]
        borders.append(first)
        for approach in jobs.APPROACHES:
            shown = [
                _border(rows[f"{approach} {f}"][f"active_{s}"]) for f, sides in SHOWN.items() for s in sides
            ]
            borders.append(["", approach, *shown])
    made: dict[str, Rows] = {
        "borders": borders,
        "isometric": [
            [name, *(_border(one["isometric"][kind]) for kind in jobs.DEFORMATIONS)]
            for name, one in laws.items()
        ],
        "following": [
            [
                name,
                *(
                    _border(one[f"{approach}_{what}"])
                    for approach in ("strain", "stress")
                    for what in ("gamma", "stretch")
                ),
            ]
            for name, one in following.items()
        ],
        "slab": [
            [approach, one["border"], f"1/{1 / spacing:.0f}", border, waves]
            for approach, one in measured.numbers["slab"].items()
            for spacing, border, waves in zip(one["spacings"], one["borders"], one["waves"], strict=True)
        ],
    }
    if not measured.quick:
        made["compressible"] = [[name, one["compressible_borders_differ_by"]] for name, one in laws.items()]
    return made


def _border(value: float | None) -> str:
    return "none" if value is None or np.isnan(value) else fixed(value, 3).replace("-", "−")


def data(measured: Measured) -> dict[str, dict[str, Any]]:
    """The maps: a row for each approach, family, γ and stretch; and those of activations that follow."""
    made: dict[str, dict[str, Any]] = {}
    grids = jobs.grids(measured.quick)
    for name in jobs.LAWS:
        arrays = measured.found[name].arrays
        gamma, tension = arrays["gamma"], arrays["tension"]
        columns: dict[str, list[Any]] = {
            key: []
            for key in ("approach", "family", "gamma", "tension_over_modulus", "stretch_or_shear", "least")
        }
        for approach in jobs.APPROACHES:
            for family, grid in grids.items():
                least = arrays[f"{approach} {family} least"]
                columns["approach"] += [approach] * least.size
                columns["family"] += [family] * least.size
                columns["gamma"] += np.repeat(gamma, len(grid)).tolist()
                columns["tension_over_modulus"] += np.repeat(tension, len(grid)).tolist()
                columns["stretch_or_shear"] += np.tile(grid, len(gamma)).tolist()
                columns["least"] += least.ravel().tolist()
        made[f"ellipticity-{name}"] = columns
        one = measured.found[f"{name} following"].arrays
        shape = one["strain"].shape
        made[f"ellipticity-following-{name}"] = {
            "gamma_at_1": np.repeat(one["gamma"], shape[1]),
            "tension_over_modulus": np.repeat(one["tension"], shape[1]),
            "stretch": np.tile(one["stretch"], shape[0]),
            **{f"least_{key}": one[key].ravel() for key in ("strain", "stress", "frozen")},
            "determinant_over_frozen": one["ordinary"].ravel(),
        }
    return made
