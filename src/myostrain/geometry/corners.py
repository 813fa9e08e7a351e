"""The corners of cells, whatever the degree of the geometry."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def corner_nodes(mesh: Any) -> npt.NDArray[np.int32]:
    """Numbers in the mesh's geometry of the corners of each local cell, (cells, corners)."""
    return np.asarray(mesh.geometry.dofmaps[0][:, : mesh.topology.dim + 1])


def corners(mesh: Any) -> npt.NDArray[np.float64]:
    """Coordinates (cells, corners, dim) of the corners of each local cell."""
    return np.asarray(mesh.geometry.x[corner_nodes(mesh)][..., : mesh.geometry.dim])


def is_curved(mesh: Any) -> bool:
    """Whether cells have nodes between their corners."""
    return bool(mesh.geometry.dofmaps[0].shape[1] > mesh.topology.dim + 1)
