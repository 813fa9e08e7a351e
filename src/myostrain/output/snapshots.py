"""Frames of a run's nodal fields: a folder of files, each there whole or not at all."""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from myostrain.errors import InputError
from myostrain.output.folder import on_first, read_regular, write_atomically
from myostrain.output.manifest import make_folder

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from myostrain.engine import fem

Array = npt.NDArray[np.float64]

FRAME = re.compile(r"frame-(\d+)\.npz")

#: Fields with a component for each dimension; all others are scalar.
VECTORS = ("displacement", "velocity")
#: In a frame, the displacement of the middles of the edges, where it is quadratic.
MIDDLES = "displacement.middles"


def frame_paths(folder: Path) -> dict[int, Path]:
    """Files of the frames in ``folder/snapshots`` by number of the step, in order."""
    found = ((FRAME.fullmatch(path.name), path) for path in (folder / "snapshots").glob("frame-*.npz"))
    return dict(sorted((int(name[1]), path) for name, path in found if name is not None))


class SnapshotWriter:
    """Writes ``folder/snapshots``: the mesh now, then a frame of the fields a time.

    Nodes are numbered as :class:`~myostrain.output.ordering.Ordering` does, whatever process has them. All
    methods are collective and raise :class:`~myostrain.errors.ComputationError` on every process if the
    first one cannot write.

    Args:
        folder: The result folder.
        space: Space of the scalar fields, P1.
        vectors: Space of the vector fields, P1 with a block; None if there are none.
        fibres: Fibre directions at the centres of this process's own cells, (cells, dim); None to leave
            them out.
        about: What pictures have to know of the run: see :func:`~myostrain.output.units.about`.
        quadratic: Space of a quadratic displacement, P2 with a block; None where it is linear.
    """

    def __init__(
        self,
        folder: Path,
        space: fem.FunctionSpace,
        vectors: fem.FunctionSpace | None,
        fibres: Array | None = None,
        about: Mapping[str, Any] | None = None,
        quadratic: fem.FunctionSpace | None = None,
    ) -> None:
        # Here, as who only reads frames needs no engine.
        from myostrain.engine import lasting
        from myostrain.output.ordering import Ordering

        mesh = space.mesh
        self._folder, self._dim, self._comm = folder, mesh.geometry.dim, lasting(mesh.comm)
        self._nodes = Ordering(space)
        self._vectors = None if vectors is None else Ordering(vectors)
        self._quadratic = None if quadratic is None else Ordering(quadratic)
        corners = mesh.geometry.dofmaps[0][:, : mesh.topology.dim + 1]
        X = np.empty((len(self._nodes.positions), self._dim))
        X[space.dofmap.list] = mesh.geometry.x[corners, : self._dim]  # as they were given, to the last digit
        columns = [self._nodes.gather(X[:, i]) for i in range(self._dim)]
        own = mesh.topology.index_map(mesh.topology.dim).size_local
        parts = self._comm.gather((self._nodes.positions[space.dofmap.list[:own]], fibres), root=0)
        arrays = {}
        if parts is not None:
            cells = np.concatenate([part for part, _ in parts])
            by_nodes = np.lexsort(np.sort(cells, axis=1).T[::-1])
            arrays = {"points": np.column_stack(columns), "cells": cells[by_nodes]}  # type: ignore[arg-type]
            if fibres is not None:
                arrays["fibres"] = np.concatenate([part for _, part in parts])[by_nodes]
        self._save("mesh.npz", {**arrays, "about": json.dumps(dict(about or {}))})

    def write(
        self, step: int, time: float, values: Mapping[str, Array], quadratic: Array | None = None
    ) -> None:
        """Write a frame.

        Args:
            step: Number of the step.
            time: Simulated time.
            values: Local values (owned and ghost) by name of the field.
            quadratic: Those of the quadratic displacement, where there is one: the middles of edges are kept.
        """
        arrays: dict[str, Any] = {"time": time}
        for name, local in values.items():
            ordering = self._vectors if name in VECTORS else self._nodes
            assert ordering is not None, f"no space of {name} was given"
            whole = ordering.gather(local)
            if whole is not None:
                arrays[name] = whole.reshape(-1, self._dim) if name in VECTORS else whole
        if quadratic is not None and self._quadratic is not None:
            whole = self._quadratic.gather(quadratic)
            if whole is not None:  # after the nodes come the edges, in the order of :func:`edges_of`
                arrays[MIDDLES] = whole.reshape(-1, self._dim)[self._nodes.size :]
        self._save(f"frame-{step:09d}.npz", arrays)

    def truncate(self, step: int) -> None:
        """Remove what was written after a step: later frames, activation times, leavings of a killed run."""
        folder = self._folder / "snapshots"

        def remove() -> None:
            late = [path for number, path in frame_paths(self._folder).items() if number > step]
            for path in (*late, *folder.glob(".frame-*.npz.part"), folder / "activation.npz"):
                path.unlink(missing_ok=True)

        on_first(self._comm, remove, folder)

    def finish(self, maps: Mapping[str, Array]) -> None:
        """Write ``activation.npz`` at the end of a run: rows (rows, local nodes) by name, NaN for none.

        The first row of the activation times is there once more, as ``activation_time``.
        """
        arrays = {name: [self._nodes.gather(row) for row in rows] for name, rows in maps.items()}
        self._save("activation.npz", {"activation_time": arrays["activation_times"][0], **arrays})

    def _save(self, name: str, arrays: dict[str, Any]) -> None:
        path = self._folder / "snapshots" / name

        def save() -> None:
            if name == "mesh.npz":
                make_folder(path.parent)
            # In memory first: a zip file that cannot be completed fails in ways of its own.
            content = io.BytesIO()
            np.savez(content, **arrays)
            write_atomically(path, content.getvalue())

        on_first(self._comm, save, path)


