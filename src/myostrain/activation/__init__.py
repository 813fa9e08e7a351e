"""Activation: a law gives γ from the potential, a deformation gives Fo from γ; one of each a file.

A law has ``gamma(v)`` in plain arithmetic or UFL functions; a deformation has ``tensor(gamma, fibres)``. The
other approach, :class:`ActiveStress`, has ``energy(F, fibres, v)``. Each is replaceable by an object of the
user's script.
"""

from typing import Any, Protocol

from myostrain.activation.active_stress import ActiveStress
from myostrain.activation.fibre import Fibre
from myostrain.activation.orthotropic import Orthotropic
from myostrain.activation.proportional import Proportional
from myostrain.activation.transversely_isotropic import TransverselyIsotropic


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


__all__ = [
    "ActivationLaw",
    "ActiveDeformation",
    "ActiveStress",
    "Fibre",
    "Orthotropic",
    "Proportional",
    "TransverselyIsotropic",
]
