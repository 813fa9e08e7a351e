"""The table of the waves at the sheet's centre."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.content import Measured, Rows

MESHES = {
    True: "`sheet-2d` with spacing 3, Δt = 6e-3, mechanics every 4 steps",
    False: "`sheet-2d` as it ships: 12,097 nodes, Δt = 3e-3, mechanics every 4 steps",
}
COLUMNS = ("celerity", "potential_duration", "shortening_duration", "length_ratio", "rise_delay",
           "peak_delay", "shortening_peak")  # fmt: skip


def words(measured: Measured) -> dict[str, Any]:
    """What the words name beside the numbers."""
    n = measured.numbers
    return {
        "mesh": MESHES[measured.quick],
        "motions": n["random motions"],
        "block": n["free block"],
        "least_power": n["line's dashpot, least power"],
        "large_strain": n["free block, γ to −0.3"]["plane-stress"],
    }


def tables(measured: Measured) -> dict[str, Rows]:
    """The rows of the tables."""
    return {
        "waves": [
            [
                "5, no stretch below rest" if name == "rectified" else f"{float(name):g}",
                *map(row.get, COLUMNS),
            ]
            for name, row in measured.numbers["sheets"].items()
        ]
    }
