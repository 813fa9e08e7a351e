"""Each passive law over activation and deformation, activations that follow the stretch, and a slab."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.jobs import Job

import numpy as np

LAWS: dict[str, dict[str, Any]] = {
    "NeoHookean": {"model": "NeoHookean", "mu": 1.0},
    "MooneyRivlin": {"model": "MooneyRivlin", "mu": 1.0, "mu_2": 0.5},
    "Guccione1995": {"model": "Guccione1995", "C": 2.0, "bf": 8.0, "bt": 2.0, "bfs": 4.0},
    "Usyk2002": {
        "model": "Usyk2002",
        "C": 0.88,
        "bff": 8.0,
        "bss": 6.0,
        "bnn": 3.0,
        "bfs": 12.0,
        "bfn": 3.0,
        "bns": 3.0,
    },
    "HolzapfelOgden2009": {
        "model": "HolzapfelOgden2009",
        "a": 0.059,
        "b": 8.023,
        "a_f": 18.472,
        "b_f": 16.026,
        "a_s": 2.481,
        "b_s": 11.12,
        "a_fs": 0.216,
        "b_fs": 11.436,
        "switch": 0.01,
    },
}
#: Laws whose energy is a polynomial, polyconvex, and the exponential ones.
POLYNOMIAL, EXPONENTIAL = list(LAWS)[:2], list(LAWS)[2:]
DEFORMATIONS: dict[str, dict[str, Any]] = {
    "fibre": {"kind": "Fibre"},
    "transversely isotropic": {"kind": "TransverselyIsotropic"},
    "orthotropic": {"kind": "Orthotropic", "kappa": 0.5},
}
APPROACHES = [*DEFORMATIONS, "tension"]
FAMILIES = ("uniaxial", "plane", "shear")
#: γ at which borders are compared.
JUDGED = -0.3
SEED = 16
#: T/μ at which the critical slope is sought.
TENSIONS = (0.5, 1.0, 3.0)
#: The slab: κ over the modulus, and γ.
BULK, SLAB_GAMMA = 100.0, -0.2
SLAB_LAW = "Guccione1995"
#: Slope of the fibres' tilt where it is squeezed step by step.
TILT = 0.05
#: Its border by the acoustic tensor, roughly, by approach.
SLAB_BORDERS = {"passive": 0.7071, "strain": 0.5657, "tension": 0.6385}
#: λ of the slab over that border.
SHARES = {True: (1.01, 0.98, 0.95, 0.92, 0.89), False: tuple(np.linspace(1.03, 0.89, 15).tolist())}
SPACINGS = {True: (0.25, 0.125), False: (0.25, 0.125, 1 / 12)}


def gammas(quick: bool) -> list[float]:
    """Active strains of the maps."""
    return np.linspace(-0.4, 0.1, 11 if quick else 26).round(6).tolist()


def grids(quick: bool) -> dict[str, list[float]]:
    """Stretches and shears of the maps."""
    count = 25 if quick else 61
    stretches, shears = np.linspace(0.4, 1.6, count), np.linspace(0.0, 1.2, count)
    return {family: (shears if family == "shear" else stretches).tolist() for family in FAMILIES}


def calcium(quick: bool) -> list[float]:
    """Calcium of the maps of activations that follow the stretch, μM."""
    return np.linspace(0.25, 1.4, 24 if quick else 47).tolist()


def followed(quick: bool) -> list[float]:
    """Stretches of those maps, within the range of the force–length curve."""
    return np.linspace(0.9, 1.32, 22 if quick else 85).tolist()


def jobs(quick: bool) -> dict[str, Job]:
    """The computations."""
    made = {"limits": Job("ellipticity.limits", {"tensions": list(TENSIONS)}, 0.5)}
    shared = {"deformations": DEFORMATIONS, "gammas": gammas(quick), "grids": grids(quick), "seed": SEED}
    shared["samples"] = 150 if quick else 1000
    for name, law in LAWS.items():
        made[name] = Job("ellipticity.examined", {"law": law, **shared}, 3.0 if quick else 15.0)
        parameters = {"law": law, "calcium": calcium(quick), "stretches": followed(quick)}
        made[f"{name} following"] = Job("ellipticity.following", parameters, 1.0 if quick else 6.0)
        if not quick:
            compressible = {"law": law, **shared, "bulk_modulus": BULK}
            made[f"{name} compressible"] = Job("ellipticity.examined", compressible, 30.0)
    for approach, border in SLAB_BORDERS.items():
        made[f"slab {approach}"] = Job(
            "slab_stability.stability",
            {
                "law": LAWS[SLAB_LAW],
                "approach": approach,
                "gamma": SLAB_GAMMA,
                "spacings": list(SPACINGS[quick]),
                "stretches": [share * border for share in SHARES[quick]],
                "bulk_modulus": BULK,
            },
            4.0 if quick else 60.0,
        )
        made[f"run {approach}"] = Job(
            "slab_stability.squeezed_on",
            {
                "law": LAWS[SLAB_LAW],
                "approach": approach,
                "gamma": SLAB_GAMMA,
                "spacings": list(SPACINGS[quick]),
                "stretches": np.linspace(1.0, 0.55, 10 if quick else 19).tolist(),
                "bulk_modulus": BULK,
                "tilt": TILT,
            },
            4.0 if quick else 30.0,
        )
    return made
