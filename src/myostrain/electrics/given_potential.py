"""A potential that is given rather than solved for: what drives a quasi-static case."""

from __future__ import annotations

from typing import Any

from myostrain.engine import fem
from myostrain.geometry import Body
from myostrain.mechanics.loads import Course, value_at
from myostrain.state import State
from myostrain.validation import description

import numpy as np
import numpy.typing as npt


@description
class Drive:
    """The potential over time, the same in the whole body.

    Args:
        potential: v, non-dimensional: a number, or points (time, v) joined by straight lines.
    """

    potential: Course = 0.0


class GivenPotential:
    """Stands where a :class:`Potential` does, with nothing to solve: for loads and activation given in time.

    Args:
        body: The reference body.
        drive: The potential over time; zero unless given.

    Attributes:
        v: The potential, P1.
    """

    balance = "advective"
    isochoric = True
    solver = None
    seconds = 0.0

    def __init__(self, body: Body, drive: Drive | None = None) -> None:
        self.body, self._drive = body, drive or Drive()
        self.v = fem.Function(fem.functionspace(body.mesh, ("Lagrange", 1)), name="potential")
        self.states: dict[str, fem.Function] = {}
        self._put(0.0)

    def _put(self, time: float) -> None:
        self._value = value_at(self._drive.potential, time)
        self.v.x.array[:] = self._value

    @property
    def fields(self) -> list[fem.Function]:
        """The potential."""
        return [self.v]

    def start(self) -> None:
        """Begin at time 0."""
        self._put(0.0)

    def solve(self, end: float, guess: Any = None, weights: Any = None) -> None:
        """Take the potential at the time ``end``."""
        self._put(end)

    def extrapolate(self, weights: Any) -> npt.NDArray[np.float64]:
        """The present potential (nodal, local)."""
        return self.v.x.array

    def accept(self, keep: int) -> None:
        """Nothing: the past is given too."""

    def update_deformation(self) -> None:
        """Nothing: the potential does not see the body."""

    def forget(self) -> None:
        """Nothing."""

    def conserve(self) -> float:
        """Nothing is conserved; zero change."""
        return 0.0

    def amount(self) -> None:
        """There is no amount that a balance would keep."""

    def state(self) -> State:
        """The potential."""
        return {"value": self._value}

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self._value = state["value"]
        self.v.x.array[:] = self._value
