"""Initial values of the potential and the membrane's states in a place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.electrics.place import Array, Place
from myostrain.errors import InputError, nearest
from myostrain.geometry import Body
from myostrain.validation import Finite, description


@description
class InitialValues:
    """Potential and states in a place, at the start; elsewhere the membrane is at rest.

    Args:
        where: The place.
        potential: v there; at rest unless given.
        states: Values of states there, by name; the others are at rest.
    """

    where: Place
    potential: Finite | None = None
    states: Mapping[str, Finite] | None = None

    def __post_init__(self) -> None:
        """Refuse values of nothing."""
        if self.potential is None and not self.states:
            raise ValueError("give potential, or states such as { recovery = 0.5 }")

    def apply(self, body: Body, space: Any, v: Array, states: Array, names: Sequence[str]) -> None:
        """Write the values into v (nodes,) and states (states, nodes).

        Raises:
            InputError: The place is none of this body, or a state is none of this membrane.
        """
        share = self.where.share(body, space, "initial")
        if self.potential is not None:
            v[:] = (1 - share) * v + share * self.potential  # exact where the share is 0 or 1
        for name, value in (self.states or {}).items():
            if name not in names:
                hint = nearest(name, names) if names else "this membrane has no states"
                raise InputError(f"'{name}' is not a state of the membrane; {hint}", "initial.states")
            row = states[list(names).index(name)]
            row[:] = (1 - share) * row + share * value
