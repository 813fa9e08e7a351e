"""Active stress, the other approach to activation."""

from typing import Any

from myostrain.activation.coefficient import PositiveCoefficient
from myostrain.validation import NonNegative, description

import ufl


@description
class ActiveStress:
    """A tension along the fibre, in place of an active strain: P = F S, S = Ta (f0⊗f0 + η (1 − f0⊗f0)).

    With η = 0 and Ta = 60 kPa it is that of the third problem of S. Land and others, Proc. R. Soc. A 471
    (2015) 20150641, doi 10.1098/rspa.2015.0641; the part across the fibre is that of, for instance,
    fenicsx-pulse. The stress is the derivative of the energy per reference volume, with I₁ = tr FᵀF and
    I₄f = f0·FᵀF f0,

    Ta/2 [(I₄f − 1) + η (I₁ − I₄f − 2)].

    It takes F itself, not Fe, also beside an active strain. The tension is Ta = T max(v, 0): the undershoot
    of the potential does not push. A tension that is given in time is a uniform v, given in time.

    Args:
        tension: T, the tension at v = 1, a pressure, positive. In a script also a UFL scalar on the body's
            mesh: a field, or a :class:`dolfinx.fem.Constant` that the script changes.
        transverse: Share η of the tension across the fibre, zero or more.
    """

    tension: PositiveCoefficient = 1.0
    transverse: NonNegative = 0.0

    def energy(self, F: Any, fibres: Any, v: Any) -> Any:
        """Energy per reference volume that gives the active stress, for F in the dimension of materials.

        Args:
            F: Deformation gradient (3 × 3, or 1 × 1 on a line), UFL.
            fibres: Has the unit direction ``f0``, a UFL vector.
            v: Potential, a UFL scalar.
        """
        stretched = F * fibres.f0
        along = ufl.dot(stretched, stretched)
        across = ufl.inner(F, F) - along
        dim = len(fibres.f0)
        tension = self.tension * ufl.max_value(v, 0.0)
        return tension / 2 * ((along - 1) + self.transverse * (across - (dim - 1)))
