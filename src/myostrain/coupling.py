"""Electromechanics: the order of the sub-steps, and what is handed over between potential and mechanics.

Each scheme below is one page of that order; nothing else in myostrain knows both sides.
"""

from __future__ import annotations

from typing import ClassVar, Protocol

from myostrain.electrics.potential import Potential
from myostrain.errors import ComputationError, InputError
from myostrain.history import backward_difference, extrapolation_weights
from myostrain.mechanics.equilibrium import Mechanics
from myostrain.solvers.linear import largest
from myostrain.state import State
from myostrain.validation import Count, Positive, description

import numpy as np

#: Largest −v γ′/(1 + γ) for which an extrapolated body is stable where J follows v (2/3, with a margin).
STRONG = 0.66


class Scheme(Protocol):
    """One way to advance the coupled problem by a step."""

    order: ClassVar[int]
    """Order of the scheme in the time step, measured by a test."""

    def advance(self, model: Electromechanics, start: float, end: float) -> None:
        """Advance from time ``start`` to ``end``."""
        ...


class Electromechanics:
    """The coupled problem.

    Args:
        potential: The potential on the deforming body, or one that is given
            (:class:`GivenPotential`).
        mechanics: The deforming body; None for a rigid one.
        scheme: How to advance; second order, mechanics every step, unless given.

    Attributes:
        time: Simulated time of the present state.
        coupling_iterations: Fixed-point iterations done so far (the implicit scheme).
        feedback: By how much J v answers to v through J, see :func:`check_well_posed`.
        displacement_lag: Largest difference so far between the body that the potential was solved on and the
            one that mechanics then found for the same time (the schemes of one pass).

    Raises:
        InputError: The activation makes Fo singular, or the conservative balance ill-posed; or mechanics is
            to be solved every few steps where each must be iterated.
    """

    def __init__(
        self, potential: Potential, mechanics: Mechanics | None = None, scheme: Scheme | None = None
    ) -> None:
        self.feedback = 0.0 if mechanics is None else check_well_posed(potential, mechanics)
        self.potential, self.mechanics = potential, mechanics
        self.scheme: Scheme = scheme or SecondOrder()
        if isinstance(self.scheme, SecondOrder) and self.scheme.every > 1 and self.feedback > STRONG:
            raise InputError(
                f"{self.scheme.every}: J follows the potential so strongly here (−v γ′/(1 + γ) up to "
                f"{self.feedback:.2f}, over {STRONG}) that mechanics is iterated in every step; give 1",
                "mechanics.every",
            )
        self.time = 0.0
        self.steps = 0
        self.coupling_iterations = 0
        self.displacement_lag = 0.0
        self._times: list[float] = []

    def start(self) -> None:
        """Find the initial configuration for the present potential, at time 0."""
        self.time, self.steps, self._times = 0.0, 0, [0.0]
        if self.mechanics is not None:
            self.feedback = check_well_posed(self.potential, self.mechanics)
            self._give_potential()
            self.mechanics.start(0.0)
        self.potential.start()

    def step(self, end: float) -> None:
        """Advance to the time ``end``.

        Raises:
            ComputationError: A solver failed.
        """
        was_held = self.mechanics is not None and self.mechanics.held(self.time)
        self.scheme.advance(self, self.time, end)
        self.time = end
        self.steps += 1
        self._times = [end, *self._times[: self.scheme.order - 1]]
        if was_held and self.mechanics is not None and not self.mechanics.held(end):
            self._release()

    def state(self) -> State:
        """What the next step needs, without copies of what no step changes in place."""
        return {
            "time": self.time,
            "steps": self.steps,
            "times": self._times,
            "feedback": self.feedback,
            "coupling_iterations": self.coupling_iterations,
            "displacement_lag": self.displacement_lag,
            "mechanics": None if self.mechanics is None else self.mechanics.state(),
            "potential": self.potential.state(),
        }

    def restore(self, state: State) -> None:
        """Go on from a state, in place of :meth:`start` or after a failed step."""
        self.time, self.steps, self._times = state["time"], state["steps"], list(state["times"])
        self.feedback = state["feedback"]
        self.coupling_iterations = state["coupling_iterations"]
        self.displacement_lag = state["displacement_lag"]
        if self.mechanics is not None:
            self.mechanics.restore(state["mechanics"])
        self.potential.restore(state["potential"])

    # What schemes are made of.

    def weights(self, end: float, order: int) -> np.ndarray:
        """Backward-difference weights of the value at ``end`` and the past ones, newest first."""
        return backward_difference([end, *self._times[:order]])

    def extrapolated_potential(self, end: float, order: int) -> np.ndarray:
        """The potential at ``end`` by a polynomial through its last ``order`` values (nodal, local)."""
        return self.potential.extrapolate(extrapolation_weights(self._times[:order], end))

    def solve_mechanics(self, end: float, order: int, handed_over: int) -> None:
        """Solve mechanics for the present potential and accept it.

        Args:
            end: Time of the present potential.
            order: Order of viscous rates in time.
            handed_over: Order of the extrapolation by which the potential saw the body until now.
        """
        assert self.mechanics is not None
        self._give_potential()
        held = self.mechanics.held(self.time)  # a stretch that ends now has held the body until now
        self.mechanics.solve(end, order=order, held=held)
        if not held:
            self.displacement_lag = max(self.displacement_lag, self.mechanics.lag(end, handed_over))
        self.mechanics.accept(end)

    def _give_potential(self) -> None:
        assert self.mechanics is not None
        self.mechanics.v.x.array[:] = self.potential.v.x.array

    def _release(self, tolerance: float = 1e-10, most: int = 200) -> None:
        """The imposed stretch ends now: the body springs to equilibrium, J v and J w are conserved."""
        assert self.mechanics is not None
        mechanics, potential = self.mechanics, self.potential
        mechanics.release()
        self._times = self._times[:1]
        potential.forget()
        if mechanics.relaxation_time > 0:  # a viscous body does not jump
            mechanics.accept(self.time)
            return
        for _ in range(most):
            self._give_potential()
            try:
                mechanics.solve(self.time, predict=False)
            except ComputationError as error:
                raise self._no_release() from error
            mechanics.hand_over_present()
            potential.update_deformation()
            if potential.conserve() <= tolerance:
                break
        else:
            raise self._no_release()
        mechanics.accept(self.time)

    def _no_release(self) -> ComputationError:
        return ComputationError(
            "no equilibrium conserves J v when the imposed stretch ends (on a line: for 4 β v x′ > 1)",
            time=self.time,
            advice="a smaller stretch or potential.",
        )


