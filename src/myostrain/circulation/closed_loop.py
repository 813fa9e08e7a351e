"""The whole circulation as a closed loop, of which one or both ventricles are solids."""

from __future__ import annotations

from typing import Annotated

from myostrain.circulation.contracts import Array
from myostrain.validation import Finite, Positive, description

import numpy as np
from pydantic import Field

#: E_A, E_B, T_C, T_R, t_C, V_0 of a chamber, and R, C, L of arteries and then of veins.
Six = tuple[Finite, Finite, Finite, Finite, Finite, Finite]
Three = tuple[Finite, Finite, Finite]
Four = tuple[Finite, Finite, Finite, Finite]


@description
class ClosedLoop:
    """Chambers of time-varying elastance, valves, and vessels with resistance, compliance and inertance.

    A chamber has p = (E_B + E_A e(t)) (V − V₀), where e rises from 0 to 1 by half a cosine in T_C from t_C
    on, and falls likewise in T_R. Arteries and veins of both circulations have C dp/dt = Q_in − Q and
    L dQ/dt = p − p_next − R Q. A valve has one resistance where it is open and a large one where it is shut.
    The left ventricle is the solid's cavity; of two cavities the second is the right ventricle. F. Regazzoni
    and others, J. Comput. Phys. 457 (2022) 111083, doi 10.1016/j.jcp.2022.111083; the values are those of the
    package circulation 0.4 (MIT), in mL, mmHg and s.

    Args:
        cavities: How many ventricles are solids, the left one first.
        period: Duration of a beat, s.
        left_atrium: E_A, E_B (mmHg/mL), T_C, T_R, t_C (s), V₀ (mL).
        right_atrium: The same of the right atrium.
        right_ventricle: The same of the right ventricle, where it is not a solid.
        systemic: R, C, L of the arteries, then of the veins (mmHg s/mL, mL/mmHg, mmHg s²/mL).
        pulmonary: The same of the lung.
        valve_open: Resistance of an open valve, mmHg s/mL.
        valve_shut: Resistance of a shut valve.
        volumes: Volumes of left atrium, right atrium and right ventricle at the beginning, mL.
        pressures: Pressures in systemic arteries and veins, pulmonary arteries and veins, mmHg.
        flows: Flows out of them, mL/s.
        volume_unit: 1 mL in the case's unit of volume: 1000 for mm.
        pressure_unit: 1 mmHg in its unit of pressure: 0.133322 for kPa.
        time_unit: 1 s in its unit of time: 1000 for ms.
    """

    cavities: Annotated[int, Field(ge=1, le=2, strict=True)] = 1
    period: Positive = 0.8
    left_atrium: Six = (0.07, 0.18, 0.17, 0.17, 0.9, 4.0)
    right_atrium: Six = (0.06, 0.07, 0.17, 0.17, 0.9, 4.0)
    right_ventricle: Six = (0.2, 0.029, 0.25, 0.4, 0.1, 16.0)
    systemic: Six = (0.733, 1.372, 0.005, 0.32, 11.363, 0.0005)
    pulmonary: Six = (0.046, 20.0, 0.0005, 0.0015, 16.0, 0.0005)
    valve_open: Positive = 0.0075
    valve_shut: Positive = 75006.2
    volumes: Three = (87.183, 86.833, 166.177)
    pressures: Four = (87.675, 35.898, 19.545, 15.004)
    flows: Four = (71.104, 94.039, 94.084, 473.279)
    volume_unit: Positive = 1000.0
    pressure_unit: Positive = 0.133322
    time_unit: Positive = 1000.0

    @property
    def states(self) -> tuple[str, ...]:
        """Volumes of what is not a solid, pressures and flows of the vessels, in mL, mmHg and mL/s."""
        volumes = ("left_atrium_mL", "right_atrium_mL", "right_ventricle_mL")[: 4 - self.cavities]
        vessels = [f"{side}_{kind}" for side in ("systemic", "pulmonary") for kind in ("arteries", "veins")]
        return (*volumes, *(f"{name}_mmHg" for name in vessels), *(f"{name}_mL_per_s" for name in vessels))

    @property
    def preload(self) -> Array:
        """Pressures of the atria at the beginning, with which the ventricles begin, in the case's unit."""
        atria = zip((self.left_atrium, self.right_atrium), self.volumes, strict=False)
        pressures = [max(0.0, self._chamber(atrium, 0.0, volume)) for atrium, volume in atria]
        return self.pressure_unit * np.array(pressures[: self.cavities])

    def initial_states(self, pressures: Array, volumes: Array) -> Array:
        """Those that are given."""
        chambers = self.volumes if self.cavities == 1 else self.volumes[:2]
        return np.array([*chambers, *self.pressures, *self.flows])

    def rates(self, time: float, states: Array, pressures: Array) -> tuple[Array, Array]:
        """Rates of the states, and flows into the ventricles."""
        t, left = time / self.time_unit, pressures[0] / self.pressure_unit
        chambers, p, q = states[:-8], states[-8:-4], states[-4:]
        left_atrium = self._chamber(self.left_atrium, t, chambers[0])
        right_atrium = self._chamber(self.right_atrium, t, chambers[1])
        if self.cavities == 2:
            right = pressures[1] / self.pressure_unit
        else:
            right = self._chamber(self.right_ventricle, t, chambers[2])
        mitral, aortic = self._valve(left_atrium - left), self._valve(left - p[0])
        tricuspid, pulmonary = self._valve(right_atrium - right), self._valve(right - p[2])
        into_left, into_right = mitral - aortic, tricuspid - pulmonary
        resistance, compliance, inertance = np.array([*self.systemic, *self.pulmonary]).reshape(4, 3).T
        entering = np.array([aortic, q[0], pulmonary, q[2]])
        following = np.array([p[1], right_atrium, p[3], left_atrium])
        rates = [q[3] - mitral, q[1] - tricuspid, *([into_right] if self.cavities == 1 else [])]
        rates += [*((entering - q) / compliance), *((p - following - resistance * q) / inertance)]
        flows = np.array([into_left, into_right][: self.cavities])
        return np.array(rates) / self.time_unit, flows * self.volume_unit / self.time_unit

    def _chamber(self, chamber: Six, time: float, volume: float) -> float:
        high, low, rising, falling, begin, rest = chamber
        since = (time - begin) % self.period
        if since < rising:
            share = (1 - np.cos(np.pi * since / rising)) / 2
        else:
            share = (1 + np.cos(np.pi * min((since - rising) / falling, 1.0))) / 2
        return float((low + high * share) * (volume - rest))

    def _valve(self, drop: float) -> float:
        return drop / (self.valve_open if drop > 0 else self.valve_shut)
