"""Fields over time: VTX for ParaView, and one HDF5 file that the figures are drawn from."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from myostrain.engine import fem, lasting

import dolfinx.io
import h5py
import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from myostrain.coupling import Electromechanics

Array = npt.NDArray[np.float64]

FieldName = Literal["potential", "states", "displacement", "stress_trace"]


class FieldWriter:
    """Writes chosen fields at the times when :meth:`write` is called.

    Args:
        model: The coupled problem.
        folder: The result folder.
        names: Which fields; "states" means all of the membrane's.
    """

    def __init__(self, model: Electromechanics, folder: Path, names: Sequence[FieldName]) -> None:
        self._model = model
        space = model.potential.v.function_space
        self._comm = lasting(space.mesh.comm)
        wanted: dict[str, fem.Function] = {}
        if "potential" in names:
            wanted["potential"] = model.potential.v
        if "states" in names:
            wanted.update(model.potential.states)
        self._trace = None
        if model.mechanics is not None:
            if "displacement" in names:
                wanted["displacement"] = model.mechanics.displacement()
            if "stress_trace" in names:
                self._trace = wanted["stress_trace"] = fem.Function(space, name="stress_trace")
        self._fields = wanted
        self._vtx = None
        if dolfinx.io.has_adios2 and wanted:
            self._vtx = dolfinx.io.VTXWriter(self._comm, folder / "fields.bp", list(wanted.values()))
        self._file = _Snapshots(folder / "snapshots.h5", space, list(wanted)) if wanted else None

    def write(self, time: float) -> None:
        """Write the present fields."""
        mechanics = self._model.mechanics
        if mechanics is not None:
            mechanics.displacement()
            if self._trace is not None:
                self._trace.x.array[:] = mechanics.stress_trace()
        if self._vtx is not None:
            self._vtx.write(time)
        if self._file is not None:
            self._file.append(time, {name: f.x.array for name, f in self._fields.items()})

    def close(self, activation_times: Array | None = None) -> None:
        """Close the files; the nodes' activation times, NaN for none, go beside the frames."""
        if self._vtx is not None:
            self._vtx.close()
        if self._file is not None:
            self._file.close(activation_times)


class _Snapshots:
    """One HDF5 file on the first process: mesh, and a frame of every field a time, in single precision."""

    def __init__(self, path: Path, space: fem.FunctionSpace, names: Sequence[str]) -> None:
        mesh = space.mesh
        self._comm, self._map = lasting(mesh.comm), space.dofmap.index_map
        dim, owned = mesh.geometry.dim, self._map.size_local
        cells = mesh.topology.index_map(mesh.topology.dim).size_local
        corners = self._map.local_to_global(space.dofmap.list[:cells].reshape(-1).astype(np.int32))
        points = self._gather(space.tabulate_dof_coordinates()[:owned, :dim])
        connectivity = self._gather(corners.reshape(-1, mesh.topology.dim + 1))
        self._file = None
        if self._comm.rank == 0:
            self._file = h5py.File(path, "w")
            self._file["points"], self._file["cells"] = points, connectivity
            self._file.create_dataset("time", (0,), maxshape=(None,), dtype="f8")
            self._names = list(names)

    def _gather(self, local: Any) -> Any:
        parts = self._comm.gather(local, root=0)
        return np.concatenate(parts) if parts is not None else None

    def append(self, time: float, values: dict[str, Array]) -> None:
        owned = self._map.size_local
        for name, array in values.items():
            block = len(array) // (owned + self._map.num_ghosts)
            whole = self._gather(
                array[: owned * block].reshape(owned, block)
                if block > 1 or name == "displacement"
                else array[:owned]
            )
            if self._file is not None:
                if name not in self._file:
                    self._file.create_dataset(
                        name,
                        (0, *whole.shape),
                        maxshape=(None, *whole.shape),
                        chunks=(1, *whole.shape),
                        dtype="f4",
                    )
                _grow(self._file[name], whole)
        if self._file is not None:
            _grow(self._file["time"], time)
            self._file.flush()

    def close(self, activation_times: Array | None) -> None:
        whole = None if activation_times is None else self._gather(activation_times[: self._map.size_local])
        if self._file is not None:
            if whole is not None:
                self._file["activation_time"] = whole
            self._file.close()


def _grow(dataset: Any, value: Any) -> None:
    dataset.resize(len(dataset) + 1, axis=0)
    dataset[-1] = value
