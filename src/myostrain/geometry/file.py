"""A mesh from a gmsh file."""

from pathlib import Path
from typing import Any

from myostrain.errors import InputError
from myostrain.geometry.body import Meshed
from myostrain.geometry.gmsh_model import readable, to_meshed
from myostrain.validation import description

import numpy as np

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
    _check_cells(model, dim, np.asarray(corners[0]).reshape(-1, dim + 1), path)


def _check_cells(model: Any, dim: int, corners: np.ndarray, path: Path) -> None:
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
