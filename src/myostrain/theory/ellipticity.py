"""Strong ellipticity of active bodies: the least eigenvalue of the acoustic tensor in closed form.

For an energy W(F) per reference volume the acoustic tensor of a unit vector m is Q(m)ᵢₖ = Aᵢⱼₖₗ mⱼ mₗ with
A = ∂²W/∂F∂F. The body is strongly elliptic where a·Q(m) a > 0 for all m and all amplitudes a, those with
a·F⁻ᵀm = 0 where J is kept.

**Active strain.** Let W be the energy of the passive body and Jo W(F Fo⁻¹) that of the active one, with Fo
that does not depend on F. A change a⊗m of F changes Fe by (a⊗m) Fo⁻¹ = a⊗(Fo⁻ᵀm), so that

    Q(m; F) = Jo Qe(Fo⁻ᵀm; F Fo⁻¹),    and    a·F⁻ᵀm = a·Fe⁻ᵀ(Fo⁻ᵀm):

the active body is strongly elliptic at F if, and only if, the passive one is at Fe = F Fo⁻¹, with the same
amplitudes. (D. Ambrosi, S. Pezzuto, J. Elasticity 107 (2012) 199–212, doi 10.1007/s10659-011-9351-4, ask for
the rank-one convexity of both approaches.) The neo-Hookean body, Qe = μ |m|² 1, has

    Q(m) = μ Jo |Fo⁻ᵀm|² 1,    least μ Jo/a²    with a the largest principal stretch of Fo.

**Active stress.** A tension T that gives P = T F f⊗f adds T (m·f)² 1, if it does not follow the deformation.
If it is a function of the stretch λ = |F f|, it adds T (m·f)² 1 + T′(λ)/λ (m·f)² (F f)⊗(F f) too. For the
neo-Hookean body under λ along the fibre, with J = 1 and equal sides, let x = (m·f)², k = λ³ and D = T′ λ⁴.
The amplitude a in the plane of m and f, the only one that T′ sees, has

    a·Q(m) a = μ + T x + D x (1 − x)/(k + (1 − k) x).

With y = k + (1 − k) x its derivative by x is T + D (k/y² − 1)/(1 − k), stationary at
y² = k/(1 − (1 − k) T/D).

**Fung-type laws**, W = C/2 (exp Σ b_ij E_ij² − 1), have under elastic stretches e_i along their axes, with
m along axis i and a along axis j, and g = C exp Q,

    a·Q(m) a = g/2 (b_i (e_i² − 1) + b_ij e_j²):

a compressed fibre (i = f) kinks, or a compressed sheet, where that is zero (compare J. Merodio, R. W. Ogden,
Arch. Mech. 54 (2002) 525–552). It is lost there at the latest; other m may be first.

**The line.** Its balance (2.9) conserves the potential per reference length J v, so that during a change of
J that is fast compared with diffusion v is proportional to 1/J. With γ = −β v the elastic strain is then
Fe = J/(1 + γ) with (dFe/dJ)/Fe = (1 − 2 β v)/(J (1 − β v)): the stress of the line rises with its stretch,
whatever its convex energy, as long as 2 β v < 1, which is also where its balance is forward-parabolic.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["critical_slope", "kinking_stretch", "least_with_strain", "least_with_tension", "line_answer"]

Array = NDArray[np.float64]


def least_with_strain(active: ArrayLike, mu: float = 1.0) -> Array:
    """The least eigenvalue of Q(m) over unit m of a neo-Hookean body with active strain, whatever F.

    Args:
        active: Principal stretches (a_f, a_s, a_n) of Fo along the last axis, positive.
        mu: Shear modulus μ.
    """
    a = np.asarray(active, dtype=float)
    return np.asarray(mu * a.prod(axis=-1) / a.max(axis=-1) ** 2)


def least_with_tension(
    stretch: ArrayLike, tension: ArrayLike, slope: ArrayLike = 0.0, mu: float = 1.0
) -> Array:
    """The least a·Q(m) a of an incompressible neo-Hookean body with a tension along the fibre.

    Args:
        stretch: λ along the fibre, with equal sides, positive.
        tension: T, a second Piola stress in the unit of μ.
        slope: dT/dλ where the tension follows the stretch.
        mu: Shear modulus μ.
    """
    lam, T, slope = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (stretch, tension, slope)))
    k, D = lam**3, slope * lam**4
    ends = np.minimum(0.0, T)  # x = 0 and 1
    with np.errstate(divide="ignore", invalid="ignore"):
        y = np.sqrt(k / (1 - (1 - k) * T / D))
        # At k = 1 the quotient is of zeros; there x = (1 + T/D)/2.
        x = np.where(np.abs(1 - k) > 1e-9, (y - k) / (1 - k), (1 + T / D) / 2)
        inner = T * x + D * x * (1 - x) / (k + (1 - k) * x)
    inside = (D != 0) & np.isfinite(x) & (x > 0) & (x < 1)
    return np.asarray(mu + np.where(inside, np.minimum(ends, inner), ends))


def critical_slope(tension: ArrayLike, mu: float = 1.0) -> Array:
    """The slope dT/dλ, negative, at which an unstretched incompressible neo-Hookean body is not elliptic.

    At λ = 1 the least eigenvalue is μ − (|T′| − T)²/(4 |T′|) for T′ < −|T|, zero where
    |T′| = T + 2μ + 2 √(μ (μ + T)).

    Args:
        tension: T ≥ 0 in the unit of μ.
        mu: Shear modulus μ.
    """
    T = np.asarray(tension, dtype=float)
    return np.asarray(-(T + 2 * mu + 2 * np.sqrt(mu * (mu + T))))


def kinking_stretch(along: ArrayLike, shear: ArrayLike, across: ArrayLike = 1.0) -> Array:
    """The elastic stretch e_i along an axis below which a law of Fung's type is not elliptic across it.

    Args:
        along: Exponent b_i of stretch along the axis.
        shear: Exponent b_ij of shear between it and the axis j across.
        across: Elastic stretch e_j.

    Returns:
        √(1 − e_j² b_ij/b_i); zero where that does not exist.
    """
    b, bij, e = (np.asarray(v, dtype=float) for v in (along, shear, across))
    return np.asarray(np.sqrt(np.maximum(1 - e**2 * bij / b, 0.0)))


def line_answer(activity: ArrayLike) -> Array:
    """How the elastic strain of the line answers to its stretch while J v is kept, d(ln Fe)/d(ln J).

    Args:
        activity: β v < 1, non-dimensional.
    """
    b = np.asarray(activity, dtype=float)
    return np.asarray((1 - 2 * b) / (1 - b))
