"""The table over the relaxation time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.reproduce.chapters.viscosity.jobs import watched
from myostrain.reproduce.content import Measured, Rows

GRIDS = {
    True: "Δx = 1, Δt = 4 × 10⁻³, a line of length 180 at t = 2.6 (quick settings, good to 1 %)",
    False: "Δx = 1/2, Δt = 10⁻³, a line of length 400 at t = 5",
}


def words(measured: Measured) -> dict[str, Any]:
    """What the words name beside the numbers."""
    n = measured.numbers
    return {
        "grid": GRIDS[measured.quick],
        "watch": watched(measured.quick),
        **n["limits"],
        "first": n["sweep"][0],
        "last": n["sweep"][-1],
        "least": n["least_width"]["width_spatial"],
    }


def tables(measured: Measured) -> dict[str, Rows]:
    """The rows of the tables."""
    limits = measured.numbers["limits"]
    rigid = limits["rigid"]

    def cells(title: str, row: Mapping[str, Any]) -> list[Any]:
        wave = row["shortening_half_width"]
        return [title, row["celerity"], row["width_material"], row["width_spatial"],
                row["width_spatial"] / rigid["width_spatial"], row["shortening_max"], row["peak_delay"],
                row["rise_delay"], None if wave is None else wave / row["half_width"]]  # fmt: skip

    still = {"shortening_half_width": None, "peak_delay": None, "rise_delay": None}
    return {
        "sweep": [
            cells("elastic", limits["elastic"]),
            *(cells(f"{row['part']:g}", row) for row in measured.numbers["sweep"]),
            cells("rigid", rigid | still),
        ]
    }
