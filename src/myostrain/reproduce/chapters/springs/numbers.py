"""The active force that springs need, and the order to which (1.12) holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.reproduce.chapters.springs.jobs import POWERS, PULLED_BACK, RESIDUAL_FREE, ROWS
from myostrain.reproduce.jobs import Found


def numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number of the chapter."""
    rows = {name: found[name].numbers for name in ROWS}
    printed, pulled = (
        [rows[name] for name, (_, form, _) in ROWS.items() if form == wanted]
        for wanted in (RESIDUAL_FREE, PULLED_BACK)
    )
    return {
        **{name: found[name].numbers for name in POWERS},
        "small_strains": rows,
        "orders": _orders(printed),
        "orders_pulled_back": _orders(pulled),
        "least_relative_difference": min(row["relative_smallest"] for row in (*printed, *pulled)),
    }


def _orders(rows: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    return {
        "smallest_order": min(row["smallest_order"] for row in rows),
        "largest_order": max(row["largest_order"] for row in rows),
    }


def readings(n: Mapping[str, Any]) -> dict[str, Any]:
    """What is judged, by claim and reading."""
    cubic, printed = n["cubic"], "as printed"
    return {
        "linear": {printed: {"difference": n["linear"]["constant_difference"][0]}},
        "cubic": {printed: {"error": cubic["error"][0], "error_where_it_is_least": min(cubic["error"])}},
        "explicit": {printed: {"difference": cubic["explicit_difference"][0]}},
        "small-strains": {"as printed, without residual stress": n["orders"]},
        "only-small": {printed: {"least_relative_difference": n["least_relative_difference"]}},
    }
