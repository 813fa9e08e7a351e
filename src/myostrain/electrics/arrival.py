"""When nodes are reached: from a table of times, or by a front that runs over a surface from its roots."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from myostrain.engine import fem, lasting
from myostrain.errors import InputError
from myostrain.geometry import Body, readable
from myostrain.geometry.body import range_of

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

#: A node takes a mean of so many nearest points of a table.
NEIGHBOURS = 8

#: A node of the place is no farther from the nearest point of a table, and a root from its surface, than this
#: share of the body's diagonal: what is farther has other units, or is of another body.
FARTHEST = 0.5


def tabulated(path: Path, body: Body, space: Any, share: Array, key: str) -> Array:
    """Times at the nodes of a place from a table (nodes,), infinite where never (collective).

    Args:
        path: A CSV file with the columns x, y, z (as many as the body has dimensions) and time, in any order;
            or node and time, with numbers of the nodes in the file of the mesh, from 0.
        body: The reference body.
        space: P1 space of the nodes.
        share: How much of each node is in the place (nodes,).
        key: Key of a case file that names the table, for messages.

    Raises:
        InputError: The file is missing or no such table, or a node of the place has no time.
    """
    comm = lasting(body.comm)
    problem, table = "", {}
    if comm.rank == 0:
        try:
            table = _read(path, body.dim)
        except InputError as error:
            problem = str(error).removeprefix(f"{key}: ")
    problem, table = comm.bcast((problem, table), root=0)
    if problem:
        raise InputError(problem, key)
    inside = share > 0
    if "node" in table:
        found = _by_number(body, space, table)
        missing = comm.allreduce(int((np.isnan(found) & inside).sum()))
        if missing:
            raise InputError(
                f"{path} has no time for {missing} nodes of the place; give each a time, inf for never", key
            )
        return np.where(inside, found, np.inf)
    found, distance = _nearby(table, space.tabulate_dof_coordinates()[:, : body.dim])
    far = max(comm.allgather(float(distance[inside].max(initial=0.0))))
    low, high = body.extent()
    if far > FARTHEST * np.linalg.norm(high - low):
        points = np.column_stack([table[name] for name in "xyz"[: body.dim]])
        raise InputError(
            f"{path}: a node of the place is {far:.4g} away from the nearest point of the table; its points "
            f"are between {points.min(axis=0).tolist()} and {points.max(axis=0).tolist()}, the body is "
            f"between {low.tolist()} and {high.tolist()}: are the units the same?",
            key,
        )
    return np.where(inside, found, np.inf)


def _read(path: Path, dim: int) -> dict[str, Array]:
    """The columns of a table by name."""
    readable(path, "")
    by_point, by_node = (*"xyz"[:dim], "time"), ("node", "time")
    try:
        with path.open(encoding="utf-8-sig") as stream:
            names = [name.strip().strip('"').lower() for name in stream.readline().split(",")]
            wanted = by_node if "node" in names else by_point
            if missing := [name for name in wanted if name not in names]:
                raise InputError(
                    f"{path} has no column {', '.join(missing)} in its first line, only {', '.join(names)}; "
                    f"give {', '.join(by_point)}, or node, time"
                )
            text = stream.read()
            rows = np.loadtxt(io.StringIO(text), delimiter=",", ndmin=2) if text.strip() else np.zeros((0, 1))
    except (ValueError, OSError) as error:  # of UTF-8 and of numbers
        raise InputError(f"{path} is not a table of numbers: {' '.join(str(error).split())}") from error
    if not len(rows):
        raise InputError(f"{path} has no row")
    if rows.shape[1] != len(names):
        raise InputError(f"{path} has {len(names)} names and {rows.shape[1]} columns")
    table = {name: rows[:, names.index(name)] for name in wanted}
    bad = np.isnan(table["time"]) | (table["time"] < 0)
    for name in wanted[:-1]:
        bad |= ~np.isfinite(table[name])
    if wanted is by_node:
        bad |= (table["node"] < 0) | (table["node"] != np.floor(table["node"]))
    else:
        bad |= np.isinf(table["time"])
    if bad.any():
        what = "whole numbers" if wanted is by_node else "finite numbers"
        raise InputError(
            f"{path}: row {int(np.argmax(bad)) + 2} is {rows[np.argmax(bad)].tolist()}; give {what} "
            "and times from 0 on"
        )
    if wanted is by_node and len(np.unique(table["node"])) < len(rows):
        raise InputError(f"{path} has several times for one node")
    return table


def _by_number(body: Body, space: Any, table: dict[str, Array]) -> Array:
    """Times by the numbers of nodes in the mesh's file, NaN for those that have none (nodes,)."""
    geometry = body.mesh.geometry
    numbers = np.empty(len(space.tabulate_dof_coordinates()), dtype=np.int64)
    corners = geometry.dofmaps[0][:, : body.dim + 1]
    numbers[space.dofmap.list] = np.asarray(geometry.input_global_indices)[corners]
    order = np.argsort(table["node"])
    known = table["node"][order].astype(np.int64)
    place = np.minimum(np.searchsorted(known, numbers), len(known) - 1)
    return np.where(known[place] == numbers, table["time"][order][place], np.nan)