class Snapshots:
    """Reads ``folder/snapshots``, also while the run goes on.

    Args:
        folder: The result folder.

    Attributes:
        points: Material coordinates of the nodes, (n, dim).
        cells: Node numbers of the cells, (m, dim + 1).
        fibres: Fibre directions at the centres of the cells, (m, dim); None where they were not written.
        about: What pictures have to know of the run: see :func:`~myostrain.output.units.about`.
        times: Times of the frames, (frames,).
        names: Fields that every frame has; empty without a frame.

    Raises:
        InputError: There is no mesh, or a file is damaged; it is named.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder / "snapshots"
        if not (self._folder / "mesh.npz").is_file():
            raise InputError(f"{folder} {_without_frames(folder)}")
        with _opened(self._folder / "mesh.npz") as mesh:
            self.points: Array = np.asarray(mesh["points"], dtype=float)
            self.cells: npt.NDArray[np.int64] = np.asarray(mesh["cells"], dtype=np.int64)
            self.about: dict[str, Any] = json.loads(str(mesh["about"])) if "about" in mesh.files else {}
            given = "fibres" in mesh.files
            self.fibres: Array | None = np.asarray(mesh["fibres"], dtype=float) if given else None
        self._paths = list(frame_paths(folder).values())
        times, names = [], []
        for path in self._paths:
            with _opened(path) as frame:
                times.append(float(frame["time"]))
                names.append({name for name in frame.files if name not in ("time", MIDDLES)})
        self.times: Array = np.array(times)
        self.names: frozenset[str] = frozenset(set.intersection(*names) if names else ())

    def __repr__(self) -> str:
        """What there is."""
        frames = f"{len(self.times)} frames"
        if len(self.times):
            frames += f", t = {self.times[0]:g} to {self.times[-1]:g}, of {', '.join(sorted(self.names))}"
        return f"Snapshots({self._folder.parent}: {len(self.points)} nodes; {frames})"

    def field(self, name: str, frame: int = -1) -> Array:
        """Nodal values (n,) or (n, dim) of a field at one frame, by default the last."""
        with _opened(self._paths[frame]) as data:
            return np.asarray(data[name], dtype=float)

    @cached_property
    def edges(self) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
        """The two nodes of each edge, and the edges of each cell: see :func:`edges_of`."""
        return edges_of(self.cells)

    def middles(self, frame: int = -1) -> Array | None:
        """Displacement (edges, dim) of the middles of the edges, in the order of :func:`edges_of`.

        None where it is linear: then it is half the sum of those of the ends.
        """
        with _opened(self._paths[frame]) as data:
            return np.asarray(data[MIDDLES], dtype=float) if MIDDLES in data.files else None

    def activation(self) -> Array | None:
        """First activation times (n,) of the nodes, NaN for never; None if the run did not reach its end."""
        return self.maps().get("activation_time")

    def maps(self) -> dict[str, Array]:
        """What there is of each node at the end of a run: see :meth:`SnapshotWriter.finish`; else nothing."""
        path = self._folder / "activation.npz"
        if not path.exists():
            return {}
        with _opened(path) as data:
            return {name: np.array(data[name], dtype=float) for name in data.files}


def _without_frames(folder: Path) -> str:
    """Why there is nothing to show, and what to try."""
    if not folder.is_dir():
        where = "is a file" if folder.exists() else "is not there"
        return f"{where}; name the result folder of a run (--out)"
    if (folder / "sweep.json").exists():
        return f"is a sweep; name one of its runs, such as {folder / '001'}"
    if (folder / "case.toml").exists():
        return (
            "holds no frames (snapshots/mesh.npz): its run wrote no fields (output.fields was empty), or "
            "stopped before the first one"
        )
    return "holds no frames (snapshots/mesh.npz); name the result folder of a run (--out)"


def edges_of(cells: npt.NDArray[np.int64]) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """The edges of simplices, ordered by their two nodes.

    Args:
        cells: Node numbers, (m, corners).

    Returns:
        The two nodes of each edge, the lower first, (edges, 2); the edges of each cell, (m, pairs), for the
        pairs of its corners in the order (0, 1), (0, 2), ..., (1, 2), ...
    """
    first, second = np.triu_indices(cells.shape[1], 1)
    pairs = np.sort(np.stack([cells[:, first], cells[:, second]], axis=-1), axis=-1)
    size = int(cells.max(initial=0)) + 1
    keys, inverse = np.unique(pairs[..., 0] * size + pairs[..., 1], return_inverse=True)
    return np.column_stack(np.divmod(keys, size)), inverse.reshape(len(cells), -1)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """A file of arrays, open for reading; whatever is wrong with it is an :class:`InputError`."""
    damage = (OSError, ValueError, TypeError, KeyError, EOFError, RuntimeError, zipfile.BadZipFile)
    try:
        with np.load(io.BytesIO(read_regular(path)), allow_pickle=False) as arrays:
            yield arrays
    except damage as error:
        then = "remove it to go without this frame" if FRAME.fullmatch(path.name) else "run the case again"
        raise InputError(
            f"{path} cannot be read, it is damaged or no run wrote it ({error}); {then}"
        ) from error
