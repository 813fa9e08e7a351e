"""Delay and length of the mechanical wave over λ/τ, frame indifference, dissipation, the line's limit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.reproduce.chapters.viscous_sheet.jobs import KINEMATICS, SHARES, SIZES
from myostrain.reproduce.jobs import Found

import numpy as np


def numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number of the chapter."""
    difference = {k: [found[f"{k} {size}"].numbers["difference"] for size in SIZES] for k in KINEMATICS}
    block: dict[str, float] = {}
    for name, of in (("order", lambda _, b, c: float(np.log2(b / c))), ("difference", lambda _, b, c: b)):
        block |= {f"{name}_{k.replace('-', '_')}": of(*values) for k, values in difference.items()}
    return {
        "sheets": {
            **{str(share): _row(found, f"sheet {share}") for share in SHARES},
            "rectified": _row(found, "rectified"),
        },
        "free block": block,
        "free block, γ to −0.3": {k: values[0] for k, values in difference.items()},
        "line's dashpot, least power": found["plane-stress 0.3"].numbers["line_power"],
        "random motions": found["motions"].numbers,
    }


def _row(found: Mapping[str, Found], name: str) -> dict[str, Any]:
    """The numbers of one sheet, and what the claims are about."""
    own, elastic = found[name].numbers, found["sheet 0.0"].numbers
    v, s = own["potential"], own["shortening"]
    return {
        "celerity": own["metrics"]["celerity"],
        "potential_duration": v["duration"],
        "shortening_duration": s["duration"],
        "shortening_peak": s["peak"],
        "rise_delay": own["rise_delay"],
        "peak_delay": own["peak_delay"],
        "rise_delay_over_duration": own["rise_delay"] / v["duration"],
        "length_ratio": None if s["duration"] is None else s["duration"] / v["duration"],
        "peak_over_elastic": s["peak"] / elastic["shortening"]["peak"],
    }


def readings(n: Mapping[str, Any]) -> dict[str, Any]:
    """What is judged, by claim and reading."""
    sheets = {
        "λ = τ" if share == 1 else f"λ = {share:g} τ": n["sheets"][str(share)]
        for share in (1.0, 0.4, 5.0, 50.0)
    }
    sheets["λ = 5 τ, and no stretch below rest"] = n["sheets"]["rectified"]
    return {
        "viscous-delay": sheets,
        "viscous-length": sheets,
        "viscous-frame": {"printed": n["random motions"]},
        "viscous-line": {"printed": n["free block"]},
    }
