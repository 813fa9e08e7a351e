"""Claims of the paper as data, and the verdict on each: a function of numbers alone."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any, Literal

Kind = Literal["agrees", "agrees with a reading", "does not agree"]

#: Measured numbers by name; None or NaN where one does not exist.
Numbers = Mapping[str, float | None]


@dataclass(frozen=True)
class Claim:
    """One statement of the paper that has a number, or can be given one.

    Args:
        name: Its name in ``cases/paper/CHAPTER.toml``.
        where: Equation, section or figure of the paper.
        quote: The paper's words, or the equation.
        bounds: By the name of a measured number, the least and the largest value that bears the claim out.
        because: Why these bounds.
        answer: Where the paper asks: the answer that is judged in place of its words.
        source: Whose the answer is: ours, the paper's, that of others.
        sure: How sure it is.
    """

    name: str
    where: str
    quote: str
    bounds: Mapping[str, tuple[float, float]]
    because: str
    answer: str = ""
    source: str = ""
    sure: str = ""

    def holds(self, numbers: Numbers) -> bool:
        """Whether every number exists and lies within its bounds."""
        return not self.failing(numbers)

    def failing(self, numbers: Numbers) -> dict[str, float | None]:
        """Those of its numbers that do not exist or lie outside of their bounds."""
        return {name: numbers[name] for name in self.bounds if not _within(numbers[name], self.bounds[name])}


@dataclass(frozen=True)
class Verdict:
    """Whether the numbers bear a claim out.

    Args:
        kind: "agrees": as printed; "agrees with a reading": with the first such of the readings given;
            "does not agree": with none.
        reading: The reading it agrees with, or the printed one.
        numbers: The numbers that were judged, of that reading.
    """

    kind: Kind
    reading: str
    numbers: dict[str, float | None]


def judge(claim: Claim, readings: Mapping[str, Numbers]) -> Verdict:
    """Judge a claim by what was measured.

    Args:
        claim: The claim.
        readings: Measured numbers by reading, the printed one first. Each must have all numbers that the
            claim is about.

    Raises:
        KeyError: A reading lacks a number.
    """
    printed, *_ = readings
    for reading, numbers in readings.items():
        if claim.holds(numbers):
            kind: Kind = "agrees" if reading == printed else "agrees with a reading"
            return Verdict(kind, reading, _judged(claim, numbers))
    return Verdict("does not agree", printed, _judged(claim, readings[printed]))


def _judged(claim: Claim, numbers: Numbers) -> dict[str, float | None]:
    return {name: numbers[name] for name in claim.bounds}


def _within(value: float | None, bounds: tuple[float, float]) -> bool:
    return value is not None and not math.isnan(value) and bounds[0] <= value <= bounds[1]


@cache
def paper(chapter: str) -> dict[str, Any]:
    """What ``cases/paper/CHAPTER.toml`` holds: claims, words and what was examined last."""
    file = resources.files("myostrain.cases.paper") / f"{chapter}.toml"
    return tomllib.loads(file.read_text(encoding="utf-8"))


def claims(chapter: str) -> dict[str, Claim]:
    """The claims of a chapter by name, in the order of ``cases/paper/CHAPTER.toml``."""
    return {
        name: Claim(
            name,
            entry["where"],
            entry["quote"],
            {key: (float(low), float(high)) for key, (low, high) in entry["bounds"].items()},
            entry["because"],
            **{key: entry[key] for key in ("answer", "source", "sure") if key in entry},
        )
        for name, entry in paper(chapter)["claims"].items()
    }
