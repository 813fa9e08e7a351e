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
        self.clear()

    def clear(self) -> None:
        """Forget the past: the iteration is another one now."""
        self._last: tuple[Array, Array] | None = None
        # Changes from each correction to the next: of x and the correction together, and of what is measured.
        self._moved: list[Array] = []
        self._changed: list[Array] = []

    def step(self, x: Array, correction: Array) -> Array:
        """What to add to x, where the plain iteration adds the correction; both arrays are kept."""
        step = correction
        if self._last is not None:
            change = correction - self._last[1]
            moved = x - self._last[0]
            moved += change
            self._moved = [*self._moved, moved][-self._memory :]
            self._changed = [*self._changed, change[self._measured]][-self._memory :]
            rows = np.stack([*self._changed, correction[self._measured]]).T
            triangle = np.linalg.qr(rows, mode="r")
            if self._comm.size > 1:  # of all processes together
                triangle = np.linalg.qr(np.vstack(self._comm.allgather(triangle)), mode="r")
            weights = np.linalg.lstsq(triangle[:, :-1], triangle[:, -1], rcond=1e-10)[0]
            step = correction.copy()
            for weight, past in zip(weights, self._moved, strict=True):
                step -= weight * past
        if self._memory:
            self._last = x, correction
        return step
