"""Whether an object is a membrane model, before the first step."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from myostrain.errors import InputError, shown
from myostrain.membranes.linearly_implicit import with_slope
from myostrain.membranes.tracing import traced

import numpy as np

KEY = "cell.model"

#: Units of time that a membrane may count in; None is without dimension.
TIME_UNITS = (None, "ms", "s")

#: Nodes of the sample on which a model is tried; not one of them is a likely threshold.
SAMPLE = 7


def check_membrane(membrane: Any) -> None:
    """Refuse what is no membrane model, by its declarations and by a sample of its functions.

    Raises:
        InputError: Something is missing, has a wrong shape, or, where it cannot be
            differentiated in symbols, is not analytic; the message says which.
    """
    name = f"the class {membrane.__name__}" if isinstance(membrane, type) else type(membrane).__name__
    if isinstance(membrane, type):
        raise InputError(f"{name} is not an object: give {membrane.__name__}()", KEY)
    for method in ("resting_potential", "current"):
        if not callable(getattr(membrane, method, None)):
            raise InputError(f"{name} is not a membrane model: it has no method {method}", KEY)
    states = getattr(membrane, "states", ())
    if isinstance(states, str) or not isinstance(states, Sequence):
        raise InputError(f'{name}.states is {states!r}; give a sequence of names, such as ("recovery",)', KEY)
    if not all(isinstance(s, str) and s for s in states) or len(set(states)) != len(states):
        raise InputError(f"{name}.states is {list(states)}; give each state a name of its own", KEY)
    if taken := set(states) & {"potential", "stretch", "time", "displacement", "activation"}:
        raise InputError(f"{name}.states has '{taken.pop()}', which is the name of another field", KEY)
    if states and not callable(getattr(membrane, "resting_states", None)):
        former = " (initial_states of earlier versions)" if hasattr(membrane, "initial_states") else ""
        raise InputError(f"{name} has states, but no method resting_states{former}", KEY)
    low, high = _range(membrane, name)
    rest = _called(membrane, "resting_potential")
    if not _are_numbers(rest, ()):
        raise InputError(f"{name}.resting_potential gives {rest!r}; give a number", KEY)
    if not 2 * low - high <= rest <= 2 * high - low:
        raise InputError(
            f"{name} rests at {rest:g}, far out of its range {(low, high)}: declare the range "
            "(lowest, highest) and the threshold, which are (0, 1) and 0.5 unless given",
            KEY,
        )
    values = _called(membrane, "resting_states") if states else ()
    if not _are_numbers(values, (len(states),)):
        raise InputError(
            f"{name}.resting_states gives {values!r}; give a finite number for each of {list(states)}", KEY
        )
    for what in ("gates", "conserved"):
        named = getattr(membrane, what, ())
        if isinstance(named, str) or not isinstance(named, Collection) or not set(named) <= set(states):
            raise InputError(f"{name}.{what} is {named!r}; give names among its states {list(states)}", KEY)
    _declared(membrane, name)
    calcium = getattr(membrane, "calcium", None)
    if calcium is not None and calcium not in states:
        raise InputError(f"{name}.calcium is '{calcium}', which is none of its states {list(states)}", KEY)
    v = low + (high - low) * (np.arange(SAMPLE) + 0.5377) / SAMPLE
    present = np.tile(np.asarray(values, dtype=float).reshape(-1, 1), SAMPLE)
    v.flags.writeable = present.flags.writeable = False
    if states and not callable(getattr(membrane, "rates", None)):
        raise InputError(f"{name} has states, but no method rates", KEY)
    complex_step = traced(membrane) is None
    _sampled(membrane, name, "current", v, present, (), complex_step)
    if states:
        found = _called(membrane, "rates", v, present)
        if isinstance(found, Mapping):
            raise InputError(
                f"{name}.rates gives a {type(found).__name__}; give a sequence, as states is", KEY
            )
        if not hasattr(found, "__len__") or len(found) != len(states):
            count = len(found) if hasattr(found, "__len__") else "one value"
            raise InputError(f"{name}.rates gives {count} for the states {list(states)}; give one each", KEY)
        for index in range(len(states)):
            _sampled(membrane, name, "rates", v, present, (index,), complex_step)


def _declared(membrane: Any, name: str) -> None:
    """Refuse units that are no texts, a time in others than ms and s, and a stimulus that is none."""
    for what in ("time_unit", "potential_unit", "calcium_unit"):
        unit = getattr(membrane, what, None)
        if not (unit is None or (isinstance(unit, str) and unit)):
            raise InputError(f'{name}.{what} is {unit!r}; give a text, such as "ms", or None', KEY)
    if (unit := getattr(membrane, "time_unit", None)) not in TIME_UNITS:
        raise InputError(
            f'{name}.time_unit is {unit!r}; a membrane counts time in "ms", in "s", or has None, without '
            "dimension: convert its rates and its current to one of them",
            KEY,
        )
    pacing = getattr(membrane, "pacing", None)
    if pacing is not None and not (_are_numbers(pacing, (2,)) and pacing[1] > 0):
        raise InputError(
            f"{name}.pacing is {pacing!r}; give strength (rate of v) and duration, which is positive", KEY
        )


def _range(membrane: Any, name: str) -> tuple[float, float]:
    found = getattr(membrane, "range", (0.0, 1.0))
    if not _are_numbers(found, (2,)) or not found[0] < found[1]:
        raise InputError(f"{name}.range is {found!r}; give (lowest, highest) potential to expect", KEY)
    threshold = getattr(membrane, "threshold", 0.5)
    if not _are_numbers(threshold, ()) or not found[0] < threshold < found[1]:
        raise InputError(f"{name}.threshold is {threshold!r}; give a potential within {tuple(found)}", KEY)
    return float(found[0]), float(found[1])


def _are_numbers(value: Any, shape: tuple[int, ...]) -> bool:
    """Whether something is finite numbers, as many as there should be."""
    try:
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        return False
    return numbers.shape == shape and bool(np.isfinite(numbers).all())


def _sampled(
    membrane: Any, name: str, method: str, v: Any, states: Any, picked: tuple[int, ...], derivatives: bool
) -> None:
    """Try a function on a sample: shapes, and its derivative in v where that is taken by a complex step."""

    def function(at: Any, beside: Any = states) -> Any:
        found = _called(membrane, method, at, beside)
        for index in picked:
            found = found[index]
        return found

    found = function(v)
    what = f"{name}.{method}" + "".join(f"[{i}]" for i in picked)
    if isinstance(found, (list, tuple)):
        raise InputError(f"{what} gives a {type(found).__name__}; give an array of NumPy", KEY)
    if np.shape(found) not in ((), v.shape):
        raise InputError(
            f"{what} gives values of shape {np.shape(found)} for {len(v)} nodes; give one a node", KEY
        )
    if np.asarray(found).dtype.kind not in "fiu":
        raise InputError(f"{what} gives {shown(found)}; give a number for each node", KEY)
    if not np.isfinite(np.asarray(found, dtype=float)).any():
        raise InputError(f"{what} is nowhere finite between {v[0]:g} and {v[-1]:g}, at rest else", KEY)
    alone = function(v[:3], states[:, :3])
    if not np.allclose(alone, np.broadcast_to(found, v.shape)[:3], rtol=1e-9, atol=0.0, equal_nan=True):
        raise InputError(
            f"{what} of a node changes with the other nodes; give what is of its own values", KEY
        )
    if not derivatives:
        return
    shift = 1e-6 * (v[-1] - v[0])
    with np.errstate(all="ignore"):
        slope = np.broadcast_to(with_slope(function, v)[1], v.shape)
        differences = np.broadcast_to((function(v + shift) - function(v - shift)) / (2 * shift), v.shape)
    scale = np.abs(differences).max(initial=0.0)
    # A jump within the shift would make one sample differ, what is not analytic makes many.
    wrong = np.abs(slope - differences) > 1e-3 * scale + 1e-9
    if np.isfinite(differences).all() and wrong.sum() > 1:
        raise InputError(
            f"{what} is not analytic: its derivative by the complex step is not that by differences; abs and "
            "conjugates are not allowed, comparisons and numpy.where are",
            KEY,
        )


def _called(membrane: Any, method: str, *arguments: Any) -> Any:
    try:
        return getattr(membrane, method)(*arguments)
    except (ArithmeticError, AttributeError, LookupError, NameError, TypeError, ValueError) as error:
        said = str(error)
        if "truth value of an array" in said:
            said = "it decides by Python's if, and, or, which see one number; take numpy.where, &, |"
        raise InputError(
            f"{type(membrane).__name__}.{method} failed: {type(error).__name__}: {said}", KEY
        ) from error
