"""The result folder: made without overwriting anything, written atomically."""

from __future__ import annotations

import json
import math
import os
import shutil
from pathlib import Path
from typing import Any

from myostrain.errors import InputError

#: What a run writes, and so all that ``force`` may remove.
OWN = (
    "case.toml",
    "results.json",
    "failure.json",
    "probes.csv",
    "fields.bp",
    "snapshots.h5",
    "figures",
    "rigid",
    ".case.toml.part",
    ".results.json.part",
    ".failure.json.part",
    ".writable",
)

#: What a run draws.
FIGURES = (
    *(f"{name}.png" for name in ("potential", "evolution", "space-time", "stress", "activation", "probes")),
    "animation.gif",
)


def prepare(path: Path, *, force: bool, comm: Any) -> Path:
    """Make an empty result folder.

    Args:
        path: The folder; it may exist if it is empty.
        force: Whether results of an earlier run in it may be removed. Other files are never touched.
        comm: MPI communicator; the first process works, all learn the outcome.

    Raises:
        InputError: It holds something already, or cannot be written.
    """
    problem = _prepare(path, force) if comm.rank == 0 else None
    problem = comm.bcast(problem, root=0)
    if problem is not None:
        raise InputError(problem, "--out")
    return path


def _prepare(path: Path, force: bool) -> str | None:
    try:
        if path.exists() and not path.is_dir():
            return f"{path} is a file; name another folder"
        held = sorted(p.name for p in path.iterdir()) if path.exists() else []
        if held and not force:
            some = ", ".join(held[:3])
            return f"the folder {path} holds something already ({some}, ...); name another, or add --force"
        strange = [name for name in held if name not in OWN] + _foreign(path)
        if strange:
            some = ", ".join(strange[:3])
            return f"the folder {path} holds what no run has written ({some}); name another folder"
        path.mkdir(parents=True, exist_ok=True)
        for name in held:
            old = path / name
            shutil.rmtree(old) if old.is_dir() and not old.is_symlink() else old.unlink()
        probe = path / ".writable"
        probe.touch()
        probe.unlink()
    except OSError as error:
        return f"the folder {path} cannot be written: {error.strerror or error}"
    return None


def _foreign(path: Path) -> list[str]:
    """Files in the folders of a run that no run has written."""
    pictures = path / "figures"
    found = (
        [f"figures/{p.name}" for p in pictures.iterdir() if p.name not in FIGURES]
        if pictures.is_dir()
        else []
    )
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


def write_atomically(path: Path, text: str) -> None:
    """Write a file so that it is there whole or not at all."""
    temporary = path.with_name(f".{path.name}.part")
    with temporary.open("w", encoding="utf-8") as stream:
        stream.write(text)
        stream.flush()
        os.fsync(stream.fileno())
    temporary.replace(path)


def write_json(path: Path, data: Any) -> None:
    """Write JSON atomically; JSON has no infinity, so that one becomes the text "inf"; NaN is refused."""
    write_atomically(path, json.dumps(_finite(data), indent=1, allow_nan=False) + "\n")


def _finite(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _finite(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_finite(value) for value in data]
    return str(data) if isinstance(data, float) and math.isinf(data) else data
