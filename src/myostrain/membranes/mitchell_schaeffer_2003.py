"""Mitchell–Schaeffer membrane."""

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar

from myostrain.validation import Positive, description

import numpy as np
from pydantic import Field


@description
class MitchellSchaeffer2003:
    """Mitchell and Schaeffer 2003: one inward current with one gate h; potential from 0 to 1, time in ms.

    The current is −h v² (1 − v)/τ_in + v/τ_out; h opens below V_gate and closes above it. As implemented in
    public codes that cite the paper, doi:10.1016/S0092-8240(03)00041-7.

    Args:
        tau_in: τ_in of the inward current [ms]; below τ_out/4, or there is no excitation.
        tau_out: τ_out of the outward current [ms].
        tau_open: Time constant with which the gate opens [ms].
        tau_close: Time constant with which the gate closes [ms].
        V_gate: Potential above which the gate closes, between 0 and 1.
    """

    tau_in: Positive = 0.3
    tau_out: Positive = 6.0
    tau_open: Positive = 120.0
    tau_close: Positive = 150.0
    V_gate: Annotated[float, Field(gt=0, lt=1, strict=True)] = 0.13
    states: ClassVar[tuple[str, ...]] = ("h",)
    time_unit: ClassVar[str | None] = "ms"
    potential_unit: ClassVar[str | None] = None
    range: ClassVar[tuple[float, float]] = (0.0, 1.0)
    threshold: ClassVar[float] = 0.5
    calcium: ClassVar[str | None] = None
    calcium_unit: ClassVar[str | None] = None
    gates: ClassVar[tuple[str, ...]] = ("h",)
    conserved: ClassVar[tuple[str, ...]] = ()
    pacing: ClassVar[tuple[float, float] | None] = (0.4, 1.0)

    def resting_potential(self) -> float:
        """Zero."""
        return 0.0

    def resting_states(self) -> tuple[float, ...]:
        """An open gate, one; codes that start from 0.9 start from no equilibrium."""
        return (1.0,)

    def current(self, v: Any, states: Sequence[Any]) -> Any:
        """−h v² (1 − v)/τ_in + v/τ_out [1/ms]."""
        (h,) = states
        return v / self.tau_out - h * v * v * (1 - v) / self.tau_in

    def rates(self, v: Any, states: Sequence[Any]) -> Sequence[Any]:
        """(1 − h)/τ_open below V_gate, −h/τ_close above [1/ms]."""
        (h,) = states
        return (np.where(v < self.V_gate, (1 - h) / self.tau_open, -h / self.tau_close),)
