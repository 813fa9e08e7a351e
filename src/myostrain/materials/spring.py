"""The line's linear spring."""

from typing import Any, ClassVar

from myostrain.validation import Positive, description


@description
class Spring:
    """Linear spring of the one-dimensional continuum (4.2): W = μ/2 (Fe − 1)², P = μ (Fe − 1).

    Args:
        mu: Stiffness μ (non-dimensional in the paper's cases), positive.
    """

    mu: Positive = 1.0
    tensor_dim: ClassVar[int] = 1

    @property
    def modulus(self) -> float:
        """Stiffness, by which viscosity is scaled."""
        return self.mu

    def energy(self, Fe: Any, fibres: Any) -> Any:
        """Stored energy of the stretch Fe (1 × 1)."""
        return self.mu / 2 * (Fe[0, 0] - 1) ** 2
