"""A tension along the fibre, and a share of it across."""

from typing import Any

from myostrain.validation import NonNegative, description

import ufl


@description
class FibreTension:
    """P = F S with S = Ta (f0⊗f0 + η (1 − f0⊗f0)), beside the passive stress.

    The active stress of S. Land and others, Proc. R. Soc. A 471 (2015) 20150641,
    doi 10.1098/rspa.2015.0641 (η = 0); the part across the fibre is that of, for instance, fenicsx-pulse.
    It is the derivative of the energy per reference volume, with I₁ = tr FᵀF and I₄f = f0·FᵀF f0,

    Ta/2 [(I₄f − 1) + η (I₁ − I₄f − 2)].

    Args:
        transverse: Share η of the tension across the fibre, zero or more.
    """

    transverse: NonNegative = 0.0

    def energy(self, F: Any, fibres: Any, tension: Any) -> Any:
        """Energy per reference volume that gives the active stress.

        Args:
            F: Deformation gradient (3 × 3, or 1 × 1 on a line), UFL.
            fibres: Has the unit direction ``f0``, a UFL vector.
            tension: Ta, a UFL scalar.
        """
        stretched = F * fibres.f0
        along = ufl.dot(stretched, stretched)
        across = ufl.inner(F, F) - along
        dim = len(fibres.f0)
        return tension / 2 * ((along - 1) + self.transverse * (across - (dim - 1)))
