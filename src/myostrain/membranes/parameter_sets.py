"""Published sets of parameters that a membrane offers by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from myostrain.errors import InputError, nearest, shown

#: Default of a parameter that is the set's unless it is given.
OF_SET: Any = None


def fill_from_set(membrane: Any, sets: Mapping[Any, Mapping[str, Any]], key: str = "set") -> None:
    """Give each parameter that was left out its value in the set that another parameter names.

    Args:
        membrane: The model.
        sets: The sets by name, a word or a number.
        key: The parameter that names one of them.

    Raises:
        InputError: There is no such set; or every number is given, and they are those of another set.
    """
    name = getattr(membrane, key)
    if name not in sets:
        known = nearest(name, sets) if isinstance(name, str) else f"known: {', '.join(map(str, sets))}"
        raise InputError(f"{shown(name)} is not a {key} of {type(membrane).__name__}; {known}", f"cell.{key}")
    given = {field.name: getattr(membrane, field.name) for field in dataclasses.fields(membrane)}
    for other, values in sets.items():
        if values != sets[name] and all(given[of] == value for of, value in values.items()):
            this, those = (f'"{word}"' if isinstance(word, str) else f"{word}" for word in (name, other))
            raise InputError(
                f"this is {this}, but the numbers beside it are all those of {those}: leave them out",
                f"cell.{key}",
            )
    for of, value in sets[name].items():
        if given[of] is None:
            object.__setattr__(membrane, of, value)


def without_the_sets(membrane: type, values: Mapping[str, Any]) -> dict[str, Any]:
    """Values of a membrane without the numbers that its set gives anyway, so that the set may be changed.

    Args:
        membrane: The class.
        values: Values by name; names that are not the class's are kept.

    Raises:
        InputError: The values without those numbers make no membrane.
    """
    defaults = {field.name: field.default for field in dataclasses.fields(membrane)}
    if "set" not in defaults:
        return dict(values)
    of_set = {key for key, default in defaults.items() if default is OF_SET}
    plain = membrane(**{key: values[key] for key in defaults if key in values and key not in of_set})
    return {key: value for key, value in values.items() if key not in of_set or value != getattr(plain, key)}
