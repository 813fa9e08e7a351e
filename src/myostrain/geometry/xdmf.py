"""A mesh from an XDMF file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from myostrain.errors import InputError
from myostrain.geometry.mesh_arrays import MeshArrays, named, spread_out
from myostrain.geometry.meshed import Meshed
from myostrain.geometry.xdmf_arrays import SHAPES, Indices, Simplices, grids, hdf5_files, read
from myostrain.validation import description

import numpy as np

KEY = "geometry.path"


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
        return spread_out(comm, self.arrays)

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

    def arrays(self) -> MeshArrays:
        """Read and check the file, on one process.

        Raises:
            InputError: See :meth:`mesh`.
        """
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
        names: dict[str, dict[str, int]] = {}
        if "facet_tags" in tagged:
            names["facet_tags"] = named(tagged["facet_tags"].values, self.boundaries, "boundaries")
        if "cell_tags" in tagged:
            names["cell_tags"] = named(tagged["cell_tags"].values, self.regions, "regions")
        found = MeshArrays(dim, points[:, :dim], cells.nodes, tagged, names)
        MeshArrays(dim, points, cells.nodes, tagged, names).check(self.path)
        return found

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
