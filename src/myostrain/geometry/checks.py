"""What cannot be a reference body is refused, saying where it is wrong; on the model that gmsh has read."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from myostrain.errors import InputError

import numpy as np
import numpy.typing as npt

Indices = npt.NDArray[np.int64]
Array = npt.NDArray[np.float64]

#: gmsh's numbers of the straight line, triangle and tetrahedron, by dimension, and what it calls such bodies.
CELL_KIND = {1: 1, 2: 2, 3: 4}
ENTITY = {1: "Curve", 2: "Surface", 3: "Volume"}


@dataclass(frozen=True)
class _Mesh:
    """A mesh as arrays.

    Args:
        path: Where it is from, for messages.
        dim: Its dimension.
        tags: gmsh's numbers of the nodes (n,), ascending.
        points: Their coordinates (n, 3).
        cells: Nodes of each cell (m, dim + 1), as places in ``tags``.
    """

    path: Path
    dim: int
    tags: Indices
    points: Array
    cells: Indices

    def centre(self, cell: Any) -> str:
        """Where a cell is."""
        return f"near {_place(self.points[self.cells[cell]].mean(axis=0)[: self.dim])}"

    def node(self, place: Any) -> str:
        """What a node is called, and where it is."""
        return f"node {self.tags[place]} at {_place(self.points[place])}"

    def error(self, message: str) -> InputError:
        """An error about the file."""
        return InputError(f"{self.path} {message}", "geometry.path")


def _place(point: Array) -> str:
    return str([float(f"{x:.7g}") for x in point])


def check(model: Any, dim: int, path: Path) -> None:
    """Refuse what cannot be a reference body.

    Args:
        model: gmsh's model.
        dim: Its dimension.
        path: The file, for messages.

    Raises:
        InputError: The message says what is wrong, and where.
    """
    key = "geometry.path"
    if dim not in CELL_KIND:
        raise InputError(f"{path} has dimension {dim}; a line (1), sheet (2) or solid (3) is needed", key)
    kinds, elements, _ = model.mesh.getElements(dim)
    if not sum(len(tags) for tags in elements):
        raise InputError(f"{path} has no cells of dimension {dim}: was it saved before it was meshed?", key)
    if not model.getPhysicalGroups(dim):
        raise InputError(
            f"{path} has no physical group of dimension {dim}; in gmsh, put the body into one "
            f'(for example `Physical {ENTITY[dim]}("body") = {{1}};`), mesh, and save again',
            key,
        )
    strange = [model.mesh.getElementProperties(int(kind))[0] for kind in kinds if kind != CELL_KIND[dim]]
    if strange:
        raise InputError(
            f"{path} has cells of kind {', '.join(strange)}; use straight lines, triangles or tetrahedra", key
        )
    for d in (dim, dim - 1):
        _check_groups(model, d, path)
    mesh = _read(model, dim, path)
    _check_points(mesh)
    _check_cells(mesh)
    _check_boundary(model, mesh)
    _check_whole(mesh)


def check_arrays(path: Path, dim: int, points: Array, cells: Indices) -> None:
    """Refuse a mesh that is no gmsh model, as far as it can be told; its cells may be turned either way.

    Args:
        path: The file, for messages.
        dim: Dimension of the body.
        points: Coordinates of the nodes (n, 3), which messages number from 0.
        cells: Their numbers (m, dim + 1).

    Raises:
        InputError: The message says what is wrong, and where.
    """
    mesh = _Mesh(path, dim, np.arange(len(points)), points, cells)
    _check_points(mesh)
    _check_cells(mesh, oriented=False)
    _check_whole(mesh)


def _read(model: Any, dim: int, path: Path) -> _Mesh:
    """Nodes, and the cells in physical groups."""
    key = "geometry.path"
    tags, coordinates, _ = model.mesh.getNodes()
    tags = np.asarray(tags, dtype=np.int64)
    order = np.argsort(tags, kind="stable")
    tags, points = tags[order], np.asarray(coordinates, dtype=float).reshape(-1, 3)[order]
    again = np.flatnonzero(np.diff(tags) == 0)
    if again.size:
        raise InputError(f"{path} has two nodes of number {tags[again[0]]}", key)
    corners = _corners(model, dim)
    if not len(corners):
        raise InputError(f"{path} has no cell in a physical group of dimension {dim}", key)
    outside = len(model.mesh.getElements(dim)[2][0]) // (dim + 1) - len(corners)
    cells = np.minimum(np.searchsorted(tags, corners), len(tags) - 1)
    wrong = tags[cells] != corners
    if wrong.any():
        raise InputError(f"{path} has a cell with node {corners[wrong][0]}, which is not there", key)
    if outside > 0:
        raise InputError(
            f"{path} has {outside} cells of dimension {dim} in no physical group; put the whole body into "
            "groups, and remove what is no part of it",
            key,
        )
    return _Mesh(path, dim, tags, points, cells)


def _corners(model: Any, dim: int) -> Indices:
    """Numbers of the nodes (m, dim + 1) of what is in physical groups of a dimension."""
    groups = [model.getEntitiesForPhysicalGroup(dim, tag) for _, tag in model.getPhysicalGroups(dim)]
    found = [model.mesh.getElements(dim, int(entity))[2] for entities in groups for entity in entities]
    nodes = [np.asarray(part, dtype=np.int64) for parts in found for part in parts]
    return np.concatenate(nodes or [np.zeros(0, dtype=np.int64)]).reshape(-1, dim + 1)


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


def _check_points(mesh: _Mesh) -> None:
    """Refuse coordinates that are not finite or not in the body's plane."""
    lost = ~np.isfinite(mesh.points).all(axis=1)
    if lost.any():
        raise mesh.error(f"has nodes whose coordinates are not finite, such as {mesh.node(np.argmax(lost))}")
    if np.abs(mesh.points).max() > 1e50:
        raise mesh.error(
            f"has coordinates above 1e50, such as {mesh.node(np.abs(mesh.points).max(axis=1).argmax())}"
        )
    if np.ptp(mesh.points, axis=0).max() < 1e-50:
        raise mesh.error(f"has all its nodes within 1e-50 of {mesh.node(0)}; choose other units")
    off = mesh.points[:, mesh.dim :] != mesh.points[0, mesh.dim :]
    if off.any():
        raise mesh.error(
            f"is not flat, see {mesh.node(np.argmax(off.any(axis=1)))}: a body of dimension {mesh.dim} lies "
            f"in the first {mesh.dim} coordinates"
        )


