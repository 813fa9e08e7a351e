"""A tension proportional to the excitation, the other approach to activation."""

from typing import Any, ClassVar

from myostrain.activation.contracts import Yield
from myostrain.validation import Positive, description

import numpy as np


@description
class ActiveStress:
    """Ta = T max(v, 0): a tension in place of an active strain. The undershoot of v does not push.

    v is the excitation: 0 at rest, 1 at full excitation, whatever the membrane's units.

    With T = 60 kPa and a uniform v that is given in time it is the activation of the third problem of S. Land
    and others, Proc. R. Soc. A 471 (2015) 20150641, doi 10.1098/rspa.2015.0641.

    Args:
        tension: T, the tension at full excitation, a stress, positive.
    """

    tension: Positive = 1.0
    drivers: ClassVar[tuple[str, ...]] = ("excitation",)
    yields: ClassVar[Yield] = "tension"

    def activation(self, states: Any, drivers: Any) -> Any:
        """The tension (nodes,) for the excitation."""
        return self.tension * np.maximum(drivers["excitation"], 0.0)
