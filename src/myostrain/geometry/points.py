"""The cells in which points lie."""

from __future__ import annotations

from typing import Any

from myostrain.geometry.corners import is_curved

import basix
import numpy as np
import numpy.typing as npt
from dolfinx import geometry as dgeometry

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

#: How far outside a cell a point may be, as a share of the cell's height, and still be in it: coordinates of
#: single precision must do.
OUTSIDE = 1e-6

#: How far outside of the box about its nodes a curved cell may reach, as a share of the longest edge.
BULGE = 0.05

#: Corrections of Newton's method for the place in a curved cell.
CORRECTIONS = 8


def cells_at(mesh: Any, points: Array, reach: float = 0.0) -> tuple[Indices, Indices, Array]:
    """The cells of this process in which points lie, on a mesh of cells of any size.

    DOLFINx's own search takes a cell for one that holds a point if it is nearer than some absolute distance,
    which in a body of micrometres, measured in metres, is many a cell.

    Args:
        mesh: A DOLFINx mesh of lines, triangles or tetrahedra.
        points: Points (n, dim), or more coordinates, the others of which are zero in the mesh.
        reach: A length by which a point may be outside all the same, up to a hundredth of the cell's height.

    Returns:
        For each pair of a point and a cell that holds it, by ascending points and then cells: the point's
        number, the cell's local one, and the barycentric coordinates (pairs, dim + 1), those of the reference
        cell where it is curved, by the order of the cell's corners in the mesh's geometry. A point on a side
        is in all cells that meet there.
    """
    dim = mesh.topology.dim
    owned = mesh.topology.index_map(dim).size_local
    padded = np.zeros((len(points), 3))
    padded[:, : points.shape[1]] = points
    nodes = mesh.geometry.x[mesh.geometry.dofmaps[0][:owned]]
    corners = nodes[:, : dim + 1]
    if not owned or not len(points):
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, dim + 1))
    farthest = max(reach, OUTSIDE * np.ptp(corners, axis=1).max())
    if is_curved(mesh):  # whose edges may leave the box about their nodes
        farthest += BULGE * np.ptp(corners, axis=1).max()
    tree = dgeometry.bb_tree(mesh, dim, entities=np.arange(owned, dtype=np.int32), padding=farthest)
    near = dgeometry.compute_collisions_points(tree, padded)
    place = np.repeat(np.arange(len(points)), np.diff(near.offsets))
    cell = near.array.astype(np.int64)
    edges = (corners[cell, 1:] - corners[cell, :1])[..., :dim]
    # Columns of the inverse are gradients of weights: normals of the sides, as long as 1 / height.
    inverse = np.linalg.inv(edges)
    gradients = np.concatenate([-inverse.sum(axis=2, keepdims=True), inverse], axis=2)
    others = np.einsum("pk,pki->pi", (padded[place] - corners[cell, 0])[:, :dim], inverse)
    if is_curved(mesh):
        others = _pulled_back(mesh, nodes[cell][..., :dim], padded[place][:, :dim], others)
    weights = np.concatenate([1 - others.sum(axis=1, keepdims=True), others], axis=1)
    outside = np.clip(reach * np.linalg.norm(gradients, axis=1), OUTSIDE, 1e-2)
    off = np.abs((padded[place] - corners[cell, 0])[:, dim:]).max(axis=1, initial=0.0)
    inside = (weights >= -outside).all(axis=1) & (off <= farthest)
    order = np.lexsort((cell[inside], place[inside]))
    return place[inside][order], cell[inside][order], weights[inside][order]


def _pulled_back(mesh: Any, nodes: Array, points: Array, guess: Array) -> Array:
    """Places (n, dim) in the reference cell that curved cells of these nodes (n, nodes, dim) map to points.

    By Newton's method; of a point far outside of the cell whatever that gives, or no number.
    """
    cell = getattr(basix.CellType, mesh.topology.cell_type.name)
    element = basix.create_element(
        basix.ElementFamily.P, cell, mesh.geometry.cmaps[0].degree, basix.LagrangeVariant.equispaced
    )
    found = guess.copy()
    with np.errstate(all="ignore"):
        for _ in range(CORRECTIONS):
            values = element.tabulate(1, np.clip(found, -1.0, 2.0))[..., 0]  # (1 + dim, n, nodes)
            off = np.einsum("pk,pkd->pd", values[0], nodes) - points
            jacobian = np.einsum("ipk,pkd->pdi", values[1:], nodes)
            found = found - np.einsum("pij,pj->pi", np.linalg.pinv(jacobian), off)
    return np.where(np.isfinite(found), found, np.inf)
