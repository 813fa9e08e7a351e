"""Membranes, stretch currents, and active bodies by strain and by stress that contract alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from myostrain import membranes
from myostrain.activation import Fibre, FibreTension, NashPanfilov2004, Proportional, Relaxing
from myostrain.electrics import StretchCurrent
from myostrain.validation import Positive, description

import numpy as np
import ufl

#: Excitation at which the time constants of contraction change.
SWITCH = 0.05


@description
class QuickRecovery(membranes.Membrane):
    """The cubic of Aliev and Panfilov with a recovery that follows at once where the cell is at rest.

    The current is k v (v − a)(v − 1) + v r; dr/dt = ε(v) (k v − r), ε = 1 for v < a, and ``slow`` from a
    on. Of the kind with which A. V. Panfilov, R. H. Keldermann, M. P. Nash, Phys. Rev. Lett. 95 (2005)
    258104, have their pacemakers, as we remember it: their text was not at hand.

    Args:
        k: Rate of the reaction.
        a: Threshold.
        slow: ε where the cell is excited.
    """

    k: Positive = 8.0
    a: Positive = 0.05
    slow: Positive = 0.1
    states: ClassVar[tuple[str, ...]] = ("recovery",)

    def resting_potential(self) -> float:
        """Zero."""
        return 0.0

    def resting_states(self) -> tuple[float, ...]:
        """Zero."""
        return (0.0,)

    def current(self, v: Any, states: Sequence[Any]) -> Any:
        """k v (v − a)(v − 1) + v r."""
        return self.k * v * (v - self.a) * (v - 1) + v * states[0]

    def rates(self, v: Any, states: Sequence[Any]) -> Sequence[Any]:
        """ε(v) (k v − r)."""
        return (np.where(v < self.a, 1.0, self.slow) * (self.k * v - states[0]),)


@dataclass(frozen=True)
class InPlane:
    """Fo = 1 + γ (1 − n⊗n) with the sheet's normal n: the same contraction in all directions of the sheet."""

    def tensor(self, gamma: Any, fibres: Any) -> Any:
        """Fo for γ."""
        return ufl.as_matrix([[1 + gamma, 0, 0], [0, 1 + gamma, 0], [0, 0, 1]])


@dataclass(frozen=True)
class InPlaneTension:
    """A tension in all directions of the sheet: T/2 (C₁₁ + C₂₂ − 2)."""

    def energy(self, F: Any, fibres: Any, tension: Any) -> Any:
        """Energy per reference volume."""
        C = F.T * F
        return tension / 2 * (C[0, 0] + C[1, 1] - 2)


def matched(beta: float, reading: str, modulus: float = 1.0) -> float:
    """The tension that does to a neo-Hookean sheet what the active strain −β does.

    Jo W(F Fo⁻¹) is Jo times the passive energy and that of a tension μ ((1 − β)⁻² − 1), along the fibre or
    in the plane: free bodies shorten by the same with this tension, held ones pull by the same with Jo
    times it.

    Args:
        beta: β.
        reading: "free" or "held".
        modulus: μ.
    """
    tension = modulus * ((1 - beta) ** -2 - 1)
    return tension if reading == "free" else (1 - beta) * tension


def membrane_of(given: Mapping[str, Any]) -> Any:
    """A membrane of the program, or the one of this module: "model" and its parameters."""
    others = dict(given)
    model = others.pop("model")
    return QuickRecovery(**others) if model == "QuickRecovery" else getattr(membranes, model)(**others)


def activation_of(approach: str, beta: float, rise: float, fall: float) -> tuple[Any, Any]:
    """What contracts, and the law that it follows, with the same time constants for strain and stress.

    Args:
        approach: "strain", "stress" (matched free) or "stress, held" (matched held), along the fibre; with
            " in plane" after it in all directions of the sheet.
        beta: β of the strain.
        rise: Time constant where the cell is excited; 0 follows the potential at once.
        fall: Elsewhere.
    """
    kind, plane = approach.removesuffix(" in plane"), approach.endswith(" in plane")
    if kind == "strain":
        law: Any = Proportional(beta=beta)
        if rise > 0:
            law = Relaxing(beta=beta, rise=rise, fall=fall, threshold=SWITCH)
        return InPlane() if plane else Fibre(), law
    tension = matched(beta, "free" if kind == "stress" else "held")
    law = NashPanfilov2004(tension=tension, rate=1 / fall, above=fall / rise, threshold=SWITCH)
    return InPlaneTension() if plane else FibreTension(), law


def currents(conductance: float) -> list[StretchCurrent]:
    """The stretch current; none at zero."""
    return [StretchCurrent(conductance=conductance)] if conductance > 0 else []
