"""Bueno-Orovio–Cherry–Fenton membrane."""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from myostrain.errors import InputError
from myostrain.membranes.parameter_sets import OF_SET, fill_from_set
from myostrain.validation import NonNegative, Positive, description

import numpy as np

#: Potential in mV: 85.7 u − 84.
SCALE, ZERO = 85.7, -84.0

#: The published sets, and the value of each parameter in each of them.
_SETS = ("EPI", "ENDO", "M", "PB", "TNNP")
_TABLE = {
    "u0": (0.0, 0.0, 0.0, 0.0, 0.0),
    "u_u": (1.55, 1.56, 1.61, 1.45, 1.58),
    "theta_v": (0.3, 0.3, 0.3, 0.35, 0.3),
    "theta_w": (0.13, 0.13, 0.13, 0.13, 0.015),
    "theta_vm": (0.006, 0.2, 0.1, 0.175, 0.015),
    "theta_0": (0.006, 0.006, 0.005, 0.006, 0.006),
    "tau_v1m": (60.0, 75.0, 80.0, 10.0, 60.0),
    "tau_v2m": (1150.0, 10.0, 1.4506, 1150.0, 1150.0),
    "tau_vp": (1.4506, 1.4506, 1.4506, 1.4506, 1.4506),
    "tau_w1m": (60.0, 6.0, 70.0, 140.0, 70.0),
    "tau_w2m": (15.0, 140.0, 8.0, 6.25, 20.0),
    "k_wm": (65.0, 200.0, 200.0, 65.0, 65.0),
    "u_wm": (0.03, 0.016, 0.016, 0.015, 0.03),
    "tau_wp": (200.0, 280.0, 280.0, 326.0, 280.0),
    "tau_fi": (0.11, 0.1, 0.078, 0.105, 0.11),
    "tau_o1": (400.0, 470.0, 410.0, 400.0, 6.0),
    "tau_o2": (6.0, 6.0, 7.0, 6.0, 6.0),
    "tau_so1": (30.0181, 40.0, 91.0, 30.0181, 43.0),
    "tau_so2": (0.9957, 1.2, 0.8, 0.9957, 0.2),
    "k_so": (2.0458, 2.0, 2.1, 2.0458, 2.0),
    "u_so": (0.65, 0.65, 0.6, 0.65, 0.65),
    "tau_s1": (2.7342, 2.7342, 2.7342, 2.7342, 2.7342),
    "tau_s2": (16.0, 2.0, 4.0, 16.0, 3.0),
    "k_s": (2.0994, 2.0994, 2.0994, 2.0994, 2.0994),
    "u_s": (0.9087, 0.9087, 0.9087, 0.9087, 0.9087),
    "tau_si": (1.8875, 2.9013, 3.3849, 1.8875, 2.8723),
    "tau_winf": (0.07, 0.0273, 0.01, 0.175, 0.07),
    "w_infstar": (0.94, 0.78, 0.5, 0.9, 0.94),
}


