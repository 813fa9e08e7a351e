"""Tables of thresholds, and the same as columns."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.content import Measured, Rows

import numpy as np


def words(measured: Measured) -> dict[str, Any]:
    """What the words name beside the numbers."""
    found = measured.numbers["thresholds"]
    return {
        "ap": found["AlievPanfilov1996"],
        "fhn": found["FitzHughNagumo"],
        "ms": found["MitchellSchaeffer2003"],
        "zip": zip,
        # The conductance from which on a stretch of 1.2 excites.
        "enough": {name: one["mean_drive"] / 0.2 for name, one in found.items()},
    }


def tables(measured: Measured) -> dict[str, Rows]:
    """The rows of the tables."""
    n = measured.numbers
    return {
        "thresholds": [
            [name, g, estimated, stretch, ratio]
            for name, one in n["thresholds"].items()
            for g, estimated, stretch, ratio in zip(
                one["conductances"], one["estimated"], one["stretch"], one["over_estimate"], strict=True
            )
        ],
        "slow": [
            [{"ramp": "stretched slowly, then held", "brief": "held, then let go"}[way], time, stretch]
            for way in ("ramp", "brief")
            for time, stretch in zip(n[way]["times"], n[way]["stretch"], strict=True)
        ],
        "segments": [
            [half, drive, drive / n["thresholds"]["AlievPanfilov1996"]["mean_drive"]]
            for half, drive in zip(n["segments"]["halves"], n["segments"]["drive"], strict=True)
        ],
    }


def data(measured: Measured) -> dict[str, dict[str, Any]]:
    """Thresholds by membrane and conductance, and the potential of held points."""
    n, held = measured.numbers["thresholds"], measured.found["held"].arrays
    columns: dict[str, list[Any]] = {
        key: [] for key in ("membrane", "conductance", "estimated_stretch", "threshold_stretch", "drive")
    }
    for name, one in n.items():
        columns["membrane"] += [name] * len(one["conductances"])
        columns["conductance"] += one["conductances"]
        columns["estimated_stretch"] += one["estimated"]
        columns["threshold_stretch"] += one["stretch"]
        columns["drive"] += one["drive"]
    every = max(1, len(held["times"]) // 200)
    times, v = held["times"][::every], held["potential"][::every]
    return {
        "stretch-threshold": columns,
        "stretch-threshold-held": {
            "drive": np.repeat(held["drives"], len(times)),
            "time": np.tile(times, len(held["drives"])),
            "potential": v.T.ravel(),
        },
    }
