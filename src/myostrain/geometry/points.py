"""The cells in which points lie."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from dolfinx import geometry as dgeometry

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

#: How far outside a cell a point may be, as a share of the cell's height, and still be in it: coordinates of
#: single precision must do.
OUTSIDE = 1e-6


def cells_at(mesh: Any, points: Array) -> tuple[Indices, Indices, Array]:
    """The cells of this process in which points lie, on a mesh of straight cells of any size.

    DOLFINx's own search takes a cell for one that holds a point if it is nearer than some absolute distance,
    which in a body of micrometres, measured in metres, is many a cell.

    Args:
        mesh: A DOLFINx mesh of lines, triangles or tetrahedra.
        points: Points (n, dim), or more coordinates, the others of which are zero in the mesh.

    Returns:
        For each pair of a point and a cell that holds it, by ascending points and then cells: the point's
        number, the cell's local one, and the barycentric coordinates (pairs, dim + 1) by the order of the
        cell's nodes in the mesh's geometry. A point on a side is in all cells that meet there.
    """
    dim = mesh.topology.dim
    owned = mesh.topology.index_map(dim).size_local
    padded = np.zeros((len(points), 3))
    padded[:, : points.shape[1]] = points
    corners = mesh.geometry.x[mesh.geometry.dofmaps[0][:owned]]
    if not owned or not len(points):
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, dim + 1))
    size = np.ptp(corners, axis=1).max()
    tree = dgeometry.bb_tree(mesh, dim, entities=np.arange(owned, dtype=np.int32), padding=OUTSIDE * size)
    near = dgeometry.compute_collisions_points(tree, padded)
    place = np.repeat(np.arange(len(points)), np.diff(near.offsets))
    cell = near.array.astype(np.int64)
    edges = (corners[cell, 1:] - corners[cell, :1])[..., :dim]
    others = np.linalg.solve(np.swapaxes(edges, 1, 2), (padded[place] - corners[cell, 0])[:, :dim, None])
    weights = np.concatenate([1 - others.sum(axis=1), others[..., 0]], axis=1)
    off = np.abs((padded[place] - corners[cell, 0])[:, dim:]).max(axis=1, initial=0.0)
    inside = (weights.min(axis=1) >= -OUTSIDE) & (off <= OUTSIDE * size)
    order = np.lexsort((cell[inside], place[inside]))
    return place[inside][order], cell[inside][order], weights[inside][order]