def check_well_posed(potential: Potential, mechanics: Mechanics) -> float:
    """Refuse an activation that makes Fo singular, or the balance of the potential backward-parabolic.

    Where J follows 1 + γ(v) at once, ∂((1 + γ) v)/∂t = (1 + γ + v γ′) ∂v/∂t, whose factor must be positive
    for v between 0 and 1: for γ = −βv that is 2β < 1, stricter than the paper's αβ < 1/2.

    Returns:
        The largest −v γ′/(1 + γ), by how much J v answers to v through J; zero where J does not follow.

    Raises:
        InputError: The activation is singular, or the balance ill-posed.
    """
    v = np.linspace(0.0, 1.0, 101)
    largest_v = largest(potential.v.x.array, potential.body.comm)
    try:
        most = mechanics.activity_max
        gamma = most * np.array([float(mechanics.law.gamma(value)) for value in v])
        at_most = 1 + most * float(mechanics.law.gamma(largest_v))
    except (TypeError, ValueError):  # a law in UFL terms that floats do not fit
        return 0.0
    if largest_v > 1 and not at_most > 0:
        raise InputError(
            f"the active deformation is singular: 1 + γ = {at_most:.3g} for v = {largest_v:.3g}",
            "initial.potential",
        )
    key = "activation.beta" if hasattr(mechanics.law, "beta") else "activation"
    if not (1 + gamma > 0).all():
        raise InputError(
            f"the active deformation is singular: 1 + γ = {1 + gamma.min():.3g} for v in [0, 1]", key
        )
    # A viscous line lags behind; where det Fe = 1, J is det Fo whatever the viscosity.
    lags = mechanics.relaxation_time > 0 and mechanics.kinematics.tensor_dim == 1
    # Nearly incompressible is near enough to J = 1.
    nearly = getattr(mechanics.kinematics, "bulk_modulus", None) is not None
    free = not nearly or mechanics.kinematics.constraint == "elastic"  # type: ignore[attr-defined]
    follows = free and not potential.isochoric and not lags and not mechanics.held(np.inf)
    if potential.balance != "conservative" or not follows:
        return 0.0
    if (np.gradient((1 + gamma) * v, v, edge_order=2) < 1e-9).any():
        raise InputError(
            "the conservative balance is ill-posed where (1 + γ(v)) v does not grow with v (γ = −βv needs "
            'β < 0.5); a smaller beta, potential.balance = "advective", or on a line '
            "mechanics.relaxation_time > 0",
            key,
        )
    return float(np.max(-v * np.gradient(gamma, v) / (1 + gamma)))


