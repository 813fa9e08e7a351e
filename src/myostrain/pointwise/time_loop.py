"""A pointwise formula that is taken again and again: a loop over time, compiled."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

from myostrain.engine import MPI
from myostrain.pointwise.c_source import c_source
from myostrain.pointwise.compiler import library
from myostrain.pointwise.expressions import Expression

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: Beside ``evaluate``: the same formulas at one node, whose results are given to the next step.
_ADVANCE = """
long advance(long steps, long every, const double *numbers, double *values, long watched_count,
             const long *watched, double *seen, double *sampled)
{
  double fixed[FIXED + 1], state[INPUTS + 1][LANES];
  double *at[INPUTS + 1];
  for (int k = 0; k < INPUTS; ++k) {
    at[k] = state[k];
    for (int l = 0; l < LANES; ++l) state[k][l] = values[k];
  }
  const unsigned modes = without_tiny();
  prepare(numbers, fixed);
  long step = 0;
  for (; step < steps; ++step) {
    const long wrong = first_false(block((const double *const *)at, fixed, at, 0));
    for (int k = 0; k < INPUTS; ++k) values[k] = state[k][0];
    if (wrong >= 0) break;
    for (long w = 0; w < watched_count; ++w) seen[step*watched_count + w] = values[watched[w]];
    if ((step + 1) % every == 0)
      memcpy(sampled + ((step + 1)/every - 1)*INPUTS, values, INPUTS*sizeof(double));
  }
  with_modes(modes);
  return step;
}
"""

_POINTER = ctypes.POINTER(ctypes.c_double)


class TimeLoop:
    """Takes steps of one point: what a step gives is what the next one begins with.

    Args:
        inputs: The values before a step.
        scalars: What else is given, as numbers.
        outputs: The values after it, in the order of the inputs; and truth values, conditions that must hold.
        comm: Processes that make it together (collective).

    Attributes:
        compiled: Whether there is a compiler; without one it cannot be called.
    """

    def __init__(
        self,
        inputs: Sequence[Expression],
        scalars: Sequence[Expression],
        outputs: Sequence[Expression],
        comm: Any = MPI.COMM_SELF,
    ) -> None:
        self._size = len(inputs)
        source = c_source(inputs, scalars, outputs) + _ADVANCE
        found = library(source, comm)
        self.compiled = found is not None
        if found is not None:
            self._advance = found.advance
            self._advance.restype = ctypes.c_long

    def __call__(
        self, values: Array, numbers: Sequence[float], steps: int, every: int, watched: Sequence[int]
    ) -> tuple[Array, Array, int]:
        """Take steps.

        Args:
            values: Values (n,) at the beginning; at the end those after the last step.
            numbers: The scalars, in their order.
            steps: How many steps.
            every: All values are kept after each so many steps.
            watched: Which values are kept after each step.

        Returns:
            The watched values (steps, watched), all (steps // every, n), and the steps that were taken:
            fewer than asked where a condition does not hold; ``values`` are then those that break it.
        """
        seen = np.empty((steps, len(watched)))
        sampled = np.empty((steps // every, self._size))
        taken = self._advance(
            ctypes.c_long(steps),
            ctypes.c_long(every),
            (ctypes.c_double * max(len(numbers), 1))(*numbers),
            values.ctypes.data_as(_POINTER),
            ctypes.c_long(len(watched)),
            (ctypes.c_long * max(len(watched), 1))(*watched),
            seen.ctypes.data_as(_POINTER),
            sampled.ctypes.data_as(_POINTER),
        )
        return seen, sampled, int(taken)
