"""A mesh of simplices from arrays that the first process has read, with tags by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from myostrain.errors import InputError
from myostrain.geometry.checks import check_arrays
from myostrain.geometry.meshed import Meshed
from myostrain.geometry.xdmf_arrays import Indices, Simplices

import basix.ufl
import numpy as np
import numpy.typing as npt
from dolfinx import graph, io
from dolfinx import mesh as dmesh


@dataclass(frozen=True)
class MeshArrays:
    """What the first process has read and checked; the others have no nodes and cells.

    Args:
        dim: Dimension of the body.
        points: Coordinates of the nodes (n, dim).
        cells: Numbers of their nodes (m, dim + 1).
        tagged: Tagged facets and cells, by "facet_tags" and "cell_tags".
        names: Tags by name, by the same keys.
    """

    dim: int
    points: npt.NDArray[np.float64]
    cells: Indices
    tagged: Mapping[str, Simplices]
    names: Mapping[str, dict[str, int]]

    def empty(self) -> MeshArrays:
        """The same without numbers."""
        none = {
            key: Simplices(part.dim, part.nodes[:0], part.values[:0]) for key, part in self.tagged.items()
        }
        return MeshArrays(self.dim, self.points[:0], self.cells[:0], none, self.names)

    def check(self, path: Path) -> None:
        """Refuse a mesh that is none, see :func:`~myostrain.geometry.checks.check_arrays`."""
        nothing = Simplices(
            self.dim - 1, np.zeros((0, self.dim), dtype=np.int64), np.zeros(0, dtype=np.int64)
        )
        sides = self.tagged.get("facet_tags", nothing)
        padded = np.zeros((len(self.points), 3))
        padded[:, : self.points.shape[1]] = self.points
        check_arrays(path, self.dim, padded, self.cells, sides.nodes, sides.values)


def spread_out(comm: Any, read: Callable[[], MeshArrays]) -> Meshed:
    """Spread what the first process reads over all of them (collective).

    Args:
        comm: The communicator.
        read: What reads, on the first process.

    Raises:
        InputError: What ``read`` raises, on every process.
    """
    problem, data, rest = None, None, None
    if comm.rank == 0:
        try:
            data = read()
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


def _tags(mesh: dmesh.Mesh, part: Simplices) -> dmesh.MeshTags:
    """Tags on a mesh of simplices whose nodes have the file's numbers, given on any process."""
    mesh.topology.create_entities(part.dim)
    mesh.topology.create_connectivity(part.dim, mesh.topology.dim)
    entities, values = io.distribute_entity_data(mesh, part.dim, part.nodes, part.values.astype(np.int32))
    return dmesh.meshtags_from_entities(mesh, part.dim, graph.adjacencylist(entities), values)


def named(values: Indices, names: Mapping[str, int] | None, key: str) -> dict[str, int]:
    """The tags by name; one without a name is called by its number.

    Raises:
        InputError: A name is that of no tag, or the number of another one.
    """
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
