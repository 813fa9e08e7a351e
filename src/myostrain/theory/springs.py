"""A spring that contracts, by active stress and by active strain: section 1.1 of the paper, (1.7)–(1.10).

The paper is D. Ambrosi, G. Arioli, F. Nobile, A. Quarteroni, SIAM J. Appl. Math. 71(2), 2011,
doi 10.1137/100788379.  A spring of rest length ℓo carries the force k (ℓ − ℓo)^m, m = 1 for the linear one
and m = 3 for the cubic one.  Active stress adds a force f_a to that, active strain makes the rest length ℓa:

    active stress   (1.7), (1.9):    k (ℓ − ℓo)^m + f_a = f
    active strain   (1.8), (1.10):   k (ℓ − ℓa)^m       = f

They agree at a length ℓ if f_a = k ((ℓ − ℓa)^m − (ℓ − ℓo)^m), which is −k (ℓa − ℓo) whatever ℓ for m = 1, and

    −k δ (3 e² − 3 e δ + δ²),   e = ℓ − ℓo,   δ = ℓa − ℓo,

for m = 3: a parabola in ℓ.  Everything is non-dimensional, as in the paper.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["active_strain_force", "active_stress_force", "equivalent_active_force"]

Array = NDArray[np.float64]


def active_stress_force(
    length: ArrayLike, rest: ArrayLike, active_force: ArrayLike, *, stiffness: float = 1.0, power: int = 1
) -> Array:
    """Force f of a spring with active stress, (1.7) for the linear and (1.9) for the cubic one.

    Args:
        length: Length ℓ.
        rest: Rest length ℓo.
        active_force: Active force f_a.
        stiffness: Stiffness k > 0.
        power: m, odd: 1 for the linear spring, 3 for the cubic one.

    Returns:
        f, in the shape to which the arguments broadcast.

    Raises:
        ValueError: The stiffness is not positive, or the power not odd.
    """
    _check(stiffness, power)
    strain = np.asarray(length, dtype=float) - np.asarray(rest, dtype=float)
    return np.asarray(stiffness * strain**power + np.asarray(active_force, dtype=float))


def active_strain_force(
    length: ArrayLike, active_length: ArrayLike, *, stiffness: float = 1.0, power: int = 1
) -> Array:
    """Force f of a spring with active strain, (1.8) for the linear and (1.10) for the cubic one.

    Args:
        length: Length ℓ.
        active_length: Length ℓa that the active spring takes without a load.
        stiffness: As in `active_stress_force`, and so the next one and the errors.
        power: As there.

    Returns:
        f, in the shape to which the arguments broadcast.
    """
    return active_stress_force(length, active_length, 0.0, stiffness=stiffness, power=power)


def equivalent_active_force(
    length: ArrayLike, rest: ArrayLike, active_length: ArrayLike, *, stiffness: float = 1.0, power: int = 1
) -> Array:
    """Active force f_a with which (1.7) and (1.8), or (1.9) and (1.10), give the same force at ``length``.

    It is −k (ℓa − ℓo) at any length for the linear spring, and depends on the length for the cubic one.

    Args:
        length: Length ℓ.
        rest: Rest length ℓo.
        active_length: Length ℓa that the active spring takes without a load.
        stiffness: As in `active_stress_force`, and so the next one and the errors.
        power: As there.

    Returns:
        f_a, in the shape to which the arguments broadcast.
    """
    passive = active_stress_force(length, rest, 0.0, stiffness=stiffness, power=power)
    return active_strain_force(length, active_length, stiffness=stiffness, power=power) - passive


def _check(stiffness: float, power: int) -> None:
    if not stiffness > 0:
        raise ValueError(f"stiffness = {stiffness} must be positive")
    if not (power > 0 and power % 2 == 1):
        raise ValueError(f"power = {power} must be odd and positive: an even one pulls and pushes alike")
