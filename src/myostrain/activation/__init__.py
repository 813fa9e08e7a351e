"""Activation: a law gives γ from the potential, a deformation gives Fo from γ; one of each a file.

A law has ``gamma(v)`` in plain arithmetic or UFL functions; a deformation has ``tensor(gamma, fibres)``. Each
is replaceable by an object of the user's script.
"""

from typing import Any, Protocol

from myostrain.activation.fibre import Fibre
from myostrain.activation.proportional import Proportional


class ActivationLaw(Protocol):
    """What the mechanics asks of an activation law."""

    def gamma(self, v: Any) -> Any:
        """Active strain γ along the fibre for the potential v; negative contracts."""
        ...


class ActiveDeformation(Protocol):
    """What the mechanics asks of an active deformation."""

    def tensor(self, gamma: Any, fibres: Any) -> Any:
        """Fo for the active strain γ and the unit directions ``fibres.f0``, ``s0``, ``n0``."""
        ...


__all__ = ["ActivationLaw", "ActiveDeformation", "Fibre", "Proportional"]
