"""What cannot be a reference body is refused, saying where it is wrong; on the model that gmsh has read."""

from __future__ import annotations

from collections.abc import Mapping
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

#: Nodes of a flat body are off their line or plane by this part of its extent at most: single precision has
#: errors of 1e-7.
FLATNESS = 1e-6


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
        return f"near {place(self.points[self.cells[cell]].mean(axis=0)[: self.dim])}"

    def node(self, number: Any) -> str:
        """What a node is called, and where it is."""
        return f"node {self.tags[number]} at {place(self.points[number])}"

    def error(self, message: str) -> InputError:
        """An error about the file."""
        return InputError(f"{self.path} {message}", "geometry.path")


def place(point: Array) -> str:
    """A point in seven digits, for messages."""
    return str([float(f"{x:.7g}") for x in point])


def check(model: Any, dim: int, path: Path, declared: Mapping[tuple[int, int], str]) -> None:
    """Refuse what cannot be a reference body.

    Args:
        model: gmsh's model.
        dim: Its dimension.
        path: The file, for messages.
        declared: Names of physical groups by dimension and tag, as the file has them.

    Raises:
        InputError: The message says what is wrong, and where.
    """
    key = "geometry.path"
    if dim not in CELL_KIND:
        raise InputError(f"{path} has dimension {dim}; a line (1), sheet (2) or solid (3) is needed", key)
    kinds, elements, _ = model.mesh.getElements(dim)
    body = f'`Physical {ENTITY[dim]}("body") = {{1}};`'
    if not sum(len(tags) for tags in elements):
        if any(len(tags) for tags in model.mesh.getElements(dim - 1)[1]):
            raise InputError(
                f"{path} has cells of dimension {dim - 1} but none of dimension {dim}: gmsh saves only what "
                f"is in physical groups; put the body into one, too (for example {body}), mesh it in {dim} "
                "dimensions, and save again",
                key,
            )
        raise InputError(f"{path} has no cells of dimension {dim}: was it saved before it was meshed?", key)
    if not model.getPhysicalGroups(dim):
        if declared and not model.getPhysicalGroups():
            raise InputError(
                f"{path} has names of physical groups, but no cell in one: gmsh's MSH 2.2 loses the groups "
                'with `Mesh.SaveAll = 1` ("Save all elements"); save again without it, or as MSH 4.1',
                key,
            )
        raise InputError(
            f"{path} has no physical group of dimension {dim}; in gmsh, put the body into one (for example "
            f"{body}), mesh, and save again",
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
    _check_sides(mesh, *_corners(model, dim - 1))
    _check_whole(mesh)


def check_arrays(
    path: Path, dim: int, points: Array, cells: Indices, facets: Indices, facet_tags: Indices
) -> None:
    """Refuse a mesh that is not a gmsh model, as far as it can be told; its cells may be turned either way.

    Args:
        path: The file, for messages.
        dim: Dimension of the body.
        points: Coordinates of the nodes (n, 3), which messages number from 0; some may be no cell's.
        cells: Their numbers (m, dim + 1).
        facets: Nodes (k, dim) of what is tagged on the boundary.
        facet_tags: Its tags (k,).

    Raises:
        InputError: The message says what is wrong, and where.
    """
    used, places = np.unique(cells, return_inverse=True)
    mesh = _Mesh(path, dim, used, points[used], places.reshape(cells.shape))
    _check_points(mesh)
    _check_cells(mesh, oriented=False)
    _check_sides(mesh, facets, facet_tags)
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
    corners, _ = _corners(model, dim)
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
            "groups, and remove what is not part of it",
            key,
        )
    return _Mesh(path, dim, tags, points, cells)


def _corners(model: Any, dim: int) -> tuple[Indices, Indices]:
    """Numbers of the nodes (m, dim + 1) of what is in physical groups of a dimension, and the groups (m,)."""
    nodes, groups = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for _, tag in model.getPhysicalGroups(dim):
        for entity in model.getEntitiesForPhysicalGroup(dim, tag):
            for part in model.mesh.getElements(dim, int(entity))[2]:
                nodes.append(np.asarray(part, dtype=np.int64))
                groups.append(np.full(len(part) // (dim + 1), tag))
    return np.concatenate(nodes).reshape(-1, dim + 1), np.concatenate(groups)


def _check_groups(model: Any, dim: int, path: Path) -> None:
    """Refuse a part in two physical groups: a mesh has one tag a part, the other group would be empty."""
    owner: dict[int, str] = {}
    for _, tag in model.getPhysicalGroups(dim):
        name = model.getPhysicalName(dim, tag) or str(tag)
        for entity in model.getEntitiesForPhysicalGroup(dim, tag):
            if int(entity) not in owner:
                owner[int(entity)] = name
                continue
            twice = f"{path} has a part in two physical groups, '{owner[int(entity)]}' and '{name}'; "
            if int(entity) == 0:
                raise InputError(
                    f"{twice}each element has the number of its group, but none of its entity, as "
                    'meshio writes it: there, give "gmsh:geometrical" the numbers of "gmsh:physical"',
                    "geometry.path",
                )
            raise InputError(f"{twice}put each part into one", "geometry.path")


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
    extent = np.ptp(mesh.points, axis=0).max()
    across = mesh.points[:, mesh.dim :]
    off = np.abs(across - np.median(across, axis=0)).max(axis=1, initial=0.0)
    if off.max() > FLATNESS * extent:
        flat = "plane" if mesh.dim == 2 else "line"
        raise mesh.error(
            f"is not flat: {mesh.node(np.argmax(off))} is {off.max():.3g} off the {flat} of the others, "
            f"{off.max() / extent:.2g} of the extent, and {FLATNESS:g} is allowed; a body of dimension "
            f"{mesh.dim} lies in the first {mesh.dim} coordinates (of a solid, save its cells, too)"
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


def _check_sides(mesh: _Mesh, facets: Indices, tags: Indices) -> None:
    """Refuse named boundaries that are not sides of cells, and a side in two of them."""
    if not len(facets):
        return
    facets, corners = np.sort(facets, axis=1), mesh.tags[mesh.cells]
    sides = np.sort(np.concatenate([np.delete(corners, i, axis=1) for i in range(mesh.dim + 1)]), axis=1)
    both, number = np.unique(np.concatenate([sides, facets]), axis=0, return_inverse=True)
    there = np.zeros(len(both), dtype=bool)
    there[number.reshape(-1)[: len(sides)]] = True
    number = number.reshape(-1)[len(sides) :]
    strange = ~there[number]
    if strange.any():
        nodes = ", ".join(map(str, facets[np.argmax(strange)]))
        raise mesh.error(
            f"has {int(strange.sum())} boundary facets that are not sides of a cell, the first with nodes "
            f"{nodes}; mesh the boundary and the body together"
        )
    tag_of = np.zeros(len(both), dtype=np.int64)
    tag_of[number] = tags
    other = tag_of[number] != tags
    if other.any():
        first = np.argmax(other)
        raise mesh.error(
            f"has {int(other.sum())} boundary facets twice, with two tags: {tags[first]} and "
            f"{tag_of[number[first]]} at nodes {', '.join(map(str, facets[first]))}; give each one tag"
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