def _nearby(table: dict[str, Array], X: Array) -> tuple[Array, Array]:
    """Times (n,) at points X (n, dim) between those of a table, and the distance (n,) of the nearest."""
    from scipy.spatial import KDTree  # takes a tenth of a second, which others need not wait for

    points = np.column_stack([table[name] for name in "xyz"[: X.shape[1]]])
    count = min(NEIGHBOURS + 1, len(points))
    distance, which = KDTree(points).query(X, k=[*range(1, count + 1)])
    nearest = np.maximum(distance, 1e-9 * np.maximum(distance[:, -1:], 1e-300))
    weights = nearest**-2.0
    if count > NEIGHBOURS:
        # To nothing at the farthest: which of points at equal distances are taken does not matter then.
        weights *= np.maximum(1 - nearest / nearest[:, -1:], 1e-6) ** 2
    return (weights * table["time"][which]).sum(axis=1) / weights.sum(axis=1), distance[:, 0]


def spread(
    body: Body, space: Any, names: tuple[str, ...], roots: tuple[tuple[float, ...], ...], key: str
) -> Array:
    """Lengths of the shortest ways over a surface from the nearest of its roots (nodes,) (collective).

    A node off the surface has that of the nearest node on it. The lengths solve |∇d| = 1 on the surface, from
    triangle to triangle (the local solver of P. A. Gremaud, C. M. Kuster, SIAM J. Sci. Comput. 27 (2006)
    1803–1816, and Jacobi's iterations): exact where a front is plane, else of first order in the mesh.

    Args:
        body: The reference body, a solid.
        space: P1 space of the nodes.
        names: The parts of the boundary that make the surface.
        roots: Points, each of which is taken for that of the surface that is the nearest.
        key: Key of a case file, for messages.

    Raises:
        InputError: The body is not a solid, a root is far from the surface, or no way leads to some of it.
    """
    from scipy.spatial import KDTree

    if body.dim != 3:
        raise InputError("fronts run over surfaces of solids; elsewhere give a table of times", key)
    if any(len(root) != 3 for root in roots):
        raise InputError("give three coordinates for each root", key)
    X, triangles = _surface(body, space, names)
    low, high = range_of(X, body.comm)
    at, close = np.array(roots, dtype=float), FARTHEST * float(np.linalg.norm(high - low))
    distance, nearest = KDTree(X).query(at)
    if (distance > close).any():
        raise InputError(
            f"{at[np.argmax(distance)].tolist()} is {distance.max():.4g} away from {', '.join(names)}, "
            f"which is between {low.tolist()} and {high.tolist()}",
            key,
        )
    begun = np.full(len(X), np.inf)
    for root, node in zip(at, nearest, strict=True):  # straight within the triangles around a root
        around = np.unique(triangles[(triangles == node).any(axis=1)])
        offset = X[around] - root
        begun[around] = np.minimum(begun[around], np.linalg.norm(offset, axis=1))
    lengths = shortest_ways(X, triangles, begun)
    if not np.isfinite(lengths).all():
        lost = X[~np.isfinite(lengths)]
        raise InputError(
            f"no way over {', '.join(names)} leads from these roots to {len(lost)} of its nodes, such as "
            f"{lost[0].tolist()}: give a root on each separate piece",
            key,
        )
    _, which = KDTree(X).query(space.tabulate_dof_coordinates())
    return np.asarray(lengths[which])


