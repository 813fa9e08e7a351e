"""What is asked of a membrane model, and of what integrates its states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Membrane(Protocol):
    """A membrane model: equations only, pointwise, with du/dt = −current + what is applied and diffused.

    A class of your own may inherit from this one; what it does not say is then that of a non-dimensional
    model between 0 and 1.

    Attributes:
        states: Names of the state variables; none for a model of the potential alone.
        time_unit: Unit of time, "ms" or "s"; None for a non-dimensional model.
        potential_unit: Unit of the potential, such as "mV"; None for a non-dimensional model.
        range: Lowest and highest potential to expect: what pictures show, and over what activation laws are
            judged.
        threshold: The potential above which a node counts as activated.
        calcium: Name of the state that is the calcium which drives contraction; None without.
        calcium_unit: Its unit, such as "μM".
        gates: Names of the states that are probabilities; one that leaves [0, 1] ends a run with a message.
        conserved: Names of the states that the conservative balance counts per spatial volume, as the
            paper's w (2.8). Others, such as gates, belong to material points and know no J.
        pacing: Strength (rate of v) and duration of the stimulus that excites a single cell.
    """

    @property
    def states(self) -> Sequence[str]:
        """Names of the state variables."""
        return ()

    @property
    def time_unit(self) -> str | None:
        """Unit of time."""
        return None

    @property
    def potential_unit(self) -> str | None:
        """Unit of the potential."""
        return None

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest potential to expect."""
        return (0.0, 1.0)

    @property
    def threshold(self) -> float:
        """The potential above which a node counts as activated."""
        return 0.5

    @property
    def calcium(self) -> str | None:
        """Name of the state that is the calcium."""
        return None

    @property
    def calcium_unit(self) -> str | None:
        """Unit of the calcium."""
        return None

    @property
    def gates(self) -> Sequence[str]:
        """Names of the states that stay in [0, 1]."""
        return ()

    @property
    def conserved(self) -> Sequence[str]:
        """Names of the states that are balanced per spatial volume."""
        return ()

    @property
    def pacing(self) -> tuple[float, float] | None:
        """Strength and duration of the stimulus that excites a single cell."""
        return None

    def resting_potential(self) -> float:
        """The potential at rest."""
        return 0.0

    def resting_states(self) -> Sequence[float]:
        """Value of each state at rest."""
        return ()

    def current(self, v: Any, states: Any) -> Any:
        """Ionic current (nodes,), a rate of v, for v (nodes,) and states (states, nodes)."""
        ...

    def rates(self, v: Any, states: Any) -> Any:
        """Time derivative of each state, a sequence of (nodes,)."""
        return ()


@dataclass(frozen=True)
class Step:
    """A step of time as an integrator sees it.

    Args:
        length: Its length.
        weight: Backward-difference weight of the new value.
        history: Weighted sum of the past values of each state, (states, nodes): ds/dt ≈ weight s + history.
        before: States before the step, (states, nodes).
        potential: Potential before the step, (nodes,).
        order: Order in time of the scheme that takes the step; an integrator may have less.
    """

    length: float
    weight: float
    history: Array
    before: Array
    potential: Array
    order: int = 2


class Integrator(Protocol):
    """How the states of a membrane advance over a step.

    The integrators that ship also have ``formula``, which writes the step down in symbols, so that it is
    compiled. One of a script needs :meth:`advance` only.

    Attributes:
        order: Its order in time, if the potential is given to that order.
    """

    @property
    def order(self) -> int:
        """Its order in time."""
        ...

    def advance(self, membrane: Membrane, v: Array, states: Array, step: Step) -> Array:
        """The states after a step, (states, nodes).

        Args:
            membrane: The model.
            v: Potential at the end of the step (nodes,), extrapolated or iterated.
            states: A first guess (states, nodes); may be changed in place.
            step: The step.
        """
        ...
