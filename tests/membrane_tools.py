"""A membrane without a body, by an integrator that is none of ours; what a beat measures."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class Beat:
    """The last of several beats, over the time since its stimulus began.

    Args:
        time: Sampled times; in them the first 30 units are finer.
        values: Potential and states (1 + states, times).
        rest: Potential at the beginning of the beat.
        apd: Time from the steepest upstroke until nine tenths of the way from the peak to rest.
        crossing_apd: The same from the upward crossing of the threshold.
    """

    time: np.ndarray
    values: np.ndarray
    rest: float
    apd: float
    crossing_apd: float

    @property
    def peak(self):
        return self.values[0].max()


def slopes(membrane, y, stimulus=0.0):
    """Time derivative of potential and states; du/dt is minus the current, plus what is applied."""
    v, states = y[0], y[1:]
    return np.array([stimulus - membrane.current(v, states), *membrane.rates(v, states)], dtype=float)


def last_beat(membrane, cycle, beats, method="RK45", fine=0.01, coarse=0.1):
    """Pace a membrane from rest with its own stimulus, and measure the last beat."""
    strength, duration = membrane.pacing
    y = np.array([membrane.resting_potential(), *membrane.resting_states()])
    early = np.arange(0.0, duration, fine)
    later = np.concatenate([np.arange(duration, 0.03 * cycle, fine), np.arange(0.03 * cycle, cycle, coarse)])
    for beat in range(beats):
        rest, found = y[0], []
        for begin, end, times, applied in ((0.0, duration, early, strength), (duration, cycle, later, 0.0)):
            part = solve_ivp(
                lambda t, y, applied=applied: slopes(membrane, y, applied),
                (begin, end),
                y,
                method=method,
                t_eval=[*times, end] if beat == beats - 1 else [end],
                rtol=1e-8,
                atol=1e-10,
            )
            assert part.success
            y = part.y[:, -1]
            found.append(part.y[:, :-1])
    time, values = np.concatenate([early, later]), np.hstack(found)
    v = values[0]
    steepest = time[np.argmax(np.diff(v) / np.diff(time))] + fine / 2
    level = v.max() - 0.9 * (v.max() - rest)
    top = int(np.argmax(v))
    down = top + int(np.argmax(v[top:] < level))
    end = np.interp(-level, -v[down - 1 : down + 1], time[down - 1 : down + 1])
    up = int(np.argmax(v > membrane.threshold))
    crossing = np.interp(membrane.threshold, v[up - 1 : up + 1], time[up - 1 : up + 1])
    return Beat(time, values, rest, end - steepest, end - crossing)
