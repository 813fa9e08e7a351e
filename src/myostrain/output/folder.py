"""The result folder: made without overwriting anything, written atomically, by the first process."""

from __future__ import annotations

import contextlib
import errno
import json
import math
import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from myostrain.errors import ComputationError, InputError
from myostrain.output.lock import FolderLock

#: What a run writes, and so all that ``force`` may remove.
OWN = (
    "case.toml",
    "results.json",
    "failure.json",
    "probes.csv",
    "measures.csv",
    "lines.csv",
    "fields.bp",
    "snapshots",
    "figures",
    "rigid",
    "checkpoint",
    "run.log",
    ".lock",
    ".case.toml.part",
    ".results.json.part",
    ".failure.json.part",
    ".fields.bp.part",
    ".writable",
)

#: What a run draws.
FIGURES = (
    *(f"{name}.png" for name in ("potential", "evolution", "space-time", "displacement", "stress")),
    *(f"{name}.png" for name in ("activation", "fibres", "land", "probes")),
    "animation.gif",
)

#: Names of the files in ``snapshots``.
SNAPSHOTS = re.compile(r"(mesh|activation|frame-\d+)\.npz|\.(mesh|activation|frame-\d+)\.npz\.part")


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


def _prepare(path: Path, force: bool, resume: bool) -> FolderLock:
    if path.exists() and not path.is_dir():
        raise InputError(f"{path} is a file; name another folder", "--out")
    path.mkdir(parents=True, exist_ok=True)
    lock = FolderLock(path)
    try:
        held = sorted(p.name for p in path.iterdir() if p.name != ".lock")
        if resume:
            discard(path / "failure.json")
        elif held and not force:
            some = ", ".join(held[:3])
            raise InputError(
                f"the folder {path} holds something already ({some}, ...); name another, add --force to "
                "replace it, or --resume to go on",
                "--out",
            )
        else:
            strange = [name for name in held if name not in OWN] + _foreign(path)
            if strange:
                some = ", ".join(strange[:3])
                raise InputError(
                    f"the folder {path} holds what no run has written ({some}); name another folder", "--out"
                )
            for name in held:
                discard(path / name)
        probe = path / ".writable"
        probe.touch()
        probe.unlink()
    except BaseException:
        lock.release()
        raise
    return lock


def _foreign(path: Path) -> list[str]:
    """Files in the folders of a run that no run has written."""
    pictures = path / "figures"
    found = (
        [f"figures/{p.name}" for p in pictures.iterdir() if p.name not in FIGURES]
        if pictures.is_dir()
        else []
    )
    frames = path / "snapshots"
    if frames.is_dir():
        found += [f"snapshots/{p.name}" for p in frames.iterdir() if not SNAPSHOTS.fullmatch(p.name)]
    saved = path / "checkpoint"
    if saved.is_dir():
        found += [f"checkpoint/{p.name}" for p in saved.iterdir() if ".ckpt" not in p.suffixes]
    twin = path / "rigid"
    if twin.is_dir():
        found += [f"rigid/{p.name}" for p in twin.iterdir() if p.name not in OWN]
    return found


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


def write_atomically(path: Path, *contents: Any) -> None:
    """Write a file so that it is there whole or not at all; text in UTF-8, bytes as they are."""
    temporary = part_of(path)
    try:
        with temporary.open("wb") as stream:
            for content in contents:
                stream.write(content.encode() if isinstance(content, str) else content)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(path)
    except OSError:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise


def write_json(path: Path, data: Any) -> None:
    """Write JSON atomically; JSON has no infinity, so that one becomes the text "inf"; NaN is refused."""
    write_atomically(path, json.dumps(_finite(data), indent=1, allow_nan=False) + "\n")


def _finite(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _finite(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_finite(value) for value in data]
    return str(data) if isinstance(data, float) and math.isinf(data) else data
