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
        of_active = ufl.det(active.active(a))
        determinants = ufl.as_vector([ufl.det(active.gradient(u)), of_active])
        self._determinants = fem.Expression(determinants, points, jit_options=jit_options())
        self._of_active = fem.Expression(ufl.as_vector([of_active, a]), points, jit_options=jit_options())
        self._cells = np.arange(mesh.topology.index_map(mesh.topology.dim).size_local, dtype=np.int32)

    def check(self) -> None:
        """Refuse a body that is inverted, or an active deformation that is (γ ≤ −1).

        Raises:
            ComputationError: It is, with the place.
        """
        values = self._determinants.eval(self._body.mesh, self._cells)
        worst, where, _ = self._worst(values.reshape(len(self._cells), -1))
        if not worst > 0:
            raise ComputationError(
                f"the body is inverted near {where}: det F or det Fo is {worst:.3g}",
                where=where,
                advice="a smaller time step, or a smaller activation or load.",
            )

    def check_active(self) -> None:
        """Refuse an active deformation that is singular or no number, whatever the body does.

        Raises:
            ComputationError: It is, with the place and the activation there.
        """
        values = self._of_active.eval(self._body.mesh, self._cells).reshape(len(self._cells), -1, 2)
        worst, where, gamma = self._worst(values[:, :, 0], values[:, :, 1])
        if not worst > 0:
            what = f"{worst:.3g}" if np.isfinite(worst) else "not a number"
            raise ComputationError(
                f"the active deformation is singular near {where}: det Fo is {what} for an activation of "
                f"{gamma:.4g}",
                where=where,
                advice="a smaller activation, or another active deformation (one with a ratio K needs "
                "γ > −1/K). Where γ follows the potential, a weaker stimulus: a strong one drives the "
                "potential above the membrane's range.",
            )

    def _worst(self, values: Any, others: Any = None) -> tuple[float, list[float], float]:
        """The least of values (cells, points) over all processes, its place, and the other value there."""
        mine: tuple[float, list[float], float] = (np.inf, [], 0.0)
        if len(self._cells):
            values = np.nan_to_num(values, nan=-np.inf, neginf=-np.inf)  # NaN must not pass
            cell, point = np.unravel_index(int(np.argmin(values)), values.shape)
            corners = self._body.mesh.geometry.x[self._body.mesh.geometry.dofmaps[0][cell]]
            where = np.round(corners.mean(axis=0)[: self._body.dim], 4).tolist()
            mine = float(values[cell, point]), where, 0.0 if others is None else float(others[cell, point])
        return min(self._body.comm.allgather(mine))
