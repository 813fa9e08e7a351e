"""Membrane models: one a file.

A model is pointwise: ``states`` names its state variables, ``initial_states()`` gives their resting values,
``rates(v, states)`` their time derivatives and ``current(v, states)`` the ionic current, so that at a point
dv/dt = −current. Both are plain arithmetic or NumPy functions of arrays of nodal values; derivatives are
taken by the complex step, so they must be analytic (no ``abs``; comparisons and ``numpy.where`` are fine).
"""

from collections.abc import Sequence
from typing import Any, Protocol

from myostrain.membranes.fitzhugh_nagumo import FitzHughNagumo


class CellModel(Protocol):
    """What the potential asks of a membrane model."""

    @property
    def states(self) -> Sequence[str]:
        """Names of the state variables; empty for a model of the potential alone."""
        ...

    def resting_potential(self) -> float:
        """The potential at rest."""
        ...

    def initial_states(self) -> Sequence[float]:
        """Resting value of each state."""
        ...

    def current(self, v: Any, states: Sequence[Any]) -> Any:
        """Ionic current: at a point, dv/dt = −current."""
        ...

    def rates(self, v: Any, states: Sequence[Any]) -> Sequence[Any]:
        """Time derivative of each state."""
        ...


__all__ = ["CellModel", "FitzHughNagumo"]
