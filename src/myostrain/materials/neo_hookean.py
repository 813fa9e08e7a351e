"""Neo-Hookean material."""

from typing import Any, ClassVar

from myostrain.validation import Positive, description

import ufl


@description
class NeoHookean:
    """Incompressible neo-Hookean material, (3.1) with μ₂ = 0: W = μ/2 (I − 3).

    Args:
        mu: Shear modulus μ (non-dimensional in the paper's cases), positive.
    """

    mu: Positive = 1.0
    tensor_dim: ClassVar[int] = 3

    @property
    def modulus(self) -> float:
        """Shear modulus at rest, by which viscosity is scaled."""
        return self.mu

    def energy(self, Fe: Any, fibres: Any) -> Any:
        """Stored energy of the elastic deformation Fe (3 × 3)."""
        return self.mu / 2 * (ufl.inner(Fe, Fe) - 3)
