"""The one place where DOLFINx, PETSc and MPI are imported and their kernels' compiler is set up.

What the wheel ``dolfinx-solver-real`` needs to be imported in any order is in ``myostrain_engine_first.py``.
"""

from __future__ import annotations

import importlib.metadata
import os
import platform
from functools import cache
from typing import Any

from myostrain import blas
from myostrain.kernel_cache import cache_folder, claim_cache, cpu_key, sure_of_the_compiler

# PETSc would end the process at SIGTERM before a run can write a checkpoint.
os.environ["PETSC_OPTIONS"] = f"{os.environ.get('PETSC_OPTIONS', '')} -no_signal_handler".strip()
# With more processes than cores, MPICH's busy waiting would take the time of those that compute.
if int(os.environ.get("MPI_LOCALNRANKS", "1")) > (os.cpu_count() or 1):
    os.environ.setdefault("MPIR_CVAR_ENABLE_HEAVY_YIELD", "1")

try:
    blas.hasten(cache_folder())
    import dolfinx
except ModuleNotFoundError as missing:
    raise ModuleNotFoundError(
        "myostrain needs DOLFINx 0.11 with PETSc. Install it with `pip install 'myostrain[engine]'`, "
        "or use a DOLFINx from conda-forge, Debian or a container in the same environment."
    ) from missing

import numpy as np
import ufl
from dolfinx import fem
from ffcx.codegeneration import jit
from mpi4py import MPI
from petsc4py import PETSc

if not dolfinx.has_petsc4py:
    raise ImportError("this DOLFINx was built without petsc4py, which myostrain needs for its solvers")
if np.dtype(PETSc.ScalarType) != np.float64:
    raise ImportError("myostrain needs a PETSc with real 64-bit numbers; this one has another scalar type")

# Options that a solver has no use for are checked when it is made, not complained about at exit.
PETSc.Options().setValue("options_left", False)

__all__ = ["MPI", "PETSc", "cache_folder", "compile_form", "cpu_key", "jit_options", "lasting", "versions"]

# As -ffast-math, but NaN and Inf keep their meaning (a diverging run must show) and linking sets no
# process-wide flag.
NATIVE_FLAGS = [
    "-O3",
    "-march=native",
    "-g0",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fno-signed-zeros",
    "-fassociative-math",
    "-freciprocal-math",
]


def lasting(comm: Any) -> Any:
    """A communicator over the same processes that is never freed, where there is one.

    A mesh's own communicator goes away with the mesh, and mpi4py may then wait for ever if a pickling
    collective (``allreduce``, ``bcast``, ...) was used on it and bodies are freed while an exception
    propagates.
    """
    for known in (MPI.COMM_WORLD, MPI.COMM_SELF):
        if MPI.Comm.Compare(comm, known) in (MPI.IDENT, MPI.CONGRUENT):
            return known
    return comm


@cache
def _jit_options() -> dict[str, Any]:
    folder = cache_folder()
    claim_cache(folder)
    if hasattr(jit, "get_cached_module"):
        jit.get_cached_module = sure_of_the_compiler(jit.get_cached_module)
    return {
        "cffi_extra_compile_args": NATIVE_FLAGS,
        "cache_dir": str(folder),
        # Another process may be compiling the same form; large ones take a while.
        "timeout": 300,
    }


def jit_options() -> dict[str, Any]:
    """Options of the kernel compiler (a fresh copy): native flags, and a cache folder of this processor.

    Raises:
        InputError: The cache folder cannot be written.
    """
    return dict(_jit_options())


def compile_form(form: ufl.Form) -> fem.Form:
    """Compile a UFL form with the machine's own flags (cached on disk)."""
    return fem.form(form, jit_options=jit_options())


def versions() -> dict[str, str]:
    """Versions of what computes: myostrain, DOLFINx, PETSc, MPI, Python, NumPy."""
    try:
        own = importlib.metadata.version("myostrain")
    except importlib.metadata.PackageNotFoundError:
        own = "unknown"
    return {
        "myostrain": own,
        "dolfinx": dolfinx.__version__,
        "petsc": ".".join(str(n) for n in PETSc.Sys.getVersion()),
        "mpi": MPI.Get_library_version().splitlines()[0].replace("\t", " ").strip(),
        "numpy": np.__version__,
        "python": platform.python_version(),
    }
