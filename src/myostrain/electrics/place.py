"""Where something acts, begins or differs: a ball, a box, a layer of the wall, a region of the mesh."""

from __future__ import annotations

from typing import Literal

from myostrain.engine import MPI, compile_form, fem
from myostrain.errors import InputError, nearest
from myostrain.geometry import Body
from myostrain.geometry.transmural import nodal_depth
from myostrain.solvers.linear import assemble_nodal
from myostrain.validation import Finite, NonNegative, Positive, description

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import geometry as dgeometry

Array = npt.NDArray[np.float64]

#: What is nearer than this share of the body's extent counts as there: single precision, and round-off.
CLOSE = 1e-9
#: The same of the wall's depth, which is solved for.
CLOSE_DEPTH = 1e-6


@description
class Place:
    """A place in the body; give a ball, a box, parts of the boundary, regions, or a layer of the wall.

    Lengths are in the unit of the mesh.

    Args:
        center: Centre of a ball in material coordinates, at least as many as the body has dimensions; any
            further ones must be zero.
        radius: Radius of the ball.
        box: Lowest and highest corner of a box along the axes; along axes beyond the body's dimensions it
            must contain zero.
        boundary: Named parts of the boundary, such as an endocardium.
        depth: How deep from ``boundary`` into the body; 0 takes the nodes on it only, a layer that gets
            thinner with the mesh.
        region: Named regions of the mesh (physical groups of cells).
        transmural: A layer of the wall, between two depths, 0 being the endocardium and 1 the epicardium;
            between these the depth is the harmonic function of the wall.
        transmural_between: The parts of the boundary that take the place of endocardium and epicardium.
        sampling: "nodal": a node is in or out, so that a ball or a box changes its size with the mesh;
            "mean": a node takes the mean around it, weighted by its basis function, which keeps the integral.
    """

    center: tuple[Finite, ...] | None = None
    radius: Positive | None = None
    box: tuple[tuple[Finite, ...], tuple[Finite, ...]] | None = None
    boundary: tuple[str, ...] | None = None
    depth: NonNegative = 0.0
    region: tuple[str, ...] | None = None
    transmural: tuple[Finite, Finite] | None = None
    transmural_between: tuple[str, str] | None = None
    sampling: Literal["nodal", "mean"] = "nodal"

    def __post_init__(self) -> None:
        """Refuse what is not a place, or several."""
        kinds = {
            "center and radius": self.center is not None or self.radius is not None,
            "box": self.box is not None,
            "boundary": self.boundary is not None,
            "region": self.region is not None,
            "transmural": self.transmural is not None,
        }
        given = [kind for kind, there in kinds.items() if there]
        if len(given) != 1:
            raise ValueError(
                f"give one of {', '.join(kinds)}" + (f", not {' and '.join(given)}" if given else "")
            )
        if (self.center is None) != (self.radius is None):
            raise ValueError("a ball takes center and radius")
        if self.box is not None and len(self.box[0]) != len(self.box[1]):
            raise ValueError("the corners of a box have as many coordinates each")
        if self.box is not None and not all(a < b for a, b in zip(*self.box, strict=True)):
            raise ValueError("give the lowest corner of the box and then the highest one")
        if self.depth > 0 and self.boundary is None:
            raise ValueError("a depth goes with boundary")
        if self.transmural is not None and not 0 <= self.transmural[0] < self.transmural[1] <= 1:
            raise ValueError("transmural is from a lower depth to a higher one, between 0 and 1")
        if self.transmural is None and self.transmural_between is not None:
            raise ValueError("transmural_between goes with transmural")
        if self.sampling == "mean" and self.center is None and self.box is None:
            raise ValueError('sampling = "mean" is for a ball or a box')

    def share(self, body: Body, space: fem.FunctionSpace, key: str) -> Array:
        """How much of each node of a P1 space is in the place, 0 to 1 (nodes,).

        It is the same on any number of processes.

        Raises:
            InputError: No node is in it, a name is unknown, or the dimensions differ; ``key`` goes before.
        """
        X = space.tabulate_dof_coordinates()[:, : body.dim]
        low, high = body.extent()
        close = CLOSE * float(np.linalg.norm(high - low))
        if self.boundary is not None:
            inside = self._near_boundary(body, space, X, close, key)
        elif self.region is not None:
            inside = self._in_region(body, space, key)
        elif self.transmural is not None:
            depth = nodal_depth(body, self.transmural_between, f"{key}.transmural_between")
            low_end, high_end = self.transmural
            inside = (depth >= low_end - CLOSE_DEPTH) & (depth <= high_end + CLOSE_DEPTH)
        else:
            points = np.array([self.center] if self.box is None else self.box, dtype=float)
            beyond = points[:, body.dim :]
            if not body.dim <= points.shape[1] <= 3 or (beyond[0] > 0).any() or (beyond[-1] < 0).any():
                what = "a coordinate" if body.dim == 1 else f"{body.dim} coordinates"
                raise InputError(
                    f"{self._given()}: give {what}, as the body has no others",
                    f"{key}.{'box' if self.box else 'center'}",
                )
            points = points[:, : body.dim]
            outside = self._outside(X, points)
            inside = outside <= close
            if not body.comm.allreduce(bool(inside.any()), MPI.LOR):
                away = body.comm.allreduce(float(outside.min(initial=np.inf)), MPI.MIN)
                what = f"in {self._given()}" if self.box else f"within {self.radius} of {self._given()}"
                raise InputError(
                    f"no node of the mesh lies {what}; the nearest is {away:.4g} outside, the body extends "
                    f"from {low.tolist()} to {high.tolist()}: another place, or a finer mesh",
                    f"{key}.radius" if self.center else f"{key}.box",
                )
            if self.sampling == "mean":
                return _mean(body, space, self._indicator(body, points))
        if not body.comm.allreduce(bool(inside.any()), MPI.LOR):
            raise InputError("no node of the mesh lies in this place; choose another, or a finer mesh", key)
        return inside.astype(float)

    def _given(self) -> list[float] | list[list[float]]:
        """Centre or corners, as a case writes them."""
        return [list(corner) for corner in self.box] if self.box else list(self.center or ())

    def _outside(self, X: Array, points: Array) -> Array:
        """How far points X (n, dim) are outside a ball or a box; zero or less within."""
        if self.radius is not None:
            return np.asarray(np.linalg.norm(X - points[0], axis=1) - self.radius)
        beyond = np.maximum(points[0] - X, X - points[1])
        return np.asarray(beyond.max(axis=1))

    def _indicator(self, body: Body, points: Array) -> ufl.core.expr.Expr:
        X, mesh = ufl.SpatialCoordinate(body.mesh), body.mesh
        if self.radius is not None:
            arm = X - fem.Constant(mesh, points[0])
            return ufl.conditional(ufl.le(ufl.dot(arm, arm), fem.Constant(mesh, self.radius**2)), 1.0, 0.0)
        found = 1.0
        for i in range(body.dim):
            within = ufl.And(ufl.ge(X[i], points[0, i]), ufl.le(X[i], points[1, i]))
            found *= ufl.conditional(within, 1.0, 0.0)
        return found

    def _near_boundary(
        self, body: Body, space: fem.FunctionSpace, X: Array, close: float, key: str
    ) -> npt.NDArray[np.bool_]:
        facets = body.boundary_facets(self.boundary, f"{key}.boundary")
        if self.depth == 0:
            marked = fem.Function(space)
            marked.x.array[fem.locate_dofs_topological(space, body.dim - 1, facets)] = 1.0
            marked.x.scatter_forward()
            return marked.x.array > 0
        # The part may lie on other processes than the node: each measures all nodes from what it has of it.
        parts = body.comm.allgather(X)
        distances = _distances(body, np.concatenate(parts), facets)
        body.comm.Allreduce(MPI.IN_PLACE, distances, op=MPI.MIN)
        first = sum(len(part) for part in parts[: body.comm.rank])
        return distances[first : first + len(X)] <= self.depth + close

    def _in_region(self, body: Body, space: fem.FunctionSpace, key: str) -> npt.NDArray[np.bool_]:
        tags, known = body.meshed.cell_tags, body.meshed.regions
        body.mesh.topology.create_connectivity(body.dim, body.dim)
        marked = fem.Function(space)
        for name in self.region or ():
            if name not in known or tags is None:
                hint = nearest(name, known) if known else "this mesh has no named regions"
                raise InputError(f"no region is called '{name}'; {hint}", f"{key}.region")
            dofs = fem.locate_dofs_topological(space, body.dim, tags.find(known[name]))
            marked.x.array[dofs] = 1.0
        marked.x.scatter_forward()
        return marked.x.array > 0


