"""Tables of lines and of families of laws, and courses and maps as columns."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.chapters.delay import jobs
from myostrain.reproduce.chapters.delay import numbers as of
from myostrain.reproduce.content import Measured, Rows
from myostrain.reproduce.measurements.contraction import MEASURES

import numpy as np

COLUMNS = ("peak_delay", "rise_delay", "delay_share", "half_length", "tenth_length", "peak",
           "shortening_share")  # fmt: skip
#: What the page calls the runs, after the membrane.
LABELS = {
    "at once": "γ = −βv, at once",
    "relaxing": "relaxing",
    "rossi": "Rossi 2014, as published",
    "rossi fast": "Rossi 2014, μ = 500",
}


def label(name: str) -> str:
    """What the page calls the law of a run."""
    law, _, sheet = name.split(" ", 1)[1].partition(", ")
    if law.startswith("viscous "):
        law = f"viscous, λ = {law.removeprefix('viscous ')}"
    return LABELS.get(law, law) + (", sheet" if sheet else "")


def words(measured: Measured) -> dict[str, Any]:
    """What the words name beside the numbers."""
    quick, rows = measured.quick, measured.numbers["rows"]
    spacing = jobs.SPACINGS[quick]
    return {
        "DELAY": of.DELAY,
        "OUTLASTING": of.OUTLASTING,
        "REPOLARIZATION": of.REPOLARIZATION,
        "COMPARED": of.COMPARED,
        "fhn": measured.numbers["maps"]["FHN"],
        "human": measured.numbers["maps"]["BOCF"],
        "rows": rows,
        "errors": measured.numbers["map_errors"],
        "grid": (
            f"Δx = {spacing['FHN']:g} (FitzHugh–Nagumo) and {spacing['BOCF']:g} mm, time steps of "
            f"{jobs.STAGES[quick]['FHN'][0][0]:g} and {jobs.STAGES[quick]['BOCF'][0][0]:g} ms while the "
            "front passes"
        ),
        "laws": {
            family: sum(one[family]["laws"] for one in measured.numbers["maps"].values() if family in one)
            for family in of.FAMILIES
        },
    }


def tables(measured: Measured) -> dict[str, Rows]:
    """The rows of the tables."""
    rows = []
    for name, row in measured.numbers["rows"].items():
        membrane = jobs.MEMBRANES[name.split()[0]][1]
        yes = [word for word, key in (("delay", "physiological_delay"), ("length", "outlasts")) if row[key]]
        cells = [row[key] for key in COLUMNS]
        rows.append([membrane, label(name), *cells, " and ".join(yes) or "neither"])
    families = []
    for membrane, one in measured.numbers["maps"].items():
        for family in of.FAMILIES:
            if family in one:
                own = one[family]
                counts = [own[key] for key in ("laws", "delayed", "outlasting", "both")]
                shortening = own["shortening_of_delayed"]
                families.append([
                    jobs.MEMBRANES[membrane][1],
                    family,
                    *counts,
                    own["longest_of_delayed"],
                    None if shortening is None else f"{shortening[0]:.2f} to {shortening[1]:.2f}",
                ])  # fmt: skip
    return {"lines": rows, "families": families}


def data(measured: Measured) -> dict[str, dict[str, Any]]:
    """Courses at the places, and every law of the maps."""
    courses: dict[str, list[Any]] = {
        key: [] for key in ("membrane", "law", "time_after_upstroke", "excitation", "shortening")
    }
    for name in measured.numbers["rows"]:
        arrays, upstroke = measured.found[name].arrays, measured.found[name].numbers["upstroke"]
        count = len(arrays["times"])
        courses["membrane"] += [name.split()[0]] * count
        courses["law"] += [name.split(" ", 1)[1]] * count
        courses["time_after_upstroke"] += (arrays["times"] - upstroke).tolist()
        courses["excitation"] += arrays["excitation"].tolist()
        courses["shortening"] += arrays["shortening"].tolist()
    made: dict[str, dict[str, Any]] = {"delay-courses": courses}
    for membrane in measured.numbers["maps"]:
        made[f"delay-laws-{membrane}"] = _laws(measured, membrane)
    return made


def _laws(measured: Measured, membrane: str) -> dict[str, Any]:
    """One row per law: its parameters, nothing where it has none of the name, and what it does."""
    settings = jobs.map_settings(membrane, measured.quick)
    arrays = measured.found[f"{membrane} map"].arrays
    names = ("relaxation_time", "threshold", "rise", "fall", "alpha", "mu")
    columns: dict[str, list[Any]] = {key: [] for key in ("law", *names, *MEASURES)}
    grid = np.meshgrid(settings["thresholds"], settings["rise"], settings["fall"], indexing="ij")
    pairs = np.array(settings["rossi"], dtype=float).reshape(-1, 2)
    parameters: dict[str, dict[str, Any]] = {
        "viscosity": {"relaxation_time": settings["relaxation"]},
        "relaxing": {key: one.ravel().tolist() for key, one in zip(names[1:4], grid, strict=True)},
        "rossi": dict(zip(names[4:], pairs.T.tolist(), strict=True)),
    }
    for family, own in parameters.items():
        count = len(next(iter(own.values())))
        if not count:
            continue
        columns["law"] += [family] * count
        for key in names:
            columns[key] += list(own.get(key, [np.nan] * count))
        for key in MEASURES:
            columns[key] += arrays[f"{family} {key}"].ravel().tolist()
    return columns
