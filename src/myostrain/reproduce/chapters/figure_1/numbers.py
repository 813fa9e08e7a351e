"""Rows of the table and their ratios to the rigid line, at Δx = 1 and converged."""

from __future__ import annotations

from collections.abc import Mapping
from math import log2
from typing import Any

from myostrain.reproduce.chapters.figure_1.jobs import (
    QUICK_STEP,
    READINGS,
    RIGID,
    SPACINGS,
    STEP,
    STRIPS,
    SWEEP,
)
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements.signals import extrapolated
from myostrain.reproduce.verdict import claims

NAMES = ("celerity", "width_material", "width_spatial", "front_spatial", "potential_max", "potential_min")
#: Ratios to the rigid line; the widths both over its one width.
RATIOS = {
    "celerity_ratio": "celerity",
    "width_ratio": "width_spatial",
    "width_material_ratio": "width_material",
    "position_ratio": "front_spatial",
    "maximum_ratio": "potential_max",
    "minimum_ratio": "potential_min",
}


def numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number of the chapter."""
    rows = {row: _row(found[row]) for row in (RIGID, *READINGS, *SWEEP)}
    made: dict[str, Any] = {
        "spacing": 1.0,
        "step": QUICK_STEP if quick else STEP,
        "time": 5.0,
        "rows": rows,
        "ratios": _ratios(rows),
    }
    return made if quick else made | _converged(found, rows)


def _converged(found: Mapping[str, Found], rows: Mapping[str, dict[str, float]]) -> dict[str, Any]:
    """Finer meshes and what they tend to, half the step, the paper's scheme, and strips."""
    meshes = {
        row: [rows[row], *(_row(found[f"{row}, Δx = {h}"]) for h in SPACINGS[1:])]
        for row in (RIGID, *READINGS)
    }
    limits = {
        row: {name: extrapolated(medium[name], fine[name]) for name in NAMES}
        for row, (_, medium, fine) in meshes.items()
    }
    halved, implicit = (
        {row: _row(found[f"{row}, {change}"]) for row in (RIGID, "conservative")}
        for change in ("Δt = 5e-4", "implicit")
    )
    strips = {row: _row(found[row]) for row in STRIPS}
    fine = _ratios({row: values[-1] for row, values in meshes.items()})
    ratios = _ratios(limits)
    return {
        "meshes": {
            row: dict(zip(("1", "1/2", "1/4"), values, strict=True)) for row, values in meshes.items()
        },
        "orders": {
            row: {name: _order(*(mesh[name] for mesh in values)) for name in NAMES[:4]}
            for row, values in meshes.items()
        },
        "converged": limits,
        "converged_ratios": ratios,
        "converged_error": max(
            abs(ratios[row][name] - fine[row][name])
            for row in READINGS
            for name in ("celerity_ratio", "width_ratio", "position_ratio")
        ),
        "step_halved": halved,
        "step_error": max(abs(halved[row][n] / rows[row][n] - 1) for row in halved for n in NAMES[:4]),
        "implicit": implicit,
        "implicit_ratios": _ratios(implicit),
        "strips": strips,
        "strip_ratios": _ratios(strips, rows[RIGID]),
    }


def _row(found: Found) -> dict[str, float]:
    return {name: found.numbers[name] for name in NAMES}


def _ratios(rows: Mapping[str, Any], rigid: Mapping[str, float] | None = None) -> dict[str, dict[str, float]]:
    """Rows over the rigid line, which is among them unless given."""
    base = rows[RIGID] if rigid is None else rigid
    return {row: {key: own[name] / base[name] for key, name in RATIOS.items()} for row, own in rows.items()}


def _order(coarse: float, medium: float, fine: float) -> float:
    return log2(abs((coarse - medium) / (medium - fine)))


def judged(n: Mapping[str, Any]) -> Mapping[str, Any]:
    """The ratios that are judged: converged where there are several meshes."""
    ratios: Mapping[str, Any] = n.get("converged_ratios", n["ratios"])
    return ratios


def readings(n: Mapping[str, Any]) -> dict[str, Any]:
    """What is judged, by claim and reading: the same for all claims."""
    ratios = {text: judged(n)[row] for row, (text, _) in READINGS.items()}
    return dict.fromkeys(claims("figure-1"), ratios)
