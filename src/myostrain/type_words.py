"""Types in words: what a value may be, for messages and for the reference of the case file."""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any

PLAIN = {float: "number", int: "integer", bool: "true or false", str: "text", Path: "path", Any: "number"}


def in_words(hint: Any) -> str:
    """What a value of a type may be, without an article: "list of 2 numbers > 0"; "" of other types."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Annotated:
        limits = [text for each in args[1:] for text in map(limit, getattr(each, "metadata", ())) if text]
        return " ".join([in_words(args[0]), *([" and ".join(limits)] if limits else [])])
    if origin is typing.Literal:
        return " or ".join(quoted(arg) for arg in args)
    if origin in (typing.Union, types.UnionType):
        return ", or ".join(filter(None, map(in_words, args)))
    if origin is tuple:
        return f"list of {'' if args[-1] is Ellipsis else f'{len(args)} '}{several(args[0])}"
    if origin is Mapping:
        each = in_words(args[1])
        if typing.get_origin(args[1]) is not Mapping:  # whose "or" has its article
            each = each.replace(", or ", ", or a ")
        return f"table that gives each name {with_article(each)}"
    if dataclasses.is_dataclass(hint):
        return "table"
    return PLAIN.get(hint, "")


def several(hint: Any) -> str:
    """The same for many: "lists of 2 numbers > 0"."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Literal:
        return f"words out of {', '.join(quoted(arg) for arg in args)}"
    if origin is typing.Annotated and len(typing.get_args(args[0])) > 1:
        return several(args[0])  # of more than one kind, with a check of its own
    if origin in (typing.Union, types.UnionType):
        return ", or ".join(several(arg) for arg in args)
    if origin is tuple:  # no plural of a plural: "lists of 2 numbers"
        return in_words(hint).replace("list", "lists", 1)
    first, *rest = in_words(hint).split(" ")
    first = f"{first[:-1]}s," if first.endswith(",") else f"{first}s"
    return " ".join([first, *rest])


def with_article(words: str) -> str:
    """A type in words with "a" or "an", where it needs one."""
    if words.startswith(('"', "`", "true")):
        return words
    return f"{'an' if words[:1] in 'aeiou' else 'a'} {words}"


def limit(constraint: Any) -> str | None:
    """A bound as a sign and a number."""
    signs = {"gt": ">", "ge": "≥", "lt": "<", "le": "≤"}
    for name, sign in signs.items():
        if hasattr(constraint, name):
            return f"{sign} {getattr(constraint, name):g}"
    return None


def quoted(word: Any) -> str:
    """A word as TOML has it."""
    return f'"{word}"'
