"""Files that others wrote: looked at before they are opened, and read first in a process of their own."""

from __future__ import annotations

import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

from myostrain.errors import InputError

#: Seconds that a reader has for any file, beside one for each megabyte.
PATIENCE = 30.0


def readable(path: Path, key: str) -> None:
    """Refuse a path that is not a readable, non-empty, regular file.

    Args:
        path: The file.
        key: Key of a case file that names it, for messages.

    Raises:
        InputError: It is not; of a pipe or a device nothing is read.
    """
    try:
        problem = _problem(path.stat())
        if problem is None:
            with path.open("rb") as stream:
                stream.read(1)
    except (FileNotFoundError, NotADirectoryError):
        problem = "there is no file {}"
    except OSError as error:
        problem = f"the file {{}} cannot be read: {error.strerror}"
    except ValueError as error:  # a zero byte in the name
        problem = f"{{!r}} is not a name of a file: {error}"
    if problem is not None:
        raise InputError(problem.format(str(path)), key)


def _problem(status: os.stat_result) -> str | None:
    """What is wrong with a path of this status."""
    if not stat.S_ISREG(status.st_mode):
        what = "a folder" if stat.S_ISDIR(status.st_mode) else "a pipe, a socket or a device"
        return f"there is no file {{}}: it is {what}"
    return "the file {} is empty" if status.st_size == 0 else None


def read_alone(
    script: str, *arguments: str, given: bytes = b"", path: Path, key: str, reader: str
) -> tuple[int, bytes, str]:
    """Run a Python script that reads a file, in a process that a damaged file may kill or hold up.

    Args:
        script: The script.
        arguments: Its arguments.
        given: Its standard input.
        path: The file that it reads, for messages and for the time it is given: 30 s and 1 s a megabyte.
        key: Key of a case file that names it, for messages.
        reader: What reads it there, for messages.

    Returns:
        Exit status, standard output, and what it wrote to standard error.

    Raises:
        InputError: The process died of a signal or came to no end.
        OSError: No process can be started.
    """
    # An h5py that is built with MPI must not join the run's processes.
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PMI", "OMPI_", "MPI_"))}
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-c", script, *arguments],
            input=given,
            capture_output=True,
            timeout=PATIENCE + path.stat().st_size / 1e6,
            env=environment,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise InputError(
            f"{path} is damaged: {reader} never finishes reading it; write it again", key
        ) from None
    if done.returncode < 0:
        try:
            name = signal.Signals(-done.returncode).name
        except ValueError:
            name = f"signal {-done.returncode}"
        raise InputError(f"{path} is damaged: {reader} dies of it ({name}); write it again", key)
    return done.returncode, done.stdout, done.stderr.decode(errors="replace")
