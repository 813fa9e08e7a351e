"""Frozen, validated descriptions: what a case file or a script says, checked when it is made."""

from __future__ import annotations

import copy
import dataclasses
import functools
import inspect
from collections.abc import Callable, Mapping
from typing import Annotated, Any, dataclass_transform

from myostrain.engine import fem
from myostrain.errors import InputError

import pydantic
from pydantic import ConfigDict, Field

# Strict: a text or a truth value is no number.
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False, strict=True)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False, strict=True)]
Number = Annotated[float, Field(strict=True)]
Finite = Annotated[float, Field(allow_inf_nan=False, strict=True)]
Count = Annotated[int, Field(ge=1, strict=True)]
Flag = Annotated[bool, Field(strict=True)]


@dataclass_transform(frozen_default=True)
def description[T](cls: type[T]) -> type[T]:
    """Make a class a frozen dataclass whose values are checked; unknown names are refused."""
    config = ConfigDict(extra="forbid", arbitrary_types_allowed=True)
    return pydantic.dataclasses.dataclass(frozen=True, config=config)(cls)  # type: ignore[return-value]


def refuse_former(given: Mapping[str, Any], former: Mapping[str, str], who: str) -> None:
    """Refuse keywords that an object does not take; those of earlier versions with what became of them.

    Raises:
        InputError: A keyword of an earlier version.
        TypeError: Any other one.
    """
    for name in given:
        if name in former:
            raise InputError(f"{who} takes no '{name}' any more: {former[name]}")
        raise TypeError(f"{who} takes no '{name}'")


def remembers[**P](make: Callable[P, None]) -> Callable[P, None]:
    """An ``__init__`` that keeps what it is given, by name, as ``made_from``."""
    signature = inspect.signature(make)

    @functools.wraps(make)
    def made(*arguments: P.args, **named: P.kwargs) -> None:
        bound = signature.bind(*arguments, **named)
        bound.apply_defaults()
        myself, *names = bound.arguments
        bound.arguments[myself].made_from = {name: bound.arguments[name] for name in names}
        make(*arguments, **named)

    return made


def with_constants[T](thing: T, mesh: Any) -> T:
    """A copy of a dataclass whose numbers are :class:`dolfinx.fem.Constant`.

    Forms built from it are compiled once for all values of the parameters. Anything that is not a
    dataclass is returned as it is, and then its numbers are compiled in.
    """
    if not dataclasses.is_dataclass(thing) or isinstance(thing, type):
        return thing
    made = copy.copy(thing)
    for field in dataclasses.fields(thing):
        value = getattr(thing, field.name)
        if isinstance(value, float):
            object.__setattr__(made, field.name, fem.Constant(mesh, value))
    return made
