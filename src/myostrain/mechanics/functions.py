"""Functions of time of a script among what supports and loads are given."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.course import with_functions, without_functions, wrapped
from myostrain.validation import check_fields


def check_with_functions(thing: Any, lowest: Mapping[str, float | None]) -> None:
    """Check the values of a frozen dataclass, of which some may be functions of time.

    Args:
        thing: The dataclass.
        lowest: The fields that may hold functions, and the least value of each; None for any.

    Raises:
        InputError: A value does not fit, or is not a function of time.
    """
    given = {name: wrapped(getattr(thing, name), f"mechanics.{name}", low) for name, low in lowest.items()}
    for name, values in given.items():
        object.__setattr__(thing, name, without_functions(values))
    check_fields(thing, "mechanics")
    for name, values in given.items():
        object.__setattr__(thing, name, with_functions(getattr(thing, name), values))
