"""What the mesh of the mechanics and that of the potential hand each other."""

from __future__ import annotations

from typing import Any, Protocol

from myostrain.engine import compile_form, fem
from myostrain.errors import ComputationError, InputError
from myostrain.geometry import Body
from myostrain.geometry.cell_fields import CellFields
from myostrain.geometry.corners import corners
from myostrain.geometry.refinement import RefinedBody
from myostrain.kinematics import Deformation
from myostrain.solvers.linear import Options, make_ksp, reason

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import mesh as dmesh
from dolfinx.fem import petsc as fem_petsc
from dolfinx.la import InsertMode

Array = npt.NDArray[np.float64]


class Transfer(Protocol):
    """What the coupling asks of a pair of meshes.

    Attributes:
        mesh: The potential's mesh.
        deformation: The deformation as the potential sees it, UFL on that mesh.
    """

    mesh: dmesh.Mesh
    deformation: Deformation

    def to_mechanics(self, values: Array) -> Array:
        """Values at the mechanics' nodes, of values (nodes,) at those of the potential."""
        ...

    def to_potential(self, values: Array) -> Array:
        """Values at the potential's nodes, of values (nodes, ...) at those of the mechanics."""
        ...

    def displacement(self, values: Array | None = None) -> fem.Function:
        """The displacement at the potential's nodes, a P1 vector function.

        Args:
            values: Of the mechanics' unknown, in place of the present ones: such as a velocity.
        """
        ...

    def quadratic_displacement(self) -> fem.Function | None:
        """The present displacement on the potential's mesh, a P2 vector function; None where it is linear."""
        ...

    def hand_over(self) -> None:
        """Make ``deformation`` that of the displacement which the mechanics hands over now."""
        ...


class SameMesh:
    """Potential and mechanics share their mesh: nothing is to be done.

    Args:
        mechanics: The deforming body.
    """

    def __init__(self, mechanics: Any) -> None:
        self._mechanics, self.mesh = mechanics, mechanics.body.mesh
        self.deformation: Deformation = mechanics.deformation
        self._quadratic: tuple[fem.Function, Any] | None = None

    def to_mechanics(self, values: Array) -> Array:
        """The values themselves."""
        return values

    def to_potential(self, values: Array) -> Array:
        """The values themselves."""
        return values

    def displacement(self, values: Array | None = None) -> fem.Function:
        """The mechanics' own."""
        return self._mechanics.displacement(values)

    def quadratic_displacement(self) -> fem.Function | None:
        """The mechanics' own."""
        mechanics = self._mechanics
        if mechanics.kinematics.degree == 1:
            return None
        if not mechanics.kinematics.has_pressure:
            return mechanics.u
        if self._quadratic is None:
            space, dofs = mechanics.u.function_space.sub(0).collapse()
            self._quadratic = fem.Function(space), np.asarray(dofs)
        made, dofs = self._quadratic
        made.x.array[:] = mechanics.u.x.array[dofs]
        return made

    def hand_over(self) -> None:
        """Nothing: the deformation is the mechanics' own."""


