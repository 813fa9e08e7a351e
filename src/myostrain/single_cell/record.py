"""The result folder of a cell: ``results.json``, ``trace.csv``, a picture; and its end, to begin with."""

from __future__ import annotations

import copy
import json
import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from myostrain.engine import MPI, versions
from myostrain.errors import InputError
from myostrain.output.figures.style import BLUE, COLOURS, new_figure, save, style
from myostrain.output.folder import read_regular, results_folder, write_atomically, write_json
from myostrain.single_cell.pacing import Paced

import numpy as np

log = logging.getLogger("myostrain")

#: States that the picture shows at most.
SHOWN = 6


def results_of(paced: Paced, model: str, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """What ``results.json`` holds.

    Args:
        paced: The membrane that was paced.
        model: Its name.
        parameters: Its parameters, all resolved.
    """
    membrane = paced.membrane
    time, potential = (getattr(membrane, f"{name}_unit", None) for name in ("time", "potential"))
    calcium = getattr(membrane, "calcium_unit", None)
    rate = None if time is None else f"{potential or '1'}/{time}"
    units = dict.fromkeys(("apd30", "apd50", "apd90", "alternans", "calcium_time", "cycle", "step"), time)
    units |= {"peak": potential, "rest": potential, "upstroke_velocity": rate, "calcium_peak": calcium}
    return {
        "model": model,
        "completed": True,
        **paced.last,
        "alternans": paced.alternans,
        "notes": dict(paced.notes),
        "beats": [dict(beat) for beat in paced.beats],
        "cycle": paced.cycle,
        "stimulus": dict(zip(("strength", "duration"), paced.stimulus, strict=True)),
        "step": paced.step,
        "units": {name: unit for name, unit in units.items() if unit is not None},
        "end": dict(paced.end),
        "parameters": dict(parameters),
        "versions": versions(),
    }


def write_cell(
    paced: Paced,
    out: Path,
    model: str,
    parameters: Mapping[str, Any],
    *,
    force: bool = False,
    title: str | None = None,
) -> dict[str, Any]:
    """Write a result folder.

    Args:
        paced: The membrane that was paced.
        out: The folder.
        model: Name of the model.
        parameters: Its parameters, all resolved.
        force: Whether results of an earlier run in it may be removed.
        title: What the picture calls it; the name unless given.

    Returns:
        What ``results.json`` holds.

    Raises:
        InputError: The folder holds something already, or cannot be written.
    """
    found = results_of(paced, model, parameters)
    calcium = {} if paced.calcium is None else {"calcium": paced.calcium}
    columns = {"time": paced.time, "potential": paced.potential, **calcium}
    columns |= {name: values for name, values in paced.states.items() if name not in columns}
    rows = [",".join(f"{x:.9g}" for x in row) for row in np.column_stack(list(columns.values())).tolist()]
    with results_folder(out, "cell", force=force, comm=MPI.COMM_SELF) as picture:
        write_atomically(out / "trace.csv", "\n".join([",".join(columns), *rows]) + "\n")
        draw_cell(paced, title or model, picture)
        write_json(out / "results.json", found)
    return found


def draw_cell(paced: Paced, model: str, path: Path) -> Path:
    """Draw the last beat: the action potential, the calcium, and the states that change most.

    Args:
        paced: The membrane that was paced.
        model: What it is called.
        path: Where to, replaced if it exists.

    Raises:
        InputError: It cannot be written.
    """
    membrane = paced.membrane
    since = paced.time - (paced.time[-1] - paced.cycle)
    last = since >= -1e-9 * paced.cycle
    x, v = since[last], paced.potential[last]
    calcium = getattr(membrane, "calcium", None)
    others = {name: values[last] for name, values in paced.states.items() if name != calcium}
    change = {name: float(np.ptp(y) / (np.abs(y).max() or 1.0)) for name, y in others.items()}
    gates = [n for n in others if n in getattr(membrane, "gates", ())] or list(others)
    chosen = sorted(gates, key=lambda name: -change[name])[:SHOWN]

    def label(text: str, name: str) -> str:
        unit = getattr(membrane, f"{name}_unit", None)
        return f"{text} ({unit})" if unit else text

    panels = ["potential", *(["calcium"] if calcium else []), *(["states"] if chosen else [])]
    with style():
        figure = new_figure(4.0 * len(panels), 3.6, f"{model}, beat {len(paced.beats)}")
        for name, panel in zip(panels, np.atleast_1d(figure.subplots(1, len(panels))), strict=True):
            panel.set_xlabel(label("time since the stimulus", "time"))
            panel.margins(x=0)
            if name == "potential":
                panel.plot(x, v, color=BLUE)
                panel.set_ylabel(label("potential", "potential"))
                if (apd := paced.last["apd90"]) is not None:
                    unit = getattr(membrane, "time_unit", None) or ""
                    panel.set_title(f"APD90 {apd:.4g} {unit}".rstrip())
            elif name == "calcium":
                panel.plot(x, paced.states[str(calcium)][last], color=COLOURS[1])
                panel.set_ylabel(label(f"calcium {calcium}", "calcium"))
            else:
                for state, colour in zip(chosen, COLOURS, strict=False):
                    panel.plot(x, others[state], color=colour, label=state, linewidth=1.3)
                panel.set_ylabel("states")
                panel.legend(ncols=2)
        return save(figure, path)


def end_state(
    folder: Path, membrane: Any, model: str, parameters: Mapping[str, Any], key: str = "cell.initial"
) -> dict[str, float]:
    """The potential and the states at the end of a cell's run, for a tissue to begin with.

    Another model is refused. Other parameters are allowed, as a tissue may vary them, but a warning says
    which.

    Args:
        folder: Result folder of ``myostrain cell``.
        membrane: The membrane that is to begin so.
        model: Its name.
        parameters: Its parameters, all resolved.
        key: What the folder was given by, for the message.

    Raises:
        InputError: No cell was written there, or it was of another model.
    """
    path = folder / "results.json"
    try:
        found = json.loads(read_regular(path))
        end = {name: float(value) for name, value in found["end"].items()}
        theirs, other = dict(found["parameters"]), str(found["model"])
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        why = getattr(error, "strerror", None) or "it is not of `myostrain cell`"
        raise InputError(
            f"{path} cannot be used: {why}; write it by `myostrain cell {model} --out {folder}`", key
        ) from error
    names = ["potential", *getattr(membrane, "states", ())]
    if other != model:
        raise InputError(
            f"{folder} is of {other}, and the membrane is {model}: take one of the same model", key
        )
    if set(end) != set(names):
        raise InputError(
            f"{folder} is of a cell with the states {', '.join(end)}, and the membrane has "
            f"{', '.join(names)}: take one of the same file",
            key,
        )
    ours = dict(parameters)
    differing = [n for n in {**theirs, **ours} if theirs.get(n) != ours.get(n)]
    if differing:
        said = ", ".join(f"{n} {theirs.get(n)} there, {ours.get(n)} here" for n in differing[:5])
        log.warning("%s: the cell in %s had other parameters: %s", key, folder, said)
    return end


def resting_at(membrane: Any, state: Mapping[str, float]) -> Any:
    """The same membrane with its rest at another potential and other states.

    Args:
        membrane: The model; it is not changed.
        state: The potential ("potential") and all states by name.
    """
    rest = tuple(state[name] for name in getattr(membrane, "states", ()))
    cls = type(membrane)
    methods = {
        "resting_potential": lambda _: state["potential"],
        "resting_states": lambda _: rest,
        "__module__": cls.__module__,
    }
    made = copy.copy(membrane)
    object.__setattr__(made, "__class__", type(cls.__name__, (cls,), methods))
    return made
