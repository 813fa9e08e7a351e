"""Triangles as pixels, for films."""

from myostrain.output.figures.raster import interpolated

import numpy as np
import pytest
from matplotlib.tri import Triangulation

WIDTH, HEIGHT = 40, 30


def middles():
    y, x = np.divmod(np.arange(WIDTH * HEIGHT), WIDTH)
    return np.column_stack([x, y]) + 0.5


@pytest.fixture
def mesh():
    """Triangles of all sizes and shapes over more than the picture, the finest far below a pixel."""
    random = np.random.default_rng(3)
    box = np.array([[-9.0, -7.0], [55.0, -5.0], [60.0, 44.0], [-5.0, 41.0]])
    points = np.concatenate([box, random.uniform(-3, 43, (300, 2)), random.normal(15, 0.2, (200, 2))])
    triangles = Triangulation(*points.T).triangles
    turned = random.permuted(triangles, axis=1)  # either way round
    return points, turned.astype(np.int64)


def test_every_pixel_of_a_closed_mesh_once_with_the_linear_value(mesh):
    """Neither holes nor overlaps where triangles meet, to the last pixel."""
    points, triangles = mesh
    values = 3.0 + points @ [0.7, -1.3]
    pixels, found = interpolated(points, triangles, values, WIDTH, HEIGHT)
    assert np.array_equal(np.sort(pixels), np.arange(WIDTH * HEIGHT))
    np.testing.assert_allclose(found, 3.0 + middles()[pixels] @ [0.7, -1.3], atol=1e-8)


def test_the_value_is_that_of_the_triangle_a_pixel_is_in(mesh):
    """Against Matplotlib's own search, for values that are linear in no larger part than a triangle."""
    points, triangles = mesh
    values = np.random.default_rng(4).normal(size=len(points))
    pixels, found = interpolated(points, triangles, values, WIDTH, HEIGHT)
    where = middles()[pixels]
    finder = Triangulation(*points.T, triangles).get_trifinder()
    corners = triangles[finder(*where.T)]
    edges = points[corners[:, 1:]] - points[corners[:, :1]]
    share = np.linalg.solve(edges.transpose(0, 2, 1), (where - points[corners[:, 0]])[..., None])[..., 0]
    expected = values[corners[:, 0]] + (share * (values[corners[:, 1:]] - values[corners[:, :1]])).sum(axis=1)
    # Next to an edge either side's triangle will do: both have the same value there.
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_what_is_outside_or_has_no_area_gives_no_pixel():
    points = np.array([[5.0, 5.0], [9.0, 5.0], [13.0, 5.0], [-9.0, -9.0], [-5.0, -9.0], [-5.0, -4.0]])
    pixels, values = interpolated(points, np.array([[0, 1, 2], [3, 4, 5], [0, 0, 1]]), points[:, 0], 40, 30)
    assert len(pixels) == len(values) == 0


def test_a_triangle_that_reaches_beyond_the_picture_is_cut_off():
    points = np.array([[-100.0, -100.0], [200.0, -100.0], [-100.0, 200.0]])
    pixels, values = interpolated(points, np.array([[0, 1, 2]]), points[:, 1], WIDTH, HEIGHT)
    assert np.array_equal(np.sort(pixels), np.arange(WIDTH * HEIGHT))
    np.testing.assert_allclose(values, middles()[pixels, 1])
