"""Expressions of one mesh at points that are known by cell and place in it."""

from __future__ import annotations

from typing import Any

from myostrain.engine import fem, jit_options

import basix
import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import mesh as dmesh

Array = npt.NDArray[np.float64]
Cells = npt.NDArray[np.int32]


class CellFields:
    """An expression in every cell, as the polynomial through its values at a few points.

    Args:
        mesh: The mesh.
        expression: A UFL expression on it.
        degree: Degree of the polynomials: exact for an expression of at most that degree.
    """

    def __init__(self, mesh: dmesh.Mesh, expression: Any, degree: int) -> None:
        self._mesh = mesh
        dim = mesh.topology.dim
        self._cells = np.arange(mesh.topology.index_map(dim).size_local, dtype=np.int32)
        self._element = basix.create_element(
            basix.ElementFamily.P,
            getattr(basix.CellType, mesh.topology.cell_type.name),
            degree,
            basix.LagrangeVariant.equispaced,
            discontinuous=degree == 0,
        )
        self._points = np.asarray(self._element.points)
        if not ufl.domain.extract_domains(expression):  # numbers only
            expression = fem.Constant(mesh, 1.0) * expression
        self._expression = fem.Expression(expression, self._points, jit_options=jit_options())

    def values(self) -> Array:
        """Present values (cells · points, components)."""
        found = self._expression.eval(self._mesh, self._cells)
        return np.asarray(found, dtype=float).reshape(len(self._cells) * len(self._points), -1)

    def matrix_at(self, places: Array, parents: Cells) -> Any:
        """What gives the polynomials at places of cells from :meth:`values`: a sparse matrix.

        Args:
            places: Reference coordinates (n, places, dim), or (n, dim) for one each.
            parents: The cell of each, (n,).
        """
        from scipy.sparse import csr_array  # takes a tenth of a second, which others need not wait for

        n, each = places.shape[:2]
        size = len(self._points)
        weights = self._element.tabulate(0, places.reshape(n * each, -1))[0, :, :, 0]
        columns = np.repeat(parents.astype(np.int64), each)[:, None] * size + np.arange(size)
        rows = np.arange(n * each + 1) * size
        return csr_array(
            (weights.reshape(-1), columns.reshape(-1), rows), shape=(n * each, len(self._cells) * size)
        )
