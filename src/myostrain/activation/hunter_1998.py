"""A tension that follows calcium and the length of the fibre at once."""

from typing import Any, ClassVar

from myostrain.activation.contracts import Yield
from myostrain.validation import NonNegative, Positive, description

import numpy as np


@description
class Hunter1998:
    """Ta = T (1 + β (λ − 1)) xⁿ/(xⁿ + c₅₀ⁿ), x = (c − c₀)₊: more on a longer fibre, never negative.

    c is the calcium, λ the stretch of the fibre. The steady state of P. J. Hunter, A. D. McCulloch and
    H. E. D. J. ter Keurs, Prog. Biophys. Mol. Biol. 69 (1998) 289–331, doi 10.1016/S0079-6107(98)00013-3,
    with form, T and β of a public code; c₀, c₅₀ and n, which that code leaves to its user, are ours. It is
    the counterpart of :class:`~myostrain.activation.Rossi2014`: the same drivers, a stress in place of a
    strain.

    A tension that grows at once with the length pulls the fibre back in the next step. With the schemes of
    one pass the length may oscillate from step to step, whatever the step: from a gain β T λ/(K + T) of 1 on
    (staggered) or of 1/3 (second order), K being the passive stiffness along the fibre. Use the implicit
    scheme there. ``myostrain reproduce strain-and-stress`` shows it.

    Args:
        tension: T, the largest tension at stretch one, in the case's unit of stress; 100 kPa in that code.
        beta: β, the slope over the stretch, non-dimensional.
        c0: Calcium c₀ from which there is a tension, μM.
        c50: c₅₀, how much more calcium gives half of it, μM.
        n: The exponent.
    """

    tension: Positive = 100.0
    beta: NonNegative = 1.45
    c0: NonNegative = 0.11
    c50: Positive = 0.6
    n: Positive = 3.0
    drivers: ClassVar[tuple[str, ...]] = ("calcium", "stretch")
    units: ClassVar[dict[str, str]] = {"calcium": "μM"}
    yields: ClassVar[Yield] = "tension"

    def activation(self, states: Any, drivers: Any) -> Any:
        """Ta (nodes,)."""
        x = (np.maximum(drivers["calcium"] - self.c0, 0.0) / self.c50) ** self.n
        longer = np.maximum(1 + self.beta * (drivers["stretch"] - 1), 0.0)
        return self.tension * longer * x / (1 + x)
