"""A result folder belongs to one run at a time."""

from __future__ import annotations

import contextlib
import datetime as dt
import errno
import fcntl
import os
import socket
import stat
import weakref
from pathlib import Path

from myostrain.errors import InputError

#: How a lock begins; one that nobody has written yet is empty.
_BEGIN = b"process "


class FolderLock:
    """The lock of a result folder, given back when it is released or the process ends in whatever way.

    Args:
        folder: The folder, which exists.

    Raises:
        InputError: Another run uses the folder; it is named, with its start. Or what is called ``.lock``
            there is no lock of a run.
        OSError: The lock cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / ".lock"
        while True:
            handle = _opened(self._path)
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
        if not _BEGIN.startswith(os.pread(handle, len(_BEGIN), 0)):
            os.close(handle)
            raise _foreign(self._path)
        now = dt.datetime.now(tz=dt.UTC).isoformat(timespec="seconds")
        owner = f"{_BEGIN.decode()}{os.getpid()} on {socket.gethostname()} since {now}\n"
        with contextlib.suppress(OSError):  # a full disk: the lock holds all the same
            os.ftruncate(handle, 0)
            os.pwrite(handle, owner.encode(), 0)
        self.release = weakref.finalize(self, _release, handle, self._path)


def _opened(path: Path) -> int:
    """The lock, opened; a link, a pipe or a device of that name is left alone."""
    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, 0o644)
    except OSError as error:
        if error.errno in (errno.ELOOP, errno.EISDIR, errno.ENXIO):
            raise _foreign(path) from error
        raise
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise _foreign(path)
    return handle


def _foreign(path: Path) -> InputError:
    return InputError(f"{path} is not a lock of a run; move it away, or name another folder", "--out")


def _is(handle: int, path: Path) -> bool:
    """Whether an open file is the one that a path names."""
    with contextlib.suppress(FileNotFoundError):
        return os.path.samestat(os.fstat(handle), path.stat())
    return False


def _release(handle: int, path: Path) -> None:
    with contextlib.suppress(OSError):
        path.unlink()
    os.close(handle)
