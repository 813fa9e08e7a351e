"""Delay, length and size of the contraction by law, and which laws give what a heart needs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.reproduce.chapters.delay.jobs import RELAXATION, RELAXING, ROSSI, THRESHOLDS, map_settings
from myostrain.reproduce.jobs import Found

import numpy as np

#: What counts as physiological: the delay of the peak in ms, for a potential of REPOLARIZATION, ...
DELAY = (50.0, 100.0)
REPOLARIZATION = 270.0
#: ... and how much later than the potential the contraction is back to a tenth of its peak, as a ratio.
OUTLASTING = 1.25
#: A delay in between, at which costs are compared.
COMPARED = 75.0
NAMES = ("repolarization", "duration", "excitation_peak", "peak_delay", "rise_delay", "half_end", "tenth_end",
         "half_length", "tenth_length", "delay_share", "peak")  # fmt: skip
#: Laws of the maps, and the names of what they vary.
FAMILIES = {"viscosity": ("relaxation",), "relaxing": ("thresholds", "rise", "fall"), "rossi": ("rossi",)}


def within_delay(share: Any) -> Any:
    """Whether a delay over the repolarisation is that of a heart."""
    share = np.asarray(share, dtype=float)
    return (share >= DELAY[0] / REPOLARIZATION) & (share <= DELAY[1] / REPOLARIZATION)


def numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number of the chapter."""
    rows = {name: _row(found, name) for name in found if not name.endswith(" map")}
    maps = {
        membrane: _map(found[f"{membrane} map"], map_settings(membrane, quick), rows[f"{membrane} at once"])
        for membrane in ("FHN", "BOCF")
    }
    errors = {membrane: _map_errors(membrane, found, rows, quick) for membrane in ("FHN", "BOCF")}
    return {"rows": rows, "maps": maps, "map_errors": errors}


def _row(found: Mapping[str, Found], name: str) -> dict[str, Any]:
    """What a line or a sheet measured, and its shortening over that of the law that follows at once."""
    own = {key: found[name].numbers[key] for key in NAMES}
    membrane, sheet = name.split(maxsplit=1)[0], ", sheet" if name.endswith(", sheet") else ""
    base = found.get(f"{membrane} at once{sheet}")
    # Where the membrane has no such run, its own excitation stands for it.
    elastic = 0.3 * own["excitation_peak"] if base is None else base.numbers["peak"]
    return own | {
        "shortening_share": own["peak"] / elastic,
        "physiological_delay": bool(within_delay(own["delay_share"] or np.nan)),
        "outlasts": bool((own["tenth_length"] or 0.0) >= OUTLASTING),
    }


def _map(one: Found, settings: Mapping[str, Any], elastic: Mapping[str, Any]) -> dict[str, Any]:
    """By family of laws: where the delay is physiological, how long the contraction then is, and its size."""
    made: dict[str, Any] = {"repolarization": one.numbers["repolarization"]}
    compared = COMPARED / REPOLARIZATION
    for family in FAMILIES:
        if f"{family} peak" not in one.arrays:
            continue
        share, length, peak = (
            one.arrays[f"{family} {key}"] for key in ("delay_share", "tenth_length", "peak")
        )
        # What is not back to a tenth by the end of the run outlasts it all.
        length = np.where(np.isnan(length) & ~np.isnan(share), np.inf, length)
        delayed, long = within_delay(share), length >= OUTLASTING
        made[family] = {
            "laws": int(share.size),
            "delayed": int(delayed.sum()),
            "outlasting": int(long.sum()),
            "both": int((delayed & long).sum()),
            "longest_of_delayed": float(length[delayed].max()) if delayed.any() else None,
            "least_delay_of_outlasting": float(share[long].min()) if long.any() else None,
            "shortening_of_delayed": [float(f(peak[delayed]) / elastic["peak"]) for f in (np.min, np.max)]
            if delayed.any()
            else None,
            "shortening_of_both": float(peak[delayed & long].max() / elastic["peak"])
            if (delayed & long).any()
            else None,
        }
    viscosity = [one.arrays[f"viscosity {key}"] for key in ("delay_share", "peak")]
    inside = within_delay(viscosity[0])
    window = np.array(settings["relaxation"])[inside]
    made["viscosity"] |= {
        "window": [float(window.min()), float(window.max())] if inside.any() else None,
        "compared": _at(compared, *viscosity) / elastic["peak"],
    }
    share, peak, left = (one.arrays[f"relaxing {key}"][0] for key in ("delay_share", "peak", "left"))
    rises = np.array(settings["rise"])[within_delay(share[:, 0])]
    made["relaxing"] |= {
        "window": [float(rises.min()), float(rises.max())] if len(rises) else None,
        "compared": _at(compared, share[:, 0], peak[:, 0]) / elastic["peak"],
        # How little the fall time has to do with the delay, where this is physiological.
        "delay_by_fall": float(np.ptp(share[within_delay(share[:, 0])], axis=1).max()),
        "left": float(left[within_delay(share[:, 0])].max()),
    }
    return made


