"""Cavities whose pressure, or whose volume, is given over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from myostrain.circulation.contracts import Array
from myostrain.course import Course, value_at
from myostrain.errors import InputError
from myostrain.validation import Level, description

import numpy as np


@description
class PrescribedPressure:
    """The pressure of a cavity is given.

    Args:
        pressure: The pressure: a number, or points (time, value) joined by straight lines.
    """

    pressure: Course
    cavities: ClassVar[int] = 1

    def tied(self, time: float, volumes: Array, pressures: Array) -> tuple[Array, Array, Array]:
        """What is zero where the pressure is the given one, and its derivatives."""
        return pressures - value_at(self.pressure, time), np.zeros((1, 1)), np.eye(1)


@description
class PrescribedVolume:
    """The volume of a cavity is given, and its pressure found.

    Args:
        volume: The volume: a number, or points (time, value) joined by straight lines.
    """

    volume: Course
    cavities: ClassVar[int] = 1

    def __post_init__(self) -> None:
        """Refuse what is not a volume.

        Raises:
            InputError: A volume is negative or zero.
        """
        course = self.volume
        for value in [value for _, value in course] if isinstance(course, Sequence) else [course]:
            if not value > 0:
                raise InputError(f"{value:g} is not a volume: give positive ones", "circulation.volume")

    def tied(self, time: float, volumes: Array, pressures: Array) -> tuple[Array, Array, Array]:
        """What is zero where the volume is the given one, and its derivatives."""
        return volumes - value_at(self.volume, time), np.eye(1), np.zeros((1, 1))


@description
class Isovolumetric:
    """Cavities without any flow: each keeps the volume that it has after the preload.

    Args:
        cavities: How many.
    """

    cavities: Level = 1
    states: ClassVar[tuple[str, ...]] = ()

    def initial_states(self, pressures: Array, volumes: Array) -> Array:
        """There are none."""
        return np.zeros(0)

    def rates(self, time: float, states: Array, pressures: Array) -> tuple[Array, Array]:
        """Nothing flows."""
        return np.zeros(0), np.zeros(self.cavities)
