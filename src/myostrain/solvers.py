"""Linear and nonlinear solvers on PETSc: they own matrices and factorizations, and count what they do."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from myostrain.engine import PETSc, compile_form, fem, lasting
from myostrain.errors import ComputationError, InputError

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx.fem import petsc as fem_petsc
from dolfinx.la import InsertMode

Options = Mapping[str, str | int | float | bool | None]
"""PETSc options without a prefix, such as ``{"ksp_type": "cg"}``."""

_numbers = itertools.count()

#: Unknowns below which PETSc's own factorization is taken on one process.
SMALL = 60_000


@dataclass
class Counters:
    """What a solver has done so far."""

    solves: int = 0
    newton: int = 0
    linear: int = 0
    factorizations: int = 0
    assemblies: int = 0

    def as_dict(self) -> dict[str, int]:
        """The counts by name."""
        return asdict(self)


def make_ksp(matrix: PETSc.Mat, name: str, defaults: Options, options: Options | None) -> PETSc.KSP:
    """A linear solver with an options prefix of its own.

    Args:
        matrix: The matrix, whose values may change between solves.
        name: "mechanics" or "potential": the section [solver.NAME] of a case file.
        defaults: Our options.
        options: The user's options, which win.

    Raises:
        InputError: An option is not one of a linear solver, or PETSc refuses its value.
    """
    for key in options or {}:
        if not key.startswith(("ksp_", "pc_", "mat_", "sub_", "mg_", "fieldsplit_")):
            raise InputError(
                "no option of a linear solver: they begin with ksp_, pc_ or mat_", f"solver.{name}.{key}"
            )
    prefix = f"myostrain_{name}_{next(_numbers)}_"
    database: Any = PETSc.Options(prefix)
    for key, value in {**defaults, **(options or {})}.items():
        database[key] = value
    ksp = PETSc.KSP().create(matrix.comm)
    ksp.setOptionsPrefix(prefix)
    ksp.setOperators(matrix)
    matrix.setOptionsPrefix(prefix)
    try:
        ksp.setFromOptions()
    except PETSc.Error as error:
        given = ", ".join(f"{key} = {value}" for key, value in (options or {}).items())
        last = str(error).splitlines()[-1].partition("] ")[2]
        raise InputError(f"PETSc refuses {given}: {last}", f"solver.{name}") from error
    for key in options or {}:
        if key.startswith(("ksp_", "pc_")) and not PETSc.Options().used(prefix + key):
            raise InputError("PETSc has no use for this option with this solver", f"solver.{name}.{key}")
    return ksp


def reason(ksp: Any) -> int:
    """PETSc's reason for having stopped; negative for failure."""
    return int(ksp.getConvergedReason())


def direct(unknowns: int, processes: int, saddle_point: bool) -> Options:
    """Options of the direct solver for a symmetric tangent.

    PETSc's own Cholesky factors solve three times faster than those of MUMPS (2.5 against 8 ms for 24,000
    unknowns of a sheet) but take longer to compute, and no pivots: it is taken on one process, up to
    :data:`SMALL` unknowns, without a zero block.
    """
    if processes == 1 and not saddle_point and unknowns < SMALL:
        return {"ksp_type": "preonly", "pc_type": "cholesky", "pc_factor_mat_ordering_type": "nd"}
    if not PETSc.Sys.hasExternalPackage("mumps"):
        raise InputError(
            "this PETSc has no MUMPS, which the default solver needs for large bodies, pressures and several "
            "processes; choose another solver in [solver.mechanics]",
            "solver.mechanics",
        )
    return {
        "ksp_type": "preonly",
        "pc_type": "cholesky",
        "pc_factor_mat_solver_type": "mumps",
        "mat_mumps_icntl_14": 60,  # room for pivoting, in percent
    }


def owned_dofs(space: fem.FunctionSpace) -> int:
    """Number of degrees of freedom that this process owns (blocks counted out)."""
    return int(space.dofmap.index_map.size_local * space.dofmap.index_map_bs)


def global_dofs(space: fem.FunctionSpace) -> int:
    """Number of degrees of freedom over all processes."""
    return int(space.dofmap.index_map.size_global * space.dofmap.index_map_bs)


def largest(values: npt.NDArray[np.float64], comm: Any) -> float:
    """Largest magnitude over all processes; NaN if there is one anywhere."""
    local = float(np.abs(values).max(initial=0.0))
    if comm.size == 1:
        return local
    return max(comm.allgather(local), key=lambda value: (math.isnan(value), value))


