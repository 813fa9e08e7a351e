"""Stimuli: an applied rate of the potential in a place, over times."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Protocol

from myostrain.electrics.arrival import spread, tabulated
from myostrain.electrics.place import Array, Place
from myostrain.geometry import Body
from myostrain.validation import Count, Finite, NonNegative, Positive, description

import numpy as np

Source = Callable[[Array, float], Array]
"""Applied rate of v at points (n, dim) and a time."""


class Applied(Protocol):
    """What the potential asks of a stimulus; a script may give its own.

    One that begins later at some nodes also gives ``delays(body, space)``, (nodes,) or None for none.
    """

    def share(self, body: Body, space: Any) -> Array:
        """How strongly it acts at each node of a P1 space, (nodes,), fixed for the run."""
        ...

    def amount(self, time: Any) -> Any:
        """What it has added to v since time 0 where the share is one: the integral of its rate.

        A number; of one with delays an array for an array of times.
        """
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
        times: A table (CSV) of activation times: each node of the place begins at ``start`` and its own
            time. Columns x, y, z, time: a node takes a mean of the eight nearest points, by inverse squares
            of the distances (R. Franke, G. Nielson, Int. J. Numer. Methods Eng. 15 (1980) 1691). Columns
            node, time: numbers of the nodes in the mesh's file, from 0.
        roots: Points of the part ``boundary``, from which a front runs over it, as from the ends of Purkinje
            fibres; each node of the place begins when the front has come to it.
        speed: Speed of that front.
        reached_in: In place of the speed: the time in which it comes to the last node.
    """

    where: Place
    strength: Finite
    duration: Positive
    start: NonNegative = 0.0
    period: Positive | None = None
    count: Count | None = None
    times: Path | None = None
    roots: tuple[tuple[Finite, ...], ...] | None = None
    speed: Positive | None = None
    reached_in: Positive | None = None

    def __post_init__(self) -> None:
        """Refuse pulses that overlap, a count of them without a period, and fronts that are not known."""
        if self.strength == 0:
            raise ValueError("strength = 0 does nothing; give another rate, or leave the stimulus out")
        if self.period is not None and self.period < self.duration:
            raise ValueError(f"period = {self.period} is shorter than duration = {self.duration}")
        if self.period is None and self.count is not None and self.count > 1:
            raise ValueError("several pulses need a period")
        if self.times is not None and self.roots is not None:
            raise ValueError("give times or roots, not both")
        if self.roots is not None:
            if not self.roots:
                raise ValueError("give one root or more")
            if self.where.boundary is None:
                raise ValueError("roots go with boundary: the surface over which the front runs")
            if (self.speed is None) == (self.reached_in is None):
                raise ValueError("roots go with one of speed and reached_in")
        elif self.speed is not None or self.reached_in is not None:
            raise ValueError("speed and reached_in are those of a front: they go with roots")

    def share(self, body: Body, space: Any) -> Array:
        """One in the place, zero elsewhere (nodes,)."""
        return self.where.share(body, space, "stimulus")

    def delays(self, body: Body, space: Any) -> Array | None:
        """By how much later than ``start`` each node begins (nodes,), infinite for never; None for nowhere.

        Raises:
            InputError: The table or the roots are not those of this body.
        """
        if self.times is not None:
            return tabulated(self.times, body, space, self.share(body, space), "stimulus.times")
        if self.roots is None or self.where.boundary is None:
            return None
        lengths = spread(body, space, self.where.boundary, self.roots, "stimulus.roots")
        if self.speed is not None:
            return lengths / self.speed
        most = np.where(self.share(body, space) > 0, lengths, 0.0).max(initial=0.0)
        return lengths * (self.reached_in or 1.0) / max(body.comm.allgather(float(most)))

    def amount(self, time: Any) -> Any:
        """Integral of the rate from time 0 to ``time``, a number or an array."""
        elapsed = np.maximum(np.asarray(time, dtype=float) - self.start, 0.0)
        if self.period is None:
            return self.strength * np.minimum(elapsed, self.duration)
        # A pulse that has begun but for round-off has not begun.
        whole = np.floor(elapsed / self.period * (1 + 1e-14))
        rest = np.clip(elapsed - whole * self.period, 0.0, self.duration)
        if self.count is not None:
            rest = np.where(whole < self.count, rest, 0.0)
            whole = np.minimum(whole, self.count)
        return self.strength * (whole * self.duration + rest)


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
        self._shares = [
            (stimulus, stimulus.share(body, space), _delays(stimulus, body, space)) for stimulus in stimuli
        ]
        self._points = space.tabulate_dof_coordinates()[:, : body.dim]

    def rate(self, times: Sequence[float], weights: Array) -> Array | float | None:
        """The rate (nodes,), None where nothing acts.

        Stimuli act by the backward difference of their integrals, the source by its value at the end.

        Args:
            times: The end of the step and past times, newest first, at least as many as weights.
            weights: Backward-difference weights.
        """
        found: Any = None if self._source is None else self._source(self._points, times[0])
        for stimulus, share, delay in self._shares:
            rate = sum(w * stimulus.amount(t - delay) for w, t in zip(weights, times, strict=False))
            if np.any(rate):
                found = rate * share if found is None else found + rate * share
        return found


def _delays(stimulus: Applied, body: Body, space: Any) -> Array | float:
    found = stimulus.delays(body, space) if hasattr(stimulus, "delays") else None
    return 0.0 if found is None else found
