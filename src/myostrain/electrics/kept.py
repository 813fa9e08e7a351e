"""What the kept preconditioner of the potential was made of, to make it again after a restart."""

from __future__ import annotations

from myostrain.electrics.diffusion import Diffusion
from myostrain.engine import fem
from myostrain.solvers.linear import LinearSolver
from myostrain.state import FieldState, State

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class KeptPreconditioner:
    """The matrix of which the kept preconditioner was made, by what it was assembled from.

    Args:
        diffusion: What assembles it.
        solver: What keeps the preconditioner.
        space: P1 space of the potential.

    Attributes:
        weight: The time derivative's factor in it, 0 before the first step.
    """

    def __init__(self, diffusion: Diffusion, solver: LinearSolver, space: fem.FunctionSpace) -> None:
        self._diffusion, self._solver, self._space = diffusion, solver, space
        self.weight = 0.0
        self._origin: State = {}

    def forget(self) -> None:
        """The next solve makes a new one."""
        self._solver.forget()
        self.weight = 0.0

    def follow(self, weight: float) -> None:
        """Give it up where the time derivative's factor is another one."""
        # Times are sums, so that equal steps give weights that differ in the last bits.
        if abs(weight - self.weight) > 1e-9 * abs(weight):
            self.forget()
            self.weight = float(weight)

    def take(self, diagonal: Array) -> None:
        """Remember the matrix if the next solve makes a preconditioner of it.

        Args:
            diagonal: What was added to its diagonal (nodes,).
        """
        if self._solver.renews:
            added = FieldState(self._space, diagonal)
            self._origin = {"body": self._diffusion.body(), "diagonal": added}

    def state(self) -> State:
        """What it was made of."""
        return {"weight": self.weight, "origin": self._origin}

    def restore(self, state: State) -> None:
        """Make that of a state again; the matrix of the present step is to be assembled after it."""
        self.weight = state["weight"]
        if state["origin"] and state["origin"] is not self._origin:
            self._origin = state["origin"]
            present = self._diffusion.body()
            self._diffusion.put_body(self._origin["body"])
            self._diffusion.put_again(self.weight, self._origin["diagonal"].values)
            self._solver.precondition()
            self._diffusion.put_body(present)