def assemble_nodal(form: fem.Form) -> npt.NDArray[np.float64]:
    """Assemble a linear form; values at owned and ghost degrees of freedom, summed over processes."""
    b = fem.assemble_vector(form)
    b.scatter_reverse(InsertMode.add)
    b.scatter_forward()
    return b.array


class ChordNewton:
    """Newton's method that keeps its factorization for as long as it contracts well.

    A correction is accepted when the next one, by the same factorization, is smaller (Deuflhard's natural
    monotonicity test). If it is not, the tangent is renewed, and with a fresh tangent the step is halved. The
    residual is always that of the present state, so an old tangent costs iterations, never accuracy.

    Args:
        residual: UFL form, linear in a test function.
        unknown: The unknown, updated in place; it satisfies the conditions ``bcs`` already.
        bcs: Conditions, homogeneous for the corrections.
        measured: Owned degrees of freedom in which corrections are measured; None for all of them.
        tolerance: Estimated largest error of the measured unknowns at which to stop, in their unit.
        name: Section of a case file that reaches the linear solver's options.
        options: Options of the linear solver.
        saddle_point: Whether the tangent has a zero block.
        refresh: Contraction above which the tangent is renewed.
        max_iterations: Corrections that a solve may take.
    """

    def __init__(
        self,
        residual: Any,
        unknown: fem.Function,
        bcs: Sequence[fem.DirichletBC],
        *,
        measured: npt.NDArray[np.int32] | None = None,
        tolerance: float = 1e-9,
        name: str = "mechanics",
        options: Options | None = None,
        saddle_point: bool = False,
        refresh: float = 0.3,
        max_iterations: int = 60,
    ) -> None:
        self.counters = Counters()
        self.tolerance = tolerance
        space = unknown.function_space
        self._comm = lasting(space.mesh.comm)
        self._unknown, self._bcs = unknown, list(bcs)
        self._owned = owned_dofs(space)
        self._measured = slice(0, self._owned) if measured is None else measured
        self._name, self._refresh, self._max = name, refresh, max_iterations
        self._residual = compile_form(residual)
        self._tangent = compile_form(ufl.derivative(residual, unknown))
        self._matrix = fem_petsc.create_matrix(self._tangent)
        self._matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        self._b, self._dx = fem.Function(space), fem.Function(space)
        dofs = [bc.dof_indices()[0] for bc in self._bcs]
        self._fixed = np.unique(np.concatenate(dofs)) if dofs else np.zeros(0, dtype=np.int32)
        defaults = direct(global_dofs(space), self._comm.size, saddle_point)
        self.ksp = make_ksp(self._matrix, name, defaults, options)
        self._ready = False  # whether there is a factorization
        # Its contraction as last measured, the correction then, and how often it has been trusted since.
        self._rate, self._first, self._unchecked = math.inf, 0.0, 0

    def forget(self) -> None:
        """Drop the factorization: the next solve begins with a fresh tangent."""
        self._ready, self._rate = False, math.inf

    def residual_norm(self) -> float:
        """Largest entry of the residual at the present state (outside fixed degrees of freedom)."""
        self._assemble()
        return largest(self._b.x.array[: self._owned], self._comm)

    def _assemble(self) -> None:
        b = self._b.x
        b.array[:] = 0.0
        fem.assemble_vector(b.array, self._residual)
        if self._comm.size > 1:
            b.scatter_reverse(InsertMode.add)
        b.array[self._fixed] = 0.0
        self.counters.assemblies += 1

    def _renew(self) -> None:
        self._matrix.zeroEntries()
        fem_petsc.assemble_matrix(self._matrix, self._tangent, bcs=self._bcs)
        self._matrix.assemble()
        self.ksp.setOperators(self._matrix)
        try:
            self.ksp.setUp()
        except PETSc.Error as error:
            raise ComputationError(
                f"the tangent of the {self._name} cannot be factorized ({error})",
                advice=f"a smaller time step, or another solver in [solver.{self._name}].",
            ) from error
        self.counters.factorizations += 1
        self._ready, self._rate = True, math.inf

    def _correction(self) -> float:
        """Solve for the correction at the assembled residual; its measured size, or NaN."""
        self.ksp.solve(self._b.x.petsc_vec, self._dx.x.petsc_vec)
        self.counters.linear += max(1, self.ksp.getIterationNumber())
        if reason(self.ksp) < 0:
            return math.nan
        return largest(self._dx.x.array[self._measured], self._comm)

    def _trusted(self, size: float) -> bool:
        """Whether one correction of this size by a kept tangent may end a solve without another residual.

        It may when the correction is no larger than in the solve in which the tangent's contraction was
        measured, ten times that contraction (at least 1 %) leaves an error within the tolerance, and this has
        not happened ten times in a row.
        """
        if not (size <= 3 * self._first and size * max(0.01, 10 * self._rate) <= self.tolerance):
            return False
        self._unchecked += 1
        return self._unchecked <= 10

    def solve(self) -> int:
        """Solve for the unknown from its present value; returns the number of corrections.

        Raises:
            ComputationError: It did not converge. The unknown is then what it was before.
        """
        x, before, dx = self._unknown.x, self._unknown.x.array.copy(), self._dx.x.array
        self.counters.solves += 1
        fresh = not self._ready
        kept = self._ready  # whether this solve has one tangent, older than itself
        self._assemble()
        if fresh:
            self._renew()
        size, damping = self._correction(), 1.0
        first = size
        # Corrections at the level of round-off need not shrink.
        negligible = max(1e-3 * self.tolerance, 1e-14 * largest(before[: self._owned], self._comm))
        for iteration in range(1, self._max + 1):
            self.counters.newton += 1
            origin, step = x.array.copy(), dx.copy()
            x.array[:] = origin - damping * step
            x.scatter_forward()
            if size <= negligible or (iteration == 1 and self._trusted(size)):
                return iteration
            self._unchecked = 0
            self._assemble()
            following = self._correction()
            if not following < max(size * (1 - damping / 2), negligible):  # also when it is NaN
                x.array[:] = origin
                if not fresh:
                    self._assemble()
                    self._renew()
                    fresh, kept, size, damping = True, False, self._correction(), 1.0
                else:
                    dx[:] = step
                    damping /= 2
                if damping < 1e-3 or not math.isfinite(size):
                    break
                continue
            contraction = following / size if size else 0.0
            fresh, size = False, following
            if damping == 1.0:
                if kept and iteration == 1:
                    self._rate, self._first = contraction, first
                if size * contraction / (1 - contraction) <= self.tolerance:
                    x.array[:] -= dx
                    x.scatter_forward()
                    return iteration
            if contraction > self._refresh:
                self._renew()
                fresh, kept, size = True, False, self._correction()
            damping = min(1.0, 2 * damping)
        x.array[:] = before
        x.scatter_forward()
        self.forget()
        raise ComputationError(
            f"Newton's method for the {self._name} did not converge in {iteration} corrections "
            f"(last correction {size:.3g}, wanted {self.tolerance:.3g})",
            advice="a smaller time step, a smaller activation or load.",
        )