def _at(where: float, x: Any, y: Any) -> float:
    """y where x, which ascends, has a value."""
    return float(np.interp(where, x, y))


def _map_errors(
    membrane: str, found: Mapping[str, Found], rows: Mapping[str, Any], quick: bool
) -> dict[str, float]:
    """By how much coupled lines differ from the rigid line's potential put through the same laws."""
    errors: dict[str, list[float]] = {"delay_share": [], "tenth_length": [], "peak": []}
    settings, arrays = map_settings(membrane, quick), found[f"{membrane} map"].arrays
    runs: dict[str, Any] = {f"viscous {v:g}": ("viscosity", (v,)) for v in RELAXATION[membrane]}
    runs["relaxing"] = ("relaxing", (THRESHOLDS[0], *RELAXING[membrane]))
    runs |= {name: ("rossi", pair) for name, pair in ROSSI.items() if f"{membrane} {name}" in found}
    for run, (family, values) in runs.items():
        for key, kept in errors.items():
            predicted = _looked_up(arrays[f"{family} {key}"], family, settings, values)
            own = rows[f"{membrane} {run}"][key]
            kept.append(abs(predicted / own - 1) if key == "peak" else abs(predicted - own))
    return {key: max(kept) for key, kept in errors.items()}


def _looked_up(values: Any, family: str, settings: Mapping[str, Any], at: tuple[float, ...]) -> float:
    """A value of a map, linear between the logarithms of times."""
    if family == "rossi":
        return float(values[settings["rossi"].index(list(at))])
    if family == "viscosity":
        return float(np.interp(np.log(at[0]), np.log(settings["relaxation"]), values))
    first = values[settings["thresholds"].index(at[0])]
    over_fall = [np.interp(np.log(at[2]), np.log(settings["fall"]), row) for row in first]
    return float(np.interp(np.log(at[1]), np.log(settings["rise"]), over_fall))


def readings(n: Mapping[str, Any]) -> dict[str, Any]:
    """What is judged, by claim and reading."""
    measured = "as measured"
    rows, maps = n["rows"], n["maps"]
    human, calcium, published = maps["BOCF"], rows["TTP06 rossi"], rows["BOCF rossi"]
    at_once = [row for name, row in rows.items() if " at once" in name]
    relaxing = [row for name, row in rows.items() if " relaxing" in name and name.startswith("BOCF")]
    viscosity = [one["viscosity"] for one in maps.values()]
    return {
        "at-once": {
            measured: {
                "rise_delay_share": max(abs(row["rise_delay"]) / row["repolarization"] for row in at_once),
                "human_peak_delay_ms": rows["BOCF at once"]["peak_delay"],
                "least_length": min(row["tenth_length"] for row in at_once),
                "largest_length": max(row["tenth_length"] for row in at_once),
            }
        },
        "viscosity": {
            measured: {
                "membranes_delayed": sum(one["delayed"] > 0 for one in viscosity),
                "laws_with_both": sum(one["both"] for one in viscosity),
                "longest_of_delayed": max(one["longest_of_delayed"] or 0.0 for one in viscosity),
                "human_delay_of_outlasting_ms": human["viscosity"]["least_delay_of_outlasting"]
                * human["repolarization"],
            }
        },
        "relaxing": {
            measured: {
                "least_delay_share": min(row["delay_share"] for row in relaxing),
                "largest_delay_share": max(row["delay_share"] for row in relaxing),
                "least_length": min(row["tenth_length"] for row in relaxing),
                "least_shortening_share": min(row["shortening_share"] for row in relaxing),
                "delay_by_fall": max(one["relaxing"]["delay_by_fall"] for one in maps.values()),
            }
        },
        "calcium": {
            measured: {
                "least_delay_ms": min(published["peak_delay"], calcium["peak_delay"]),
                "calcium_length": calcium["tenth_length"],
                "gate_length": published["tenth_length"],
                "laws_with_both": human["rossi"]["both"],
                "largest_shortening": max(published["peak"], calcium["peak"]),
            }
        },
        "cost": {
            measured: {
                "viscosity_share": human["viscosity"]["compared"],
                "relaxing_share": human["relaxing"]["compared"],
                "rossi_share": max(published["shortening_share"], calcium["shortening_share"]),
            }
        },
        "local": {measured: {f"{key}_error": value for key, value in n["map_errors"]["BOCF"].items()}},
    }
