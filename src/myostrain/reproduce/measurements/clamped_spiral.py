"""Spirals in clamped squares."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.electrics import InitialValues, Place
from myostrain.output.tips import Tip, TipTable
from myostrain.reproduce.jobs import Array, Found
from myostrain.reproduce.measurements.clamped_sheet import EXCITED, SILENT, clamped_sheet, drawn
from myostrain.reproduce.measurements.matched import activation_of, currents, membrane_of
from myostrain.reproduce.measurements.stepping import stepped

import numpy as np


def spiral(
    membrane: Mapping[str, Any],
    approach: str,
    conductance: float,
    size: float,
    spacing: float,
    step: float,
    every: int,
    end: float,
    beta: float = 0.3,
    rise: float = 10.0,
    fall: float = 1.0,
) -> Found:
    """A spiral in a clamped square, begun from crossed fields as in the case ``spiral-2d``.

    Returns:
        Numbers: ``period``, ``radius``, ``drift``, ``deviation`` of the tip that is followed, in the
        reference body, None where there is no circle; ``tips`` at the last look and ``tips_max``;
        ``silent``, whether the sheet has come to rest, and ``end``, when it has, or the end. Arrays:
        ``path`` (t, 3): time, X and Y of the tip that was followed last; ``potential`` (n,) at the end,
        ``X`` (n, 2), ``cells`` (m, 3).
    """

    def box(x: float, y: float) -> Place:
        return Place(box=((0.0, 0.0), (x, y)))

    sixth, high = size / 6, size * 25 / 60
    initial = [
        InitialValues(where=box(sixth, size), potential=EXCITED),
        InitialValues(where=box(size, high), states={"recovery": 2.0}),
        InitialValues(where=box(sixth, high), potential=EXCITED, states={"recovery": 2.0}),
    ]
    contraction = activation_of(approach, beta, rise, fall)
    model = clamped_sheet(
        membrane_of(membrane), contraction, currents(conductance), initial, size, spacing, every
    )
    model.start()
    v, looks, table = model.potential.v.x.array, 2 * every, TipTable(model, Tip(), None)
    before = v.copy()
    path: list[Any] = []
    for number, _ in enumerate(stepped(model, step, end), start=1):
        if number % looks == 0:
            table.add(before, step)
            path = table.state()["path"] or path
        before[:] = v
        if v.max() < SILENT:
            break
    metrics = table.metrics()
    numbers: dict[str, Any] = {
        name: metrics[f"tip_{name}"] for name in ("period", "radius", "drift", "deviation")
    }
    numbers |= {"tips": metrics["tips"], "tips_max": metrics["tips_max"]}
    numbers |= {"silent": bool(v.max() < SILENT), "end": model.time}
    way: Array = np.array(path, dtype=np.float64)
    arrays = {
        "potential": v.copy(),
        "path": way.reshape(-1, 3),
        **drawn(model.potential),
    }
    return Found(numbers, arrays)
