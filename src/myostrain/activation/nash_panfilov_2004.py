"""A tension that follows the excitation with two rates."""

from typing import Any, ClassVar

from myostrain.activation.contracts import Yield
from myostrain.validation import Finite, Positive, description

import numpy as np


@description
class NashPanfilov2004:
    """dTa/dt = ε(v) (kTa v − Ta), with ε = rate below the threshold and above · rate from it on.

    v is the excitation: 0 at rest, 1 at full excitation, whatever the membrane's units; below 0 it is 0 here.
    M. P. Nash and A. V. Panfilov, Prog. Biophys. Mol. Biol. 85 (2004) 501–522,
    doi 10.1016/j.pbiomolbio.2004.01.016, have the tension grow ten times as fast as it falls (above = 10).
    In later papers of the group it is the other way round (above = 0.1), so that contraction lags behind the
    potential. The step is exact for a frozen excitation.

    Args:
        tension: kTa, the tension at full excitation, in the case's unit of stress; published 47.9 kPa.
        rate: ε at rest, per unit of time of the membrane. The default is for Aliev and Panfilov's; for one in
            milliseconds it is 1/12.9.
        above: The factor on the rate from the threshold on, 10 as published in 2004, 0.1 in later papers.
        threshold: The excitation at which the rate changes.
    """

    tension: Positive = 47.9
    rate: Positive = 1.0
    above: Positive = 10.0
    threshold: Finite = 0.05
    drivers: ClassVar[tuple[str, ...]] = ("excitation",)
    states: ClassVar[tuple[str, ...]] = ("tension",)
    yields: ClassVar[Yield] = "tension"

    def initial_states(self, drivers: Any) -> Any:
        """Ta = 0: what is excited at the start has no tension yet."""
        return (0.0,)

    def advance(self, states: Any, drivers: Any, step: float) -> Any:
        """Ta after a step for a frozen excitation, exactly."""
        v = drivers["excitation"]
        limit = self.tension * np.maximum(v, 0.0)
        rate = self.rate * np.where(v < self.threshold, 1.0, self.above)
        return limit + (states - limit) * np.exp(-rate * step)

    def activation(self, states: Any, drivers: Any) -> Any:
        """Ta (nodes,)."""
        return states[0]
