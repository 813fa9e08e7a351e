"""Fields over time: snapshots while the run goes on, and VTX for ParaView of them at its end."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from myostrain.engine import fem, jit_options, lasting
from myostrain.errors import InputError
from myostrain.output.folder import discard, on_first, part_of
from myostrain.output.manifest import claim, claimed, make_folder
from myostrain.output.nodal_values import FieldName, NodalValues
from myostrain.output.ordering import Ordering
from myostrain.output.snapshots import VECTORS, Snapshots, SnapshotWriter

import dolfinx.io
import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from myostrain.coupling import Electromechanics
    from myostrain.geometry import Body

Array = npt.NDArray[np.float64]


def cell_fibres(body: Body) -> Array:
    """Fibre directions at the centres of this process's own cells, (m, dim)."""
    tdim = body.mesh.topology.dim
    cells = np.arange(body.mesh.topology.index_map(tdim).size_local, dtype=np.int32)
    centre = np.full((1, tdim), 1 / (tdim + 1))
    f0 = fem.Expression(body.f0, centre, jit_options=jit_options()).eval(body.mesh, cells)
    return np.asarray(f0, dtype=float).reshape(len(cells), -1)


def _described(kinematics: Any) -> dict[str, Any]:
    """What derived fields have to know of a kinematics."""
    return {"name": type(kinematics).__name__, "constraint": getattr(kinematics, "constraint", None)}


class FieldWriter:
    """Writes chosen fields at the times when :meth:`write` is called; all methods are collective.

    Of a quadratic displacement the middles of the edges are kept too.

    Args:
        model: The coupled problem.
        folder: The result folder.
        names: Which fields: see :data:`~myostrain.output.nodal_values.FieldName`.
        about: What pictures have to know of the run: see :func:`~myostrain.output.units.about`.
        expressions: UFL expressions to write, by name.
        activation_times: Gives the first activation time of each local node.

    Raises:
        InputError: The model has no such field.
    """

    def __init__(
        self,
        model: Electromechanics,
        folder: Path,
        names: Sequence[FieldName],
        about: Mapping[str, Any] | None = None,
        expressions: Mapping[str, Any] | None = None,
        activation_times: Callable[[], Array] | None = None,
    ) -> None:
        self._model, self._folder = model, folder
        self._space = space = model.potential.v.function_space
        self._values = NodalValues(model, names, expressions, activation_times)
        self._vectors, self._moves = None, "displacement" in self._values.names
        if set(VECTORS) & set(self._values.names):
            self._vectors = model.transfer.displacement().function_space
        self._snapshots = None
        if self._values.names:
            body, whole = model.potential.body, self._quadratic()
            fibres = cell_fibres(body) if body.dim > 1 else None
            if model.mechanics is not None:
                about = {**(about or {}), "kinematics": _described(model.mechanics.kinematics)}
                about["yields"] = model.mechanics.yields
                modulus = getattr(model.mechanics.material, "modulus", None)
                about["modulus"] = float(modulus) if isinstance(modulus, int | float) else 0.0
            quadratic = None if whole is None else whole.function_space
            self._snapshots = SnapshotWriter(folder, space, self._vectors, fibres, about, quadratic)

    def _quadratic(self) -> fem.Function | None:
        return self._model.transfer.quadratic_displacement() if self._moves else None

    def write(self, step: int, time: float) -> None:
        """Write the present fields, after so many steps.

        Raises:
            ComputationError: They cannot be written.
        """
        if self._snapshots is not None:
            whole = self._quadratic()
            middles = None if whole is None else whole.x.array
            self._snapshots.write(step, time, self._values.values(), middles)

    def truncate(self, step: int) -> None:
        """Remove what an earlier run wrote after a step, to go on from there."""
        if self._snapshots is not None:
            self._snapshots.truncate(step)

    def close(self, maps: Mapping[str, Array] | None = None) -> None:
        """Make ``fields.bp`` of the snapshots.

        Args:
            maps: Of each node what there is at the end of a run, rows (rows, local nodes) by name, with the
                activation times among them. None if the run did not reach its end: then nothing is raised,
                so that the reason why is not hidden.

        Raises:
            ComputationError: Something cannot be written.
        """
        if self._snapshots is None:
            return
        if maps is not None:
            self._snapshots.finish(maps)
            write_vtx(self._folder, self._space, self._vectors)
        else:
            with suppress(InputError, RuntimeError):
                write_vtx(self._folder, self._space, self._vectors)


