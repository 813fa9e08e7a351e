"""Isochoric active deformation that differs along and across the sheets."""

from typing import Any

from myostrain.activation.coefficient import Coefficient
from myostrain.directions import with_sheets
from myostrain.validation import description

import ufl


@description
class Orthotropic:
    """Fo = 1 + γ f⊗f + γ_s s⊗s + γ_n n⊗n with γ_n = κ ((1 + γ)^(−1/2) − 1) and γ_s from det Fo = 1.

    κ is how much of an isochoric cell's own thickening appears along the sheet's normal n0; the sheet
    direction s0, which points through the wall in rule-based ventricles, takes the rest: κ = 1 is
    :class:`TransverselyIsotropic`, with κ = 0 all thickening is along s0, with κ < 0 the normal shortens
    too, as sheets slide. Fo is admissible while 1 + γ_n > 0, that is for every γ where 0 ≤ κ ≤ 1; else it
    is for the user to see to, as det Fo = 1 shows nothing.

    Sources: orthotropic activation is due to S. Rossi and others, Eur. J. Mech. A/Solids 48 (2014) 129–142,
    doi 10.1016/j.euromechsol.2013.10.009. The form with κ, which may vary through the wall, is that of D.
    Barbarotta and others, Int. J. Numer. Meth. Biomed. Engng. 34 (2018) e3137, doi 10.1002/cnm.3137, and
    A. Gerbi, L. Dedè, A. Quarteroni, Math. Eng. 1 (2018), doi 10.3934/Mine.2018.1.1. Others take
    γ_n = K γ, the same to first order with κ = −2 K. The default of κ is ours.

    Args:
        kappa: κ, non-dimensional, finite. In a script also a UFL scalar on the body's mesh, such as
            κ_endo + (κ_epi − κ_endo) ξ with a coordinate ξ through the wall.
    """

    kappa: Coefficient = 0.5

    def tensor(self, gamma: Any, fibres: Any) -> Any:
        """Fo for the active strain γ > −1 (UFL scalar) and the directions ``fibres.f0``, ``s0``, ``n0``.

        Raises:
            InputError: The fibres come without sheets.
        """
        f0, s0, n0 = with_sheets(fibres, type(self).__name__)
        gamma_n = self.kappa * ((1 + gamma) ** -0.5 - 1)
        gamma_s = 1 / ((1 + gamma) * (1 + gamma_n)) - 1
        across = gamma_s * ufl.outer(s0, s0) + gamma_n * ufl.outer(n0, n0)
        return ufl.Identity(3) + gamma * ufl.outer(f0, f0) + across
