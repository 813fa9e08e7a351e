"""Active strain that follows the excitation with a rise and a fall time."""

from typing import Annotated, Any, ClassVar

from myostrain.activation.contracts import Yield
from myostrain.validation import Finite, Positive, description

import numpy as np
from pydantic import Field


@description
class Relaxing:
    """τ(v) dγ/dt = −β v − γ, with τ = rise where v is above a threshold and τ = fall elsewhere.

    v is the excitation: 0 at rest, 1 at full excitation, whatever the membrane's units.

    According to the paper's concluding remarks, a delay between upstroke and contraction, and a contraction
    that outlasts the potential, are missing. Two time constants give both; the switch is that of M. P. Nash
    and A. V. Panfilov, Prog. Biophys. Mol. Biol. 85 (2004) 501–522, doi 10.1016/j.pbiomolbio.2004.01.016, who
    use it for a tension. The step is exact for a frozen excitation.

    Args:
        beta: β, the contraction that v = 1 leads to, 0 ≤ β < 1, non-dimensional.
        rise: Time constant where v is above the threshold, positive.
        fall: Time constant elsewhere, positive.
        threshold: The excitation at which the time constant changes.
    """

    beta: Annotated[float, Field(ge=0, lt=1, strict=True)] = 0.3
    rise: Positive = 0.1
    fall: Positive = 0.2
    threshold: Finite = 0.05
    drivers: ClassVar[tuple[str, ...]] = ("excitation",)
    states: ClassVar[tuple[str, ...]] = ("gamma",)
    yields: ClassVar[Yield] = "strain"

    def initial_states(self, drivers: Any) -> Any:
        """γ = 0: what is excited at the start has not contracted yet."""
        return (0.0,)

    def advance(self, states: Any, drivers: Any, step: float) -> Any:
        """γ after a step for a frozen excitation, exactly."""
        v = drivers["excitation"]
        decay = np.exp(-step / np.where(v > self.threshold, self.rise, self.fall))
        return -self.beta * v + (states + self.beta * v) * decay

    def activation(self, states: Any, drivers: Any) -> Any:
        """γ (nodes,)."""
        return states[0]
