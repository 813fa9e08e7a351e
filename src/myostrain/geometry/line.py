"""A line."""

from typing import Any, ClassVar

from myostrain.geometry.body import cells_along, check_size, tag_boundary
from myostrain.geometry.meshed import Meshed
from myostrain.validation import Positive, description

import numpy as np
from dolfinx import mesh as dmesh


@description
class Line:
    """The interval 0 ≤ X ≤ length with equal cells; boundaries "left" and "right".

    Args:
        length: Length, positive.
        spacing: Desired cell size; the nearest that divides the length is taken.
    """

    length: Positive
    spacing: Positive = 1.0
    dim: ClassVar[int] = 1

    def counts(self) -> tuple[float, float]:
        """About how many nodes and cells the mesh has, before it is made."""
        cells = max(1.0, self.length / self.spacing)
        return cells + 1, cells

    def mesh(self, comm: Any) -> Meshed:
        """Mesh the line over the processes of ``comm``."""
        check_size(self.length / self.spacing)
        mesh = dmesh.create_interval(comm, cells_along(self.length, self.spacing), [0.0, self.length])
        parts = {
            "left": lambda x: np.isclose(x[0], 0.0, atol=1e-9 * self.length),
            "right": lambda x: np.isclose(x[0], self.length),
        }
        return Meshed(mesh, *tag_boundary(mesh, parts), None, {})