def _check_cells(mesh: _Mesh, oriented: bool = True) -> None:
    """Refuse copies, cells of no size and cells of both orientations."""
    _, first, number = np.unique(np.sort(mesh.cells, axis=1), axis=0, return_index=True, return_counts=True)
    copied = number > 1
    if copied.any():
        raise mesh.error(
            f"has {int((number - 1).sum())} cells twice, the first {mesh.centre(first[copied].min())}; "
            "remove the copies"
        )
    edges = (mesh.points[mesh.cells[:, 1:]] - mesh.points[mesh.cells[:, :1]])[:, :, : mesh.dim]
    longest = np.abs(edges).max(axis=(1, 2))
    size = np.linalg.det(edges / np.where(longest > 0, longest, 1.0)[:, None, None])
    flat = (np.abs(size) <= 1e-12) | (longest <= 1e-12 * np.ptp(mesh.points, axis=0).max())
    if flat.any():
        raise mesh.error(
            f"has {int(flat.sum())} cells of no size, the first {mesh.centre(np.argmax(flat))}; mend the "
            "mesh and save again"
        )
    turned = size < 0
    if oriented and turned.any() and not turned.all():
        odd = turned if 2 * turned.sum() <= len(turned) else ~turned
        raise mesh.error(
            f"has {int(odd.sum())} inverted cells among {len(odd)}, the first {mesh.centre(np.argmax(odd))}; "
            f"in gmsh, turn them with `ReverseMesh {ENTITY[mesh.dim]}`, or mesh again"
        )


def _check_boundary(model: Any, mesh: _Mesh) -> None:
    """Refuse named boundaries that are not sides of cells."""
    facets = np.sort(_corners(model, mesh.dim - 1), axis=1)
    if not len(facets):
        return
    corners = mesh.tags[mesh.cells]
    sides = np.sort(np.concatenate([np.delete(corners, i, axis=1) for i in range(mesh.dim + 1)]), axis=1)
    both, place = np.unique(np.concatenate([sides, facets]), axis=0, return_inverse=True)
    there = np.zeros(len(both), dtype=bool)
    there[place.reshape(-1)[: len(sides)]] = True
    strange = ~there[place.reshape(-1)[len(sides) :]]
    if strange.any():
        nodes = ", ".join(map(str, facets[np.argmax(strange)]))
        raise mesh.error(
            f"has {int(strange.sum())} boundary facets that are no side of a cell, the first with nodes "
            f"{nodes}; mesh the boundary and the body together"
        )


def _check_whole(mesh: _Mesh) -> None:
    """Refuse nodes that no cell uses and parts that do not hang together."""
    used = np.bincount(mesh.cells.reshape(-1), minlength=len(mesh.tags)) > 0
    if not used.all():
        raise mesh.error(
            f"has {int((~used).sum())} nodes that no cell of the body uses, the first "
            f"{mesh.node(np.argmin(used))}; in gmsh, put only the body and its boundary into physical "
            "groups, remove stray points, apply `Coherence Mesh`, and save again"
        )
    part = components(mesh.cells, len(mesh.tags))[mesh.cells[:, 0]]
    names, sizes = np.unique(part, return_counts=True)
    if len(names) > 1:
        least = np.argmin(sizes)
        raise mesh.error(
            f"has {len(names)} parts that do not hang together: one of {sizes[least]} cells "
            f"{mesh.centre(np.argmax(part == names[least]))}, the largest of {sizes.max()} cells; leave the "
            "smaller out, or join them in gmsh with `Coherence Mesh`"
        )


def components(cells: Indices, nodes: int) -> Indices:
    """For each node (nodes,) the lowest node that cells (m, corners) connect it with.

    Every cell hands its lowest label to its corners and to what these point to, then labels are shortened:
    the number of rounds grows with the logarithm of the number of nodes.
    """
    label = np.arange(nodes)
    while True:
        before = label.copy()
        lowest = np.repeat(label[cells].min(axis=1), cells.shape[1])
        np.minimum.at(label, label[cells].reshape(-1), lowest)
        np.minimum.at(label, cells.reshape(-1), lowest)
        label = label[label]
        if np.array_equal(label, before):
            return label
