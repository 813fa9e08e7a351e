"""A ventricle that fills from an atrium and ejects into a three-element Windkessel."""

from __future__ import annotations

from typing import ClassVar

from myostrain.circulation.contracts import Array
from myostrain.validation import Finite, NonNegative, Positive, description

import numpy as np


@description
class Windkessel:
    """C dπ/dt = Q − (π − π_v)/R behind the outlet valve, through which Q = max(p − π, 0)/Z flows.

    p is the pressure in the ventricle and π that in the arteries. The ventricle fills through the inlet valve
    with max(p_a − p, 0)/R_in from an atrium of constant pressure p_a. The valves are diodes: they let nothing
    back, and while both are shut the volume stays. N. Westerhof, J.-W. Lankhaar, B. E. Westerhof, Med. Biol.
    Eng. Comput. 47 (2009) 131–141, doi 10.1007/s11517-008-0359-2, review the model.

    All is in the units of the case: with mm, ms and kPa resistances are in kPa ms/mm³, where 1 mmHg s/mL is
    0.1333, and compliances in mm³/kPa, where 1 mL/mmHg is 7501.

    Args:
        resistance: Peripheral resistance R.
        compliance: Compliance C of the arteries.
        impedance: Characteristic impedance Z, the resistance from the ventricle to the arteries.
        inlet_resistance: Resistance R_in from the atrium to the ventricle.
        filling_pressure: Pressure p_a in the atrium; the ventricle begins with it unless there is a preload.
        arterial_pressure: Pressure π in the arteries at the beginning.
        venous_pressure: Pressure π_v behind the peripheral resistance.
    """

    resistance: Positive
    compliance: Positive
    impedance: Positive
    inlet_resistance: Positive
    filling_pressure: NonNegative
    arterial_pressure: Finite
    venous_pressure: Finite = 0.0
    cavities: ClassVar[int] = 1
    #: The arterial pressure, and what has flowed in and out since the beginning.
    states: ClassVar[tuple[str, ...]] = ("pressure_arteries", "inflow", "outflow")

    @property
    def preload(self) -> float:
        """Pressure with which the ventricle begins unless another one is given."""
        return self.filling_pressure

    def initial_states(self, pressures: Array, volumes: Array) -> Array:
        """The arteries at their first pressure; nothing has flowed."""
        return np.array([self.arterial_pressure, 0.0, 0.0])

    def rates(self, time: float, states: Array, pressures: Array) -> tuple[Array, Array]:
        """Rates of the states, and the flow into the ventricle."""
        (p,), (arteries, _, _) = pressures, states
        inflow = max(self.filling_pressure - p, 0.0) / self.inlet_resistance
        outflow = max(p - arteries, 0.0) / self.impedance
        leaving = (arteries - self.venous_pressure) / self.resistance
        return np.array([(outflow - leaving) / self.compliance, inflow, outflow]), np.array(
            [inflow - outflow]
        )