def _distances(body: Body, points: Array, facets: npt.NDArray[np.int32]) -> Array:
    """Distances (n,) of points (n, dim) from the facets that this process has, infinite without one."""
    mesh, dim = body.mesh, body.dim - 1
    if not len(facets):
        return np.full(len(points), np.inf)
    if dim == 0:
        mesh.topology.create_connectivity(0, 1)
        ends = fem.locate_dofs_topological(fem.functionspace(mesh, ("Lagrange", 1)), 0, facets)
        x = fem.functionspace(mesh, ("Lagrange", 1)).tabulate_dof_coordinates()[ends, 0]
        return np.asarray(np.abs(points - x[None, :]).min(axis=1))
    whole = np.zeros((len(points), 3))
    whole[:, : points.shape[1]] = points
    tree = dgeometry.bb_tree(mesh, dim, entities=facets)
    middles = dgeometry.create_midpoint_tree(mesh, dim, facets)
    nearest_facets = dgeometry.compute_closest_entity(tree, middles, mesh, whole)
    return np.sqrt(dgeometry.squared_distance(mesh, dim, nearest_facets, whole))


def _mean(body: Body, space: fem.FunctionSpace, inside: ufl.core.expr.Expr) -> Array:
    """Share of each node's surroundings, weighted by its basis function, in which ``inside`` is one."""
    test = ufl.TestFunction(space)
    dx = ufl.dx(metadata={"quadrature_degree": 20})  # the integrand jumps: many points in place of order
    return assemble_nodal(compile_form(inside * test * dx)) / assemble_nodal(compile_form(test * ufl.dx))
