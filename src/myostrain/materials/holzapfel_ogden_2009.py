"""Orthotropic material of Holzapfel and Ogden."""

from typing import Any, ClassVar

from myostrain.directions import with_sheets
from myostrain.validation import NonNegative, Positive, description

import ufl


@description
class HolzapfelOgden2009:
    """Orthotropic myocardium, with fibres and sheets that bear tension but no compression.

    W = a/(2b) (exp(b (I₁ − 3)) − 1) + Σ_{i = f, s} a_i/(2b_i) (exp(b_i ⟨I₄ᵢ − 1⟩²) − 1)
    + a_fs/(2b_fs) (exp(b_fs I₈²) − 1),

    of C = FeᵀFe by I₁ = tr C, I₄f = f0·C f0, I₄s = s0·C s0, I₈ = f0·C s0; ⟨x⟩ is x where x > 0, else 0.

    **The switch of tension.** ⟨x⟩² has a jump in its second derivative at x = 0, so that the stiffness would
    jump by 4 a_i where a fibre begins to be stretched, and Newton's iteration with it. In place of ⟨x⟩²
    stands x² (1 − (1 − x/δ)³) for 0 < x < δ: the stiffness is continuous, never negative and at most 1.38
    times the law's own, energy and stress of the fibre are exactly zero in compression, so that rest is
    without stress, and exactly the law's for x ≥ δ, a stretch of δ/2 or more. Between, to lowest order in
    b_i δ², energy differs by at most 0.0173 a_i δ², and the second Piola stress by at most 0.136 a_i δ
    (at x = 0.155 δ): 0.025 kPa for the defaults.

    The terms of fibre and sheet, convex in I₄ and never decreasing, are convex in Fe, as that of the matrix
    is. At rest only the matrix and a_fs have any stiffness, so that Newton's method takes longest in the
    first step from rest; it follows a ventricle that is filled by steps of 0.1 kPa. A wider switch hardly
    shortens that, and is less exact: at 0.1 kPa a cavity has grown by 4.3 % with δ = 0.01 and with 0.001,
    and by 4.8 % with 0.05; at 1 kPa by 26.3 % with all three. But a ventricle that fills fast after its
    contraction, where most fibres go from slack to taut, takes a fifth of the factorizations with δ = 0.1,
    and its beat is the same (`heartbeat-3d`).

    Source: G. A. Holzapfel, R. W. Ogden, Phil. Trans. R. Soc. A 367 (2009) 3445–3475,
    doi 10.1098/rsta.2009.0091; the defaults are its parameters for simple shear of pig myocardium (second row
    of table 1, fitted to data of Dokos and others 2002), in kPa. Its third row, with fibres only (biaxial
    tests), is a = 2.280, b = 9.726, a_f = 1.685, b_f = 15.779, a_s = a_fs = 0.

    Args:
        a: Stiffness of the matrix, a pressure (the default in kPa), positive.
        b: Exponent of the matrix, non-dimensional, positive, as are the other exponents.
        a_f: Stiffness of the fibres, zero or more, as are the following.
        b_f: Exponent of the fibres.
        a_s: Stiffness of the sheets.
        b_s: Exponent of the sheets.
        a_fs: Stiffness of shear between fibre and sheet direction.
        b_fs: Exponent of shear between fibre and sheet direction.
        switch: Width δ of the switch of tension, in I₄ − 1, positive.
    """

    a: Positive = 0.059
    b: Positive = 8.023
    a_f: NonNegative = 18.472
    b_f: Positive = 16.026
    a_s: NonNegative = 2.481
    b_s: Positive = 11.120
    a_fs: NonNegative = 0.216
    b_fs: Positive = 11.436
    switch: Positive = 0.01
    tensor_dim: ClassVar[int] = 3

    @property
    def modulus(self) -> float:
        """Shear modulus at rest between fibre and sheet direction, a + a_fs, by which viscosity is scaled.

        Shear with the normal has a alone.
        """
        return self.a + self.a_fs

    def energy(self, Fe: Any, fibres: Any) -> Any:
        """Stored energy of the elastic deformation Fe (3 × 3).

        Raises:
            InputError: The fibres come without sheets.
        """
        f0, s0, _ = with_sheets(fibres, type(self).__name__)
        C = Fe.T * Fe
        I4f, I4s, I8 = ufl.dot(f0, C * f0), ufl.dot(s0, C * s0), ufl.dot(f0, C * s0)
        matrix = self.a / (2 * self.b) * (ufl.exp(self.b * (ufl.tr(C) - 3)) - 1)
        return (
            matrix
            + _exponential(self.a_f, self.b_f, self._squared(I4f - 1))
            + _exponential(self.a_s, self.b_s, self._squared(I4s - 1))
            + _exponential(self.a_fs, self.b_fs, I8**2)
        )

    def _squared(self, x: Any) -> Any:
        """⟨x⟩² with a continuous second derivative."""
        tension = ufl.max_value(x, 0.0)
        return tension**2 * (1 - (1 - ufl.min_value(tension / self.switch, 1.0)) ** 3)


def _exponential(a: Any, b: Any, square: Any) -> Any:
    return a / (2 * b) * (ufl.exp(b * square) - 1)
