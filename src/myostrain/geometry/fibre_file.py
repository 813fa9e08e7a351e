"""Fibres from a file: a direction for each cell."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from myostrain.engine import MPI, fem, lasting
from myostrain.errors import InputError
from myostrain.geometry.fibres import Microstructure
from myostrain.geometry.file import open_safely
from myostrain.geometry.gmsh_model import readable, session
from myostrain.geometry.laplace_fibres import orthonormal
from myostrain.geometry.meshed import Meshed
from myostrain.validation import description

import numpy as np
import numpy.typing as npt
from dolfinx import geometry as dgeometry

Array = npt.NDArray[np.float64]


@description
class FileFibres:
    """Fibres, and sheets if they are there, given for each cell by a file.

    Two formats:

    - ``.msh``: gmsh's own mesh with ``$ElementData`` of three components called "f0" and, for solids that
      need it, "s0". It may be the file of the geometry or another of the same body.
    - ``.npz`` of numpy: ``points`` (n, dim), ``f0`` (n, dim) and perhaps ``s0`` (n, dim), the directions at
      these points, of which one at least is in each cell: their centres, say.

    A cell takes the direction of a point that lies in it (of several the last in the file), so that numbering
    and partition do not matter. Directions may have any length; s0 is made orthogonal to f0, n0 = f0 × s0.

    Args:
        path: The file. In a case file, relative to the case file's folder.
    """

    path: Path

    def directions_on(self, meshed: Meshed) -> Microstructure:
        """Unit directions as UFL vectors, constant in each cell.

        Raises:
            InputError: The file is missing or unreadable, holds no directions, or none for some cell.
        """
        mesh = meshed.mesh
        points, given = self._read(lasting(mesh.comm), mesh.geometry.dim)
        of_cell = self._points_of_cells(mesh, points)
        fields = []
        for name, values in given.items():
            field = fem.Function(fem.functionspace(mesh, ("DG", 0, (mesh.geometry.dim,))), name=name)
            owned = field.x.array.reshape(-1, mesh.geometry.dim)[: len(of_cell)]
            owned[field.function_space.dofmap.list[: len(of_cell), 0]] = values[of_cell]
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
                readable(self.path, "fibres.path")
                points, given = self._from_msh() if self.path.suffix == ".msh" else self._from_npz()
                given = self._checked(points, given, dim)
            except InputError as error:
                problem = str(error)
        problem, points, given = comm.bcast((problem, points, given), root=0)
        if problem is not None:
            raise InputError(problem)
        return points[:, :dim], given

    def _error(self, message: str) -> InputError:
        return InputError(f"{self.path} {message}", "fibres.path")

    def _from_npz(self) -> tuple[Array, dict[str, Array]]:
        try:
            with np.load(self.path, allow_pickle=False) as data:
                arrays = {name: np.asarray(data[name], dtype=float) for name in data.files}
        except Exception as error:  # numpy and zipfile raise many kinds
            raise self._error(f"cannot be read as .npz: {error}") from error
        if "points" not in arrays:
            raise self._error(f"has no array 'points', only {', '.join(arrays) or 'nothing'}")
        points = arrays.pop("points")
        if points.ndim != 2:
            raise self._error("has points that are no table, one point a row")
        return points, {name: arrays[name] for name in ("f0", "s0") if name in arrays}

    def _from_msh(self) -> tuple[Array, dict[str, Array]]:
        with session() as gmsh:
            open_safely(gmsh, self.path, "fibres.path")
            model, given = gmsh.model, {}
            cells: Any = None
            for view in gmsh.view.getTags():
                name = gmsh.view.option.getString(view, "Name")
                if name not in ("f0", "s0"):
                    continue
                kind, tags, data, _, components = gmsh.view.getModelData(view, 0)
                if kind != "ElementData" or components != 3:
                    raise self._error(
                        f"has '{name}' as {kind} of {components} components: give ElementData of 3"
                    )
                if cells is not None and not np.array_equal(cells, tags):
                    raise self._error("has f0 and s0 on different cells")
                cells, given[name] = tags, np.array(data, dtype=float)
            if cells is None:
                return np.zeros((0, 3)), {}
            centres = {}
            dim = model.getDimension()
            for element_kind, tags, _ in zip(*model.mesh.getElements(dim), strict=True):
                middle = model.mesh.getBarycenters(int(element_kind), -1, False, False).reshape(-1, 3)
                centres[int(element_kind)] = (np.asarray(tags), middle)
        tags = np.concatenate([tags for tags, _ in centres.values()])
        middle = np.concatenate([middle for _, middle in centres.values()])
        order = np.argsort(tags)
        place = np.minimum(np.searchsorted(tags[order], cells), len(tags) - 1)
        if (tags[order][place] != cells).any():
            raise self._error("has directions for elements that are no cells of it")
        return middle[order][place], given

    def _checked(self, points: Array, given: dict[str, Array], dim: int) -> dict[str, Array]:
        """The directions with unit length."""
        if "f0" not in given:
            raise self._error(
                "holds no fibres: a .msh has $ElementData called \"f0\", a .npz has arrays 'points' and 'f0'"
            )
        if "s0" in given and dim != 3:
            raise self._error(
                "has sheet directions, which a body of less than three dimensions has no use for"
            )
        units = {}
        for name, values in given.items():
            if values.ndim != 2 or len(values) != len(points) or min(values.shape[1], points.shape[1]) < dim:
                raise self._error(
                    f"has '{name}' of shape {values.shape} for points of shape {points.shape}; "
                    f"({len(points)}, {dim}) is needed"
                )
            length = np.linalg.norm(values[:, :dim], axis=1)
            bad = ~(np.isfinite(length) & (length > 0))
            if bad.any():
                where = points[np.argmax(bad)].tolist()
                raise self._error(
                    f"has {int(bad.sum())} directions '{name}' that are zero or not finite, one at {where}"
                )
            units[name] = values[:, :dim] / length[:, None]
        if "s0" in units:
            along = np.abs((units["f0"] * units["s0"]).sum(axis=1)) > 1 - 1e-6
            if along.any():
                where = points[np.argmax(along)].tolist()
                raise self._error(f"has {int(along.sum())} sheet directions along the fibre, one at {where}")
        return units

    def _points_of_cells(self, mesh: Any, points: Array) -> npt.NDArray[np.int64]:
        """For each cell that this process owns the number of a point in it."""
        tdim = mesh.topology.dim
        owned = mesh.topology.index_map(tdim).size_local
        of_cell = np.full(owned, -1, dtype=np.int64)
        if owned and len(points):
            padded = np.zeros((len(points), 3))
            padded[:, : points.shape[1]] = points
            tree = dgeometry.bb_tree(mesh, tdim, entities=np.arange(owned, dtype=np.int32), padding=1e-9)
            near = dgeometry.compute_collisions_points(tree, padded)
            inside = dgeometry.compute_colliding_cells(mesh, near, padded)
            cells, starts = inside.array, inside.offsets
            of_cell[cells] = np.repeat(np.arange(len(points)), np.diff(starts))
        missing = np.flatnonzero(of_cell < 0)
        comm = lasting(mesh.comm)
        number = comm.allreduce(len(missing), MPI.SUM)
        if number:
            centres = mesh.geometry.x[mesh.geometry.dofmaps[0][missing[:1]]].mean(axis=1).round(6).tolist()
            first = next(c[0] for c in comm.allgather(centres) if c)
            raise self._error(f"has no direction in {number} cells of the body, such as the one near {first}")
        return of_cell