def write_vtx(folder: Path, space: fem.FunctionSpace, vectors: fem.FunctionSpace | None = None) -> None:
    """Write ``folder/fields.bp`` of the snapshots in ``folder``, if there are any (collective).

    It replaces an earlier one when it is complete. There must be room for it beforehand, because ADIOS2 ends
    the process when the disk is full.

    Args:
        folder: The result folder.
        space: Space of the scalar fields, P1.
        vectors: Space of the displacement, P1 with a block; None to leave it out.

    Raises:
        ComputationError: It cannot be written.
        InputError: A snapshot cannot be read.
    """
    if not dolfinx.io.has_adios2:
        return
    comm, opened = lasting(space.mesh.comm), cache(Snapshots)
    path, part = folder / "fields.bp", part_of(folder / "fields.bp")
    names, times = _from_first(comm, lambda: (opened(folder).names, opened(folder).times))
    spaces = {name: vectors if name in VECTORS else space for name in names}
    fields = {name: fem.Function(s, name=name) for name, s in sorted(spaces.items()) if s is not None}
    if not len(times) or not fields:
        return
    orderings = {name: Ordering(f.function_space) for name, f in fields.items() if name in VECTORS}
    scalar = Ordering(space)
    needed = len(times) * _frame_bytes(space, list(fields))

    def make_room() -> None:
        if needed > shutil.disk_usage(folder).free:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        discard(part)
        claim(path)
        part.mkdir()

    on_first(comm, make_room, path)
    try:
        with dolfinx.io.VTXWriter(comm, part, list(fields.values())) as vtx:
            for frame, time in enumerate(times):
                for name, function in fields.items():
                    whole = _from_first(comm, partial(_field, opened, folder, name, frame))
                    function.x.array[:] = orderings.get(name, scalar).take(whole.reshape(-1))
                vtx.write(time)
        comm.Barrier()
        on_first(comm, partial(_replace, part, path), path)
    finally:
        if comm.rank == 0:
            discard(part)


def _field(opened: Callable[[Path], Snapshots], folder: Path, name: str, frame: int) -> Array:
    return opened(folder).field(name, frame)


def _replace(part: Path, path: Path) -> None:
    make_folder(path)
    own = claimed(path.parent)
    for old in path.iterdir():
        if f"{path.name}/{old.name}" in own:
            old.unlink()
    for new in part.iterdir():
        claim(path / new.name)
        new.replace(path / new.name)


def _frame_bytes(space: fem.FunctionSpace, names: Sequence[str]) -> float:
    """About what one time takes in a VTX file: mesh and fields, vectors with three components, some more."""
    topology = space.mesh.topology
    nodes, cells = space.dofmap.index_map.size_global, topology.index_map(topology.dim).size_global
    values = sum(3 if name in VECTORS else 1 for name in names)
    # A node has coordinates and a number, a cell its corners and how many they are.
    return 1.2 * 8 * (nodes * (values + 4) + cells * (topology.dim + 2))


def _from_first(comm: Any, read: Callable[[], Any]) -> Any:
    """What the first process reads, on all processes; if it cannot, all raise the same."""
    outcome = None
    if comm.rank == 0:
        try:
            outcome = read()
        except InputError as error:
            outcome = error
    outcome = comm.bcast(outcome, root=0)
    if isinstance(outcome, InputError):
        raise outcome
    return outcome
