"""The thickness of a plane-stress sheet at a loaded edge, recovered from the balance of forces there."""

from __future__ import annotations

from typing import Any

from myostrain.engine import fem
from myostrain.mechanics.active_body import ActiveBody

import ufl


def thickness_factor(active: ActiveBody, u: fem.Function, a: Any, N: Any, p: Any, others: Any) -> Any:
    """By what to multiply the thickness λ₃ of a cell at its edge, where a pressure acts.

    λ₃ = J/det F₂ of linear elements is that of the cell's centre, O(h) off at the edge, and so would be the
    force p λ₃ per length there. Of F₂ at the edge only the derivative along the normal is unknown, F₂ + b⊗N,
    since that along the edge is exact to O(h²) at its middle. One step of Newton's method for the balance at
    the edge, P(F₂ + b⊗N) N = −p λ₃ cof F₂ N + t, gives b to O(h²), and the factor 1/(1 + s) with
    s = b·F₂⁻ᵀN; as exp(−s) it is positive whatever Newton's method tries on its way.

    Args:
        active: The equations of the body.
        u: The unknown.
        a: The activation.
        N: Outward normal.
        p: The pressure.
        others: What else acts there, t per reference area.
    """
    kinematics = active.kinematics
    F = active.gradient(u)
    G, Jo = ufl.variable(F), ufl.det(active.active(a))
    lifted = kinematics.lift(G, Jo)
    piola = ufl.diff(active.stored(lifted, a), G)
    cofactor = ufl.det(G) * ufl.inv(G).T
    residual = piola * N + p * lifted[2, 2] * cofactor * N - others
    i, j, k = ufl.indices(3)
    tangent = ufl.as_tensor(ufl.diff(residual, G)[i, k, j] * N[j], (i, k))
    b = -ufl.inv(tangent) * residual
    return ufl.exp(-ufl.dot(b, ufl.inv(F).T * N))
