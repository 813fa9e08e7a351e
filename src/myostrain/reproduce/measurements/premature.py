"""A premature stimulus in the wake of a wave on a clamped line: whether it is none, one way or both ways."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

from myostrain.reproduce.jobs import Array, Found
from myostrain.reproduce.measurements.matched import membrane_of
from myostrain.reproduce.measurements.signals import first_rise, last_fall
from myostrain.reproduce.measurements.stepping import along, stepped
from myostrain.reproduce.measurements.stretched_lines import contracting_line
from myostrain.state import State

import numpy as np

#: Delays after the upstroke that are looked at.
EARLIEST, LATEST = 10.0, 60.0
#: Places that a new wave must reach, as shares of the line; it starts in the middle.
BACK, FORTH = 1 / 6, 5 / 6
#: Time within which it must.
WITHIN = 40.0


class _Pulse:
    """A rate of the potential in the middle of the line, from a time on that is set before each use."""

    def __init__(self, middle: float, half: float, strength: float, lasting: float) -> None:
        self._middle, self._half, self._strength, self._lasting = middle, half, strength, lasting
        self.begin = np.inf

    def __call__(self, X: Array, time: float) -> Array:
        on = self.begin <= time <= self.begin + self._lasting
        return np.where(on & (np.abs(X[:, 0] - self._middle) <= self._half), self._strength, 0.0)


def window(
    membrane: Mapping[str, Any],
    conductance: float,
    beta: float,
    length: float,
    spacing: float,
    step: float,
    apart: float,
    strength: float,
    lasting: float,
    half: float,
) -> Found:
    """The vulnerable window: delays at which a stimulus in the wake starts a wave one way only.

    A wave runs along a line that is clamped at both ends and contracts, so that the wave stretches what is
    at rest. A stimulus follows in the middle. Too early there is no wave, late waves run both ways, and
    between only the one back into what has recovered for longer: the block that re-entry begins with.

    Args:
        membrane: "model" and parameters.
        conductance: g of the stretch current.
        beta: γ = −βv.
        length: Of the line.
        spacing: Of its nodes.
        step: Time step.
        apart: Delays are multiples of this, and the borders are found to it.
        strength: Rate of the stimulus.
        lasting: Its duration.
        half: Half length of the part that gets it.

    Returns:
        Numbers: ``upstroke`` of the middle by the first wave, and its ``duration`` there; the delays after
        that upstroke from which on a wave runs ``back``, and ``forth`` too; None for none; the ``width``
        between them.
    """
    pulse = _Pulse(length / 2, half, strength, lasting)
    model = contracting_line(membrane_of(membrane), conductance, True, beta, length, spacing, source=pulse)
    potential = model.potential
    X, v = along(potential), potential.v.x.array
    middle, back, forth = (np.abs(X - share * length).argmin() for share in (0.5, BACK, FORTH))
    model.start()
    times, course = [0.0], [float(v[middle])]
    kept: dict[int, State] = {}
    upstroke, every = None, round(apart / step)
    for time in stepped(model, step, 2 * LATEST):
        times.append(time)
        course.append(float(v[middle]))
        if upstroke is None:
            upstroke = first_rise(np.array(times), np.array(course), potential.threshold)
            begun = len(times) - 1
        elif time - upstroke > LATEST:
            break
        elif (len(times) - 1 - begun) % every == 0 and time - upstroke >= EARLIEST:
            kept[len(times) - 1] = model.state()
    if upstroke is None:
        return Found(dict.fromkeys(("upstroke", "duration", "back", "forth", "width")))
    fall = last_fall(np.array(times), np.array(course), potential.threshold)

    @cache
    def reaches(number: int) -> tuple[bool, bool]:
        """Whether a stimulus from this step on sends a wave back, and forth."""
        model.restore(kept[number])
        pulse.begin = times[number]
        low, found = v < potential.threshold, np.zeros(len(v), dtype=bool)
        for _ in stepped(model, step, times[number] + WITHIN, times[number]):
            above = v >= potential.threshold
            found |= low & above
            low |= ~above
            if found[back] and found[forth]:
                break
        return bool(found[back]), bool(found[forth])

    starts = [_first(sorted(kept), reaches, way) for way in (0, 1)]
    delays = [None if number is None else times[number] - upstroke for number in starts]
    width = None if delays[0] is None or delays[1] is None else delays[1] - delays[0]
    return Found(
        {
            "upstroke": upstroke,
            "duration": None if fall is None else fall - upstroke,
            "back": delays[0],
            "forth": delays[1],
            "width": width,
        }
    )


def _first(numbers: list[int], ways: Callable[[int], tuple[bool, bool]], way: int) -> int | None:
    """The first number from which on this way is reached, by halving; None for none."""
    if not ways(numbers[-1])[way]:
        return None
    low, high = -1, len(numbers) - 1
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if ways(numbers[middle])[way] else (middle, high)
    return numbers[high]
