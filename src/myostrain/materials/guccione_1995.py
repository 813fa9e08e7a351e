"""Transversely isotropic exponential material of Guccione and others."""

from typing import Any, ClassVar

from myostrain.validation import Positive, description

import ufl


@description
class Guccione1995:
    """Transversely isotropic myocardium: W = C/2 (exp Q − 1), with E = (FeᵀFe − 1)/2.

    Q = bf E_ff² + bt (E_ss² + E_nn² + E_sn² + E_ns²) + bfs (E_fs² + E_sf² + E_fn² + E_nf²).

    The fibre is the only special direction: Q is written in E_ff, |E f0|² and |E|², and needs no sheets.
    Energy and stress at rest are zero.

    Sources: J. M. Guccione, A. D. McCulloch, L. K. Waldman, J. Biomech. Eng. 113 (1991) 42–55,
    doi 10.1115/1.2894084; J. M. Guccione, K. D. Costa, A. D. McCulloch, J. Biomech. 28 (1995) 1167–1177,
    doi 10.1016/0021-9290(94)00174-3; in the form, and with the parameters, of S. Land and others, Proc. R.
    Soc. A 471 (2015) 20150641, doi 10.1098/rspa.2015.0641:

    =========  =======  ====  ====  =====
    problem    C (kPa)  bf    bt    bfs
    =========  =======  ====  ====  =====
    1 and 3    2        8     2     4      (the defaults)
    2          10       1     1     1
    =========  =======  ====  ====  =====

    Args:
        C: Stiffness, a pressure (kPa in the table), positive.
        bf: Exponent of stretch along the fibre, non-dimensional, positive.
        bt: Exponent across the fibre, non-dimensional, positive.
        bfs: Exponent of shear between the fibre and what is across, non-dimensional, positive.
    """

    C: Positive = 2.0
    bf: Positive = 8.0
    bt: Positive = 2.0
    bfs: Positive = 4.0
    tensor_dim: ClassVar[int] = 3

    @property
    def modulus(self) -> float:
        """Shear modulus at rest between the fibre and what is across, C bfs/2, by which viscosity is scaled.

        Shear within the plane across the fibre has C bt/2.
        """
        return self.C * self.bfs / 2

    def energy(self, Fe: Any, fibres: Any) -> Any:
        """Stored energy of the elastic deformation Fe (3 × 3)."""
        E = (Fe.T * Fe - ufl.Identity(3)) / 2
        Ef = E * fibres.f0
        along = ufl.dot(fibres.f0, Ef) ** 2
        shear = 2 * (ufl.dot(Ef, Ef) - along)
        across = ufl.inner(E, E) - along - shear
        return self.C / 2 * (ufl.exp(self.bf * along + self.bt * across + self.bfs * shear) - 1)
