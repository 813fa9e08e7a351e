"""Changes of single keys from the command line: ``KEY=VALUE``."""

from __future__ import annotations

import dataclasses
import logging
import re
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.case.sections import CELLS, DEFORMATIONS, FIBRES, GEOMETRIES, LAWS, MATERIALS, SCHEMES
from myostrain.errors import InputError, shown
from myostrain.membranes.parameter_sets import without_the_sets

log = logging.getLogger("myostrain")

#: Keys whose word says which others a section has.
WORDS: dict[str, Mapping[str, Any]] = {
    "geometry.kind": GEOMETRIES,
    "fibres.kind": FIBRES,
    "cell.model": CELLS,
    "activation.law": LAWS,
    "activation.deformation": DEFORMATIONS,
    "material.model": MATERIALS,
    "time.scheme": SCHEMES,
}

#: Tables in tables that a case may have at most; a deeper key is a mistake.
DEPTH = 8


#: ``KEY=VALUE``, or the key and the value.
Assignment = str | tuple[str, Any]


def override(data: dict[str, Any], assignments: Sequence[Assignment]) -> None:
    """Apply ``KEY=VALUE`` to nested dictionaries, one after the other.

    Args:
        data: The case; changed in place.
        assignments: Dotted keys, and values in TOML syntax; a bare word is a text. Of several sections of a
            name, the number follows it: ``stimulus.2.strength=20``; where there is one, it may be left out.
            Or pairs of a key and a value. A word that chooses a model takes the place of the earlier one with
            its keys, as a warning says.

    Raises:
        InputError: An assignment is of another form.
    """
    if assignments and isinstance(data.get("cell"), Mapping):
        data["cell"] = _without_the_sets(data["cell"])
    pairs = [split(each) if isinstance(each, str) else each for each in assignments]
    before = {key: _word(data, key) for key in WORDS}
    for key, value in pairs:
        _assign(data, key, value)
    given = {key for key, _ in pairs}
    for key in WORDS:
        if key in given and before[key] != _word(data, key):
            _drop_what_no_longer_fits(data, key, given)


def _word(data: Mapping[str, Any], key: str) -> Any:
    section, name = key.split(".")
    return data[section].get(name) if isinstance(data.get(section), Mapping) else None


def _drop_what_no_longer_fits(data: dict[str, Any], key: str, given: set[str]) -> None:
    """Take out of a section what only its earlier model has; what was given with the new one stays."""
    section, choices, word = key.partition(".")[0], WORDS[key], _word(data, key)
    if not isinstance(word, str) or word not in choices:
        return  # said where the case is checked
    old = {field.name for cls in choices.values() for field in dataclasses.fields(cls)}
    if key == "activation.law" and getattr(choices[word], "yields", "strain") == "tension":
        old |= {"deformation", *(f.name for cls in DEFORMATIONS.values() for f in dataclasses.fields(cls))}
    fits = {field.name for field in dataclasses.fields(choices[word])}
    table = data[section]
    gone = {n: table.pop(n) for n in list(table) if n in old - fits and f"{section}.{n}" not in given}
    if gone:
        said = ", ".join(f"{name} = {shown(value)}" for name, value in gone.items())
        log.warning("%s is %s now: left out of [%s] what it does not have: %s", key, word, section, said)


def _without_the_sets(cell: Mapping[str, Any]) -> dict[str, Any]:
    """The section [cell] without the numbers that its set of parameters gives anyway.

    A resolved case holds all of them; were they kept, another ``cell.set`` would change nothing.
    """
    model = CELLS.get(str(cell.get("model")))
    try:
        return without_the_sets(model, cell) if model else dict(cell)
    except InputError:  # said where the case is checked
        return dict(cell)


def split(assignment: str) -> tuple[str, Any]:
    """Key and value of ``KEY=VALUE``.

    Raises:
        InputError: It is of another form.
    """
    if not assignment.isprintable():
        raise InputError(f"{assignment!r} holds characters that cannot be printed", "--set")
    key, equals, text = assignment.partition("=")
    path = [part.strip() for part in key.split(".")]
    if not equals or not all(path) or len(path) > DEPTH:
        raise InputError(f"'{assignment}' is not of the form KEY=VALUE, such as cell.alpha=0.13", "--set")
    return ".".join(path), _value(key, text)


def _assign(data: dict[str, Any], key: str, value: Any) -> None:
    path = key.split(".")
    at: Any = data
    for part in path[:-1]:
        at = _within(at, part, key)
        if not isinstance(at, dict | list):
            raise InputError(f"'{part}' is a value, not a section", f"--set {key}")
    if isinstance(at, list) and len(at) == 1 and isinstance(at[0], dict) and not path[-1].isdecimal():
        at = at[0]
    if isinstance(at, list):  # the sections [[...]], counted from 1 as in messages
        _within(at, path[-1], key)
        at[int(path[-1]) - 1] = value
    else:
        at[path[-1]] = value


def _within(at: Any, part: str, key: str) -> Any:
    """What a part of a dotted key names: a table, made if it is not there, or one of several sections."""
    if isinstance(at, list) and len(at) == 1 and isinstance(at[0], dict) and not part.isdecimal():
        at = at[0]
    if isinstance(at, dict):
        return at.setdefault(part, {})
    if not part.isdecimal() or not 1 <= int(part) <= len(at):
        raise InputError(
            f"there are {len(at)} of this section: name one by its number, from 1 on, before the key, or "
            "give all of them as a list",
            f"--set {key}",
        )
    return at[int(part) - 1]


def _value(key: str, text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):  # ValueError: of TOML, and of integers that are too long
        # A shell takes the quotes away: a bare word, a number of a version or a path is a text.
        word = text.strip()
        if not word or not all(letter.isalnum() or letter in "-_./~+" for letter in word):
            if re.fullmatch(r"[-+]?\d+,\d+", word):
                raise InputError(
                    f"'{text}' is not a number in TOML syntax: write {word.replace(',', '.')}, or "
                    f"[{word}] for a list",
                    f"--set {key}",
                ) from None
            raise InputError(
                f"'{text}' is not a value in TOML syntax (a text with spaces needs quotes of its own: "
                f"--set '{key.strip()}=\"a text\"')",
                f"--set {key}",
            ) from None
        return word
