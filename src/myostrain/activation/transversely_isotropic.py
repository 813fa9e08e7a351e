"""Isochoric active deformation, the same in all directions across the fibre."""

from typing import Any

from myostrain.validation import description

import ufl


@description
class TransverselyIsotropic:
    """Fo = (1 + γ) f⊗f + (1 + γ)^(−1/2) (1 − f⊗f), with det Fo = 1: what shortens thickens, as a cell does.

    On a line, which has no direction across, Fo = 1 + γ. Used, for instance, by S. Rossi and others, Eur. J.
    Mech. A/Solids 48 (2014) 129–142, doi 10.1016/j.euromechsol.2013.10.009, for the single cell.
    """

    def tensor(self, gamma: Any, fibres: Any) -> Any:
        """Fo for the active strain γ > −1 (UFL scalar) along ``fibres.f0`` (UFL vector)."""
        f0 = fibres.f0
        along = ufl.outer(f0, f0)
        return (1 + gamma) * along + (1 + gamma) ** -0.5 * (ufl.Identity(len(f0)) - along)
