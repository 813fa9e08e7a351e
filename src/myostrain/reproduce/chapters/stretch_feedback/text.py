"""Tables of squares, lines and spirals, and the same as columns."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.content import Measured, Rows
from myostrain.reproduce.words import fixed

import numpy as np


def words(measured: Measured) -> dict[str, Any]:
    """What the words name beside the numbers."""
    n = measured.numbers
    return {
        "plane": n["quick"]["strain in plane"],
        "zip": zip,
        "ways": _ways,
        "widest": min(one["widest"] for way in n["slow"].values() for one in way.values()),
    }


def _ways(one: dict[str, Any]) -> str:
    """What a square does, in words."""
    if one["pacemaker"]:
        return f"{fixed(one['beats'], 1)} upstrokes, period {fixed(one['period'], 1)}, going on"
    if one["silent"] is None:
        return f"{fixed(one['beats'], 1)} upstrokes, going on"
    return f"{fixed(one['beats'], 1)} upstrokes, at rest from {fixed(one['silent'], 0)}"


def tables(measured: Measured) -> dict[str, Rows]:
    """The rows of the tables."""
    n = measured.numbers
    made: dict[str, Rows] = {
        "lines": [[g, one["middle"], one["beats"]] for g, one in n["lines"].items()],
        "premature": [
            [g, *(one[key] for key in ("upstroke", "duration", "back", "forth", "width"))]
            for g, one in n["premature"].items()
        ],
        "squares": [
            [membrane, approach, g, _ways(one), one["first_drive"]]
            for name, membrane in (("quick", "quick recovery"), ("slow", "Aliev–Panfilov"))
            for approach, row in n[name].items()
            for g, one in row.items()
        ],
        "spirals": [
            [approach, g, one["period"], one["radius"], one["drift"], one["tips_max"], _end(one)]
            for approach, row in n["spirals"].items()
            for g, one in row.items()
        ],
    }
    if not measured.quick:
        made["thresholds"] = [
            [approach, one["below"] if one["least"] is None else one["least"], _found(one)]
            for approach, one in n["thresholds"].items()
        ]
        made["halved"] = [
            [name, _ways(n["quick"][name.rpartition(" ")[0]][name.rpartition(" ")[2]]), _ways(one)]
            for name, one in n["halved"].items()
        ]
        made["large"] = [
            [approach, g, _ways(one), one["most"], one["period"]]
            for approach, row in n["large"].items()
            for g, one in row.items()
        ]
    return made


def _end(one: dict[str, Any]) -> str:
    return f"at rest from {fixed(one['end'], 0)}" if one["silent"] else f"tips: {one['tips']}"


def _found(one: dict[str, Any]) -> str:
    return "none up to here" if one["least"] is None else "pacemaker from here on"


def data(measured: Measured) -> dict[str, dict[str, Any]]:
    """The excited share over time of all squares, and what the table of squares says."""
    squares = {name: one for name, one in measured.found.items() if "excited" in one.arrays}
    columns: dict[str, list[Any]] = {"square": [], "time": [], "excited_share": []}
    for name, one in squares.items():
        every = max(1, len(one.arrays["times"]) // 400)
        times, share = one.arrays["times"][::every], one.arrays["excited"][::every]
        columns["square"] += [name] * len(times)
        columns["time"] += times.tolist()
        columns["excited_share"] += share.tolist()
    keys = ("beats", "most", "silent", "period", "first_drive", "stretched")
    rows: dict[str, list[Any]] = {"square": list(squares)}
    rows |= {key: [one.numbers[key] for one in squares.values()] for key in keys}
    lines = measured.numbers["lines"]
    return {
        "stretch-feedback-excited": columns,
        "stretch-feedback-squares": rows,
        "stretch-feedback-lines": {
            "conductance": np.array([float(g) for g in lines]),
            "arrival": [one["middle"] for one in lines.values()],
        },
        "stretch-feedback-premature": {
            "conductance": [float(g) for g in measured.numbers["premature"]],
            **{
                key: [one[key] for one in measured.numbers["premature"].values()]
                for key in ("upstroke", "duration", "back", "forth", "width")
            },
        },
    }
