"""Linear solvers on PETSc, what they count, and small helpers around degrees of freedom."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from typing import Any

from myostrain.engine import PETSc, fem, lasting
from myostrain.errors import ComputationError, InputError
from myostrain.solvers.options import check_options, without_viewers
from myostrain.state import State

import numpy as np
import numpy.typing as npt
from dolfinx.la import InsertMode

Options = Mapping[str, str | int | float | bool | None]
"""PETSc options without a prefix, such as ``{"ksp_type": "cg"}``."""

_numbers = itertools.count()


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


def make_ksp(
    matrix: PETSc.Mat,
    name: str,
    defaults: Options,
    options: Options | None,
) -> PETSc.KSP:
    """A linear solver with an options prefix of its own.

    Args:
        matrix: The matrix, whose values may change between solves.
        name: "mechanics" or "potential": the section [solver.NAME] of a case file.
        defaults: Our options.
        options: The user's options, which win.

    Raises:
        InputError: An option may not be set, or not to its value, or PETSc refuses it.
    """
    check_options(name, options)
    prefix = f"myostrain_{name}_{next(_numbers)}_"
    database: Any = PETSc.Options(prefix)
    for key, value in {**defaults, **without_viewers(options)}.items():
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
    for key in set(options or {}) - {"pc_precision"}:  # which is read with the first factorization
        if key.startswith(("ksp_", "pc_")) and not PETSc.Options().used(prefix + key):
            raise InputError("PETSc has no use for this option with this solver", f"solver.{name}.{key}")
    return ksp


def reason(ksp: Any) -> int:
    """PETSc's reason for having stopped; negative for failure."""
    return int(ksp.getConvergedReason())


def reason_name(why: int) -> str:
    """PETSc's name for a reason to have stopped, such as DIVERGED_MAX_IT."""
    names = {v: k for k, v in vars(PETSc.KSP.ConvergedReason).items() if isinstance(v, int)}
    return names.get(why, f"PETSc's reason {why}")


def preconditioner(symmetric: bool, processes: int, nodes: int, dim: int) -> Options:
    """Options of the potential's preconditioner: incomplete factors with some fill, process by process.

    The mass dominates at the steps that accuracy asks for. On sheets of 3,000 to 191,000 nodes at Δt = 3e-3
    the kept factors take 2 to 5 iterations and 0.4 to 0.7 µs a node and step (ksp_rtol 1e-8), Jacobi 5 to 31
    and 0.4 to 1.0 µs, multigrid 1 to 4 and 1.3 to 2.0 µs. On 191,000 nodes three levels of
    fill take 4.8 iterations for 7.1 with one, in the same time: beyond 100,000 the count does not grow.

    In a solid, where a node has 14 neighbours, Jacobi is the faster one up to D Δt/h² of about one: at 0.12
    it takes 7.4 iterations, in which a step takes 0.2 µs a node without the membrane, incomplete factors
    2.9 and 0.5 µs; at 2 both take 0.5 µs. It needs no memory, and is the same on all numbers of processes.
    There the tolerance is 1e-8 in place of 1e-10: of 7 iterations it saves two, and a pulse of 130 mV changes
    by 1e-5 mV, a thousandth or less of what steps that resolve its upstroke leave.
    """
    if dim == 3:
        return {"pc_type": "jacobi", "ksp_rtol": 1e-8}
    kind = "icc" if symmetric else "ilu"
    levels = 1 if nodes <= 100_000 else 3
    if processes == 1:
        return {"pc_type": kind, "pc_factor_levels": levels}
    return {"pc_type": "bjacobi", "sub_pc_type": kind, "sub_pc_factor_levels": levels}


def solver_options(
    symmetric: bool, processes: int, nodes: int, dim: int, chosen: Options
) -> tuple[Options, bool]:
    """Options of the potential's solver, and whether its preconditioner may be kept from step to step.

    Args:
        symmetric: Whether the matrix is.
        processes: How many share it.
        nodes: Its size.
        dim: Dimension of the body.
        chosen: Options of the user.
    """
    defaults: dict[str, str | int | float | bool | None] = {
        "ksp_type": "cg" if symmetric else "bcgs",
        "ksp_rtol": 1e-10,
        "ksp_initial_guess_nonzero": chosen.get("ksp_type") != "preonly",
    }
    if "pc_type" not in chosen:
        defaults |= preconditioner(symmetric, processes, nodes, dim)
    # A user's choice may be a direct solver, which must follow the matrix.
    # PETSc takes the diagonal for Jacobi at the first use: it cannot be kept, and costs nothing to renew.
    return defaults, defaults.get("pc_type") != "jacobi" and not {"ksp_type", "pc_type"} & chosen.keys()


def last_resort() -> Options:
    """Options of a direct solver for any matrix; with MUMPS it pivots."""
    package = "mumps" if PETSc.Sys.hasExternalPackage("mumps") else "petsc"
    return {"ksp_type": "preonly", "pc_type": "lu", "pc_factor_mat_solver_type": package}


