"""Rigid motions that supports leave free, the loads along them, and the few points that stop a drift."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from myostrain.engine import MPI, fem
from myostrain.geometry import Body

import numpy as np
import numpy.typing as npt
from dolfinx import mesh as dmesh

Array = npt.NDArray[np.float64]

#: Rigid motions by the body's dimension.
MODES = {1: 1, 2: 3, 3: 6}


class RigidMotions:
    """The rigid motions (1, 3 or 6) that supports leave free.

    Args:
        body: The reference body.
        held: Parts of the boundary (None for all of it) and the axes along which they are held, None for
            their normals.

    Attributes:
        free: The motions left, orthonormal columns: of translations along the axes and rotations about them
            (for which lengths are measured from the body's middle, in units of its size).
    """

    def __init__(self, body: Body, held: Sequence[tuple[Sequence[str] | None, Sequence[int] | None]]) -> None:
        self._body = body
        low, high = body.extent()
        self.middle, self.size = (low + high) / 2, float(np.linalg.norm(high - low))
        gram = sum((self._gram(*part) for part in held), np.zeros((MODES[body.dim],) * 2))
        gram = body.comm.allreduce(gram)
        values, vectors = np.linalg.eigh(gram)
        self.free: Array = vectors[:, values <= 1e-10 * max(1e-300, values.max())]

    def rows(self, points: Array, directions: Array) -> Array:
        """How far the motions move points (n, dim) along directions (n, dim): (n, 1, 3 or 6)."""
        arms = (points - self.middle) / self.size
        if self._body.dim == 1:
            return directions
        return np.hstack([directions, _cross(arms, directions)])

    def _gram(self, parts: Sequence[str] | None, axes: Sequence[int] | None) -> Array:
        """How much the motions move parts of the boundary along axes, or along the normals (None)."""
        points, normals = surface(self._body, parts)
        dim = self._body.dim
        corners = points.reshape(-1, dim)
        if axes is None:
            directions = [np.repeat(normals, points.shape[1], axis=0)]
        else:
            directions = [np.tile(np.eye(dim)[axis], (len(corners), 1)) for axis in axes]
        rows = np.vstack([self.rows(corners, d) for d in directions])
        return rows.T @ rows

    def push(self, part: str, direction: Array | None = None) -> tuple[Array, float]:
        """The forces of a unit load on a part of the boundary along the free motions, and the part's area.

        Args:
            part: Name of the part.
            direction: Direction (dim,) of the load; the inward normal unless given.
        """
        points, normals = surface(self._body, [part])
        if self._body.dim == 1:
            areas = np.ones(len(points))
        elif self._body.dim == 2:
            areas = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
        else:
            areas = (
                np.linalg.norm(np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]), axis=1) / 2
            )
        directions = -normals if direction is None else np.broadcast_to(direction, normals.shape)
        rows = self.rows(points.mean(axis=1), directions) * areas[:, None]
        comm = self._body.comm
        return comm.allreduce(rows.sum(axis=0) @ self.free), comm.allreduce(float(areas.sum()))

    def pins(self, space: fem.FunctionSpace, mixed: bool) -> list[fem.DirichletBC]:
        """Hold the body at as many components of nodes as it has free motions.

        The node nearest to the body's lowest corner; the one farthest from it along an axis; the one that the
        rotation about the line between them moves most along an axis; of each the components that the free
        motions move most. These begin near zero, so that a body that shrinks can keep them, as it could not
        keep the height of a far corner, for example. A statically determinate
        support: its reactions vanish where nothing pushes along the free motions.
        """
        body, left, pins = self._body, self.free, []
        for node in self._nodes():
            while left.shape[1]:
                rows = self.rows(np.tile(node, (body.dim, 1)), np.eye(body.dim)) @ left
                sizes = np.linalg.norm(rows, axis=1)
                component = int(np.argmax(sizes >= sizes.max() - 1e-9))
                if sizes[component] < 1e-6:
                    break
                pins.append((node, component))
                # What is left: the motions that do not move this component.
                left = left @ np.linalg.svd(rows[component : component + 1])[2][1:].T
        return [condition for node, axis in pins for condition in _pin(body, space, mixed, node, axis)]

    def _nodes(self) -> Iterator[Array]:
        body, size = self._body, self.size
        low, _ = body.extent()
        first = _node(body, lambda x: np.linalg.norm(x - low, axis=1) / size)
        yield first
        if body.dim > 1:
            second = _node(body, lambda x: -_excess((x - first) / size))
            yield second
            arm = (second - first) / np.linalg.norm(second - first)
        if body.dim > 2:

            def lever(x: Array) -> Array:
                moved = np.cross(arm, (x - first) / size)
                return (moved**2 - np.cross(moved, arm) ** 2).max(axis=1)

            yield _node(body, lambda x: -lever(x))


def _excess(arms: Array) -> Array:
    """Square of the largest component of vectors (n, dim), less those of the others."""
    return 2 * (arms**2).max(axis=1) - (arms**2).sum(axis=1)


def _cross(a: Array, b: Array) -> Array:
    """Cross products (n, 3) in space, (n, 1) in the plane."""
    if b.shape[1] == 3:
        return np.cross(a, b)
    return a[..., :1] * b[:, 1:] - a[..., 1:] * b[:, :1]


def surface(body: Body, parts: Sequence[str] | None) -> tuple[Array, Array]:
    """Corners (n, dim, dim) of the facets that this process owns of parts of the boundary, unit normals."""
    mesh, dim = body.mesh, body.dim
    facets = body.boundary_facets(parts)
    facets = facets[facets < mesh.topology.index_map(dim - 1).size_local]
    mesh.topology.create_connectivity(dim - 1, dim)
    nodes = dmesh.entities_to_geometry(mesh, dim - 1, facets) if len(facets) else np.zeros((0, dim), int)
    points = mesh.geometry.x[nodes[:, :dim]][:, :, :dim]
    if dim == 1:
        normals = np.ones((len(points), 1))
    elif dim == 2:
        edge = points[:, 1] - points[:, 0]
        normals = np.stack([edge[:, 1], -edge[:, 0]], axis=1)
    else:
        normals = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    cells = mesh.topology.connectivity(dim - 1, dim)
    inside = cells.array[cells.offsets[facets]]  # the one cell of each
    middles = mesh.geometry.x[mesh.geometry.dofmaps[0][inside]].mean(axis=1)[:, :dim]
    outward = np.sign(np.einsum("ij,ij->i", normals, points.mean(axis=1) - middles))
    normals = normals * outward[:, None] / np.linalg.norm(normals, axis=1, keepdims=True)
    return points, normals


def _node(body: Body, score: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """The mesh node (dim,) with the least score; the same on every number of processes."""
    x = body.mesh.geometry.x[:, : body.dim]
    scores = score(x)
    least = body.comm.allreduce(float(scores.min(initial=np.inf)), MPI.MIN)
    # Equal scores are told apart by the coordinates, not by the numbering, which depends on the processes.
    close = x[scores <= least + 1e-9]
    first = close[np.lexsort(close.T[::-1])[:1]].tolist()
    return np.array(min(node for part in body.comm.allgather(first) for node in part))


def _pin(body: Body, space: fem.FunctionSpace, mixed: bool, point: np.ndarray, component: int) -> list[Any]:
    if body.dim == 1:
        dofs = fem.locate_dofs_geometrical(space, _at(body, point))
        return [fem.dirichletbc(fem.Function(space), dofs)]
    parent = space.sub(0).sub(component) if mixed else space.sub(component)
    collapsed, _ = parent.collapse()
    zero = fem.Function(collapsed)
    dofs = fem.locate_dofs_geometrical((parent, collapsed), _at(body, point))
    assert body.comm.allreduce(len(dofs[0]), MPI.SUM) > 0, "a mesh node carries a degree of freedom"
    return [fem.dirichletbc(zero, dofs, parent)]


def _at(body: Body, point: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Marks coordinates (3, n) that are at the point."""
    low, high = body.extent()
    close = 1e-9 * np.linalg.norm(high - low) + 1e-13 * np.abs(point).max()
    return lambda x: np.linalg.norm(x[: body.dim] - point[:, None], axis=0) < close
