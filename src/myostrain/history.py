"""Past values of fields, and the formulas that use them: extrapolation and backward differences."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from myostrain.engine import fem
from myostrain.state import FieldState, State

import numpy as np
import numpy.typing as npt


def extrapolation_weights(times: Sequence[float], time: float) -> npt.NDArray[np.float64]:
    """Weights (n,) of values at ``times`` (n,) in the polynomial through them, evaluated at ``time``."""
    t = np.asarray(times, dtype=float)
    weights = np.ones(len(t))
    for i in range(len(t)):
        for j in range(len(t)):
            if i != j:
                weights[i] *= (time - t[j]) / (t[i] - t[j])
    return weights


def backward_difference(times: Sequence[float]) -> npt.NDArray[np.float64]:
    """Weights (n,) of values at ``times`` (n,), newest first, in the time derivative at the newest.

    Two times give the first-order backward difference, three the second-order one (BDF2, any step sizes).
    """
    t = np.asarray(times, dtype=float)
    n = len(t)
    powers = np.vander(t - t[0], n, increasing=True).T  # row p: (t_j − t_0)^p
    scale = np.abs(t[-1] - t[0])
    rhs = np.zeros(n)
    rhs[1] = 1.0 / scale
    return np.linalg.solve(powers / scale ** np.arange(n)[:, None], rhs)


class History:
    """The last few values of a field, newest first, with their times.

    Args:
        function: The field.
        depth: How many values are kept.

    Attributes:
        times: Times of the kept values, newest first.
        values: The values, arrays as long as the field's local array, newest first.
    """

    def __init__(self, function: fem.Function, depth: int) -> None:
        self._function, self.depth = function, depth
        self.times: list[float] = []
        self.values: list[npt.NDArray[np.float64]] = []

    def push(self, time: float) -> None:
        """Keep the field's present value as that at ``time``, no earlier than all kept ones.

        It takes the place of one that is kept for the same time.
        """
        past = slice(1 if self.times[:1] == [time] else 0, None)
        self.times = [time, *self.times[past]][: self.depth]
        self.values = [self._function.x.array.copy(), *self.values[past]][: self.depth]

    def state(self) -> State:
        """Times and values; the arrays are never changed afterwards."""
        space = self._function.function_space
        return {"times": self.times, "values": [FieldState(space, value) for value in self.values]}

    def restore(self, state: State) -> None:
        """Take times and values from a state."""
        self.times = list(state["times"])
        self.values = [field.values for field in state["values"]]

    def clear(self) -> None:
        """Forget all values: nothing smooth connects them with what comes."""
        self.times, self.values = [], []

    def predict(
        self, time: float, size: Callable[[npt.NDArray[np.float64]], float], out: npt.NDArray[np.float64]
    ) -> None:
        """Write the value at ``time`` by the polynomial that would have met the newest value best.

        Of n values, orders up to n − 2 can be tried. Where the highest is best, one order more is taken.

        Args:
            time: The time.
            size: Norm of a local array, the same on all processes (collective).
            out: The value.
        """
        tried = []
        for order in range(len(self.times) - 1):
            weights = extrapolation_weights(self.times[1 : order + 2], self.times[0])
            missed = self.values[0].copy()
            for weight, value in zip(weights, self.values[1:], strict=False):
                missed -= weight * value
            tried.append(size(missed))
        best = int(np.argmin(tried)) if tried else 0
        self.extrapolate(time, best + (best == len(tried) - 1), out)

    def extrapolate(self, time: float, order: int, out: npt.NDArray[np.float64]) -> None:
        """Write the value at ``time`` by a polynomial of at most ``order`` through the newest values."""
        points = min(order + 1, len(self.times))
        if points == 0:
            return
        weights = extrapolation_weights(self.times[:points], time)
        np.multiply(self.values[0], weights[0], out=out)
        for weight, value in zip(weights[1:], self.values[1:points], strict=True):
            out += weight * value
