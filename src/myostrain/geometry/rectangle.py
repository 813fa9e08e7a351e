"""A rectangle."""

from typing import Any, ClassVar

from myostrain.geometry.body import cells_along, check_size, tag_boundary
from myostrain.geometry.meshed import Meshed
from myostrain.validation import Positive, description

import numpy as np
from dolfinx import mesh as dmesh


@description
class Rectangle:
    """The rectangle [0, a] × [0, b] in right-angled triangles; boundaries "left", "right", "bottom", "top".

    Args:
        size: Sides (a, b), positive.
        spacing: Desired cell size; the nearest that divides each side is taken.
    """

    size: tuple[Positive, Positive]
    spacing: Positive = 1.0
    dim: ClassVar[int] = 2

    def counts(self) -> tuple[float, float]:
        """About how many nodes and cells the mesh has, before it is made."""
        a, b = (max(1.0, side / self.spacing) for side in self.size)
        return (a + 1) * (b + 1), 2 * a * b

    def mesh(self, comm: Any) -> Meshed:
        """Mesh the rectangle over the processes of ``comm``."""
        a, b = self.size
        check_size(2 * (a / self.spacing) * (b / self.spacing))
        mesh = dmesh.create_rectangle(
            comm,
            [np.zeros(2), np.array([a, b])],
            [cells_along(a, self.spacing), cells_along(b, self.spacing)],
            dmesh.CellType.triangle,
            diagonal=dmesh.DiagonalType.left_right,
        )
        parts = {
            "left": lambda x: np.isclose(x[0], 0.0, atol=1e-9 * a),
            "right": lambda x: np.isclose(x[0], a),
            "bottom": lambda x: np.isclose(x[1], 0.0, atol=1e-9 * b),
            "top": lambda x: np.isclose(x[1], b),
        }
        return Meshed(mesh, *tag_boundary(mesh, parts), None, {})
