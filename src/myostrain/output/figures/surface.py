"""What is seen of a solid: its boundary, also of a body cut open, found once for all frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

#: Corners of a tetrahedron's sides, each numbered as the corner that it has not.
SIDES = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])
#: A body that fills less of the box around it is hollow (ventricles about 0.3; a full ellipsoid 0.52).
HOLLOW = 0.45


@dataclass(frozen=True)
class Surface:
    """Triangles whose corners are nodes, or places on the edges between two nodes.

    Attributes:
        first: Node before each corner, (p,).
        second: Node after it, (p,); the same one where the corner is a node.
        share: How far it is from the one to the other, 0 to 1, (p,).
        triangles: Numbers of the corners, (k, 3).
        cell: The tetrahedron behind each triangle, (k,).
    """

    first: Indices
    second: Indices
    share: Array
    triangles: Indices
    cell: Indices

    def at(self, values: Array) -> Array:
        """Values (p,) or (p, dim) at the corners of nodal values (n,) or (n, dim), linear along the edges."""
        share = self.share.reshape(-1, *[1] * (values.ndim - 1))
        return (1 - share) * values[self.first] + share * values[self.second]


def boundary_triangles(points: Array, cells: Indices) -> tuple[Indices, Indices]:
    """Sides of tetrahedra that belong to one of them only.

    Args:
        points: Nodes (n, 3).
        cells: Node numbers (m, 4).

    Returns:
        Node numbers (k, 3) of the triangles, anticlockwise from outside, and the tetrahedron of each, (k,).
    """
    sides = cells[:, SIDES].reshape(-1, 3)
    ordered = np.sort(sides, axis=1)
    order = np.lexsort(ordered.T)
    same = (ordered[order[1:]] == ordered[order[:-1]]).all(axis=1)
    single = order[~(np.r_[same, False] | np.r_[False, same])]
    single.sort()
    triangles, cell = sides[single], single // 4
    return _outward(triangles, points[triangles], points[cells[cell]].mean(axis=1)), cell


def boundary(points: Array, cells: Indices) -> Surface:
    """The whole boundary of a body of tetrahedra (m, 4) between nodes (n, 3)."""
    triangles, cell = boundary_triangles(points, cells)
    return _joined([np.stack([triangles, triangles], axis=2)], [cell], np.zeros(len(points)))


def cut_open(points: Array, cells: Indices, height: Array) -> Surface:
    """The boundary of the part of a body where a nodal height is not negative, linear in each tetrahedron.

    Args:
        points: Nodes (n, 3).
        cells: Node numbers (m, 4).
        height: Say the distance from a plane, (n,).
    """
    triangles, cell = boundary_triangles(points, cells)
    kept = height >= 0
    parts, owners = _clipped(triangles, cell, kept)
    for count in (1, 2, 3):
        chosen = np.flatnonzero(kept[cells].sum(axis=1) == count)
        # The corners on one side first, the alone one or two of them.
        alone = kept[cells[chosen]] == (count < 3)
        corner = np.take_along_axis(cells[chosen], np.argsort(~alone, axis=1, kind="stable"), axis=1)
        a, b, c, d = corner.T
        one = [[(a, b), (a, c), (a, d)]]
        two = [[(a, c), (a, d), (b, d)], [(a, c), (b, d), (b, c)]]
        beyond = (~kept[cells[chosen]][:, :, None] * points[cells[chosen]]).sum(axis=1) / (4 - count)
        for edges in two if count == 2 else one:
            pairs = np.stack([np.stack(pair, axis=1) for pair in edges], axis=1)
            places = _places(pairs, points, height)
            parts.append(_outward(pairs, places, 2 * places.mean(axis=1) - beyond))
            owners.append(chosen)
    return _joined(parts, owners, height)


def _clipped(
    triangles: Indices, cell: Indices, kept: npt.NDArray[np.bool_]
) -> tuple[list[Indices], list[Indices]]:
    """What is left of triangles: corners as pairs of nodes (k, 3, 2), and their tetrahedra."""
    count = kept[triangles].sum(axis=1)
    whole = count == 3
    parts, owners = [np.stack([triangles[whole], triangles[whole]], axis=2)], [cell[whole]]
    for number in (1, 2):
        some, of = triangles[count == number], cell[count == number]
        alone = (kept[some] == (number == 1)).argmax(axis=1)
        a, b, c = np.take_along_axis(some, (alone[:, None] + np.arange(3)) % 3, axis=1).T
        cut = (
            [[(a, a), (a, b), (a, c)]]
            if number == 1
            else [[(a, b), (b, b), (c, c)], [(a, b), (c, c), (a, c)]]
        )
        for corners in cut:
            parts.append(np.stack([np.stack(pair, axis=1) for pair in corners], axis=1))
            owners.append(of)
    return parts, owners


def _outward(corners: Indices, places: Array, inside: Array) -> Indices:
    """Triangles (k, 3) or (k, 3, 2) turned so that ``inside`` (k, 3) is behind them."""
    normal = np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0])
    wrong = (normal * (places.mean(axis=1) - inside)).sum(axis=1) < 0
    turned = corners.copy()
    turned[wrong] = corners[wrong][:, ::-1]
    return turned


def _shares(first: Indices, second: Indices, height: Array) -> Array:
    """How far it is from a node to where the height is zero, as part of the way to another node."""
    rise = height[first] - height[second]
    return np.divide(height[first], rise, out=np.zeros(rise.shape), where=rise != 0)


def _places(pairs: Indices, points: Array, height: Array) -> Array:
    first, second = pairs[..., 0], pairs[..., 1]
    share = _shares(first, second, height)[..., None]
    return (1 - share) * points[first] + share * points[second]


def _joined(parts: list[Indices], owners: list[Indices], height: Array) -> Surface:
    """A surface of triangles whose corners are pairs of nodes, (k, 3, 2): zero height between them."""
    pairs = np.sort(np.concatenate(parts).astype(np.int64), axis=2)
    n = len(height)
    unique, number = np.unique(pairs[..., 0] * n + pairs[..., 1], return_inverse=True)
    first, second = np.divmod(unique, n)
    return Surface(
        first, second, _shares(first, second, height), number.reshape(-1, 3), np.concatenate(owners)
    )


def hollow(points: Array, cells: Indices) -> bool:
    """Whether a body has a cavity or the like: it fills little of the box around it, however it is turned.

    Args:
        points: Nodes (n, 3).
        cells: Node numbers (m, 4).
    """
    corners = points[cells]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    centres = corners.mean(axis=1)
    centres -= np.average(centres, axis=0, weights=volumes)
    axes = np.linalg.eigh((centres * volumes[:, None]).T @ centres)[1]
    return bool(volumes.sum() < HOLLOW * np.prod(np.ptp(points @ axes, axis=0)))
