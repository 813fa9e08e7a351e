"""A result folder belongs to one run at a time."""

from __future__ import annotations

import contextlib
import datetime as dt
import fcntl
import os
import socket
import weakref
from pathlib import Path

from myostrain.errors import InputError


class FolderLock:
    """The lock of a result folder, given back when it is released or the process ends in whatever way.

    Args:
        folder: The folder, which exists.

    Raises:
        InputError: Another run uses the folder; it is named, with its start.
        OSError: The lock cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / ".lock"
        while True:
            handle = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o644)
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                owner = os.read(handle, 500).decode(errors="replace").strip() or "another process"
                os.close(handle)
                raise InputError(
                    f"the folder {folder} is in use by {owner}; wait for its end, or name another folder",
                    "--out",
                ) from None
            if _is(handle, self._path):
                break
            os.close(handle)  # its owner removed it at this moment
        now = dt.datetime.now(tz=dt.UTC).isoformat(timespec="seconds")
        owner = f"process {os.getpid()} on {socket.gethostname()} since {now}\n"
        with contextlib.suppress(OSError):  # a full disk: the lock holds all the same
            os.ftruncate(handle, 0)
            os.write(handle, owner.encode())
        self.release = weakref.finalize(self, _release, handle, self._path)


def _is(handle: int, path: Path) -> bool:
    """Whether an open file is the one that a path names."""
    with contextlib.suppress(FileNotFoundError):
        return os.path.samestat(os.fstat(handle), path.stat())
    return False


def _release(handle: int, path: Path) -> None:
    with contextlib.suppress(OSError):
        path.unlink()
    os.close(handle)
