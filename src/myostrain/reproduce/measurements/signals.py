"""What is read off values over time or place: crossings, tops, limits."""

from __future__ import annotations

from myostrain.reproduce.jobs import Array

import numpy as np


def first_rise(times: Array, values: Array, level: float) -> float | None:
    """When values first rise through a level, linear in time."""
    rises = np.flatnonzero((values[:-1] < level) & (values[1:] >= level))
    if not len(rises):
        return None
    i = rises[0]
    share = (level - values[i]) / (values[i + 1] - values[i])
    return float(times[i] + share * (times[i + 1] - times[i]))


def last_fall(times: Array, values: Array, level: float) -> float | None:
    """When values last fall through a level, linear in time."""
    falls = np.flatnonzero((values[:-1] >= level) & (values[1:] < level))
    if not len(falls):
        return None
    i = falls[-1]
    share = (values[i] - level) / (values[i] - values[i + 1])
    return float(times[i] + share * (times[i + 1] - times[i]))


def wave(times: Array, values: Array) -> dict[str, float | None]:
    """A wave at one place.

    Args:
        times: Times (n,), ascending.
        values: Values (n,).

    Returns:
        The largest value ``peak``; when it is reached, ``peak_time``, the top of the parabola through three
        samples; when half of it is reached first, ``rise_time``; and for how long it is exceeded,
        ``duration``; None where that has not happened.
    """
    i = int(np.argmax(values))
    half = values[i] / 2
    rise, fall = first_rise(times, values, half), first_rise(times[i:], -values[i:], -half)
    inside = 0 < i < len(values) - 1
    return {
        "peak": float(values[i]),
        "peak_time": lowest(times[i - 1 : i + 2], -values[i - 1 : i + 2])[0] if inside else float(times[i]),
        "rise_time": rise,
        "duration": None if fall is None or rise is None else fall - rise,
    }


def delays(times: Array, potential: Array, shortening: Array) -> dict[str, float | None]:
    """By how much the shortening at a place comes after the potential.

    Args:
        times: Times (m,), ascending.
        potential: v (m,) at the place.
        shortening: 1 − x′ (m,) there.

    Returns:
        ``peak_delay`` and ``rise_delay``: differences of the times of :func:`wave`. None where the line does
        not shorten, or where it still does at the last sample.
    """
    if shortening.max() < 1e-12 or np.argmax(shortening) == len(times) - 1:
        return {"peak_delay": None, "rise_delay": None}
    early, late = wave(times, potential), wave(times, shortening)
    return {f"{of}_delay": difference(late[f"{of}_time"], early[f"{of}_time"]) for of in ("peak", "rise")}


def difference(late: float | None, early: float | None) -> float | None:
    """None where one of them does not exist."""
    return None if late is None or early is None else late - early


def lowest(x: Array, y: Array) -> tuple[float, float]:
    """Place and value of the least y: the bottom of the parabola through the lowest point and its neighbours.

    Args:
        x: Places (n,), ascending, n ≥ 3.
        y: Values (n,); their least lies inside.

    Raises:
        ValueError: The least value is the first or the last.
    """
    i = int(np.argmin(y))
    if i in (0, len(y) - 1):
        raise ValueError("the least value lies at an end")
    a, b, c = np.polyfit(x[i - 1 : i + 2] - x[i], y[i - 1 : i + 2], 2)
    place = -b / (2 * a)
    return float(x[i] + place), float(c + b * place / 2)


def extrapolated(coarse: float, fine: float, ratio: float = 2.0, order: float = 2.0) -> float:
    """The value at h = 0 from two meshes (Richardson).

    Args:
        coarse: Value at h.
        fine: Value at h / ratio.
        ratio: Ratio of the meshes.
        order: Order of the error.
    """
    return fine + (fine - coarse) / (ratio**order - 1)
