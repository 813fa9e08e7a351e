"""The folder of compiled kernels: made, freed of what a killed compilation left, and kept small."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import platform
import tempfile
from functools import cache
from pathlib import Path

from myostrain.errors import InputError

#: Its lock, which every process that may compile shares as long as it lives.
LOCK = ".in-use"

#: So many kernels are kept. FFCx lists the folder for every kernel that it loads: 10 ms with 5,000 of them.
KEPT = 3000


@cache
def cpu_key() -> str:
    """A short key of this processor: another one that shares the home folder makes its own kernels."""
    description = platform.machine() + platform.processor()
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith(("flags", "Features", "model name")):
                description += line
            if not line.strip():
                break
    return hashlib.sha256(description.encode()).hexdigest()[:12]


def cache_folder() -> Path:
    """Where compiled kernels are kept."""
    root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return root / "myostrain" / f"kernels-{cpu_key()}"


def claim_cache(folder: Path) -> None:
    """Make the folder of compiled kernels ready for this process.

    FFCx takes a C file without a finished library for a compilation that goes on, and waits for it. When a
    compilation was killed that would be for ever: such files are removed if no other process uses the folder.
    So are object files, and where kernels are a third more than :data:`KEPT`, the least recently used ones.

    Args:
        folder: The folder.

    Raises:
        InputError: It cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
        handle = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    except OSError as error:
        raise InputError(
            f"the folder of compiled kernels {folder} cannot be written ({error.strerror or error}): set "
            "XDG_CACHE_HOME to a folder of yours"
        ) from error
    with contextlib.suppress(OSError):  # others are at work, or a file system without locks
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        for source in folder.glob("libffcx_*.c"):
            if not source.with_suffix(".c.cached").exists():
                source.unlink(missing_ok=True)
        for kind in ("cached", "failed"):  # marks whose source somebody removed would fail the next one
            for mark in folder.glob(f"libffcx_*.c.{kind}"):
                if not mark.with_suffix("").exists():
                    mark.unlink(missing_ok=True)
        _prune(folder)
    with contextlib.suppress(OSError):
        fcntl.flock(handle, fcntl.LOCK_SH)  # until the process ends


def _prune(folder: Path) -> None:
    """Remove object files, and the kernels that were not used the longest where there are too many."""
    for left in folder.glob("*.o"):
        left.unlink(missing_ok=True)
    libraries = list(folder.glob("*.so"))
    if len(libraries) <= KEPT * 4 // 3:
        return
    # The access time is kept by the day at best, on some file systems not at all.
    used = {library: max(library.stat().st_atime, library.stat().st_mtime) for library in libraries}
    for library in sorted(libraries, key=used.__getitem__)[:-KEPT]:
        stem = library.name.partition(".")[0]
        for ending in (".c.cached", ".c"):  # the mark first: without it the rest is a killed compilation
            library.with_name(stem + ending).unlink(missing_ok=True)
        library.unlink(missing_ok=True)
