"""Factorizations of a tangent: which one, and how good one of single precision is."""

from __future__ import annotations

from myostrain.engine import PETSc, lasting
from myostrain.errors import InputError
from myostrain.solvers.linear import Options, largest

import numpy as np
import numpy.typing as npt

#: Unknowns below which PETSc's own factorization is taken on one process.
SMALL = 60_000
#: Unknowns of a solid from which factors are compressed.
COMPRESSED = 60_000
#: Share of a correction that may be wrong by the rounding of new factors in single precision.
ROUNDING = 0.1
#: Options by which a user chooses another solver than that.
CHOICE = {"ksp_type", "pc_type", "pc_precision", "pc_factor_mat_solver_type"}


def direct(
    unknowns: int,
    processes: int,
    saddle_point: bool,
    symmetric: bool = True,
    solid: bool = False,
    single: bool = False,
) -> Options:
    """Options of the direct solver for a tangent.

    One factorization serves a whole run, so that multigrid never wins on a sheet: with 382,000 unknowns a
    correction takes 0.22 s by the kept factors and 1.07 s by kept multigrid, a factorization 4.0 s and 1.1 s.
    PETSc's own Cholesky factors solve three times faster than those of MUMPS (2.5 against 8 ms for 24,000
    unknowns of a sheet) but take longer to compute, and no pivots: it is taken on one process, up to
    :data:`SMALL` unknowns, without a zero block.

    In a solid that would hold for some thousand unknowns only. Its factors may be of single precision, half
    the memory: with 48,916 unknowns they take 1.5 s in place of 2.3 s, and a substitution 32 in place of
    59 ms. From 60,000 on they are compressed to relative errors of 1e-5 (block low-rank), which below takes
    as long as it saves. The number of corrections stays what it was.

    Args:
        unknowns: How many there are, on all processes.
        processes: How many share them.
        saddle_point: Whether the tangent has a zero block.
        symmetric: Whether it is symmetric.
        solid: Whether the body is a solid.
        single: Whether factors of MUMPS are of single precision.
    """
    kind = "cholesky" if symmetric else "lu"
    if processes == 1 and not saddle_point and unknowns < (SMALL // 20 if solid else SMALL):
        return {"ksp_type": "preonly", "pc_type": kind, "pc_factor_mat_ordering_type": "nd"}
    if not PETSc.Sys.hasExternalPackage("mumps"):
        raise InputError(
            "this PETSc has no MUMPS, which the default solver needs for large bodies, pressures and several "
            "processes; choose another solver in [solver.mechanics]",
            "solver.mechanics",
        )
    compressed = (
        {"mat_mumps_icntl_35": 2, "mat_mumps_cntl_7": 1e-5} if solid and unknowns >= COMPRESSED else {}
    )
    return {
        "ksp_type": "preonly",
        "pc_type": kind,
        "pc_factor_mat_solver_type": "mumps",
        "pc_precision": "single" if single else "double",
        "mat_mumps_icntl_14": 60,  # room for pivoting, in percent
        **compressed,
    }


def refine(ksp: PETSc.KSP, b: PETSc.Vec, x: PETSc.Vec, measured: npt.NDArray[np.int32] | slice) -> float:
    """Refine the solution x of Ax = b once, by the same factors (collective).

    Args:
        ksp: The solver.
        b: The right-hand side.
        x: The solution, written in place.
        measured: Owned entries that are measured.

    Returns:
        How much of x, as it was, changed: what rounding and compression of the factors leave of it; or NaN.
    """
    left, change = b.duplicate(), x.duplicate()
    ksp.getOperators()[0].mult(x, left)
    left.aypx(-1.0, b)
    ksp.solve(left, change)
    comm = lasting(x.comm.tompi4py())
    sizes = [largest(np.asarray(vector.array[measured]), comm) for vector in (change, x)]
    x.axpy(1.0, change)
    left.destroy()
    change.destroy()
    return sizes[0] / sizes[1] if sizes[1] else 0.0
