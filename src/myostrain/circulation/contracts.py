"""What a 0D model says of the pressures and volumes of cavities."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Circulation(Protocol):
    """What cavities are connected to: it says how fast they fill at given pressures.

    Volumes, pressures and times are in the units of the case: with mm, kPa and ms a flow is in mm³/ms. A
    model is advanced implicitly, together with the wall (:class:`~myostrain.circulation.Circuit`), so that
    stiff equations and valves that open at once need no care.
    """

    @property
    def cavities(self) -> int:
        """How many cavities it is connected to; a class variable will do."""
        ...

    @property
    def states(self) -> tuple[str, ...]:
        """Names of its states, such as the pressure in an artery; a class variable will do."""
        ...

    def initial_states(self, pressures: Array, volumes: Array) -> Any:
        """The states (states,) at the beginning, for the cavities' pressures and volumes (cavities,)."""
        ...

    def rates(self, time: float, states: Array, pressures: Array) -> tuple[Any, Any]:
        """The rates (states,) of the states, and the net flows (cavities,) into the cavities.

        Args:
            time: Simulated time.
            states: The states (states,).
            pressures: Pressures (cavities,) in the cavities.
        """
        ...


class Prescribed(Protocol):
    """What ties a cavity's volume or pressure to a time, without states and flows."""

    @property
    def cavities(self) -> int:
        """How many cavities it prescribes."""
        ...

    def tied(self, time: float, volumes: Array, pressures: Array) -> tuple[Array, Array, Array]:
        """What is zero (cavities,) where it holds, and its derivatives (cavities, cavities).

        Args:
            time: Simulated time.
            volumes: Volumes (cavities,).
            pressures: Pressures (cavities,).

        Returns:
            The values, their derivatives by the volumes, and those by the pressures.
        """
        ...
