"""Faster products of matrices, for factorizations by the PETSc of DOLFINx's PyPI wheel.

MUMPS asks OpenBLAS for a product in one triangle (``dgemmt``, ``sgemmt``), which does so column by column,
at a tenth of the speed of its other products: it was 60 % of a symmetric factorization of a solid. ``blas.c``
has it by blocks, on top of the same OpenBLAS. MUMPS substitutes one right-hand side by products and solutions
of matrices with one column; ``blas.c`` hands them on to the functions for a vector, which saves a fifth.
It is compiled once, and put where the dynamic linker finds it before OpenBLAS's own; nothing happens where
there is no compiler, no wheel, or where PETSc was loaded already.
"""

from __future__ import annotations

import ctypes
import hashlib
import importlib
import os
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(__file__).with_name("blas.c")
FLAGS = ("-O2", "-fPIC", "-shared")


def compiled(folder: Path) -> Path | None:
    """The library, compiled into a folder if it is not there; None where that fails."""
    if os.environ.get("MYOSTRAIN_NO_COMPILER") == "1":
        return None
    command = shlex.split(os.environ.get("CC") or "cc")
    key = hashlib.sha256("\0".join([SOURCE.read_text(), *command, *FLAGS]).encode()).hexdigest()[:20]
    path = folder / f"blas_{key}.so"
    try:
        if not path.exists():
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(dir=folder, prefix=".blas-") as work:
                made = Path(work) / path.name
                subprocess.run([*command, *FLAGS, "-o", made, SOURCE], check=True, capture_output=True)
                made.replace(path)  # atomic: other processes see all of it or nothing
    except (OSError, subprocess.CalledProcessError):
        return None
    return path


def based_on(path: Path, openblas: Path) -> ctypes.CDLL:
    """The library at a path, with the products of an OpenBLAS beneath it."""
    library, below = ctypes.CDLL(str(path)), ctypes.CDLL(str(openblas))
    for kind in "ds":
        names = [f"{kind}{name}_" for name in ("gemm", "gemv", "trsm", "trsv")]
        library[f"set_{kind}"](*(ctypes.cast(below[name], ctypes.c_void_p) for name in names))
    return library


def wheel() -> Path | None:
    """OpenBLAS of the wheel; None where DOLFINx is another one."""
    try:
        found = importlib.import_module("dolfinx_solver").__file__
    except ModuleNotFoundError:
        return None
    openblas = Path(found or "").parent / "lib" / "libopenblas.so.0"
    return openblas if openblas.exists() else None


def hasten(folder: Path) -> bool:
    """Put these functions before those of OpenBLAS, for libraries that are loaded later.

    Args:
        folder: Where compiled libraries are kept.

    Returns:
        Whether they are there.
    """
    if "petsc4py.PETSc" in sys.modules:
        return False
    openblas = wheel()
    path = None if openblas is None else compiled(folder)
    if openblas is None or path is None:
        return False
    try:
        based_on(path, openblas)
        ctypes.CDLL(str(path), mode=ctypes.RTLD_GLOBAL)
    except (OSError, AttributeError):
        return False
    return True
