"""A pulse along a line or a free strip: where it is, how long in X and x, and the contraction behind it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.output.metrics import leading_pulse
from myostrain.reproduce.jobs import Array, Found, Job
from myostrain.reproduce.measurements import cases
from myostrain.reproduce.measurements.cases import resolved
from myostrain.reproduce.measurements.signals import delays

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
