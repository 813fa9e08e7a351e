"""A potential that is given rather than solved for: what drives a quasi-static case."""

from __future__ import annotations

from typing import Any

from myostrain.course import Course, value_at
from myostrain.engine import fem
from myostrain.geometry import Body
from myostrain.state import State
from myostrain.validation import description

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


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
        pattern: Factor on it at the nodes of P1, (nodes,); one everywhere unless given.

    Attributes:
        v: The potential, P1.
    """

    balance = "advective"
    isochoric = True
    solver = None
    calcium = None
    state_names: tuple[str, ...] = ()
    threshold = 0.5

    def __init__(self, body: Body, drive: Drive | None = None, pattern: Array | None = None) -> None:
        self.body, self.drive = body, drive or Drive()
        self.v = fem.Function(fem.functionspace(body.mesh, ("Lagrange", 1)), name="potential")
        self.states: Array = np.zeros((0, len(self.v.x.array)))
        self.seconds = 0.0
        self._pattern = 1.0 if pattern is None else pattern
        self._put(0.0)

    def __repr__(self) -> str:
        """The course."""
        return f"GivenPotential({self.drive!r})"

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest potential that comes, at least from 0 to 1."""
        course = self.drive.potential
        values = [v for _, v in course] if isinstance(course, tuple) else [float(course)]
        return min(0.0, *values), max(1.0, *values)

    def _put(self, time: float) -> None:
        self._value = value_at(self.drive.potential, time)
        self.v.x.array[:] = self._value * self._pattern

    def field_values(self) -> dict[str, Array]:
        """The potential at the nodes, by name."""
        return {"potential": self.v.x.array}

    def begin(self) -> None:
        """Begin at time 0."""
        self._put(0.0)

    def start(self, time: float = 0.0) -> None:
        """Begin at a time."""
        self._put(time)

    def solve(self, end: float, guess: Any = None, weights: Any = None) -> None:
        """Take the potential at the time ``end``."""
        self._put(end)

    def extrapolate(self, weights: Any) -> Array:
        """The present potential (nodal, local)."""
        return self.v.x.array

    def accept(self, time: float, keep: int) -> None:
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
        self.v.x.array[:] = self._value * self._pattern
