"""A body on a finer mesh that is nested in its own: every cell is divided into cells of half the size."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from myostrain.engine import fem, lasting
from myostrain.errors import InputError
from myostrain.geometry.body import MAX_CELLS, Body
from myostrain.geometry.cell_fields import CellFields
from myostrain.geometry.corners import corners, is_curved
from myostrain.geometry.fibres import Microstructure
from myostrain.geometry.meshed import Meshed
from myostrain.geometry.numbering import canonical_numbers
from myostrain.validation import Level, checked

import basix.ufl
import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import graph
from dolfinx import mesh as dmesh

Array = npt.NDArray[np.float64]
Cells = npt.NDArray[np.int32]
Numbers = npt.NDArray[np.int64]

#: Children of a cell by its nodes of degree 2: corners, then middles of edges, in the order of Basix. Those
#: of a tetrahedron at its corners; the octahedron between is divided about one of its three diagonals.
CHILDREN = {
    1: np.array([[[0, 2], [2, 1]]]),
    2: np.array([[[0, 5, 4], [5, 1, 3], [4, 3, 2], [3, 4, 5]]]),
    3: np.array(
        [
            [[0, 9, 8, 7], [9, 1, 6, 5], [8, 6, 2, 4], [7, 5, 4, 3], *([*ends, *side] for side in sides)]
            for ends, sides in (
                ((4, 9), ((5, 6), (6, 8), (8, 7), (7, 5))),
                ((5, 8), ((4, 6), (6, 9), (9, 7), (7, 4))),
                ((6, 7), ((4, 5), (5, 9), (9, 8), (8, 4))),
            )
        ]
    ),
}


@dataclass(frozen=True, repr=False)
class RefinedBody(Body):
    """A body on a mesh that is nested in another body's.

    Args:
        coarse: The other body.
        parents: The other body's cell in which each cell of this process lies, (cells,).
        places: Where in it the corners are, in coordinates of the reference cell, (cells, dim + 1, dim).
    """

    coarse: Body
    parents: Cells
    places: Array


def refined(body: Body, levels: int) -> Body:
    """The body on a finer mesh: so many times each cell is divided into 2, 4 or 8 of half the size.

    Names of boundaries and regions are inherited, and so are fibres: a new cell has the parent's directions
    at its own centre. A new cell is on the process of its parent, and the mesh is the same on any number
    of processes. The octahedron in the middle of a tetrahedron is divided about its shortest diagonal, so
    that cells do not get ever flatter (J. Bey, Computing 55 (1995) 355–378, doi 10.1007/BF02238487). Cells of
    curved ones are straight, with corners at the curved ones' nodes.

    Args:
        body: The body.
        levels: How often; zero gives the body itself.

    Raises:
        InputError: ``levels`` is not a whole number from zero on, or there would be too many cells.
    """
    levels = checked(Level, levels, "potential.refinement")
    cells = body.cells * 2.0 ** (body.dim * min(levels, 100))
    if cells > MAX_CELLS:
        raise InputError(
            f"{levels}: this gives about {cells:.2g} cells, more than {MAX_CELLS:.1g}: refine less often",
            "potential.refinement",
        )
    if levels == 0:
        return body
    meshed, dim = body.meshed, body.dim
    unit = np.vstack([np.zeros(dim), np.eye(dim)])
    owned = body.mesh.topology.index_map(dim).size_local
    parents, places = np.arange(owned, dtype=np.int32), np.broadcast_to(unit, (owned, dim + 1, dim))
    for _ in range(levels):
        meshed, above, nodes = _refined(meshed)
        places = np.einsum("cik,ckd->cid", _shares(dim)[nodes], places[above])
        parents = parents[above]
    return RefinedBody(meshed, _inherited(body, meshed, parents, places), body, parents, places)


def _shares(dim: int) -> Array:
    """Barycentric coordinates of a simplex' nodes of degree 2, (nodes, dim + 1)."""
    edges = basix.topology(_simplex(dim))[1]
    return np.vstack([np.eye(dim + 1), [[(k in edge) / 2 for k in range(dim + 1)] for edge in edges]])


def _simplex(dim: int) -> Any:
    return (basix.CellType.interval, basix.CellType.triangle, basix.CellType.tetrahedron)[dim - 1]


def _refined(meshed: Meshed) -> tuple[Meshed, Cells, Numbers]:
    """Refine once.

    Returns:
        The mesh; each new cell's parent; and the parent's nodes of degree 2 that are its corners.
    """
    mesh, comm = meshed.mesh, lasting(meshed.mesh.comm)
    dim = mesh.topology.dim
    owned = mesh.topology.index_map(dim).size_local
    space = fem.functionspace(mesh, ("Lagrange", 2))
    numbers, dofs = canonical_numbers(space), space.dofmap.list[:owned]
    points = np.empty((len(numbers), dim))
    if is_curved(mesh):  # its own nodes of degree 2, by the same order
        points[dofs] = mesh.geometry.x[mesh.geometry.dofmaps[0][:owned], :dim]
    else:  # half the sum, which has the same bits from either end
        points[dofs] = np.einsum("nk,ckd->cnd", _shares(dim), corners(mesh)[:owned])
    nodes = CHILDREN[dim][_diagonals(points[dofs])].reshape(-1, dim + 1)
    above = np.repeat(np.arange(owned, dtype=np.int32), 2**dim)
    fine = _made(mesh, comm, space.dofmap.index_map, numbers, points, numbers[dofs][above[:, None], nodes])
    first = int(comm.scan(len(above))) - len(above)
    order = np.asarray(fine.topology.original_cell_index, dtype=np.int64) - first
    above, nodes = above[order], nodes[order]
    return _named(meshed, fine, above, nodes), above, nodes


