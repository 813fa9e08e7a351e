"""Luo–Rudy membrane, phase I."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any, ClassVar

from myostrain.errors import InputError
from myostrain.membranes.equilibrium import equilibrium
from myostrain.validation import Finite, NonNegative, Positive, description

import numpy as np

#: Gas constant [J/(kmol K)], temperature [K] and Faraday's constant [C/mol]: RT/F in mV.
GAS, TEMPERATURE, FARADAY = 8314.0, 310.0, 96484.6

#: Steps of Newton's method for the steady calcium, which converges within ten.
NEWTON = 20


def _ratio(z: Any) -> Any:
    """z/(1 − exp(−z)), with its value at zero."""
    near = np.abs(z) < 1e-3
    apart = np.where(near, 1.0, z)
    return np.where(near, 1 + z / 2 + z * z / 12, -apart / np.expm1(-apart))


@description
class LuoRudy1991:
    """Luo and Rudy 1991: a guinea-pig ventricular cell, six currents, six gates and calcium; mV, ms and μM.

    As implemented in public codes that cite the paper, doi:10.1161/01.RES.68.6.1501. Currents are in μA/cm²,
    conductances in mS/cm², concentrations in mM but for the state "Cai", which is in μM.

    Args:
        g_Na: Conductance of the fast sodium current.
        g_si: Conductance of the slow inward current.
        g_K: Conductance of the time-dependent potassium current at Ko = 5.4; it goes with the root of Ko.
        g_K1: Conductance of the time-independent potassium current at Ko = 5.4; it goes with the root of Ko.
        g_Kp: Conductance of the plateau potassium current.
        g_b: Conductance of the background current.
        E_b: Reversal potential of the background current [mV].
        Ko: Potassium outside [mM].
        Ki: Potassium inside [mM].
        Nao: Sodium outside [mM].
        Nai: Sodium inside [mM].
        PR_NaK: Permeability of the time-dependent potassium channel for sodium, relative to potassium.
        C: Capacitance of the membrane [μF/cm²].
    """

    g_Na: NonNegative = 23.0
    g_si: NonNegative = 0.09
    g_K: NonNegative = 0.282
    g_K1: NonNegative = 0.6047
    g_Kp: NonNegative = 0.0183
    g_b: NonNegative = 0.03921
    E_b: Finite = -59.87
    Ko: Positive = 5.4
    Ki: Positive = 145.0
    Nao: Positive = 140.0
    Nai: Positive = 18.0
    PR_NaK: NonNegative = 0.01833
    C: Positive = 1.0
    states: ClassVar[tuple[str, ...]] = ("m", "h", "j", "d", "f", "X", "Cai")
    time_unit: ClassVar[str | None] = "ms"
    potential_unit: ClassVar[str | None] = "mV"
    range: ClassVar[tuple[float, float]] = (-90.0, 50.0)
    threshold: ClassVar[float] = -40.0
    calcium: ClassVar[str | None] = "Cai"
    calcium_unit: ClassVar[str | None] = "μM"
    gates: ClassVar[tuple[str, ...]] = ("m", "h", "j", "d", "f", "X")
    conserved: ClassVar[tuple[str, ...]] = ()
    pacing: ClassVar[tuple[float, float] | None] = (25.5, 2.0)

    @cached_property
    def _rest(self) -> tuple[float, ...]:
        """Potential and states at rest: the lowest potential at which the steady current turns outward."""
        v = np.linspace(-150.0, self.threshold, 2201)
        shut, open_ = (self.rates(v, [gate] * 6 + [0.1]) for gate in (0.0, 1.0))
        steady = [low / (low - high) for low, high in zip(shut[:6], open_[:6], strict=True)]
        calcium = np.full_like(v, 1e-6)
        for _ in range(NEWTON):  # from below, so that it rises to the solution of a convex equation
            rate = self.rates(v, [*steady, calcium])[6]
            calcium = calcium + rate / (1.30287 * self.g_si * steady[3] * steady[4] / calcium + 0.07)
        current = self.current(v, [*steady, calcium])
        turns = np.flatnonzero((current[:-1] <= 0) & (current[1:] > 0))
        if not len(turns):
            raise InputError(
                f"LuoRudy1991 has no rest below {self.threshold:g} mV with these parameters; change "
                "them by less",
                "cell.model",
            )
        near = turns[0]
        return equilibrium(self, v[near], [float(x[near]) for x in (*steady, calcium)])

    def resting_potential(self) -> float:
        """Where all currents balance [mV]; it follows from the parameters.

        Raises:
            InputError: They leave no rest.
        """
        return self._rest[0]

    def resting_states(self) -> tuple[float, ...]:
        """Gates and calcium at the resting potential."""
        return self._rest[1:]

    def _nernst(self, outside: Any, inside: Any) -> Any:
        return GAS * TEMPERATURE / FARADAY * np.log(outside / inside)

    def _slow_inward(self, v: Any, d: Any, f: Any, calcium: Any) -> Any:
        return self.g_si * d * f * (v - 7.7 + 13.0287 * np.log(1e-3 * calcium))

    def current(self, v: Any, states: Sequence[Any]) -> Any:
        """The six currents over the capacitance [mV/ms]."""
        m, h, j, d, f, X, calcium = states
        E_Na, E_K1 = self._nernst(self.Nao, self.Nai), self._nernst(self.Ko, self.Ki)
        E_K = self._nernst(self.Ko + self.PR_NaK * self.Nao, self.Ki + self.PR_NaK * self.Nai)
        potassium = np.sqrt(self.Ko / 5.4)
        sodium = self.g_Na * m**3 * h * j * (v - E_Na)
        # (exp(y) − 1)/y is one over the ratio at −y.
        rectified = 2.837 * 0.04 * np.exp(-0.04 * (v + 35.0)) / _ratio(-0.04 * (v + 77.0))
        time_dependent = self.g_K * potassium * X * np.where(v > -100.0, rectified, 1.0) * (v - E_K)
        alpha = 1.02 / (1 + np.exp(0.2385 * (v - E_K1 - 59.215)))
        beta = (0.49124 * np.exp(0.08032 * (v - E_K1 + 5.476)) + np.exp(0.06175 * (v - E_K1 - 594.31))) / (
            1 + np.exp(-0.5143 * (v - E_K1 + 4.753))
        )
        time_independent = self.g_K1 * potassium * alpha / (alpha + beta) * (v - E_K1)
        plateau = self.g_Kp * (v - E_K1) / (1 + np.exp((7.488 - v) / 5.98))
        background = self.g_b * (v - self.E_b)
        slow_inward = self._slow_inward(v, d, f, calcium)
        return (sodium + slow_inward + time_dependent + time_independent + plateau + background) / self.C

    def rates(self, v: Any, states: Sequence[Any]) -> Sequence[Any]:
        """Of the gates [1/ms], α (1 − x) − β x each, and of the calcium [μM/ms]."""
        m, h, j, d, f, X, calcium = states
        low, below = v < -40.0, np.minimum(v, -40.0)  # so that what is not taken cannot overflow
        alpha_m = 3.2 * _ratio(0.1 * (v + 47.13))
        beta_m = 0.08 * np.exp(-v / 11.0)
        alpha_h = np.where(low, 0.135 * np.exp(-(v + 80.0) / 6.8), 0.0)
        beta_h = np.where(
            low,
            3.56 * np.exp(0.079 * below) + 3.1e5 * np.exp(0.35 * below),
            1 / (0.13 * (1 + np.exp(-(v + 10.66) / 11.1))),
        )
        alpha_j = np.where(
            low,
            -(127140.0 * np.exp(0.2444 * below) + 3.474e-5 * np.exp(-0.04391 * below))
            * (v + 37.78)
            / (1 + np.exp(0.311 * (below + 79.23))),
            0.0,
        )
        beta_j = np.where(
            low,
            0.1212 * np.exp(-0.01052 * v) / (1 + np.exp(-0.1378 * (v + 40.14))),
            0.3 * np.exp(-2.535e-7 * v) / (1 + np.exp(-0.1 * (v + 32.0))),
        )
        alpha_d = 0.095 * np.exp(-0.01 * (v - 5.0)) / (1 + np.exp(-0.072 * (v - 5.0)))
        beta_d = 0.07 * np.exp(-0.017 * (v + 44.0)) / (1 + np.exp(0.05 * (v + 44.0)))
        alpha_f = 0.012 * np.exp(-0.008 * (v + 28.0)) / (1 + np.exp(0.15 * (v + 28.0)))
        beta_f = 0.0065 * np.exp(-0.02 * (v + 30.0)) / (1 + np.exp(-0.2 * (v + 30.0)))
        alpha_X = 0.0005 * np.exp(0.083 * (v + 50.0)) / (1 + np.exp(0.057 * (v + 50.0)))
        beta_X = 0.0013 * np.exp(-0.06 * (v + 20.0)) / (1 + np.exp(-0.04 * (v + 20.0)))
        return (
            alpha_m * (1 - m) - beta_m * m,
            alpha_h * (1 - h) - beta_h * h,
            alpha_j * (1 - j) - beta_j * j,
            alpha_d * (1 - d) - beta_d * d,
            alpha_f * (1 - f) - beta_f * f,
            alpha_X * (1 - X) - beta_X * X,
            # 1e-4 mM/ms a μA/cm², and a recovery to 1e-4 mM.
            -0.1 * self._slow_inward(v, d, f, calcium) + 0.07 * (0.1 - calcium),
        )
