"""Newton's method with a kept tangent."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

from myostrain.engine import MPI, PETSc, compile_form, fem, lasting
from myostrain.errors import ComputationError
from myostrain.solvers import saddle_point as saddle_point_solver
from myostrain.solvers.anderson import Anderson
from myostrain.solvers.border import Border, Bordered
from myostrain.solvers.factors import CHOICE, ROUNDING, direct, refine
from myostrain.solvers.linear import (
    Counters,
    Options,
    discard,
    global_dofs,
    largest,
    make_ksp,
    owned_dofs,
    pivoting,
    place_of_largest,
    reason,
)
from myostrain.solvers.origin import Origin
from myostrain.state import State

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx.fem import petsc as fem_petsc
from dolfinx.la import InsertMode

#: Past corrections that are combined in a solid, where a factorization is dear.
MEMORY = 10
#: How far a correction may grow there.
GROWTH = 4.0
#: Mean contraction above which the tangent is renewed there.
SLOW = 0.8


class ChordNewton:
    """Newton's method that keeps its factorization for as long as it contracts well.

    A correction is accepted when the next one, by the same factorization, is smaller (Deuflhard's natural
    monotonicity test). If it is not, the tangent is renewed, and with a fresh tangent the step is halved. The
    residual is always that of the present state: an old tangent, or one rounded, costs iterations only.

    In a solid a factorization takes as long as fifty corrections, and is kept for longer: corrections are
    combined with the past ones of the solve (:class:`~myostrain.solvers.anderson.Anderson`), and may grow
    for once. So does a large solid (:mod:`myostrain.solvers.saddle_point`), whose tangent is solved with by
    iterations, to a tenth.

    Args:
        residual: UFL form, linear in a test function.
        unknown: The unknown, updated in place.
        bcs: Conditions, homogeneous for the corrections: the unknown keeps its values there.
        moving: Conditions besides, whose values may change between solves; the unknown is moved to them.
        measured: Owned degrees of freedom in which corrections are measured; None for all of them.
        tolerance: Estimated largest error of the measured unknowns at which to stop, in their unit.
        name: Section of a case file that reaches the linear solver's options.
        options: Options of the linear solver.
        saddle_point: Whether the tangent has a zero block.
        symmetric: Whether the tangent is symmetric; that of a follower pressure is not.
        stabilization: Form that makes a preconditioner of the tangent of a large solid with a zero block.
        depends_on: Functions and constants, beside the unknown, that the tangent depends on.
        numbers: A few numbers in the residual that are unknowns too, each with an equation.
        refresh: Contraction above which the tangent is renewed.
        max_iterations: Corrections that a solve may take.
        advice: What to try where it does not converge.
    """

    def __init__(
        self,
        residual: Any,
        unknown: fem.Function,
        bcs: Sequence[fem.DirichletBC],
        *,
        moving: Sequence[fem.DirichletBC] = (),
        measured: npt.NDArray[np.int32] | None = None,
        tolerance: float = 1e-9,
        name: str = "mechanics",
        options: Options | None = None,
        saddle_point: bool = False,
        symmetric: bool = True,
        stabilization: Any = None,
        depends_on: Sequence[Any] = (),
        numbers: Bordered | None = None,
        refresh: float = 0.3,
        max_iterations: int = 60,
        advice: str = "a smaller time step.",
    ) -> None:
        self._advice = advice
        self.counters = Counters()
        self.tolerance = tolerance
        space = unknown.function_space
        self._comm = lasting(space.mesh.comm)
        self._unknown, self._bcs, self._moving = unknown, [*bcs, *moving], list(moving)
        self._owned = owned_dofs(space)
        self._measured = slice(0, self._owned) if measured is None else measured
        self._name, self._refresh, self._max, self._options = name, refresh, max_iterations, options
        self._residual = compile_form(residual)
        tangent = ufl.derivative(residual, unknown)
        self._tangent = compile_form(tangent)
        self._symmetric = symmetric
        self._made: PETSc.Mat | None = None  # the tangent as one matrix, from its first use on
        self._b, self._dx, self._lift = fem.Function(space), fem.Function(space), fem.Function(space)
        dofs = [bc.dof_indices()[0] for bc in self._bcs]
        self._fixed = np.unique(np.concatenate(dofs)) if dofs else np.zeros(0, dtype=np.int32)
        self._border = None if numbers is None else Border(numbers, space, self._fixed)
        solid, unknowns = space.mesh.geometry.dim == 3, global_dofs(space)
        self._memory = MEMORY if solid else 0  # corrections that are combined
        self._single = False  # whether factors are of single precision
        self._slow, self._blocks = SLOW, None
        if saddle_point_solver.wanted(space, unknowns, options) and saddle_point == (
            stabilization is not None
        ):
            self._slow, self._memory = saddle_point_solver.SLOW, saddle_point_solver.MEMORY
            self._blocks = saddle_point_solver.Blocks(
                residual, unknown, self._bcs, stabilization, name, options, symmetric
            )
            self.ksp = self._blocks.ksp
        else:
            self._direct = partial(direct, unknowns, self._comm.size, saddle_point, symmetric, solid)
            self._use(single=solid and not CHOICE & set(options or {}))
        self._unproven = False  # whether the factors are new ones in single precision
        self._ready = False  # whether there is a factorization
        self._origin = Origin([unknown, *depends_on])
        # Its contraction as last measured, the correction then, and how often it has been trusted since.
        self._rate, self._first, self._unchecked = math.inf, 0.0, 0

    def forget(self) -> None:
        """Drop the factorization: the next solve begins with a fresh tangent."""
        self._ready, self._rate, self._first, self._unchecked = False, math.inf, 0.0, 0

    @property
    def pivots(self) -> bool:
        """Whether corrections are found by a factorization that pivots, so that another one hardly helps."""
        pc = self.ksp.getPC()
        return pc.getType() in ("lu", "cholesky") and pc.getFactorSolverType() == "mumps"

    @contextmanager
    def direct_solver(self) -> Iterator[None]:
        """Solve by a direct solver with pivots for a while."""
        usual = self.ksp, self._blocks, self._single
        with pivoting(self._matrix, self._name) as ksp:
            self.ksp, self._blocks, self._single = ksp, None, False
            self.forget()
            try:
                yield
            finally:
                self.ksp, self._blocks, self._single = usual
                self.forget()

    def _use(self, *, single: bool) -> None:
        """Make the direct solver, with factors in single or in double precision."""
        defaults = self._direct(single)
        self._single = defaults.get("pc_precision") == "single"
        self.ksp = make_ksp(self._matrix, self._name, defaults, self._options)

    def state(self) -> State:
        """Counts, and what the kept tangent was made of."""
        return {
            "counters": self.counters.as_dict(),
            "ready": self._ready,
            "single": self._single,
            "rate": self._rate,
            "first": self._first,
            "unchecked": self._unchecked,
            "origin": self._origin.state(),
        }

    def restore(self, state: State) -> None:
        """Go on from a state; the tangent is assembled and factorized again where it is another one."""
        same = self._origin.is_that_of(state["origin"])
        if self._single and not state["single"]:
            discard(self.ksp)
            self._use(single=False)
            same = False
        ready = state["ready"] and self._origin.fits(state["origin"])
        if ready and not self._comm.allreduce(same, MPI.LAND):  # one that differs makes all assemble
            with self._origin.put(state["origin"]):
                self._renew()
            self._unproven = False
        self.counters = Counters(**state["counters"])
        self._ready = ready
        self._rate, self._first, self._unchecked = state["rate"], state["first"], state["unchecked"]

    def residual_norm(self) -> float:
        """Largest entry of the residual at the present state (outside fixed degrees of freedom)."""
        self._assemble()
        return largest(self._b.x.array[: self._owned], self._comm)

    def forces(self) -> npt.NDArray[np.float64]:
        """The residual at the present state, also where conditions hold: there it is what they bear."""
        self._assemble_residual()
        self._b.x.scatter_forward()
        return self._b.x.array.copy()

    def _assemble_residual(self) -> None:
        b = self._b.x
        b.array[:] = 0.0
        fem.assemble_vector(b.array, self._residual)
        if self._comm.size > 1:
            b.scatter_reverse(InsertMode.add)

    def _assemble(self) -> None:
        b, x = self._b.x, self._unknown.x.array
        self._assemble_residual()
        b.array[self._fixed] = 0.0
        self.counters.assemblies += 1
        if self._border is not None:
            self._border.assemble()
        if not self._moving:
            return
        # How far the unknown is from the values of these conditions: the correction takes it there, and the
        # tangent says what that does to the others.
        away = np.zeros_like(b.array)
        for condition in self._moving:
            condition.set(away, x, -1.0)
        if largest(away, self._comm) > 1e-3 * self.tolerance:
            lifting = self._lift.x
            lifting.array[:] = 0.0
            fem.apply_lifting(lifting.array, [self._tangent], [self._moving], [x], -1.0)
            if self._comm.size > 1:
                lifting.scatter_reverse(InsertMode.add)
            b.array[:] += lifting.array
            b.array[self._fixed] = away[self._fixed]

    @property
    def _matrix(self) -> PETSc.Mat:
        """The tangent as one matrix, which blocks do without."""
        if self._made is None:
            self._made = matrix = fem_petsc.create_matrix(self._tangent)
            matrix.setOption(PETSc.Mat.Option.SYMMETRIC, self._symmetric)
        return self._made

    def _renew(self) -> None:
        self._ready = False
        try:
            if self._blocks is not None:
                self._blocks.renew()
                if self._border is not None:
                    with self._blocks.precisely():
                        self._border.factor(self._blocks)
            else:
                self._matrix.zeroEntries()
                fem_petsc.assemble_matrix(self._matrix, self._tangent, bcs=self._bcs)
                self._matrix.assemble()
                self.ksp.setOperators(self._matrix)
                self.ksp.setUp()
                if self._border is not None:
                    self._border.factor(self.ksp, rounded=self._single)
        except PETSc.Error as error:
            raise ComputationError(
                f"the tangent of the {self._name} cannot be factorized ({error})",
                advice=f"a smaller time step, or another solver in [solver.{self._name}].",
            ) from error
        self.counters.factorizations += 1
        self._ready, self._rate = True, math.inf
        self._unproven = self._single
        self._origin.take()

    def _correction(self) -> float:
        """Solve for the correction at the assembled residual; its size, or NaN."""
        try:
            solve = self.ksp.solve if self._blocks is None else self._blocks.solve
            solve(self._b.x.petsc_vec, self._dx.x.petsc_vec)
            iterations, why = max(1, self.ksp.getIterationNumber()), reason(self.ksp)
            if self._unproven:
                self._unproven = False
                left = refine(self.ksp, self._b.x.petsc_vec, self._dx.x.petsc_vec, self._measured)
                if not left <= ROUNDING:  # also when it is NaN
                    discard(self.ksp)
                    self._use(single=False)
                    self._renew()
                    return self._correction()
            if self._border is not None:
                self._border.correct(self._dx.x.array)
        except PETSc.Error:  # a factorization met NaN, perhaps on one process alone
            return largest(np.array([math.nan]), self._comm)
        self.counters.linear += iterations
        if why < 0 and not (self._blocks and why == PETSc.KSP.ConvergedReason.DIVERGED_MAX_IT):
            return math.nan  # but of blocks it is still a direction to try
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

    def _worn(self, contraction: float, mean: float, since: int) -> bool:
        """Whether to renew the tangent, by the last contraction and the mean one of the corrections by it."""
        if self._memory:
            return (since >= (6 if self._blocks is None else 3) and mean > self._slow) or since >= 30
        return contraction > self._refresh

    def _get(self) -> npt.NDArray[np.float64]:
        field = self._unknown.x.array[: self._owned]
        return field.copy() if self._border is None else np.append(field, self._border.of.numbers)

    def _put(self, values: npt.NDArray[np.float64]) -> None:
        self._unknown.x.array[: self._owned] = values[: self._owned]
        if self._border is not None:
            self._border.of.put(values[self._owned :])
        self._unknown.x.scatter_forward()

    def _step(self) -> npt.NDArray[np.float64]:
        field = self._dx.x.array[: self._owned]
        return field.copy() if self._border is None else np.append(field, self._border.step)

    def solve(self) -> int:
        """Solve for the unknown from its present value; returns the number of corrections.

        Raises:
            ComputationError: It did not converge. The unknown is then what it was before.
        """
        before = self._get()
        self.counters.solves += 1
        fresh = not self._ready
        kept = self._ready  # whether this solve has one tangent, older than itself
        self._assemble()
        if fresh:
            self._renew()
        size, damping = self._correction(), 1.0
        first, mixing = size, Anderson(self._memory, self._measured, self._comm)
        # The correction when the tangent was renewed last, how many since, and their slowest contraction.
        began, since, slow = size, 0, 0.0
        # Corrections at the level of round-off need not shrink.
        negligible = max(1e-3 * self.tolerance, 1e-14 * largest(before[self._measured], self._comm))
        for iteration in range(1, self._max + 1):
            self.counters.newton += 1
            origin, step = self._get(), self._step()
            if damping == 1.0:
                self._put(origin + mixing.step(origin, -step))
            else:
                mixing.clear()
                self._put(origin - damping * step)
            if size <= negligible or (iteration == 1 and self._trusted(size)):
                return iteration
            self._unchecked = 0
            self._assemble()
            following = self._correction()
            limit = GROWTH * size if self._memory and not fresh else size * (1 - damping / 2)
            if not following < max(limit, negligible):  # also when it is NaN
                self._put(origin)
                mixing.clear()
                if not fresh:
                    self._assemble()
                    self._renew()
                    fresh, kept, size, damping = True, False, self._correction(), 1.0
                    began, since, slow = size, 0, 0.0
                else:
                    self._dx.x.array[: self._owned], damping = step[: self._owned], damping / 2
                    if self._border is not None:
                        self._border.step = step[self._owned :]
                if damping < 1e-3 or not math.isfinite(size):
                    break
                continue
            contraction = following / size if size else 0.0
            fresh, size, since = False, following, since + 1
            mean = (size / began) ** (1 / since) if began else 0.0
            if damping == 1.0:
                if kept and iteration == 1:
                    self._rate, self._first = contraction, first
                # What is left after this correction; none contract evenly, and least after the first of them.
                slow = max(contraction, mean if self._memory else slow)
                left = size if self._memory else (4 if since == 1 else 2) * slow * size
                if slow < 1 and left / (1 - slow) <= self.tolerance:
                    self._put(self._get() - self._step())
                    return iteration
            if self._worn(contraction, mean, since):
                self._renew()
                mixing.clear()
                fresh, kept, size = True, False, self._correction()
                began, since, slow = size, 0, 0.0
            damping = min(1.0, 2 * damping)
        self._assemble()
        where = place_of_largest(self._unknown.function_space, self._b.x.array)
        self._put(before)
        self.forget()
        raise ComputationError(
            f"Newton's method for the {self._name} did not converge in {iteration} corrections "
            f"(last correction {size:.3g}, wanted {self.tolerance:.3g}; the largest residual is near "
            f"{where})",
            where=where,
            advice=self._advice,
        )
