"""What a rate by differences over past configurations keeps from one step to the next."""

from __future__ import annotations

from myostrain.engine import fem
from myostrain.state import FieldState, State


class Rate:
    """Weights of present and past values, and functions that hold the past.

    Attributes:
        functions: Functions of the past.
        weights: Constants.
    """

    functions: list[fem.Function]
    weights: list[fem.Constant]

    def clear(self) -> None:
        """No rate: a body at rest."""
        for weight in self.weights:
            weight.value = 0.0

    def state(self) -> State:
        """What the next step needs."""
        return {
            "fields": [FieldState.of(function) for function in self.functions],
            "weights": [float(weight.value) for weight in self.weights],
        }

    def restore(self, state: State) -> None:
        """Go on from a state."""
        for function, field in zip(self.functions, state["fields"], strict=True):
            field.put(function)
        for weight, value in zip(self.weights, state["weights"], strict=True):
            weight.value = value
