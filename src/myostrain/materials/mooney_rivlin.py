"""Mooney–Rivlin material."""

from typing import Any, ClassVar

from myostrain.validation import NonNegative, Positive, description

import ufl


@description
class MooneyRivlin:
    """Incompressible Mooney–Rivlin material (3.1), (3.2): W = μ/2 (I − 3) + μ₂/2 (II − 3).

    Args:
        mu: Modulus μ of the first invariant, positive.
        mu_2: Modulus μ₂ of the second invariant, zero or more.
    """

    mu: Positive = 1.0
    mu_2: NonNegative = 0.0
    tensor_dim: ClassVar[int] = 3

    @property
    def modulus(self) -> float:
        """Shear modulus at rest, by which viscosity is scaled: μ + μ₂."""
        return self.mu + self.mu_2

    def energy(self, Fe: Any, fibres: Any) -> Any:
        """Stored energy of the elastic deformation Fe (3 × 3)."""
        B = Fe * Fe.T
        first = ufl.tr(B)
        second = (first**2 - ufl.tr(B * B)) / 2
        return self.mu / 2 * (first - 3) + self.mu_2 / 2 * (second - 3)
