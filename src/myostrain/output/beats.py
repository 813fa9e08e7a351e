"""Times of the beats of many points: of activation and of repolarisation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from myostrain.engine import MPI
from myostrain.state import State

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


class Beats:
    """Times by beat of n points: row k has each one's beat k, NaN where there is none.

    Args:
        n: Number of points.

    Attributes:
        times: The rows, (n,) each; one at least.
    """

    def __init__(self, n: int) -> None:
        self.times: list[Array] = [np.full(n, np.nan)]

    def clear(self) -> None:
        """Forget all times."""
        self.put(np.full((1, len(self.times[0])), np.nan))

    def put(self, times: Array) -> None:
        """Take times (beats, n)."""
        self.times = [row.copy() for row in times]

    def set(self, beats: Indices, points: Indices, times: Array) -> None:
        """Set the times (k,) of one beat each of some points (k,)."""
        for beat in np.unique(beats).tolist():
            while len(self.times) <= beat:
                self.times.append(np.full(len(self.times[0]), np.nan))
            these = beats == beat
            self.times[beat][points[these]] = times[these]

    def together(self, comm: Any) -> Array:
        """The times (beats, n), as many rows on every process (collective)."""
        rows = comm.allreduce(len(self.times), op=MPI.MAX)
        missing = np.full((rows - len(self.times), len(self.times[0])), np.nan)
        return np.vstack([*self.times, missing])


class Activations(Beats):
    """Times at which the values of n points rise through a threshold: a beat each.

    Args:
        n: Number of points.
        threshold: The threshold.

    Attributes:
        count: Beats of each point so far, (n,).
    """

    def __init__(self, n: int, threshold: float) -> None:
        super().__init__(n)
        self._threshold = threshold
        self.count: Indices = np.zeros(n, dtype=np.int64)

    def put(self, times: Array) -> None:
        """Take times (beats, n)."""
        super().put(times)
        self.count = (~np.isnan(times)).sum(axis=0)

    def start(self, values: Array, time: float) -> Indices:
        """Begin anew: what is above the threshold is activated now; returns which."""
        self.clear()
        return self._add(np.flatnonzero(values >= self._threshold), time)

    def observe(self, before: Array, now: Array, start: float, end: float) -> Indices:
        """Look at values (n,) before and after a step; returns which points were activated in it."""
        rises = np.flatnonzero((before < self._threshold) & (now >= self._threshold))
        return self._add(rises, _between(before[rises], now[rises], self._threshold, start, end))

    def _add(self, points: Indices, times: Any) -> Indices:
        self.set(self.count[points], points, np.broadcast_to(times, points.shape))
        self.count[points] += 1
        return points


class Repolarization:
    """Times at which the values of n points have fallen by a percentage of their amplitude, beat by beat.

    The amplitude of a beat is that of the point itself: from the lowest value since it was repolarised last
    (the membrane's rest if it never was) to the highest since its activation. Where it falls below the level
    more often than once in a beat, as behind a notch, the last time counts. It is linear in time between
    steps. A point that is activated again before it is repolarised has no time for the first of these beats.

    Args:
        n: Number of points.
        percents: Percentages, such as 90 for the end of an APD90.
        rest: The membrane's resting potential.

    Attributes:
        percents: The percentages.
        beats: The times by percentage.
    """

    def __init__(self, n: int, percents: Sequence[float], rest: float) -> None:
        self.percents, self._rest = tuple(percents), rest
        self._shares = np.array(self.percents) / 100
        self.beats = {percent: Beats(n) for percent in self.percents}
        self._clear(n)

    def _clear(self, n: int) -> None:
        self._peak = np.full(n, np.inf)  # of a point that was never activated
        self._low, self._base = np.full(n, self._rest), np.full(n, self._rest)
        self._levels = np.full((len(self.percents), n), -np.inf)
        self._above: Any = None  # whether each was above its levels, found when that is needed

    def start(self, values: Array, activated: Indices) -> None:
        """Begin anew with values (n,), of which some points are activated."""
        self._clear(len(values))
        for beats in self.beats.values():
            beats.clear()
        if self.percents:
            self._low = np.minimum(self._low, values)
            self._activate(activated)
            self._follow_peaks(values)

    def observe(
        self, before: Array, now: Array, start: float, end: float, seen: Activations, new: Any
    ) -> None:
        """Look at values (n,) before and after a step.

        Args:
            before: Values before the step.
            now: Values after it.
            start: Time before the step.
            end: Time after it.
            seen: The activations up to now.
            new: The points that were activated in this step.
        """
        if not self.percents:
            return
        if self._above is None:
            self._above = before >= self._levels
        self._activate(new)
        self._follow_peaks(now)
        np.minimum(self._low, now, out=self._low)
        last = max(self.percents)
        for row, (percent, level) in enumerate(zip(self.percents, self._levels, strict=True)):
            above = now >= level
            falls = np.flatnonzero(self._above[row] > above)
            self._above[row] = above
            if len(falls):
                times = _between(before[falls], now[falls], level[falls], start, end)
                self.beats[percent].set(seen.count[falls] - 1, falls, times)
                if percent == last:
                    self._low[falls] = now[falls]

    def _activate(self, points: Indices) -> None:
        self._base[points] = self._low[points]
        self._peak[points] = -np.inf

    def _follow_peaks(self, values: Array) -> None:
        higher = np.flatnonzero(values > self._peak)
        self._put_levels(higher, values)
        if self._above is not None:
            self._above[:, higher] = True

    def _put_levels(self, points: Indices, peaks: Array) -> None:
        self._peak[points] = peaks[points]
        height = peaks[points] - self._base[points]
        self._levels[:, points] = peaks[points] - self._shares[:, None] * height

    def state(self, pack: Callable[[Array], Any], comm: Any) -> State:
        """What goes on in a resumed run; ``pack`` makes values (n,) fit for a checkpoint (collective)."""
        kept = {"peak": self._peak, "low": self._low, "base": self._base} if self.percents else {}
        return {
            **{name: pack(values) for name, values in kept.items()},
            "times": {f"{p:g}": [pack(row) for row in self.beats[p].together(comm)] for p in self.percents},
        }

    def restore(self, state: State, unpack: Callable[[Any], Array]) -> None:
        """Go on from a state; a percentage that it has not begins with the next step."""
        if not (self.percents and "peak" in state):
            return
        self._low, self._base, peak = (unpack(state[name]).copy() for name in ("low", "base", "peak"))
        self._peak = peak.copy()
        self._put_levels(np.flatnonzero(np.isfinite(peak)), peak)
        for percent, beats in self.beats.items():
            if rows := state["times"].get(f"{percent:g}"):
                beats.put(np.array([unpack(row) for row in rows]))


def _between(before: Array, now: Array, level: Any, start: float, end: float) -> Array:
    """Times at which values pass a level between two times, linear in time."""
    return np.asarray(start + (level - before) / (now - before) * (end - start))
