"""Orders and remainders of (5.1), the maps beside (5.2), and what contractions do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.reproduce.chapters.startup.jobs import (
    DRIVEN,
    FAMILIES,
    SCHEMES,
    SPACINGS,
    WEAK,
    entries,
    widths_of,
)
from myostrain.reproduce.jobs import Found

import numpy as np


def numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number of the chapter."""
    rows, sides = _map(found, quick), found["sides"].numbers
    made = {
        "energy": _energy(found),
        "rates": _rates(found),
        "map": rows,
        "with_recovery": _judged(rows, True),
        "without_recovery": _judged(rows, False),
        "sides": {
            "spacings": SPACINGS,
            **sides,
            "ratio_coupled": [g / c for g, c in zip(sides["gain"], sides["coupled"], strict=True)],
            "ratio_held": [g / h for g, h in zip(sides["gain"], sides["held"], strict=True)],
        },
        "least_stretch": found["least stretch"].numbers["stretch"],
        "stretched_peak": found["stretched"].numbers["metrics"]["potential_max"],
        "isochoric": found["isochoric"].numbers,
        "driven": {name: found[name].numbers for name in DRIVEN},
    }
    if not quick:
        made["closer"] = {
            name: job.numbers["threshold"]
            for name, job in found.items()
            if name.startswith(("window", "implicit", "later"))
        }
    return made


def _energy(found: Mapping[str, Found]) -> dict[str, dict[str, dict[str, float]]]:
    """By body and form of the identity: observed orders, and what remains at a step of zero."""
    made: dict[str, dict[str, dict[str, float]]] = {}
    for body in ("sheet", "line"):
        made[body] = {}
        for form in ("printed", "weighted", "whole"):
            row: dict[str, float] = {}
            remainders = []
            for scheme in SCHEMES:
                coarse, fine = found[f"energy {body} {scheme}"].numbers[form][-2:]
                row[f"order_{scheme.replace('-', '_')}"] = float(np.log2(abs(coarse / fine)))
                factor = 4 if scheme == "second-order" else 2
                remainders.append(abs(factor * fine - coarse) / (factor - 1))
            made[body][form] = {**row, "remainder": max(remainders)}
    return made


def _rates(found: Mapping[str, Found]) -> dict[str, float]:
    """Whether (5.2) says what the energy does at first."""
    wrong, worst = 0, 0.0
    for body in ("line", "sheet"):
        values = found[f"rate {body}"].numbers
        rate, gain, loss = (np.array(values[name]) for name in ("rate", "gain", "loss"))
        wrong += int(np.sum(np.sign(rate) != np.sign(gain - loss)))
        worst = max(worst, float(np.max(np.abs(rate - gain + loss) / (np.abs(gain) + loss))))
    return {"wrong_signs": wrong, "discrepancy": worst}


def _map(found: Mapping[str, Found], quick: bool) -> list[dict[str, Any]]:
    """The points of the maps: threshold, where (5.2) begins to hold, energy at the threshold."""
    rows = []
    for family, mode, width in entries(quick):
        condition = found[f"(5.2) {family} {'coupled' if mode == 'coupled' else 'held'}"].numbers
        i = widths_of(family, quick).index(width)
        threshold, begins = found[f"{family} {mode} {width:g}"].numbers["threshold"], condition["from"][i]
        row = {"family": family, "mode": mode, "half_width": width, "threshold": threshold}
        row |= {"satisfied_from": begins, "satisfied_to": condition["to"][i]}
        known = threshold is not None
        row["margin"] = begins - threshold if known and begins is not None else None
        row["energy"] = threshold**2 * condition["square"][i] / 2 if known else None
        rows.append(row)
    return rows


def _judged(rows: list[dict[str, Any]], recovery: bool) -> dict[str, Any]:
    """What the maps say about (5.2), with or without recovery."""
    rows = [row for row in rows if FAMILIES[row["family"]][3] is recovery]
    fire = [row for row in rows if row["threshold"] is not None]
    both = [row for row in rows if row["margin"] is not None]
    steps = [row for row in both if FAMILIES[row["family"]][0] == "step" and row["half_width"] <= 10]
    # The bisection knows a threshold to half its last interval, at most 3e-3.
    early = [row for row in fire if row["margin"] is None or row["margin"] > 3e-3]
    least = min(fire, key=lambda row: row["energy"])
    return {
        "points": len(rows),
        "fire": len(fire),
        "satisfiable": len(both),
        "not_sufficient": sum(row["margin"] < 0 for row in both),
        "least_margin": min(row["margin"] for row in both),
        "least_margin_narrow_steps": min((row["margin"] for row in steps), default=None),
        "exceptions": len(early),
        "least_energy": least["energy"],
        "least_energy_half_width": least["half_width"],
        "largest_energy": max(row["energy"] for row in fire),
    }


def point(n: Mapping[str, Any], family: str, mode: str, width: float) -> dict[str, Any]:
    """The point of a map: its family, mode and half-width, threshold, and where (5.2) holds."""
    keys = {"family": family, "mode": mode, "half_width": width}
    row: dict[str, Any] = next(row for row in n["map"] if keys.items() <= row.items())
    return row


def rest(n: Mapping[str, Any]) -> float:
    """The largest |v| of all experiments that begin at rest."""
    return max(run["largest"] for name, run in n["driven"].items() if name.endswith("v = 0"))


def readings(n: Mapping[str, Any]) -> dict[str, Any]:
    """What is judged, by claim and reading."""
    sheet, line, yes, sides = n["energy"]["sheet"], n["energy"]["line"], n["with_recovery"], n["sides"]

    def rise(*runs: str) -> dict[str, float]:
        return {"rise": max(n["driven"][run]["largest"] for run in runs) / WEAK}

    return {
        "energy-sheet": {"plane-stress sheet": sheet["printed"]},
        "energy-line": {"as printed": line["printed"], "with J and the term of J_t": line["whole"]},
        "begins-to-grow": {"held line and sheet": n["rates"]},
        "minimum-energy": {"line": yes},
        "sufficient": {
            "with recovery": {"least_margin": yes["least_margin"]},
            "without recovery (w = 0)": n["without_recovery"],
        },
        "necessary": {"with recovery": yes},
        "figure-2-fails": {"coupled line": {"largest_ratio": max(sides["ratio_coupled"])}},
        "figure-2-held": {"cells of 1": {"ratio": sides["ratio_held"][0]}},
        "minimum-strain": {"held until t = 0.01": {"ratio": n["least_stretch"] / sides["stretch"][0]}},
        "incompressible": {
            "a signal that varies in all directions": {"least_loss": n["isochoric"]["ball"]},
            "a signal that varies in the plane of a sheet only": {"least_loss": n["isochoric"]["column"]},
        },
        "rest": {"line and sheet": {"largest_potential": rest(n)}},
        "nonzero": {
            "line, J = x′": rise("line contracts"),
            "incompressible body, J = 1 (3.8)": rise("sheet contracts", "sheet let go"),
        },
    }
