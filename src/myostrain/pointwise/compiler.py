"""The C compiler: libraries of pointwise formulas, compiled on first use and kept in the user's cache."""

from __future__ import annotations

import ctypes
import hashlib
import logging
import os
import shlex
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from myostrain.engine import MPI, cache_folder

log = logging.getLogger("myostrain")

FLAGS = (
    *("-std=gnu11", "-O3", "-march=native", "-fPIC", "-shared", "-fopenmp-simd", "-ffp-contract=fast"),
    # NaN and Inf keep their meaning, and sums their order: the same numbers on any vector width.
    *("-fno-math-errno", "-fno-trapping-math"),
)

#: Set to 1 to do without a compiler, as on a machine that has none.
SWITCH = "MYOSTRAIN_NO_COMPILER"


@cache
def compiler() -> str | None:
    """The command of the C compiler, CC or cc, gcc, clang; None where there is none, which is said once."""
    if os.environ.get(SWITCH) == "1":
        return None
    wanted = os.environ.get("CC")
    for command in [wanted] if wanted else ["cc", "gcc", "clang"]:
        if shutil.which(shlex.split(command)[0]):
            return command
    log.warning("no C compiler was found: ionic models run in NumPy, some ten times slower")
    return None


def library(source: str, comm: Any = MPI.COMM_SELF) -> ctypes.CDLL | None:
    """Compile C, or take it from the cache.

    Args:
        source: The source text.
        comm: Processes that need it (collective): the first one compiles.

    Returns:
        The library, None where it cannot be compiled.
    """
    path = _compiled(source) if comm.rank == 0 else None
    path = comm.bcast(path, root=0)
    return None if path is None else _loaded(path)


@cache
def _loaded(path: str) -> ctypes.CDLL:
    return ctypes.CDLL(path)


def _compiled(source: str) -> str | None:
    command = compiler()
    if command is None:
        return None
    key = hashlib.sha256("\0".join([source, command, *FLAGS]).encode()).hexdigest()[:20]
    folder = cache_folder()
    path = folder / f"pointwise_{key}.so"
    if path.exists():
        return str(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # The source stays beside it, for who wants to read what runs.
        with tempfile.TemporaryDirectory(dir=folder, prefix=".pointwise-") as work:
            text, made = Path(work) / f"pointwise_{key}.c", Path(work) / path.name
            text.write_text(source, encoding="utf-8")
            arguments = [*shlex.split(command), *FLAGS, "-o", str(made), str(text), "-lm"]
            subprocess.run(arguments, check=True, capture_output=True, text=True)
            text.replace(folder / text.name)
            made.replace(path)  # atomic: others see all of it or nothing
    except (OSError, subprocess.CalledProcessError) as error:
        said = getattr(error, "stderr", "") or str(error)
        log.warning(
            "the C compiler (%s) failed, ionic models run in NumPy, some ten times slower: %s",
            command,
            said.strip().splitlines()[-1] if said.strip() else error,
        )
        return None
    return str(path)
