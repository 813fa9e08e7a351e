"""What a solver needs to go on from where it is, as a tree of named values that a checkpoint can hold.

An object with a state has ``state()``, which gives such a tree and copies nothing that is never changed in
place, and ``restore(state)``, after which it goes on bit by bit as the one that gave the state.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from myostrain.engine import fem

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

State = dict[str, Any]
"""Values by name: numbers, texts, None, :class:`FieldState`, :class:`CellState`, lists of these, and
further states."""


@dataclass(frozen=True, eq=False)
class FieldState:
    """Values of a function: its space, and the local array, ghosts included."""

    space: fem.FunctionSpace
    values: Array

    @classmethod
    def of(cls, function: fem.Function) -> FieldState:
        """A copy of a function's present values."""
        return cls(function.function_space, function.x.array.copy())

    def put(self, function: fem.Function) -> None:
        """Give the function these values."""
        function.x.array[:] = self.values


@dataclass(frozen=True, eq=False)
class CellState:
    """Values at the corners of some cells: the P1 space that numbers the corners, cells, and values.

    The cells are those of this process, in rising order; the values are (cells, corners, values a corner),
    with the corners in the order of the space.
    """

    space: fem.FunctionSpace
    cells: npt.NDArray[np.int64]
    values: Array
