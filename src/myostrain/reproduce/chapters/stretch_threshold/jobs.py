"""Bodies without a stretch current; lines with one, stretched at once, slowly, briefly, or in part."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.jobs import Job

import numpy as np

#: Membranes, with steps and times in their units, and the conductances that are looked at.
MEMBRANES: dict[str, dict[str, Any]] = {
    "AlievPanfilov1996": {
        "conductances": (0.5, 1.0, 1.5, 2.0, 3.0),
        "step": 0.1,
        "end": 80.0,
        "highest": 2.0,
    },
    "FitzHughNagumo": {"conductances": (0.5, 1.0, 1.5, 2.0, 3.0), "step": 1e-3, "end": 0.6, "highest": 8.0},
    "MitchellSchaeffer2003": {"conductances": (0.01, 0.03, 0.1), "step": 0.5, "end": 600.0, "highest": 1.2},
}
#: At quick settings.
FEW = {"AlievPanfilov1996": (1.0, 3.0), "FitzHughNagumo": (1.0, 3.0), "MitchellSchaeffer2003": (0.03,)}
#: The membrane that is examined further, and its conductance.
EXAMINED, CONDUCTANCE = {"model": "AlievPanfilov1996"}, 1.0
#: λ of bodies without a stretch current.
STRETCH = 1.5
#: Without a stretch current: membranes, and a step in their units.
WITHOUT = {"FitzHughNagumo": 2e-3, "AlievPanfilov1996": 0.1, "BuenoOrovio2008": 0.1}
#: λ − 1 up to which slow and brief stretches are looked for.
HIGHEST = {True: 0.3, False: 1.0}
#: g (λ − 1) of the largest held stretch.
LARGEST = 2.0


def times(way: str, quick: bool) -> list[float]:
    """Of ramps, or for which a line is held."""
    if way == "ramp":
        return [5.0, 40.0] if quick else [1.0, 5.0, 10.0, 20.0, 40.0]
    return [1.0, 5.0] if quick else [0.5, 1.0, 2.0, 5.0, 10.0, 20.0]


def halves(quick: bool) -> list[float]:
    """Half lengths of the part of a line that has the current."""
    return [1.0, 6.0] if quick else [1.0, 1.5, 2.0, 3.0, 6.0]


def jobs(quick: bool) -> dict[str, Job]:
    """The computations."""
    made: dict[str, Job] = {}
    for name, given in MEMBRANES.items():
        parameters = {
            **given,
            "membrane": {"model": name},
            "conductances": list(FEW[name] if quick else given["conductances"]),
            "reversal": 1.0,
            "span": 1.0,
            "step": 2 * given["step"] if quick else given["step"],
            "tolerance": 6e-3 if quick else 1e-3,
        }
        made[name] = Job("stretch_threshold.thresholds", parameters, 2.0 if quick else 15.0)
    for name, step in WITHOUT.items():
        for balance in ("conservative", "advective"):
            steps = 10 if quick else 400
            without = {"membrane": {"model": name}, "balance": balance, "stretch": STRETCH}
            made[f"{name} {balance}"] = Job(
                "stretch_threshold.unexcited", {**without, "step": step, "end": step * steps}, 0.5
            )
    finely = {"membrane": EXAMINED, "step": 0.25 if quick else 0.1}
    for way in ("ramp", "brief"):
        made[way] = Job(
            "stretch_threshold.slow",
            {
                **finely,
                "conductance": CONDUCTANCE,
                "times": times(way, quick),
                "way": way,
                "highest": HIGHEST[quick],
                "end": 40.0,
                "tolerance": 0.05 if quick else 3e-3,
            },
            2.5 if quick else 50.0,
        )
    made["segments"] = Job(
        "stretch_threshold.segments",
        {
            **finely,
            "halves": halves(quick),
            "length": 15.0,
            "spacing": 1.0 if quick else 0.25,
            "diffusivity": 1.0,
            "highest": 4.0,
            "end": 40.0,
            "tolerance": 0.06 if quick else 5e-3,
        },
        2.0 if quick else 60.0,
    )
    drives = np.geomspace(0.03, LARGEST, 25 if quick else 100).round(6).tolist()
    made["held"] = Job("stretch_threshold.held_on", {**finely, "drives": drives, "end": 200.0}, 1.0)
    return made
