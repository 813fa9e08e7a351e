"""Active deformation along the fibre only."""

from typing import Any

from myostrain.validation import description

import ufl


@description
class Fibre:
    """Fo = 1 + γ n⊗n (1.4), with det Fo = 1 + γ."""

    def tensor(self, gamma: Any, fibres: Any) -> Any:
        """Fo for the active strain γ (UFL scalar) along ``fibres.f0`` (UFL vector)."""
        f0 = fibres.f0
        return ufl.Identity(len(f0)) + gamma * ufl.outer(f0, f0)
