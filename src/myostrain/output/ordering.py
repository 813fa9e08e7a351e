"""An order of the degrees of freedom that does not depend on how the mesh is spread over processes."""

from __future__ import annotations

from typing import Any

from myostrain.engine import fem, lasting
from myostrain.geometry.numbering import canonical_numbers
from myostrain.state import CellState

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]


class Ordering:
    """Canonical numbers of a Lagrange space's degrees of freedom, by the nodes of the mesh as it was given.

    A degree of freedom belongs to a vertex or an edge; vertices come first, in the order of the mesh's nodes,
    then edges by their two nodes. The parts of a mixed space follow each other.

    Args:
        space: A scalar, vector-valued or mixed Lagrange space of degree 1 or 2 on straight simplices.

    Attributes:
        size: Global number of degrees of freedom, blocks counted out.
        positions: Canonical number of each local degree of freedom (owned and ghost, blocks counted out).
    """

    def __init__(self, space: fem.FunctionSpace) -> None:
        self._comm = lasting(space.mesh.comm)
        index_map, block = space.dofmap.index_map, space.dofmap.index_map_bs
        self._owned = index_map.size_local * block
        self.size = int(index_map.size_global * block)
        local = (index_map.size_local + index_map.num_ghosts) * block
        self.positions: Numbers = np.full(local, -1, dtype=np.int64)
        offset = 0
        for part, dofs in _parts(space):
            numbers = canonical_numbers(part)
            block = part.dofmap.index_map_bs
            unrolled = (numbers[:, None] * block + np.arange(block)).reshape(-1)
            self.positions[slice(None) if dofs is None else dofs] = offset + unrolled
            offset += int(part.dofmap.index_map.size_global * block)

    def gather(self, local: Array) -> Array | None:
        """The whole array in canonical order on the first process, None elsewhere (collective)."""
        mine = self.positions[: self._owned], local[: self._owned]
        parts = [mine] if self._comm.size == 1 else self._comm.gather(mine, root=0)
        if parts is None:
            return None
        whole = np.empty(self.size)
        for positions, values in parts:
            whole[positions] = values
        return whole

    def take(self, whole: Array) -> Array:
        """This process's local values, ghosts included, of a whole array that every process has."""
        return whole[self.positions]


def gather_cells(ordering: Ordering, state: CellState) -> tuple[Numbers | None, Array | None]:
    """Values of cells on the first process, None elsewhere (collective).

    Returns:
        Canonical numbers of the cells' corners (cells, corners), rising, and the values there; the cells in
        the order of their corners.
    """
    numbers = ordering.positions[state.space.dofmap.list[state.cells]]
    turn = np.argsort(numbers, axis=1)
    mine = np.take_along_axis(numbers, turn, 1), np.take_along_axis(state.values, turn[..., None], 1)
    parts = lasting(state.space.mesh.comm).gather(mine, root=0)
    if parts is None:
        return None, None
    corners, values = (np.concatenate(each) for each in zip(*parts, strict=True))
    order = np.lexsort(corners.T[::-1])
    return corners[order], values[order]


def take_cells(ordering: Ordering, space: fem.FunctionSpace, corners: Numbers, values: Array) -> CellState:
    """This process's part of what :func:`gather_cells` gave, which every process has."""
    own = space.mesh.topology.index_map(space.mesh.topology.dim).size_local
    numbers = ordering.positions[space.dofmap.list[:own]]
    turn = np.argsort(numbers, axis=1)
    mine, given = (
        np.ascontiguousarray(rows).view([("", np.int64)] * rows.shape[1]).reshape(-1)
        for rows in (np.take_along_axis(numbers, turn, 1), corners)
    )
    cells = np.flatnonzero(np.isin(mine, given))
    found = np.empty((len(cells), *values.shape[1:]))
    rows = np.searchsorted(given, mine[cells])
    np.put_along_axis(found, turn[cells, :, None], values[rows], 1)
    return CellState(space, cells, found)


def _parts(space: fem.FunctionSpace) -> list[tuple[Any, Any]]:
    """The space itself, or the parts of a mixed one with their degrees of freedom in it."""
    if space.num_sub_spaces == 0 or space.dofmap.index_map_bs > 1:
        return [(space, None)]
    return [space.sub(i).collapse() for i in range(space.num_sub_spaces)]
