"""Celerities, widths, steepnesses over the rigid line's, what a delay leaves of them, the held line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.reproduce.chapters.human_pulse.jobs import FAR, FINE, HUMAN, KINDS, diffusivity, rises
from myostrain.reproduce.jobs import Found

import numpy as np

NAMES = ("celerity", "width_material", "width_spatial", "steepness_material", "steepness_spatial", "duration",
         "repolarization", "peak")  # fmt: skip
#: X between which the times of the held line are compared with the rigid one's, mm.
EARLY, LATE = 4.0, 21.0


def numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number of the chapter."""
    rows = {m: {kind: _row(found[f"{m} {kind}"]) for kind in KINDS} for m in HUMAN}
    ratios = {m: _ratios(own, own["rigid"]) for m, own in rows.items()}
    balances = [b for b in ("conservative", "advective") if f"{b} rise {rises(quick)[0]}" in found]
    rigid = rows["BOCF"]["rigid"]["celerity"]
    foot = diffusivity() / rigid**2
    sweep = {
        balance: [
            {
                "rise": rise,
                "predicted": 1 / (1 + rise / foot),
                "left": (found[f"{balance} rise {rise}"].numbers["celerity"] / rigid - 1)
                / (ratios["BOCF"][balance]["celerity"] - 1),
            }
            for rise in rises(quick)
        ]
        for balance in balances
    }
    made: dict[str, Any] = {
        "rows": rows,
        "ratios": ratios,
        "left": {
            m: {
                balance: (own[late]["celerity"] - 1) / (own[balance]["celerity"] - 1)
                for balance, late in (("conservative", "relaxing"), ("advective", "relaxing advective"))
            }
            for m, own in ratios.items()
        },
        "foot": foot,
        "sweep": sweep,
        "half_rise": {balance: _half(own) for balance, own in sweep.items()},
        "held": {name: _held(found[name], rigid) for name in ("held", "held at once")},
    }
    if not quick:
        fine = {
            m: {kind: found[f"{m} {kind}, fine"].numbers for kind in KINDS if f"{m} {kind}, fine" in found}
            for m in HUMAN
        }
        made["fine"] = {
            m: {
                kind: {name: one[name] / own["rigid"][name] for name in ("celerity", "steepness_spatial")}
                for kind, one in own.items()
            }
            for m, own in fine.items()
        }
        made["fine_spacing"] = FINE
        made["mesh_error"] = max(
            abs(made["fine"][m][kind]["celerity"] - ratios[m][kind]["celerity"])
            for m in HUMAN
            for kind in fine[m]
        )
    return made


def _row(found: Found) -> dict[str, Any]:
    return {name: found.numbers[name] for name in NAMES}


def _ratios(rows: Mapping[str, Any], rigid: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """Rows over the rigid line."""
    return {kind: {name: own[name] / rigid[name] for name in NAMES[:-1]} for kind, own in rows.items()}


def _half(sweep: list[dict[str, float]]) -> float:
    """The rise time at which half of the effect is left, between logarithms; the first one if it is less."""
    left, times = (np.array([row[key] for row in sweep]) for key in ("left", "rise"))
    return float(np.exp(np.interp(-0.5, -left, np.log(times))))


def _held(one: Found, rigid: float) -> dict[str, float]:
    """The front near the far end of the held line: its speed over the rigid one's, the stretch it meets."""
    X, arrival, stretch = (one.arrays[name] for name in ("X", "arrival", "front_stretch"))
    met = float(np.interp((FAR[0] + FAR[1]) / 2, X, stretch))
    ratio = one.numbers["celerity"] / rigid
    travelled = float(np.interp(LATE, X, arrival) - np.interp(EARLY, X, arrival))
    return {
        "celerity_ratio": ratio,
        "stretch": met,
        "spatial_ratio": ratio * met,
        "late_ms": travelled - (LATE - EARLY) / rigid,
    }


def readings(n: Mapping[str, Any]) -> dict[str, Any]:
    """What is judged, by claim and reading."""
    measured = "as measured"
    ratios, left, held = n["ratios"], n["left"], n["held"]["held"]

    def each(name: str, *kinds: str) -> list[float]:
        return [ratios[m][kind][name] for m in HUMAN for kind in kinds]

    late = ("relaxing", "relaxing advective", "rossi")
    at_once = ("conservative", "advective")
    conservative = n["sweep"]["conservative"]
    return {
        "celerity": {
            "conservative, as printed": _range(each("celerity", "conservative")),
            "advective balance, J ∂v/∂t": _range(each("celerity", "advective")),
        },
        "width": {
            "conservative, as printed": _range(each("width_spatial", "conservative")),
            "advective balance, J ∂v/∂t": _range(each("width_spatial", "advective")),
            "relaxing": _range(each("width_spatial", "relaxing", "relaxing advective")),
        },
        "human": {
            measured: {
                "least_conservative": min(each("celerity", "conservative")),
                "largest_conservative": max(each("celerity", "conservative")),
                "least_advective": min(each("celerity", "advective")),
                "largest_advective": max(each("celerity", "advective")),
                "least_width": min(each("width_spatial", *at_once)),
                "largest_width": max(each("width_spatial", *at_once)),
                "least_width_material": min(each("width_material", *at_once)),
            }
        },
        "steepness": {
            measured: {
                "least_conservative": min(each("steepness_spatial", "conservative")),
                "least_advective": min(each("steepness_spatial", "advective")),
                "largest_material": max(each("steepness_material", *at_once)),
            }
        },
        "delayed": {
            measured: {
                "largest_left": max(abs(value) for own in left.values() for value in own.values()),
                "largest_celerity_change": max(abs(value - 1) for value in each("celerity", *late)),
                "largest_steepness_change": max(abs(v - 1) for v in each("steepness_spatial", *late)),
                "least_width": min(each("width_spatial", *late[:2])),
                "largest_width": max(each("width_spatial", *late[:2])),
            }
        },
        "how-soon": {
            measured: {
                "half_rise_ms": n["half_rise"]["conservative"],
                "left_at_3_ms": next(row["left"] for row in conservative if row["rise"] == 3.0),
                "largest_off": max(abs(row["left"] - row["predicted"]) for row in conservative),
            }
        },
        "held": {
            measured: {
                "celerity_ratio": held["celerity_ratio"],
                "spatial_ratio": held["spatial_ratio"],
                "stretch": held["stretch"],
            }
        },
        "blocking": {
            measured: {
                "least_loss_at_once": min(1 - 1 / value for value in each("celerity", *at_once)),
                "largest_change_late": max(abs(1 / value - 1) for value in each("celerity", *late)),
                "duration_advective": max(abs(v - 1) for v in each("repolarization", "relaxing advective")),
                "duration_conservative": max(1 / v - 1 for v in each("repolarization", "relaxing")),
                "held_late_ms": held["late_ms"],
            }
        },
    }


def _range(values: list[float]) -> dict[str, float]:
    return {"least_ratio": min(values), "largest_ratio": max(values)}
