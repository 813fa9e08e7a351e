"""An ellipse, and the paper's distorted one."""

from typing import Annotated, Any, ClassVar

from myostrain.geometry.body import cells_along, check_size, tag_boundary
from myostrain.geometry.meshed import Meshed
from myostrain.validation import Positive, description

import basix.ufl
import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import mesh as dmesh
from pydantic import Field


@description
class Ellipse:
    """An ellipse that fills the rectangle [0, a] × [0, b], smoothly distorted; one boundary, "boundary".

    The paper's body is "a distorted ellipsoid, contained in a rectangle with size 130 × 180" (section 7); the
    distortion is not printed. Here the half-width is multiplied by 1 + distortion · sin θ, an egg whose
    broad end is up, and the outline scaled to touch the four sides. The mesh is n rings of triangles,
    6 n² in all, mapped from the disk.

    Args:
        size: Sides (a, b) of the rectangle, positive.
        spacing: Mean distance between the rings; n = √(a b) / (2 spacing), rounded.
        distortion: Distortion, −0.5 to 0.5; zero is an ellipse.
    """

    size: tuple[Positive, Positive]
    spacing: Positive = 1.0
    distortion: Annotated[float, Field(ge=-0.5, le=0.5, strict=True)] = 0.0
    dim: ClassVar[int] = 2

    def from_disk(self, disk: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Map points (n, 2) of the unit disk to the body."""
        theta = np.linspace(0, 2 * np.pi, 20_001)
        half_width = np.max(np.cos(theta) * (1 + self.distortion * np.sin(theta)))
        a, b = self.size
        x = disk[:, 0] * (1 + self.distortion * disk[:, 1]) / half_width
        return np.column_stack([a / 2 * (1 + x), b / 2 * (1 + disk[:, 1])])

    def counts(self) -> tuple[float, float]:
        """About how many nodes and cells the mesh has, before it is made."""
        a, b = self.size
        rings = max(2.0, np.sqrt(a) * np.sqrt(b) / 2 / self.spacing)
        return float(1 + 3 * rings * (rings + 1)), float(6 * rings * rings)

    def mesh(self, comm: Any) -> Meshed:
        """Mesh the body over the processes of ``comm``."""
        a, b = self.size
        check_size(1.5 * (a / self.spacing) * (b / self.spacing))
        rings = max(2, cells_along(np.sqrt(a * b) / 2, self.spacing))
        points, cells = np.empty((0, 2)), np.empty((0, 3), dtype=np.int64)
        if comm.rank == 0:
            disk, cells = disk_of_rings(rings)
            points = self.from_disk(disk)
        element = ufl.Mesh(basix.ufl.element("Lagrange", "triangle", 1, shape=(2,)))
        mesh = dmesh.create_mesh(comm, cells, element, points)
        return Meshed(mesh, *tag_boundary(mesh, {"boundary": lambda x: np.full(x.shape[1], True)}), None, {})


def disk_of_rings(rings: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Points (n, 2) and triangles (6 rings², 3) of the unit disk; ring i has 6 i points."""
    ring = np.repeat(np.arange(rings + 1), np.maximum(1, 6 * np.arange(rings + 1)))
    first = np.concatenate([[0], 1 + 3 * np.arange(rings + 1) * np.arange(1, rings + 2)])  # of each ring
    place = np.arange(len(ring)) - first[ring]
    angle = 2 * np.pi * place / np.maximum(1, 6 * ring)
    points = (ring / rings)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])

    def node(i: Any, j: Any) -> Any:
        return first[i] + np.where(i == 0, 0, j % np.maximum(1, 6 * i))

    # Triangles with a side on ring i ≥ 1 (pointing in), then those with a side on the ring inside it.
    i, j = ring[1:], place[1:]
    sector, step = j // i, j % i
    inner = sector * (i - 1) + step
    inwards = np.column_stack([node(i, j), node(i, j + 1), node(i - 1, inner)])
    both = step < i - 1
    i, j, inner = i[both], j[both], inner[both]
    outwards = np.column_stack([node(i - 1, inner), node(i, j + 1), node(i - 1, inner + 1)])
    return points, np.concatenate([inwards, outwards])
