"""Fibres from a file: directions at points or in cells, of which each cell takes the mean."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

from myostrain.engine import MPI, fem, lasting
from myostrain.errors import InputError
from myostrain.geometry import opencarp, vtu
from myostrain.geometry.body import extent
from myostrain.geometry.checks import place
from myostrain.geometry.fibres import Microstructure
from myostrain.geometry.file import open_safely
from myostrain.geometry.foreign import readable
from myostrain.geometry.gmsh_model import says, session
from myostrain.geometry.laplace_fibres import orthonormal
from myostrain.geometry.meshed import Meshed
from myostrain.geometry.points import cells_at
from myostrain.validation import Positive, description

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

KEY = "fibres.path"
FORMATS = (
    'there are: .msh of gmsh with $ElementData or $NodeData called "f0", .npz of numpy with arrays '
    "'points' (n, dim) and 'f0' (n, dim), .lon of openCARP, and .vtu with data called f0"
)

#: A point belongs to a cell if it is outside by this part of the body's extent at most: files in single
#: precision have errors of 1e-7.
REACH = 1e-6

#: So many points are looked up at a time.
CHUNK = 50_000


@description
class FileFibres:
    """Fibres, and optionally sheets, from a file with directions at points of the body.

    Four formats:

    - ``.msh``: gmsh's own mesh with ``$ElementData`` or ``$NodeData`` of three components called "f0" and,
      for solids that need it, "s0". It may be the file of the geometry or another of the same body.
    - ``.npz`` of NumPy: ``points`` (n, dim), ``f0`` (n, dim) and optionally ``s0`` (n, dim), the directions
      at these points. Each cell must contain at least one; take its centre, say, or the nodes.
    - ``.lon`` of openCARP, of the .elem and .pts beside it: a direction, or two, of each element.
    - ``.vtu``, ``.vtk``: data on cells or nodes called "f0", "fiber" or "fibers" and, for sheets, "s0",
      "sheet" or "sheets".

    A cell takes the mean of the points that lie in it or on its boundary, within 1e-6 of the body's extent;
    so numbering, order and partition do not matter. A direction and its opposite are the same fibre: the mean
    is the axis to which the directions are closest, in the mean square. Directions may have any length; s0 is
    made orthogonal to f0, n0 = f0 × s0.

    Args:
        path: The file. In a case file, relative to the case file's folder.
        scale: Factor on the coordinates, as that of the geometry.
    """

    path: Path
    scale: Positive = 1.0

    @property
    def files(self) -> tuple[Path, ...]:
        """What is read: a run is resumed with the same only."""
        if self.path.suffix in opencarp.ENDINGS:
            return tuple(self.path.with_suffix(ending) for ending in opencarp.ENDINGS)
        return (self.path,)

    def directions_on(self, meshed: Meshed) -> Microstructure:
        """Unit directions as UFL vectors, constant in each cell.

        Raises:
            InputError: The file is missing or unreadable, holds no directions, or none for some cell; or the
                directions in a cell have no mean.
        """
        mesh = meshed.mesh
        dim = mesh.geometry.dim
        points, given = self._read(lasting(mesh.comm), dim)
        fields = []
        for name, values in self._means(mesh, points, given).items():
            field = fem.Function(fem.functionspace(mesh, ("DG", 0, (dim,))), name=name)
            owned = field.x.array.reshape(-1, dim)[: len(values)]
            owned[field.function_space.dofmap.list[: len(values), 0]] = values
            field.x.scatter_forward()
            fields.append(field)
        if len(fields) == 1:
            return Microstructure(fields[0])
        return orthonormal(*fields)

    def _read(self, comm: Any, dim: int) -> tuple[Array, dict[str, Array]]:
        """Points (n, dim) and unit directions (n, dim) by name, read by the first process."""
        problem: str | None = None
        points: Array = np.zeros((0, dim))
        given: dict[str, Array] = {}
        if comm.rank == 0:
            try:
                points, given = self._from_file()
                points = points * self.scale
                given = self._checked(points, given, dim)
            except InputError as error:
                problem = str(error)
        problem, points, given = comm.bcast((problem, points, given), root=0)
        if problem is not None:
            raise InputError(problem)
        return points[:, :dim], given

    def _error(self, message: str) -> InputError:
        return InputError(f"{self.path} {message}", KEY)

    def _from_file(self) -> tuple[Array, dict[str, Array]]:
        if self.path.suffix in opencarp.ENDINGS:
            return opencarp.read_directions(self.path)
        if vtu.is_vtk(self.path):
            return vtu.read_directions(self.path)
        readable(self.path, KEY)
        with self.path.open("rb") as stream:
            begin = stream.read(12)
        if self.path.suffix == ".msh" or begin.startswith(b"$MeshFormat"):
            with session() as gmsh:
                open_safely(gmsh, self.path, KEY)
                with says(self.path, KEY):
                    return self._from_msh(gmsh)
        if self.path.suffix == ".npz" or zipfile.is_zipfile(self.path):
            return self._from_npz()
        raise self._error(f"is of no known format; {FORMATS}")

    def _from_npz(self) -> tuple[Array, dict[str, Array]]:
        if not zipfile.is_zipfile(self.path):
            raise self._error(f"cannot be read as .npz: it is not an archive of numpy.savez; {FORMATS}")
        arrays = {}
        try:
            with np.load(self.path, allow_pickle=False) as data:
                names = data.files
                for name in ("points", "f0", "s0"):
                    if name in names:
                        arrays[name] = data[name]
        except Exception as error:  # numpy and zipfile raise many kinds
            words = "an array holds objects" if "pickle" in str(error) else " ".join(str(error).split())
            raise self._error(f"cannot be read as .npz: {words}") from error
        if "points" not in arrays:
            raise self._error(f"has no array 'points', only {', '.join(names) or 'nothing'}")
        for name, values in arrays.items():
            if values.dtype.kind not in "fiu":
                raise self._error(f"has '{name}' of type {values.dtype}; real numbers are needed")
            arrays[name] = values.astype(float)
        points = arrays.pop("points")
        if points.ndim != 2:
            raise self._error("has points that are not a table, one point a row")
        return points, arrays

    def _from_msh(self, gmsh: Any) -> tuple[Array, dict[str, Array]]:
        given: dict[str, Array] = {}
        kinds, tags = set(), []
        for view in gmsh.view.getTags():
            name = gmsh.view.option.getString(view, "Name")
            if name not in ("f0", "s0"):
                continue
            kind, numbers, data, _, components = gmsh.view.getModelData(view, 0)
            if kind not in ("ElementData", "NodeData") or components != 3:
                raise self._error(
                    f"has '{name}' as {kind} of {components} components: give ElementData or NodeData of 3"
                )
            kinds.add(kind)
            tags.append(np.asarray(numbers, dtype=np.int64))
            given[name] = np.array(data, dtype=float)
        if not given:
            return np.zeros((0, 3)), {}
        if len(kinds) > 1 or not np.array_equal(tags[0], tags[-1]):
            raise self._error("has f0 and s0 on different cells or nodes")
        if kinds == {"NodeData"}:
            known, places, _ = gmsh.model.mesh.getNodes()
            places = places.reshape(-1, 3)
        else:
            elements = gmsh.model.mesh.getElements(gmsh.model.getDimension())
            known = np.concatenate([np.zeros(0, dtype=np.int64), *elements[1]])
            centres = [gmsh.model.mesh.getBarycenters(int(k), -1, False, False) for k in elements[0]]
            places = np.concatenate([np.zeros(0), *centres]).reshape(-1, 3)
        order = np.argsort(known)
        number = np.minimum(np.searchsorted(known[order], tags[0]), len(known) - 1)
        if not len(known) or (known[order][number] != tags[0]).any():
            raise self._error("has directions for elements or nodes that are none of the body")
        return places[order][number], given

    def _checked(self, points: Array, given: dict[str, Array], dim: int) -> dict[str, Array]:
        """The directions with unit length."""
        if "f0" not in given:
            raise self._error(f"holds no fibres; {FORMATS}")
        if "s0" in given and dim != 3:
            raise self._error(
                "has sheet directions, which a body of less than three dimensions has no use for"
            )
        lost = ~np.isfinite(points).all(axis=1)
        if lost.any():
            raise self._error(
                f"has {int(lost.sum())} points that are not finite, the first in row {np.argmax(lost)}"
            )
        units = {}
        for name, values in given.items():
            if values.ndim != 2 or len(values) != len(points) or min(values.shape[1], points.shape[1]) < dim:
                raise self._error(
                    f"has '{name}' of shape {values.shape} for points of shape {points.shape}; "
                    f"({len(points)}, {dim}) is needed"
                )
            largest = np.abs(values[:, :dim]).max(axis=1, initial=0.0)
            bad = ~(np.isfinite(largest) & (largest > 0))
            if bad.any():
                where = place(points[np.argmax(bad)])
                raise self._error(
                    f"has {int(bad.sum())} directions '{name}' that are zero or not finite, one at {where}"
                )
            scaled = values[:, :dim] / largest[:, None]
            units[name] = scaled / np.linalg.norm(scaled, axis=1, keepdims=True)
        return units

    def _means(self, mesh: Any, points: Array, given: dict[str, Array]) -> dict[str, Array]:
        """The mean direction in each cell that this process owns (cells, dim), by name."""
        number, sums, squares = _sums(mesh, points, given)
        self._refuse(mesh, number == 0, "has no direction in {} cells of the body")
        means = {}
        for name in given:
            spread, axes = np.linalg.eigh(squares[name])
            if spread.shape[1] > 1:
                none = spread[:, -1] - spread[:, -2] < 1e-6 * spread[:, -1]
                self._refuse(mesh, none, f"has directions '{name}' without a mean in {{}} cells of the body")
            axis = axes[:, :, -1]
            axis = axis * np.where((axis * sums[name]).sum(axis=1) < 0, -1.0, 1.0)[:, None]
            means[name] = np.where(number[:, None] == 1, sums[name], axis)
        if "s0" in means:
            along = np.abs((means["f0"] * means["s0"]).sum(axis=1)) > 1 - 1e-6
            self._refuse(mesh, along, "has sheet directions along the fibre in {} cells of the body")
        return means

    def _refuse(self, mesh: Any, bad: Flags, message: str) -> None:
        """Refuse, on every process, what is bad in cells; the message has a place for their number."""
        comm = lasting(mesh.comm)
        number = comm.allreduce(int(bad.sum()), MPI.SUM)
        if number:
            first = np.flatnonzero(bad)[:1]
            centres = mesh.geometry.x[mesh.geometry.dofmaps[0][first]].mean(axis=1)
            near = next(c[0] for c in comm.allgather(centres) if len(c))
            where = place(near[: mesh.geometry.dim])
            raise self._error(f"{message.format(number)}, such as the one near {where}")


def _sums(
    mesh: Any, points: Array, given: dict[str, Array]
) -> tuple[npt.NDArray[np.int64], dict[str, Array], dict[str, Array]]:
    """Over the points in each owned cell: their number, the sums of d and of d ⊗ d."""
    dim = mesh.topology.dim
    owned = mesh.topology.index_map(dim).size_local
    number = np.zeros(owned, dtype=np.int64)
    sums = {name: np.zeros((owned, dim)) for name in given}
    squares = {name: np.zeros((owned, dim, dim)) for name in given}
    low, high = extent(mesh)
    for start in range(0, len(points), CHUNK):
        which, cells, _ = cells_at(mesh, points[start : start + CHUNK], REACH * float((high - low).max()))
        number += np.bincount(cells, minlength=owned)
        for name, values in given.items():
            d = values[start + which]
            for i in range(dim):
                sums[name][:, i] += np.bincount(cells, d[:, i], minlength=owned)
                for j in range(dim):
                    squares[name][:, i, j] += np.bincount(cells, d[:, i] * d[:, j], minlength=owned)
    return number, sums, squares
