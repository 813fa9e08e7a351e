"""The mass that follows a front: it cancels the error of the diffusion in the direction of the front."""

from __future__ import annotations

import itertools
from typing import Any

from myostrain.engine import fem, jit_options

import numpy as np
import numpy.typing as npt
import ufl

Array = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]

#: Largest sum of the shares |mₑ| of a cell; from 1/8 on the mass of a tetrahedron may vanish.
LARGEST = 1 / 9


class FollowingMass:
    """The difference of two mass matrices, that which follows a front less the averaged one.

    Linear elements find the diffusion of a plane wave as Σₑ kₑ (2 − 2 cos κ·e) over the edges e, with the
    entries kₑ of the stiffness matrix: too small by Σₑ kₑ (κ·e)⁴/12. On a mesh that repeats itself a mass
    that is lumped less Σₑ mₑ (φᵢ − φⱼ)(φₖ − φₗ) makes up for it if

        Σₑ mₑ (κ·e)² = |cell|/12 Σₑ kₑ (κ·e)⁴ / Σₑ kₑ (κ·e)².

    Across a front v varies along e by what is proportional to κ·e. So mₑ = |cell|/12 kₑ (δₑv)²/Σ kₑ (δₑv)²,
    with the differences δₑv of v. On a line that is the averaged mass. In a plane and in a solid the averaged
    one does the same along the edges of boxes, but not between them. It is positive: where an edge of an
    obtuse cell has a negative kₑ, the mₑ are cut down to Σ|mₑ| = |cell|/9 at most. Without any mₑ in
    directions in which v does not vary, it is lumped there.

    All that is for h κ much below one. Where a cell has a part s of the whole height of the front, it gets
    1 − s⁴ of the difference, which leaves the order as it is.

    Args:
        space: P1 space of the potential.
        conductivity: D on the reference mesh, J F⁻¹ D F⁻ᵀ, a UFL expression.
        span: The height of a front.
    """

    def __init__(self, space: fem.FunctionSpace, conductivity: Any, span: float) -> None:
        self._span = span
        self._mesh, self._dim = space.mesh, space.mesh.topology.dim
        centre = np.full((1, self._dim), 1 / (self._dim + 1))
        to_reference = ufl.JacobianInverse(self._mesh)
        self._stiffness = fem.Expression(
            to_reference * conductivity * to_reference.T, centre, jit_options=jit_options()
        )
        self._edges = list(itertools.combinations(range(self._dim + 1), 2))

    def shares(self, cells: Numbers, v: Array) -> Array:
        """The mₑ of cells of unit volume.

        Args:
            cells: The cells of this process.
            v: The potential at their corners (corners, cells).

        Returns:
            Of each edge (edges, cells), in the order of ``itertools.combinations`` of the corners.
        """
        inner = self._stiffness.eval(self._mesh, cells.astype(np.int32))
        inner = np.ascontiguousarray(inner.reshape(len(cells), self._dim**2).T)
        inner = inner.reshape(self._dim, self._dim, len(cells))
        # Rows add up to zero with that of the first corner, which is left out.
        parts = np.array([
            (inner[:, j - 1].sum(axis=0) if i == 0 else -inner[i - 1, j - 1]) * (v[i] - v[j]) ** 2
            for i, j in self._edges
        ])  # fmt: skip
        parts /= np.maximum(12 * parts.sum(axis=0), np.finfo(float).tiny)
        size = np.abs(parts).sum(axis=0)
        parts *= LARGEST / np.maximum(size, LARGEST)
        return parts

    def difference(self, cells: Numbers, v: Array, values: Array) -> Array:
        """The difference of the masses of cells of unit volume, times nodal values.

        Args:
            cells: The cells of this process.
            v: The potential at their corners (cells, corners).
            values: What the mass multiplies there (cells, corners).

        Returns:
            Of each corner (cells, corners); the sum over a cell is zero.
        """
        averaged = 1 / (2 * (self._dim + 1) * (self._dim + 2))
        v, values = np.ascontiguousarray(v.T), values.T.copy()
        values *= np.maximum(1 - (np.ptp(v, axis=0) / self._span) ** 4, 0.0)
        found = np.zeros_like(values)
        for share, (i, j) in zip(self.shares(cells, v), self._edges, strict=True):
            flow = (averaged - share) * (values[i] - values[j])
            found[i] += flow
            found[j] -= flow
        return found.T
