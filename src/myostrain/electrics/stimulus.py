"""Stimuli: an applied rate of the potential in a place, over times."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from myostrain.electrics.place import Array, Place
from myostrain.geometry import Body
from myostrain.validation import Count, Finite, NonNegative, Positive, description

import numpy as np

Source = Callable[[Array, float], Array]
"""Applied rate of v at points (n, dim) and a time."""


class Applied(Protocol):
    """What the potential asks of a stimulus; a script may give its own."""

    def share(self, body: Body, space: Any) -> Array:
        """How strongly it acts at each node of a P1 space, (nodes,), fixed for the run."""
        ...

    def amount(self, time: float) -> float:
        """What it has added to v since time 0 where the share is one: the integral of its rate."""
        ...


@description
class Stimulus:
    """Rectangular pulses of a rate of v.

    Time steps need not hit the pulses' edges: what a pulse adds to v is exact whatever the steps, since
    its rate enters a step by the backward difference of its integral, as v itself does.

    Args:
        where: The place.
        strength: Rate of v, in units of v per unit of time.
        start: Time at which the first pulse begins.
        duration: Duration of a pulse.
        period: Time between the beginnings of two pulses, at least the duration; one pulse unless given.
        count: Number of pulses; with a period and without a count they go on for ever.
    """

    where: Place
    strength: Finite
    duration: Positive
    start: NonNegative = 0.0
    period: Positive | None = None
    count: Count | None = None

    def __post_init__(self) -> None:
        """Refuse pulses that overlap, or a count of them without a period."""
        if self.strength == 0:
            raise ValueError("strength = 0 does nothing; give another rate, or leave the stimulus out")
        if self.period is not None and self.period < self.duration:
            raise ValueError(f"period = {self.period} is shorter than duration = {self.duration}")
        if self.period is None and self.count is not None and self.count > 1:
            raise ValueError("several pulses need a period")

    def share(self, body: Body, space: Any) -> Array:
        """One in the place, zero elsewhere (nodes,)."""
        return self.where.share(body, space, "stimulus")

    def amount(self, time: float) -> float:
        """Integral of the rate from time 0 to ``time``."""
        elapsed = time - self.start
        if elapsed <= 0:
            return 0.0
        if self.period is None:
            return self.strength * min(elapsed, self.duration)
        # A pulse that has begun but for round-off has not begun.
        whole = int(np.floor(elapsed / self.period * (1 + 1e-14)))
        if self.count is not None and whole >= self.count:
            return self.strength * self.duration * self.count
        rest = max(elapsed - whole * self.period, 0.0)
        return self.strength * (whole * self.duration + min(rest, self.duration))


class AppliedRates:
    """The rate of v at the nodes that stimuli and a source apply together.

    Args:
        stimuli: The stimuli.
        source: Applied rate of v, a function of points (n, dim) and time that gives (n,); None for none.
        body: The reference body.
        space: P1 space whose nodes are meant.
    """

    def __init__(self, stimuli: Sequence[Applied], source: Source | None, body: Body, space: Any) -> None:
        self._source = source
        self._shares = [(stimulus, stimulus.share(body, space)) for stimulus in stimuli]
        self._points = space.tabulate_dof_coordinates()[:, : body.dim]

    def rate(self, times: Sequence[float], weights: Array) -> Array | float | None:
        """The rate (nodes,), None where nothing acts.

        Stimuli act by the backward difference of their integrals, the source by its value at the end.

        Args:
            times: The end of the step and past times, newest first, at least as many as weights.
            weights: Backward-difference weights.
        """
        found: Any = None if self._source is None else self._source(self._points, times[0])
        for stimulus, share in self._shares:
            rate = sum(w * stimulus.amount(t) for w, t in zip(weights, times, strict=False))
            if rate:
                found = rate * share if found is None else found + rate * share
        return found
