"""A pulse along a line or a free strip: where it is, how long in X and x, and the contraction behind it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.output.metrics import leading_pulse
from myostrain.reproduce.jobs import Array, Found, Job
from myostrain.reproduce.measurements import cases
from myostrain.reproduce.measurements.cases import resolved

import numpy as np


def pulse_job(
    name: str,
    overrides: Sequence[str] = (),
    *,
    frames: Sequence[float] = (),
    watch: float | None = None,
    cost: float = 1.0,
) -> Job:
    """The job that runs a named case along a line and measures its pulse, see :func:`pulse`.

    Args:
        name: The case.
        overrides: "KEY=VALUE", as on the command line.
        frames: Simulated times at which the fields are wanted, beside the end.
        watch: Material X at which potential and shortening are watched over time; None for nowhere.
        cost: Seconds that it takes, roughly.
    """
    parameters = {"case": resolved(name, overrides), "frames": list(frames), "watch": watch}
    return Job("lines.pulse", parameters, cost)


def pulse(case: Mapping[str, Any], frames: Sequence[float], watch: float | None) -> Found:
    """Run a case on a line, or on a strip 0 ≤ X ≤ length of which the edge Y = 0 is looked at.

    Returns:
        Numbers, of the end where not said otherwise, None where one does not exist: ``celerity`` (in X,
        between the first two probes), ``front_material`` and ``front_spatial``, where v falls through 0.5;
        ``width_material`` and ``width_spatial``, between there and where v rises through 0.5 behind;
        ``potential_max`` and ``potential_min``; ``half_width``, the length in X over which v is more than
        half its maximum; ``shortening_max`` of 1 − x′ and its ``shortening_half_width``;
        ``cells``, ``steps``. With ``watch`` ``peak_delay``, the time from the peak of v to that of 1 − x′
        there, and ``rise_delay``, between their upward crossings of half their maxima.
        Arrays: ``X`` (n,); ``times`` (frames,), ``x`` and ``potential`` (frames, n), the last at the end,
        x measured along the line from its left end. With ``watch`` ``watch_times`` (m,),
        ``watch_potential`` (m,) and ``watch_shortening`` (m,).
    """
    end, step = case["time"]["end"], case["time"]["step"]
    watched = [] if watch is None else np.arange(1, round(end / step)) * step
    run = cases.run(case, sorted({*frames, *watched}))
    edge = np.flatnonzero(np.all(np.abs(run.arrays["X"][:, 1:]) < 1e-9, axis=1))
    edge = edge[np.argsort(run.arrays["X"][edge, 0])]
    X = run.arrays["X"][edge, 0]
    # Lengths along the edge: a free strip may turn as a whole.
    places = run.arrays["X"][edge] + run.arrays["u"][:, edge]
    x = np.insert(np.cumsum(np.linalg.norm(np.diff(places, axis=1), axis=2), axis=1), 0, 0.0, axis=1)
    v = run.arrays["potential"][:, edge]
    metrics = run.numbers["metrics"]
    numbers = {
        "celerity": metrics["celerity"],
        **_place(X, x[-1], v[-1]),
        "potential_max": metrics["potential_max"],
        "potential_min": metrics["potential_min"],
        "half_width": half_width(X, v[-1]),
        **_shortened(X, x[-1]),
        "cells": run.numbers["cells"],
        "steps": run.numbers["steps"],
    }
    times = run.arrays["times"]
    wanted = [int(np.argmin(np.abs(times - time))) for time in (*frames, times[-1])]
    arrays = {"X": X, "times": times[wanted], "x": x[wanted], "potential": v[wanted]}
    if watch is not None:
        node = int(np.argmin(np.abs(X - watch)))
        shortening = 1 - (x[:, node + 1] - x[:, node - 1]) / (X[node + 1] - X[node - 1])
        numbers |= delays(times, v[:, node], shortening)
        arrays |= {
            "watch_times": times,
            "watch_potential": v[:, node],
            "watch_shortening": shortening,
        }
    return Found(numbers, arrays)


def half_width(X: Array, values: Array) -> float | None:
    """Length over which a pulse exceeds half its maximum, the leading one; None where it has no two ends.

    Args:
        X: Coordinates (n,), ascending.
        values: Values (n,).
    """
    top = float(values.max())
    found = leading_pulse(X, X, values / top) if top > 0 else None
    return None if found is None else found.width_material


def delays(times: Array, potential: Array, shortening: Array) -> dict[str, float | None]:
    """By how much the shortening at a place comes after the potential.

    Args:
        times: Times (m,), ascending.
        potential: v (m,) at the place.
        shortening: 1 − x′ (m,) there.

    Returns:
        ``peak_delay``, from the peak of v to that of 1 − x′, each the top of the parabola through three
        samples; ``rise_delay``, between their first upward crossings of half their maxima. None where the
        line does not shorten, or where it still does at the last sample.
    """
    if shortening.max() < 1e-12 or np.argmax(shortening) == len(times) - 1:
        return {"peak_delay": None, "rise_delay": None}
    return {
        "peak_delay": _peak_time(times, shortening) - _peak_time(times, potential),
        "rise_delay": _rise_time(times, shortening) - _rise_time(times, potential),
    }


def extrapolated(coarse: float, fine: float, ratio: float = 2.0, order: float = 2.0) -> float:
    """The value at h = 0 from two meshes (Richardson).

    Args:
        coarse: Value at h.
        fine: Value at h / ratio.
        ratio: Ratio of the meshes.
        order: Order of the error.
    """
    return fine + (fine - coarse) / (ratio**order - 1)


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


def _place(X: Array, x: Array, v: Array) -> dict[str, float | None]:
    """Front and widths of the leading pulse."""
    found = leading_pulse(X, x, v)
    names = ("front_material", "front_spatial", "width_material", "width_spatial")
    if found is None:
        return dict.fromkeys(names)
    # The front in x lies between the same two nodes; x is as smooth there as v.
    spatial = float(np.interp(found.front, X, x))
    return dict(zip(names, (found.front, spatial, found.width_material, found.width_spatial), strict=True))


def _shortened(X: Array, x: Array) -> dict[str, float | None]:
    """The wave of contraction, from the stretch of each cell."""
    shortening = 1 - np.diff(x) / np.diff(X)
    top = float(shortening.max())
    middle = (X[1:] + X[:-1]) / 2
    width = half_width(middle, shortening) if top > 1e-12 else None
    return {"shortening_max": top, "shortening_half_width": width}


def _peak_time(times: Array, values: Array) -> float:
    i = min(max(int(np.argmax(values)), 1), len(values) - 2)
    return lowest(times[i - 1 : i + 2], -values[i - 1 : i + 2])[0] if np.argmax(values) == i else times[i]


def _rise_time(times: Array, values: Array) -> float:
    half = values.max() / 2
    i = int(np.flatnonzero((values[:-1] < half) & (values[1:] >= half))[0])
    share = (half - values[i]) / (values[i + 1] - values[i])
    return float(times[i] + share * (times[i + 1] - times[i]))
