"""The result folder: made without overwriting anything, written atomically, by the first process."""

from __future__ import annotations

import contextlib
import errno
import json
import math
import os
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from myostrain.errors import ComputationError, InputError, shown
from myostrain.output import manifest
from myostrain.output.lock import FolderLock


def prepare(path: Path, *, force: bool, comm: Any, resume: bool = False) -> FolderLock | None:
    """Make an empty result folder, or take one up again, and lock it.

    Args:
        path: The folder; it may exist if it is empty.
        force: Whether results of an earlier run in it may be removed. Other files are never touched.
        comm: MPI communicator; the first process works, all learn the outcome.
        resume: Whether an earlier run in it is to go on; nothing is removed then.

    Returns:
        The lock, on the first process.

    Raises:
        InputError: It holds something already, is in use, or cannot be written.
    """
    lock, problem = None, None
    if comm.rank == 0:
        try:
            lock = _prepare(path, force, resume)
        except InputError as error:
            problem = str(error)
        except OSError as error:
            problem = f"--out: the folder {path} cannot be written: {error.strerror or error}"
    problem = comm.bcast(problem, root=0)
    if problem is not None:
        raise InputError(problem)
    return lock


def check_free(path: Path, *, force: bool) -> None:
    """Refuse a result folder that could not be written into, before the work.

    Raises:
        InputError: It cannot be looked at, is a file, or holds something and nothing may be removed.
    """
    check_path(path, "--out")
    if path.exists() and not path.is_dir():
        raise InputError(f"{path} is a file; name another folder", "--out")
    if force or not path.exists():
        return
    try:
        held = sorted(p.name for p in path.iterdir() if not manifest.LEAVINGS.fullmatch(p.name))
    except OSError as error:
        raise InputError(f"{path} cannot be used: {error.strerror}; name another", "--out") from error
    if held:
        goes_on = ", or --resume to go on" if {"checkpoint", "sweep.json"} & set(held) else ""
        raise InputError(
            f"the folder {path} holds something already ({', '.join(held[:3])}, ...); name another, or add "
            f"--force to replace it{goes_on}",
            "--out",
        )


def check_ready(path: Path, *, force: bool) -> None:
    """:func:`check_free`, and that a folder can be made there: for what makes its folder after the work.

    Raises:
        InputError: It is not free, or cannot be written.
    """
    check_free(path, force=force)
    there = next(each for each in (path, *path.absolute().parents) if each.exists())
    try:
        Path(tempfile.mkdtemp(prefix=".myostrain-", dir=there)).rmdir()
    except OSError as error:
        raise InputError(
            f"the folder {path} cannot be written: {error.strerror or error}", "--out"
        ) from error


def _prepare(path: Path, force: bool, resume: bool) -> FolderLock:
    check_free(path, force=True)
    path.mkdir(parents=True, exist_ok=True)
    lock = FolderLock(path)
    try:
        if resume:
            if "failure.json" in manifest.claimed(path):
                discard(path / "failure.json")
        else:
            check_free(path, force=force)
            if strange := manifest.others(path):
                some = ", ".join(strange[:3])
                raise InputError(
                    f"the folder {path} holds what no run has written ({some}), as its {manifest.NAME} says; "
                    "nothing was removed: move that away, or name another folder",
                    "--out",
                )
            manifest.clear(path)
        manifest.begin(path)
        manifest.claim(path / "failure.json")  # now, as a full disk may be what it is about
    except BaseException:
        lock.release()
        raise
    return lock


@contextlib.contextmanager
def results_folder(path: Path, picture: str, *, force: bool, comm: Any) -> Iterator[Path]:
    """Make a result folder with one picture, for what is neither long nor shared by processes.

    The caller writes its files and draws, ``results.json`` last; a failure to write is an
    :class:`InputError` that says so.

    Args:
        path: The folder.
        picture: Name of the picture, without a suffix.
        force: Whether results of an earlier run in it may be removed.
        comm: A communicator of this process alone.

    Yields:
        Where the picture goes.

    Raises:
        InputError: It holds something already, is in use, or cannot be written.
    """
    lock = prepare(path, force=force, comm=comm)
    try:
        with writing(path):
            manifest.make_folder(path / "figures")
            yield path / "figures" / f"{picture}.png"
    finally:
        if lock is not None:
            lock.release()


