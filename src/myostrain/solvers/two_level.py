"""Multigrid of two levels for quadratic displacements: they are smoothed, linear ones are solved for.

Linear displacements are quadratic ones too, on the same cells, so that the coarse matrix needs no product: it
is the same form with other elements. It has an eighth of the unknowns and a twentieth of the entries.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from myostrain.engine import PETSc, compile_form, fem, lasting
from myostrain.solvers.factors import direct
from myostrain.solvers.linear import Options, global_dofs, owned_dofs

import basix.ufl
import numpy as np
import numpy.typing as npt
from dolfinx.fem import petsc as fem_petsc

Dofs = npt.NDArray[np.int32]


#: Linear displacements from which multigrid solves for them too, and no longer factors.
COARSE = 60_000

GAMG: Options = {
    "pc_type": "gamg",
    "pc_gamg_threshold": 0.0,
    "mg_levels_ksp_type": "richardson",
    "mg_levels_ksp_max_it": 1,
    "mg_levels_pc_type": "sor",
}
SWEEP: Options = {"ksp_type": "richardson", "ksp_max_it": 1, "ksp_norm_type": "none", "pc_type": "sor"}


class Matrix:
    """A matrix and the form that it is assembled from.

    Args:
        form: UFL form.
        bcs: Conditions, homogeneous.
        symmetric: Whether it is, if that matters.
    """

    def __init__(self, form: Any, bcs: Sequence[fem.DirichletBC] = (), symmetric: bool = False) -> None:
        self._form, self._bcs = compile_form(form), list(bcs)
        self.matrix = fem_petsc.create_matrix(self._form)
        self.matrix.setOption(PETSc.Mat.Option.SYMMETRIC, symmetric)

    def assemble(self) -> None:
        """Make it that of the present state (collective)."""
        self.matrix.zeroEntries()
        fem_petsc.assemble_matrix(self.matrix, self._form, bcs=self._bcs)
        self.matrix.assemble()


class TwoLevels:
    """One cycle: the coarse solution of the right-hand side, then sweeps over the fine unknowns.

    Without sweeps before it the coarse problem needs no residual, which saves two products of the five that a
    cycle with both takes, and hardly costs an iteration.

    Args:
        fine: Space of quadratic displacements.
        fixed: Its local degrees of freedom that are held, components counted.
        matrix: The fine matrix.
        form: The same form on linear displacements.
        space: The space of these.
        symmetric: Whether it is.
        prefix: Of options that the user may have set, for ``mg_levels_`` and ``mg_coarse_``.

    Attributes:
        matrix: The coarse matrix.
        smoother, coarse: The solvers.
    """

    def __init__(
        self,
        fine: fem.FunctionSpace,
        fixed: Dofs,
        matrix: PETSc.Mat,
        form: Any,
        space: fem.FunctionSpace,
        symmetric: bool,
        prefix: str,
    ) -> None:
        self._prolong = fem_petsc.interpolation_matrix(space, fine)
        self._prolong.assemble()
        self._fixed = fixed[fixed < owned_dofs(fine)]
        corners = held_corners(fine, space, fixed)
        self._coarse_fixed = corners[corners < owned_dofs(space)]
        self._residual, self._correction = self._prolong.createVecRight(), self._prolong.createVecRight()
        self.matrix = Matrix(form, conditions(space, corners), symmetric)
        self.matrix.matrix.setNearNullSpace(rigid_motions(space))
        unknowns, processes = global_dofs(space), space.mesh.comm.size
        defaults = direct(unknowns, processes, True, symmetric, True, single=True)
        if unknowns > COARSE:
            defaults = {**SWEEP, "ksp_max_it": 2, **GAMG}
        self.coarse = part_solver(self.matrix.matrix, f"{prefix}mg_coarse_", defaults)
        self.smoother = part_solver(matrix, f"{prefix}mg_levels_", SWEEP)
        self.smoother.setInitialGuessNonzero(True)

    @staticmethod
    def coarse_space(fine: fem.FunctionSpace) -> fem.FunctionSpace:
        """Linear displacements on the mesh of quadratic ones."""
        cell, block = fine.mesh.basix_cell(), fine.dofmap.index_map_bs
        return fem.functionspace(fine.mesh, basix.ufl.element("Lagrange", cell, 1, shape=(block,)))

    def apply(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Write into x about what solves for b."""
        self._prolong.multTranspose(b, self._residual)
        self._residual.array[self._coarse_fixed] = 0.0
        self.coarse.solve(self._residual, self._correction)
        self._prolong.mult(self._correction, x)
        x.array[self._fixed] = 0.0
        self.smoother.solve(b, x)


def part_solver(matrix: PETSc.Mat, prefix: str, defaults: Options) -> PETSc.KSP:
    """A part of a solver, with options that the user may have set under its prefix."""
    database: Any = PETSc.Options()
    for key, value in defaults.items():
        if not database.hasName(prefix + key):
            database[prefix + key] = value
    ksp = PETSc.KSP().create(matrix.comm)
    ksp.setOptionsPrefix(prefix)
    ksp.setOperators(matrix)
    ksp.setFromOptions()
    return ksp


def held_corners(fine: fem.FunctionSpace, coarse: fem.FunctionSpace, fixed: Dofs) -> Dofs:
    """Local degrees of freedom of linear displacements where quadratic ones are held."""
    block = fine.dofmap.index_map_bs
    corners, nodes = coarse.dofmap.list, fine.dofmap.list
    maps = [space.dofmap.index_map for space in (coarse, fine)]
    sizes = [each.size_local + each.num_ghosts for each in maps]
    same = np.zeros(sizes[0], dtype=np.int32)
    same[corners.ravel()] = nodes[:, : corners.shape[1]].ravel()  # the corners come first in a cell
    held = np.zeros(block * sizes[1], dtype=bool)
    held[fixed] = True
    return np.flatnonzero(held.reshape(-1, block)[same].ravel()).astype(np.int32)


def conditions(space: fem.FunctionSpace, fixed: Dofs) -> list[fem.DirichletBC]:
    """Homogeneous conditions at local degrees of freedom, components counted."""
    block, found = space.dofmap.index_map_bs, []
    for i in range(block):
        part = space.sub(i)
        alone, _ = part.collapse()
        mine = fixed[fixed % block == i]
        found.append(fem.dirichletbc(fem.Function(alone), [mine, (mine // block).astype(np.int32)], part))
    return found


def rigid_motions(space: fem.FunctionSpace) -> PETSc.NullSpace:
    """Orthonormal translations and rotations of a space of displacements (collective)."""
    dim, comm = space.dofmap.index_map_bs, lasting(space.mesh.comm)
    x = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local]
    modes = [np.tile(axis, (len(x), 1)) for axis in np.eye(dim)]
    for i in range(dim):
        for j in range(i):
            turn = np.zeros((len(x), dim))
            turn[:, i], turn[:, j] = x[:, j], -x[:, i]
            modes.append(turn)
    vectors: list[PETSc.Vec] = []
    for mode in modes:
        vector = PETSc.Vec().createMPI((mode.size, PETSc.DETERMINE), bsize=dim, comm=comm)
        vector.array[:] = mode.ravel()
        for _ in range(2):  # twice is enough, however far the body is from the origin
            for other in vectors:
                vector.axpy(-vector.dot(other), other)
            vector.normalize()
        vectors.append(vector)
    return PETSc.NullSpace().create(vectors=vectors, comm=comm)
