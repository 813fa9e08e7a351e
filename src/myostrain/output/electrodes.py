"""Pseudo-electrocardiograms: the potential that the wave makes at points outside of the body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from myostrain.electrics.diffusion import pulled_back_conductivity
from myostrain.engine import MPI, compile_form, fem, lasting
from myostrain.errors import InputError
from myostrain.geometry.points import cells_at
from myostrain.kinematics import Deformation
from myostrain.output.table import Table
from myostrain.solvers.linear import assemble_nodal, owned_dofs

import numpy as np
import numpy.typing as npt
import ufl

if TYPE_CHECKING:
    from myostrain.coupling import Electromechanics

Array = npt.NDArray[np.float64]

#: Degree of the quadrature, exact for nothing but enough a cell's size away from the body.
DEGREE = 4


class Electrodes:
    """Potentials of a body in an unbounded conductor, from the gradient of v (Gima and Rudy 2002; Plonsey).

    φ(x_e) = 1/(4π) ∫ −σ ∇v · ∇(1/r) dx with r = |x_e − x|, over the deformed body; pulled back it is
    1/(4π) ∫ −J F⁻¹ σ F⁻ᵀ ∇v · Fᵀ ∇(1/r) dX with r = |x_e − x(X)|. σ is the conductivity over that along the
    fibre, D / D_along: what is found is φ but for the factor of the conductivity along the fibre over that of
    the conductor. Of a sheet it is that per thickness, of a line that per cross section.

    Args:
        model: The coupled problem; its potential is solved for.
        points: Places in space by name, (3,); coordinates that are left out are zero. They do not move.

    Raises:
        InputError: A place has too few or too many coordinates, or lies in the body; the potential is given.

    Attributes:
        names: The names.
    """

    def __init__(self, model: Electromechanics, points: Mapping[str, Sequence[float]]) -> None:
        self._model, self.names = model, list(points)
        potential = model.potential
        if potential.solver is None:
            raise InputError(
                "the potential is given, and without a conductivity it makes no current; leave them out",
                "electrodes",
            )
        space = potential.v.function_space
        mesh, dim = space.mesh, potential.body.dim
        self._space, self._comm = space, lasting(mesh.comm)
        self._places = _places(points, dim)
        self._refuse_inside(mesh)
        deformation = potential.made_from["deformation"] or Deformation(ufl.Identity(dim))  # type: ignore[attr-defined]
        self._u = None
        at: list[ufl.core.expr.Expr] = list(ufl.SpatialCoordinate(mesh))
        if model.mechanics is not None:
            self._u = fem.Function(fem.functionspace(mesh, ("Lagrange", 1, (dim,))))
            at = [X + self._u[i] for i, X in enumerate(at)]
        self._place = fem.Constant(mesh, np.zeros(3))
        arm = [self._place[i] - (at[i] if i < dim else 0.0) for i in range(3)]
        distance = ufl.sqrt(sum(side**2 for side in arm))
        pull = deformation.F.T * ufl.as_vector(arm[:dim]) / (4 * np.pi * distance**3)
        along, across = potential.diffusivity
        conductivity = pulled_back_conductivity(deformation, potential.body.f0, 1.0, across / along, mesh)
        test = ufl.TestFunction(space)
        dx = ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": DEGREE})
        self._lead = compile_form(-ufl.inner(conductivity * ufl.grad(test), pull) * dx)
        self._leads: list[Array] = []  # of a rigid body, made once

    def _refuse_inside(self, mesh: object) -> None:
        inside, _, _ = cells_at(mesh, self._places)
        found = np.zeros(len(self._places), dtype=np.int64)
        found[inside] = 1
        self._comm.Allreduce(MPI.IN_PLACE, found, op=MPI.MAX)
        for name, place, held in zip(self.names, self._places, found, strict=True):
            if held:
                raise InputError(
                    f"{place.tolist()} lies in the body; an electrode is outside of it, in the conductor: "
                    "move it away, and off a line or a sheet by its last coordinate",
                    f"electrodes.{name}",
                )

    def values(self) -> list[float]:
        """The potentials at the electrodes now, in their order (collective)."""
        u = self._model.displacement()
        leads = self._leads
        if self._u is not None and u is not None:
            self._u.x.array[:] = u.reshape(-1)
            leads = []
        if not leads:
            for place in self._places:
                self._place.value[:] = place
                leads.append(assemble_nodal(self._lead))
        own = owned_dofs(self._space)
        v = self._model.potential.v.x.array[:own]
        local = np.array([float(lead[:own] @ v) for lead in leads])
        self._comm.Allreduce(MPI.IN_PLACE, local, op=MPI.SUM)
        return local.tolist()


class ElectrodeTable:
    """``ecg.csv``: one column per electrode.

    Args:
        model: The coupled problem.
        points: Places in space by name.
        folder: The result folder; None writes nothing.
        size: Bytes of an earlier run's table to keep and go on from; None begins anew.

    Raises:
        InputError: See :class:`Electrodes`; or the earlier table is shorter than that.
    """

    def __init__(
        self,
        model: Electromechanics,
        points: Mapping[str, Sequence[float]],
        folder: Path | None,
        size: int | None = None,
    ) -> None:
        self._model, self._electrodes = model, Electrodes(model, points)
        self._table: Table | None = None
        if folder is not None:
            columns = ["time", *self._electrodes.names]
            self._table = Table(folder / "ecg.csv", columns, lasting(model.potential.body.comm), size)

    def add(self) -> None:
        """Add a row with the present potentials (collective).

        Raises:
            ComputationError: It cannot be written.
        """
        if self._table is not None:
            self._table.add(self._model.time, self._electrodes.values())

    def size(self) -> int | None:
        """Bytes written so far, safely on the disk (collective); None where there is no table."""
        return None if self._table is None else self._table.size()

    def close(self) -> None:
        """Close the file."""
        if self._table is not None:
            self._table.close()


def _places(points: Mapping[str, Sequence[float]], dim: int) -> Array:
    """Places (n, 3) by name.

    Raises:
        InputError: One has too few or too many coordinates, or one that is not finite.
    """
    places = np.zeros((len(points), 3))
    for row, (name, point) in enumerate(points.items()):
        given = np.asarray(tuple(point), dtype=float)
        if not dim <= given.size <= 3 or not np.isfinite(given).all():
            raise InputError(
                f"{list(point)}: give three finite coordinates, such as [0.0, 0.0, 20.0]",
                f"electrodes.{name}",
            )
        places[row, : given.size] = given
    return places
