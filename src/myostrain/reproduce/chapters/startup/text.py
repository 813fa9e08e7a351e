"""The tables of thresholds, of what is missing in (5.1), and of experiments."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.chapters.startup.jobs import (
    DRIVEN,
    FAMILIES,
    MODES,
    SCHEMES,
    SPACINGS,
    TOLERANCES,
    widths_of,
)
from myostrain.reproduce.chapters.startup.numbers import point, rest
from myostrain.reproduce.content import Measured, Rows

#: What a family's bumps and (5.1) are called.
BODIES = {"sheet": "sheet, $J = 1$", "line": "line, $J = x'$"}
FORMS = {"printed": "as printed", "weighted": "with $J$", "whole": "with $J$ and $J_t$"}


def settings(family: str) -> str:
    """The bumps of a family in words."""
    shape, spacing, sampling, recovery = FAMILIES[family]
    bump = ("step" if shape == "step" else "smooth") + ("" if recovery else ", w = 0")
    return f"{bump}, cells of {spacing:g}" + (", each node the mean around it" if sampling == "mean" else "")


def words(measured: Measured) -> dict[str, Any]:
    """What the words name beside the numbers."""
    n, quick = measured.numbers, measured.quick
    made = {
        "steps": "4e-4 and 2e-4 to t = 0.01" if quick else "2e-4 and 1e-4 to t = 0.02",
        "tolerance": TOLERANCES[quick],
        "largest_from_rest": rest(n),
        "at": lambda family, mode, width: point(n, family, mode, width),
    }
    return made if quick else made | {"window": _window(n)}


def _window(n: Any) -> dict[str, Any]:
    """The thresholds for R = 2 on finer meshes, and what they hang on."""
    closer = n["closer"]

    def moved(kind: str, mode: str, width: float) -> float:
        threshold = point(n, "paper", mode, width)["threshold"]
        return 0.0 if threshold is None else abs(closer[f"{kind} {mode} {width:g}"] - threshold)

    made: dict[str, Any] = {}
    for mode in ("coupled", "held"):
        nodal, mean = ([closer[f"window {s} {mode} {h}"] for h in (0.25, 0.125)] for s in ("nodal", "mean"))
        made[mode] = {"mean": mean[1], "change": abs(mean[1] - mean[0]), "nodal": 2 * nodal[1] - nodal[0]}
    return made | {
        "later": max(moved("later", mode, width) for mode in MODES for width in (2.0, 40.0)),
        "implicit": max(moved("implicit", "coupled", 2.0), moved("implicit", "held", 1.0)),
    }


def tables(measured: Measured) -> dict[str, Rows]:
    """The rows of the tables."""
    n, found = measured.numbers, measured.found
    thresholds: list[list[Any]] = []
    for family in FAMILIES:
        for i, width in enumerate(widths_of(family, measured.quick)):
            points = {r["mode"]: r for r in n["map"] if (r["family"], r["half_width"]) == (family, width)}
            known = [points[mode]["threshold"] if mode in points else None for mode in MODES]
            begins = [found[f"(5.2) {family} {name}"].numbers["from"][i] for name in ("held", "coupled")]
            thresholds.append([settings(family), f"{width:g}", *known, *begins])
    made: dict[str, Rows] = {
        "thresholds": thresholds,
        "energy": [
            [BODIES[body], FORMS[form]]
            + [found[f"energy {body} {scheme}"].numbers[form][-1] for scheme in SCHEMES]
            + [n["energy"][body][form]["remainder"]]
            for body, forms in (("sheet", ("printed",)), ("line", FORMS))
            for form in forms
        ],
        "driven": [
            [name.split(",")[0] + (", w = 0" if name.endswith("w = 0") else ""), DRIVEN[name][1]]
            + [run[key] for key in ("after", "largest", "last", "stretch")]
            for name, run in n["driven"].items()
        ],
    }
    if not measured.quick:
        columns = [(s, mode) for s in ("nodal", "mean") for mode in ("coupled", "held")]
        made["window"] = [
            [f"{h:g}", *(n["closer"][f"window {s} {mode} {h:g}"] for s, mode in columns)] for h in SPACINGS
        ]
    return made
