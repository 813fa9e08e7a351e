"""Blocks of a neo-Hookean solid with active strain: (3.1)–(3.8) where nothing varies.

The paper is D. Ambrosi, G. Arioli, F. Nobile, A. Quarteroni, SIAM J. Appl. Math. 71(2), 2011,
doi 10.1137/100788379.  Let f, s, n be orthogonal axes of the block, the fibre and two across it, and let
active deformation and deformation be diagonal in them, Fo = diag(a_f, a_s, a_n) and F = diag(λ_f, λ_s, λ_n).
The energy per reference volume is Jo W(F Fo⁻¹) with Jo = a_f a_s a_n, that is

    μ/2 Jo (λ_f²/a_f² + λ_s²/a_s² + λ_n²/a_n² − 3)    under    λ_f λ_s λ_n = J,

where J = 1 (3.8), or J = Jo where the elastic part is isochoric. Its least value, with all sides free, is at

    λ_i = a_i (J/Jo)^{1/3},

which for Fo = 1 + γ f⊗f and J = 1 is (1 + γ)^{2/3} along the fibre. With λ_f = λ given and both sides free,
λ_s/a_s = λ_n/a_n, and what is left is the energy of λ alone, whose derivative is the first Piola stress

    P = μ Jo (λ/a_f² − J/(λ² a_s a_n)).

At λ = 1 it is the isometric stress. Between rigid plates across n, λ_n = 1, it is

    P = μ Jo (λ/a_f² − J²/(λ³ a_s²)).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["active_stretches", "free_stretches", "uniaxial_stress"]

Array = NDArray[np.float64]


def active_stretches(gamma: ArrayLike, kappa: float | None = None) -> Array:
    """Stretches (a_f, a_s, a_n) of the active deformation for the active strain γ along the fibre.

    Args:
        gamma: γ > −1, non-dimensional.
        kappa: None for Fo = 1 + γ f⊗f (1.4); else the share κ of :class:`myostrain.activation.Orthotropic`,
            with det Fo = 1: κ = 1 is the same in all directions across the fibre.

    Returns:
        The three stretches, along a new last axis.

    Raises:
        ValueError: One of them is not positive.
    """
    along = 1 + np.asarray(gamma, dtype=float)
    if kappa is None:
        normal = sheet = np.ones_like(along)
    else:
        with np.errstate(invalid="ignore", divide="ignore"):
            normal = 1 + kappa * (along**-0.5 - 1)
            sheet = 1 / (along * normal)
    stretches = np.stack([along, sheet, normal], axis=-1)
    _check(stretches, "active stretches")
    return stretches


def free_stretches(active: ArrayLike, volume: ArrayLike = 1.0) -> Array:
    """Stretches (λ_f, λ_s, λ_n) of a free block, which is without stress.

    They are those of each isotropic material, and of every material where J = Jo, since Fe is a multiple of
    the unit tensor, or the unit tensor itself.

    Args:
        active: (a_f, a_s, a_n) along the last axis, positive.
        volume: J, positive.

    Returns:
        The three stretches, in the shape of ``active``.

    Raises:
        ValueError: A stretch or a volume is not positive.
    """
    a, J = np.asarray(active, dtype=float), np.asarray(volume, dtype=float)
    _check(a, "active stretches")
    _check(J, "the volume")
    return np.asarray(a * np.cbrt(J / np.prod(a, axis=-1))[..., None])


def uniaxial_stress(
    stretch: ArrayLike, active: ArrayLike, volume: ArrayLike = 1.0, *, mu: float = 1.0, plates: bool = False
) -> Array:
    """First Piola stress along the fibre of a block that is held at the stretch λ along it.

    Args:
        stretch: λ, positive; 1 gives the isometric stress.
        active: (a_f, a_s, a_n) along the last axis, positive.
        volume: J, positive.
        mu: Shear modulus μ.
        plates: Whether rigid plates keep λ_n = 1; else both sides are free.

    Returns:
        P in the unit of μ, in the shape to which the arguments broadcast.

    Raises:
        ValueError: A stretch or a volume is not positive.
    """
    lam, a = np.asarray(stretch, dtype=float), np.asarray(active, dtype=float)
    J = np.asarray(volume, dtype=float)
    for values, what in ((lam, "the stretch"), (a, "active stretches"), (J, "the volume")):
        _check(values, what)
    a_f, a_s, a_n = a[..., 0], a[..., 1], a[..., 2]
    passive = J**2 / (lam**3 * a_s**2) if plates else J / (lam**2 * a_s * a_n)
    return np.asarray(mu * a_f * a_s * a_n * (lam / a_f**2 - passive))


def _check(values: Array, what: str) -> None:
    if not np.all(values > 0):
        raise ValueError(f"{what} = {values} must be positive")
