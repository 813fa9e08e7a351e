"""A mesh from an XDMF file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from myostrain.errors import InputError
from myostrain.geometry.checks import check_arrays
from myostrain.geometry.meshed import Meshed
from myostrain.geometry.xdmf_arrays import SHAPES, Indices, Simplices, grids, hdf5_files, read
from myostrain.validation import description

import basix.ufl
import numpy as np
import numpy.typing as npt
from dolfinx import graph, io
from dolfinx import mesh as dmesh

KEY = "geometry.path"


@dataclass(frozen=True)
class _Data:
    """What the first process has read and checked; the others have no nodes and cells.

    Args:
        dim: Dimension of the body.
        points: Coordinates of the nodes (n, dim).
        cells: Numbers of their nodes (m, dim + 1).
        tagged: Tagged facets and cells, by the key that names them.
        names: Tags by name, by the same keys.
    """

    dim: int
    points: npt.NDArray[np.float64]
    cells: Indices
    tagged: Mapping[str, Simplices]
    names: Mapping[str, dict[str, int]]

    def empty(self) -> _Data:
        """The same without numbers."""
        none = {
            key: Simplices(part.dim, part.nodes[:0], part.values[:0]) for key, part in self.tagged.items()
        }
        return _Data(self.dim, self.points[:0], self.cells[:0], none, self.names)


@description
class XdmfFile:
    """A mesh of straight lines, triangles or tetrahedra from an XDMF file and its HDF5 file, with tags.

    These are files as DOLFINx writes them (``XDMFFile.write_mesh`` and ``write_meshtags``). Tags there are
    numbers; names for them are given here, and a number that has none is its own name, as in "7".

    Args:
        path: The ``.xdmf`` file. In a case file, relative to the case file's folder.
        grid: Name of the mesh in the file; needed if there are several.
        facet_tags: Name of the tags of facets in the file, if boundaries are wanted.
        cell_tags: Name of the tags of cells in the file, if regions are wanted.
        boundaries: Names of boundaries, and their tags.
        regions: Names of regions, and their tags.
    """

    path: Path
    grid: str = "mesh"
    facet_tags: str | None = None
    cell_tags: str | None = None
    boundaries: Mapping[str, int] | None = None
    regions: Mapping[str, int] | None = None

    @property
    def files(self) -> tuple[Path, ...]:
        """What is read, the HDF5 files included: a run is resumed with the same only."""
        return (self.path, *hdf5_files(self.path))

    def mesh(self, comm: Any) -> Meshed:
        """Read the file and spread the mesh over the processes of ``comm``.

        Raises:
            InputError: The file or its HDF5 file is missing, damaged or unreadable, has no grid or tags of
                these names, tags of another kind, cells of another kind, cells of no size, or parts that do
                not hang together; or no part has a tag that is named.
        """
        problem, data, rest = None, None, None
        if comm.rank == 0:
            try:
                data = self._data()
                rest = data.empty()
            except InputError as error:
                problem = str(error)
        problem, rest = comm.bcast((problem, rest), root=0)
        if problem is not None:
            raise InputError(problem)
        data = data or rest
        shape = ("interval", "triangle", "tetrahedron")[data.dim - 1]
        mesh = dmesh.create_mesh(
            comm,
            data.cells,
            basix.ufl.element("Lagrange", shape, 1, shape=(data.dim,)),
            data.points,
            dmesh.create_cell_partitioner(dmesh.GhostMode.shared_facet, 2),
        )
        tags = {key: _tags(mesh, part) for key, part in data.tagged.items()}
        return Meshed(
            mesh,
            tags.get("facet_tags"),
            data.names.get("facet_tags", {}),
            tags.get("cell_tags"),
            data.names.get("cell_tags", {}),
        )

    def counts(self) -> tuple[float, float]:
        """How many nodes and cells the file has, before anything reads them."""
        try:
            grid = grids(self.path)[self.grid][0]
            sizes = [
                float(str(part.attrib[what]).split()[0])
                for tag, what in (("Geometry/DataItem", "Dimensions"), ("Topology", "NumberOfElements"))
                for part in grid.iterfind(tag)
            ]
            return sizes[0], sizes[1]
        except (InputError, KeyError, IndexError, ValueError):
            return 0.0, 0.0  # who reads it will say why

    def _data(self) -> _Data:
        """Read and check the file."""
        wanted = {"facet_tags": self.facet_tags, "cell_tags": self.cell_tags}
        for key, given in (("facet_tags", self.boundaries), ("cell_tags", self.regions)):
            if given and wanted[key] is None:
                of = "boundaries" if key == "facet_tags" else "regions"
                raise InputError(f"names are given, but no {key} to read from the file", f"geometry.{of}")
        asked = {key: name for key, name in wanted.items() if name is not None}
        points, cells, tagged = read(self.path, self.grid, asked)
        dim = cells.dim
        if dim == 0 or points.shape[1] < dim:
            raise InputError(
                f"{self.path} has cells that are {SHAPES[dim]}, and nodes of {points.shape[1]} coordinates; "
                "use lines, triangles or tetrahedra",
                KEY,
            )
        for key, part in tagged.items():
            self._check_tags(key, part, dim, cells.nodes)
        if not len(cells.nodes):
            raise InputError(f"{self.path} has no cells", KEY)
        nothing = Simplices(dim - 1, np.zeros((0, dim), dtype=np.int64), np.zeros(0, dtype=np.int64))
        sides = tagged.get("facet_tags", nothing)
        padded = np.zeros((len(points), 3))
        padded[:, : points.shape[1]] = points
        check_arrays(self.path, dim, padded, cells.nodes, sides.nodes, sides.values)
        names: dict[str, dict[str, int]] = {}
        if "facet_tags" in tagged:
            names["facet_tags"] = _named(tagged["facet_tags"].values, self.boundaries, "boundaries")
        if "cell_tags" in tagged:
            names["cell_tags"] = _named(tagged["cell_tags"].values, self.regions, "regions")
        return _Data(dim, points[:, :dim], cells.nodes, tagged, names)

    def _check_tags(self, key: str, part: Simplices, dim: int, cells: Indices) -> None:
        """Refuse tags of something else than the key says."""
        needed = dim - 1 if key == "facet_tags" else dim
        if part.dim != needed:
            what = "the sides of the cells" if key == "facet_tags" else "the cells"
            raise InputError(
                f"'{getattr(self, key)}' in {self.path} are tags of {SHAPES[part.dim]}; {what} are "
                f"{SHAPES[needed]}",
                f"geometry.{key}",
            )
        if key == "facet_tags":
            return
        both = np.sort(np.concatenate([cells, part.nodes]), axis=1)
        number = np.unique(both, axis=0, return_inverse=True)[1].reshape(-1)
        strange = ~np.isin(number[len(cells) :], number[: len(cells)])
        if strange.any():
            raise InputError(
                f"{self.path} has tags of {int(strange.sum())} {SHAPES[dim]} that are not cells of the mesh",
                f"geometry.{key}",
            )
        if len(np.unique(number[len(cells) :])) < len(part.nodes):
            raise InputError(f"{self.path} has two tags for a cell", f"geometry.{key}")


def _tags(mesh: dmesh.Mesh, part: Simplices) -> dmesh.MeshTags:
    """Tags on a mesh of simplices whose nodes have the file's numbers, given on any process."""
    mesh.topology.create_entities(part.dim)
    mesh.topology.create_connectivity(part.dim, mesh.topology.dim)
    entities, values = io.distribute_entity_data(mesh, part.dim, part.nodes, part.values.astype(np.int32))
    return dmesh.meshtags_from_entities(mesh, part.dim, graph.adjacencylist(entities), values)


def _named(values: Indices, names: Mapping[str, int] | None, key: str) -> dict[str, int]:
    """The tags by name; one without a name is called by its number."""
    known = np.unique(values).tolist()
    given = dict(names or {})
    for name, value in given.items():
        if value not in known or value < 0:
            there = ", ".join(str(tag) for tag in known if tag >= 0)
            raise InputError(f"nothing has the tag {value}; there are {there}", f"geometry.{key}.{name}")
        if name.isdecimal() and int(name) in known and int(name) != value:
            raise InputError(
                f"'{name}' is the name of the tag {value}, but there is a tag {name}; choose another name",
                f"geometry.{key}.{name}",
            )
    unnamed = {str(tag): tag for tag in known if tag >= 0 and tag not in given.values()}
    return given | unnamed