@contextmanager
def pivoting(matrix: PETSc.Mat, name: str) -> Iterator[PETSc.KSP]:
    """A direct solver for any matrix, for a while (collective).

    Args:
        matrix: The matrix.
        name: "mechanics" or "potential", for messages.
    """
    prefix = matrix.getOptionsPrefix()
    ksp = make_ksp(matrix, name, last_resort(), None)
    try:
        yield ksp
    finally:
        matrix.setOptionsPrefix(prefix)
        discard(ksp)


def discard(ksp: PETSc.KSP) -> None:
    """Free a solver with its factors and options (collective)."""
    options = PETSc.Options(ksp.getOptionsPrefix())
    for key in options.getAll():
        options.delValue(key)
    ksp.destroy()  # on several processes PETSc would keep it, factors and all, when Python drops it


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


def points_of_dofs(space: fem.FunctionSpace) -> npt.NDArray[np.float64]:
    """Material coordinates (n, dim) of the local degrees of freedom, blocks counted out."""
    dim = space.mesh.geometry.dim
    if space.num_sub_spaces > 0 and space.dofmap.index_map_bs == 1:
        dofmap = space.dofmap
        points = np.zeros((dofmap.index_map.size_local + dofmap.index_map.num_ghosts, dim))
        for i in range(space.num_sub_spaces):
            part, dofs = space.sub(i).collapse()
            points[dofs] = points_of_dofs(part)
        return points
    return np.repeat(space.tabulate_dof_coordinates()[:, :dim], space.dofmap.index_map_bs, axis=0)


def place_of_largest(space: fem.FunctionSpace, values: npt.NDArray[np.float64]) -> list[float]:
    """Material coordinates where owned values are largest in magnitude, or not finite (collective)."""
    comm = lasting(space.mesh.comm)
    sizes = np.nan_to_num(np.abs(values[: owned_dofs(space)]), nan=np.inf)
    mine = (-1.0, [0.0])
    if sizes.size:
        dof = int(np.argmax(sizes))
        mine = (float(sizes[dof]), np.round(points_of_dofs(space)[dof], 4).tolist())
    return max(comm.allgather(mine), key=lambda found: found[0])[1]


def assemble_nodal(form: fem.Form) -> npt.NDArray[np.float64]:
    """Assemble a linear form; values at owned and ghost degrees of freedom, summed over processes."""
    b = fem.assemble_vector(form)
    b.scatter_reverse(InsertMode.add)
    b.scatter_forward()
    return b.array


class LinearSolver:
    """A linear solver for one matrix whose values change.

    Args:
        matrix: The PETSc matrix.
        name: Section of a case file that reaches its options.
        defaults: Our options.
        options: The user's options.
        keep: Whether to keep the preconditioner while the matrix changes; it is made again after a
            solve that takes over one iteration more than the first one with it did.
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
        self._matrix, self._name, self._keep = matrix, name, keep
        self._first = 0  # iterations of the first solve with the kept preconditioner; 0: make it again

    @property
    def renews(self) -> bool:
        """Whether the next solve makes a preconditioner that later ones keep."""
        return self._keep and self._first == 0

    def forget(self) -> None:
        """Make the preconditioner again at the next solve."""
        self._first = 0

    def precondition(self) -> None:
        """Make the preconditioner of the present matrix."""
        self.ksp.getPC().setReusePreconditioner(False)
        self.ksp.setOperators(self._matrix)
        self.ksp.setUp()
        self.ksp.setUpOnBlocks()  # those of several processes would wait for the next solve

    @contextmanager
    def direct_solver(self) -> Iterator[None]:
        """Solve by a direct solver for a while, whatever the options say."""
        usual, keep = self.ksp, self._keep
        with pivoting(self._matrix, self._name) as ksp:
            self.ksp, self._keep = ksp, False
            try:
                yield
            finally:
                self.ksp, self._keep = usual, keep
                self.forget()

    def state(self) -> State:
        """Counts."""
        return {"counters": self.counters.as_dict(), "first": self._first}

    def restore(self, state: State) -> None:
        """Go on from a state; the preconditioner is the caller's to make again."""
        self.counters = Counters(**state["counters"])
        self._first = state["first"]

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve for x, which holds the initial guess where the method uses one.

        Raises:
            ComputationError: It did not converge.
        """
        if self._keep:
            self.ksp.getPC().setReusePreconditioner(not self.renews)
        try:
            self.ksp.solve(b, x)
        except PETSc.Error as error:  # a factorization met NaN or a zero pivot
            self.forget()
            raise self._failure(str(error).splitlines()[-1]) from error
        iterations = self.ksp.getIterationNumber()
        self.counters.solves += 1
        self.counters.linear += iterations
        if self._keep:
            first = self._first or iterations
            self._first = 0 if iterations > first + 1 else first
        why = reason(self.ksp)
        if why < 0:
            self.forget()
            raise self._failure(reason_name(why))

    def _failure(self, why: str) -> ComputationError:
        return ComputationError(
            f"the linear solver of the {self._name} did not converge ({why})",
            advice=f"a smaller time step, or other options in [solver.{self._name}].",
        )
