"""A mesh from a gmsh file."""

from pathlib import Path
from typing import Any

from myostrain.errors import InputError
from myostrain.geometry.body import Meshed
from myostrain.geometry.gmsh_model import readable, to_meshed
from myostrain.validation import description

import numpy as np
import numpy.typing as npt

Cells = npt.NDArray[np.int64]

#: gmsh's numbers of the straight line and the straight triangle, by dimension.
CELL_KIND = {1: 1, 2: 2}


@description
class MeshFile:
    """A gmsh ``.msh`` file of straight lines or triangles.

    The physical groups of the highest dimension are the body and its regions, those one dimension lower
    the boundaries that ``mechanics.fixed`` and others name.

    Args:
        path: The file. In a case file, relative to the case file's folder.
    """

    path: Path

    def mesh(self, comm: Any) -> Meshed:
        """Read the file and spread the mesh over the processes of ``comm``.

        Raises:
            InputError: The file is missing, empty or unreadable, has no physical group for its cells, cells
                of another kind than straight lines or triangles, or cells of no size.
        """

        def make(gmsh: Any) -> int:
            readable(self.path, "geometry.path")
            gmsh.open(str(self.path))
            dim = int(gmsh.model.getDimension())
            if dim < 0:
                raise InputError(
                    f"{self.path} has no cells: was it saved before it was meshed?", "geometry.path"
                )
            _check(gmsh.model, dim, self.path)
            return dim

        return to_meshed(comm, make, str(self.path))


def _check(model: Any, dim: int, path: Path) -> None:
    """Refuse what cannot be a reference body, saying where it is wrong."""
    key = "geometry.path"
    if dim not in CELL_KIND:
        raise InputError(f"{path} has dimension {dim}; a line (1) or a sheet (2) is needed", key)
    kinds, elements, corners = model.mesh.getElements(dim)
    if not sum(len(tags) for tags in elements):
        raise InputError(f"{path} has no cells of dimension {dim}: was it saved before it was meshed?", key)
    if not model.getPhysicalGroups(dim):
        raise InputError(
            f"{path} has no physical group of dimension {dim}; in gmsh, put the body into one "
            '(for example `Physical Surface("body") = {1};`), mesh, and save again',
            key,
        )
    strange = [model.mesh.getElementProperties(int(kind))[0] for kind in kinds if kind != CELL_KIND[dim]]
    if strange:
        raise InputError(
            f"{path} has cells of kind {', '.join(strange)}; use straight lines or triangles", key
        )
    cells = np.asarray(corners[0], dtype=np.int64).reshape(-1, dim + 1)
    _check_cells(model, dim, cells, path)
    for d in (dim, dim - 1):
        _check_groups(model, d, path)
    _check_boundary(model, dim, cells, path)


def _check_groups(model: Any, dim: int, path: Path) -> None:
    """Refuse a part in two physical groups: a mesh has one tag a part, the other group would be empty."""
    owner: dict[int, str] = {}
    for _, tag in model.getPhysicalGroups(dim):
        name = model.getPhysicalName(dim, tag) or str(tag)
        for entity in model.getEntitiesForPhysicalGroup(dim, tag):
            if int(entity) in owner:
                raise InputError(
                    f"{path} has a part in two physical groups, '{owner[int(entity)]}' and '{name}'; "
                    "put each part into one",
                    "geometry.path",
                )
            owner[int(entity)] = name


def _check_boundary(model: Any, dim: int, cells: Cells, path: Path) -> None:
    """Refuse named boundaries that are not sides of cells."""
    groups = [model.getEntitiesForPhysicalGroup(dim - 1, tag) for d, tag in model.getPhysicalGroups(dim - 1)]
    found = [model.mesh.getElements(dim - 1, int(entity))[2] for entities in groups for entity in entities]
    nodes = [np.asarray(part, dtype=np.int64) for parts in found for part in parts]
    if not nodes:
        return
    facets = np.sort(np.concatenate(nodes).reshape(-1, dim), axis=1)
    sides = np.concatenate([np.delete(cells, corner, axis=1) for corner in range(dim + 1)])
    base = int(max(cells.max(), facets.max())) + 1
    power = base ** np.arange(dim)
    strange = ~np.isin(facets @ power, np.sort(sides, axis=1) @ power)
    if strange.any():
        raise InputError(
            f"{path} has {int(strange.sum())} boundary facets that are no side of a cell; mesh the boundary "
            "and the body together",
            "geometry.path",
        )


def _check_cells(model: Any, dim: int, corners: Cells, path: Path) -> None:
    key = "geometry.path"
    tags, coordinates, _ = model.mesh.getNodes()
    points = np.zeros((int(tags.max()) + 1, 3))
    points[tags] = coordinates.reshape(-1, 3)
    if not np.isfinite(points).all():
        raise InputError(f"{path} has nodes whose coordinates are not finite", key)
    if dim < 3 and np.ptp(points[tags][:, dim:], axis=0).max(initial=0) > 0:
        raise InputError(
            f"{path} is not flat: a body of dimension {dim} lies in the first {dim} coordinates", key
        )
    same = len(corners) - len(np.unique(np.sort(corners, axis=1), axis=0))
    if same:
        raise InputError(f"{path} has {same} cells twice; remove the copies", key)
    edges = points[corners[:, 1:]] - points[corners[:, :1]]
    size = np.abs(np.linalg.det(edges[:, :, :dim]))
    longest = np.linalg.norm(edges, axis=2).max(axis=1)
    bad = size <= 1e-12 * longest**dim
    if bad.any():
        centre = points[corners[np.argmax(bad)]].mean(axis=0)[:dim]
        raise InputError(
            f"{path} has {int(bad.sum())} cells of no size, the first near {np.round(centre, 6).tolist()}; "
            "mend the mesh and save again",
            key,
        )
