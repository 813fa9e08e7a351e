"""Frozen, validated descriptions: what a case file or a script says, checked when it is made."""

from __future__ import annotations

import copy
import dataclasses
import functools
import html
import inspect
import re
import typing
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, dataclass_transform

from myostrain.engine import fem
from myostrain.errors import InputError, nearest, shown
from myostrain.type_words import in_words, with_article

import pydantic
from pydantic import ConfigDict, Field

# Strict: a text or a truth value is not a number.
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False, strict=True)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False, strict=True)]
Share = Annotated[float, Field(ge=0, le=1, strict=True)]
Number = Annotated[float, Field(strict=True)]
Finite = Annotated[float, Field(allow_inf_nan=False, strict=True)]
Count = Annotated[int, Field(ge=1, strict=True)]
Level = Annotated[int, Field(ge=0, strict=True)]
Flag = Annotated[bool, Field(strict=True)]


@dataclass_transform(frozen_default=True)
def description[T](cls: type[T]) -> type[T]:
    """Make a class a frozen dataclass whose values are checked; unknown names are refused."""
    config = ConfigDict(extra="forbid", arbitrary_types_allowed=True)
    made: Any = pydantic.dataclasses.dataclass(frozen=True, config=config)(cls)
    make = made.__init__

    @functools.wraps(make)
    def checked_init(self: Any, *arguments: Any, **named: Any) -> None:
        try:
            make(self, *arguments, **named)
        except pydantic.ValidationError as error:
            raise _in_words(error, cls) from None

    made.__init__ = checked_init
    return made


class InvalidDescription(InputError):
    """A description whose values were refused.

    Args:
        message: What is wrong.
        found: What pydantic says of it.
    """

    def __init__(self, message: str, found: Any) -> None:
        super().__init__(message)
        self.found = found


def _in_words(error: pydantic.ValidationError, cls: type) -> InputError:
    """The deepest of pydantic's complaints in the words of a script: class, parameter, what is allowed."""
    found: Any = deepest(error)
    cause = found.get("ctx", {}).get("error")
    if isinstance(cause, InputError):  # of values that do not go together, by the class itself
        return cause
    place = [str(part) for part in found["loc"] if isinstance(part, int) or part.isidentifier()]
    kind = str(typing.get_type_hints(cls).get(place[0])) if place else ""
    if found["type"] == "unexpected_keyword_argument":
        known = [field.name for field in dataclasses.fields(cls)]
        said = f"no such parameter; {nearest(place[-1], known)}"
    elif found["type"] == "missing":
        said = missing(cls, place[-1])
    else:
        said = plain_words(found, kind) + (f", not {shown(found['input'])}" if place else "")
    return InvalidDescription(f"{'.'.join([cls.__name__, *place])}: {said}", found)


def missing(cls: type, name: str) -> str:
    """That a field of a description is missing, and what to give."""
    words = in_words(typing.get_type_hints(cls, include_extras=True).get(name))
    return f"missing; give {with_article(words)}" if words else "missing"


def deepest(error: pydantic.ValidationError) -> Any:
    """Of a union's complaints, the one that went deepest, and about the value rather than the type.

    A name that is none may stand for one that is missing: it comes first.
    """
    return max(
        error.errors(),
        key=lambda e: (len(e["loc"]), e["type"].startswith("unexpected"), not e["type"].endswith("_type")),
    )


def expect(thing: Any, method: str, key: str, example: str) -> None:
    """Refuse what is no object with a method: a word, a class, an object of another kind.

    Raises:
        InputError: It is none.
    """
    if isinstance(thing, type) or not hasattr(thing, method):
        raise InputError(f"{shown(thing)}: give an object, such as {example}", key)


def refuse_former(given: Mapping[str, Any], former: Mapping[str, str], cls: type) -> None:
    """Refuse keywords that a class does not take; those of earlier versions with what became of them.

    Raises:
        InputError: A keyword of an earlier version.
        TypeError: Any other one.
    """
    for name in given:
        if name in former:
            raise InputError(f"{cls.__name__} takes no '{name}' any more: {former[name]}")
        taken = inspect.signature(cls).parameters.values()
        known = [keyword.name for keyword in taken if keyword.kind is not keyword.VAR_KEYWORD]
        raise TypeError(f"{cls.__name__} takes no '{name}'; {nearest(name, known)}")


