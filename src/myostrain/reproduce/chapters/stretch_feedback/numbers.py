"""Arrivals, beats of squares, delays of re-excitation, ways of spirals."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

from myostrain.reproduce.chapters.stretch_feedback.jobs import (
    APPROACHES,
    BETA,
    FEW,
    HALVED,
    LINES,
    PREMATURE,
    SPIRALS,
    slow_squares,
    squares,
)
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements.matched import matched

import numpy as np

#: Upstrokes from which on a square that has not come to rest counts as having a pacemaker.
BEATS = 3.0


def numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number of the chapter."""
    made: dict[str, Any] = {
        "lines": {f"{g:g}": found[f"clamped {g:g}"].numbers for g in LINES},
        "free_difference": float(
            np.abs(found["free 3"].arrays["potential"] - found["free 0"].arrays["potential"]).max()
        ),
        "tensions": {reading: matched(BETA, reading) for reading in ("free", "held")},
        "premature": {f"{g:g}": found[f"premature {g:g}"].numbers for g in PREMATURE[quick]},
        "quick": {},
        "slow": {},
        "window": {name: found[f"window {name}"].numbers for name in ("slow", "quick")},
        "spirals": {},
    }
    for name, wanted in (("quick", squares(quick)), ("slow", slow_squares(quick))):
        for approach, g in wanted:
            made[name].setdefault(approach, {})[f"{g:g}"] = _judged(found[f"{name} {approach} {g:g}"])
    for approach in ("strain",) if quick else ("strain", "stress"):
        made["spirals"][approach] = {
            f"{g:g}": found[f"spiral {approach} {g:g}"].numbers for g in SPIRALS[quick]
        }
    if not quick:
        made["premature_halved"] = {
            f"{g:g}": found[f"premature halved {g:g}"].numbers for g in PREMATURE[True]
        }
        made["thresholds"] = {approach: found[f"threshold {approach}"].numbers for approach in APPROACHES}
        made["halved"] = {
            f"{approach} {g:g}": _judged(found[f"halved {approach} {g:g}"]) for approach, g in HALVED
        }
        made["large"] = {
            approach: {f"{g:g}": _judged(found[f"large {approach} {g:g}"]) for g in FEW}
            for approach in ("strain", "stress")
        }
    return made


def _judged(one: Found) -> dict[str, Any]:
    """The numbers, the largest share that is excited at one time, and whether there is a pacemaker."""
    n = one.numbers | {"widest": float(one.arrays["excited"].max())}
    return n | {"pacemaker": bool(n["silent"] is None and n["beats"] >= BEATS)}


def readings(n: Mapping[str, Any]) -> dict[str, Any]:
    """What is judged, by claim and reading."""
    measured = "as measured"
    times = [one["middle"] for one in n["lines"].values()]
    plane, held = n["quick"]["strain in plane"], n["quick"]["stress, held in plane"]
    free = n["quick"]["stress in plane"]
    slow, quick = n["window"]["slow"], n["window"]["quick"]
    spirals = n["spirals"]["strain"]
    silent = spirals["1"]["silent"]
    without, some = n["premature"]["0"], n["premature"]["0.2"]
    return {
        "line": {
            measured: {
                "last_over_first": _ratio(times[-1], times[0]),
                "latest_over_before": max(_ratio(late, early) or np.inf for early, late in pairwise(times)),
                "beats": max(one["beats"] for one in n["lines"].values()),
                "free_difference": n["free_difference"],
            }
        },
        "pacemaker": {
            measured: {
                "beats": plane["3"]["beats"],
                "going_on": float(plane["3"]["silent"] is None),
                "beats_at_2": plane["2"]["beats"],
            }
        },
        "strain-and-stress": {
            measured: {
                "strain_beats": plane["2"]["beats"],
                "stress_beats": free["2"]["beats"],
                "strain_over_stress_drive": plane["2"]["first_drive"] / free["2"]["first_drive"],
                "strain_over_held_stress_drive": plane["2"]["first_drive"] / held["2"]["first_drive"],
            }
        },
        "fibre": {measured: {"beats": max(one["beats"] for one in n["quick"]["strain"].values())}},
        "aliev-panfilov": {
            measured: {"beats": max(one["beats"] for ways in n["slow"].values() for one in ways.values())}
        },
        "window": {
            measured: {
                "slow_over_duration": _ratio(slow["earliest"][0], slow["duration"]),
                "quick_over_duration": _ratio(quick["earliest"][0], quick["duration"]),
            }
        },
        "vulnerable": {
            measured: {
                "width_without": without["width"],
                "width_over_without": _ratio(some["width"], without["width"]),
                "back_over_without": _ratio(some["back"], without["back"]),
                "forth_over_without": _ratio(some["forth"], without["forth"]),
            }
        },
        "spiral": {
            measured: {
                "period_without": spirals["0"]["period"],
                "drift_without": spirals["0"]["drift"],
                "drift_at_half_over_without": _ratio(spirals["0.5"]["drift"], spirals["0"]["drift"]),
                "ended_at_1": float(silent),
            }
        },
    }


def _ratio(a: float | None, b: float | None) -> float | None:
    return None if a is None or b is None else a / b
