"""The volume of a cavity, and the mean position of its rim."""

from __future__ import annotations

from typing import Any

from myostrain.engine import compile_form, fem, lasting
from myostrain.geometry import Body
from myostrain.mechanics.quadrature import integral

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import la
from dolfinx import mesh as dmesh

Array = npt.NDArray[np.float64]


class Cavity:
    """What a surface and the cone from its rim to the rim's mean position enclose, deformed.

    With Nanson's formula and Gauss's theorem the volume is −⅓ ∫ (x − o)·J F⁻ᵀN dS over the surface at rest,
    where N points out of the body, into the cavity: the cone with its apex at o adds nothing to the integral.
    The point o is the mean of the deformed rim by arc length at rest. So the volume does not change under
    rigid motions, is multiplied by det A under x → A x, and is exact for the discrete surface where the rim
    is plane, as that of a base held in a plane. A surface without a rim needs no cone.

    Args:
        body: The reference body, a solid.
        boundary: Name of the boundary that is the surface.
        displacement: Its displacement, UFL.
        degree: Polynomial degree of the displacement.

    Raises:
        InputError: No part of the boundary has this name.

    Attributes:
        rim_at_rest: Mean position (3,) of the rim at rest.
    """

    def __init__(self, body: Body, boundary: str, displacement: Any, degree: int) -> None:
        mesh = body.mesh
        self._comm = lasting(mesh.comm)
        x = ufl.SpatialCoordinate(mesh) + displacement
        F = ufl.Identity(3) + ufl.grad(displacement)
        self._centre, self._axis = fem.Constant(mesh, np.zeros(3)), fem.Constant(mesh, np.zeros(3))
        ds = body.boundary_measure([boundary], 2 * degree, "geometry")
        area = ufl.det(F) * ufl.inv(F).T * ufl.FacetNormal(mesh)
        self._volume = compile_form(-ufl.dot(x - self._centre, area) / 3 * ds)
        rim = _rim(mesh, body.boundary_facets([boundary]))
        tags = dmesh.meshtags(mesh, 1, rim, np.ones_like(rim))
        dr = ufl.Measure(
            "dr", domain=mesh, subdomain_data=tags, metadata={"quadrature_degree": max(2, degree)}
        )(1)
        self._length = integral(compile_form(fem.Constant(mesh, 1.0) * dr), self._comm)
        self.rim_at_rest = self._mean(compile_form(ufl.dot(self._axis, ufl.SpatialCoordinate(mesh)) * dr))
        self._position = compile_form(ufl.dot(self._axis, x) * dr)

    def rim(self) -> Array:
        """Mean position (3,) of the deformed rim; the origin where there is none."""
        return self._mean(self._position)

    def _mean(self, position: fem.Form) -> Array:
        mean = np.zeros(3)
        if self._length > 0:
            for i in range(3):
                self._axis.value[:] = np.eye(3)[i]
                mean[i] = integral(position, self._comm) / self._length
        return mean

    def volume(self) -> float:
        """The volume."""
        self._centre.value[:] = self.rim()
        return integral(self._volume, self._comm)


def _rim(mesh: dmesh.Mesh, facets: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """Edges, of those that this process owns, that belong to one of the facets and not to two."""
    topology = mesh.topology
    topology.create_entities(1)
    topology.create_connectivity(2, 1)
    owned = facets[facets < topology.index_map(2).size_local]
    sides = topology.connectivity(2, 1)
    edges = topology.index_map(1)
    count = la.vector(edges)  # over all processes: the two facets of an edge may be on two
    np.add.at(count.array, sides.array.reshape(sides.num_nodes, -1)[owned], 1.0)
    count.scatter_reverse(la.InsertMode.add)
    return np.flatnonzero(count.array[: edges.size_local] == 1).astype(np.int32)
