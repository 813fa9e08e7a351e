"""Tiny cases, and the command line called in this process, for tests of everything around the model."""

import contextlib
import copy
import io
import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

from myostrain import cli
from myostrain.engine import MPI

import tomlkit

#: A line of 20 cells, 10 steps; every section is there.
LINE: dict[str, Any] = {
    "geometry": {"kind": "line", "length": 20.0, "spacing": 1.0},
    "cell": {"model": "FitzHughNagumo", "alpha": 0.1, "tau": 0.2, "A": 100.0, "recovery": True},
    "potential": {"diffusivity": 100.0, "balance": "conservative"},
    "initial": {"potential": 0.9, "center": [0.0], "radius": 5.0},
    "activation": {"law": "proportional", "beta": 0.3, "deformation": "fibre"},
    "material": {"model": "Spring", "mu": 1.0},
    "mechanics": {"kinematics": "line", "fixed": ["left"], "every": 1},
    "time": {"step": 1e-3, "end": 1e-2, "scheme": "second-order"},
    "probes": {"a": [6.0], "b": [8.0]},
    "output": {"every": 2e-3},
}

#: A sheet of 96 triangles, 10 steps.
SHEET: dict[str, Any] = {
    **LINE,
    "geometry": {"kind": "ellipse", "size": [20.0, 24.0], "spacing": 2.75, "distortion": 0.1},
    "fibres": {"direction": [1.0, -1.0]},
    "initial": {"potential": 0.9, "center": [10.0, 12.0], "radius": 5.0},
    "material": {"model": "NeoHookean", "mu": 1.0},
    "mechanics": {"kinematics": "plane-stress", "constraint": "total", "robin": 1.0, "every": 1},
    "probes": {"a": [10.0, 12.0], "b": [10.0, 5.0]},
}

#: A slab of 60 tetrahedra, 6 steps.
SOLID: dict[str, Any] = {
    **LINE,
    "geometry": {"kind": "slab", "size": [5.0, 2.0, 1.0], "spacing": 1.0},
    "fibres": {"direction": [1.0, 0.0, 0.0]},
    "initial": {"potential": 0.9, "center": [0.0, 0.0, 0.0], "radius": 2.0},
    "material": {"model": "NeoHookean", "mu": 1.0},
    "mechanics": {"kinematics": "solid", "constraint": "total", "fixed": ["left"], "every": 2},
    "time": {"step": 5e-3, "end": 3e-2, "scheme": "second-order"},
    "probes": {"a": [2.0, 1.0, 0.5], "b": [4.0, 1.0, 0.5]},
    "output": {"every": 1e-2},
}

#: The same slab without a potential to solve for: loaded and activated over time, 4 steps.
STATIC: dict[str, Any] = {
    **{key: SOLID[key] for key in ("geometry", "fibres", "material", "probes")},
    "drive": {"potential": [[0.0, 0.0], [1.0, 1.0]]},
    "activation": {"law": "active-stress", "tension": 0.3},
    "mechanics": {
        "kinematics": "solid",
        "fixed": ["left"],
        "pressure": {"bottom": [[0.0, 0.0], [1.0, 0.02]]},
    },
    "time": {"step": 0.25, "end": 1.0},
    "output": {"every": 0.5},
}

#: This process alone, whatever mpiexec started.
ALONE = MPI.COMM_SELF

#: In place of a value: the key is removed.
REMOVED = object()


def changed(case: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """A deep copy of a case with dotted keys set, or removed where the value is :data:`REMOVED`."""
    made = copy.deepcopy(case)
    for key, value in changes.items():
        *sections, last = key.split(".")
        at = made
        for section in sections:
            at = at.setdefault(section, {})
        if value is REMOVED:
            del at[last]
        else:
            at[last] = value
    return made


def write_case(path: Path, case: dict[str, Any]) -> Path:
    """Write a case file."""
    path.write_text(tomlkit.dumps(case), encoding="utf-8")
    return path


def strict_json(text: str) -> Any:
    """JSON as its standard has it: no NaN, no Infinity."""

    def refuse(word: str) -> None:
        raise AssertionError(word)

    return json.loads(text, parse_constant=refuse)


@dataclass(frozen=True)
class Outcome:
    """What a command did: exit status and the two streams."""

    status: int
    out: str
    err: str


def command_line(*arguments: Any) -> Outcome:
    """Call the command line in this process."""
    out, err, status = io.StringIO(), io.StringIO(), 0
    with (
        mock.patch.object(sys, "argv", ["myostrain", *map(str, arguments)]),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            cli.main()
        except SystemExit as stop:
            status = int(stop.code or 0)
    return Outcome(status, out.getvalue(), err.getvalue())


#: The command line in a process of its own.
COMMAND = (sys.executable, "-c", "from myostrain.cli import main; main()")


def other_process(
    *arguments: Any, launcher: tuple[str, ...] = (), cwd: Path, timeout: float = 60.0
) -> Outcome:
    """Call the command line in a process of its own, or in several by a launcher; too long is an error."""
    done = subprocess.run(
        [*launcher, *COMMAND, *map(str, arguments)],
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )
    return Outcome(done.returncode, done.stdout, done.stderr)
