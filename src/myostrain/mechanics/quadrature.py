"""Values of UFL expressions at quadrature points, and integrals, outside of any assembly."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from myostrain.engine import fem, jit_options, lasting

import basix
import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import mesh as dmesh

Array = npt.NDArray[np.float64]


class QuadraturePoints:
    """The quadrature points of cells that this process owns.

    Args:
        mesh: The mesh.
        degree: Degree of the quadrature.
        cells: Local numbers of the cells; all that this process owns unless given.

    Attributes:
        cells: The cells.
        weights: What each point stands for of the reference volume, (cells, points).
    """

    def __init__(
        self, mesh: dmesh.Mesh, degree: int, cells: npt.NDArray[np.integer[Any]] | None = None
    ) -> None:
        topology = mesh.topology
        self._mesh, self._comm = mesh, lasting(mesh.comm)
        owned = np.arange(topology.index_map(topology.dim).size_local)
        self.cells = np.asarray(owned if cells is None else cells, dtype=np.int32)
        cell_type = getattr(basix.CellType, topology.cell_type.name)
        self._points, weights = basix.make_quadrature(cell_type, degree)
        self.weights = weights * np.abs(self.values(ufl.JacobianDeterminant(mesh))())

    def values(self, expression: Any) -> Callable[[], Array]:
        """Prepare the evaluation of a UFL expression; call the result for its values (cells, points, ...)."""
        compiled = fem.Expression(expression, self._points, jit_options=jit_options())
        return lambda: np.asarray(compiled.eval(self._mesh, self.cells))

    def integral(self, values: Array) -> Array:
        """Integral over the reference body, on all processes, of values (cells, points, ...) (collective)."""
        return np.asarray(self._comm.allreduce(np.einsum("cq,cq...->...", self.weights, values)))


def integral(form: fem.Form, comm: Any) -> float:
    """Value of a scalar form over all processes (collective)."""
    return float(comm.allreduce(fem.assemble_scalar(form)))
