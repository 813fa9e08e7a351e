"""Lines of several membranes under each law, many laws at one place, and sheets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from myostrain.reproduce.chapters.settings import RIGID
from myostrain.reproduce.jobs import Job
from myostrain.reproduce.measurements.contraction import course_job

import numpy as np

BETA = 0.3
#: Membranes by what the numbers call them: the case, and what the page calls them.
MEMBRANES = {
    "FHN": ("pulse-1d", "FitzHugh–Nagumo"),
    "BOCF": ("pulse-1d-bueno", "Bueno-Orovio 2008"),
    "TTP06": ("pulse-1d-tentusscher", "ten Tusscher–Panfilov 2006"),
}
TAU = 0.2
#: λ of the viscous lines, in the unit of time of each membrane; 0.1 τ and τ for FitzHugh–Nagumo.
RELAXATION = {"FHN": (0.02, 0.2), "BOCF": (20.0, 100.0)}
#: Rise and fall times of the relaxing law.
RELAXING = {"FHN": (0.02, 0.2), "BOCF": (20.0, 100.0), "TTP06": (20.0, 100.0)}
#: α and μ of the law of Rossi and others as published, and a faster one.
ROSSI = {"rossi": (-4.0, 5000.0), "rossi fast": (-4.0, 500.0)}
THRESHOLDS = (0.05, 0.5)
#: The line: length, place, and the two between which the celerity is measured.
LINES: dict[str, tuple[float, float, tuple[float, float]]] = {
    "FHN": (60.0, 30.0, (20.0, 40.0)),
    "BOCF": (12.0, 6.0, (4.0, 8.0)),
    "TTP06": (12.0, 6.0, (4.0, 8.0)),
}
SPACINGS = {True: {"FHN": 1.0, "BOCF": 0.2, "TTP06": 0.2}, False: {"FHN": 0.5, "BOCF": 0.1, "TTP06": 0.1}}
#: Time steps, each with the time until which it is taken: short ones while the front passes.
STAGES: dict[bool, dict[str, tuple[tuple[float, float], ...]]] = {
    True: {
        "FHN": ((4e-3, 0.88), (1e-2, 2.28)),
        "BOCF": ((0.04, 18.0), (0.5, 80.0), (2.0, 600.0)),
        "TTP06": ((0.04, 18.0), (0.5, 80.0), (2.0, 600.0)),
    },
    False: {
        "FHN": ((1e-3, 0.88), (4e-3, 2.88)),
        "BOCF": ((0.02, 18.0), (0.2, 80.0), (1.0, 700.0)),
        "TTP06": ((0.02, 18.0), (0.2, 80.0), (1.0, 700.0)),
    },
}
#: The last stage of the lines whose potential the maps are made of: long enough for what is slow.
LONG = {True: {"FHN": (2e-2, 4.0), "BOCF": (2.0, 1000.0)}, False: {"FHN": (4e-3, 4.0), "BOCF": (1.0, 1000.0)}}
#: The sheet of a human membrane, in full.
SHEET = (
    'geometry={kind="rectangle", size=[16.0, 8.0], spacing=0.4}',
    "fibres={direction=[1.0, 0.0]}",
    "stimulus.box=[[0.0, 0.0], [2.0, 8.0]]",
    "material.model=NeoHookean",
    "mechanics={kinematics='plane-stress', fixed=[]}",
)


def overrides(membrane: str, quick: bool, *more: str) -> list[str]:
    """Overrides of the case of a membrane, a short line."""
    length, spacing = LINES[membrane][0], SPACINGS[quick][membrane]
    stimulus = () if membrane == "FHN" else ("stimulus.box=[[0.0], [2.0]]",)
    line = (f"geometry.length={length}", f"geometry.spacing={spacing}", "probes={}")
    return [*line, *stimulus, "output.rigid_twin=false", *more]


def line_job(membrane: str, quick: bool, *more: str, cost: float | None = None) -> Job:
    """The job that follows a place of a short line of a membrane."""
    _, watch, places = LINES[membrane]
    return course_job(
        MEMBRANES[membrane][0],
        overrides(membrane, quick, *more),
        stages=STAGES[quick][membrane],
        watch=watch,
        places=places,
        cost=cost or {"FHN": 0.7, "BOCF": 1.2, "TTP06": 1.8}[membrane] * (1 if quick else 4),
    )


def relaxing(membrane: str) -> str:
    """The override that makes a membrane's activation relax."""
    rise, fall = RELAXING[membrane]
    return f"activation={{law='relaxing', beta={BETA}, rise={rise}, fall={fall}}}"


