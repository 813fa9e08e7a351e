"""Values over simulated time: numbers, points joined by straight lines, functions of a script."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, Protocol, runtime_checkable

from myostrain.errors import ComputationError, InputError, shown
from myostrain.validation import Finite

import numpy as np
import numpy.typing as npt
from pydantic import AfterValidator


def _ascending(course: float | tuple[tuple[float, float], ...]) -> float | tuple[tuple[float, float], ...]:
    """Refuse points that are not a function of time."""
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


@dataclass(frozen=True)
class FunctionOfTime:
    """A number or a vector over simulated time by a function of a script, which is called with the time.

    Args:
        function: The function.
        key: What it stands for, for messages.
        lowest: The least value that is allowed; None for any.

    Raises:
        InputError: It cannot be called with a time, or gives no finite numbers at time 0.
    """

    function: Callable[[float], Any]
    key: str
    lowest: float | None = None

    def __post_init__(self) -> None:
        """Call it once."""
        try:
            wrong = self._wrong(np.asarray(self.function(0.0), dtype=float))
        except Exception as error:  # noqa: BLE001 - whatever the script raises
            wrong = f"it raises {type(error).__name__}: {error}"
        if wrong:
            raise InputError(
                f"give a number, points, or a function of the time alone, such as lambda t: 0.1 * t; at "
                f"t = 0 {wrong}",
                self.key,
            )

    def _wrong(self, value: npt.NDArray[np.float64]) -> str:
        if value.ndim > 1 or not np.isfinite(value).all():
            return f"it is {shown(value.tolist())}"
        if self.lowest is not None and (value < self.lowest).any():
            return f"it is {shown(value.tolist())}, and may not be below {self.lowest:g}"
        return ""

    def values(self, time: float) -> npt.NDArray[np.float64]:
        """The number () or vector (n,) at a time.

        Raises:
            ComputationError: It is not finite, or too low.
        """
        value = np.asarray(self.function(time), dtype=float)
        if wrong := self._wrong(value):
            raise ComputationError(f"{self.key} as the script gives it: {wrong}", time=time)
        return value

    def at(self, time: float) -> float:
        """The number at a time.

        Raises:
            ComputationError: See :meth:`values`.
        """
        return float(self.values(time))


def is_function(given: Any) -> bool:
    """Whether a script gives a function of time."""
    return isinstance(given, FunctionOfTime) or (callable(given) and not isinstance(given, Solution | type))


def wrapped(given: Any, key: str, lowest: float | None = None) -> Any:
    """What a script gives, functions of time wrapped, in a mapping too.

    Raises:
        InputError: One is not a function of time.
    """
    if isinstance(given, FunctionOfTime):
        return given
    if isinstance(given, Mapping):
        return {name: wrapped(value, f"{key}.{name}", lowest) for name, value in given.items()}
    return FunctionOfTime(given, key, lowest) if is_function(given) else given


def without_functions(given: Any) -> Any:
    """The same without functions: of a mapping what is left, zero in place of a single one."""
    if isinstance(given, Mapping):
        return {name: without_functions(value) for name, value in given.items() if not is_function(value)}
    return 0.0 if is_function(given) else given


def with_functions(checked: Any, given: Any) -> Any:
    """What :func:`without_functions` took away, put back in its place."""
    if isinstance(given, Mapping):
        return {
            name: with_functions(checked.get(name), value) if isinstance(checked, Mapping) else value
            for name, value in given.items()
        }
    return given if isinstance(given, FunctionOfTime) else checked


def check_course(course: Course, key: str) -> None:
    """Refuse points that are not a function of time.

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
