"""Numbers of a space's nodes that do not depend on how the mesh is spread over processes."""

from __future__ import annotations

from typing import Any

from myostrain.engine import lasting

import basix
import numpy as np
import numpy.typing as npt

Numbers = npt.NDArray[np.int64]


def canonical_numbers(space: Any) -> Numbers:
    """Canonical number of each local node of a space, ghosts included, blocks not counted out (collective).

    A node belongs to a vertex or an edge; vertices come first, in the order of the mesh's nodes as they were
    given, then edges by their two nodes.

    Args:
        space: A scalar or vector-valued Lagrange space of degree 1 or 2 on straight simplices.
    """
    mesh, dofmap = space.mesh, space.dofmap
    comm = lasting(mesh.comm)
    nodes = np.asarray(mesh.geometry.input_global_indices, dtype=np.int64)[mesh.geometry.dofmaps[0]]
    base = max(comm.allgather(int(nodes.max(initial=0)))) + 1
    keys = np.full(dofmap.index_map.size_local + dofmap.index_map.num_ghosts, -1, dtype=np.int64)
    entities = basix.topology(getattr(basix.CellType, mesh.topology.cell_type.name))
    for dim, kind in enumerate(entities):
        for number, corners in enumerate(kind):
            for dof in dofmap.dof_layout.entity_dofs(dim, number):
                ends = nodes[:, corners]
                key = (dim > 0) * base**2 + ends.min(axis=1) * base + ends.max(axis=1)
                keys[dofmap.list[:, dof]] = key
    parts = comm.allgather(keys[: dofmap.index_map.size_local])
    return np.searchsorted(np.sort(np.concatenate(parts)), keys)
