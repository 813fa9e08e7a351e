"""The folder of compiled kernels: made, and freed of what a killed compilation left."""

from __future__ import annotations

import contextlib
import fcntl
import os
import tempfile
from pathlib import Path

from myostrain.errors import InputError

#: Its lock, which every process that may compile shares as long as it lives.
LOCK = ".in-use"


def claim_cache(folder: Path) -> None:
    """Make the folder of compiled kernels ready for this process.

    FFCx takes a C file without a finished library for a compilation that goes on, and waits for it. When a
    compilation was killed that would be for ever: such files are removed if no other process uses the folder.

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
    with contextlib.suppress(OSError):
        fcntl.flock(handle, fcntl.LOCK_SH)  # until the process ends
