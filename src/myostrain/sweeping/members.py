"""The runs of a sweep: which there are, and what each of them is to run."""

from __future__ import annotations

import copy
import itertools
import json
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from myostrain import cases
from myostrain.case.case import Case
from myostrain.case.overrides import override
from myostrain.errors import InputError, shown
from myostrain.output.folder import read_regular
from myostrain.run.resume import differences, said

import numpy as np

#: Runs of one sweep at most: more is a slip.
MOST = 100_000


@dataclass(frozen=True)
class Member:
    """One run of a sweep.

    Args:
        name: Its number, "001", as its folder is called.
        values: Values of the swept keys.
        case: The case with them.
    """

    name: str
    values: Mapping[str, Any]
    case: Case

    @property
    def said(self) -> str:
        """The values in words."""
        return ", ".join(f"{key} = {as_text(value)}" for key, value in self.values.items())


@dataclass(frozen=True)
class Plan:
    """What a sweep is to run.

    Args:
        axes: Values by swept key.
        grid: Whether every value of a key meets all values of the others; else they go side by side.
        members: The runs.
    """

    axes: Mapping[str, Sequence[Any]]
    grid: bool
    members: tuple[Member, ...]

    def as_json(self) -> dict[str, Any]:
        """What ``sweep.json`` holds: all that it takes to go on."""
        runs = [
            {"run": m.name, "values": dict(m.values), "name": m.case.name, "case": m.case.to_toml()}
            for m in self.members
        ]
        return {
            "keys": {key: list(values) for key, values in self.axes.items()},
            "grid": self.grid,
            "runs": runs,
        }


def plan(case: str | Path | Case, values: Mapping[str, Any], *, grid: bool = True) -> Plan:
    """The runs of a sweep, each checked.

    Args:
        case: A named case, a case file, or a case.
        values: By dotted key a list of values to sweep over, or one value, which all runs have.
        grid: Whether every value of a key meets all values of the others; else the first values of all keys
            make the first run, the second ones the second, and so on.

    Raises:
        InputError: A run's case is not allowed, or there is nothing to sweep over.
    """
    given = {key: _listed(value) for key, value in values.items()}
    axes = {key: value for key, value in given.items() if isinstance(value, list)}
    fixed = {key: value for key, value in given.items() if not isinstance(value, list)}
    if not axes:
        raise InputError(
            "give a list of values for one key at least: activation.beta=[0.0, 0.1, 0.2]", "--set"
        )
    for key, several in axes.items():
        if not several:
            raise InputError("give a value at least", f"--set {key}")
        if grid and any(several.count(value) > 1 for value in several):
            raise InputError("a value is there twice", f"--set {key}")
    counts = {key: len(several) for key, several in axes.items()}
    if not grid and len(set(counts.values())) > 1:
        lengths = ", ".join(f"{key} has {count}" for key, count in counts.items())
        raise InputError(f"all keys need the same number of values: {lengths}", "--list")
    total = int(np.prod(list(counts.values()), dtype=float)) if grid else next(iter(counts.values()))
    if total > MOST:
        raise InputError(f"these are {total} runs; {MOST} are allowed", "--set")
    combined: Iterable[tuple[Any, ...]] = (
        itertools.product(*axes.values()) if grid else zip(*axes.values(), strict=True)
    )
    width = max(3, len(str(total)))
    members = []
    for number, combination in enumerate(combined, start=1):
        own = dict(zip(axes, combination, strict=True))
        members.append(Member(f"{number:0{width}}", own, _made(case, {**fixed, **own}, axes)))
    return Plan(axes, grid, tuple(members))


def _listed(value: Any) -> Any:
    """Values that are to be swept over as a list; numbers of NumPy as plain ones."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | range):
        return [_plain(each) for each in value]
    return _plain(value)


def _plain(value: Any) -> Any:
    """A value as TOML and JSON can hold it."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: _plain(each) for key, each in value.items()}
    return [_plain(each) for each in value] if isinstance(value, tuple | list) else value


def _made(case: str | Path | Case, values: Mapping[str, Any], axes: Mapping[str, Sequence[Any]]) -> Case:
    """A case with values; where a swept list is what one run wants as its value, the message says so."""
    try:
        return _with(case, values)
    except InputError as error:
        key = error.key or ""
        hit = next((k for k in axes if key == k or key.startswith(f"{k}.")), None)
        if hit is None:
            raise
        try:
            _with(case, {**values, hit: list(axes[hit])})
        except InputError:
            raise error from None
        raise InputError(
            f"{str(error).removeprefix(f'{key}: ')}. A list holds the values of the runs; a value that is a "
            f"list itself goes into a list of its own: {hit}=[[...], [...]]",
            key,
        ) from error


def _with(case: str | Path | Case, values: Mapping[str, Any]) -> Case:
    pairs = [(key, copy.deepcopy(value)) for key, value in values.items()]
    if isinstance(case, Case):
        data = json.loads(json.dumps(case.parameters))
        override(data, pairs)
        return Case.from_dict(data, name=case.name)
    text = str(case)
    named = not (isinstance(case, Path) or text.endswith(".toml") or "/" in text)
    return Case.from_file(cases.path(text) if named else Path(text), pairs)


def read_plan(path: Path) -> Plan:
    """The runs of a sweep that has begun, from ``sweep.json``.

    Raises:
        InputError: It cannot be read.
    """
    try:
        found = json.loads(read_regular(path))
        members = tuple(
            Member(run["run"], run["values"], Case.from_dict(tomllib.loads(run["case"]), name=run["name"]))
            for run in found["runs"]
        )
        return Plan(dict(found["keys"]), bool(found["grid"]), members)
    except InputError:
        raise
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise InputError(
            f"{path} cannot be read, it is damaged or no sweep wrote it ({error}); sweep into another folder",
            "--resume",
        ) from error


def check_same(before: Plan, now: Plan, folder: Path) -> None:
    """Refuse to go on with another sweep than that in a folder.

    Raises:
        InputError: The values or the case are others.
    """
    if [dict(m.values) for m in before.members] != [dict(m.values) for m in now.members]:
        keys = ", ".join(f"{key} = {shown(list(values))}" for key, values in before.axes.items())
        raise InputError(
            f"{folder} holds a sweep over other values ({keys}); leave CASE and --set out to go on with it, "
            "or name another folder",
            "--resume",
        )
    for old, new in zip(before.members, now.members, strict=True):
        if found := differences(old.case.parameters, json.loads(json.dumps(new.case.parameters))):
            raise InputError(
                f"{folder} holds a sweep of another case ({said(found)}); leave CASE and --set out to go on "
                "with it, or name another folder",
                "--resume",
            )


def as_text(value: Any) -> str:
    """A value for a table: numbers and texts as they are, all else as JSON."""
    if isinstance(value, float):
        return f"{value:.10g}"
    return value if isinstance(value, str) else json.dumps(value)
