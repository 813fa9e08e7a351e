"""Anderson's acceleration of a fixed-point iteration."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Anderson:
    """Combines the last corrections so that what is left of them is least.

    D. G. Anderson, J. ACM 12 (1965) 547–560, doi 10.1145/321296.321305. On a linear problem it is as good as
    GMRES with the iteration as its preconditioner (H. F. Walker, P. Ni, SIAM J. Numer. Anal. 49 (2011)
    1715–1735, doi 10.1137/10078356X).

    Args:
        memory: Past corrections that are used; none gives the plain iteration.
        measured: Entries in which corrections are measured.
        comm: The processes that the vectors are spread over.
    """

    def __init__(self, memory: int, measured: npt.NDArray[np.int32] | slice, comm: Any) -> None:
        self._memory, self._measured, self._comm = memory, measured, comm
        self._past: list[tuple[Array, Array]] = []

    def clear(self) -> None:
        """Forget the past: the iteration is another one now."""
        self._past = []

    def step(self, x: Array, correction: Array) -> Array:
        """What to add to x, where the plain iteration adds the correction; both arrays are kept."""
        step = correction
        if self._past:
            moved = np.stack([x - old for old, _ in self._past], axis=1)
            changed = np.stack([correction - old for _, old in self._past], axis=1)
            rows = np.column_stack([changed[self._measured], correction[self._measured]])
            triangle = np.linalg.qr(rows, mode="r")
            if self._comm.size > 1:  # of all processes together
                triangle = np.linalg.qr(np.vstack(self._comm.allgather(triangle)), mode="r")
            weights = np.linalg.lstsq(triangle[:, :-1], triangle[:, -1], rcond=1e-10)[0]
            step = correction - (moved + changed) @ weights
        if self._memory:
            self._past = [*self._past, (x, correction)][-self._memory :]
        return step
