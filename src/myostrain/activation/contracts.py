"""What is asked of an activation law, an active deformation and an active tension."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

Drivers = Mapping[str, Any]
"""Values of the drivers by name: arrays (nodes,), and for "time" a number."""

Yield = Literal["strain", "tension"]


class ActivationLaw(Protocol):
    """How γ, or a tension, follows what drives it; pointwise, on arrays of nodal values.

    A law with a time of its own is a :class:`LawWithStates`. A law may also have ``yields``: "strain" for γ
    (negative contracts), which is so unless it says otherwise, or "tension" for a stress along the fibre; and
    ``units``, such as ``{"calcium": "μM", "time": "ms"}``, in which it wants drivers and the length of a
    step: they are converted, and a membrane that counts in something else is refused.
    """

    @property
    def drivers(self) -> Sequence[str]:
        """What drives it, by name.

        "potential", in the membrane's unit; "excitation", the potential as 0 at rest and 1 at the upper end
        of the membrane's range; "stretch" of the fibre, |F f0|; "time"; "calcium", the state that the
        membrane says it is; or the name of any state of the membrane.
        """
        ...

    def activation(self, states: Array, drivers: Drivers) -> Any:
        """γ or the tension, (nodes,), for states (states, nodes) and drivers at the same time."""
        ...


class LawWithStates(ActivationLaw, Protocol):
    """An activation law with states of its own."""

    @property
    def states(self) -> Sequence[str]:
        """Names of its states."""
        ...

    def initial_states(self, drivers: Drivers) -> Sequence[Any]:
        """Each state at the start, a number or (nodes,), for the drivers at the start."""
        ...

    def advance(self, states: Array, drivers: Drivers, step: float) -> Any:
        """The states after a step of time for frozen drivers, exact if the law has a closed form.

        Args:
            states: States before the step, (states, nodes): a copy, as all that a law gets.
            drivers: Drivers, frozen over the step: at its middle where the scheme is of second order.
            step: Length of the step.

        Returns:
            The states after it, (states, nodes).
        """
        ...


class ActiveDeformation(Protocol):
    """What an active strain does: Fo from γ."""

    def tensor(self, gamma: Any, fibres: Any) -> Any:
        """Fo for the active strain γ and the unit directions ``fibres.f0``, ``s0``, ``n0``, all UFL."""
        ...


class ActiveTension(Protocol):
    """What a tension does: an energy per reference volume whose derivative is the active stress."""

    def energy(self, F: Any, fibres: Any, tension: Any) -> Any:
        """Energy per reference volume for F in the dimension of materials, a UFL scalar."""
        ...
