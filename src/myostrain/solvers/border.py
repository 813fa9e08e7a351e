"""A few numbers beside a field as unknowns, each with an equation: a bordered system."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from myostrain.engine import fem, lasting
from myostrain.solvers.factors import refine
from myostrain.solvers.linear import owned_dofs

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Bordered(Protocol):
    """Numbers λ (n,) in the residual R(u, λ), and n equations g(u, λ) = 0 for them."""

    @property
    def numbers(self) -> Array:
        """λ (n,), the same on all processes."""
        ...

    def put(self, values: Array) -> None:
        """Take λ (n,)."""
        ...

    def columns(self) -> Sequence[Array]:
        """∂R/∂λ, n arrays of local degrees of freedom whose owned entries count (collective)."""
        ...

    def equations(self) -> tuple[Array, Array, Array]:
        """g (n,), ∂g/∂u (n, local degrees of freedom) and ∂g/∂λ (n, n) at the present state (collective)."""
        ...


class Border:
    """Solves a bordered system by block elimination.

    A correction of u and λ solves [[K, B], [C, D]] (du, dλ) = (R, g). With X = K⁻¹B and y = K⁻¹R, λ follows
    from the small matrix S = D − C X, S dλ = g − C y, and du = y − X dλ. X takes a solve a number with each
    factorization, and is kept with it; C, D and g are always those of the present state, so that the
    equations hold to second order in the correction however old the factorization is.

    Args:
        of: The numbers and their equations.
        space: Space of the field.
        fixed: Local degrees of freedom that are held.
    """

    def __init__(self, of: Bordered, space: fem.FunctionSpace, fixed: npt.NDArray[np.int32]) -> None:
        self.of, self._fixed = of, fixed
        self._comm, self._owned = lasting(space.mesh.comm), owned_dofs(space)
        self._b, self._x = fem.Function(space), fem.Function(space)
        size = len(of.numbers)
        self.step = np.zeros(size)  # dλ of the last correction
        self._solved = np.zeros((size, self._owned))  # Xᵀ

    def assemble(self) -> None:
        """Take the equations at the present state (collective)."""
        self._g, rows, self._by_numbers = self.of.equations()
        self._rows = rows[:, : self._owned]

    def factor(self, ksp: Any, *, rounded: bool = False) -> None:
        """Solve for the columns by a new factorization, once more for what rounding left (collective)."""
        for solution, column in zip(self._solved, self.of.columns(), strict=True):
            self._b.x.array[: self._owned] = column[: self._owned]
            self._b.x.array[self._fixed] = 0.0
            ksp.solve(self._b.x.petsc_vec, self._x.x.petsc_vec)
            if rounded:
                refine(ksp, self._b.x.petsc_vec, self._x.x.petsc_vec, slice(0, self._owned))
            solution[:] = self._x.x.array[: self._owned]

    def correct(self, du: Array) -> None:
        """Make of y, in place, the correction du, and set :attr:`step`; NaN if that is impossible."""
        products = np.column_stack([self._rows @ self._solved.T, self._rows @ du[: self._owned]])
        products = self._sum(products)
        schur, right = self._by_numbers - products[:, :-1], self._g - products[:, -1]
        try:
            self.step = np.linalg.solve(schur, right)
        except np.linalg.LinAlgError:
            self.step = np.full_like(right, np.nan)
        du[: self._owned] -= self.step @ self._solved

    def _sum(self, values: Array) -> Array:
        return values if self._comm.size == 1 else np.asarray(self._comm.allreduce(values))
