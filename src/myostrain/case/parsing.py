"""Sections of a case file made into descriptions, and back; every message names a key to act on."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from myostrain.case.sections import CLASSES, CirculationSection
from myostrain.electrics import Place, StretchCurrent, Variation
from myostrain.errors import InputError, dotted, nearest, shown
from myostrain.mechanics import Cavities
from myostrain.membranes.variants import changes
from myostrain.solvers.options import check_options
from myostrain.validation import Finite, InvalidDescription, flat, missing, plain_words

import pydantic


def pick(section: dict[str, Any], key: str, choices: Mapping[str, Any], default: str | None = None) -> Any:
    """Take the word that chooses a class out of a section."""
    word = section.pop(key.split(".")[1], default)
    if word is None:
        raise InputError(f"missing; allowed: {', '.join(choices)}", key)
    if not isinstance(word, str) or word not in choices:
        raise InputError(f"{shown(word)} is not known here; {nearest(shown(word), choices)}", key)
    return choices[word]


def make(
    cls: Any,
    values: Mapping[str, Any],
    section: str,
    also: Sequence[str] = (),
    sections: Mapping[str, str] | None = None,
) -> Any:
    """Make a description from a section; errors name the key.

    Args:
        cls: The class.
        values: Its values.
        section: Name of the section.
        also: Keys of the section that are known but not the class's, for the message.
        sections: Keys of the class that live in another section.
    """
    fields = [f.name for f in dataclasses.fields(cls)]
    for key in values:
        if key not in fields:
            where = (sections or {}).get(key, section)
            raise InputError(f"no such key; {nearest(key, [*fields, *also])}", dotted(where, key))
    try:
        return cls(**values)
    except InvalidDescription as error:
        found = error.found
    place = [part for part in found["loc"] if isinstance(part, int) or part.isidentifier()]
    kinds = ("float", "int", "str", "bool", "tuple", "ImposedStretch", "Tip")
    place = [part for part in place if part not in kinds]
    where = (sections or {}).get(str(place[0]), section) if place else section
    key = ".".join([where, *map(str, place)])
    if found["type"] == "missing" and not isinstance(place[-1], int):
        raise InputError(missing(cls if len(place) == 1 else type(None), str(place[-1])), key)
    if found["type"] == "unexpected_keyword_argument":
        inner = _descriptions(typing.get_type_hints(cls)[str(place[0])])
        known = [f.name for part in inner for f in dataclasses.fields(part)]
        raise InputError(f"no such key; {nearest(str(place[-1]), known)}", key)
    kind = str(typing.get_type_hints(cls).get(str(place[0]))) if place else ""
    # What does not fit together is not a single value.
    given = f", not {shown(found['input'])}" if place else ""
    raise InputError(f"{plain_words(found, kind)}{given}", key)


def _descriptions(kind: Any) -> list[Any]:
    """The descriptions that a type is made of."""
    if dataclasses.is_dataclass(kind):
        return [kind]
    return [found for part in typing.get_args(kind) for found in _descriptions(part)]


def make_placed(cls: Any, given: Any, section: str) -> tuple[Any, ...]:
    """Make things in places from a section, or from several: the keys of the place lie among the others."""
    tables = [given] if isinstance(given, Mapping) else list(given)
    places = [f.name for f in dataclasses.fields(Place)]
    known = [*places, *(f.name for f in dataclasses.fields(cls) if f.name != "where")]
    made = []
    for number, table in enumerate(tables, start=1):
        key = section if len(tables) == 1 else f"{section}.{number}"
        for name in table:
            if name not in known:
                raise InputError(f"no such key; {nearest(name, known)}", dotted(key, name))
        where = make(Place, {k: v for k, v in table.items() if k in places}, key)
        others = {k: v for k, v in table.items() if k not in places}
        made.append(make(cls, {**others, "where": where}, key))
    return tuple(made)


def make_stretch_currents(given: Any, membrane: Any, dim: int | None) -> tuple[StretchCurrent, ...]:
    """Make the stretch-activated currents of a cell: one table, or several, each with a place or without.

    Args:
        given: What the case says.
        membrane: The membrane, whose units say what is left out.
        dim: Dimension of the body; None of a rigid one.
    """
    key = "cell.stretch_current"
    tables = [given] if isinstance(given, Mapping) else given
    if not isinstance(tables, (list, tuple)) or not all(isinstance(table, Mapping) for table in tables):
        raise InputError("give a table, such as { conductance = 0.5 }, or a list of them", key)
    if tables and dim is None:
        raise InputError("a rigid body is not stretched: leave it out", key)
    places = {f.name for f in dataclasses.fields(Place)}
    made: list[StretchCurrent] = []
    for number, table in enumerate(tables, start=1):
        at = key if len(tables) == 1 else f"{key}.{number}"
        if places & table.keys():
            (current,) = make_placed(StretchCurrent, table, at)
        else:
            also = tuple(sorted(places))
            current = make(StretchCurrent, table, at, also)
        made.append(current.fitting(membrane, dim))
    return tuple(made)


def make_variations(given: Any, membrane: Any) -> tuple[Variation, ...]:
    """Make variations of a membrane from the tables [[cell.variation]].

    Keys that are not those of the place or of a variation are parameters of the membrane. Of a parameter
    that is given twice, the key of the table itself counts, not that under ``parameters``.

    Raises:
        InputError: They are not tables, or what the membrane does not have or take.
    """
    key, made = "cell.variation", []
    if not isinstance(given, list) or not all(isinstance(table, Mapping) for table in given):
        raise InputError("give tables: [[cell.variation]]", key)
    places = [f.name for f in dataclasses.fields(Place)]
    own = [f.name for f in dataclasses.fields(Variation) if f.name != "where"]
    for number, table in enumerate(given, start=1):
        here = f"{key}.{number}"
        values = {k: v for k, v in table.items() if k in own}
        parameters = flat({k: v for k, v in table.items() if k not in (*places, *own)})
        if not isinstance(values.get("parameters", {}), Mapping):
            raise InputError("give a table of numbers by name", f"{here}.parameters")
        values["parameters"] = flat(values.get("parameters", {})) | parameters
        # Before the place: a misspelt key of the place is the better message.
        changes(membrane, values.get("set"), values["parameters"], here, [*places, *own])
        where = make(Place, {k: v for k, v in table.items() if k in places}, here)
        made.append(make(Variation, {**values, "where": where}, here))
        made[-1].check(membrane, here)
    return tuple(made)


def make_cavities(connected: Any, section: Mapping[str, Any]) -> tuple[Cavities, bool]:
    """Make the cavities of a case, and whether its geometry is that under their preload.

    Args:
        connected: The class of what they are connected to.
        section: [circulation], without its kind.

    Raises:
        InputError: A key is unknown, or a value is not allowed.
    """
    names = [f.name for f in dataclasses.fields(CirculationSection)]
    own = make(CirculationSection, {k: v for k, v in section.items() if k in names}, "circulation")
    others = {k: v for k, v in section.items() if k not in names}
    cavities = (own.cavity,) if isinstance(own.cavity, str) else own.cavity
    if any(field.name == "cavities" for field in dataclasses.fields(connected)):
        others["cavities"] = len(cavities)
    made = make(connected, others, "circulation", also=("kind", *names))
    return Cavities(names=cavities, circulation=made, preload=own.preload, beats=own.beats), own.unload


def make_points(
    section: Mapping[str, Any], name_of: str, what: str, example: str
) -> dict[str, tuple[float, ...]]:
    """A section of points by name, checked; their dimension shows only on the mesh.

    Args:
        section: The section.
        name_of: Its name.
        what: What a point is, for the message.
        example: A point, for the message.
    """
    checked = {}
    for name, point in section.items():
        if not name.isprintable() or not 0 < len(name) <= 100:
            raise InputError(f"call {what} by a short, printable name", dotted(name_of, name))
        try:
            checked[name] = pydantic.TypeAdapter(tuple[Finite, ...]).validate_python(point)
        except pydantic.ValidationError:
            raise InputError(
                f"give finite coordinates, such as {example}, not {shown(point)}", dotted(name_of, name)
            ) from None
    return checked


def make_solver(section: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """The sections [solver.potential] and [solver.mechanics], checked."""
    for name, options in section.items():
        if name not in ("potential", "mechanics"):
            raise InputError(
                f"no such solver; {nearest(name, ('potential', 'mechanics'))}", dotted("solver", name)
            )
        if not isinstance(options, Mapping):
            raise InputError('give PETSc options, such as { ksp_type = "cg" }', f"solver.{name}")
        check_options(name, options)
    return {name: dict(options) for name, options in section.items()}


def places_of(name: str, data: Mapping[str, Any]) -> list[str]:
    """Dotted keys that end in a name: those that a case has, else those that it may have.

    Args:
        name: The last part of a key.
        data: The case, with the sections that it has.
    """
    tables = {key: table for key, table in data.items() if key != name and isinstance(table, Mapping)}
    if found := [f"{section}.{name}" for section, table in tables.items() if name in table]:
        return found
    return [
        f"{section}.{name}"
        for section, classes in CLASSES.items()
        if any(field.name == name for cls in classes for field in dataclasses.fields(cls))
    ]


def word(thing: Any, choices: Mapping[str, Any]) -> str:
    """The word that chooses the class of a description."""
    return next(word for word, cls in choices.items() if type(thing) is cls)


def plain(value: Any) -> Any:
    """A value as TOML and JSON can hold it; None is left out of tables."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {k: plain(v) for k, v in value.items() if v is not None}
    if isinstance(value, tuple | list):
        return [plain(v) for v in value]
    return str(value) if isinstance(value, Path) else value
