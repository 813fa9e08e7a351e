"""A membrane with other parameters than elsewhere, for a part of a body."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from myostrain.errors import InputError, dotted, nearest, shown
from myostrain.membranes.files import FileMembrane
from myostrain.membranes.parameter_sets import without_the_sets
from myostrain.validation import InvalidDescription, plain_words

import numpy as np

#: Parameters that name a set of others, and where a class has its sets.
SELECTORS = {"set": "sets", "slope": "slopes"}


def numbers(membrane: Any) -> dict[str, Any]:
    """The parameters of a membrane that may vary over a body, by the names that a user has for them."""
    if isinstance(membrane, FileMembrane):
        return dict(membrane.parameters)
    return _held(membrane)


def attribute(membrane: Any, name: str) -> str:
    """By which name a membrane holds a parameter that a user calls ``name``."""
    return getattr(membrane, "_attributes", {}).get(name, name)


def _held(membrane: Any) -> dict[str, Any]:
    """Numbers and truth values among the attributes."""
    held = vars(membrane) if hasattr(membrane, "__dict__") else {}
    return {n: x for n, x in held.items() if isinstance(x, bool | int | float) and not n.startswith("_")}


def changes(
    membrane: Any, named: str | None, parameters: Mapping[str, Any], key: str, also: Sequence[str] = ()
) -> dict[str, Any]:
    """The parameters that a set and other values replace, by name.

    Args:
        membrane: The membrane of the rest of the body.
        named: Name of a published set; None for none.
        parameters: Values by name: numbers, truth values, or arrays of them.
        key: What goes before the names in messages.
        also: Other names that are known where these are given.

    Raises:
        InputError: An unknown name, an unknown set, or a parameter that is not a number.
    """
    found: dict[str, Any] = {}
    name, known = type(membrane).__name__, numbers(membrane)
    chosen = {"set": named, "slope": parameters.get("slope")}
    for selector, place in SELECTORS.items():
        word, sets = chosen[selector], getattr(membrane, place, None)
        if word is None or (sets is None and selector != "set"):
            continue
        if sets is None:
            raise InputError(f"{name} has no sets of parameters; leave it out", f"{key}.{selector}")
        if not isinstance(word, str | float | int) or word not in sets:
            hint = nearest(word, sets) if isinstance(word, str) else f"known: {', '.join(map(str, sets))}"
            raise InputError(f"{shown(word)} is not a {selector} of {name}; {hint}", f"{key}.{selector}")
        found |= {selector: word} | sets[word]
    for parameter, value in parameters.items():
        if parameter not in known:
            raise InputError(_unknown(membrane, parameter, [*known, *also]), dotted(key, parameter))
        found[parameter] = value
    return found


def _unknown(membrane: Any, parameter: str, known: Sequence[str]) -> str:
    if parameter == "set":
        return "give set by itself, not among the parameters"
    if hasattr(membrane, parameter) and not parameter.startswith("_"):
        held = getattr(membrane, parameter)
        return f"this is {shown(held)}, no number: it is the same all over the body"
    return f"{type(membrane).__name__} has no such parameter; {nearest(parameter, known)}"


def variant(membrane: Any, changed: Mapping[str, Any], key: str) -> Any:
    """A copy of a membrane in which some parameters are others; its rest follows them.

    Args:
        membrane: The membrane; it is not changed.
        changed: Numbers by name, as :func:`changes` gives them.
        key: What goes before the names in messages.

    Raises:
        InputError: A value that the membrane does not take, or that changes which states it has.
    """
    for name, value in changed.items():
        number = isinstance(value, bool | int | float | np.number) and math.isfinite(value)
        if not number and name not in SELECTORS:
            raise InputError(f"give a finite number, not {shown(value)}", dotted(key, name))
    try:
        if isinstance(membrane, FileMembrane):
            made: Any = dataclasses.replace(membrane, parameters={**membrane.parameters, **changed})
        elif dataclasses.is_dataclass(membrane) and not isinstance(membrane, type):
            # Numbers of the body's set are left out: one that changes may make them those of another set.
            held = {f.name: getattr(membrane, f.name) for f in dataclasses.fields(membrane) if f.init}
            made = type(membrane)(**{**without_the_sets(type(membrane), held), **changed})
        else:
            made = copy.copy(membrane)
            for name, value in changed.items():
                setattr(made, name, value)
    except InvalidDescription as error:
        name = str(error.found["loc"][-1]) if error.found["loc"] else ""
        given = f", not {shown(error.found['input'])}" if name else ""
        raise InputError(f"{plain_words(error.found, '')}{given}", dotted(key, name)) from None
    except InputError as error:
        said = str(error).removeprefix(f"{error.key}: ")
        raise InputError(said, f"{key}.{(error.key or 'set').split('.')[-1]}") from None
    if tuple(getattr(made, "states", ())) != tuple(getattr(membrane, "states", ())):
        name = next(iter(changed))
        raise InputError(
            "this decides which states there are: it is the same all over the body", f"{key}.{name}"
        )
    return made


def differing(membrane: Any, variants: Iterable[Any]) -> list[str]:
    """Attributes that are numbers, and others in one of the variants than in the membrane."""
    held, found = _held(membrane), set[str]()
    for made in variants:
        found |= {n for n, x in _held(made).items() if n not in SELECTORS and held.get(n) != x}
    return sorted(found)
