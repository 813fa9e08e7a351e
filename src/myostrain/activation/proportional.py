"""Active strain proportional to the potential."""

from typing import Annotated, Any, ClassVar

from myostrain.activation.contracts import Yield
from myostrain.validation import description

from pydantic import Field


@description
class Proportional:
    """γ = −β v (3.4).

    Args:
        beta: Contraction β at v = 1, non-dimensional, 0 ≤ β < 1 (at β = 1, v = 1 the active deformation is
            singular); the paper takes 0.3.
    """

    beta: Annotated[float, Field(ge=0, lt=1, strict=True)] = 0.3
    drivers: ClassVar[tuple[str, ...]] = ("potential",)
    yields: ClassVar[Yield] = "strain"

    def activation(self, states: Any, drivers: Any) -> Any:
        """γ (nodes,) for the potential."""
        return -self.beta * drivers["potential"]
