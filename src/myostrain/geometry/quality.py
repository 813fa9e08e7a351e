"""How good the triangles or tetrahedra of a mesh are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from myostrain.engine import MPI, lasting
from myostrain.geometry.corners import corners

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True)
class Quality:
    """Quality of a mesh over all processes.

    Args:
        cells: Number of cells.
        angle_min: Smallest angle in degrees: between sides of a triangle, faces of a tetrahedron.
        angle_max: Largest such angle.
        radius_ratio_min: Least of dim · inradius / circumradius, one for a regular cell, zero for a flat one.
        radius_ratio_mean: Its mean.
        edge_min: Shortest edge.
        edge_max: Longest edge.
    """

    cells: int
    angle_min: float
    angle_max: float
    radius_ratio_min: float
    radius_ratio_mean: float
    edge_min: float
    edge_max: float


def quality(mesh: Any) -> Quality:
    """Measure the triangles or tetrahedra of a mesh, those between the corners of curved ones.

    Args:
        mesh: A DOLFINx mesh of two or three dimensions.
    """
    dim = mesh.topology.dim
    owned = mesh.topology.index_map(dim).size_local
    x = corners(mesh)[:owned]
    # Gradients of the barycentric coordinates: inward normals of the sides, each as long as 1 / height.
    edges = x[:, 1:] - x[:, :1]
    gradients = np.swapaxes(np.linalg.inv(edges), 1, 2)
    gradients = np.concatenate([-gradients.sum(axis=1, keepdims=True), gradients], axis=1)
    heights = 1 / np.linalg.norm(gradients, axis=2)
    i, j = np.triu_indices(dim + 1, 1)
    cosine = -np.einsum("cpk,cpk->cp", gradients[:, i], gradients[:, j]) * heights[:, i] * heights[:, j]
    angles = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    inradius = 1 / (1 / heights).sum(axis=1)
    # The centre c of the circumsphere from the first corner: 2 c · edge = |edge|².
    centre = np.linalg.solve(2 * edges, (edges**2).sum(axis=2)[..., None])[..., 0]
    ratio = dim * inradius / np.linalg.norm(centre, axis=1)
    lengths = np.linalg.norm(x[:, i] - x[:, j], axis=2)

    comm = lasting(mesh.comm)

    def least(values: npt.NDArray[np.float64]) -> float:
        return float(comm.allreduce(values.min(initial=np.inf), MPI.MIN))

    cells = int(comm.allreduce(len(x), MPI.SUM))
    return Quality(
        cells=cells,
        angle_min=least(angles),
        angle_max=-least(-angles),
        radius_ratio_min=least(ratio),
        radius_ratio_mean=float(comm.allreduce(ratio.sum(), MPI.SUM)) / cells,
        edge_min=least(lengths),
        edge_max=-least(-lengths),
    )
