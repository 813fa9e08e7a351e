"""Whether the outside pushes a deformed body along motions that nothing holds."""

from __future__ import annotations

from typing import Any

from myostrain.engine import compile_form, fem, lasting
from myostrain.errors import ComputationError
from myostrain.mechanics.external_forces import ExternalForces
from myostrain.mechanics.rigid_motions import RigidMotions
from myostrain.solvers.linear import assemble_nodal, owned_dofs

import numpy as np
import numpy.typing as npt

#: Net force or moment along free motions that is refused, of all the forces that act, and of them times the
#: body's diagonal. What discretization leaves of loads that balance is far less.
SHARE = 0.01


class Balance:
    """The net force and moment of loads and springs along the free motions of the deformed body.

    Loads that balance at rest need not do so after deformation: the points that stop the body's drift would
    then carry a force of their own, and nothing would be solved that a real body does.

    Args:
        space: Displacement space, or the mixed space whose first part it is.
        u: The unknown.
        forces: What the outside adds to the residual, a UFL form.
        motions: The motions that supports leave free.
        mixed: Whether ``space`` is mixed.
        negligible: A force below which none is refused.
    """

    def __init__(
        self,
        space: fem.FunctionSpace,
        u: fem.Function,
        forces: Any,
        motions: RigidMotions,
        mixed: bool,
        negligible: float,
    ) -> None:
        self._negligible = negligible
        self._u, self._motions, self._comm = u, motions, lasting(space.mesh.comm)
        dim = space.mesh.geometry.dim
        dofs: Any
        if mixed:
            displacement, dofs = space.sub(0).collapse()
        else:
            displacement = space
            dofs = np.arange(dim * displacement.tabulate_dof_coordinates().shape[0])
        self._dofs = np.asarray(dofs).reshape(-1, dim)
        self._points = displacement.tabulate_dof_coordinates()[:, :dim]
        self._owned = self._dofs[:, 0] < owned_dofs(space)
        self._forces = compile_form(forces)

    def check(self) -> None:
        """Refuse loads that do not balance on the present configuration.

        Raises:
            ComputationError: They do not, with the numbers.
        """
        motions, dim = self._motions, self._points.shape[1]
        forces = -assemble_nodal(self._forces)[self._dofs][self._owned]
        x = (self._points + self._u.x.array[self._dofs])[self._owned]
        acting = self._comm.allreduce(float(np.linalg.norm(forces, axis=1).sum()))
        rows = sum(
            motions.rows(x, np.tile(axis, (len(x), 1))).T @ forces[:, i] for i, axis in enumerate(np.eye(dim))
        )
        total = self._comm.allreduce(np.asarray(rows))
        net = motions.free @ (motions.free.T @ total)
        if not np.abs(net).max() > max(SHARE * acting, self._negligible):
            return
        force, moment = net[:dim], net[dim:] * motions.size
        parts = [f"a net force {_listed(force)}"] + ([f"moment {_listed(moment)}"] if dim > 1 else [])
        raise ComputationError(
            f"the loads balance at rest but not on the deformed body: along motions that nothing holds they "
            f"have {' and '.join(parts)}, where all that acts adds up to {acting:.3g} (of that the net "
            f"force, and the moment over the body's diagonal {motions.size:.3g}, may be {SHARE:.0%})",
            advice="fix a part of the boundary, let one slide in its plane, or give robin > 0.",
        )


def balance_of(
    u: fem.Function, external: ExternalForces, motions: RigidMotions, mixed: bool
) -> Balance | None:
    """The balance of what acts from outside on a body that supports leave free; None where nothing does."""
    if not external.residual:
        return None
    negligible = 1e-6 * external.stiffness * motions.size ** len(motions.middle)
    return Balance(u.function_space, u, external.residual, motions, mixed, negligible)


def _listed(values: npt.NDArray[np.float64]) -> str:
    return f"({', '.join(f'{value:.3g}' for value in values)})"
