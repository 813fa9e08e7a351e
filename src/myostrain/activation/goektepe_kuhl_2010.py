"""A tension that follows a potential in millivolts, with a smooth switch between two rates."""

from typing import Any, ClassVar

from myostrain.activation.contracts import Yield
from myostrain.validation import Finite, Positive, description

import numpy as np


@description
class GoektepeKuhl2010:
    """dTa/dt = ε(V) (kT (V − Vr) − Ta), ε = ε₀ + (ε∞ − ε₀) exp(−exp(−ξ (V − Vs))).

    V is the potential in mV; below Vr it counts as Vr. S. Göktepe and E. Kuhl, Comput. Mech. 45 (2010)
    227–243, doi 10.1007/s00466-009-0434-z, with the parameters that a public code has. The step is exact for
    a frozen potential.

    Args:
        tension: kT, tension per millivolt, in the case's unit of stress; 0.005 kPa/mV in that code.
        rest: Vr, the potential without tension, mV.
        slow: ε₀, the rate at rest, 1/ms.
        fast: ε∞, the rate in excited tissue, 1/ms.
        steepness: ξ of the switch, 1/mV.
        switch: Vs, the potential of the switch, mV.
    """

    tension: Positive = 0.005
    rest: Finite = -80.0
    slow: Positive = 0.1
    fast: Positive = 1.0
    steepness: Positive = 1.0
    switch: Finite = -30.0
    drivers: ClassVar[tuple[str, ...]] = ("potential",)
    units: ClassVar[dict[str, str]] = {"potential": "mV", "time": "ms"}
    states: ClassVar[tuple[str, ...]] = ("tension",)
    yields: ClassVar[Yield] = "tension"

    def initial_states(self, drivers: Any) -> Any:
        """Ta = 0: what is excited at the start has no tension yet."""
        return (0.0,)

    def advance(self, states: Any, drivers: Any, step: float) -> Any:
        """Ta after a step for a frozen potential, exactly."""
        v = drivers["potential"]
        limit = self.tension * np.maximum(v - self.rest, 0.0)
        # Beyond 700 the exponential is infinite to double precision, and its inverse zero.
        below = np.exp(np.minimum(-self.steepness * (v - self.switch), 700.0))
        rate = self.slow + (self.fast - self.slow) * np.exp(-below)
        return limit + (states - limit) * np.exp(-rate * step)

    def activation(self, states: Any, drivers: Any) -> Any:
        """Ta (nodes,)."""
        return states[0]