def rossi(name: str = "rossi") -> str:
    """The override for the law of Rossi and others."""
    alpha, mu = ROSSI[name]
    return f"activation={{law='rossi-2014', alpha={alpha}, mu={mu}}}"


def map_settings(membrane: str, quick: bool) -> dict[str, Any]:
    """Parameters of the laws that the maps are made of."""
    scale = TAU / 100 if membrane == "FHN" else 1.0  # 100 ms are about as much as τ

    def times(low: float, high: float, count: int) -> list[float]:
        return (scale * np.geomspace(low, high, count)).round(6).tolist()

    few, many = (9, 10) if quick else (25, 31)
    pairs: Sequence[tuple[float, float]] = ()
    if membrane != "FHN":
        alphas = (-4.0, -20.0) if quick else (-4.0, -8.0, -16.0, -32.0)
        mus = (500.0, 5000.0) if quick else (250.0, 500.0, 1000.0, 2500.0, 5000.0, 10000.0, 20000.0)
        pairs = [(alpha, mu) for alpha in alphas for mu in mus]
    return {
        "beta": BETA,
        "relaxation": times(2.0, 200.0, 2 * many - 1),
        "rise": times(2.0, 60.0, many),
        "fall": times(20.0, 200.0, few),
        "thresholds": list(THRESHOLDS),
        "rossi": [list(pair) for pair in pairs],
        "samples": 800 if quick else 4000,
    }


def jobs(quick: bool) -> dict[str, Job]:
    """The computations."""
    made: dict[str, Job] = {}
    for membrane in ("FHN", "BOCF"):
        made[f"{membrane} at once"] = line_job(membrane, quick)
        for value in RELAXATION[membrane]:
            more = f"mechanics.relaxation_time={value}"
            made[f"{membrane} viscous {value:g}"] = line_job(membrane, quick, more)
        made[f"{membrane} relaxing"] = line_job(membrane, quick, relaxing(membrane))
        rigid = course_job(
            MEMBRANES[membrane][0],
            overrides(membrane, quick, RIGID),
            stages=(*STAGES[quick][membrane][:-1], LONG[quick][membrane]),
            watch=LINES[membrane][1],
        )
        parameters = {key: rigid.parameters[key] for key in ("case", "stages", "watch")}
        parameters |= map_settings(membrane, quick)
        made[f"{membrane} map"] = Job("contraction.mapped", parameters, 2.0 if quick else 25.0)
    for name in ("rossi",) if quick else ROSSI:
        made[f"BOCF {name}"] = line_job("BOCF", quick, rossi(name))
    made["TTP06 rossi"] = line_job("TTP06", quick, rossi())
    return made if quick else made | _sheets()


def _sheets() -> dict[str, Job]:
    """A sheet of each membrane, at once and relaxing; that of figure 3 viscous, too."""
    kinds = {"at once": (), "viscous 0.2": ("mechanics.relaxation_time=0.2",), "relaxing": (relaxing("FHN"),)}
    made = {
        f"FHN {kind}, sheet": course_job(
            "sheet-2d",
            ["geometry.spacing=2.0", "probes={}", *more],
            stages=((4e-3, 3.2),),
            watch=(65.0, 90.0),
            cost=15.0,
        )
        for kind, more in kinds.items()
    }
    for kind, more in {"at once": (), "relaxing": (relaxing("BOCF"),)}.items():
        made[f"BOCF {kind}, sheet"] = course_job(
            "pulse-1d-bueno",
            [*SHEET, "probes={}", "output.rigid_twin=false", *more],
            stages=((0.05, 22.0), (0.5, 80.0), (2.0, 600.0)),
            watch=(8.0, 4.0),
            cost=25.0,
        )
    return made
