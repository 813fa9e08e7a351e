"""The solver of large solids: GMRES by blocks, with multigrid for the displacement, a mass for the pressure.

The tangent of an incompressible body is K = [[A, Bᵀ], [B, C]], C = 0, kept as these blocks. GMRES solves with
it, preconditioned from the right by the upper triangle of

    P = [[A, Bᵀ], [B, C − ∫ p q / (2μ)]],

where μ is a shear modulus of the present state. The mass stands for the Schur complement, to which it is
spectrally equivalent (with the body's augmentation nearly equal: with A⁻¹ itself six iterations gain six
digits); two levels of multigrid stand for A⁻¹ (:mod:`myostrain.solvers.two_level`). See M. Benzi,
G. H. Golub, J. Liesen, Acta Numerica 14 (2005) 1–137, sections 8 and 10, doi 10.1017/S0962492904000212. A
nearly incompressible body without a pressure has A alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from myostrain.engine import PETSc, fem
from myostrain.solvers.linear import Options, make_ksp, owned_dofs
from myostrain.solvers.two_level import GAMG, SWEEP, Matrix, TwoLevels, conditions, part_solver, rigid_motions

import numpy as np
import ufl

#: Unknowns of a solid from which this solver is taken in place of a kept factorization.
LARGE = 500_000
#: Past corrections that are combined there.
MEMORY = 5
#: Relative residual of solutions that are kept with the tangent.
WELL = 1e-4
#: Mean contraction above which the tangent is renewed there: it takes as long as a few corrections.
SLOW = 0.3

KRYLOV: Options = {
    "ksp_type": "gmres",
    "ksp_pc_side": "right",
    "ksp_rtol": 0.1,  # corrections are combined, and the residual is always the present one
    "ksp_max_it": 200,
    "ksp_gmres_restart": 50,
}


def wanted(space: fem.FunctionSpace, unknowns: int, options: Options | None) -> bool:
    """Whether this solver is taken: by size, or as the user says."""
    chosen = (options or {}).get("pc_type")
    if chosen is None:
        return space.mesh.geometry.dim == 3 and unknowns >= LARGE
    return chosen == ("fieldsplit" if space.num_sub_spaces and space.dofmap.index_map_bs == 1 else "gamg")


class Blocks:
    """Solves with the blocks of a tangent.

    Args:
        residual: UFL form on the space of displacement and pressure, or of displacement alone.
        unknown: What it is differentiated by.
        bcs: Conditions, homogeneous for what is solved for.
        stabilization: Form with what stands for the Schur complement; None without pressure.
        name: Section of a case file that reaches the options.
        options: Options of the user.
        symmetric: Whether the tangent is symmetric.

    Attributes:
        ksp: The Krylov solver.
        levels: The multigrid for the displacement, unless the user has another solver for it.
    """

    def __init__(
        self,
        residual: Any,
        unknown: fem.Function,
        bcs: Sequence[fem.DirichletBC],
        stabilization: Any,
        name: str,
        options: Options | None,
        symmetric: bool,
    ) -> None:
        space = unknown.function_space
        mesh, test = space.mesh, residual.arguments()[0]
        mixed = stabilization is not None
        fixed = np.concatenate([np.zeros(0, np.int32), *(bc.dof_indices()[0] for bc in bcs)])
        if mixed:
            (V, u_dofs), (Q, p_dofs) = (space.sub(i).collapse() for i in range(2))
            self._dofs: list[Any] = [
                np.ravel(dofs)[: owned_dofs(part)] for part, dofs in ((V, u_dofs), (Q, p_dofs))
            ]
            fixed = np.flatnonzero(np.isin(np.ravel(u_dofs), fixed))
        else:
            V, self._dofs = space, [slice(0, owned_dofs(space))]
        dim = V.dofmap.index_map_bs
        fixed = np.unique(fixed).astype(np.int32)
        held = conditions(V, fixed)

        def displacement(v: Any) -> Any:
            return ufl.as_vector([*(v[i] for i in range(dim)), 0]) if mixed else v

        def tangent(rows: Any, columns: Any) -> Any:
            return ufl.derivative(ufl.replace(residual, {test: rows}), unknown, columns)

        def of_displacements(on: fem.FunctionSpace) -> Any:
            return tangent(displacement(ufl.TestFunction(on)), displacement(ufl.TrialFunction(on)))

        A = Matrix(of_displacements(V), held, symmetric)
        self._matrices = [A]
        if mixed:
            zeros = [0] * dim
            rows = ufl.as_vector([*zeros, ufl.TestFunction(Q)])
            columns = ufl.as_vector([*zeros, ufl.TrialFunction(Q)])
            Bt = Matrix(tangent(displacement(ufl.TestFunction(V)), columns), held)
            arguments = dict(zip(stabilization.arguments(), (rows, columns), strict=True))
            schur = ufl.replace(stabilization, arguments)
            of_pressure = ufl.algorithms.expand_derivatives(tangent(rows, columns))
            C = None if of_pressure.empty() else Matrix(of_pressure)
            S = Matrix(schur if C is None else schur + of_pressure)
            self._matrices += [part for part in (Bt, C, S) if part is not None]
            corner = None if C is None else C.matrix
            blocks = [[A.matrix, Bt.matrix], [PETSc.Mat().createTranspose(Bt.matrix), corner]]
            self._K = PETSc.Mat().createNest(blocks, comm=mesh.comm)
        else:
            self._K = A.matrix
        chosen = {key: value for key, value in (options or {}).items() if key != "pc_type"}
        self.ksp = make_ksp(self._K, name, {**KRYLOV, "pc_type": "python"}, chosen)
        prefix = self.ksp.getOptionsPrefix() + ("fieldsplit_u_" if mixed else "")
        self.levels: TwoLevels | None = None
        if V.ufl_element().degree == 2 and "fieldsplit_u_pc_type" not in chosen:
            coarse = TwoLevels.coarse_space(V)
            self.levels = TwoLevels(V, fixed, A.matrix, of_displacements(coarse), coarse, symmetric, prefix)
            self._matrices.append(self.levels.matrix)
            self._solvers = [self.levels.coarse, self.levels.smoother]
            apply = self.levels.apply
        else:
            A.matrix.setNearNullSpace(rigid_motions(V))
            self._solvers = [part_solver(A.matrix, prefix, {"ksp_type": "preonly", **GAMG})]
            apply = self._solvers[0].solve
        preconditioner: Any = _Alone(apply)
        if mixed:
            prefix = f"{self.ksp.getOptionsPrefix()}fieldsplit_p_"
            self._solvers.append(part_solver(S.matrix, prefix, {**SWEEP, "ksp_max_it": 2}))
            preconditioner = _Upper(apply, Bt.matrix, self._solvers[-1], self._K.getNestISs()[0])
        self.ksp.getPC().setPythonContext(preconditioner)
        size = self._K.getLocalSize()[0]
        self._b, self._x = (PETSc.Vec().createMPI((size, PETSc.DETERMINE), comm=mesh.comm) for _ in range(2))

    def renew(self) -> None:
        """Assemble the tangent at the present state, and make the preconditioner (collective)."""
        for matrix in self._matrices:
            matrix.assemble()
        for solver in self._solvers:
            solver.setOperators(solver.getOperators()[0])
            solver.setUp()
        self._K.assemble()
        self.ksp.setOperators(self._K)

    @contextmanager
    def precisely(self) -> Iterator[None]:
        """For a while solve for what is kept."""
        usual = self.ksp.getTolerances()[0]
        self.ksp.setTolerances(rtol=min(usual, WELL))
        try:
            yield
        finally:
            self.ksp.setTolerances(rtol=usual)

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for x, owned degrees of freedom of the whole space (collective)."""
        given, found, first = b.array_r, self._b.array, 0
        for dofs in self._dofs:
            part = given[dofs]
            found[first : first + len(part)] = part
            first += len(part)
        self.ksp.solve(self._b, self._x)
        solution, first, values = x.array, 0, self._x.array_r
        for dofs in self._dofs:
            size = len(solution[dofs])
            solution[dofs] = values[first : first + size]
            first += size


class _Alone:
    """A preconditioner of PETSc from a function."""

    def __init__(self, apply: Any) -> None:
        self._apply = apply

    def apply(self, pc: PETSc.PC, x: PETSc.Vec, y: PETSc.Vec) -> None:
        self._apply(x, y)


class _Upper:
    """The upper triangle: the pressure first, then the displacement that goes with it."""

    def __init__(self, apply: Any, Bt: PETSc.Mat, pressure: PETSc.KSP, sets: Sequence[PETSc.IS]) -> None:
        self._displacement, self._Bt, self._pressure, self._sets = apply, Bt, pressure, sets
        self._force = Bt.createVecLeft()

    def apply(self, pc: PETSc.PC, x: PETSc.Vec, y: PETSc.Vec) -> None:
        given, found = ([vector.getSubVector(index) for index in self._sets] for vector in (x, y))
        self._pressure.solve(given[1], found[1])
        self._Bt.mult(found[1], self._force)
        self._force.aypx(-1.0, given[0])
        self._displacement(self._force, found[0])
        for vector, parts in ((x, given), (y, found)):
            for index, part in zip(self._sets, parts, strict=True):
                vector.restoreSubVector(index, part)