class NestedMesh:
    """The potential lives on a mesh that is nested in that of the mechanics.

    F in a cell of the potential is the gradient of the mechanics' displacement at that cell's centre, which
    for linear displacements is the gradient in the parent cell. J is taken at the cell's corners, of the
    quadratic polynomial through its values in the parent cell: exact on a line.

    The activation goes back by the L2 projection on the linear functions of the mechanics' mesh. It keeps
    them as they are, and the integral of all others.

    Args:
        mechanics: The deforming body.
        fine: Its body on a finer mesh, of :func:`myostrain.geometry.refined`.

    Raises:
        InputError: ``fine`` was not made of the mechanics' body.
    """

    def __init__(self, mechanics: Any, fine: Body) -> None:
        body = mechanics.body
        if not isinstance(fine, RefinedBody) or fine.coarse.mesh is not body.mesh:
            raise InputError(
                "the fine mesh is not nested in that of the mechanics: give "
                "geometry.refined(mechanics.body, levels), with levels from 1 on",
                "potential.refinement",
            )
        self.made_from = {"cells": fine.cells}
        self._mechanics, self._fine, self.mesh = mechanics, fine, fine.mesh
        seen, dim = mechanics.deformation, body.dim
        degree = mechanics.kinematics.degree - 1
        centres = fine.places.mean(axis=1)[:, None]
        self._gradient = CellFields(body.mesh, seen.F, degree)
        self._gradient_at = self._gradient.matrix_at(centres, fine.parents)
        F = fem.Function(fem.functionspace(fine.mesh, ("DG", 0, (dim, dim))))
        self._F, J, self._J = F, 1.0, None
        if not seen.isochoric:
            self._ratio = CellFields(body.mesh, seen.J, 2)
            self._ratio_at = self._ratio.matrix_at(fine.places, fine.parents)
            J = self._J = fem.Function(fem.functionspace(fine.mesh, ("DG", 1)))
        self.deformation = Deformation(F, J, (mechanics.handed.u, mechanics.handed.a), self.hand_over)
        self._space = fem.functionspace(fine.mesh, ("Lagrange", 1))
        coarse = mechanics.activation.function_space
        self._up = self._interpolation(coarse, self._space)
        self._down = (self._up.T @ _mass(self._space)).tocsr()
        trial, test = ufl.TrialFunction(coarse), ufl.TestFunction(coarse)
        matrix = fem_petsc.assemble_matrix(compile_form(trial * test * ufl.dx))
        matrix.assemble()
        options: Options = {"ksp_type": "cg", "pc_type": "jacobi", "ksp_rtol": 1e-12}
        self._projection = make_ksp(matrix, "transfer", options, None)
        self._load, self._projected = fem.Function(coarse), fem.Function(coarse)
        self._displacements: dict[int, Any] = {}

    def _interpolation(self, space: fem.FunctionSpace, fine: fem.FunctionSpace) -> Any:
        """The matrix that takes a Lagrange function on the mechanics' mesh to one on the potential's."""
        from scipy.sparse import csr_array

        _, first = np.unique(fine.dofmap.list.reshape(-1), return_index=True)
        nodes = np.asarray(fine.element.basix_element.points)
        cells, which = np.divmod(first, len(nodes))
        corners = np.column_stack([1 - nodes.sum(axis=1), nodes])  # barycentric
        parents = self._fine.parents[cells]
        places = np.einsum("nk,nkd->nd", corners[which], self._fine.places[cells])
        weights = space.element.basix_element.tabulate(0, places)[0, :, :, 0]
        columns = space.dofmap.list[parents]
        rows = np.arange(len(cells) + 1) * weights.shape[1]
        size = space.dofmap.index_map.size_local + space.dofmap.index_map.num_ghosts
        return csr_array((weights.reshape(-1), columns.reshape(-1), rows), shape=(len(cells), size))

    def to_mechanics(self, values: Array) -> Array:
        """The L2 projection on the linear functions of the mechanics' mesh.

        Raises:
            ComputationError: The values are not finite.
        """
        load, found = self._load, self._projected
        load.x.array[:] = self._down @ values
        load.x.scatter_reverse(InsertMode.add)
        self._projection.solve(load.x.petsc_vec, found.x.petsc_vec)
        if reason(self._projection) < 0:
            raise ComputationError("the activation could not be handed to the mechanics: is it finite?")
        found.x.scatter_forward()
        return found.x.array

    def to_potential(self, values: Array) -> Array:
        """Linear interpolation."""
        flat = self._up @ values.reshape(len(values), -1)
        return np.asarray(flat).reshape(len(flat), *values.shape[1:])

    def displacement(self, values: Array | None = None) -> fem.Function:
        """The displacement itself at the potential's nodes, exact for quadratic displacements too."""
        return self._interpolated(1, self._mechanics.u.x.array if values is None else values)

    def quadratic_displacement(self) -> fem.Function | None:
        """The displacement itself, which is quadratic in the cells of the finer mesh too."""
        mechanics = self._mechanics
        return None if mechanics.kinematics.degree == 1 else self._interpolated(2, mechanics.u.x.array)

    def _interpolated(self, degree: int, values: Array) -> fem.Function:
        """The displacement in values of the mechanics' unknown, on the potential's mesh."""
        mechanics, dim = self._mechanics, self._fine.dim
        if degree not in self._displacements:
            made = fem.Function(fem.functionspace(self._fine.mesh, ("Lagrange", degree, (dim,))))
            part, dofs = mechanics.u.function_space, None
            if mechanics.kinematics.has_pressure:
                part, dofs = part.sub(0).collapse()
            self._displacements[degree] = made, self._interpolation(part, made.function_space), dofs
        made, matrix, dofs = self._displacements[degree]
        u = values if dofs is None else values[dofs]
        made.x.array[:] = (matrix @ u.reshape(-1, dim)).reshape(-1)
        return made

    def hand_over(self) -> None:
        """Take F and J of what the mechanics hands over now."""
        self._F.x.array[:] = (self._gradient_at @ self._gradient.values()).reshape(-1)
        if self._J is not None:
            # The order of the nodes of a discontinuous space is that of cells and corners.
            self._J.x.array[:] = (self._ratio_at @ self._ratio.values()).reshape(-1)


def _mass(space: fem.FunctionSpace) -> Any:
    """Consistent mass of this process's cells on its nodes, owned and ghosts: a sparse matrix."""
    from scipy.sparse import coo_array

    mesh, cells = space.mesh, space.dofmap.list
    n = cells.shape[1]
    x = corners(mesh)
    volumes = np.abs(np.linalg.det(x[:, 1:] - x[:, :1]))
    # ∫ φᵢ φⱼ over a simplex is its volume times (1 + δᵢⱼ) / (n (n + 1)), its volume det / (n − 1)!.
    local = (np.ones((n, n)) + np.eye(n)) / (n * (n + 1) * (1, 1, 2, 6)[n - 1])
    entries = volumes[:, None, None] * local
    rows, columns = np.repeat(cells, n, axis=1), np.tile(cells, (1, n))
    size = space.dofmap.index_map.size_local + space.dofmap.index_map.num_ghosts
    return coo_array(
        (entries.reshape(-1), (rows.reshape(-1), columns.reshape(-1))), shape=(size, size)
    ).tocsr()
