"""Active strain that calcium drives, and the stretch of the fibre."""

from typing import Annotated, Any, ClassVar

from myostrain.activation.contracts import Array, Yield
from myostrain.activation.force_length import force_length
from myostrain.validation import NonNegative, Positive, description

import numpy as np
from pydantic import Field

#: Corrections of Newton's method at most. From any start it converges from one side; three or four are usual.
MOST = 60
#: Relaxation times after which nothing is left of the start.
LONG = 250.0


@description
class Rossi2014:
    """μ c² dγ/dt = F + 2 λ² ((1 + γ)⁻³ − 1), with the active force F = α (c − c₀)₊² RFL(λ).

    c is the calcium, λ the stretch of the fibre, and RFL the force over the sarcomere's length, see
    :func:`~myostrain.activation.force_length.force_length`: a longer fibre contracts more. The last term is
    the passive force that opposes γ. (Codes have its Taylor polynomial Σ (−1)ʲ (j + 1)(j + 2) λ² γʲ, j = 1 to
    5, in its place.) For frozen c and λ, γ tends to (1 − F/(2 λ²))^(−1/3) − 1. S. Rossi and others, Eur. J.
    Mech. A/Solids 48 (2014) 129–142, doi 10.1016/j.euromechsol.2013.10.009, as implemented in public codes,
    which agree on α and c₀, but have 5000 or 10,000 for μ. With these γ is weak, some −0.035 to −0.05.

    The step is exact for frozen calcium and stretch, so that no step is too long for it: the equation is
    separable, and its implicit solution is one convex equation for each node.

    Args:
        alpha: α, μM⁻², negative.
        c0: Calcium c₀ from which there is a force, μM.
        mu: μ, ms μM⁻²: the larger, the slower.
        sarcomere: Length of the sarcomere at stretch one, μm.
    """

    alpha: Annotated[float, Field(lt=0, allow_inf_nan=False, strict=True)] = -4.0
    c0: NonNegative = 0.2155
    mu: Positive = 5000.0
    sarcomere: Positive = 1.95
    drivers: ClassVar[tuple[str, ...]] = ("calcium", "stretch")
    units: ClassVar[dict[str, str]] = {"calcium": "μM", "time": "ms"}
    states: ClassVar[tuple[str, ...]] = ("gamma",)
    yields: ClassVar[Yield] = "strain"

    def initial_states(self, drivers: Any) -> Any:
        """γ = 0: what has calcium at the start has not contracted yet."""
        return (0.0,)

    def equilibrium(self, calcium: Any, stretch: Any) -> Any:
        """γ (nodes,) that is reached at a calcium and a stretch."""
        return (1 - self._force(calcium, stretch) / (2 * stretch**2)) ** (-1 / 3) - 1

    def advance(self, states: Any, drivers: Any, step: float) -> Any:
        """γ after a step for frozen calcium and stretch, exactly."""
        calcium, stretch = drivers["calcium"], drivers["stretch"]
        limit = 1 + self.equilibrium(calcium, stretch)
        # With y = (1 + γ)/limit the equation is dy/dτ = y⁻³ − 1, τ = t · 2 λ²/(μ c² limit⁴).
        with np.errstate(divide="ignore"):
            time = step * 2 * stretch**2 / (self.mu * np.square(calcium) * limit**4)
        return limit * relaxed((1 + states[0]) / limit, np.minimum(time, LONG))[None] - 1

    def activation(self, states: Any, drivers: Any) -> Any:
        """γ (nodes,)."""
        return states[0]

    def _force(self, calcium: Any, stretch: Any) -> Any:
        above = np.maximum(calcium - self.c0, 0.0)
        return self.alpha * above**2 * force_length(stretch, self.sarcomere)


def relaxed(start: Array, time: Array) -> Array:
    """y(τ) of dy/dτ = y⁻³ − 1 from y(0) = start > 0, each (nodes,).

    Since ∫ y³/(1 − y³) dy = G(y) − ln|1 − y|/3 with G(y) = −y + ln(1 + y + y²)/6 + atan((2y + 1)/√3)/√3, the
    distance from the limit is y − 1 = (start − 1) eˢ, where s + 3τ = 3 (G(y) − G(start)). The derivative of
    s − 3G in s, 3y³/(1 + y + y²), is positive and monotone: after its first correction Newton's method
    converges from one side, and quadratically; G decreases, which bounds s from below.
    """
    away, begun = start - 1, 3 * _smooth(start)
    lowest = np.minimum(3 * _smooth(np.ones(1)) - begun, 0.0) - 3 * time
    s, y = np.zeros_like(start), start
    for _ in range(MOST):
        correction = (s - 3 * _smooth(y) + begun + 3 * time) * (1 + y + y * y) / (3 * y**3)
        left = np.abs(correction * (y - 1)).max(initial=0.0)
        s = np.maximum(s - correction, lowest)
        y = 1 + away * np.exp(s)
        if not left > 1e-9:  # what is left now is its square; NaN ends it too
            break
    return y


def _smooth(y: Array) -> Array:
    return -y + np.log(1 + y + y * y) / 6 + np.arctan((2 * y + 1) / np.sqrt(3)) / np.sqrt(3)
