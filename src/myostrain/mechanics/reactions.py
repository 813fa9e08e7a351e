"""The forces by which supports hold a body."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from myostrain.engine import compile_form, fem, lasting
from myostrain.geometry import Body
from myostrain.mechanics.external_forces import ExternalForces
from myostrain.mechanics.supports import AXES, Hold
from myostrain.solvers.linear import owned_dofs
from myostrain.solvers.newton import ChordNewton

import numpy as np
import ufl


class Reactions:
    """Forces on the body by part of the boundary that holds it: fixed, sliding, prescribed, springs, dampers.

    They add up to what balances the loads, and the inertia. Of held parts they are sums of nodal forces, as
    exact as the displacement's energy; a node of two such parts counts for the first of them (fixed ones,
    then sliding, then prescribed). Of springs they are −∫ k u dS, of dampers −∫ c v dS. Units are those of
    the modulus times an area (in a sheet, times a length; on a line, as the modulus).

    Args:
        body: The reference body.
        u: The unknown.
        displacement: The displacement in it, UFL.
        holds: Components of the displacement that are held.
        external: Loads and springs.
        solver: Whose residual has the forces.

    Attributes:
        names: "reaction_PART_x", ...; PART is "boundary" for springs on all of it.
    """

    def __init__(
        self,
        body: Body,
        u: fem.Function,
        displacement: Any,
        holds: Sequence[Hold],
        external: ExternalForces,
        solver: ChordNewton,
    ) -> None:
        self._comm, self._solver = lasting(body.mesh.comm), solver
        self._dofs: list[tuple[str, np.ndarray]] = []
        self._forms: list[tuple[str, fem.Form]] = []
        owned, seen = owned_dofs(u.function_space), np.zeros(0, dtype=np.int32)
        for hold in holds:
            mine = np.setdiff1d(hold.dofs[hold.dofs < owned], seen)
            seen = np.union1d(seen, mine)
            self._dofs.append((f"reaction_{hold.part}_{AXES[hold.axis]}", mine))
        pulls = [
            (-k * (displacement if normal is None else ufl.dot(displacement, normal) * normal), parts)
            for k, parts, normal in external.springs
        ]
        pulls += [(-c * v, parts) for c, v, parts in external.dampers]
        for force, parts in pulls:
            for part in parts or ["boundary"]:
                measure = body.boundary_measure(None if parts is None else [part], 4)
                for axis in range(body.dim):
                    form = compile_form(force[axis] * measure)
                    self._forms.append((f"reaction_{part}_{AXES[axis]}", form))
        self.names = list(dict.fromkeys(name for name, _ in (*self._dofs, *self._forms)))

    def values(self) -> dict[str, float]:
        """The forces by name, on all processes (collective)."""
        found = dict.fromkeys(self.names, 0.0)
        forces = self._solver.forces()
        for name, dofs in self._dofs:
            found[name] += float(forces[dofs].sum())
        for name, form in self._forms:
            found[name] += float(fem.assemble_scalar(form))
        total = self._comm.allreduce(np.array([found[name] for name in self.names]))
        return dict(zip(self.names, (total + 0.0).tolist(), strict=True))
