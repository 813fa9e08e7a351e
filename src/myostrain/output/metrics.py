"""Numbers that describe a pulse, from arrays of nodal values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: The level at which activation, fronts and widths are taken unless a membrane has another threshold.
LEVEL = 0.5


@dataclass(frozen=True)
class LeadingPulse:
    """The pulse farthest along a line, at one time.

    Args:
        front: Material X of the crossing of the level that leads.
        back: Material X of the crossing behind it, None for a front without a back.
        slope: |∂v/∂X| at the leading crossing.
        width_spatial: Distance of front and back in x, None without a back.
    """

    front: float
    back: float | None
    slope: float
    width_spatial: float | None

    @property
    def width_material(self) -> float | None:
        """Distance of front and back in X."""
        return None if self.back is None else self.front - self.back


def leading_pulse(X: Array, x: Array, v: Array, level: float = LEVEL) -> LeadingPulse | None:
    """The pulse that leads in the direction of growing X, None where v does not cross the level.

    Args:
        X: Material coordinates (n,), ascending.
        x: Spatial coordinates (n,) of the same points.
        v: Potential (n,).
        level: The potential at which front and back are taken.
    """
    v = v - level
    above = v >= 0
    changes = np.flatnonzero(above[1:] != above[:-1]).tolist()
    downward = [i for i in changes if above[i]]
    if not downward:
        return None
    lead = downward[-1]
    front, slope = _crossing(X, v, lead)
    upward = [i for i in changes if i < lead]
    if not upward:
        return LeadingPulse(front, None, slope, None)
    back, _ = _crossing(X, v, upward[-1])
    front_x, _ = _crossing(x, v, lead)
    back_x, _ = _crossing(x, v, upward[-1])
    return LeadingPulse(front, back, slope, front_x - back_x)


def _crossing(X: Array, v: Array, i: int) -> tuple[float, float]:
    """Place after node i where v = 0, and |slope| there, by the cubic through four nodes."""
    lo = min(max(i - 1, 0), max(len(X) - 4, 0))
    picked = slice(lo, min(lo + 4, len(X)))
    origin, scale = X[i], X[i + 1] - X[i]
    s = (X[picked] - origin) / scale
    cubic = np.polynomial.Polynomial.fit(s, v[picked], len(s) - 1, domain=[0, 1], window=[0, 1])
    roots: list[complex] = cubic.roots().tolist()
    inside = [r.real for r in roots if abs(r.imag) < 1e-9 and -1e-9 <= r.real <= 1 + 1e-9]
    linear = -v[i] / (v[i + 1] - v[i])
    place = min(inside, key=lambda r: abs(r - linear)) if inside else linear
    return float(origin + place * scale), float(abs(cubic.deriv()(place) / scale))


def last_durations(beats: Array, ends: Array) -> Array:
    """Duration (nodes,) of the last beat of each node that has ended, NaN where none has.

    Args:
        beats: Activation times (beats, nodes).
        ends: Repolarisation times (beats or fewer, nodes).
    """
    found = np.full(beats.shape[1], np.nan)
    for begun, ended in zip(beats, ends, strict=False):
        found = np.where(np.isnan(ended), found, ended - begun)
    return found