@description
class BuenoOrovio2008:
    """Bueno-Orovio, Cherry and Fenton 2008: a minimal human ventricular cell, four variables; mV and ms.

    The equations are those in u with the potential 85.7 u − 84 mV: a fast inward current with the gate v, a
    slow outward one, and a slow inward one with the gates w and s. Contraction takes s as calcium in μM, as
    codes do that couple this model; it is a gate with the shape of a calcium transient. As implemented in
    public codes that cite the paper, doi:10.1016/j.jtbi.2008.03.029. Where u is below zero, as diffusion can
    make it beside a front, w tends to more than one; so w is not held to [0, 1].

    Args:
        set: Set of parameters: "EPI", "ENDO", "M" (the three layers), "PB" (fitted to the model of Priebe
            and Beuckelmann) or "TNNP" (to that of ten Tusscher et al.). What is not given below is the set's.
        u0: Resting potential, as u.
        u_u: Potential u_u at which the fast inward current reverses, as u.
        theta_v: Threshold θ_v of the fast inward current, as u.
        theta_w: Threshold θ_w of the slow currents, as u.
        theta_vm: Threshold θ_v⁻, as u: above it v rests closed, and changes its pace.
        theta_0: Threshold θ_o, as u: above it τ_o and the rest of w change.
        tau_v1m: Time constant of v below θ_v⁻ [ms].
        tau_v2m: Time constant of v between θ_v⁻ and θ_v [ms].
        tau_vp: Time constant with which v closes above θ_v [ms].
        tau_w1m: Time constant of w at low potentials [ms].
        tau_w2m: Time constant of w at higher ones, below θ_w [ms].
        k_wm: Steepness of the change between the two.
        u_wm: Potential of the change between the two, as u.
        tau_wp: Time constant with which w closes above θ_w [ms].
        tau_fi: τ_fi of the fast inward current [ms].
        tau_o1: τ_o of the slow outward current below θ_o [ms].
        tau_o2: The same between θ_o and θ_w [ms].
        tau_so1: τ_so of the slow outward current above θ_w, at low potentials [ms].
        tau_so2: The same at high potentials [ms].
        k_so: Steepness of the change between the two.
        u_so: Potential of the change between the two, as u.
        tau_s1: Time constant of s below θ_w [ms].
        tau_s2: Time constant of s above θ_w [ms].
        k_s: Steepness of the activation of s.
        u_s: Potential at which s is half activated, as u.
        tau_si: τ_si of the slow inward current [ms].
        tau_winf: Scale of u on which w closes at rest, below θ_o.
        w_infstar: Value at which w rests above θ_o.
    """

    set: str = "EPI"
    u0: NonNegative = OF_SET
    u_u: Positive = OF_SET
    theta_v: Positive = OF_SET
    theta_w: Positive = OF_SET
    theta_vm: NonNegative = OF_SET
    theta_0: NonNegative = OF_SET
    tau_v1m: Positive = OF_SET
    tau_v2m: Positive = OF_SET
    tau_vp: Positive = OF_SET
    tau_w1m: Positive = OF_SET
    tau_w2m: Positive = OF_SET
    k_wm: Positive = OF_SET
    u_wm: NonNegative = OF_SET
    tau_wp: Positive = OF_SET
    tau_fi: Positive = OF_SET
    tau_o1: Positive = OF_SET
    tau_o2: Positive = OF_SET
    tau_so1: Positive = OF_SET
    tau_so2: Positive = OF_SET
    k_so: Positive = OF_SET
    u_so: Positive = OF_SET
    tau_s1: Positive = OF_SET
    tau_s2: Positive = OF_SET
    k_s: Positive = OF_SET
    u_s: Positive = OF_SET
    tau_si: Positive = OF_SET
    tau_winf: Positive = OF_SET
    w_infstar: NonNegative = OF_SET
    sets: ClassVar[Mapping[str, Mapping[str, float]]] = {
        name: {key: values[column] for key, values in _TABLE.items()} for column, name in enumerate(_SETS)
    }
    states: ClassVar[tuple[str, ...]] = ("v", "w", "s")
    time_unit: ClassVar[str | None] = "ms"
    potential_unit: ClassVar[str | None] = "mV"
    range: ClassVar[tuple[float, float]] = (-85.0, 50.0)
    threshold: ClassVar[float] = -40.0
    calcium: ClassVar[str | None] = "s"
    calcium_unit: ClassVar[str | None] = "μM"
    gates: ClassVar[tuple[str, ...]] = ("v", "s")
    conserved: ClassVar[tuple[str, ...]] = ()
    pacing: ClassVar[tuple[float, float] | None] = (34.28, 1.0)

    def __post_init__(self) -> None:
        """Take what is not given from the set; refuse a rest above the thresholds."""
        fill_from_set(self, self.sets)
        if not self.u0 < min(self.theta_v, self.theta_w):
            raise InputError(
                f"the membrane rests there: give less than theta_v = {self.theta_v:g} and "
                f"theta_w = {self.theta_w:g}, not {self.u0:g}",
                "cell.u0",
            )

    def resting_potential(self) -> float:
        """Where u = u0 [mV]."""
        return ZERO + SCALE * self.u0

    def resting_states(self) -> tuple[float, ...]:
        """v, w and s at rest; s is not zero, as it is in the paper's initial values, but 0.0216."""
        u = self.u0
        return (
            float(u < self.theta_vm),
            1 - u / self.tau_winf if u < self.theta_0 else self.w_infstar,
            0.5 * (1 + float(np.tanh(self.k_s * (u - self.u_s)))),
        )

    def current(self, v: Any, states: Sequence[Any]) -> Any:
        """Fast inward, slow outward and slow inward current [mV/ms]."""
        fast, slow, s = states
        u = (v - ZERO) / SCALE
        fast_inward = np.where(
            u > self.theta_v, -fast * (u - self.theta_v) * (self.u_u - u) / self.tau_fi, 0.0
        )
        tau_o = np.where(u > self.theta_0, self.tau_o2, self.tau_o1)
        high = 0.5 * (1 + np.tanh(self.k_so * (u - self.u_so)))
        tau_so = self.tau_so1 + (self.tau_so2 - self.tau_so1) * high
        slow_currents = np.where(u > self.theta_w, 1 / tau_so - slow * s / self.tau_si, (u - self.u0) / tau_o)
        return SCALE * (fast_inward + slow_currents)

    def rates(self, v: Any, states: Sequence[Any]) -> Sequence[Any]:
        """Of v, w and s [1/ms]."""
        fast, slow, s = states
        u = (v - ZERO) / SCALE
        opening = np.where(u > self.theta_vm, -fast / self.tau_v2m, (1 - fast) / self.tau_v1m)
        high = 0.5 * (1 + np.tanh(self.k_wm * (u - self.u_wm)))
        tau_w = self.tau_w1m + (self.tau_w2m - self.tau_w1m) * high
        open_w = np.where(u > self.theta_0, self.w_infstar, 1 - u / self.tau_winf)
        tau_s = np.where(u > self.theta_w, self.tau_s2, self.tau_s1)
        return (
            np.where(u > self.theta_v, -fast / self.tau_vp, opening),
            np.where(u > self.theta_w, -slow / self.tau_wp, (open_w - slow) / tau_w),
            (0.5 * (1 + np.tanh(self.k_s * (u - self.u_s))) - s) / tau_s,
        )
