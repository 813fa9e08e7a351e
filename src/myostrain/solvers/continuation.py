"""Load continuation: where one jump of the loads is too far, smaller ones find the way."""

from __future__ import annotations

from collections.abc import Callable

from myostrain.errors import ComputationError

import numpy as np
import numpy.typing as npt

#: The smallest share of a change of loads that is tried.
SMALLEST = 2.0**-8


def follow(jump: Callable[[float], None], u: npt.NDArray[np.float64]) -> None:
    """Go from share 0 of a change of loads, where ``u`` is in equilibrium, to all of it.

    A jump that fails is tried again with half its length, one that succeeds lets the next be longer; each
    begins on the secant through the last two configurations.

    Args:
        jump: Finds the equilibrium at a share of the change from the present ``u``.
        u: The unknown, written in place.

    Raises:
        ComputationError: A jump of :data:`SMALLEST` failed; ``u`` is then what it was before.
    """
    start = u.copy()
    done, length = 0.0, 0.25
    last, before, step = u.copy(), u.copy(), 0.0  # the last two configurations, and the share between them
    while done < 1.0:
        length = min(length, 1.0 - done)
        u[:] = last + (last - before) * (length / step if step else 0.0)
        try:
            jump(done + length)
        except ComputationError as error:
            length /= 2
            if length < SMALLEST:
                u[:] = start
                raise ComputationError(
                    f"{error.reason}; {done:.1%} of the change of the loads were reached, by steps down to "
                    f"{SMALLEST:.2%}",
                    where=error.where,
                    advice=error.advice,
                ) from error
            continue
        done, step, before, last = done + length, length, last, u.copy()
        if 1.0 - done < 1e-12:
            break
        length *= 1.5
