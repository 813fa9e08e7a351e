"""Energies, bumps by meshes and modes, and experiments with a homogeneous potential."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from myostrain.reproduce.chapters.settings import HELD, RIGID
from myostrain.reproduce.jobs import Job
from myostrain.reproduce.measurements.cases import case_job, resolved

#: What the three lines are called and their settings.
MODES: dict[str, list[str]] = {"coupled": [], "held": [HELD], "rigid": [RIGID]}
#: Families of the map: shape, spacing, sampling, whether there is recovery.
FAMILIES = {
    "paper": ("step", 1.0, "nodal", True),
    "fine": ("step", 0.25, "mean", True),
    "smooth": ("gaussian", 0.5, "nodal", True),
    "smooth, w = 0": ("gaussian", 0.5, "nodal", False),
}
#: The points of the maps, modes and half-widths by family, at the quick and at the full settings.
STEPS = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 10.0, 20.0, 40.0)
GRID: dict[bool, list[tuple[str, tuple[str, ...], tuple[float, ...]]]] = {
    True: [
        ("paper", ("coupled",), (1.0, 2.0, 6.0, 40.0)),
        ("paper", ("held",), (1.0, 2.0)),
        ("paper", ("rigid",), (40.0,)),
        ("fine", ("coupled", "held"), (2.0,)),
        ("smooth", ("rigid",), (3.0,)),
        ("smooth, w = 0", ("coupled",), (6.5,)),
    ],
    False: [
        ("paper", ("coupled", "held", "rigid"), STEPS),
        ("fine", ("coupled", "held", "rigid"), STEPS),
        ("smooth", ("coupled", "held", "rigid"), (2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 40.0)),
        ("smooth, w = 0", ("coupled", "rigid"), (3.0, 6.5, 20.0)),
    ],
}
#: Heights between which the thresholds are looked for, up to these half-widths.
BRACKETS: dict[str, dict[float, tuple[float, float]]] = {
    "step": {1: (0.45, 1.0), 2: (0.3, 0.5), 3: (0.22, 0.4), 4: (0.19, 0.32), 6: (0.16, 0.28),
             10: (0.14, 0.22), 40: (0.13, 0.18)},
    "gaussian": {2: (0.4, 0.7), 3: (0.3, 0.45), 5: (0.22, 0.33), 8: (0.17, 0.27), 12: (0.15, 0.23),
                 40: (0.14, 0.2)},
    "gaussian, w = 0": {3: (0.22, 0.28), 6.5: (0.15, 0.17), 20: (0.105, 0.12)},
}  # fmt: skip
#: About where the thresholds of the quick settings are: what is known already is not sought again.
GUESSES: dict[tuple[str, str, float], float] = {
    ("paper", "coupled", 1.0): 0.628,
    ("paper", "coupled", 2.0): 0.367,
    ("paper", "coupled", 6.0): 0.196,
    ("paper", "coupled", 40.0): 0.153,
    ("paper", "held", 1.0): 0.499,
    ("paper", "held", 2.0): 0.327,
    ("paper", "rigid", 40.0): 0.157,
    ("fine", "coupled", 2.0): 0.458,
    ("fine", "held", 2.0): 0.395,
    ("smooth", "rigid", 3.0): 0.354,
    ("smooth, w = 0", "coupled", 6.5): 0.1605,
}
#: The half-widths at which the region of (5.2) is drawn.
DENSE = [float(w) for w in (1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20, 24, 28, 32, 36, 40)]
#: Last intervals of the bisections, with and without recovery, at the quick and at the full settings.
TOLERANCES = {True: (6e-3, 4e-4), False: (2e-3, 1e-4)}
SPACINGS = [1.0, 0.5, 0.25, 0.125]
SCHEMES = ("second-order", "implicit", "staggered")
WEAK, LATER = 0.098, 0.14
CONTRACTION = {"strain": -0.3, "until": 0.01}
#: Experiments with a homogeneous potential: body, potential, recovery, what is done to it.
DRIVEN: dict[str, tuple[str, float, bool, dict[str, Any]]] = {
    "line contracts, v = 0": ("line", 0.0, True, CONTRACTION),
    "line let go, v = 0": ("line", 0.0, True, {"stretch": [1.3], "until": 0.01}),
    "sheet contracts, v = 0": ("sheet", 0.0, True, CONTRACTION),
    "sheet let go, v = 0": ("sheet", 0.0, True, {"stretch": [1.2, 0.9], "until": 0.01}),
    "line contracts": ("line", WEAK, True, CONTRACTION),
    "line contracts, higher": ("line", LATER, True, CONTRACTION),
    "rigid, higher": ("line", LATER, True, {}),
    "line contracts, w = 0": ("line", WEAK, False, CONTRACTION),
    "line let go, w = 0": ("line", WEAK, False, {"stretch": [1.0], "until": 0.01}),
    "rigid, w = 0": ("line", WEAK, False, {}),
    "sheet contracts": ("sheet", WEAK, True, CONTRACTION),
    "sheet let go": ("sheet", WEAK, True, {"stretch": [1.2, 0.9], "until": 0.01}),
}


def _case(
    mode: str, family: tuple[str, float, str, bool], width: float, *more: str, end: float = 0.3
) -> dict[str, Any]:
    _, spacing, sampling, recovery = family
    settings = [
        f"geometry.spacing={spacing}",
        f"geometry.length={60.0 + (width if width > 6 else 0.0)}",
        f"initial.radius={float(width)}",
        f'initial.sampling="{sampling}"',
        f"cell.recovery={str(recovery).lower()}",
        f"time.end={end if recovery else 1.0}",
        "time.scheme=second-order",
        *more,
    ]
    return resolved("startup-1d", MODES[mode] + settings)


def entries(quick: bool) -> Iterator[tuple[str, str, float]]:
    """Family, mode and half-width of every point of the maps."""
    for family, modes, widths in GRID[quick]:
        for mode in modes:
            yield from ((family, mode, width) for width in widths)


def widths_of(family: str, quick: bool) -> list[float]:
    """The half-widths of a family of the map, ascending."""
    return sorted({width for name, _, width in entries(quick) if name == family})


def _threshold_job(
    mode: str, family: tuple[str, float, str, bool], width: float, tolerance: float, *more: str, **end: float
) -> Job:
    shape, spacing, _, recovery = family
    brackets = BRACKETS[shape if recovery else f"{shape}, w = 0"]
    low, high = next(bracket for up_to, bracket in brackets.items() if width <= up_to)
    limits = {"shape": shape, "low": low, "high": high, "tolerance": tolerance}
    cost = (1.5 if spacing == 1 else 2.5) * (1 if recovery else 2) * (4 if more else 1)
    return Job("startup.threshold", {"case": _case(mode, family, width, *more, **end), **limits}, cost)


def jobs(quick: bool) -> dict[str, Job]:
    """The computations."""
    made: dict[str, Job] = {}
    settings: dict[str, Any]
    steps, end = ([4e-4, 2e-4], 0.01) if quick else ([4e-4, 2e-4, 1e-4], 0.02)
    for body in ("sheet", "line"):
        for scheme in SCHEMES:
            settings = {"body": body, "scheme": scheme, "steps": steps, "end": end}
            made[f"energy {body} {scheme}"] = Job("energy.identity", settings, 1.0 if quick else 4.0)
    for body, stretch, width in (("line", [1.3], 3.0), ("sheet", [1.2, 0.9], 5.0)):
        settings = {"body": body, "stretch": stretch, "amplitudes": [0.15, 0.3, 0.5, 0.8], "width": width}
        made[f"rate {body}"] = Job("energy.initial_rate", settings, 1.0)
    for name, (body, v, recovery, drive) in DRIVEN.items():
        settings = {"body": body, "potential": v, "recovery": recovery, "drive": drive}
        settings |= {"end": 0.2 if recovery else 1.0, "step": 1e-3}
        made[name] = Job("startup.driven", settings, 0.5)
    tolerance, closer = TOLERANCES[quick]
    for family, mode, width in entries(quick):
        limit = tolerance if FAMILIES[family][3] else closer
        job = _threshold_job(mode, FAMILIES[family], width, limit)
        if quick:
            job = replace(job, parameters={**job.parameters, "guess": GUESSES[family, mode, width]})
        made[f"{family} {mode} {width:g}"] = job
    for family, (shape, spacing, sampling, _) in FAMILIES.items():
        widths = widths_of(family, quick)
        settings = {"shape": shape, "spacing": spacing, "sampling": sampling}
        for name, chosen, contracted in (
            ("held", widths, False),
            ("coupled", widths, True),
            ("dense", DENSE, False),
        ):
            made[f"(5.2) {family} {name}"] = Job(
                "startup.satisfied", settings | {"widths": chosen, "contracted": contracted}, 0.5
            )
    made["sides"] = Job("startup.sides", {"spacings": SPACINGS, "height": 0.6, "width": 1.0}, 0.1)
    made["isochoric"] = Job("startup.isochoric", {"cells": 6, "largest": 1.3, "steps": 11}, 1.0)
    held = resolved("startup-1d", [HELD, "time.scheme=second-order"])
    made["least stretch"] = Job(
        "startup.least_stretch", {"case": held, "low": 0.7, "high": 1.0, "tolerance": tolerance}, 2.0
    )
    stretched = "mechanics.imposed_stretch={value=2.0, until=inf}"
    made["stretched"] = case_job("startup-1d", [stretched, "time.scheme=second-order"], cost=0.5)
    if not quick:
        made |= _closer_jobs()
    return made


def _closer_jobs() -> dict[str, Job]:
    """The window at a half-width of 2 over meshes; another scheme, another end."""
    made = {}
    for spacing in SPACINGS:
        for sampling in ("nodal", "mean"):
            for mode in ("coupled", "held"):
                family = ("step", spacing, sampling, True)
                made[f"window {sampling} {mode} {spacing:g}"] = _threshold_job(mode, family, 2.0, 5e-4)
    for mode, width in (("coupled", 2.0), ("held", 1.0)):
        made[f"implicit {mode} {width:g}"] = _threshold_job(
            mode, FAMILIES["paper"], width, 2e-3, "time.scheme=implicit"
        )
    for mode in MODES:
        for width in (2.0, 40.0):
            made[f"later {mode} {width:g}"] = _threshold_job(mode, FAMILIES["paper"], width, 2e-3, end=0.5)
    return made
