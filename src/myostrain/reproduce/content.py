"""What a page is made of: chapters with judged statements, tables, pictures and differences."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from myostrain.reproduce.jobs import Found
from myostrain.reproduce.verdict import Claim, Numbers, Verdict, judge

from matplotlib.figure import Figure

#: Texts are Markdown, formulas between dollar signs.
Text = str
#: Cells of a table; numbers are shown with four digits, None as a dash.
Rows = Sequence[Sequence[Text | float | int | None]]


@dataclass(frozen=True)
class Statement:
    """A claim of the paper beside what was measured.

    Args:
        claim: The claim, from ``cases/paper``.
        measured: What was measured, in a sentence or two with numbers and their settings.
        readings: Measured numbers by reading, the printed one first; the verdict is taken from these alone.
    """

    claim: Claim
    measured: Text
    readings: Mapping[str, Numbers]

    @property
    def verdict(self) -> Verdict:
        """The verdict."""
        return judge(self.claim, self.readings)


@dataclass(frozen=True)
class Table:
    """A table.

    Args:
        caption: What it shows: mesh, step, settings.
        head: Heads of the columns.
        rows: Its cells.
    """

    caption: Text
    head: Sequence[Text]
    rows: Rows


@dataclass(frozen=True)
class Picture:
    """A picture.

    Args:
        name: Stem of its PNG file.
        caption: What it shows, with its settings.
        alt: The same for those who cannot see it.
        draw: Makes the figure; called within the package's style.
    """

    name: str
    caption: Text
    alt: str
    draw: Callable[[], Figure]


@dataclass(frozen=True)
class Difference:
    """A place where the paper and the numbers differ, for its authors to see.

    Args:
        title: In a few words, with section or equation.
        text: What the paper says, what was measured, and what could explain it.
        command: One command that shows it.
    """

    title: str
    text: Text
    command: str


@dataclass(frozen=True)
class Chapter:
    """One part of the page.

    Args:
        title: Its title, with the paper's section.
        introduction: What the paper says, in our words, with its equations.
        statements: Judged claims.
        tables: Tables.
        pictures: Pictures.
        differences: What goes into "Where the paper and the numbers differ".
        numbers: Every number of this chapter, for the JSON file.
        remarks: What else was seen, after the pictures.
        data: What goes into CSV files, by name: columns of one length, by name.
    """

    title: Text
    introduction: Text
    statements: Sequence[Statement]
    tables: Sequence[Table] = ()
    pictures: Sequence[Picture] = ()
    differences: Sequence[Difference] = ()
    numbers: Mapping[str, Any] = field(default_factory=dict)
    remarks: Text = ""
    data: Mapping[str, Mapping[str, Sequence[Any]]] = field(default_factory=dict)


@dataclass(frozen=True)
class Measured:
    """What the words, tables and pictures of a chapter are made of.

    Args:
        found: Outcomes of its jobs by name.
        numbers: Every number of the chapter, made of these.
        quick: Whether at the quick settings.
    """

    found: Mapping[str, Found]
    numbers: Mapping[str, Any]
    quick: bool
