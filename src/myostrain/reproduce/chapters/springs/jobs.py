"""Springs, and (1.12) for each material, form of the stress and kind of F."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.jobs import Job

STIFFNESS, REST, ACTIVE = 1.3, 1.0, 0.7
SPREADS = (0.5, 0.1, 0.01)
SIZES = tuple(0.3 / 2**k for k in range(9))
MATERIALS: dict[str, dict[str, Any]] = {
    "neo-Hookean": {"model": "NeoHookean", "mu": 1.0},
    "Mooney–Rivlin": {"model": "MooneyRivlin", "mu": 1.0, "mu_2": 0.5},
    "linear spring": {"model": "Spring", "mu": 1.0},
}
RESIDUAL_FREE, PULLED_BACK, ENERGY_ALONE = "residual-free", "pulled back", "energy alone"
POWERS = {"linear": 1, "cubic": 3}
#: Rows of (1.12) by name: material, form of the stress, whether det F = 1. A spring has no pressure.
ROWS = {
    "neo_hookean": ("neo-Hookean", RESIDUAL_FREE, False),
    "neo_hookean_isochoric": ("neo-Hookean", RESIDUAL_FREE, True),
    "neo_hookean_pulled_back": ("neo-Hookean", PULLED_BACK, False),
    "neo_hookean_residual": ("neo-Hookean", ENERGY_ALONE, False),
    "mooney_rivlin": ("Mooney–Rivlin", RESIDUAL_FREE, False),
    "mooney_rivlin_isochoric": ("Mooney–Rivlin", RESIDUAL_FREE, True),
    "mooney_rivlin_pulled_back": ("Mooney–Rivlin", PULLED_BACK, False),
    "mooney_rivlin_residual": ("Mooney–Rivlin", ENERGY_ALONE, False),
    "spring": ("linear spring", RESIDUAL_FREE, False),
}


def jobs(quick: bool) -> dict[str, Job]:
    """The computations."""
    shared: dict[str, Any] = {"stiffness": STIFFNESS, "rest": REST, "active_length": ACTIVE}
    shared |= {"spreads": list(SPREADS), "points": 1001}
    made = {name: Job("springs.spring", {"power": m, **shared}, 0.1) for name, m in POWERS.items()}
    for key, (material, form, isochoric) in ROWS.items():
        parameters = {
            "material": MATERIALS[material],
            "form": form,
            "isochoric": isochoric,
            "seed": 2011,
            "directions": directions(quick),
            "sizes": list(SIZES),
        }
        made[key] = Job("springs.small_strains", parameters, 0.1 if quick else 0.5)
    return made


def directions(quick: bool) -> int:
    """How many random directions there are."""
    return 250 if quick else 2000
