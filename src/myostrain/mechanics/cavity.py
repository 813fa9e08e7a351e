"""The volume of a cavity, and the mean position of its rims."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from myostrain.engine import compile_form, fem, lasting
from myostrain.errors import InputError
from myostrain.geometry import Body
from myostrain.geometry.checks import components
from myostrain.mechanics.quadrature import integral
from myostrain.solvers.linear import assemble_nodal

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import la
from dolfinx import mesh as dmesh

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int32]


class Cavity:
    """What a surface and a cone from each of its rims to that rim's mean position enclose, deformed.

    A rim is a closed curve in which the surface ends: a ventricle's base has one, a slice two, a chamber with
    valves one a valve. With Nanson's formula and Gauss's theorem the volume is −⅓ ∫ x·J F⁻ᵀN dS over the
    surface at rest, where N points out of the body, into the cavity, plus ⅓ Σ c·A over the rims: a cone with
    its apex at c over a rim whose vector area is A = ½ ∮ x × dx. Of all rims together, with Stokes's theorem,
    ½ ∮ (c × x)·dx = ½ ∫ Σ ∇(c × x)ⱼ × ∇xⱼ · N dS, where c is any field that is c at each rim.

    The apex of a rim is its deformed mean by arc length at rest. So the volume does not change under rigid
    motions, is multiplied by det A under x → A x, and is exact for the discrete surface where the rims are
    plane, as that of a base held in a plane. A surface without a rim needs no cone.

    Args:
        body: The reference body, a solid.
        boundary: Name of the boundary that is the surface.
        displacement: Its displacement, UFL.
        degree: Polynomial degree of the displacement.
        unknown: The function that the displacement is in, for :meth:`gradient`; None where nobody asks.

    Raises:
        InputError: No part of the boundary has this name.

    Attributes:
        rims: Number of rims.
        rim_at_rest: Mean position (3,) of all rims at rest.
    """

    def __init__(
        self,
        body: Body,
        boundary: str,
        displacement: Any,
        degree: int,
        unknown: fem.Function | None = None,
    ) -> None:
        mesh = body.mesh
        self._comm = lasting(mesh.comm)
        at_rest = ufl.SpatialCoordinate(mesh)
        x = at_rest + displacement
        F = ufl.Identity(3) + ufl.grad(displacement)
        self._centre, self._axis = fem.Constant(mesh, np.zeros(3)), fem.Constant(mesh, np.zeros(3))
        ds, normal = body.boundary_measure([boundary], 2 * degree, "geometry"), ufl.FacetNormal(mesh)
        arm = x - self._centre
        area = -ufl.det(F) * ufl.inv(F).T * normal
        form = ufl.dot(arm, area) / 3
        edges, of_rim, self.rims = _rims(mesh, body.boundary_facets([boundary]))
        if self.rims > 1:  # else the only apex is the centre
            space = fem.functionspace(mesh, ("Lagrange", 1, (3,)))
            self._apexes = fem.Function(space)
            self._nodes = [
                fem.locate_dofs_topological(space, 1, edges[of_rim == rim]) for rim in range(self.rims)
            ]
            turned = ufl.cross(self._apexes, arm)
            curl = sum(ufl.cross(ufl.grad(turned[j]), ufl.grad(x[j])) for j in range(3))
            form += ufl.dot(curl, normal) / 6
        self._volume = compile_form(form * ds)
        tags = dmesh.meshtags(mesh, 1, edges, of_rim)
        dr = ufl.Measure(
            "dr", domain=mesh, subdomain_data=tags, metadata={"quadrature_degree": max(2, degree)}
        )
        one = fem.Constant(mesh, 1.0)
        self._lengths = [integral(compile_form(one * dr(rim)), self._comm) for rim in range(self.rims)]
        self._positions = [compile_form(ufl.dot(self._axis, x) * dr(rim)) for rim in range(self.rims)]
        places = [compile_form(ufl.dot(self._axis, at_rest) * dr(rim)) for rim in range(self.rims)]
        self.rim_at_rest = self._mean(self._means(places))
        if unknown is None:
            return
        self._gradient = compile_form(ufl.derivative(form * ds, unknown))
        self._area = compile_form(ufl.dot(self._axis, area) / 3 * ds)
        if self.rims > 1:
            self._by_apex = compile_form(ufl.derivative(form * ds, self._apexes))
        test = ufl.derivative(x, unknown)
        of_rim_means = [compile_form(ufl.dot(self._axis, test) * dr(rim)) for rim in range(self.rims)]
        #: By rim and axis, the derivative of the rim's mean position; it is linear in the displacement.
        self._moved = np.array(
            [[assemble_nodal(each) for _ in self._along()] for each in of_rim_means]
        ) / np.reshape(self._lengths, (-1, 1, 1))

    def rim(self) -> Array:
        """Mean position (3,) of all deformed rims; the origin where there is none."""
        return self._mean(self._means(self._positions))

    def _means(self, positions: list[fem.Form]) -> Array:
        """Mean positions (rims, 3) of the rims."""
        found = np.zeros((self.rims, 3))
        for i in self._along():
            found[:, i] = [integral(form, self._comm) for form in positions]
        return found / np.reshape(self._lengths, (-1, 1))

    def _mean(self, means: Array) -> Array:
        return np.average(means, axis=0, weights=self._lengths) if self.rims else np.zeros(3)

    def _along(self) -> Iterator[int]:
        """The three axes, of which each is in the forms meanwhile."""
        for i in range(3):
            self._axis.value[:] = np.eye(3)[i]
            yield i

    def _place_apexes(self) -> None:
        """Put the apexes of the cones where they are now."""
        means = self._means(self._positions)
        self._centre.value[:] = self._mean(means)
        if self.rims > 1:
            for nodes, mean in zip(self._nodes, means, strict=True):
                self._apexes.x.array.reshape(-1, 3)[nodes] = mean - self._centre.value

    def volume(self) -> float:
        """The volume (collective)."""
        self._place_apexes()
        return integral(self._volume, self._comm)

    def gradient(self) -> Array:
        """Derivative of the volume by the local degrees of freedom of the unknown (collective).

        It is exact: the apexes of the cones move with their rims.
        """
        self._place_apexes()
        found = assemble_nodal(self._gradient)
        if self.rims == 1:  # the only apex is the centre
            by_apex = np.array([[-integral(self._area, self._comm) for _ in self._along()]])
        elif self.rims > 1:
            nodal = assemble_nodal(self._by_apex).reshape(-1, 3)
            owned = self._apexes.function_space.dofmap.index_map.size_local
            own = [nodal[nodes[nodes < owned]].sum(axis=0) for nodes in self._nodes]
            by_apex = np.asarray(self._comm.allreduce(np.array(own)))
        for means, moved in zip(by_apex if self.rims else (), self._moved, strict=True):
            found += means @ moved
        return found


def _rims(mesh: dmesh.Mesh, facets: Indices) -> tuple[Indices, Indices, int]:
    """Edges of this process in which facets end, the rim that each belongs to, and the number of rims."""
    edges = _rim(mesh, facets)
    topology, comm = mesh.topology, lasting(mesh.comm)
    topology.create_connectivity(1, 0)
    topology.create_connectivity(1, 3)
    vertices = topology.connectivity(1, 0).array.reshape(-1, 2)[edges]
    ends = topology.index_map(0).local_to_global(vertices.reshape(-1)).reshape(-1, 2)
    names, places = np.unique(np.concatenate(comm.allgather(ends)), return_inverse=True)
    _, rim_of_vertex = np.unique(components(places.reshape(-1, 2), len(names)), return_inverse=True)
    of_edge = rim_of_vertex[np.searchsorted(names, ends[:, 0])]
    return edges, of_edge.astype(np.int32), int(rim_of_vertex.max(initial=-1)) + 1


def check_closed(body: Body, boundary: str, key: str) -> None:
    """Refuse a surface with a hole: one that ends where the boundary beyond has no name (collective).

    Where a base or a valve is beyond a rim, a cone is put over it. Over facets that were left out it would
    hide that.

    Args:
        body: The reference body, a solid.
        boundary: Name of the boundary that is the surface.
        key: Key of a case file that names it.

    Raises:
        InputError: It has one, with its place.
    """
    mesh, tags = body.mesh, body.meshed.facet_tags
    edges, of_edge, rims = _rims(mesh, body.boundary_facets([boundary], key))
    assert tags is not None
    others = [tags.find(tag) for name, tag in body.meshed.boundaries.items() if name != boundary]
    beyond = np.intersect1d(np.concatenate([edges[:0], *others]), body.boundary_facets(None)).astype(np.int32)
    bare = _facets_at_edges(mesh, beyond)[edges] == 0
    ends = np.zeros((0, 2, 3))
    if bare.any():
        ends = mesh.geometry.x[dmesh.entities_to_geometry(mesh, 1, edges[bare])][:, :2]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    sums = np.zeros((rims, 4))
    np.add.at(sums, of_edge[bare], np.column_stack([lengths[:, None] * ends.mean(axis=1), lengths]))
    sums = lasting(mesh.comm).allreduce(sums)
    for number, (*moment, length) in enumerate(sums, 1):
        if length > 0:
            place = [round(float(m / length), 4) + 0.0 for m in moment]
            raise InputError(
                f"'{boundary}' is the wall of a cavity that is not closed: over a length of {length:.4g} "
                f"around {place} it ends (loop {number} of {rims}) where the boundary beyond has no name. "
                "Give the facets there to it; if it is an opening, name what is beyond, as a base or a valve",
                key,
            )


def _rim(mesh: dmesh.Mesh, facets: Indices) -> Indices:
    """Edges, of those that this process owns, that belong to one of the facets and not to two."""
    return np.flatnonzero(_facets_at_edges(mesh, facets) == 1).astype(np.int32)


def _facets_at_edges(mesh: dmesh.Mesh, facets: Indices) -> Array:
    """How many of the facets each edge that this process owns belongs to."""
    topology = mesh.topology
    topology.create_entities(1)
    topology.create_connectivity(2, 1)
    owned = facets[facets < topology.index_map(2).size_local]
    sides = topology.connectivity(2, 1)
    edges = topology.index_map(1)
    count = la.vector(edges)  # over all processes: the two facets of an edge may be on two
    np.add.at(count.array, sides.array.reshape(sides.num_nodes, -1)[owned], 1.0)
    count.scatter_reverse(la.InsertMode.add)
    return np.asarray(count.array[: edges.size_local]).copy()
