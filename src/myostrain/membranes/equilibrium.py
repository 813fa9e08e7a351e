"""The state in which a membrane rests, where it is no closed form."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from myostrain.errors import InputError
from myostrain.membranes.linearly_implicit import COMPLEX_STEP

import numpy as np

#: Newton steps at most; from near the rest it takes four to six.
STEPS = 50


def equilibrium(membrane: Any, v: float, states: Sequence[float]) -> tuple[float, ...]:
    """Potential and states at which the current and all rates vanish, by Newton's method.

    Args:
        membrane: The model.
        v: Potential near the rest.
        states: States near the rest.

    Raises:
        InputError: There is none near.
    """
    at = np.array([v, *states], dtype=float)
    size = len(at)
    with np.errstate(all="ignore"):
        for _ in range(STEPS):
            # Column k is shifted in unknown k, so that one call gives the whole Jacobian.
            y = at[:, np.newaxis] + 1j * COMPLEX_STEP * np.eye(size)
            found = [membrane.current(y[0], y[1:]), *membrane.rates(y[0], y[1:])]
            residual = np.array([np.broadcast_to(f, size) for f in found])
            jacobian = residual.imag / COMPLEX_STEP
            if not np.isfinite(residual).all() or np.linalg.cond(jacobian) > 1e15:
                break
            shift = np.linalg.solve(jacobian, residual.real[:, 0])
            at = at - shift
            if (np.abs(shift) <= 1e-14 * np.maximum(np.abs(at), 1e-8)).all():
                return tuple(map(float, at))
    raise InputError(
        f"{type(membrane).__name__} has no rest near {v:g} with these parameters; change them by less",
        "cell.model",
    )
