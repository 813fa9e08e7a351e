"""Isochoric active deformation that differs along and across the sheets."""

from typing import Any

from myostrain.activation.coefficient import Coefficient
from myostrain.directions import with_sheets
from myostrain.validation import description

import ufl


@description
class Orthotropic:
    """Fo = 1 + γ f⊗f + γ_s s⊗s + γ_n n⊗n, with γ_s from det Fo = 1 and γ_n of two published laws.

    γ_n = κ ((1 + γ)^(−1/2) − 1) + K γ:

    - κ alone (K = 0): κ is how much of an isochoric cell's own thickening appears along the sheet's normal
      n0; the sheet direction s0, which points through the wall in rule-based ventricles, takes the rest.
      κ = 1 is :class:`TransverselyIsotropic`, with κ = 0 all thickening is along s0. It may vary through the
      wall: A. Gerbi, L. Dedè, A. Quarteroni, Math. Eng. 1 (2018), doi 10.3934/Mine.2018.1.1.
    - K alone (κ = 0), of S. Rossi and others, Eur. J. Mech. A/Solids 48 (2014) 129–142,
      doi 10.1016/j.euromechsol.2013.10.009, with K = 4: the normal shortens K times as much as the fibre, as
      sheets slide, and the wall thickens by that.
    - Both, κ = ξ and K = 4 (1 − ξ) with a coordinate ξ from the endocardium to the epicardium: this is how
      svFSI implements the transmurally heterogeneous activation of D. Barbarotta and others, Int. J. Numer.
      Meth. Biomed. Engng. 34 (2018) e3137, doi 10.1002/cnm.3137.

    To first order in γ, κ acts like K = −κ/2. Fo is admissible while 1 + γ_n > 0: for every γ > −1 if K = 0
    and 0 ≤ κ ≤ 1; for γ > −1/K if κ = 0, a quarter of shortening for K = 4. Beyond that there is no result:
    the run ends and names the place and "det Fo". The default is ours.

    Args:
        kappa: κ, non-dimensional, finite. In a script also a UFL scalar on the body's mesh, such as
            κ_endo + (κ_epi − κ_endo) ξ.
        ratio: K, as κ.
    """

    kappa: Coefficient = 0.5
    ratio: Coefficient = 0.0

    def tensor(self, gamma: Any, fibres: Any) -> Any:
        """Fo for the active strain γ > −1 (UFL scalar) and the directions ``fibres.f0``, ``s0``, ``n0``.

        Raises:
            InputError: The fibres come without sheets.
        """
        f0, s0, n0 = with_sheets(fibres, type(self).__name__)
        gamma_n = self.kappa * ((1 + gamma) ** -0.5 - 1) + self.ratio * gamma
        # det Fo = 1 would hide 1 + γ_n < 0: the square of its root is not a number then.
        gamma_s = 1 / ((1 + gamma) * ufl.sqrt(1 + gamma_n) ** 2) - 1
        across = gamma_s * ufl.outer(s0, s0) + gamma_n * ufl.outer(n0, n0)
        return ufl.Identity(3) + gamma * ufl.outer(f0, f0) + across
