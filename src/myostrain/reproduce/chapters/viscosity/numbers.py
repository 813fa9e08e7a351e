"""Celerity, widths and delays over the relaxation time, beside the elastic and the rigid line's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.reproduce.chapters.viscosity.jobs import STIFF_STEPS, parts
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements.signals import lowest

import numpy as np

#: λ/τ at which the delay of section 8 is judged.
JUDGED = 1.0
READING = "(4.14) with the contraction as its rest state"
PRINTED = "(4.14) as printed"
NAMES = ("celerity", "width_material", "width_spatial", "half_width", "shortening_max",
         "shortening_half_width", "peak_delay", "rise_delay")  # fmt: skip


def numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number of the chapter."""
    limits = {row: {name: found[row].numbers[name] for name in NAMES} for row in ("elastic", "rigid")}
    elastic, rigid = limits["elastic"], limits["rigid"]
    sweep = [
        {"part": part, **{name: found[f"{part:g}"].numbers[name] for name in NAMES}} for part in parts(quick)
    ]
    for row in sweep:
        wave = row["shortening_half_width"]
        row |= {
            "celerity_share": (row["celerity"] - rigid["celerity"])
            / (elastic["celerity"] - rigid["celerity"]),
            "width_ratio": row["width_spatial"] / rigid["width_spatial"],
            "width_material_ratio": row["width_material"] / rigid["width_material"],
            "wave_ratio": None if wave is None else wave / row["half_width"],
        }

    def ratios(row: Mapping[str, Any], to: Mapping[str, Any]) -> dict[str, float]:
        return {name: row[name] / to[name] for name in ("celerity", "width_spatial")}

    shares = [row["celerity_share"] for row in sweep[1:-1]]
    made: dict[str, Any] = {
        "limits": limits,
        "sweep": sweep,
        "elastic_limit": ratios(sweep[0], elastic),
        "rigid_limit": ratios(sweep[-1], rigid),
        "printed_over_elastic": ratios(rigid, elastic),
        "celerity_rises_by_at_most": float(np.diff([row["celerity"] for row in sweep]).max()),
        "celerity_share": [min(shares), max(shares)],
        "least_width": {name: _least(sweep, name, rigid) for name in ("width_spatial", "width_material")},
        "judged": next(row for row in sweep if row["part"] == JUDGED),
    }
    if not quick:
        coarse, fine = (found[f"stiffest, Δt = {step}"].numbers for step in STIFF_STEPS)
        names = ("celerity", "width_spatial", "potential_max")
        made["step_error"] = {name: coarse[name] / fine[name] - 1 for name in names}
    return made


def _least(sweep: list[dict[str, Any]], name: str, rigid: Mapping[str, Any]) -> dict[str, float]:
    place, value = lowest(np.log10([row["part"] for row in sweep]), np.array([row[name] for row in sweep]))
    return {"part": 10**place, "value": value, "ratio": value / rigid[name]}


def readings(n: Mapping[str, Any]) -> dict[str, Any]:
    """What is judged, by claim and reading."""
    elastic, rigid, judged = n["limits"]["elastic"], n["limits"]["rigid"], n["judged"]
    least = n["least_width"]["width_spatial"]["value"]
    shorter = min(elastic["width_spatial"], rigid["width_spatial"])
    low, high = n["celerity_share"]
    rise, duration = n["celerity_rises_by_at_most"], judged["half_width"] / judged["celerity"]

    def limit(values: Mapping[str, float]) -> dict[str, float]:
        return {"celerity_ratio": values["celerity"], "width_ratio": values["width_spatial"]}

    return {
        "viscous-elastic-limit": {
            PRINTED: limit(n["printed_over_elastic"]),
            READING: limit(n["elastic_limit"]),
        },
        "viscous-rigid-limit": {
            PRINTED: {"celerity_ratio": 1.0, "width_ratio": 1.0, "shortening": 0.0},
            READING: limit(n["rigid_limit"]) | {"shortening": n["sweep"][-1]["shortening_max"]},
        },
        "viscous-velocity": {
            PRINTED: {"least_share": 0.0, "largest_share": 0.0, "largest_rise": 0.0},
            READING: {"least_share": low, "largest_share": high, "largest_rise": rise},
        },
        "viscous-width": {READING: {"least_width_over_the_shorter_limit": least / shorter}},
        "viscous-delay": {
            PRINTED: {"peak_delay_share": None, "rise_delay_share": None},
            READING: {f"{name}_share": judged[name] / duration for name in ("peak_delay", "rise_delay")},
        },
        "viscous-long-wave": {
            PRINTED: {"length_ratio": None, "shortening_share": 0.0},
            **{
                f"{READING}, λ = {row['part']:g} τ": {
                    "length_ratio": row["wave_ratio"],
                    "shortening_share": row["shortening_max"] / elastic["shortening_max"],
                }
                for row in n["sweep"]
                if 1.0 <= row["part"] <= 10.0
            },
        },
    }
