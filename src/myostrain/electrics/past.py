"""What the potential keeps of the past: values of v and the membrane's states, and the amounts balanced."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

from myostrain.electrics.front import Front, Values
from myostrain.engine import MPI
from myostrain.errors import InputError
from myostrain.state import FieldState, State

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Past:
    """The last values of the potential and the states, newest first, with their times.

    A balance per volume is one of J (v − rest) and of J times the conserved states: these amounts are kept
    beside the values, since J was another one then.

    Args:
        rest: The potential at rest, a number or nodal values (nodes,).
        per_volume: Whether amounts are balanced; elsewhere they are the values themselves.
        conserved: Rows of the states whose amounts are balanced.
        multistep: Whether states of more than one past time are needed.

    Attributes:
        times: Times of what is kept, newest first.
        amounts: What is balanced, of each time.
        values: The potential and the states themselves, of each time; no states where none are needed.
        begun: What the last run began with, None before the first.
        front: What has a past of its own, between the nodes; None where nothing has.
    """

    front: Front | None = None

    def __init__(
        self, rest: float | Array, *, per_volume: bool, conserved: Sequence[int], multistep: bool
    ) -> None:
        self.rest, self.per_volume, self.multistep = rest, per_volume, multistep
        self.conserved = list(conserved)
        self._spare: list[Array] = []  # arrays for states that were given up
        self.reset()

    def clear(self) -> None:
        """Forget all past values."""
        self.times: list[float] = []
        self.amounts: list[Values] = []
        self.values: list[Values] = []
        if self.front is not None:
            self.front.clear()

    def reset(self) -> None:
        """Forget all past values, and what the last run began with."""
        self.begun: Values | None = None
        self.clear()

    def begin(self, v: Array, states: Array, comm: MPI.Comm) -> Values:
        """What a run begins with: the given values, but what the last step left is as that run began.

        Args:
            v: The present potential (nodes,); may be written to.
            states: The present states, likewise (states, nodes).
            comm: Processes that share the nodes.
        """
        if self.begun is not None and self.values:
            last_v, last_states = self.values[0]
            untouched = np.array([(v == last_v).all(), *(states == last_states).all(axis=1)])
            comm.Allreduce(MPI.IN_PLACE, untouched, op=MPI.LAND)
            if untouched[0]:
                v[:] = self.begun[0]
            states[untouched[1:]] = self.begun[1][untouched[1:]]
        self.begun = v, states
        return v, states.copy()

    def shorten(self) -> None:
        """Keep only the newest values."""
        self.amounts, self.values, self.times = self.amounts[:1], self.values[:1], self.times[:1]
        if self.front is not None:
            self.front.shorten()

    def push(self, time: float, v: Array, states: Array, ratio: Array, keep: int) -> None:
        """Take the values of a time, and keep ``keep`` of them.

        Args:
            time: The time.
            v: The potential (nodes,); kept itself, as are the states.
            states: The states (states, nodes).
            ratio: J at the nodes (nodes,).
            keep: How many times are kept.
        """
        keep_states = keep if self.multistep else 1
        amount, amounts = v, states
        if self.per_volume:
            amount = (v - self.rest) * ratio
            if self.multistep and self.conserved:
                amounts = states.copy()
                amounts[self.conserved] *= ratio
        for _, old in self.values[keep_states - 1 :]:
            fits = old.shape == states.shape  # not what stands for states that were not kept
            if fits and old is not states and all(old is not known for known in self._spare):
                self._spare = [old, *self._spare][:3]
        self.amounts = [(amount, amounts), *self.amounts[: keep - 1]]
        self.values = [(v, states), *self.values[: keep - 1]]
        for level in (self.amounts, self.values):
            level[keep_states:] = [(old, np.zeros((0, len(v)))) for old, _ in level[keep_states:]]
        self.times = [time, *self.times[: keep - 1]]
        if self.front is not None:
            self.front.accept(keep_states)

    def room(self, like: Array) -> Array:
        """An array for the states that nobody holds: one that was given up, or a new one."""
        for array in self._spare:
            # The list, this variable, and the argument of getrefcount hold it; a view would be one more.
            if sys.getrefcount(array) == 3:
                return array
        return np.empty_like(like)

    def set_apart(self, states: Array) -> None:
        """Keep a copy of the newest states where they are the very array that somebody may change."""
        if self.values and self.values[0][1] is states:
            self.values[0] = self.values[0][0], states.copy()

    def rate(self, weights: Array, ratio: Array) -> Array:
        """What past values of v (nodes,) add to its time derivative."""
        total = weights[1] * self.amounts[0][0]
        for w, (amount, _) in zip(weights[2:], self.amounts[1:], strict=False):
            total += w * amount
        if self.per_volume:
            total = total / ratio
            if np.any(self.rest):
                total -= weights[0] * self.rest
        return total

    def sums(self, weights: Array, ratio: Array) -> Array:
        """Weighted sums (states, nodes) of past values of each state, as they enter the step."""
        total = weights[1] * self.amounts[0][1]
        for w, (_, amounts) in zip(weights[2:], self.amounts[1:], strict=False):
            total += w * amounts
        if self.per_volume:
            total[self.conserved] /= ratio
        return total

    def extrapolate(self, weights: Array) -> tuple[Array, Array | None]:
        """Weighted sums of the values, newest first: v (nodes,), and the states if more than one is kept."""
        total = weights[0] * self.values[0][0]
        for w, (v, _) in zip(weights[1:], self.values[1:], strict=False):
            total += w * v
        if not self.multistep or not len(self.values[0][1]):
            return total, None
        states = weights[0] * self.values[0][1]
        for w, (_, past) in zip(weights[1:], self.values[1:], strict=False):
            states += w * past
        if self.front is not None:
            self.front.extrapolate(weights)
        return total, states

    def conserve(self, ratio: Array) -> Values:
        """The values of which the newest amounts are those of another J; they are the newest ones now."""
        amount, amounts = self.amounts[0]
        v, states = self.rest + amount / ratio, amounts.copy()
        states[self.conserved] /= ratio
        self.values[0] = v, states
        return v, states

    def state(self, space: Any) -> State:
        """Everything kept, as fields of a space."""
        return {
            "begun": fields(space, self.begun),
            "past": [fields(space, values) for values in self.amounts],
            "values": [fields(space, values) for values in self.values],
            "times": list(self.times),
            "front": None if self.front is None else self.front.state(),
        }

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self.amounts, self.values = ([values_of(one) for one in state[name]] for name in ("past", "values"))
        self.times = list(state["times"])
        self.begun = values_of(state["begun"]) if state["begun"] else None
        self._spare = []
        if self.front is not None:
            self.front.restore(state["front"])


def fields(space: Any, values: Values | None) -> list[FieldState]:
    """The potential and each state as fields of a space; none of nothing."""
    return [] if values is None else [FieldState(space, row) for row in (values[0], *values[1])]


def values_of(rows: list[FieldState]) -> Values:
    """The potential and the states that :func:`fields` made fields of."""
    v, *states = (row.values for row in rows)
    return v.copy(), np.array(states).reshape(-1, len(v))


def check_amounts(membrane: Any, integrator: Any, multistep: bool, reaction: str) -> None:
    """Refuse what does not balance the amount of a state where the volume changes.

    Args:
        membrane: A membrane with such a state.
        integrator: How its states advance.
        multistep: Whether that is by differences over past values.
        reaction: "nodal" or "interpolated".

    Raises:
        InputError: The amount of the state would not be balanced.
    """
    of = f"J {membrane.conserved[0]} of {type(membrane).__name__} where the volume changes"
    if not multistep:
        raise InputError(
            f"{type(integrator).__name__} does not balance {of}: take LinearlyImplicit, or balance = "
            '"advective"',
            "cell.integrator",
        )
    if reaction == "interpolated":
        raise InputError(
            f'"interpolated" does not balance {of}: take reaction = "nodal", or balance = "advective"',
            "potential.reaction",
        )
