"""What holds a body: fixed parts of its boundary, or the few points that stop a free body from drifting."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from myostrain.engine import MPI, fem
from myostrain.geometry import Body

import numpy as np


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


def rigid_body_pins(body: Body, space: fem.FunctionSpace, mixed: bool) -> list[fem.DirichletBC]:
    """Hold a free body at as many components as it has rigid motions (1, 3 or 6).

    The node nearest to the body's lowest corner is held entirely, the one farthest from it across the line
    that joins them, and in a solid one more against the rotation about that line: a statically determinate
    support, whose reactions vanish because nothing else acts on the body.
    """
    low, _ = body.extent()
    first = _node(body, lambda x: np.linalg.norm(x - low, axis=1))
    pins = [(first, component) for component in range(body.dim)]
    if body.dim > 1:
        second = _node(body, lambda x: -np.linalg.norm(x - first, axis=1))
        arm = second - first
        along = int(np.argmax(np.abs(arm)))
        pins += [(second, component) for component in range(body.dim) if component != along]
    if body.dim == 3:  # the rotation about the arm is left: the node that it moves most, where it goes

        def turned(x: np.ndarray) -> np.ndarray:
            return np.abs(np.cross(arm, x - first))

        third = _node(body, lambda x: -turned(x).max(axis=1))
        pins.append((third, int(np.argmax(turned(third[None])))))
    return [
        condition for point, component in pins for condition in _pin(body, space, mixed, point, component)
    ]


def _node(body: Body, score: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """The mesh node (dim,) with the least score; the same on every number of processes."""
    x = body.mesh.geometry.x[:, : body.dim]
    scores = score(x)
    # Equal scores are told apart by the coordinates, not by the numbering, which depends on the processes.
    candidates = [(round(float(d), 9), *map(float, xi)) for d, xi in zip(*_best(scores, x), strict=True)]
    best = min(body.comm.allgather(min(candidates, default=(np.inf, *([np.inf] * body.dim)))))
    return np.array(best[1:])


def _best(distance: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    if not len(distance):
        return distance, x
    close = distance <= distance.min() + 1e-9
    return distance[close], x[close]


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
    close = 1e-10 * (1 + np.abs(point).max())
    return lambda x: np.linalg.norm(x[: body.dim] - point[:, None], axis=0) < close
