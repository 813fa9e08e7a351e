"""The tables of sheets, of lines and strips, and of convergence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.reproduce.content import Measured, Rows
from myostrain.reproduce.words import number

#: Runs of the first table and what they are called.
ROWS = {
    "rigid": "rigid",
    "stress": "plane stress",
    "strain": "plane strain",
    "rigid ratio 4": "rigid, ratio 4",
    "stress ratio 4": "plane stress, ratio 4",
    "strain ratio 4": "plane strain, ratio 4",
    "stress elastic": "plane stress, det Fe = 1",
    "strain elastic": "plane strain, det Fe = 1",
}
#: Runs in one dimension.
LINES = {
    "line rigid": "line, rigid",
    "line": "line, coupled (4.6)",
    "strip rigid": "strip, rigid",
    "strip stress": "free strip, plane stress",
    "strip strain": "free strip, plane strain",
}


def words(measured: Measured) -> dict[str, Any]:
    """What the words name beside the numbers: above all meshes and steps."""
    n, runs = measured.numbers, measured.numbers["runs"]

    def mesh(name: str) -> str:
        return f"{runs[name]['nodes']:,} nodes, {runs[name]['cells']:,} triangles"

    def grid(name: str) -> str:
        return f"{mesh(name)}, time step {runs[name]['step']:g}"

    volume = n["constraint"]["stress"]["volume_J"], n["constraint"]["strain"]["volume_J"]
    coarse = "mechanics every 4th step, in plane strain with J = 1 every 10th"
    fine = "mechanics every 4th (plane stress) and 10th step (plane strain)"
    return {
        "sheet_mesh": mesh("stress"),
        "settings": f"{grid('stress')}; {coarse}",
        "fine_settings": f"{grid('stress ratio 4')}; {fine}",
        "finer_grid": grid("stress finer") if "stress finer" in runs else None,
        "near": {kind: runs[kind]["relevance"]["tenth"] for kind in ("stress", "strain")},
        "volume_kept": ["less than 10⁻¹⁵" if abs(one) < 1e-15 else number(one) for one in volume],
    }


def tables(measured: Measured) -> dict[str, Rows]:
    """The rows of the tables."""
    n, runs = measured.numbers, measured.numbers["runs"]
    strips = n["celerity"]["one_dimension"]
    pulse = ("maximum", "minimum", "duration")
    made: dict[str, Rows] = {
        "sheets": [_sheet(label, runs[name]) for name, label in ROWS.items()],
        "lines": [
            [label, strips[name], *(runs[name]["pulses"]["a"][key] for key in pulse)]
            for name, label in LINES.items()
        ],
    }
    if "convergence" in n:
        parts = n["convergence"]
        made["convergence"] = [
            [key.replace("_", " "), *(100 * part[key] if key in part else None for part in parts.values())]
            for key in parts["stress"]
        ]
    return made


def _sheet(label: str, run: Mapping[str, Any]) -> list[Any]:
    fits, large, centre = run["celerity"], run["largest"], run["pulses"]["centre"]
    sizes = [
        large[key] if large["displacement"] > 0 else None
        for key in ("displacement", "stress_low", "stress_high")
    ]
    changes = [round(100 * run["volume"][key], 3) + 0.0 for key in ("change", "area_change")]
    return [
        label,
        fits["along"],
        fits["across"],
        *(centre[key] for key in ("maximum", "minimum", "duration")),
        *sizes,
        *changes,
    ]
