"""The rate of the viscous strain by backward differences over past configurations."""

from __future__ import annotations

from typing import Any

from myostrain.engine import fem
from myostrain.history import History, backward_difference
from myostrain.mechanics.active_body import ActiveBody
from myostrain.mechanics.rate import Rate


class StrainRate(Rate):
    """The rate of the strain that a viscous body's dashpot sees.

    Args:
        active: The equations of the body.
        u: The unknown.
        a: The activation.

    Attributes:
        functions: The past unknowns and activations, one after the other.
        weights: Weights of the present and the past strains.
        past: Pairs of unknown and activation, newest first.
        rate: The rate, UFL.
    """

    def __init__(self, active: ActiveBody, u: fem.Function, a: fem.Function) -> None:
        self.past = [(fem.Function(u.function_space), fem.Function(a.function_space)) for _ in range(2)]
        self.functions = [function for pair in self.past for function in pair]
        self.weights = [fem.Constant(u.function_space.mesh, 0.0) for _ in range(3)]
        self.rate: Any = active.strain_rate(self.weights, [(u, a), *self.past])

    @property
    def depends_on(self) -> list[fem.Function | fem.Constant]:
        """What the tangent depends on."""
        return [*self.functions, *self.weights]

    def set(self, time: float, order: int, us: History, activations: History) -> None:
        """Take the rate at a time over the accepted configurations, of an order at most."""
        points = min(order, len(us.times))
        weights = backward_difference([time, *us.times[:points]])
        for constant, weight in zip(self.weights, [*weights, 0.0], strict=False):
            constant.value = weight
        for (u, a), u_past, a_past in zip(self.past, us.values, activations.values, strict=False):
            u.x.array[:], a.x.array[:] = u_past, a_past
