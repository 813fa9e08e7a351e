"""Lines and squares with a stretch current, clamped: waves, pacemakers, re-excitation, spirals."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.jobs import Job

ALIEV_PANFILOV = {"model": "AlievPanfilov1996"}
QUICK_RECOVERY = {"model": "QuickRecovery"}
#: Contraction at full excitation, and its time constants while excited and after.
BETA, RISE, FALL = 0.3, 10.0, 1.0
#: Conductances of the lines.
LINES = (0.0, 0.5, 1.0, 2.0, 3.0)
#: Squares with the membrane that recovers quickly, full and quick: approaches and conductances.
APPROACHES = (
    "strain",
    "stress",
    "stress, held",
    "strain in plane",
    "stress in plane",
    "stress, held in plane",
)
CONDUCTANCES = (0.0, 1.0, 1.5, 2.0, 2.5, 3.0)
JUDGED = {
    "strain": (3.0,),
    "strain in plane": (2.0, 3.0),
    "stress in plane": (2.0,),
    "stress, held in plane": (2.0,),
}
#: Side of the square, spacing, step, steps between solves of mechanics.
SIZE, SPACING, STEP, EVERY = 60.0, 1.0, 0.2, 5
#: Aliev and Panfilov's membrane: conductances, and a larger square with the stimulus near a side.
FEW = (0.5, 1.0, 2.0, 3.0)
LARGE, LARGE_SPACING, LARGE_CENTER = 120.0, 1.5, (1 / 12, 0.5)
#: What is computed again at half the spacing and the step: approach and conductance.
HALVED = (("strain in plane", 2.0), ("strain in plane", 3.0), ("strain", 3.0))
#: g up to which the least one that makes a pacemaker is sought.
HIGHEST = 6.0
#: g (√C − 1) of stretches that come after an excitation, and how long they last.
DRIVES, LASTING = (0.1, 0.2, 0.5), 10.0
#: Conductances of the spirals.
SPIRALS = {True: (0.0, 0.5, 1.0), False: (0.0, 0.1, 0.25, 0.5, 1.0, 2.0, 3.0)}


def ends(quick: bool) -> dict[str, float]:
    """When computations end: pacemakers, the large square, spirals."""
    return (
        {"sheet": 60.0, "large": 300.0, "spiral": 160.0}
        if quick
        else {"sheet": 150.0, "large": 300.0, "spiral": 250.0}
    )


def squares(quick: bool) -> list[tuple[str, float]]:
    """Approaches and conductances of the squares with quick recovery."""
    if quick:
        return [(approach, g) for approach, some in JUDGED.items() for g in some]
    return [(approach, g) for approach in APPROACHES for g in CONDUCTANCES]


def slow_squares(quick: bool) -> list[tuple[str, float]]:
    """The same with Aliev and Panfilov's membrane."""
    return [("strain", 3.0)] if quick else [(a, g) for a in ("strain", "stress") for g in FEW]


def jobs(quick: bool) -> dict[str, Job]:
    """The computations."""
    contraction = {"beta": BETA, "rise": RISE, "fall": FALL}
    line = {"membrane": ALIEV_PANFILOV, "beta": BETA, "length": 60.0, "spacing": 1.0, "step": 0.1}
    made = {
        f"clamped {g:g}": Job(
            "stretch_feedback.arrival",
            {**line, "conductance": g, "clamped": True, "end": 25.0 if quick else 100.0},
            0.5,
        )
        for g in LINES
    }
    for g in (0.0, 3.0):
        made[f"free {g:g}"] = Job(
            "stretch_feedback.arrival", {**line, "conductance": g, "clamped": False, "end": 15.0}, 0.5
        )
    mesh = {
        "size": SIZE,
        "spacing": SPACING,
        "step": STEP,
        "every": EVERY,
        "center": [0.5, 0.5],
        **contraction,
    }
    end = ends(quick)
    for approach, g in squares(quick):
        given = {
            "membrane": QUICK_RECOVERY,
            "approach": approach,
            "conductance": g,
            **mesh,
            "end": end["sheet"],
        }
        made[f"quick {approach} {g:g}"] = Job("stretch_feedback.sheet", given, 1.5)
    for approach, g in slow_squares(quick):
        given = {
            "membrane": ALIEV_PANFILOV,
            "approach": approach,
            "conductance": g,
            **mesh,
            "end": end["sheet"],
        }
        made[f"slow {approach} {g:g}"] = Job("stretch_feedback.sheet", given, 1.5)
    for name, membrane in (("slow", ALIEV_PANFILOV), ("quick", QUICK_RECOVERY)):
        made[f"window {name}"] = Job(
            "stretch_feedback.window",
            {"membrane": membrane, "drives": list(DRIVES), "duration": LASTING, "step": 0.2, "end": 60.0},
            1.5,
        )
    tip = {**mesh, "membrane": ALIEV_PANFILOV, "end": end["spiral"]}
    del tip["center"]
    for g in SPIRALS[quick]:
        for approach in ("strain",) if quick else ("strain", "stress"):
            made[f"spiral {approach} {g:g}"] = Job(
                "stretch_feedback.spiral",
                {**tip, "approach": approach, "conductance": g},
                3.0 if quick else 6.0,
            )
    if not quick:
        made |= _only_in_full(mesh, contraction, end)
    return made


def _only_in_full(mesh: dict[str, Any], contraction: dict[str, Any], end: dict[str, float]) -> dict[str, Job]:
    made: dict[str, Job] = {}
    for approach in APPROACHES:
        given = {
            "membrane": QUICK_RECOVERY,
            "approach": approach,
            "highest": HIGHEST,
            **mesh,
            "end": end["sheet"],
        }
        made[f"threshold {approach}"] = Job("stretch_feedback.threshold", given, 15.0)
    fine = {**mesh, "spacing": SPACING / 2, "step": STEP / 2}
    for approach, g in HALVED:
        given = {
            "membrane": QUICK_RECOVERY,
            "approach": approach,
            "conductance": g,
            **fine,
            "end": end["sheet"],
        }
        made[f"halved {approach} {g:g}"] = Job("stretch_feedback.sheet", given, 15.0)
    large = {
        **contraction,
        "size": LARGE,
        "spacing": LARGE_SPACING,
        "step": STEP,
        "every": EVERY,
        "center": list(LARGE_CENTER),
    }
    for approach in ("strain", "stress"):
        for g in FEW:
            given = {
                "membrane": ALIEV_PANFILOV,
                "approach": approach,
                "conductance": g,
                **large,
                "end": end["large"],
            }
            made[f"large {approach} {g:g}"] = Job("stretch_feedback.sheet", given, 8.0)
    return made
