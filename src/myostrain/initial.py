"""Initial potential."""

from __future__ import annotations

from myostrain.engine import MPI
from myostrain.errors import InputError
from myostrain.potential import Potential
from myostrain.validation import Finite, Positive, description

import numpy as np


@description
class Bump:
    """v = potential where |X − center| ≤ radius, the cell's resting potential elsewhere.

    Args:
        potential: Value in the bump.
        center: Its centre, material coordinates; missing components are zero.
        radius: Its radius, positive.
    """

    potential: Finite
    center: tuple[Finite, ...]
    radius: Positive

    def apply(self, to: Potential) -> None:
        """Set the potential.

        Raises:
            InputError: ``center`` has another dimension than the body, or no node lies in the bump.
        """
        dim = to.body.dim
        if not dim <= len(self.center) <= 3:
            raise InputError(f"{list(self.center)}: give {dim} coordinates", "initial.center")
        X = to.v.function_space.tabulate_dof_coordinates()[:, :dim]
        distance = np.linalg.norm(X - np.asarray(self.center[:dim]), axis=1)
        inside = distance <= self.radius * (1 + 1e-12)
        if not to.body.comm.allreduce(bool(inside.any()), MPI.LOR):
            nearest = to.body.comm.allreduce(float(distance.min(initial=np.inf)), MPI.MIN)
            raise InputError(
                f"no node of the mesh lies within {self.radius} of {list(self.center)}; the nearest is "
                f"{nearest:.4g} away: a larger radius, another centre, or a finer mesh",
                "initial.radius",
            )
        to.v.x.array[:] = np.where(inside, self.potential, to.cell.resting_potential())
