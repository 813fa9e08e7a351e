"""What a current that stretch opens has to be to excite a membrane at rest, at a point."""

from __future__ import annotations

from typing import Any

import numpy as np

#: Potentials between rest and threshold at which the membrane's current is looked at.
SAMPLES = 20001


def least_drive(membrane: Any, reversal: float) -> float:
    """The g (√C − 1)/span from which on a membrane at rest has nowhere to stop before its threshold.

    With all states at rest the potential of a point that a stretch current drives to the reversal E stops
    where the current I(v) equals g (√C − 1)/span (E − v). There is no such v below the threshold if
    g (√C − 1)/span exceeds the largest I/(E − v) there: for cubic reactions a saddle–node bifurcation. States
    that recover on the way make the true threshold larger.

    Args:
        membrane: The model.
        reversal: E, beyond the threshold.

    Returns:
        That value, a rate.
    """
    rest, threshold = membrane.resting_potential(), membrane.threshold
    v = np.linspace(rest, min(threshold, reversal), SAMPLES)[1:-1]
    states = [np.full_like(v, state) for state in membrane.resting_states()]
    return float(np.max(np.asarray(membrane.current(v, states)) / (reversal - v)))


def least_drive_of_a_cubic(rate: float, threshold: float) -> float:
    """The same in closed form for the reaction rate · v (v − threshold)(v − 1) and E = 1: rate threshold²/4.

    The factor 1 − v is common to both sides, and v (threshold − v) is largest halfway to the threshold.

    Args:
        rate: A of FitzHugh–Nagumo, k of Aliev–Panfilov.
        threshold: α, or a.
    """
    return rate * threshold**2 / 4
