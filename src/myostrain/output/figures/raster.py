"""Triangles as pixels: what a film needs many times over, several times as fast as Matplotlib fills them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


def interpolated(
    points: Array, triangles: Indices, values: Array, width: int, height: int
) -> tuple[Indices, Array]:
    """Pixels whose middle is in a triangle, and the nodal values there, linear in each triangle.

    A pixel is taken once where triangles share an edge; where they overlap, the last one counts.

    Args:
        points: Nodes (n, 2) in pixels, from the left and from the top.
        triangles: Node numbers (m, 3).
        values: At the nodes, (n,).
        width: Of the picture, in pixels.
        height: Of the picture.

    Returns:
        Numbers of the pixels, row by row from the top, and their values.
    """
    # Corners from top to bottom, so that an edge is computed alike for both of its triangles.
    corners = np.take_along_axis(triangles, np.argsort(points[triangles, 1], axis=1, kind="stable"), axis=1)
    (x0, x1, x2), (y0, y1, y2) = points[corners, 0].T, points[corners, 1].T
    first = np.clip(np.ceil(y0 - 0.5), 0, height).astype(np.int64)
    count = np.clip(np.ceil(y2 - 0.5), 0, height).astype(np.int64) - first
    of = np.repeat(np.arange(len(corners)), count)
    row = _counted(first, count)
    y: Any = row + 0.5
    # A row crosses the long edge, from top to bottom, and one of the two others.
    upper = y < y1[of]
    long = _crossing(y, x0[of], y0[of], x2[of], y2[of])
    short = _crossing(
        y,
        np.where(upper, x0[of], x1[of]),
        np.where(upper, y0[of], y1[of]),
        np.where(upper, x1[of], x2[of]),
        np.where(upper, y1[of], y2[of]),
    )
    left = np.clip(np.ceil(np.minimum(long, short) - 0.5), 0, width).astype(np.int64)
    size = np.clip(np.ceil(np.maximum(long, short) - 0.5), 0, width).astype(np.int64) - left
    column = _counted(left, size)
    v0, v1, v2 = values[corners].T
    twice = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
    with np.errstate(divide="ignore", invalid="ignore"):  # of triangles without area, which have no pixels
        along_x = ((v1 - v0) * (y2 - y0) - (v2 - v0) * (y1 - y0)) / twice
        along_y = ((v2 - v0) * (x1 - x0) - (v1 - v0) * (x2 - x0)) / twice
        start = (v0 + (0.5 - x0) * along_x - y0 * along_y)[of] + y * along_y[of]
        found = np.repeat(start, size) + column * np.repeat(along_x[of], size)
    return np.repeat(row * width, size) + column, found


def _counted(first: Indices, count: Indices) -> Indices:
    """first[0], first[0] + 1, ..., so many of each, one after the other."""
    before = np.cumsum(count) - count
    return np.arange(count.sum()) + np.repeat(first - before, count)


def _crossing(y: Any, x0: Any, y0: Any, x1: Any, y1: Any) -> Any:
    """x where edges from (x0, y0) down to (x1, y1) cross heights y; an end where they are level."""
    rise = y1 - y0
    share = np.divide(y - y0, rise, out=np.zeros_like(rise), where=rise > 0)
    return x0 + share * (x1 - x0)
