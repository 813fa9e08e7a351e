"""Pressure over one beat by a switched relaxation."""

from __future__ import annotations

from functools import lru_cache

from myostrain.activation.bestel_2001 import SAMPLES, Solved, check_times, step_up, switched
from myostrain.validation import Finite, NonNegative, Positive, description

import numpy as np


@description
class Bestel2001Pressure:
    """The pressure in a cavity: p′ = −|b(t)| p + σ_mid max(b(t), 0) + σ_pre g(t), p(0) = 0.

    b(t) = a(t) + α_pre g(t) + α_mid, with a(t) as in :class:`~myostrain.activation.Bestel2001` and
    g(t) = S(t_dias − t): it rises slowly before systole, quickly within it, and falls with diastole.

    Source: as there; the defaults are the parameters of Aróstica and others 2025, in Pa and s.

    Args:
        sigma_pre: σ_pre, a pressure over a time.
        sigma_mid: σ_mid, a pressure.
        alpha_pre: α_pre, a rate.
        alpha_mid: α_mid, a rate.
        t_sys: When systole begins, as all times in the case's unit of time.
        t_dias: When diastole begins, later.
        gamma: Width γ of the switches.
        a_max: Rate of the rise.
        a_min: Minus the rate of the fall.
    """

    sigma_pre: NonNegative = 7000.0
    sigma_mid: NonNegative = 16000.0
    alpha_pre: Finite = 5.0
    alpha_mid: Finite = 1.0
    t_sys: Finite = 0.17
    t_dias: Finite = 0.484
    gamma: Positive = 0.005
    a_max: NonNegative = 5.0
    a_min: Finite = -30.0

    def __post_init__(self) -> None:
        """Refuse a beat that ends before it begins."""
        check_times(self)

    def at(self, time: float) -> float:
        """The pressure at a time."""
        return _course(self).at(time)


@lru_cache(maxsize=8)
def _course(law: Bestel2001Pressure) -> Solved:
    def before(t: np.ndarray) -> np.ndarray:
        return step_up(law.t_dias - t, law.gamma)

    def rate(t: np.ndarray) -> np.ndarray:
        return np.asarray(switched(t, law) + law.alpha_pre * before(t) + law.alpha_mid)

    return Solved(
        rate,
        lambda t: law.sigma_mid * np.maximum(rate(t), 0.0) + law.sigma_pre * before(t),
        law.gamma / SAMPLES,
    )
