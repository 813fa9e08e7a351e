"""The conduction velocity in every place, from activation times."""

from __future__ import annotations

from typing import Any

from myostrain.engine import fem

import numpy as np
import numpy.typing as npt
from dolfinx import la

Array = npt.NDArray[np.float64]

#: How much of the gradients of the cells around a node is to be left in their mean: less is where waves meet,
#: begin or are blocked.
COHERENCE = 0.7


def conduction_velocity(space: fem.FunctionSpace, times: Array) -> Array:
    """Speed |∇T|⁻¹ of a wave front in material coordinates at the nodes of a P1 space (collective).

    ∇T is the mean of that of the linear interpolations on the cells around a node, weighted by their sizes.
    There is no speed, NaN, where all around has no time or is activated from the start (T ≤ 0), where all is
    activated at once, and where the gradients around a node cancel: where waves begin, meet or are blocked.

    Args:
        space: A scalar P1 space.
        times: Activation times (local nodes,), NaN for never.

    Returns:
        Speeds (local nodes,), a length over a time.
    """
    mesh = space.mesh
    dim, tdim = mesh.geometry.dim, mesh.topology.dim
    own = mesh.topology.index_map(tdim).size_local
    nodes = space.dofmap.list[:own]
    corners = mesh.geometry.x[mesh.geometry.dofmaps[0][:own, : tdim + 1], :dim]
    gradients, sizes = cell_gradients(corners, np.where(times > 0, times, np.nan)[nodes])
    lengths = np.linalg.norm(gradients, axis=1)
    known = np.isfinite(lengths)
    parts = np.column_stack([gradients, lengths])[known] * sizes[known, None]
    sums = la.vector(space.dofmap.index_map, dim + 1)
    rows = sums.array.reshape(-1, dim + 1)
    for corner in range(tdim + 1):
        np.add.at(rows, nodes[known, corner], parts)
    weights: Any = la.vector(space.dofmap.index_map)
    np.add.at(weights.array, nodes[known].reshape(-1), np.repeat(sizes[known], tdim + 1))
    for vector in (sums, weights):
        vector.scatter_reverse(la.InsertMode.add)
        vector.scatter_forward()
    mean, whole = np.linalg.norm(rows[:, :dim], axis=1), rows[:, dim]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((whole > 0) & (mean >= COHERENCE * whole), weights.array / mean, np.nan)


def cell_gradients(corners: Array, values: Array) -> tuple[Array, Array]:
    """Gradients (cells, dim) of linear functions on simplices, and the sizes (cells,) of these.

    Args:
        corners: Corners (cells, dim + 1, dim).
        values: Values at the corners (cells, dim + 1).
    """
    edges = corners[:, 1:] - corners[:, :1]
    gradients = np.linalg.solve(edges, (values[:, 1:] - values[:, :1])[..., None])[..., 0]
    factor = {1: 1.0, 2: 0.5, 3: 1 / 6}[edges.shape[2]]
    return gradients, factor * np.abs(np.linalg.det(edges))