class LinearSolver:
    """A linear solver for one matrix whose values change.

    Args:
        matrix: The PETSc matrix.
        name: Section of a case file that reaches its options.
        defaults: Our options.
        options: The user's options.
        keep: Whether to keep the preconditioner while the matrix changes; it is made again when a solve
            takes half as many iterations again as the first one with it did.
    """

    def __init__(
        self,
        matrix: PETSc.Mat,
        name: str,
        defaults: Options,
        options: Options | None = None,
        *,
        keep: bool = False,
    ) -> None:
        self.counters = Counters()
        self.ksp = make_ksp(matrix, name, defaults, options)
        self._name, self._keep = name, keep
        self._first = 0  # iterations of the first solve with the kept preconditioner

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for x, which holds the initial guess where the method uses one.

        Raises:
            ComputationError: It did not converge.
        """
        if self._keep:
            self.ksp.getPC().setReusePreconditioner(self._first > 0)
        self.ksp.solve(b, x)
        iterations = self.ksp.getIterationNumber()
        self.counters.solves += 1
        self.counters.linear += iterations
        if self._keep:
            first = self._first or iterations
            self._first = 0 if iterations > 1.5 * first + 2 else first
        why = reason(self.ksp)
        if why < 0:
            raise ComputationError(
                f"the linear solver of the {self._name} did not converge (PETSc's reason {why})",
                advice=f"a smaller time step, or other options in [solver.{self._name}].",
            )
