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
MESH = {
    "size": SIZE,
    "spacing": SPACING,
    "step": STEP,
    "every": EVERY,
    "beta": BETA,
    "rise": RISE,
    "fall": FALL,
}
#: Aliev and Panfilov's membrane: conductances, and a larger square with the stimulus near a side.
FEW = (0.5, 1.0, 2.0, 3.0)
LARGE, LARGE_SPACING, LARGE_CENTER = 120.0, 1.5, (1 / 12, 0.5)
#: What is computed again at half the spacing and the step: approach and conductance.
HALVED = (("strain in plane", 2.0), ("strain in plane", 3.0), ("strain", 3.0))
#: g up to which the least one that makes a pacemaker is sought.
HIGHEST = 6.0
#: g (√C − 1) of stretches that come after an excitation, and how long they last.
DRIVES, LASTING = (0.1, 0.2, 0.5), 10.0
#: Conductances of lines with a premature stimulus, and the stimulus: rate, duration, and the half length of
#: the part of the line that gets it.
PREMATURE = {True: (0.0, 0.2), False: (0.0, 0.1, 0.2, 0.3, 0.5)}
PULSE = {"strength": 1.0, "lasting": 1.0, "half": 2.5}
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
    end = ends(quick)
    made = _lines(quick)
    for name, membrane, some in (
        ("quick", QUICK_RECOVERY, squares(quick)),
        ("slow", ALIEV_PANFILOV, slow_squares(quick)),
    ):
        made |= {
            f"{name} {approach} {g:g}": _square(membrane, approach, g, 1.5, end=end["sheet"])
            for approach, g in some
        }
        made[f"window {name}"] = Job(
            "stretched_lines.window",
            {"membrane": membrane, "drives": list(DRIVES), "duration": LASTING, "step": 0.2, "end": 60.0},
            1.5,
        )
    for g in SPIRALS[quick]:
        for approach in ("strain",) if quick else ("strain", "stress"):
            given = {**MESH, "approach": approach, "conductance": g, "end": end["spiral"]}
            made[f"spiral {approach} {g:g}"] = Job(
                "clamped_spiral.spiral", {"membrane": ALIEV_PANFILOV, **given}, 3.0 if quick else 6.0
            )
    return made if quick else made | _only_in_full(end)


def _lines(quick: bool) -> dict[str, Job]:
    """Waves along lines, and premature stimuli in their wake."""
    line = {"membrane": ALIEV_PANFILOV, "beta": BETA, "length": 60.0, "spacing": 1.0}
    rows = [(f"clamped {g:g}", g, True, 25.0 if quick else 100.0) for g in LINES]
    rows += [(f"free {g:g}", g, False, 15.0) for g in (0.0, 3.0)]
    made = {
        name: Job(
            "stretched_lines.arrival",
            {**line, "conductance": g, "clamped": clamped, "step": 0.1, "end": end},
            0.5,
        )
        for name, g, clamped, end in rows
    }
    how = {"step": 0.2, "apart": 0.4} if quick else {"step": 0.1, "apart": 0.1}
    for g in PREMATURE[quick]:
        given = {**line, **PULSE, "conductance": g, **how}
        made[f"premature {g:g}"] = Job("premature.window", given, 2.0 if quick else 10.0)
        if not quick and g in PREMATURE[True]:
            finer = {"spacing": 0.5, "step": 0.05}
            made[f"premature halved {g:g}"] = Job("premature.window", {**given, **finer}, 20.0)
    return made


def _square(membrane: dict[str, Any], approach: str, conductance: float, cost: float, **others: Any) -> Job:
    """One stimulus in a square: :data:`MESH` and a stimulus in the middle, but for the others."""
    given = {"membrane": membrane, "approach": approach, "conductance": conductance}
    return Job("clamped_sheet.sheet", {**given, **MESH, "center": [0.5, 0.5], **others}, cost)


def _only_in_full(end: dict[str, float]) -> dict[str, Job]:
    """The least conductances, the same at half the spacing and the step, and large squares."""
    made: dict[str, Job] = {}
    for approach in APPROACHES:
        given = {"membrane": QUICK_RECOVERY, "approach": approach, "highest": HIGHEST, **MESH}
        given |= {"center": [0.5, 0.5], "end": end["sheet"]}
        made[f"threshold {approach}"] = Job("clamped_sheet.threshold", given, 15.0)
    fine = {"spacing": SPACING / 2, "step": STEP / 2, "end": end["sheet"]}
    for approach, g in HALVED:
        made[f"halved {approach} {g:g}"] = _square(QUICK_RECOVERY, approach, g, 15.0, **fine)
    large = {"size": LARGE, "spacing": LARGE_SPACING, "center": list(LARGE_CENTER), "end": end["large"]}
    for approach in ("strain", "stress"):
        for g in FEW:
            made[f"large {approach} {g:g}"] = _square(ALIEV_PANFILOV, approach, g, 8.0, **large)
    return made
