"""Values at nodes of what is known within cells, by linear fits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from myostrain.engine import fem
from myostrain.mechanics.quadrature import QuadraturePoints

import basix
import numpy as np
import numpy.typing as npt
from dolfinx.la import InsertMode
from scipy.sparse import csr_array

Array = npt.NDArray[np.float64]

#: Degree of the quadrature whose points are fitted: its weights are positive on every cell.
DEGREE = 2


class Recovery:
    """Values at the nodes of linear elements of fields that are smooth within cells only.

    The value at a node is that of the linear function which fits the field best in the cells around: least
    squares, weighted by the node's linear element. So a linear field is met exactly at every node, on the
    boundary too, where a mean over the cells on one side errs by the slope; a smooth one to second order.
    The idea is that of O. C. Zienkiewicz, J. Z. Zhu, Int. J. Numer. Meth. Engng. 33 (1992) 1331–1364,
    doi 10.1002/nme.1620330702.

    Args:
        space: Scalar P1 space.
    """

    def __init__(self, space: fem.FunctionSpace) -> None:
        self._space = space
        self._points = points = QuadraturePoints(space.mesh, DEGREE)
        self._sums: dict[int, fem.Function] = {}
        mesh = space.mesh
        cell, dim = getattr(basix.CellType, mesh.topology.cell_type.name), mesh.geometry.dim
        places, _ = basix.make_quadrature(cell, DEGREE)
        shares = np.concatenate([1 - places.sum(axis=1, keepdims=True), places], axis=1)
        nodes = space.dofmap.list[points.cells]
        shape = (len(points.cells), len(places), nodes.shape[1])  # cells, points, nodes
        weights = points.weights[:, :, None] * shares
        x = np.einsum("pn,cnd->cpd", *self._geometry(places, points.cells))
        at = np.zeros((self._count, dim))
        at[space.dofmap.list] = mesh.geometry.x[mesh.geometry.dofmaps[0][:, : dim + 1], :dim]
        arms = x[:, :, None, :] - at[nodes][:, None, :, :]
        rows = np.broadcast_to(nodes[:, None, :], shape).reshape(-1)
        columns = np.repeat(np.arange(shape[0] * shape[1]), shape[2])
        size = (self._count, shape[0] * shape[1])

        def summed(values: Array) -> Array:
            """Sums over the points around each node of values (cells, points, nodes, k)."""
            sums = [
                np.bincount(rows, v, self._count) for v in np.moveaxis(values, -1, 0).reshape(-1, rows.size)
            ]
            return self._shared(np.stack(sums, axis=1))

        # The fit at the node: (1 + c·S⁻¹c) b₀ − S⁻¹c·b₁ with b₀ the mean, b₁ that of value times arm,
        # c the mean arm, S the arms' covariance.
        whole = summed(weights[..., None])
        centre = summed(weights[..., None] * arms) / whole
        squares = (arms[..., :, None] * arms[..., None, :]).reshape(*shape, dim**2)
        spread = summed(weights[..., None] * squares).reshape(-1, dim, dim) / whole[..., None]
        spread -= centre[:, :, None] * centre[:, None, :]
        slope = np.linalg.solve(spread, centre[..., None])[..., 0] / whole
        level = 1 / whole[:, 0] + (slope * centre).sum(axis=1)
        entries = weights * (level[nodes][:, None, :] - np.einsum("cpnd,cnd->cpn", arms, slope[nodes]))
        self._operator = csr_array((entries.reshape(-1), (rows, columns)), shape=size)

    def _geometry(self, places: Array, cells: npt.NDArray[np.int32]) -> tuple[Array, Array]:
        """Shares of the geometry's nodes in the points (points, nodes), and these (cells, nodes, dim)."""
        mesh = self._space.mesh
        element = basix.create_element(
            basix.ElementFamily.P,
            getattr(basix.CellType, mesh.topology.cell_type.name),
            mesh.geometry.cmaps[0].degree,
            basix.LagrangeVariant.equispaced,
        )
        nodes = mesh.geometry.x[mesh.geometry.dofmaps[0][cells]][..., : mesh.geometry.dim]
        return element.tabulate(0, places)[0, :, :, 0], nodes

    @property
    def _count(self) -> int:
        index_map = self._space.dofmap.index_map
        return int(index_map.size_local + index_map.num_ghosts)

    def _shared(self, values: Array) -> Array:
        """Values (nodes, k) summed over the processes that have a node (collective)."""
        k = values.shape[1]
        if k not in self._sums:
            self._sums[k] = fem.Function(fem.functionspace(self._space.mesh, ("Lagrange", 1, (k,))))
        vector = self._sums[k].x
        vector.array[:] = values.reshape(-1)
        vector.scatter_reverse(InsertMode.add)
        vector.scatter_forward()
        return np.asarray(vector.array.reshape(-1, k)).copy()

    def prepare(self, expression: Any) -> Callable[[], Array]:
        """Compile a UFL scalar or vector; call the result for its values (nodes, components) (collective)."""
        values = self._points.values(expression)

        def found() -> Array:
            own = values()
            return self._shared(self._operator @ own.reshape(own.shape[0] * own.shape[1], -1))

        return found
