"""Backward differences, each state linearised in itself."""

from collections.abc import Callable, Sequence
from typing import Any, ClassVar

from myostrain.membranes.contracts import Array, Membrane, Step
from myostrain.pointwise import Expression, derivative
from myostrain.validation import description

import numpy as np

#: Increment of the complex step: its square vanishes beside one, so that derivatives are exact to round-off.
COMPLEX_STEP = 1e-100


def with_slope(function: Any, at: Array) -> tuple[Array, Array]:
    """A pointwise function and its derivative, by one complex step."""
    value = function(at + 1j * COMPLEX_STEP)
    return np.real(value), np.imag(value) / COMPLEX_STEP


@description
class LinearlyImplicit:
    """One Newton correction a step and state, each state by itself, about the guess: for a few states.

    It has the order of the backward difference that the scheme takes, one or two.
    """

    order: ClassVar[int] = 2
    multistep: ClassVar[bool] = True

    def formula(
        self,
        rates: Callable[[Sequence[Expression]], Sequence[Expression]],
        guess: Sequence[Expression],
        history: Sequence[Expression],
        weight: Expression,
    ) -> list[Expression]:
        """The states after a step, as :meth:`advance` computes them, written down."""
        states = list(guess)
        for index, state in enumerate(guess):
            rate = rates(states)[index]
            slope = derivative(rate, state, fixed=states[:index])
            states[index] = state - (weight * state + history[index] - rate) / (weight - slope)
        return states

    def advance(self, membrane: Membrane, v: Array, states: Array, step: Step) -> Array:
        """Solve weight · s + history = rate(v, s) for each state in turn, linearised about its guess."""
        for index, state in enumerate(states):

            def rate(value: Any, index: int = index) -> Any:
                given = [value if i == index else s for i, s in enumerate(states)]
                return membrane.rates(v, given)[index]

            value, slope = with_slope(rate, state)
            residual = step.weight * state + step.history[index] - value
            states[index] -= residual / (step.weight - slope)
        return states
