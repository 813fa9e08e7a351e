"""Orthotropic exponential material of Usyk, LeGrice and McCulloch."""

from typing import Any, ClassVar

from myostrain.directions import with_sheets
from myostrain.validation import Positive, description

import ufl


@description
class Usyk2002:
    """Orthotropic myocardium: W = C/2 (exp Q − 1), with E = (FeᵀFe − 1)/2.

    Q = bff E_ff² + bss E_ss² + bnn E_nn² + 2 bfs E_fs² + 2 bfn E_fn² + 2 bns E_ns².

    With bss = bnn = bns and bfs = bfn it is :class:`Guccione1995`. Energy and stress at rest are zero.

    Source, and of the default parameters: T. P. Usyk, I. J. LeGrice, A. D. McCulloch, Comput. Visual. Sci. 4
    (2002) 249–257, doi 10.1007/s00791-002-0081-9.

    Args:
        C: Stiffness, a pressure (the default in kPa), positive.
        bff: Exponent of stretch along the fibre, non-dimensional, positive, as are the following.
        bss: Exponent of stretch along the sheet, across the fibre.
        bnn: Exponent of stretch along the normal of the sheet.
        bfs: Exponent of shear between fibre and sheet direction.
        bfn: Exponent of shear between fibre and normal.
        bns: Exponent of shear between normal and sheet direction.
    """

    C: Positive = 0.88
    bff: Positive = 8.0
    bss: Positive = 6.0
    bnn: Positive = 3.0
    bfs: Positive = 12.0
    bfn: Positive = 3.0
    bns: Positive = 3.0
    tensor_dim: ClassVar[int] = 3

    @property
    def modulus(self) -> float:
        """Shear modulus at rest between fibre and sheet direction, C bfs/2, by which viscosity is scaled.

        That between fibre and normal is C bfn/2, that between normal and sheet direction C bns/2.
        """
        return self.C * self.bfs / 2

    def energy(self, Fe: Any, fibres: Any) -> Any:
        """Stored energy of the elastic deformation Fe (3 × 3).

        Raises:
            InputError: The fibres come without sheets.
        """
        f0, s0, n0 = with_sheets(fibres, type(self).__name__)
        E = (Fe.T * Fe - ufl.Identity(3)) / 2
        Ef, Es, En = E * f0, E * s0, E * n0
        Q = self.bff * ufl.dot(f0, Ef) ** 2 + self.bss * ufl.dot(s0, Es) ** 2
        Q += self.bnn * ufl.dot(n0, En) ** 2 + 2 * self.bns * ufl.dot(n0, Es) ** 2
        Q += 2 * self.bfs * ufl.dot(s0, Ef) ** 2 + 2 * self.bfn * ufl.dot(n0, Ef) ** 2
        return self.C / 2 * (ufl.exp(Q) - 1)
