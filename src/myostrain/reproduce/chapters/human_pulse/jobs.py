"""The pulse of figure 1 on short lines of human membranes, at once and late, free and held."""

from __future__ import annotations

from myostrain.reproduce.chapters.delay.jobs import (
    BETA,
    LINES,
    MEMBRANES,
    SPACINGS,
    STAGES,
    line_job,
    overrides,
    relaxing,
    rossi,
)
from myostrain.reproduce.chapters.settings import ADVECTIVE, RIGID
from myostrain.reproduce.jobs import Job
from myostrain.reproduce.measurements.cases import resolved
from myostrain.reproduce.measurements.contraction import course_job

#: Membranes by what the numbers call them, and what the page calls them.
HUMAN = {name: MEMBRANES[name][1] for name in ("BOCF", "TTP06")}
#: How the activation follows, and the balance: what the page calls it.
KINDS = {
    "rigid": "rigid",
    "conservative": "at once, conservative as printed",
    "advective": "at once, advective",
    "relaxing": "relaxing, conservative",
    "relaxing advective": "relaxing, advective",
    "rossi": "Rossi 2014, conservative",
}
#: Rise times of the sweep, ms.
QUICK_RISES = (0.2, 0.6, 3.0, 10.0)
RISES = (0.03, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0)
#: The held line: its length, and the places between which its front is measured.
HELD, FAR = 24.0, (18.0, 21.0)
HELD_STAGES = {True: ((0.04, 36.0),), False: ((0.02, 36.0),)}
BOTH_ENDS = "mechanics.fixed=['left', 'right']"
#: A finer mesh, in full, and the step there.
FINE, FINE_STEP = 0.05, 0.01


def rises(quick: bool) -> tuple[float, ...]:
    """Rise times of the sweep, ms."""
    return QUICK_RISES if quick else RISES


def settings(kind: str, membrane: str) -> tuple[str, ...]:
    """What a kind of line changes in the case of a membrane."""
    made: dict[str, tuple[str, ...]] = {
        "rigid": (RIGID,),
        "conservative": (),
        "advective": (ADVECTIVE,),
        "relaxing": (relaxing(membrane),),
        "relaxing advective": (relaxing(membrane), ADVECTIVE),
        "rossi": (rossi(),),
    }
    return made[kind]


def jobs(quick: bool) -> dict[str, Job]:
    """The computations; some of the lines are those of the chapter on delay, too."""
    made = {f"{m} {kind}": line_job(m, quick, *settings(kind, m)) for m in HUMAN for kind in KINDS}
    sweeps: dict[str, tuple[str, ...]] = (
        {"conservative": ()} if quick else {"conservative": (), "advective": (ADVECTIVE,)}
    )
    for balance, more in sweeps.items():
        for rise in rises(quick):
            law = f"activation={{law='relaxing', beta={BETA}, rise={rise}, fall=100.0}}"
            made[f"{balance} rise {rise}"] = _front(quick, law, *more)
    length = f"geometry.length={HELD}"
    for name, law in {"held": relaxing("BOCF"), "held at once": f"activation.beta={BETA}"}.items():
        made[name] = course_job(
            MEMBRANES["BOCF"][0],
            overrides("BOCF", quick, length, BOTH_ENDS, law),
            stages=HELD_STAGES[quick],
            watch=FAR[0],
            places=FAR,
            cost=1.2 if quick else 5.0,
        )
    if not quick:
        for m in HUMAN:
            for kind in ("rigid", "conservative", "advective", "relaxing"):
                made[f"{m} {kind}, fine"] = course_job(
                    MEMBRANES[m][0],
                    overrides(m, quick, f"geometry.spacing={FINE}", *settings(kind, m)),
                    stages=((FINE_STEP, 18.0),),
                    watch=LINES[m][1],
                    places=LINES[m][2],
                    cost=8.0,
                )
    return made


def _front(quick: bool, *more: str) -> Job:
    """A line that is followed until the front has passed."""
    return course_job(
        MEMBRANES["BOCF"][0],
        overrides("BOCF", quick, *more),
        stages=STAGES[quick]["BOCF"][:1],
        watch=LINES["BOCF"][1],
        places=LINES["BOCF"][2],
        cost=0.7 if quick else 2.5,
    )


def diffusivity() -> float:
    """D of the line of the sweep, mm²/ms."""
    return float(resolved(MEMBRANES["BOCF"][0])["potential"]["diffusivity"])


def spacing(quick: bool) -> float:
    """Δx of the lines, mm."""
    return SPACINGS[quick]["BOCF"]
