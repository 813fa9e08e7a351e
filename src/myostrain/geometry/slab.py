"""A slab."""

from typing import Any, ClassVar

from myostrain.geometry.body import cells_along, check_size, tag_boundary
from myostrain.geometry.meshed import Meshed
from myostrain.validation import Positive, description

import numpy as np
from dolfinx import mesh as dmesh


@description
class Slab:
    """The block [0, a] × [0, b] × [0, c], divided into boxes of six tetrahedra each.

    Boundaries: "left", "right" (across X), "front", "back" (across Y), "bottom", "top" (across Z).

    Args:
        size: Sides (a, b, c), positive.
        spacing: Desired cell size; the nearest that divides each side is taken.
    """

    size: tuple[Positive, Positive, Positive]
    spacing: Positive = 1.0
    dim: ClassVar[int] = 3

    def counts(self) -> tuple[float, float]:
        """About how many nodes and cells the mesh has, before it is made."""
        a, b, c = (max(1.0, side / self.spacing) for side in self.size)
        return (a + 1) * (b + 1) * (c + 1), 6 * a * b * c

    def mesh(self, comm: Any) -> Meshed:
        """Mesh the slab over the processes of ``comm``."""
        sides = np.array(self.size)
        boxes = [cells_along(side, self.spacing) for side in self.size]
        check_size(6 * float(np.prod(np.array(boxes, dtype=float))))
        mesh = dmesh.create_box(comm, [np.zeros(3), sides], boxes, dmesh.CellType.tetrahedron)
        names = (("left", "right"), ("front", "back"), ("bottom", "top"))
        parts = {}
        for axis, (low, high) in enumerate(names):
            parts[low] = _at(axis, 0.0, sides[axis])
            parts[high] = _at(axis, sides[axis], sides[axis])
        return Meshed(mesh, *tag_boundary(mesh, parts), None, {})


def _at(axis: int, place: float, side: float) -> Any:
    return lambda x: np.abs(x[axis] - place) < 1e-9 * side
