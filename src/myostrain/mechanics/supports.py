"""What holds a body: parts that are fixed or slide in a plane, or the few points that stop a drift."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from myostrain.engine import MPI, fem
from myostrain.errors import InputError
from myostrain.geometry import Body
from myostrain.geometry.body import range_of

import numpy as np
import numpy.typing as npt
from dolfinx import mesh as dmesh

Array = npt.NDArray[np.float64]

#: Rigid motions by the body's dimension.
MODES = {1: 1, 2: 3, 3: 6}

#: How far nodes of a plane part may be off their plane, of the body's diagonal: coordinates in single
#: precision are off by some 1e-7.
FLAT = 1e-6


def fixed_conditions(
    body: Body, space: fem.FunctionSpace, names: Sequence[str], mixed: bool
) -> list[fem.DirichletBC]:
    """u = 0 on the named parts of the boundary.

    Args:
        body: The reference body.
        space: Displacement space, or the mixed space whose first part it is.
        names: Named parts; none gives no condition.
        mixed: Whether ``space`` is mixed.
    """
    if not names:
        return []
    facets = body.boundary_facets(names, "mechanics.fixed")
    fdim = body.mesh.topology.dim - 1
    if mixed:
        collapsed, _ = space.sub(0).collapse()
        zero = fem.Function(collapsed)
        dofs = fem.locate_dofs_topological((space.sub(0), collapsed), fdim, facets)
        return [fem.dirichletbc(zero, dofs, space.sub(0))]
    dofs = fem.locate_dofs_topological(space, fdim, facets)
    return [fem.dirichletbc(fem.Function(space), dofs)]


def sliding_conditions(
    body: Body, space: fem.FunctionSpace, names: Sequence[str], mixed: bool
) -> list[fem.DirichletBC]:
    """No displacement across the named parts of the boundary, each in a plane across an axis.

    Args:
        body: The reference body.
        space: Displacement space, or the mixed space whose first part it is.
        names: Named parts; none gives no condition.
        mixed: Whether ``space`` is mixed.

    Raises:
        InputError: A part is in no such plane.
    """
    conditions = []
    for name in names:
        facets = body.boundary_facets([name], "mechanics.sliding")
        parent = space.sub(0) if mixed else space
        component = parent if body.dim == 1 else parent.sub(plane_axis(body, name))
        if component is space:
            dofs = fem.locate_dofs_topological(space, body.dim - 1, facets)
            conditions.append(fem.dirichletbc(fem.Function(space), dofs))
            continue
        collapsed, _ = component.collapse()
        dofs = fem.locate_dofs_topological((component, collapsed), body.dim - 1, facets)
        conditions.append(fem.dirichletbc(fem.Function(collapsed), dofs, component))
    return conditions


def plane_axis(body: Body, name: str) -> int:
    """The axis across which the named part of the boundary lies in a plane.

    Raises:
        InputError: There is none.
    """
    points, _ = _surface(body, [name])
    low, high = body.extent()
    least, most = range_of(points.reshape(-1, body.dim), body.comm)
    spread, size = most - least, float(np.linalg.norm(high - low))
    flat = np.flatnonzero(spread <= FLAT * size)
    if len(flat) != 1:
        raise InputError(
            f"'{name}' is in no plane across {', '.join('XYZ'[: body.dim])}, in which it could slide (it "
            f"extends over {', '.join(f'{s:.3g}' for s in spread)} along these axes; a plane may deviate by "
            f"{FLAT:g} of the body's diagonal, {FLAT * size:.3g}); fix it, or give it a stiffness along "
            "its normal in mechanics.robin_normal",
            "mechanics.sliding",
        )
    return int(flat[0])


class RigidMotions:
    """The rigid motions (1, 3 or 6) that supports leave free.

    Args:
        body: The reference body.
        fixed: Parts that are fixed.
        sliding: Parts that slide in a plane.
        springs: Parts on elastic supports, None for all of the boundary, and whether along the normal only.

    Attributes:
        free: The motions left, orthonormal columns: of translations along the axes and rotations about them
            (for which lengths are measured from the body's middle, in units of its size).
    """

    def __init__(
        self,
        body: Body,
        fixed: Sequence[str],
        sliding: Sequence[str],
        springs: Sequence[tuple[Sequence[str] | None, bool]],
    ) -> None:
        self._body = body
        low, high = body.extent()
        self._middle, self._size = (low + high) / 2, float(np.linalg.norm(high - low))
        planes = [([name], True) for name in sliding]
        holds = [*([(fixed, False)] if fixed else []), *planes, *springs]
        gram = sum((self._gram(*hold) for hold in holds), np.zeros((MODES[body.dim],) * 2))
        gram = body.comm.allreduce(gram)
        values, vectors = np.linalg.eigh(gram)
        self.free: Array = vectors[:, values <= 1e-10 * max(1e-300, values.max())]

    def rows(self, points: Array, directions: Array) -> Array:
        """How far the motions move points (n, dim) along directions (n, dim): (n, 1, 3 or 6)."""
        arms = (points - self._middle) / self._size
        if self._body.dim == 1:
            return directions
        return np.hstack([directions, _cross(arms, directions)])

    def _gram(self, parts: Sequence[str] | None, along_normal: bool) -> Array:
        points, normals = _surface(self._body, parts)
        dim = self._body.dim
        corners = points.reshape(-1, dim)
        if along_normal:
            directions = [np.repeat(normals, points.shape[1], axis=0)]
        else:
            directions = [np.tile(axis, (len(corners), 1)) for axis in np.eye(dim)]
        rows = np.vstack([self.rows(corners, d) for d in directions])
        return rows.T @ rows

    def push(self, part: str) -> tuple[Array, float]:
        """The forces of a unit pressure on a part of the boundary along the free motions, and its area."""
        points, normals = _surface(self._body, [part])
        if self._body.dim == 1:
            areas = np.ones(len(points))
        elif self._body.dim == 2:
            areas = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
        else:
            areas = (
                np.linalg.norm(np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]), axis=1) / 2
            )
        rows = self.rows(points.mean(axis=1), normals) * areas[:, None]
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
        body, size = self._body, self._size
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


def _surface(body: Body, parts: Sequence[str] | None) -> tuple[Array, Array]:
    """Corners (n, dim, dim) of the facets that this process owns of parts of the boundary, unit normals."""
    mesh, dim = body.mesh, body.dim
    facets = body.boundary_facets(parts)
    facets = facets[facets < mesh.topology.index_map(dim - 1).size_local]
    mesh.topology.create_connectivity(dim - 1, dim)
    corners = dmesh.entities_to_geometry(mesh, dim - 1, facets) if len(facets) else np.zeros((0, dim), int)
    points = mesh.geometry.x[corners][:, :, :dim]
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
