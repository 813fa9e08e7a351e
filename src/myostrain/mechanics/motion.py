"""Velocity and acceleration of the body in time, for its inertia and for what resists its motion.

Both are linear in the unknown displacement of a step, v = w u + V and a = w′ u + A, with V and A of the past;
so that the balance of forces is written down and differentiated once, whatever the rule in time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from myostrain.engine import compile_form, fem, lasting
from myostrain.history import History, backward_difference
from myostrain.mechanics.rate import Rate
from myostrain.mechanics.supports import Supports
from myostrain.state import State

import numpy as np
import numpy.typing as npt
import ufl

Array = npt.NDArray[np.float64]


class Drift(Rate):
    """The velocity of a body without inertia, by backward differences over its past configurations.

    Args:
        u: The unknown: the displacement, and a pressure where there is one.
        displacement: Takes the displacement out of such a function, UFL.

    Attributes:
        velocity: The velocity in the balance of forces, UFL.
        functions: What it depends on beside the unknown.
        weights: Constants that it depends on.
    """

    def __init__(self, u: fem.Function, displacement: Callable[[fem.Function], Any]) -> None:
        self._u, space = u, u.function_space
        self._displacement = displacement
        self._velocity_past = fem.Function(space)
        self.functions = [self._velocity_past]
        self.weights = [fem.Constant(space.mesh, 0.0)]
        self.velocity: Any = self._linear(self.weights[0], self._velocity_past)

    def _linear(self, weight: fem.Constant, past: fem.Function) -> Any:
        return weight * self._displacement(self._u) + self._displacement(past)

    @property
    def depends_on(self) -> list[fem.Constant]:
        """What the tangent depends on."""
        return self.weights

    def inertia(self, test: Any) -> Any:
        """Virtual power of ρ ü, a UFL form: none.

        Args:
            test: The virtual displacement.
        """
        return 0

    def set(self, time: float, order: int, us: History, activations: History) -> None:
        """Take the velocity at a time over the accepted configurations, of an order at most."""
        points = min(order, len(us.times))
        first, *others = backward_difference([time, *us.times[:points]])
        self.weights[0].value = first
        self._velocity_past.x.array[:] = sum(w * u for w, u in zip(others, us.values, strict=False))

    def accept(self) -> None:
        """Take the present configuration as one of the past: the next :meth:`set` finds it there."""

    def clear(self) -> None:
        """At rest."""
        super().clear()
        for function in self.functions:
            function.x.array[:] = 0.0


class Inertia(Drift):
    """Newmark's displacement and velocity with the acceleration of the generalised-α method.

    With γ = ½ + α_f − α_m and β = (γ + ½)²/4 a step h takes the displacement u and the velocity v to

        u + h v + h² ((½ − β) a + β a⁺),  v + h ((1 − γ) a + γ a⁺),

    where a, the method's own acceleration, follows that of the body, ü:

        (1 − α_m) a⁺ + α_m a = (1 − α_f) ü⁺ + α_f ü.

    The forces are balanced at the end of the step, where its loads, its activation and a constraint are:
    ρ ü⁺ is what they leave. For linear forces that is the method of Chung and Hulbert; where they are not
    linear its weighted mean is of forces, not of displacements. It is of second order, and of a vibration far
    too fast for the step a share ρ∞ is left after each, with α_m = (2 ρ∞ − 1)/(ρ∞ + 1) and
    α_f = ρ∞/(ρ∞ + 1): none for 0, all for 1. A linear body without damping keeps its energy for ρ∞ = 1.
    ρ∞ = 2/3 has α_m = 0.2, α_f = 0.4, as in the benchmark of Aróstica et al. 2025.

    The first step is an implicit one of first order, v⁺ = (u⁺ − u)/h and ü⁺ = (v⁺ − v)/h, which costs no
    order: it needs no acceleration at the start, where loads may jump.

    Sources: J. Chung, G. M. Hulbert, J. Appl. Mech. 60 (1993) 371–375, doi 10.1115/1.2900803; with forces and
    constraints at the end of the step, M. Arnold, O. Brüls, Multibody Syst. Dyn. 18 (2007) 185–202,
    doi 10.1007/s11044-007-9084-0.

    Args:
        u: The unknown: the displacement, and a pressure where there is one.
        displacement: Takes the displacement out of such a function, UFL.
        density: ρ, mass per reference volume (per area of a sheet of thickness one, per length of a line).
        spectral_radius: ρ∞, from 0 to 1.

    Attributes:
        velocity: The velocity in the balance of forces, UFL.
        acceleration: The acceleration ü there, UFL.
        moving: The velocity accepted last; write it after the start for a body that begins in motion.
    """

    def __init__(
        self,
        u: fem.Function,
        displacement: Callable[[fem.Function], Any],
        density: float,
        spectral_radius: float,
    ) -> None:
        super().__init__(u, displacement)
        space = u.function_space
        radius = spectral_radius
        self._alpha_m, self._alpha_f = (2 * radius - 1) / (radius + 1), radius / (radius + 1)
        self._gamma = 0.5 + self._alpha_f - self._alpha_m
        self._beta = (self._gamma + 0.5) ** 2 / 4
        self.moving, self._own, self._body, self._acceleration_past = (fem.Function(space) for _ in range(4))
        self.functions += [self._acceleration_past, self.moving, self._own, self._body]
        self.weights += [fem.Constant(space.mesh, 0.0)]
        self.acceleration: Any = self._linear(self.weights[1], self._acceleration_past)
        self._density = fem.Constant(space.mesh, float(density))
        self._first = True
        # Exact on elements of this degree.
        self._dx = ufl.dx(metadata={"quadrature_degree": 2 * space.ufl_element().embedded_superdegree})
        self._energy: fem.Form | None = None

    def inertia(self, test: Any) -> Any:
        """Virtual power of ρ ü, a UFL form."""
        return self._density * ufl.inner(self.acceleration, test) * self._dx

    def set(self, time: float, order: int, us: History, activations: History) -> None:
        """Take velocity and acceleration at a time from those accepted last; the order is the method's."""
        h, u, v, a = time - us.times[0], us.values[0], self.moving.x.array, self._own.x.array
        if self._first:
            weights = 1 / h, 1 / h**2
            pasts = -weights[0] * u, -weights[1] * (u + h * v)
        else:
            weights = self._gamma / (self._beta * h), self._ratio / (self._beta * h**2)
            guess = u + h * v + h**2 * (0.5 - self._beta) * a
            kept = (self._alpha_m * a - self._alpha_f * self._body.x.array) / (1 - self._alpha_f)
            pasts = -weights[0] * guess + v + h * (1 - self._gamma) * a, kept - weights[1] * guess
        for constant, weight in zip(self.weights, weights, strict=True):
            constant.value = weight
        self._velocity_past.x.array[:], self._acceleration_past.x.array[:] = pasts

    @property
    def _ratio(self) -> float:
        return (1 - self._alpha_m) / (1 - self._alpha_f)

    def accept(self) -> None:
        """Take the present configuration as that at the end of a step, if there was one."""
        if not self.weights[0].value:
            return
        u = self._u.x.array
        velocity, acceleration = (
            float(weight.value) * u + past.x.array
            for weight, past in zip(self.weights, (self._velocity_past, self._acceleration_past), strict=True)
        )
        own, body = self._own.x.array, self._body.x.array
        if self._first:
            own[:] = acceleration
        else:
            means = (1 - self._alpha_f) * acceleration + self._alpha_f * body
            own[:] = (means - self._alpha_m * own) / (1 - self._alpha_m)
        self.moving.x.array[:], body[:] = velocity, acceleration
        self._first = False

    def clear(self) -> None:
        """At rest, before a first step."""
        super().clear()
        self._first = True

    def kinetic_energy(self) -> float:
        """½ ∫ ρ |v|² of the velocity accepted last (collective)."""
        if self._energy is None:
            v = self._displacement(self.moving)
            self._energy = compile_form(self._density / 2 * ufl.inner(v, v) * self._dx)
        comm = lasting(self._u.function_space.mesh.comm)
        return float(comm.allreduce(fem.assemble_scalar(self._energy)))

    def state(self) -> State:
        """What the next step needs."""
        return {**super().state(), "first": self._first}

    def restore(self, state: State) -> None:
        """Go on from a state."""
        super().restore(state)
        self._first = state["first"]


def velocity_of(motion: Drift | None, us: History, u: fem.Function) -> Array:
    """The velocity of the configuration accepted last, in the numbering of the unknown.

    That of a body with inertia is its own; any other one's is a backward difference of second order over the
    accepted configurations, of first order after the first step, zero before it.

    Args:
        motion: The body's motion, see :func:`motion_of`.
        us: Its accepted configurations.
        u: The unknown.
    """
    if isinstance(motion, Inertia):
        return motion.moving.x.array
    velocity = np.zeros_like(u.x.array)
    weights = backward_difference(us.times[:3]) if len(us.times) > 1 else np.empty(0)
    for weight, values in zip(weights, us.values, strict=False):
        velocity += weight * values
    return velocity


def motion_of(
    u: fem.Function,
    displacement: Callable[[fem.Function], Any],
    supports: Supports,
    density: float,
    spectral_radius: float,
) -> Drift | None:
    """What the balance of forces has of the motion; None where nothing depends on it."""
    if density > 0:
        return Inertia(u, displacement, density, spectral_radius)
    return Drift(u, displacement) if any(True for _ in supports.dampers()) else None
