"""Values over simulated time: numbers, or points joined by straight lines."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Protocol, runtime_checkable

from myostrain.errors import InputError
from myostrain.validation import Finite

import numpy as np
from pydantic import AfterValidator


def _ascending(course: float | tuple[tuple[float, float], ...]) -> float | tuple[tuple[float, float], ...]:
    """Refuse points that are no function of time."""
    if isinstance(course, Sequence):
        times = [point[0] for point in course]
        if not times or any(later <= earlier for earlier, later in pairwise(times)):
            raise ValueError("give points [time, value] with ascending times")
    return course


Course = Annotated[Finite | tuple[tuple[Finite, Finite], ...], AfterValidator(_ascending)]
"""A value over simulated time: a number, or points (time, value) joined by straight lines."""


@runtime_checkable
class Solution(Protocol):
    """A value over simulated time by an equation of its own."""

    def at(self, time: float) -> float:
        """The value at a time."""
        ...


def check_course(course: Course, key: str) -> None:
    """Refuse points that are no function of time.

    Raises:
        InputError: There is none, or their times do not ascend.
    """
    try:
        _ascending(course)
    except ValueError as error:
        raise InputError(f"{error}, not {course}", key) from None


def value_at(course: Course | Solution, time: float) -> float:
    """The value at a time; before the first point and after the last one it is theirs."""
    if isinstance(course, Solution):
        return course.at(time)
    if not isinstance(course, Sequence):
        return float(course)
    times, values = np.array(course).T
    return float(np.interp(time, times, values))


def missed_peaks(course: Course | Solution, step: float, end: float) -> list[tuple[float, float]]:
    """Peaks (time, value) of a course that lie between two steps, so that nothing sees them.

    Args:
        course: The course.
        step: Time step.
        end: Time at which the run ends.
    """
    if not isinstance(course, Sequence):
        return []
    found = []
    for (_, before), (time, value), (_, after) in zip(course, course[1:], course[2:], strict=False):
        peak = (value - before) * (value - after) > 0
        steps = time / step
        if peak and 0 < time < end and abs(steps - round(steps)) > 1e-6:
            found.append((float(time), float(value)))
    return found