def check_listed(values: Any, keyword: str, example: str, methods: Sequence[str]) -> None:
    """Refuse what is no sequence of objects of a kind.

    Args:
        values: What was given.
        keyword: As what.
        example: The class of which such objects usually are.
        methods: Attributes that they have.

    Raises:
        InputError: It is no sequence, or one of its entries lacks an attribute.
    """
    single = not isinstance(values, Sequence) or isinstance(values, str)
    for value in [values] if single else values:
        lacking = [method for method in methods if not hasattr(value, method)]
        if isinstance(value, type) or lacking:
            why = "it is a class" if isinstance(value, type) else f"it has no {lacking[0]}"
            raise InputError(f"{keyword}: {shown(value)} is no {example}: {why}; give [{example}(...)]")
    if single:
        raise InputError(f"{keyword}: give a list, [{example}(...)], also of one")


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


def check_fields(thing: Any, section: str) -> None:
    """Check the values of a frozen dataclass against their types, and put them in as these say.

    Raises:
        InputError: A value does not fit; the key is that of the section of a case file.
    """
    texts = typing.get_type_hints(type(thing))
    for name, kind in typing.get_type_hints(type(thing), include_extras=True).items():
        # The keys of a table are texts, but its values need not be.
        text = re.sub(r"Mapping\[(str|typing\.Literal\[[^]]*\])", "", str(texts[name]))
        value = checked(kind, getattr(thing, name), f"{section}.{name}", text)
        object.__setattr__(thing, name, value)


def checked(kind: Any, value: Any, key: str, text: str = "") -> Any:
    """A value as a type wants it, a list as a tuple for example.

    Args:
        kind: The type.
        value: The value.
        key: Key of a case file, for the message.
        text: The type as a text without what it is annotated with, for the message.

    Raises:
        InputError: It does not fit; what is allowed.
    """
    try:
        return pydantic.TypeAdapter(kind).validate_python(value)
    except pydantic.ValidationError as error:
        found = deepest(error)
    place = [str(part) for part in found["loc"] if isinstance(part, int) or part.isidentifier()]
    place = [part for part in place if part not in ("float", "int", "str", "bool", "tuple")]
    raise InputError(f"{plain_words(found, text)}, not {shown(found['input'])}", ".".join([key, *place]))


def shown_in_notebook(title: str, rows: Mapping[str, object]) -> str:
    """A title and a table of names and values, HTML for a notebook; empty values are left out."""
    cells = "".join(
        f'<tr><td style="text-align:left">{html.escape(name)}</td>'
        f'<td style="text-align:left">{html.escape(str(value))}</td></tr>'
        for name, value in rows.items()
        if value not in (None, "", (), [], {})
    )
    return f"<b>{html.escape(title)}</b><table>{cells}</table>"


def flat(table: Mapping[str, Any]) -> dict[str, Any]:
    """Tables in tables as one, with dotted names; what lies in a table wins over a dotted name."""
    found = {key: value for key, value in table.items() if not isinstance(value, Mapping)}
    for key, value in table.items():
        if isinstance(value, Mapping):
            found |= {f"{key}.{name}": inner for name, inner in flat(value).items()}
    return found


def plain_words(error: Any, kind: str) -> str:
    """What pydantic says of a value, as something to do.

    Args:
        error: One of its errors.
        kind: The type that is wanted, as text.
    """
    texts = "str" in kind or "Literal" in kind
    some = 'texts, such as ["left"]' if texts else "numbers, such as [2.0, 1.0]"
    wanted = {
        "float_type": "give a number",
        "int_type": "give an integer",
        "int_from_float": "give an integer",
        "bool_type": "give a boolean, true or false",
        "string_type": "give a text",
        "path_type": 'give a path, such as "body.msh"',
        "tuple_type": f"give a list of {some}",
        "too_long": "give a shorter list",
        "missing": f"give a longer list of {some}",
        "mapping_type": "give a table, such as { name = [2.0, 1.0] }",
        "dict_type": "give a table, such as { name = [2.0, 1.0] }",
        "dataclass_type": "give a table, such as { value = 1.0 }",
    }
    said = error["msg"].removeprefix("Value error, ").replace("Input should be", "this should be")
    return wanted.get(error["type"], f"{said[0].lower()}{said[1:]}")


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