def check_path(path: Path, key: str) -> None:
    """Refuse a path that cannot be looked at: too long, in a loop of links, in a closed folder.

    Raises:
        InputError: It is one.
    """
    try:
        path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise InputError(f"{shown(str(path))} cannot be used: {why}; name another", key) from error


def free_name(base: Path) -> Path:
    """``base``, or ``base-2``, ``base-3``, ... : the first that does not exist."""
    path, number = base, 1
    while path.exists():
        number += 1
        path = base.with_name(f"{base.name}-{number}")
    return path


def part_of(path: Path) -> Path:
    """Where ``path`` is written before it is complete: ``.NAME.part`` beside it."""
    return path.with_name(f".{path.name}.part")


def discard(path: Path) -> None:
    """Remove a file or a folder if it is there."""
    shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink(missing_ok=True)


def on_first(comm: Any, action: Callable[[], object], path: Path) -> None:
    """Have the first process write ``path``; every process learns of a failure (collective).

    Args:
        comm: MPI communicator, one that lasts.
        action: What the first process calls.
        path: What it writes; an unfinished :func:`part_of` it is removed when that fails.

    Raises:
        ComputationError: The action raised an ``OSError``; on all processes.
    """
    problem = None
    if comm.rank == 0:
        try:
            action()
        except OSError as error:
            with contextlib.suppress(OSError):
                discard(part_of(path))
            full = error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
            remedy = "free space" if full else "make it writable"
            problem = f"{path} cannot be written: {error.strerror or error}", remedy
    problem = comm.bcast(problem, root=0)
    if problem is not None:
        reason, remedy = problem
        raise ComputationError(reason, advice=f"{remedy}, then `myostrain run --resume --out DIR`.")


@contextlib.contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn a failure to write ``path`` into an :class:`InputError` that says so."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror or error}") from error


def write_atomically(path: Path, *contents: Any) -> None:
    """Write a file so that it is there whole or not at all; text in UTF-8, bytes as they are."""
    temporary = part_of(path)
    manifest.claim(path)
    try:
        temporary.unlink(missing_ok=True)  # what a killed run left, and a link is not followed
        with temporary.open("xb") as stream:
            for content in contents:
                stream.write(content.encode() if isinstance(content, str) else content)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(path)
    except OSError:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise


def read_regular(path: Path, limit: int = -1) -> bytes:
    """What a file holds; a device or a pipe, which may never end, is refused.

    Args:
        path: The file.
        limit: Number of bytes to read at most.

    Raises:
        OSError: It cannot be read, or is not a regular file.
    """
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    with os.fdopen(handle, "rb") as stream:
        if not stat.S_ISREG(os.fstat(handle).st_mode):
            raise OSError(errno.EINVAL, "it is not a regular file")
        return stream.read(limit)


def load_results(folder: Path) -> dict[str, Any]:
    """What ``results.json`` of a result folder holds.

    Raises:
        InputError: It cannot be read, or no run has written it.
    """
    path = folder / "results.json"
    try:
        found = json.loads(read_regular(path))
        numbers = [*found["metrics"].values(), *found["seconds"].values(), found["steps"], found["time"]]
        for number in numbers:
            if number is not None:
                float(number)
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        why = getattr(error, "strerror", None) or (
            f"no {error}" if isinstance(error, KeyError) else str(error) or type(error).__name__
        )
        raise InputError(
            f"{path} cannot be read, it is damaged or no run wrote it ({why}); put it back, or remove it and "
            "go on with --resume"
        ) from error
    return dict(found)


def write_json(path: Path, data: Any) -> None:
    """Write JSON atomically; JSON has no infinity, so that one becomes the text "inf"; NaN is refused."""
    write_atomically(path, json.dumps(_finite(data), indent=1, allow_nan=False) + "\n")


def _finite(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _finite(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_finite(value) for value in data]
    return str(data) if isinstance(data, float) and math.isinf(data) else data
