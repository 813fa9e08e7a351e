"""Schemes: the order of the sub-steps of a coupled step, each on one page."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Any, ClassVar, Protocol

from myostrain.errors import ComputationError
from myostrain.solvers.linear import largest, owned_dofs
from myostrain.validation import Count, Positive, description

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: Largest −v γ′/(1 + γ) for which an extrapolated body is stable where J follows v (2/3, with a margin).
STRONG = 0.66

#: Change of the stretch, and of γ or the tension, between iterations at which a law that sees more than the
#: potential has settled.
SETTLED = 1e-6

#: Iterations of which swings are compared with those of as many before; the first of them is a later one.
SPAN, LATE = 6, 3

#: By what share swings that go on may differ; the widest that is held, as a share of the membrane's range.
EVEN, WIDEST = 0.01, 1e-3


class Scheme(Protocol):
    """One way to advance a :class:`~myostrain.Electromechanics` by a step."""

    order: ClassVar[int]
    """Order of the scheme in the time step, measured by a test."""

    def advance(self, model: Any, start: float, end: float) -> None:
        """Advance the model from time ``start`` to ``end``."""
        ...


@description
class Implicit:
    """The paper's scheme (section 7): first-order implicit, the coupling by fixed-point iteration.

    Each iteration advances the activation for the potential's iterate, solves mechanics, and then the
    potential, with its reaction linearised about the iterate, on that body. It stops when the potential
    changes by less than ``tolerance``, and the stretch that a law sees, and what it makes of the membrane's
    states, by less than 1e-6.

    Where a membrane or a law switches at a potential, there may be none that fits its own side: from either
    side it leads to the other, for ever. A node that goes on swinging so, by no more than a thousandth of
    the membrane's range, keeps its iterate for the rest of the step, and with it the side. The error is less
    than the swing, in that step; ``solver.coupling.switches`` counts these nodes.

    Args:
        tolerance: Largest change of v between iterations at which to stop, in units of v.
        max_iterations: Largest number of iterations in a step.
    """

    tolerance: Positive = 1e-8
    max_iterations: Count = 60
    order: ClassVar[int] = 1

    def advance(self, model: Any, start: float, end: float) -> None:
        """One step, iterated to ``tolerance``."""
        self.iterate(model, start, end, order=1)

    def iterate(self, model: Any, start: float, end: float, order: int) -> None:
        """One step by backward differences of an order, from the potential extrapolated to it."""
        potential, mechanics = model.potential, model.mechanics
        v, comm = potential.v.x.array, potential.body.comm
        widest = WIDEST * (potential.range[1] - potential.range[0])
        weights = model.weights(end, order)
        guess, moved = model.extrapolated_potential(end, order).copy(), 0.0
        before, held = guess.copy(), np.zeros(len(guess), dtype=bool)
        changes: deque[Array] = deque(maxlen=2 * SPAN)
        for iteration in range(self.max_iterations):
            if mechanics is not None:
                v[:] = guess
                moved = model.iterate_mechanics(start, end, order, first=iteration == 0)
            potential.solve(end, guess, weights)
            model.coupling_iterations += 1
            change = v - before
            before[:] = v
            most, apart = largest(change, comm), largest((v - guess)[held], comm)
            if most <= self.tolerance and moved <= SETTLED and apart <= widest:
                break
            if iteration >= LATE:
                changes.append(change)
                held |= self._swings(changes, widest)
            guess[~held] = v[~held]
        else:
            raise ComputationError(
                f"the coupling did not converge in {self.max_iterations} fixed-point iterations "
                f"(last change of v {most:.3g}, wanted {self.tolerance:.3g}; "
                f"of stretch or activation {moved:.3g}, wanted {SETTLED:g})",
                advice="a smaller time step.",
            )
        if iteration > LATE:  # on all processes
            own = held[: owned_dofs(potential.v.function_space)]
            model.switches += int(comm.allreduce(int(np.count_nonzero(own))))
        model.accept(end, order)
        if mechanics is not None:
            model.accept_mechanics(end)

    def _swings(self, changes: Sequence[Array], widest: float) -> Any:
        """Nodes (nodes,) that go to and fro, no less than they did before."""
        if len(changes) < 2 * SPAN:
            return False
        table = np.array(changes)
        before, now = (np.abs(part).max(axis=0) for part in (table[:SPAN], table[SPAN:]))
        both = (table > 0).any(axis=0) & (table < 0).any(axis=0)
        return both & (np.abs(now - before) <= EVEN * now) & (now > self.tolerance) & (now <= widest)


@description
class Staggered:
    """First-order, one pass a step: potential on the last known body, activation, then mechanics.

    Args:
        every: Potential steps between solves of mechanics.
    """

    every: Count = 1
    order: ClassVar[int] = 1

    def advance(self, model: Any, start: float, end: float) -> None:
        """One step."""
        potential = model.potential
        potential.solve(end, potential.v.x.array.copy(), model.weights(end, 1))
        model.advance_activation(start, end, order=1)
        model.accept(end, order=1)
        if model.mechanics is not None and model.solves_mechanics:
            model.solve_mechanics(end, order=1, handed_over=0)
            model.hand_over(end)


@description
class SecondOrder:
    """Second order, one pass per step: BDF2, reaction linearised about an extrapolation, extrapolated body.

    The potential is solved on the body extrapolated from the last two solves of mechanics, then the
    activation with its drivers at the middle of the step, and mechanics every N steps. Where J = 1 by
    construction the body is handed over once for the N steps, at their mean time: it is too late for the
    first of them by as much as it is too early for the last. The first step, and the one after a released
    stretch, are of first order, which does not lower the order of the run.

    Where J follows the potential strongly, −v γ′/(1 + γ) > 2/3 over the membrane's range (γ = −βv and v up to
    1: β > 0.4), an extrapolated body is unstable; there each step is iterated as in :class:`Implicit`.

    Args:
        every: Potential steps N between solves of mechanics.
    """

    every: Count = 1
    order: ClassVar[int] = 2

    def advance(self, model: Any, start: float, end: float) -> None:
        """One step."""
        potential, mechanics = model.potential, model.mechanics
        if model.feedback > STRONG:
            Implicit().iterate(model, start, end, order=2)
            return
        if mechanics is not None and not mechanics.held(start):
            first = model.steps % self.every == 0
            if first or not potential.isochoric:
                ahead = (self.every + 1) / 2 if potential.isochoric else 1
                model.hand_over(start + ahead * (end - start), order=1)
        potential.solve(end, model.extrapolated_potential(end, 2), model.weights(end, 2))
        model.advance_activation(start, end, order=2)
        model.accept(end, order=2)
        if mechanics is not None and model.solves_mechanics:
            model.solve_mechanics(end, order=2, handed_over=1)
