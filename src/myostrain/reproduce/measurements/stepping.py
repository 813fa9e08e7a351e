"""Models stepped from their start to an end."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from myostrain.electrics import Potential
from myostrain.reproduce.jobs import Array

import numpy as np


def stepped(model: Any, step: float, end: float, begin: float = 0.0) -> Iterator[float]:
    """Step a model that has been started, or is at ``begin``; gives the time after each step."""
    for number in range(round(begin / step) + 1, round(end / step) + 1):
        model.step(number * step)
        yield number * step


def along(potential: Potential) -> Array:
    """X of the potential's nodes (nodes,)."""
    return np.asarray(potential.v.function_space.tabulate_dof_coordinates()[:, 0])


def recorded(model: Any, step: float, end: float, nodes: Any) -> tuple[Array, Array]:
    """Start a model and step it: the times (t,), and the potential of a node, or of some, then."""
    model.start()
    v = model.potential.v.x.array
    rows = [v[nodes], *(v[nodes] for _ in stepped(model, step, end))]
    return np.linspace(0.0, end, len(rows)), np.array(rows)
