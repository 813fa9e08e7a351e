"""A mesh with named parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

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