def _surface(body: Body, space: Any, names: tuple[str, ...]) -> tuple[Array, Indices]:
    """Nodes (n, 3) and triangles (m, 3) of parts of the boundary, the same on all processes."""
    mesh, comm = body.mesh, lasting(body.comm)
    facets = body.boundary_facets(names)
    facets = facets[facets < mesh.topology.index_map(2).size_local]
    X = space.tabulate_dof_coordinates()
    dofs = fem.locate_dofs_topological(space, 2, facets[:0])  # makes the connectivities
    mesh.topology.create_connectivity(2, 3)
    mesh.topology.create_connectivity(3, 2)
    cells = mesh.topology.connectivity(2, 3)
    of_cell = mesh.topology.connectivity(3, 2).array.reshape(-1, 4)
    first = cells.array[cells.offsets[facets]]
    # The facet that is opposite to a corner has that corner's number.
    kept = of_cell[first] != facets[:, None]
    dofs = space.dofmap.list[first][kept].reshape(-1, 3)
    known = space.dofmap.index_map.local_to_global(dofs.reshape(-1).astype(np.int32))
    parts = comm.allgather((known, X[dofs.reshape(-1)]))
    numbers, places = (np.concatenate(column) for column in zip(*parts, strict=True))
    _, where, names_of = np.unique(numbers, return_index=True, return_inverse=True)
    return places[where], names_of.reshape(-1, 3)


def shortest_ways(X: Array, triangles: Indices, begun: Array) -> Array:
    """Lengths of the shortest ways over triangles (n,), infinite where none leads.

    Args:
        X: Corners (n, dim).
        triangles: Their numbers (m, 3).
        begun: Lengths to begin with (n,), infinite where none is known.
    """
    a, b, c = np.concatenate([np.roll(triangles, k, axis=1) for k in range(3)]).T
    side, arm = X[b] - X[a], X[c] - X[a]
    C, B, A = ((side * side).sum(axis=1), (side * arm).sum(axis=1), (arm * arm).sum(axis=1))
    D = np.maximum(A * C - B * B, 0.0)
    found = begun.copy()
    while True:
        begin, end = found[a], found[b]
        known = np.isfinite(begin) & np.isfinite(end)
        grow = np.where(known, end, 0.0) - np.where(known, begin, 0.0)
        # begin + s grow + |arm − s side| is least where its derivative by s vanishes, or at an end.
        inner = np.sqrt(D / np.maximum(C - grow**2, 1e-300))
        s = np.where(grow**2 < C, np.clip((B - grow * inner) / C, 0.0, 1.0), 0.0)
        through = np.where(
            known, begin + s * grow + np.sqrt(np.maximum(A - 2 * s * B + s * s * C, 0.0)), np.inf
        )
        along = np.minimum(begin + np.sqrt(A), end + np.sqrt(np.maximum(A - 2 * B + C, 0.0)))
        new = found.copy()
        np.minimum.at(new, c, np.minimum(through, along))
        new[np.isfinite(begun)] = begun[np.isfinite(begun)]
        settled = new >= found * (1 - 1e-12)
        if settled.all() and np.isfinite(new).sum() == np.isfinite(found).sum():
            return found
        found = new
