"""The chapters of the page, all alike: a folder each, and the words in ``cases/paper/CHAPTER.toml``.

- ``jobs.py``: ``jobs(quick)``, what is computed, by names of its own.
- ``numbers.py``: ``numbers(found, quick)``, every number of the chapter, and ``readings(numbers)``, those
  that are judged, by claim and reading, the printed one first.
- ``text.py``: ``words(measured)``, what the words name beside these numbers and the constants of
  ``jobs.py``, and ``tables(measured)``, the rows of the tables by name; ``data(measured)``, if there are
  arrays that others would want, by name: columns by name, for CSV files.
- ``pictures.py``: ``PICTURES``, functions of :class:`~myostrain.reproduce.content.Measured`, by name.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from myostrain.reproduce.content import Chapter, Difference, Measured, Picture, Statement, Table
from myostrain.reproduce.jobs import Found, Job
from myostrain.reproduce.verdict import claims, paper
from myostrain.reproduce.words import filled

from matplotlib.figure import Figure

#: Chapters on what the paper says, and groups of others, in the order of the page.
_NAMES = ("springs", "fronts", "figure-1", "viscosity", "startup", "figure-2", "figure-3", "viscous-sheet")
_GROUPS = {
    "open-questions": (
        "delay",
        "human-pulse",
        "strain-and-stress",
        "ellipticity",
        "stretch-feedback",
        "stretch-threshold",
    )
}


def names() -> list[str]:
    """What the chapters are called, in the order of the page."""
    return [*_NAMES, *(name for members in _GROUPS.values() for name in members)]


def groups() -> dict[str, list[str]]:
    """Groups of chapters that one name stands for, in the order of the page."""
    return {group: list(members) for group, members in _GROUPS.items()}


def jobs(name: str, quick: bool) -> dict[str, Job]:
    """The computations of a chapter, by names of its own."""
    made: dict[str, Job] = _part(name, "jobs").jobs(quick)
    return made


def chapter(name: str, found: Mapping[str, Found], quick: bool) -> Chapter:
    """A chapter, from the outcomes of its jobs."""
    part, text, data = _part(name, "numbers"), _part(name, "text"), paper(name)
    draw: Mapping[str, Callable[[Measured], Figure]] = _part(name, "pictures").PICTURES
    numbers = part.numbers(found, quick)
    readings, measured = part.readings(numbers), Measured(found, numbers, quick)
    constants = {key: value for key, value in vars(_part(name, "jobs")).items() if key.isupper()}
    values = constants | numbers | text.words(measured) | {"numbers": numbers, "quick": quick}

    def fill(template: str) -> str:
        return filled(template, values)

    def words(kind: str, of: str) -> dict[str, Any]:
        """The entries of a table or a picture, with the numbers put in."""
        entries = data[kind][of].items()
        return {
            key: fill(value) if isinstance(value, str) else list(map(fill, value)) for key, value in entries
        }

    return Chapter(
        title=data["title"],
        introduction=fill(data["introduction"]),
        statements=[
            Statement(claim, fill(data["claims"][key]["measured"]), readings[key])
            for key, claim in claims(name).items()
        ],
        tables=[Table(**words("tables", key), rows=rows) for key, rows in text.tables(measured).items()],
        pictures=[
            Picture(key, **words("pictures", key), draw=partial(one, measured)) for key, one in draw.items()
        ],
        differences=[
            Difference(**{k: fill(v) for k, v in one.items()}) for one in data.get("differences", ())
        ],
        numbers=numbers,
        remarks=fill(data.get("remarks", "")),
        data=getattr(text, "data", lambda measured: {})(measured),
    )


def _part(name: str, part: str) -> Any:
    return importlib.import_module(f"{__name__}.{name.replace('-', '_')}.{part}")
