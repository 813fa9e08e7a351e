"""Fenton–Karma membrane."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, ClassVar

from myostrain.errors import InputError
from myostrain.membranes.equilibrium import equilibrium
from myostrain.membranes.parameter_sets import OF_SET, fill_from_set
from myostrain.validation import NonNegative, Positive, description

import numpy as np

#: The published sets, and the value of each parameter in each of them.
_SETS = ("MLR-I", "Set 1", "Set 3", "Set 4", "Set 5", "Set 6", "Set 8", "Set 9", "Set 10")
_TABLE = {
    "k": (10.0, 10.0, 10.0, 15.0, 15.0, 15.0, 10.0, 10.0, 10.0),
    "tau_0": (12.5, 8.3, 12.5, 9.0, 5.0, 9.0, 12.5, 12.5, 12.5),
    "tau_d": (0.172, 0.42, 0.25, 0.407, 0.362, 0.395, 0.45, 0.25, 0.115),
    "tau_r": (130.0, 50.0, 33.33, 34.0, 33.33, 33.33, 33.25, 28.0, 25.0),
    "tau_si": (127.0, 45.0, 29.0, 26.5, 29.0, 29.0, 29.0, 29.0, 22.22),
    "tau_vm1": (18.2, 1000.0, 1250.0, 5.0, 2.0, 8.0, 1250.0, 2.0, 333.0),
    "tau_vm2": (18.2, 19.6, 19.6, 15.6, 12.0, 9.0, 19.6, 15.0, 40.0),
    "tau_vp": (10.0, 3.33, 3.33, 3.33, 3.33, 3.33, 13.03, 3.33, 10.0),
    "tau_wm": (80.0, 11.0, 41.0, 80.0, 100.0, 60.0, 40.0, 61.0, 65.0),
    "tau_wp": (1020.0, 667.0, 870.0, 350.0, 1000.0, 250.0, 800.0, 670.0, 1000.0),
    "u_c": (0.13, 0.13, 0.13, 0.15, 0.13, 0.13, 0.13, 0.13, 0.13),
    "u_csi": (0.85, 0.85, 0.85, 0.45, 0.7, 0.5, 0.85, 0.45, 0.85),
    "u_v": (0.0, 0.055, 0.04, 0.04, 0.04, 0.04, 0.04, 0.05, 0.025),
    "C_si": (1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0),
}


@description
class FentonKarma1998:
    """Fenton and Karma 1998: fast inward, slow outward and slow inward current; potential from 0 to 1, ms.

    With H = 1 above u_c: fast inward −v H (1 − u)(u − u_c)/τ_d, slow outward u (1 − H)/τ_0 + H/τ_r, slow
    inward −C_si w (1 + tanh(k (u − u_csi)))/(2 τ_si), where u is the potential; the gates v and w open below
    u_c and close above. As implemented in public codes that cite the papers: doi:10.1063/1.166311 for the set
    "MLR-I" and, for the sets with numbers, Fenton et al. 2002, doi:10.1063/1.1504242.

    Args:
        set: Set of parameters: "MLR-I", "Set 1", "Set 3", "Set 4", "Set 5", "Set 6", "Set 8", "Set 9" or
            "Set 10". What is not given below is the set's.
        k: Steepness k of the slow inward current's activation.
        tau_0: τ_0 of the slow outward current below u_c [ms].
        tau_d: τ_d of the fast inward current [ms].
        tau_r: τ_r of the slow outward current above u_c [ms].
        tau_si: τ_si of the slow inward current [ms].
        tau_vm1: Time constant with which v opens between u_v and u_c [ms].
        tau_vm2: Time constant with which v opens below u_v [ms].
        tau_vp: Time constant with which v closes [ms].
        tau_wm: Time constant with which w opens [ms].
        tau_wp: Time constant with which w closes [ms].
        u_c: Threshold u_c of the fast inward current.
        u_csi: Potential u_csi at which the slow inward current is half activated.
        u_v: Potential u_v at which the opening of v changes its pace.
        C_si: Factor on the slow inward current; zero blocks it.
    """

    set: str = "MLR-I"
    k: Positive = OF_SET
    tau_0: Positive = OF_SET
    tau_d: Positive = OF_SET
    tau_r: Positive = OF_SET
    tau_si: Positive = OF_SET
    tau_vm1: Positive = OF_SET
    tau_vm2: Positive = OF_SET
    tau_vp: Positive = OF_SET
    tau_wm: Positive = OF_SET
    tau_wp: Positive = OF_SET
    u_c: Positive = OF_SET
    u_csi: Positive = OF_SET
    u_v: NonNegative = OF_SET
    C_si: NonNegative = OF_SET
    sets: ClassVar[Mapping[str, Mapping[str, float]]] = {
        name: {key: values[column] for key, values in _TABLE.items()} for column, name in enumerate(_SETS)
    }
    states: ClassVar[tuple[str, ...]] = ("v", "w")
    time_unit: ClassVar[str | None] = "ms"
    potential_unit: ClassVar[str | None] = None
    range: ClassVar[tuple[float, float]] = (0.0, 1.0)
    threshold: ClassVar[float] = 0.5
    calcium: ClassVar[str | None] = None
    calcium_unit: ClassVar[str | None] = None
    gates: ClassVar[tuple[str, ...]] = ("v", "w")
    conserved: ClassVar[tuple[str, ...]] = ()
    pacing: ClassVar[tuple[float, float] | None] = (0.4, 1.0)

    def __post_init__(self) -> None:
        """Take what is not given from the set; refuse parameters without a rest below u_c."""
        fill_from_set(self, self.sets)
        inward = self.C_si * (1 + np.tanh(self.k * (self.u_c - self.u_csi))) / (2 * self.tau_si)
        if not inward < self.u_c / self.tau_0:
            raise InputError(
                f"at {self.u_c:g} the slow inward current is larger than the outward one, so that the "
                "membrane has no rest below; give a larger u_c, k or u_csi",
                "cell.u_c",
            )

    @cached_property
    def _rest(self) -> tuple[float, ...]:
        """Potential and gates at rest."""
        return equilibrium(self, 0.0, (1.0, 1.0))

    def resting_potential(self) -> float:
        """Where the slow currents balance: not zero, but within 1e-4 of it for all sets."""
        return self._rest[0]

    def resting_states(self) -> tuple[float, ...]:
        """Open gates."""
        return self._rest[1:]

    def current(self, v: Any, states: Sequence[Any]) -> Any:
        """Fast inward, slow outward and slow inward current [1/ms]."""
        fast, slow = states
        activated = 1 + np.tanh(self.k * (v - self.u_csi))
        slow_inward = -self.C_si * slow * activated / (2 * self.tau_si)
        fast_inward = -fast * (1 - v) * (v - self.u_c) / self.tau_d
        return slow_inward + np.where(v < self.u_c, v / self.tau_0, fast_inward + 1 / self.tau_r)

    def rates(self, v: Any, states: Sequence[Any]) -> Sequence[Any]:
        """Of v and w: they open below u_c, and close above [1/ms]."""
        fast, slow = states
        opening = np.where(v < self.u_v, self.tau_vm2, self.tau_vm1)
        below = v < self.u_c
        return (
            np.where(below, (1 - fast) / opening, -fast / self.tau_vp),
            np.where(below, (1 - slow) / self.tau_wm, -slow / self.tau_wp),
        )
