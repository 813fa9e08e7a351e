"""The named cases that ship."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from myostrain.errors import InputError, nearest


def names() -> list[str]:
    """Names of the cases, in alphabetical order."""
    folder = resources.files(__name__)
    return sorted(
        entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml")
    )


def path(name: str) -> Path:
    """The file of a named case.

    Raises:
        InputError: There is no such case.
    """
    if name not in names():
        raise InputError(f"no case is called '{name}'; {nearest(name, names())}", "CASE")
    return Path(str(resources.files(__name__) / f"{name}.toml"))
