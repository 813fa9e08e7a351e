"""What a beat of a single cell measures."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: Percentages of repolarisation of the durations.
PERCENTS = (30, 50, 90)


def measure_beat(
    time: Array, values: Array, threshold: float, stimulus: tuple[float, float]
) -> tuple[dict[str, float | None], dict[str, str]]:
    """Numbers of a beat, and why some have no value.

    A beat is activated when v crosses the threshold. ``apd30``, ``apd50``, ``apd90`` are the times from there
    until v has fallen for the last time by that share of the way from the ``peak`` to ``rest``, the potential
    at the beginning; linear between steps. ``upstroke_velocity`` is the largest rate that the membrane's own
    current gives v, without what is applied. ``calcium_peak`` is at ``calcium_time`` after the beginning.

    Args:
        time: Times since the beginning of the stimulus (n,), the first one zero.
        values: Potential, and calcium if there is one, (1 or 2, n).
        threshold: The membrane's threshold.
        stimulus: Strength and duration of the stimulus.
    """
    v = values[0]
    strength, duration = stimulus
    rest, top = float(v[0]), int(np.argmax(v))
    peak = float(v[top])
    own = np.diff(v) / np.diff(time) - np.where(time[1:] <= duration * (1 + 1e-12), strength, 0.0)
    found: dict[str, float | None] = {f"apd{percent}": None for percent in PERCENTS}
    found |= {"peak": peak, "rest": rest, "upstroke_velocity": float(own.max())}
    found |= {"calcium_peak": None, "calcium_time": None}
    if len(values) > 1:
        highest = int(np.argmax(values[1]))
        found |= {"calcium_peak": float(values[1, highest]), "calcium_time": float(time[highest])}
    rises = np.flatnonzero((v[:-1] < threshold) & (v[1:] >= threshold))
    if not len(rises):
        why = (
            f"the potential is above the threshold {threshold:g} when the beat begins: a longer cycle"
            if rest >= threshold
            else f"the stimulus did not excite: the potential reached {peak:.4g}, below {threshold:g}"
        )
        found["upstroke_velocity"] = None
        return found, dict.fromkeys([*(f"apd{p}" for p in PERCENTS), "upstroke_velocity"], why)
    begin = _crossing(time, v, int(rises[0]), threshold)
    notes = {}
    for percent in PERCENTS:
        level = peak - percent / 100 * (peak - rest)
        falls = top + np.flatnonzero((v[top:-1] >= level) & (v[top + 1 :] < level))
        if len(falls):
            found[f"apd{percent}"] = _crossing(time, v, int(falls[-1]), level) - begin
        else:
            notes[f"apd{percent}"] = "the potential has not fallen so far when the next beat begins"
    return found, notes


def _crossing(time: Array, v: Array, index: int, level: float) -> float:
    share = (level - v[index]) / (v[index + 1] - v[index])
    return float(time[index] + share * (time[index + 1] - time[index]))
