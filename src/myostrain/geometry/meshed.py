"""A mesh with named parts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from myostrain.engine import lasting
from myostrain.errors import InputError, nearest

import numpy as np
import numpy.typing as npt
from dolfinx import mesh as dmesh


@dataclass(frozen=True)
class Meshed:
    """A mesh with named parts.

    Args:
        mesh: The mesh, whose geometry has its own dimension (1, 2 or 3).
        facet_tags: Tags of boundary facets, or None.
        boundaries: Tag of each named part of the boundary.
        cell_tags: Tags of cells, or None.
        regions: Tag of each named region.
    """

    mesh: dmesh.Mesh
    facet_tags: dmesh.MeshTags | None
    boundaries: Mapping[str, int]
    cell_tags: dmesh.MeshTags | None
    regions: Mapping[str, int]

    def facets(self, names: Iterable[str] | None, key: str | None = None) -> npt.NDArray[np.int32]:
        """Facets of the named parts of the boundary (local to this process); None means all of it.

        Args:
            names: The parts.
            key: Key of a case file that names them, for the message.

        Raises:
            InputError: A name is not one of the body's boundaries, or some of its facets lie inside the body.
        """
        topology = self.mesh.topology
        tdim = topology.dim
        topology.create_connectivity(tdim - 1, tdim)
        outside = dmesh.exterior_facet_indices(topology)
        if names is None:
            return outside
        comm, owned = lasting(self.mesh.comm), topology.index_map(tdim - 1).size_local
        facets = [np.zeros(0, dtype=np.int32)]
        for name in names:
            if name not in self.boundaries or self.facet_tags is None:
                known = self.boundaries
                hint = nearest(name, known) if known else "this mesh has no named boundaries"
                raise InputError(f"no boundary is called '{name}'; {hint}", key)
            found = self.facet_tags.find(self.boundaries[name])
            mine = found[found < owned]
            inside, number = comm.allreduce(np.array([len(np.setdiff1d(mine, outside)), len(mine)]))
            if inside:
                raise InputError(
                    f"'{name}' is not a part of the boundary: {inside} of its {number} facets lie inside the "
                    "body, between two cells; name a part of the surface, or put its facets alone into a "
                    "group of their own",
                    key,
                )
            facets.append(found)
        return np.unique(np.concatenate(facets)).astype(np.int32)
