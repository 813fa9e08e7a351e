"""A mesh from an XDMF file."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from myostrain.engine import lasting
from myostrain.errors import InputError, nearest
from myostrain.geometry.checks import check_arrays
from myostrain.geometry.gmsh_model import readable
from myostrain.geometry.meshed import Meshed
from myostrain.validation import description

import numpy as np
import numpy.typing as npt
from dolfinx import mesh as dmesh
from dolfinx.io import XDMFFile

KEY = "geometry.path"
SIMPLICES = {dmesh.CellType.interval: 1, dmesh.CellType.triangle: 2, dmesh.CellType.tetrahedron: 3}


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

    def mesh(self, comm: Any) -> Meshed:
        """Read the file and spread the mesh over the processes of ``comm``.

        Raises:
            InputError: The file or its HDF5 file is missing or unreadable, has no grid or tags of these
                names, cells of another kind, cells of no size, or parts that do not hang together; or no part
                has a tag that is named.
        """
        problem = None
        if comm.rank == 0:
            try:
                self._check_file()
            except InputError as error:
                problem = str(error)
        problem = comm.bcast(problem, root=0)
        if problem is not None:
            raise InputError(problem)
        try:
            with XDMFFile(comm, str(self.path), "r") as file:
                mesh = file.read_mesh(name=self.grid)
                self._check(mesh)
                dim = mesh.topology.dim
                for d in (dim - 1, dim):
                    mesh.topology.create_entities(d)
                    mesh.topology.create_connectivity(d, dim)
                facets = file.read_meshtags(mesh, name=self.facet_tags) if self.facet_tags else None
                cells = file.read_meshtags(mesh, name=self.cell_tags) if self.cell_tags else None
        except RuntimeError as error:
            raise InputError(f"{self.path} cannot be read: {error}", KEY) from error
        return Meshed(
            mesh,
            facets,
            _named(comm, facets, self.boundaries, "boundaries"),
            cells,
            _named(comm, cells, self.regions, "regions"),
        )

    def counts(self) -> tuple[float, float]:
        """How many nodes and cells the file has, before anything reads them."""
        try:
            grid = self._grids()[self.grid]
            sizes = [
                float(str(part.attrib[what]).split()[0])
                for tag, what in (("Geometry/DataItem", "Dimensions"), ("Topology", "NumberOfElements"))
                for part in grid.iterfind(tag)
            ]
            return sizes[0], sizes[1]
        except (InputError, KeyError, IndexError, ValueError):
            return 0.0, 0.0  # who reads it will say why

    def _grids(self) -> dict[str, ET.Element]:
        try:
            root = ET.parse(self.path).getroot()
        except (ET.ParseError, OSError, ValueError) as error:
            raise InputError(f"{self.path} is no XDMF file: {error}", KEY) from error
        if root.tag != "Xdmf":
            raise InputError(f"{self.path} is no XDMF file: it begins with <{root.tag[:30]}>", KEY)
        return {grid.get("Name", ""): grid for grid in root.iter("Grid")}

    def _check_file(self) -> None:
        """Refuse a file without these grids or without its HDF5 file; of these DOLFINx says little."""
        readable(self.path, KEY)
        grids = self._grids()
        wanted = {"grid": self.grid, "facet_tags": self.facet_tags, "cell_tags": self.cell_tags}
        for key, name in wanted.items():
            if name is not None and name not in grids:
                raise InputError(
                    f"{self.path} has no grid called '{name}'; {nearest(name, grids)}", f"geometry.{key}"
                )
        for grid in grids.values():
            for item in grid.iter("DataItem"):
                if item.get("Format") == "HDF" and item.text:
                    data = self.path.parent / item.text.strip().rsplit(":", 1)[0]
                    readable(data, KEY)
                    with data.open("rb") as stream:
                        if not stream.read(8).startswith(b"\x89HDF"):
                            raise InputError(f"{data} is no HDF5 file", KEY)

    def _check(self, mesh: dmesh.Mesh) -> None:
        """Refuse what cannot be a reference body; the first process looks, all learn the outcome."""
        dim = SIMPLICES.get(mesh.topology.cell_type)
        if dim is None or mesh.geometry.cmaps[0].degree != 1:
            raise InputError(
                f"{self.path} has cells of kind {mesh.topology.cell_type.name}, degree "
                f"{mesh.geometry.cmaps[0].degree}; use straight lines, triangles or tetrahedra",
                KEY,
            )
        if mesh.geometry.dim != dim:
            raise InputError(
                f"{self.path} has cells of dimension {dim} and nodes of {mesh.geometry.dim} coordinates; "
                f"save nodes of {dim} coordinates",
                KEY,
            )
        comm, nodes = lasting(mesh.comm), mesh.geometry.index_map()
        owned = mesh.topology.index_map(dim).size_local
        corners = nodes.local_to_global(mesh.geometry.dofmaps[0][:owned].reshape(-1)).reshape(-1, dim + 1)
        parts = comm.gather((mesh.geometry.x[: nodes.size_local], corners), root=0)
        problem = None
        if comm.rank == 0:
            points, cells = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
            try:
                check_arrays(self.path, dim, points, cells)
            except InputError as error:
                problem = str(error)
        problem = comm.bcast(problem, root=0)
        if problem is not None:
            raise InputError(problem)


def _named(
    comm: Any, tags: dmesh.MeshTags | None, names: Mapping[str, int] | None, key: str
) -> dict[str, int]:
    """The tags by name."""
    if tags is None:
        if names:
            what = "facet_tags" if key == "boundaries" else "cell_tags"
            raise InputError(f"names are given, but no {what} to read from the file", f"geometry.{key}")
        return {}
    values: npt.NDArray[np.int32] = np.unique(np.concatenate(comm.allgather(np.unique(tags.values))))
    for name, value in (names or {}).items():
        if value not in values:
            known = ", ".join(map(str, values))
            raise InputError(f"nothing has the tag {value}; there are {known}", f"geometry.{key}.{name}")
    called = {value: name for name, value in (names or {}).items()}
    return {called.get(int(value), str(value)): int(value) for value in values}
