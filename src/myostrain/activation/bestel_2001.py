"""Tension over one beat by a switched relaxation."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, ClassVar

from myostrain.activation.contracts import Yield
from myostrain.validation import Finite, NonNegative, Positive, description

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: Samples of a course in the width of a switch; the quadrature between two errs by some 1e-6.
SAMPLES = 100


class Solved:
    """The solution of y′ = −|r(t)| y + s(t), y(0) = 0, by a table that grows as it is asked for.

    Between two samples the equation is integrated with its exponential, |r| and s by Simpson's rule.

    Args:
        rate: r, for an array of times.
        source: s, likewise.
        sample: Time between two samples.
    """

    def __init__(
        self, rate: Callable[[Array], Array], source: Callable[[Array], Array], sample: float
    ) -> None:
        self._rate, self._source, self._sample = rate, source, sample
        self._values = [0.0]

    def at(self, time: float) -> float:
        """The value at a time; zero before 0."""
        if time <= 0:
            return 0.0
        place = time / self._sample
        self._grow(int(place) + 2)
        before = int(place)
        first, second = self._values[before : before + 2]
        return first + (place - before) * (second - first)

    def _grow(self, count: int) -> None:
        have, h = len(self._values), self._sample
        if have >= count:
            return
        t = h * np.arange(have - 1, count - 1)[:, None] + h * np.array([0.0, 0.25, 0.5, 0.75, 1.0])
        r, s = np.abs(self._rate(t)), self._source(t)
        halves = h / 12 * (r[:, :4:2] + 4 * r[:, 1::2] + r[:, 2::2])  # ∫ |r| over each half
        left = np.exp(-halves.sum(axis=1))
        gained = h / 6 * (s[:, 0] * left + 4 * s[:, 2] * np.exp(-halves[:, 1]) + s[:, 4])
        value = self._values[-1]
        for share, more in zip(left.tolist(), gained.tolist(), strict=True):
            value = share * value + more
            self._values.append(value)


def step_up(t: Array, gamma: float) -> Array:
    """½ (1 + tanh(t/γ))."""
    return np.asarray((1 + np.tanh(t / gamma)) / 2)


def switched(t: Array, law: Any) -> Array:
    """The rate a_max f + a_min (1 − f), f being one between t_sys and t_dias and zero elsewhere."""
    f = step_up(t - law.t_sys, law.gamma) * step_up(law.t_dias - t, law.gamma)
    return np.asarray(law.a_max * f + law.a_min * (1 - f))


@description
class Bestel2001:
    """A tension over one beat: T′ = −|a(t)| T + σ₀ max(a(t), 0), T(0) = 0.

    a(t) = a_max f(t) + a_min (1 − f(t)) with f(t) = S(t − t_sys) S(t_dias − t), S(t) = ½ (1 + tanh(t/γ)):
    between systole and diastole T rises to σ₀ at the rate a_max, elsewhere it falls at the rate |a_min|.
    The same in the whole body, but for ``activation.transmural``. It is solved once, whatever the time step.

    Sources: J. Bestel, F. Clément, M. Sorine, MICCAI 2001, Lect. Notes Comput. Sci. 2208, 1159–1161,
    doi 10.1007/3-540-45468-3_143; as in R. Aróstica and others, Comput. Methods Appl. Mech. Eng. 435 (2025)
    117485, doi 10.1016/j.cma.2024.117485, of which the defaults are the parameters, in Pa and s.

    Args:
        sigma_0: σ₀, a stress, positive.
        t_sys: When systole begins, as all times in the case's unit of time.
        t_dias: When diastole begins, later.
        gamma: Width γ of the switches.
        a_max: Rate of the rise, zero or more.
        a_min: Minus the rate of the fall, zero or less.
    """

    sigma_0: Positive = 150e3
    t_sys: Finite = 0.16
    t_dias: Finite = 0.484
    gamma: Positive = 0.005
    a_max: NonNegative = 5.0
    a_min: Finite = -30.0
    drivers: ClassVar[tuple[str, ...]] = ("time",)
    yields: ClassVar[Yield] = "tension"

    def __post_init__(self) -> None:
        """Refuse a beat that ends before it begins."""
        check_times(self)

    def activation(self, states: Any, drivers: Any) -> Any:
        """The tension at the time, a number for all nodes."""
        return _course(self).at(float(drivers["time"]))


def check_times(law: Any) -> None:
    """Refuse a beat that ends before it begins, and a fall that rises.

    Raises:
        ValueError: It is one.
    """
    if not law.t_sys < law.t_dias:
        raise ValueError(f"t_dias = {law.t_dias} should be later than t_sys = {law.t_sys}")
    if law.a_min > 0:
        raise ValueError(f"a_min = {law.a_min} should be zero or less")


@lru_cache(maxsize=8)
def _course(law: Bestel2001) -> Solved:
    return Solved(
        lambda t: switched(t, law),
        lambda t: law.sigma_0 * np.maximum(switched(t, law), 0.0),
        law.gamma / SAMPLES,
    )
