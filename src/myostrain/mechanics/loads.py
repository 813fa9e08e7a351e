"""What pushes and pulls a body: follower pressures, dead tractions, body forces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Annotated, Any

from myostrain.course import Course, FunctionOfTime, value_at
from myostrain.errors import InputError
from myostrain.mechanics.bestel_2001_pressure import Bestel2001Pressure
from myostrain.mechanics.functions import check_with_functions
from myostrain.validation import Finite

import numpy as np
import numpy.typing as npt
from pydantic import AfterValidator, Discriminator, Tag

Vector = tuple[Finite, ...]


def _ascending(course: Any) -> Any:
    """Refuse points that are not a function of time, or vectors of several lengths."""
    if course and isinstance(course[0], tuple):
        if any(later[0] <= earlier[0] for earlier, later in pairwise(course)):
            raise ValueError("give points [time, vector] with ascending times")
        if len({len(vector) for _, vector in course}) > 1:
            raise ValueError("give vectors of one length")
    return course


VectorCourse = Annotated[Vector | tuple[tuple[Finite, Vector], ...], AfterValidator(_ascending)]
"""A vector over simulated time: its components, or points (time, vector) joined by straight lines."""


def _kind(given: Any) -> str:
    return "by an equation" if isinstance(given, Mapping | Bestel2001Pressure) else "by points"


PressureCourse = Annotated[
    Annotated[Course, Tag("by points")] | Annotated[Bestel2001Pressure, Tag("by an equation")],
    Discriminator(_kind),
]
"""A pressure over simulated time: a number, points (time, value), or the solution of an equation."""


@dataclass(frozen=True)
class Loads:
    """What pushes and pulls a body.

    Args:
        pressure: Follower pressure by named part, positive towards the body: P N = −p J F⁻ᵀ N. A number,
            points (time, value) joined by straight lines, or the table of a :class:`Bestel2001Pressure`; in a
            script also a function of the time.
        traction: Dead load by named part, per reference area: P N = t, a vector of the mesh's dimension
            (1 to 3), or points (time, vector); in a script also a function of the time.
        body_force: Dead load per reference volume, a UFL vector of the mesh's dimension; None for none.

    Raises:
        InputError: A value does not fit its type.
    """

    pressure: Mapping[str, PressureCourse] = field(default_factory=dict)
    traction: Mapping[str, VectorCourse] = field(default_factory=dict)
    body_force: Any = None

    def __post_init__(self) -> None:
        """Check the values."""
        check_with_functions(self, {"pressure": None, "traction": None})

    def check_dimension(self, dim: int) -> None:
        """Refuse vectors of another dimension than that of a mesh.

        Raises:
            InputError: There is one.
        """
        for part, course in self.traction.items():
            points: Any = course
            if isinstance(points, FunctionOfTime):
                points = tuple(np.atleast_1d(points.values(0.0)))
            vectors = [vector for _, vector in points] if _timed(points) else [points]
            if not vectors or any(len(vector) != dim for vector in vectors):
                raise InputError(
                    f"give {dim} numbers, such as {[0.1] * dim}, or points [time, {[0.1] * dim}], not "
                    f"{list(points)}",
                    f"mechanics.traction.{part}",
                )
        if self.body_force is not None and getattr(self.body_force, "ufl_shape", None) != (dim,):
            raise InputError(f"give a UFL vector of {dim} components", "mechanics.body_force")


def _timed(course: Any) -> bool:
    """Whether a vector is given by points over time."""
    return bool(course) and isinstance(course[0], tuple)


def components_of(course: VectorCourse) -> list[Course]:
    """The course of each component."""
    if not _timed(course):
        return [float(value) for value in course]  # type: ignore[arg-type]
    points: Any = course
    times, vectors = zip(*points, strict=True)
    return [tuple(zip(times, values, strict=True)) for values in zip(*vectors, strict=True)]


def vector_at(course: VectorCourse, time: float) -> npt.NDArray[np.float64]:
    """The vector at a time; before the first point and after the last one it is theirs."""
    if isinstance(course, FunctionOfTime):
        return np.atleast_1d(course.values(time))
    return np.array([value_at(component, time) for component in components_of(course)])


def times_of(loads: Loads) -> list[float]:
    """The times at which loads are given; zero where they are constant."""
    courses = [*loads.pressure.values(), *loads.traction.values()]
    timed: list[Any] = [course for course in courses if isinstance(course, tuple) and _timed(course)]
    solved = {course.t_dias for course in courses if isinstance(course, Bestel2001Pressure)}
    return sorted({point[0] for course in timed for point in course} | solved) or [0.0]
