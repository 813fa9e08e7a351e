"""``.manifest``: what runs have written into a result folder, so that nothing else is ever removed."""

from __future__ import annotations

import errno
import os
import re
import shutil
from contextlib import suppress
from pathlib import Path
from stat import S_ISREG

NAME = ".manifest"

#: What a run that was killed may leave before it has claimed anything; neither ours nor in the way.
LEAVINGS = re.compile(r"\.lock|\.manifest|\.writable|\..+\.part")

#: What is written before a file or folder is complete: ours where that one is.
_PART = re.compile(r"\.(.+)\.part")

_HEADER = b"What myostrain wrote into this folder; --force removes nothing else."


def begin(folder: Path) -> None:
    """Start the manifest of a result folder, or take it up again.

    Raises:
        OSError: It cannot be written, or a file of that name is something else.
    """
    handle = os.open(folder / NAME, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, 0o644)
    try:
        found = os.pread(handle, len(_HEADER), 0)
        if not _HEADER.startswith(found):
            raise OSError(errno.EEXIST, f"its {NAME} is none of a run; move it away")
        if found != _HEADER:
            os.pwrite(handle, _HEADER, 0)
    finally:
        os.close(handle)


def claim(path: Path) -> None:
    """Note that a run is going to write ``path``, if that is in a result folder or in a folder of one.

    It comes before the file, so that a run that is killed leaves nothing that no later one may replace.

    Args:
        path: A file, or a folder.

    Raises:
        OSError: The manifest cannot be written.
    """
    for folder in tuple(path.parents)[:2]:
        if not _is_file(folder / NAME):
            continue
        line = b"\n" + os.fsencode(path.relative_to(folder))  # a line cut off by a full disk spoils no other
        handle = os.open(folder / NAME, os.O_WRONLY | os.O_APPEND | os.O_NOFOLLOW)
        try:
            if os.write(handle, line) < len(line):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        finally:
            os.close(handle)
        return


def claimed(folder: Path) -> frozenset[str]:
    """Names, relative to a result folder, of what runs have written into it."""
    if not _is_file(folder / NAME):
        return frozenset()
    header, *names = (folder / NAME).read_bytes().split(b"\n")
    return frozenset(map(os.fsdecode, names)) if header == _HEADER else frozenset()


def make_folder(path: Path) -> None:
    """Make a folder of a result folder, if it is not there."""
    claim(path)
    path.mkdir(exist_ok=True)


def others(folder: Path) -> list[str]:
    """What is in a result folder, by name relative to it, that no run has written."""
    return sorted(_sorted_out(folder)[1])


def clear(folder: Path) -> None:
    """Remove what runs have written into a result folder, and nothing else; links, not what they name."""
    begin(folder)
    for path in (*_sorted_out(folder)[0], folder / NAME):
        if path.suffix == ".part" and path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        elif path.is_dir() and not path.is_symlink():
            with suppress(OSError):  # it is not empty
                path.rmdir()
        else:
            path.unlink(missing_ok=True)


def _sorted_out(folder: Path) -> tuple[list[Path], list[str]]:
    """What runs have written into a result folder, folders after what is in them, and names of all else."""
    names = claimed(folder)
    own: list[Path] = []
    strange: list[str] = []

    def look(place: Path, prefix: str) -> None:
        for entry in os.scandir(place):
            name, path = prefix + entry.name, Path(entry.path)
            part = _PART.fullmatch(entry.name)
            if name not in names and (part is None or prefix + part[1] not in names):
                if prefix or not LEAVINGS.fullmatch(name):
                    strange.append(name)
                continue
            if entry.is_dir(follow_symlinks=False) and path.suffix != ".part":
                if _is_file(path / NAME):  # the rigid twin's result folder
                    inside, beside = _sorted_out(path)
                    own.extend([*inside, path / NAME, path / ".lock"])
                    strange.extend(f"{name}/{other}" for other in beside)
                else:
                    look(path, f"{name}/")
            own.append(path)

    look(folder, "")
    return own, strange


def _is_file(path: Path) -> bool:
    with suppress(OSError):
        return S_ISREG(path.lstat().st_mode)
    return False
