"""Tables of the cubic spring and of (1.12)."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.chapters.springs import jobs
from myostrain.reproduce.chapters.springs.jobs import ENERGY_ALONE, PULLED_BACK, RESIDUAL_FREE
from myostrain.reproduce.content import Measured, Rows
from myostrain.reproduce.words import percent

STRESSES = {
    RESIDUAL_FREE: "$\\partial W/\\partial F - J p_0 F^{-T}$",
    PULLED_BACK: "the same, and pulled back (1.6)",
    ENERGY_ALONE: "$\\partial W/\\partial F$ alone",
}


def words(measured: Measured) -> dict[str, Any]:
    """What the words name beside the numbers."""
    return {"directions": jobs.directions(measured.quick)}


def tables(measured: Measured) -> dict[str, Rows]:
    """The rows of the tables."""
    cubic, rows = measured.numbers["cubic"], measured.numbers["small_strains"]
    columns = ("smallest", "largest", "best_constant", "error", "constant_difference")
    orders = ("smallest_order", "largest_order")
    return {
        "cubic": [
            [percent(spread, 0), *values]
            for spread, *values in zip(cubic["spreads"], *(cubic[name] for name in columns), strict=True)
        ],
        "orders": [
            [
                material + (", $\\det F = 1$" if isochoric else ""),
                STRESSES[form],
                rows[name]["pressure"],
                *(f"{rows[name][o]:.0e}" if form == ENERGY_ALONE else rows[name][o] for o in orders),
                rows[name]["relative_median"],
            ]
            for name, (material, form, isochoric) in jobs.ROWS.items()
        ],
    }
