"""The outward normal of a part of the boundary, as that of the smooth surface which its facets stand for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from myostrain.engine import MPI, fem
from myostrain.geometry import Body
from myostrain.geometry.corners import corner_nodes
from myostrain.mechanics.rigid_motions import surface

import numpy as np
import ufl
from dolfinx import mesh as dmesh
from dolfinx.la import InsertMode

#: Product of a facet's normal with the one at its nodes on a smooth part, at least: 40 degrees between.
SMOOTH = 0.77

#: How often normals are turned until they fit each other.
SWEEPS = 40


def smooth_normal(body: Body, parts: Sequence[str] | None) -> Any:
    """Outward unit normal on parts of the boundary, UFL: continuous where these are smooth.

    At a node facets count by N. Max's weights, e₁ × e₂/(|e₁|² |e₂|²) with the edges e₁, e₂ from the node (on
    a sheet, a normal over the edge's length), which give the normal of a sphere through the nodes exactly;
    in three dimensions they are then turned until they fit each other along the edges, which is exact to
    second order on any smooth surface. Between nodes the normal is linear, made a unit vector.
    By the facets' own normals a body that slides on a curved support would be held wherever facets meet, as
    there it would have to move along all of them. Parts with edges of their own, such as all of a box, and
    the ends of a line keep the facets' normals.

    Source: N. Max, J. Graphics Tools 4 (1999) 1–6, doi 10.1080/10867651.1999.10487501.

    Args:
        body: The reference body.
        parts: Names of the parts; None for all of the boundary.
    """
    mesh, dim = body.mesh, body.dim
    own = ufl.FacetNormal(mesh)
    if dim == 1:
        return own
    facets = body.boundary_facets(parts)
    facets = facets[facets < mesh.topology.index_map(dim - 1).size_local]
    corners, normals = surface(body, parts)
    edges = np.stack([np.roll(corners, -i, axis=1) - corners for i in range(1, dim)])
    squares = (edges**2).sum(axis=-1)  # (edges of a node, facets, nodes)
    if dim == 2:
        weights = 1 / np.sqrt(squares[0])
    else:
        areas = np.linalg.norm(np.cross(edges[0], edges[1]), axis=-1)
        weights = areas / squares.prod(axis=0)
    space = fem.functionspace(mesh, ("Lagrange", 1, (dim,)))
    mean = fem.Function(space)
    at_nodes = mean.x.array.reshape(-1, dim)
    nodes = _nodes(body, space, facets)
    np.add.at(at_nodes, nodes, weights[..., None] * normals[:, None, :])
    mean.x.scatter_reverse(InsertMode.add)
    mean.x.scatter_forward()
    lengths = np.linalg.norm(at_nodes, axis=1, keepdims=True)
    at_nodes /= np.where(lengths > 0, lengths, 1.0)
    least = float(np.einsum("fni,fi->fn", at_nodes[nodes], normals).min(initial=1.0))
    if body.comm.allreduce(least, MPI.MIN) < SMOOTH:
        return own
    if dim == 3:
        for _ in range(SWEEPS):
            _straighten(mean, nodes, corners)
    return mean / ufl.sqrt(ufl.inner(mean, mean))


def _straighten(mean: fem.Function, nodes: np.ndarray, corners: np.ndarray) -> None:
    """Turn each normal half way to that which, with those at the other ends of its edges, fits these best.

    The normals at the two ends of an edge e have opposite shares along it, (n₁ + n₂)·e = 0: exactly on a
    sphere, and on another smooth surface to third order in |e|, also at a rim with facets on one side only.
    """
    n = mean.x.array.reshape(-1, 3)
    ends = [(i, (i + shift) % 3) for i in range(3) for shift in (1, 2)]
    first, second = (nodes[:, [pair[k] for pair in ends]].ravel() for k in (0, 1))
    e = np.concatenate([corners[:, j] - corners[:, i] for i, j in ends], axis=1).reshape(-1, 3)
    e /= np.linalg.norm(e, axis=1, keepdims=True)
    matrix, right = fem.Function(_tensors(mean, (3, 3))), fem.Function(mean.function_space)
    np.add.at(matrix.x.array.reshape(-1, 3, 3), first, e[:, :, None] * e[:, None, :])
    share = ((n[first] + n[second]) * e).sum(axis=1)
    np.add.at(right.x.array.reshape(-1, 3), first, -share[:, None] * e)
    for function in (matrix, right):
        function.x.scatter_reverse(InsertMode.add)
        function.x.scatter_forward()
    on = np.flatnonzero((n**2).sum(axis=1) > 0)
    A = matrix.x.array.reshape(-1, 3, 3)[on] + n[on][:, :, None] * n[on][:, None, :]
    n[on] += np.linalg.solve(A, right.x.array.reshape(-1, 3)[on][..., None])[..., 0] / 2
    n[on] /= np.linalg.norm(n[on], axis=1, keepdims=True)


def _tensors(mean: fem.Function, shape: tuple[int, ...]) -> fem.FunctionSpace:
    return fem.functionspace(mean.function_space.mesh, ("Lagrange", 1, shape))


def _nodes(body: Body, space: fem.FunctionSpace, facets: np.ndarray) -> np.ndarray:
    """Numbers in a P1 space of the corners of facets (facets, dim), as :func:`surface` has them."""
    mesh, dim = body.mesh, body.dim
    if not len(facets):
        return np.zeros((0, dim), dtype=np.int64)
    corners = dmesh.entities_to_geometry(mesh, dim - 1, facets)[:, :dim]
    number = np.empty(len(mesh.geometry.x), dtype=np.int64)
    number[corner_nodes(mesh).ravel()] = space.dofmap.list.ravel()
    return number[corners]
