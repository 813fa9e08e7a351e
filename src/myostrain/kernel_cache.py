"""The folder of compiled kernels: made, freed of what a killed compilation left, and kept small."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import platform
import tempfile
import time
from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path
from typing import Any

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
    """Remove object and lock files, and the kernels that were not used the longest if there are too many."""
    for kind in ("*.o", "*.c.lock"):
        for left in folder.glob(kind):
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


def sure_of_the_compiler(find: Callable[..., Any]) -> Callable[..., Any]:
    """FFCx's ``get_cached_module``, sure that a compilation which it waits for goes on.

    Whoever compiles a kernel holds the lock of a file beside its source until it looks for the next one.
    Where there is a source, no library and no lock, the compiler was killed: the source is removed, and this
    process compiles. FFCx alone would wait for it until its time is over.

    Args:
        find: The function, of the kernel's name, the names in it, the folder and the seconds to wait.
    """
    held: list[int] = []  # the lock of the kernel that this process compiles

    @wraps(find)
    def found(module_name: str, object_names: Any, cache_dir: Any, timeout: int) -> Any:
        while held:
            os.close(held.pop())
        source = Path(cache_dir, module_name + ".c")
        done = source.with_suffix(".c.cached")
        if not done.exists():
            with contextlib.suppress(OSError):  # a file system without locks: as FFCx does
                held.append(
                    os.open(source.with_suffix(".c.lock"), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
                )
                if _locked(held[0], done, timeout) and not done.exists():
                    source.unlink(missing_ok=True)
        return find(module_name, object_names, cache_dir, timeout)

    return found


def _locked(handle: int, done: Path, seconds: float) -> bool:
    """Wait for a lock, or for a file that says that it is not needed; whether the lock was taken."""
    end = time.monotonic() + seconds
    while not done.exists() and time.monotonic() < end:
        with contextlib.suppress(BlockingIOError):
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        time.sleep(0.1)
    return False