@description
class Implicit:
    """The paper's scheme (section 7): first-order implicit, the coupling by fixed-point iteration.

    Each iteration solves mechanics for the potential's iterate, and then the potential, with its reaction
    linearised about the iterate, on that body; until the potential changes by less than ``tolerance``.

    Args:
        tolerance: Largest change of v between iterations at which to stop.
        max_iterations: Iterations a step may take.
    """

    tolerance: Positive = 1e-8
    max_iterations: Count = 60
    order: ClassVar[int] = 1

    def advance(self, model: Electromechanics, start: float, end: float) -> None:
        """One step, iterated to ``tolerance``."""
        self.iterate(model, start, end, order=1)

    def iterate(self, model: Electromechanics, start: float, end: float, order: int) -> None:
        """One step by backward differences of an order, from the potential extrapolated to it."""
        potential, mechanics = model.potential, model.mechanics
        weights = model.weights(end, order)
        guess = model.extrapolated_potential(end, order).copy()
        for iteration in range(self.max_iterations):
            if mechanics is not None:
                mechanics.v.x.array[:] = guess
                mechanics.solve(end, predict=iteration == 0, order=order, held=mechanics.held(start))
                mechanics.hand_over_present()
                potential.update_deformation()
            potential.solve(end, guess, weights)
            model.coupling_iterations += 1
            change = largest(potential.v.x.array - guess, potential.body.comm)
            guess[:] = potential.v.x.array
            if change <= self.tolerance:
                break
        else:
            raise ComputationError(
                f"the coupling did not converge in {self.max_iterations} fixed-point iterations "
                f"(last change of v {change:.3g}, wanted {self.tolerance:.3g})",
                advice="a smaller time step.",
            )
        potential.accept(keep=order)
        if mechanics is not None:
            mechanics.accept(end)


@description
class Staggered:
    """First-order, one pass a step: the potential on the last known body, then mechanics every N steps.

    Args:
        every: Potential steps between solves of mechanics.
    """

    every: Count = 1
    order: ClassVar[int] = 1

    def advance(self, model: Electromechanics, start: float, end: float) -> None:
        """One step."""
        potential, mechanics = model.potential, model.mechanics
        potential.solve(end, potential.v.x.array.copy(), model.weights(end, 1))
        potential.accept(keep=1)
        if mechanics is not None and (model.steps + 1) % self.every == 0:
            model.solve_mechanics(end, order=1, handed_over=0)
            mechanics.hand_over(end)
            potential.update_deformation()


@description
class SecondOrder:
    """Second order, one pass a step: BDF2, reaction linearised about an extrapolation, extrapolated body.

    The potential is solved on the body extrapolated from the last two solves of mechanics, then mechanics
    every N steps. Where J = 1 by construction the body is handed over once for the N steps, at their mean
    time: what the first of them has too much the last has too little. The first step, and the one after a
    released stretch, are of first order, which costs no order.

    Where J follows the potential strongly, −v γ′/(1 + γ) > 2/3 for some v between 0 and 1 (γ = −βv: β > 0.4),
    an extrapolated body is unstable; there each step is iterated as in :class:`Implicit`.

    Args:
        every: Potential steps N between solves of mechanics.
    """

    every: Count = 1
    order: ClassVar[int] = 2

    def advance(self, model: Electromechanics, start: float, end: float) -> None:
        """One step."""
        potential, mechanics = model.potential, model.mechanics
        if model.feedback > STRONG:
            Implicit().iterate(model, start, end, order=2)
            return
        if mechanics is not None and not mechanics.held(start):
            first = model.steps % self.every == 0
            if first or not potential.isochoric:
                ahead = (self.every + 1) / 2 if potential.isochoric else 1
                mechanics.hand_over(start + ahead * (end - start), order=1)
                potential.update_deformation()
        potential.solve(end, model.extrapolated_potential(end, 2), model.weights(end, 2))
        potential.accept(keep=2)
        if mechanics is not None and (model.steps + 1) % self.every == 0:
            model.solve_mechanics(end, order=2, handed_over=1)
