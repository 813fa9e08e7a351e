"""Initial potential."""

from __future__ import annotations

from typing import Literal

from myostrain.electrics.potential import Potential
from myostrain.engine import MPI, compile_form, fem
from myostrain.errors import InputError
from myostrain.solvers.linear import assemble_nodal
from myostrain.validation import Finite, Positive, description

import numpy as np
import ufl


@description
class BoundaryBump:
    """v = potential at the nodes of parts of the boundary, the cell's resting potential elsewhere.

    Args:
        potential: Value there.
        boundary: Named parts of the boundary, such as an endocardium.
    """

    potential: Finite
    boundary: tuple[str, ...]

    def apply(self, to: Potential) -> None:
        """Set the potential.

        Raises:
            InputError: A name is not one of the body's boundaries, or there is none.
        """
        facets = to.body.boundary_facets(self.boundary, "initial.boundary")
        dofs = fem.locate_dofs_topological(to.v.function_space, to.body.dim - 1, facets)
        if not to.body.comm.allreduce(len(dofs), MPI.SUM):
            raise InputError("no node of the mesh is there; name a part", "initial.boundary")
        to.v.x.array[:] = to.cell.resting_potential()
        to.v.x.array[dofs] = self.potential
        to.v.x.scatter_forward()


@description
class Bump:
    """v = potential where |X − center| ≤ radius, the cell's resting potential elsewhere.

    Args:
        potential: Value in the bump.
        center: Its centre, material coordinates, at least as many as the body has dimensions.
        radius: Its radius, positive.
        sampling: "nodal": each node takes the value at its point, so that the bump's size jumps with the
            mesh; "mean": it takes the mean around it, weighted by its basis function, which keeps ∫ v dX.
    """

    potential: Finite
    center: tuple[Finite, ...]
    radius: Positive
    sampling: Literal["nodal", "mean"] = "nodal"

    def apply(self, to: Potential) -> None:
        """Set the potential.

        Raises:
            InputError: ``center`` has another dimension than the body, or no node lies in the bump.
        """
        dim = to.body.dim
        if not dim <= len(self.center) <= 3:
            raise InputError(f"{list(self.center)}: give {dim} coordinates", "initial.center")
        X = to.v.function_space.tabulate_dof_coordinates()[:, :dim]
        distance = np.linalg.norm(X - np.asarray(self.center[:dim]), axis=1)
        inside = distance <= self.radius * (1 + 1e-12)
        if not to.body.comm.allreduce(bool(inside.any()), MPI.LOR):
            nearest = to.body.comm.allreduce(float(distance.min(initial=np.inf)), MPI.MIN)
            raise InputError(
                f"no node of the mesh lies within {self.radius} of {list(self.center)}; the nearest is "
                f"{nearest:.4g} away: a larger radius, another centre, or a finer mesh",
                "initial.radius",
            )
        share = inside.astype(float) if self.sampling == "nodal" else self._mean(to)
        rest = to.cell.resting_potential()
        to.v.x.array[:] = rest + (self.potential - rest) * share

    def _mean(self, to: Potential) -> np.ndarray:
        """Share of the bump in each node's surroundings, weighted by the node's basis function."""
        mesh, test = to.body.mesh, ufl.TestFunction(to.v.function_space)
        arm = ufl.SpatialCoordinate(mesh) - fem.Constant(mesh, np.array(self.center[: to.body.dim]))
        inside = ufl.conditional(ufl.le(ufl.dot(arm, arm), fem.Constant(mesh, self.radius**2)), 1.0, 0.0)
        dx = ufl.dx(metadata={"quadrature_degree": 20})  # the integrand jumps: many points in place of order
        return assemble_nodal(compile_form(inside * test * dx)) / to.weight
