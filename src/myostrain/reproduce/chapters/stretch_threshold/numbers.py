"""Thresholds beside the estimate, and what is left of them for slow, brief and small stretches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain import membranes
from myostrain.reproduce.chapters.stretch_threshold.jobs import FEW, MEMBRANES, WITHOUT, halves
from myostrain.reproduce.jobs import Found
from myostrain.theory import least_drive_of_a_cubic

import numpy as np


def numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number of the chapter."""
    made: dict[str, Any] = {"without": {}, "thresholds": {}}
    for name in WITHOUT:
        made["without"][name] = {
            balance: found[f"{name} {balance}"].numbers for balance in ("conservative", "advective")
        }
    made["largest_without"] = max(
        value for one in made["without"].values() for ways in one.values() for value in ways.values()
    )
    for name in MEMBRANES:
        one = found[name].numbers
        drives = np.array(one["drive"], dtype=float)
        made["thresholds"][name] = one | {
            "over_estimate": (drives / one["estimate"]).tolist(),
            "mean_drive": float(drives.mean()),
            "spread": float(np.ptp(drives) / drives.mean()),
        }
    cubic, paper = membranes.AlievPanfilov1996(), membranes.FitzHughNagumo()
    made["closed_forms"] = {
        "AlievPanfilov1996": least_drive_of_a_cubic(cubic.k, cubic.a),
        "FitzHughNagumo": least_drive_of_a_cubic(paper.A, paper.alpha),
    }
    made["closed_form_error"] = max(
        abs(made["thresholds"][name]["estimate"] / value - 1) for name, value in made["closed_forms"].items()
    )
    made |= {way: found[way].numbers for way in ("ramp", "brief")}
    made["segments"] = found["segments"].numbers | {"halves": halves(quick)}
    held, drives = found["held"].numbers, found["held"].arrays["drives"]
    fired = np.array(held["fired"])
    made["held"] = held | {
        "drives": drives.tolist(),
        "last_silent": float(drives[~fired].max()),
        "first_fired": float(drives[fired].min()),
        "largest_swing": max(held["swing"]),
    }
    made["few"] = {name: list(values) for name, values in FEW.items()}
    return made


def readings(n: Mapping[str, Any]) -> dict[str, Any]:
    """What is judged, by claim and reading."""
    measured = "as measured"
    first, paper = n["thresholds"]["AlievPanfilov1996"], n["thresholds"]["FitzHughNagumo"]
    drive, beyond = first["mean_drive"], first["mean_drive"]  # g = 1: λ − 1 is the drive
    parts = n["segments"]["drive"]
    slow = [None if value is None else (value - 1) / beyond for value in n["ramp"]["stretch"]]
    brief = [None if value is None else (value - 1) / beyond for value in n["brief"]["stretch"]]
    return {
        "without": {measured: {"largest_of_range": n["largest_without"]}},
        "with": {
            measured: {
                "drive_over_estimate": drive / first["estimate"],
                "spread_over_conductances": first["spread"],
                "closed_form_error": n["closed_form_error"],
            }
        },
        "paper": {
            measured: {
                "drive_over_estimate": paper["mean_drive"] / paper["estimate"],
                "spread_over_conductances": paper["spread"],
            }
        },
        "rapid": {
            measured: {
                "slowest_over_sudden": slow[-1],
                "fastest_over_sudden": slow[0],
                "briefest_over_lasting": brief[0],
            }
        },
        "part": {
            measured: {"smallest_over_whole": parts[0] / drive, "largest_over_whole": parts[-1] / drive}
        },
        "once": {
            measured: {
                "largest_swing": n["held"]["largest_swing"],
                "first_fired_over_threshold": n["held"]["first_fired"] / drive,
                "last_silent_over_threshold": n["held"]["last_silent"] / drive,
            }
        },
    }