def _diagonals(points: Array) -> Numbers:
    """Which of the ways to divide it is each cell's: one, or that about the shortest diagonal."""
    ends = CHILDREN[points.shape[2]][:, -1, :2]
    if len(ends) == 1:
        return np.zeros(len(points), dtype=np.int64)
    lengths = ((points[:, ends[:, 0]] - points[:, ends[:, 1]]) ** 2).sum(axis=2)
    # Lengths that differ by round-off are the same.
    return np.argmax(lengths <= lengths.min(axis=1, keepdims=True) * (1 + 1e-9), axis=1)


def _made(
    mesh: Any, comm: Any, index_map: Any, numbers: Numbers, points: Array, cells: Numbers
) -> dmesh.Mesh:
    """The mesh of these cells, each on this process, given by canonical numbers of nodes."""
    mine = slice(0, index_map.size_local)
    parts = comm.gather((numbers[mine], points[mine]), root=0)
    whole = np.zeros((0, points.shape[1]))
    if parts is not None:
        whole = np.empty((index_map.size_global, points.shape[1]))
        for places, part in parts:
            whole[places] = part

    def stay(comm: Any, processes: int, kinds: Any, given: Any) -> Any:
        own = np.full((len(given[0]) // cells.shape[1], 1), comm.rank, dtype=np.int32)
        return graph.adjacencylist(own)._cpp_object

    straight = basix.ufl.element("Lagrange", mesh.basix_cell(), 1, shape=(points.shape[1],))
    return dmesh.create_mesh(mesh.comm, cells, ufl.Mesh(straight), whole, partitioner=stay)


def _named(meshed: Meshed, fine: dmesh.Mesh, above: Cells, nodes: Numbers) -> Meshed:
    """The new mesh with the names of the old one."""
    old, new, dim = meshed.mesh.topology, fine.topology, fine.topology.dim
    cell_tags, facet_tags = None, None
    if meshed.cell_tags is not None:
        values = _dense(meshed.cell_tags, old, dim)[above]
        cell_tags = _tags(fine, dim, values)
    if meshed.facet_tags is not None:
        # A side lies on a side of the parent if no node of it has a share of the corner opposite.
        sides = np.array(basix.topology(_simplex(dim))[dim - 1])
        carried = _shares(dim)[nodes][:, sides].max(axis=2) > 0  # (cells, sides, corners)
        opposite = np.ones((dim + 1, dim + 1), dtype=bool)
        np.put_along_axis(opposite, sides, values=False, axis=1)
        within = ~(carried[:, :, None, :] & opposite).any(axis=3)  # (cells, sides, sides of the parent)
        cell, side, side_above = np.nonzero(within)
        old.create_connectivity(dim, dim - 1)
        new.create_connectivity(dim, dim - 1)
        before = old.connectivity(dim, dim - 1).array.reshape(-1, dim + 1)
        after = new.connectivity(dim, dim - 1).array.reshape(-1, dim + 1)
        facets = new.index_map(dim - 1)
        values = np.full(facets.size_local + facets.num_ghosts, NONE, dtype=np.int32)
        found = _dense(meshed.facet_tags, old, dim - 1)[before[above[cell], side_above]]
        values[after[cell, side]] = found
        facet_tags = _tags(fine, dim - 1, values)
    return Meshed(fine, facet_tags, meshed.boundaries, cell_tags, meshed.regions)


#: What is in no part of a mesh.
NONE = np.iinfo(np.int32).min


def _dense(tags: dmesh.MeshTags, topology: Any, dim: int) -> npt.NDArray[np.int32]:
    entities = topology.index_map(dim)
    values = np.full(entities.size_local + entities.num_ghosts, NONE, dtype=np.int32)
    values[tags.indices] = tags.values
    return values


def _tags(mesh: dmesh.Mesh, dim: int, values: npt.NDArray[np.int32]) -> dmesh.MeshTags:
    (tagged,) = np.nonzero(values != NONE)
    return dmesh.meshtags(mesh, dim, tagged.astype(np.int32), values[tagged])


def _inherited(body: Body, meshed: Meshed, parents: Cells, places: Array) -> Microstructure:
    """The directions at the centres of the new cells."""
    space = fem.functionspace(meshed.mesh, ("DG", 0, (body.dim,)))
    centres = places.mean(axis=1)[:, None]
    found: list[fem.Function | None] = []
    for direction in (body.fibres.f0, body.fibres.s0, body.fibres.n0):
        if direction is None:
            found.append(None)
            continue
        given = CellFields(body.mesh, direction, 2)
        values = given.matrix_at(centres, parents) @ given.values()
        field = fem.Function(space, name="direction")
        # The order of the cells is that of a piecewise constant field.
        for other in (f.x.array.reshape(values.shape) for f in found if f is not None):
            values -= (values * other).sum(axis=1, keepdims=True) * other
        field.x.array[:] = (values / np.linalg.norm(values, axis=1, keepdims=True)).reshape(-1)
        found.append(field)
    return Microstructure(*found)
