"""What a run may differ in from the one whose checkpoint it goes on from, and what it may not."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from myostrain.coupling import Electromechanics
from myostrain.errors import InputError, shown
from myostrain.output.comparing import flat
from myostrain.state import State

import numpy as np

#: Keys whose change leaves the meaning of a state as it is: loads, the end, outputs, solvers.
FREE = (
    *("name", "title", "cost", "time.end", "output", "solver", "drive", "stimulus"),
    *("mechanics.pressure", "mechanics.traction", "mechanics.displacement", "mechanics.loads"),
    *("mechanics.supports.displacement", "mechanics.tolerance"),
    *("mechanics.options", "potential.options", "potential.stimuli", "potential.source", "potential.drive"),
)

#: Numbers in an array that is compared.
SMALL = 100

#: How deep what is in what is compared; the corners of a stimulus' box are at level 6 of a model.
DEPTH = 9

#: What a part is made from that is compared elsewhere (the mesh, by its nodes) or follows from the rest.
_ELSEWHERE = (
    *("body", "former", "model.potential.deformation"),
    *("model.transfer.mesh", "model.transfer.deformation"),
)


def differences(before: Mapping[str, Any], now: Mapping[str, Any]) -> dict[str, tuple[Any, Any]]:
    """Values, before and now, of the dotted keys in which two nested dictionaries differ."""
    old, new = dict(flat(before)), dict(flat(now))
    keys = [*old, *(key for key in new if key not in old)]
    return {key: (old.get(key), new.get(key)) for key in keys if old.get(key) != new.get(key)}


def fixed(found: Mapping[str, tuple[Any, Any]]) -> dict[str, tuple[Any, Any]]:
    """Those differences that a resumed run may not have."""
    free = tuple(f"{key}." for key in FREE)
    return {key: pair for key, pair in found.items() if not f"{key}.".startswith(free)}


def said(found: Mapping[str, tuple[Any, Any]]) -> str:
    """Some differences in words."""
    told = [f"{key} is {shown(now)}, it was {shown(old)}" for key, (old, now) in list(found.items())[:3]]
    return "; ".join([*told, *["..."] * (len(found) > 3)])


def accept(saved: State, now: State, step: float, steps: int) -> list[dict[str, Any]]:
    """Check that a run may go on from a state.

    Args:
        saved: The state of the checkpoint.
        now: What the state of this run says of what runs: "case" and "built".
        step: The time step.
        steps: Number of steps to the end.

    Returns:
        What was changed, and at which times, for the record.

    Raises:
        InputError: It may not, as what the state means was changed; the keys are named.
    """
    with restoring():
        time, done, changes = float(saved["model"]["time"]), int(saved["model"]["steps"]), saved["changes"]
        float(saved["seconds"])
        tips = saved["tips"] or {"size": None, "found": 0, "most": 0, "path": []}
        int(tips["found"] + tips["most"] + len(tips["path"]))
        loops = saved["loops"] or {"size": None, "rows": []}
        len(loops["rows"])
        sizes = saved["table"], saved["measures"]["size"], tips["size"], saved["ecg"], loops["size"]
        for size in sizes:
            if not isinstance(size, int | None):
                raise ValueError(f"{size!r} is not a size of a table")
        dict(saved["measures"]["last"], **saved["measures"]["peaks"])
        len(saved["retries"])
        found: dict[str, Any] = {}
        for part in ("built", "probes", "electrodes", "case"):
            prefix = f"{part}." if part in ("probes", "electrodes") else ""
            differ = differences(saved[part], now[part])
            found |= {f"{prefix}{key}": pair for key, pair in differ.items()}
        before = float(saved["step"])
    if refused := fixed(found):
        raise InputError(
            f"this is not the case of the checkpoint: it was changed since ({said(refused)}); put it back, "
            "or start again in another folder. Loads, time.end, output, solvers and tolerances may change",
            "--resume",
        )
    if not math.isclose(before, step, rel_tol=1e-9):
        raise InputError(
            f"the steps of {before:g} of the checkpoint have to go on: give a whole number of them",
            "time.end",
        )
    if done > steps:
        raise InputError(f"the checkpoint is of t = {time:.6g} already; give a later end", "time.end")
    if now["case"]:  # the same again by other names is in what a script would be told by
        found = differences(saved["case"], now["case"])
    return [*changes, *({"time": time, "key": key, "from": a, "to": b} for key, (a, b) in found.items())]


@contextmanager
def restoring() -> Iterator[None]:
    """While a state is taken over: what does not fit is an :class:`InputError`."""
    try:
        yield
    except InputError:
        raise
    except (KeyError, TypeError, ValueError, AttributeError, IndexError, OverflowError) as error:
        raise InputError(
            f"the checkpoint holds no state of this model ({type(error).__name__}: {error}): another program "
            "or version wrote it; start again in another folder",
            "--resume",
        ) from error


def built(model: Electromechanics, tell: Callable[[str], object]) -> dict[str, Any]:
    """What a model is built from, as JSON can hold it, to compare a script's objects.

    Args:
        model: The coupled problem.
        tell: Is told what can be compared by its class only.
    """
    vague: list[str] = []
    found = _described(model, "model", vague)
    if vague:
        tell(f"a resumed run cannot tell whether these were changed: {', '.join(vague)}")
    return dict(json.loads(json.dumps(found)))


def _described(thing: Any, name: str, vague: list[str], depth: int = 0) -> Any:
    if thing is None or isinstance(thing, bool | int | float | str):
        return thing if not isinstance(thing, float) or math.isfinite(thing) else str(thing)
    if isinstance(thing, np.generic):
        return _described(thing.item(), name, vague, depth)
    if isinstance(thing, np.ndarray):
        if thing.size > SMALL:  # of nodes, perhaps, which another number of processes has in another order
            vague.append(name)
            return {"class": "numpy.ndarray"}
        return _described(thing.tolist(), name, vague, depth)
    if isinstance(thing, Path):
        return str(thing)
    if depth < DEPTH and isinstance(thing, list | tuple):
        return [_described(part, f"{name}.{i}", vague, depth + 1) for i, part in enumerate(thing)]
    kind = f"{type(thing).__module__}.{type(thing).__qualname__}"
    values: Mapping[Any, Any] | None = None
    if isinstance(thing, Mapping):
        values = thing
    elif hasattr(thing, "made_from"):
        values = {"class": kind, **thing.made_from}
    elif dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        values = {"class": kind} | {f.name: getattr(thing, f.name) for f in dataclasses.fields(thing)}
    elif callable(thing) and hasattr(thing, "__code__"):
        code = thing.__code__
        values = {"function": thing.__qualname__, "code": hashlib.sha256(code.co_code).hexdigest()[:16]}
        values |= {"constants": [c for c in code.co_consts if isinstance(c, bool | int | float | str)]}
    elif not kind.startswith(("ufl.", "dolfinx.", "basix.", "petsc4py.")) and hasattr(thing, "__dict__"):
        values = {"class": kind, **{k: v for k, v in vars(thing).items() if not k.startswith("_")}}
    if values is None or depth >= DEPTH:
        vague.append(name)
        return {"class": kind}
    return {
        str(key): _described(value, f"{name}.{key}", vague, depth + 1)
        for key, value in values.items()
        if key not in _ELSEWHERE and f"{name}.{key}" not in _ELSEWHERE
    }
