"""Material of Holzapfel and Ogden as the benchmark of elastodynamics has it."""

from typing import Any, ClassVar

from myostrain.directions import with_sheets
from myostrain.validation import NonNegative, Positive, description

import ufl


@description
class Arostica2025:
    """The law of :class:`HolzapfelOgden2009` with a logistic switch, and a split of the matrix alone.

    W = a/(2b) (exp(b (Ī₁ − 3)) − 1) + Σ_{i = f, s} a_i/(2b_i) χ(I₄ᵢ) (exp(b_i (I₄ᵢ − 1)²) − 1)
    + a_fs/(2b_fs) (exp(b_fs I₈²) − 1),

    with χ(I₄) = 1/(1 + exp(−k (I₄ − 1))) and Ī₁ = (det Fe)^(−2/3) I₁. In a nearly incompressible body the
    matrix sees no change of volume, and fibres and sheets see all of Fe, not only its isochoric part. At
    rest fibres have half of their stiffness, and a little in compression.

    Source: R. Aróstica and others, Comput. Methods Appl. Mech. Eng. 435 (2025) 117485,
    doi 10.1016/j.cma.2024.117485, of which the defaults are the parameters, in Pa.

    Args:
        a: Stiffness of the matrix, a pressure, positive.
        b: Exponent of the matrix, non-dimensional, positive, as are the other exponents.
        a_f: Stiffness of the fibres, zero or more, as are the following.
        b_f: Exponent of the fibres.
        a_s: Stiffness of the sheets.
        b_s: Exponent of the sheets.
        a_fs: Stiffness of shear between fibre and sheet direction.
        b_fs: Exponent of shear between fibre and sheet direction.
        k: Steepness of the switch, positive.
    """

    a: Positive = 59.0
    b: Positive = 8.023
    a_f: NonNegative = 18472.0
    b_f: Positive = 16.026
    a_s: NonNegative = 2481.0
    b_s: Positive = 11.120
    a_fs: NonNegative = 216.0
    b_fs: Positive = 11.436
    k: Positive = 100.0
    tensor_dim: ClassVar[int] = 3
    sees_volume: ClassVar[bool] = True

    @property
    def modulus(self) -> float:
        """Shear modulus at rest between fibre and sheet direction, a + a_fs; others have a alone."""
        return self.a + self.a_fs

    def energy(self, Fe: Any, fibres: Any) -> Any:
        """Stored energy of the elastic deformation Fe (3 × 3).

        Raises:
            InputError: The fibres come without sheets.
        """
        f0, s0, _ = with_sheets(fibres, type(self).__name__)
        C = Fe.T * Fe
        I4f, I4s, I8 = ufl.dot(f0, C * f0), ufl.dot(s0, C * s0), ufl.dot(f0, C * s0)
        same_volume = ufl.det(Fe) ** (-2 / 3) * ufl.tr(C)
        return (
            self.a / (2 * self.b) * (ufl.exp(self.b * (same_volume - 3)) - 1)
            + self._switched(self.a_f, self.b_f, I4f - 1)
            + self._switched(self.a_s, self.b_s, I4s - 1)
            + self.a_fs / (2 * self.b_fs) * (ufl.exp(self.b_fs * I8**2) - 1)
        )

    def _switched(self, a: Any, b: Any, x: Any) -> Any:
        return a / (2 * b) * (ufl.exp(b * x**2) - 1) / (1 + ufl.exp(-self.k * x))
