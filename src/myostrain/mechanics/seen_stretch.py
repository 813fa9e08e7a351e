"""The stretch of the fibre as an activation law sees it, over time."""

from __future__ import annotations

from typing import Any

from myostrain.engine import fem, lasting
from myostrain.history import extrapolation_weights
from myostrain.solvers.anderson import Anderson
from myostrain.solvers.linear import largest, owned_dofs
from myostrain.state import FieldState, State

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: Past iterates of which the next one is made.
MEMORY = 4


class SeenStretch:
    """Nodal stretches of the last two bodies; from them the one at a time, and its iterates within a step.

    Args:
        space: P1 space of the potential.
    """

    def __init__(self, space: fem.FunctionSpace) -> None:
        self._space, self._comm = space, lasting(space.mesh.comm)
        self._kept: list[tuple[float, Array]] = []
        self._settling = Anderson(MEMORY, slice(0, owned_dofs(space)), self._comm)

    def clear(self) -> None:
        """Forget all bodies."""
        self._kept = []

    def keep(self, time: float, stretch: Array) -> None:
        """Take a stretch (nodes,) as that at a time, in place of one there and before later ones."""
        self._kept = [(time, stretch), *[kept for kept in self._kept if kept[0] < time][:1]]

    def at(self, time: float, order: int) -> Array:
        """The stretch (nodes,) at a time, by a polynomial through the last ``order`` bodies; 1 before any."""
        if not self._kept:
            return np.ones(len(fem.Function(self._space).x.array))
        times, values = zip(*self._kept[:order], strict=True)
        weights = extrapolation_weights(times, time)
        return np.asarray(sum(w * value for w, value in zip(weights, values, strict=True)))

    def lag(self, time: float, order: int, found: Array) -> float:
        """Largest difference between what :meth:`at` gives and the stretch that was found."""
        return largest(found - self.at(time, order), self._comm)

    def settle(self, time: float, order: int, found: Array, *, first: bool, enough: float) -> float:
        """Take the next iterate of the stretch at a time, accelerated.

        A tension that grows with the length more than the body resists would else swing for ever.

        Args:
            time: The time.
            order: As in :meth:`at`.
            found: The stretch of the body that the last iterate led to.
            first: Whether that was the first iterate of this step.
            enough: A change that is no more than this is the last.

        Returns:
            The largest change.
        """
        if first:
            self._settling.clear()
        seen = self.at(time, order)
        change = largest(found - seen, self._comm)
        self.keep(time, found if change <= enough else seen + self._settling.step(seen, found - seen))
        return change

    def state(self) -> State:
        """Times and stretches."""
        return {
            "times": [time for time, _ in self._kept],
            "values": [FieldState(self._space, stretch) for _, stretch in self._kept],
        }

    def restore(self, state: State) -> None:
        """Go on from a state."""
        values: Any = [field.values for field in state["values"]]
        self._kept = list(zip(state["times"], values, strict=True))
