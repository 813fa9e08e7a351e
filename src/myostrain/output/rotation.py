"""How the tip of a spiral turns: the period, the core and the drift of its trajectory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize_scalar

Array = npt.NDArray[np.float64]

#: Turns that are fitted, the last ones; the fewest; and the most that a trajectory is searched for.
TURNS, FEWEST, MOST = 3.0, 1.5, 60.0


@dataclass(frozen=True)
class Rotation:
    """A circle whose centre moves at a constant velocity.

    Attributes:
        period: Time of a turn.
        radius: Radius of the circle, that of the spiral's core.
        drift: Speed of its centre.
        deviation: Root mean square distance of the trajectory from the place on the moving circle.
    """

    period: float
    radius: float
    drift: float
    deviation: float


def rotation(time: Sequence[float], x: Sequence[float], y: Sequence[float]) -> Rotation | None:
    """Fit a circle with a moving centre to the end of a trajectory.

    x + i y = c + d t + r e^{iωt}, by least squares, linear but for ω: first over the later half, for a
    spiral needs time to settle, then over the last :data:`TURNS` turns.

    Args:
        time: Times (n,), increasing.
        x: Coordinates (n,).
        y: Coordinates (n,).

    Returns:
        The rotation; None where the trajectory has fewer than :data:`FEWEST` turns in its later half.
    """
    t, z = np.asarray(time, dtype=float), np.asarray(x, dtype=float) + 1j * np.asarray(y, dtype=float)
    if len(t) < 8:
        return None
    half = begin = 0.5 * (t[0] + t[-1])
    omega, drift, radius, deviation = _fit(t[t >= half], z[t >= half], None)
    for _ in range(2):
        begin = max(half, t[-1] - TURNS * 2 * np.pi / abs(omega))
        omega, drift, radius, deviation = _fit(t[t >= begin], z[t >= begin], omega)
    period = 2 * np.pi / abs(omega)
    if t[-1] - begin < (1 - 1e-6) * FEWEST * period or radius <= deviation:
        return None
    return Rotation(period, radius, drift, deviation)


def _fit(t: Array, z: npt.NDArray[np.complex128], near: float | None) -> tuple[float, float, float, float]:
    """ω, the speed of the centre, the radius and the deviation; ω near a value, or any."""
    s = (t - t.mean()) / (t[-1] - t[0])
    basis, _ = np.linalg.qr(np.column_stack([np.ones_like(s), s]))
    rest = z - basis @ (basis.T @ z)

    def left(turns: Array) -> Array:
        """What a circle with so many turns leaves of the sum of squares."""
        waves = np.exp(2j * np.pi * np.multiply.outer(turns, s))
        waves = waves - (waves @ basis) @ basis.T
        return -(np.abs(waves.conj() @ rest) ** 2) / (np.abs(waves) ** 2).sum(axis=-1)

    if near is None:
        some = np.arange(1.0, min(MOST, len(t) / 4), 0.125)
        some = np.concatenate([-some, some])
        middle = some[left(some).argmin()]
    else:
        middle = near * (t[-1] - t[0]) / (2 * np.pi)
    turns = minimize_scalar(left, bounds=(middle - 0.4, middle + 0.4), method="bounded").x
    terms = np.column_stack([np.ones_like(s), s, np.exp(2j * np.pi * turns * s)])
    found = np.linalg.lstsq(terms, z, rcond=None)[0]
    deviation = float(np.sqrt(np.mean(np.abs(terms @ found - z) ** 2)))
    span = t[-1] - t[0]
    return float(2 * np.pi * turns / span), float(abs(found[1]) / span), float(abs(found[2])), deviation
