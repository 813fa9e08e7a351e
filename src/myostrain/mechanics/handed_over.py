"""The configuration that the potential sees."""

from __future__ import annotations

from myostrain.engine import fem
from myostrain.history import History
from myostrain.kinematics import Deformation
from myostrain.mechanics.active_body import ActiveBody

import numpy as np
import ufl


class HandedOver:
    """A copy of displacement and activation, apart from those that mechanics solves for.

    Args:
        active: The equations of the body.
        u: The unknown.
        a: The activation.
        held_ratio: J while an imposed stretch holds the body, whatever the activation; None if none does.
        for_ever: Whether it holds the body for ever.

    Attributes:
        u: The displacement handed over (with the pressure, where there is one).
        a: The activation.
        imposed: One while the configuration handed over is an imposed stretch, else zero.
        deformation: F and J of it.
    """

    def __init__(
        self, active: ActiveBody, u: fem.Function, a: fem.Function, held_ratio: float | None, for_ever: bool
    ) -> None:
        self.u, self.a = fem.Function(u.function_space), fem.Function(a.function_space)
        self.imposed = fem.Constant(u.function_space.mesh, 0.0)
        F, Jo = active.gradient(self.u), ufl.det(active.active(self.a))
        if held_ratio is not None:
            Jo = held_ratio if for_ever else Jo + self.imposed * (held_ratio - Jo)
        self.deformation = Deformation(F, active.kinematics.volume_ratio(F, Jo))

    def extrapolate(self, u: History, a: History, time: float, order: int, imposed: float) -> None:
        """Take the configuration at a time from accepted ones, by a polynomial of an order."""
        u.extrapolate(time, order, self.u.x.array)
        a.extrapolate(time, order, self.a.x.array)
        self.imposed.value = imposed

    def take(self, u: fem.Function, a: fem.Function, imposed: float) -> None:
        """Take this configuration."""
        np.copyto(self.u.x.array, u.x.array)
        np.copyto(self.a.x.array, a.x.array)
        self.imposed.value = imposed
