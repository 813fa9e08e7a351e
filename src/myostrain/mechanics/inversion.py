"""Whether a deformed body is still one: det F and det Fo are positive."""

from __future__ import annotations

from typing import Any

from myostrain.engine import fem, jit_options
from myostrain.errors import ComputationError
from myostrain.geometry import Body
from myostrain.mechanics.active_body import ActiveBody

import basix
import numpy as np
import ufl


class Orientation:
    """The determinants of F and of Fo at points of each cell.

    Args:
        body: The reference body.
        active: The equations of the body.
        u: The unknown.
        a: The activation.
    """

    def __init__(self, body: Body, active: ActiveBody, u: fem.Function, a: Any) -> None:
        mesh = body.mesh
        self._body = body
        points = basix.make_quadrature(getattr(basix.CellType, mesh.topology.cell_type.name), 2)[0]
        determinants = ufl.as_vector([ufl.det(active.gradient(u)), ufl.det(active.active(a))])
        self._determinants = fem.Expression(determinants, points, jit_options=jit_options())
        self._cells = np.arange(mesh.topology.index_map(mesh.topology.dim).size_local, dtype=np.int32)

    def check(self) -> None:
        """Refuse a body that is inverted, or an active deformation that is (γ ≤ −1).

        Raises:
            ComputationError: It is, with the place.
        """
        values = self._determinants.eval(self._body.mesh, self._cells)
        mine: tuple[float, list[float]] = (np.inf, [])
        if len(self._cells):
            # NaN must not pass.
            of_cell = (
                np.nan_to_num(values, nan=-np.inf, neginf=-np.inf).reshape(len(self._cells), -1).min(axis=1)
            )
            cell = int(np.argmin(of_cell))
            corners = self._body.mesh.geometry.x[self._body.mesh.geometry.dofmaps[0][cell]]
            mine = float(of_cell[cell]), np.round(corners.mean(axis=0)[: self._body.dim], 4).tolist()
        worst, where = min(self._body.comm.allgather(mine))
        if not worst > 0:
            raise ComputationError(
                f"the body is inverted near {where}: det F or det Fo is {worst:.3g}",
                where=where,
                advice="a smaller time step, or a smaller activation or load.",
            )
