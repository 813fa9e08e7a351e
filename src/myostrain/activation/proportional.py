"""Active strain proportional to the excitation."""

from typing import Annotated, Any, ClassVar

from myostrain.activation.contracts import Yield
from myostrain.validation import description

from pydantic import Field


@description
class Proportional:
    """γ = −β v (3.4), with v between 0 at rest and 1 at full excitation whatever the membrane's units.

    Args:
        beta: Contraction β at full excitation, non-dimensional, 0 ≤ β < 1 (at β = 1 the active deformation is
            singular there); the paper takes 0.3.
    """

    beta: Annotated[float, Field(ge=0, lt=1, strict=True)] = 0.3
    drivers: ClassVar[tuple[str, ...]] = ("excitation",)
    yields: ClassVar[Yield] = "strain"

    def activation(self, states: Any, drivers: Any) -> Any:
        """γ (nodes,) for the excitation."""
        return -self.beta * drivers["excitation"]
