"""Strips, tubes, jumps and staggered steps by either approach, on three passive laws."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.chapters.ellipticity.jobs import LAWS as ALL
from myostrain.reproduce.jobs import Job
from myostrain.reproduce.measurements.cases import case_job

import numpy as np

LAWS: dict[str, dict[str, Any]] = {
    name: ALL[name] for name in ("NeoHookean", "Guccione1995", "HolzapfelOgden2009")
}
NAMES = {
    "NeoHookean": "neo-Hookean",
    "Guccione1995": "Guccione 1995",
    "HolzapfelOgden2009": "Holzapfel–Ogden 2009",
}
#: Parameters that change together, by law.
GROUPS: dict[str, dict[str, list[str]]] = {
    "NeoHookean": {"stiffness": ["mu"]},
    "Guccione1995": {"stiffness": ["C"], "exponents": ["bf", "bt", "bfs"]},
    "HolzapfelOgden2009": {
        "stiffness": ["a", "a_f", "a_s", "a_fs"],
        "exponents": ["b", "b_f", "b_s", "b_fs"],
    },
}
DEFORMATIONS: dict[str, dict[str, Any]] = {
    "fibre": {"kind": "Fibre"},
    "transversely isotropic": {"kind": "TransverselyIsotropic"},
}
#: γ at which the approaches are compared.
GAMMA = -0.1
#: μ of the law of Rossi et al., ms μM⁻².
ROSSI_MU = 5000.0
#: The tube: radii, angles of the fibres inside and outside, volume at which it is filled over the reference.
RADII, HELIX, FILLED = (1.0, 1.5), (60.0, -60.0), 1.2
#: The volume at which wall and twist are compared.
EJECTED = 0.9
#: The clamped sheet: its mesh, the largest jump that is tried, and the steps of the way to γ.
SPACING, LARGEST, WAY = 0.25, -0.4, 10
#: Tension of the strip that answers to its length, by law: some ten moduli, or 60 kPa.
TENSIONS = {"NeoHookean": 10.0, "Guccione1995": 60.0, "HolzapfelOgden2009": 60.0}
#: Its stretch before, and slopes β: that of hunter-1998, and one as steep as at little calcium.
PRELOAD, SLOPES = 1.05, (1.45, 4.9)
#: Steps over the bound of stability.
SHARES = (0.8, 1.25)
#: Length of a step with the law of Rossi et al., ms.
ROSSI_STEP = 50.0
#: A beat: law of activation and load by approach; its step and its end, ms.
BEATS: dict[str, tuple[dict[str, Any], float]] = {
    "strain": ({"kind": "Rossi2014", "mu": 500.0}, 2.0),
    "stress": ({"kind": "Hunter1998", "tension": 100.0, "beta": 1.45}, 30.0),
}
BEAT_LAW, BEAT_STEP, BEAT_END = "Guccione1995", 0.25, 200.0

#: The ventricle of Land et al. 2015, coarse, under a small pressure; tensions match the strip of its law.
VENTRICLE = (
    "geometry.spacing=3.0",
    "fibres.helix=[60.0, -60.0]",
    "mechanics.pressure={endocardium=[[0.0, 0.0], [1.0, 0.3]]}",
    "time.step=0.1",
)
VENTRICLES = {
    "strain": 'activation={law="proportional", beta=0.1, deformation="fibre"}',
    "stress": 'activation={law="active-stress", tension=1.718675}',
    "force": 'activation={law="active-stress", tension=2.327596}',
}


def gammas(quick: bool) -> list[float]:
    """Active strains of the strip, the compared one last."""
    return np.linspace(GAMMA / 4, GAMMA, 4).tolist() if quick else np.linspace(-0.005, GAMMA, 20).tolist()


def stretches(quick: bool) -> list[float]:
    """Stretches of the force–length curves."""
    return np.linspace(0.85, 1.15, 31 if quick else 121).round(6).tolist()


def loads(quick: bool) -> list[float]:
    """Shares of the isometric force to which strips are released."""
    return np.linspace(0.0, 1.0, 11 if quick else 41).tolist()


def volumes(quick: bool) -> list[float]:
    """Volumes of the tube over the reference one."""
    return np.linspace(0.5, 1.3, 17 if quick else 65).round(6).tolist()


def jobs(quick: bool) -> dict[str, Job]:
    """The computations."""
    made: dict[str, Job] = {}
    for name, law in LAWS.items():
        strip: dict[str, Any] = {"law": law, "deformations": DEFORMATIONS, "gammas": gammas(quick)}
        strip |= {"stretches": stretches(quick), "loads": loads(quick)}
        made[f"{name} strip"] = Job("muscle.strip", strip, 1.5)
        released = {"law": law, "gamma": GAMMA, "loads": loads(quick), "mu": ROSSI_MU}
        made[f"{name} released"] = Job("muscle.followed", released, 0.5)
        sensitive = {"law": law, "deformation": DEFORMATIONS["fibre"], "gamma": GAMMA, "groups": GROUPS[name]}
        made[f"{name} sensitivity"] = Job("muscle.sensitivity", sensitive, 1.5)
        tube: dict[str, Any] = {
            "law": law,
            "deformations": DEFORMATIONS,
            "gamma": GAMMA,
            "radii": RADII,
            "helix": HELIX,
        }
        tube["volumes"] = volumes(quick)
        made[f"{name} tube"] = Job("tube.chamber", tube, 1.0 if quick else 4.0)
        jump: dict[str, Any] = {"law": law, "gamma": GAMMA, "largest": LARGEST, "steps": WAY}
        made[f"{name} jumps"] = Job("jumps.jumps", jump | {"spacing": SPACING, "solid": False}, 1.5)
        if not quick:
            solid = jump | {"spacing": 1.0, "solid": True}
            made[f"{name} jumps, solid"] = Job("jumps.jumps", solid, 20.0)
        for approach, activation in (("strain", GAMMA), ("stress", TENSIONS[name])):
            held: dict[str, Any] = {"law": law, "approach": approach, "activation": activation, "at": PRELOAD}
            steps = {"steps": 24}
            swings = held | steps | {"slopes": list(SLOPES)}
            made[f"{name} {approach} swings"] = Job("staggering.swings", swings, 1.5)
            lags = held | steps | {"slope": SLOPES[-1], "shares": list(SHARES)}
            made[f"{name} {approach} steps"] = Job("staggering.steps_of_time", lags, 1.0)
        rossi = {"law": law, "gamma": GAMMA, "at": PRELOAD, "step": ROSSI_STEP, "steps": 40}
        made[f"{name} rossi"] = Job("staggering.rossi", rossi, 0.5)
    if not quick:
        for approach, (active, load) in BEATS.items():
            beat = {"law": LAWS[BEAT_LAW], "active": active, "load": load, "step": BEAT_STEP, "end": BEAT_END}
            made[f"{approach} beat"] = Job("beats.beat", beat, 30.0)
        for approach, section in VENTRICLES.items():
            made[f"{approach} ventricle"] = case_job("land-3", (*VENTRICLE, section), cost=20.0)
    return made
