"""Tables of human pulses and of what a delay leaves, and both as columns."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.chapters.delay.jobs import STAGES
from myostrain.reproduce.chapters.human_pulse import jobs
from myostrain.reproduce.chapters.human_pulse import numbers as of
from myostrain.reproduce.content import Measured, Rows

#: Rows of the table, and which of them are shown over those of the rigid line.
COLUMNS = ("celerity", "width_material", "width_spatial", "steepness_material", "steepness_spatial",
           "repolarization")  # fmt: skip


def words(measured: Measured) -> dict[str, Any]:
    """What the words name beside the numbers."""
    n, step = measured.numbers, STAGES[measured.quick]["BOCF"][0][0]
    return {
        "bueno": n["ratios"]["BOCF"],
        "tusscher": n["ratios"]["TTP06"],
        "rows": n["rows"],
        "relaxed": [n["ratios"][m][kind] for m in jobs.HUMAN for kind in ("relaxing", "relaxing advective")],
        "grid": f"Δx = {jobs.spacing(measured.quick):g} mm, Δt = {step:g} ms while the front passes",
        "conservative_sweep": n["sweep"]["conservative"],
        "largest_left": max(abs(value) for own in n["left"].values() for value in own.values()),
        "EARLY": of.EARLY,
        "LATE": of.LATE,
    }


def tables(measured: Measured) -> dict[str, Rows]:
    """The rows of the tables."""
    pulses: list[list[Any]] = []
    for m, name in jobs.HUMAN.items():
        for kind, text in jobs.KINDS.items():
            row, ratio = measured.numbers["rows"][m][kind], measured.numbers["ratios"][m][kind]
            cells = [f"{row[key]:.4g} ({ratio[key]:.3f})" for key in COLUMNS]
            cells[0] = f"{100 * row['celerity']:.1f} ({ratio['celerity']:.3f})"
            pulses.append([name, text, *cells, row["peak"]])
    sweep = [
        [jobs.KINDS[balance].removeprefix("at once, "), row["rise"], row["left"], row["predicted"]]
        for balance, rows in measured.numbers["sweep"].items()
        for row in rows
    ]
    return {"pulses": pulses, "sweep": sweep}


def data(measured: Measured) -> dict[str, dict[str, Any]]:
    """What passes the place in each pulse, and what a delay leaves of the celerity's gain."""
    pulses: dict[str, list[Any]] = {
        key: [] for key in ("membrane", "line", "time_after_upstroke", "excitation", "stretch")
    }
    for m in jobs.HUMAN:
        for kind in jobs.KINDS:
            one = measured.found[f"{m} {kind}"]
            count = len(one.arrays["times"])
            pulses["membrane"] += [m] * count
            pulses["line"] += [kind] * count
            pulses["time_after_upstroke"] += (one.arrays["times"] - one.numbers["upstroke"]).tolist()
            pulses["excitation"] += one.arrays["excitation"].tolist()
            pulses["stretch"] += (1 - one.arrays["shortening"]).tolist()
    rows = [{"balance": balance} | row for balance, own in measured.numbers["sweep"].items() for row in own]
    sweep = {key: [row[key] for row in rows] for key in ("balance", "rise", "left", "predicted")}
    held = measured.found["held"].arrays
    return {
        "human-pulse-courses": pulses,
        "human-pulse-sweep": sweep,
        "human-pulse-held": {key: held[key] for key in ("X", "arrival", "front_stretch")},
    }
