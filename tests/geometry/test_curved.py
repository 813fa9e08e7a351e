"""Ventricles of curved cells: what they keep of the body, and that places in them are found."""

from myostrain.engine import MPI, fem
from myostrain.errors import InputError
from myostrain.geometry import Ventricle, build
from myostrain.geometry.corners import corners
from myostrain.geometry.ellipsoidal_fibres import EllipsoidalFibres
from myostrain.geometry.laplace_fibres import RuleBasedFibres
from myostrain.geometry.points import cells_at
from myostrain.geometry.refinement import refined
from myostrain.mechanics.normals import smooth_normal
from myostrain.mechanics.quadrature import QuadraturePoints

import basix
import numpy as np
import pytest
import ufl
from dolfinx import mesh as dmesh


@pytest.fixture(scope="module")
def body():
    """A coarse ventricle of curved cells."""
    return build(Ventricle(spacing=4.0, layers=1, order=2), EllipsoidalFibres(), MPI.COMM_SELF)


def volume(body):
    """Volume of the mesh."""
    return float(QuadraturePoints(body.mesh, 4).weights.sum())


def test_volume_and_surfaces(body):
    """Ventricle, order: nodes of edges lie on the surfaces; the volume errs 50 times less than that of
    straight cells (measured: 3.4e-4 for 2.2e-2)."""
    shape = Ventricle(spacing=4.0, layers=1)
    straight = build(shape, EllipsoidalFibres(), MPI.COMM_SELF)
    assert straight.cells == body.cells
    errors = [abs(volume(b) / shape.volume - 1) for b in (straight, body)]
    assert errors[0] > 1e-2
    assert errors[1] < errors[0] / 30
    for name, t in (("endocardium", 0.0), ("epicardium", 1.0)):
        space = fem.functionspace(body.mesh, ("Lagrange", 2))
        dofs = fem.locate_dofs_topological(space, 2, body.boundary_facets([name]))
        places = space.tabulate_dof_coordinates()[dofs]
        np.testing.assert_allclose(shape.at_depth(t).level(places), 1.0, atol=1e-6)


def test_places_in_curved_cells(body):
    """cells_at: the barycentric coordinates are those of the reference cell, to round-off."""
    rng = np.random.default_rng(1)
    weights = rng.dirichlet(np.ones(4), size=20)
    chosen = rng.integers(0, body.cells, size=20)
    element = basix.create_element(
        basix.ElementFamily.P, basix.CellType.tetrahedron, 2, basix.LagrangeVariant.equispaced
    )
    values = element.tabulate(0, weights[:, 1:])[0, :, :, 0]
    points = np.einsum("pk,pkd->pd", values, body.mesh.geometry.x[body.mesh.geometry.dofmaps[0][chosen]])
    which, cells, found = cells_at(body.mesh, points)
    at = [np.flatnonzero((which == i) & (cells == chosen[i])) for i in range(20)]
    assert all(len(places) == 1 for places in at)
    np.testing.assert_allclose(found[np.concatenate(at)], weights, atol=1e-9)
    straight = np.einsum("pk,pkd->pd", weights, corners(body.mesh)[chosen])
    assert np.abs(points - straight).max() > 0.05


def test_refined_cells_have_their_corners_on_the_surfaces(body):
    """refined, docstring: the finer mesh takes the curved cells' nodes; it is closer to the body."""
    fine = refined(body, 1)
    assert fine.cells == 8 * body.cells
    found = [abs(volume(b) / Ventricle().volume - 1) for b in (body, fine)]
    assert found[1] < 1e-2
    places = np.concatenate([fine.mesh.geometry.x[fine.mesh.geometry.dofmaps[0]].reshape(-1, 3)])
    own = body.mesh.geometry.x
    np.testing.assert_allclose(np.unique(places, axis=0), np.unique(own, axis=0), atol=1e-12)


def test_normals_and_rules(body):
    """The smooth normal is that of the ellipsoid, to 0.03 in the mean on a coarse mesh; rules take curved
    cells."""
    normal = smooth_normal(body, ["epicardium"])
    a, c = 10.0, 20.0
    x, y, z = ufl.SpatialCoordinate(body.mesh)
    exact = ufl.as_vector([x / a**2, y / a**2, z / c**2])
    exact /= ufl.sqrt(ufl.dot(exact, exact))
    ds = body.boundary_measure(["epicardium"], 4)
    error = fem.assemble_scalar(fem.form(ufl.inner(normal - exact, normal - exact) * ds))
    area = fem.assemble_scalar(fem.form(fem.Constant(body.mesh, 1.0) * ds))
    assert np.sqrt(error / area) < 0.03
    rules = build(
        Ventricle(spacing=4.0, layers=2, order=2), RuleBasedFibres(helix=(60.0, -60.0)), MPI.COMM_SELF
    )
    along = QuadraturePoints(rules.mesh, 2).values(ufl.dot(rules.f0, rules.f0))()
    np.testing.assert_allclose(along, 1.0, atol=1e-12)


def test_a_wrong_order_is_refused():
    """Ventricle, order: 1 or 2."""
    with pytest.raises(InputError, match="order"):
        Ventricle(order=3)


def test_depth_by_laplace():
    """EllipsoidalFibres, depth_by: around the equator the harmonic depth is about that of a cylinder,
    ln(r/7)/ln(10/7), which at the middle of the wall is 0.044 more than that of the ellipsoids."""
    fibres = EllipsoidalFibres(helix=(60.0, -60.0), depth_by="laplace")
    body = build(Ventricle(spacing=3.0, layers=2, order=2), fibres, MPI.COMM_SELF)
    points = QuadraturePoints(body.mesh, 2)
    x = points.values(ufl.SpatialCoordinate(body.mesh))().reshape(-1, 3)
    f = points.values(body.f0)().reshape(-1, 3)
    r = np.hypot(x[:, 0], x[:, 1])
    around = np.stack([-x[:, 1], x[:, 0], 0 * r], axis=1) / r[:, None]
    near = (np.abs(x[:, 2]) < 2) & (r > 8.2) & (r < 8.8)
    angle = np.degrees(np.arctan2(f[:, 2], (f * around).sum(axis=1)))
    depth = (60 - angle[near]) / 120
    cylinder = np.log(r[near] / 7) / np.log(10 / 7)
    assert near.sum() > 20
    assert np.mean(depth - cylinder) == pytest.approx(0, abs=0.02)  # measured 0.014
    assert np.mean(depth - (r[near] - 7) / 3) == pytest.approx(0.058, abs=0.01)


def test_narrow_cells_at_the_apex():
    """Ventricle, apex_ratio and apex_reach: edges are as long as asked for at the apex and above the reach,
    and counts() is about what gmsh makes."""
    shape = Ventricle(spacing=3.0, layers=1, apex_ratio=0.3, apex_reach=10.0)
    meshed = shape.mesh(MPI.COMM_SELF)
    facets = meshed.facets(["epicardium"], "geometry")
    corners = meshed.mesh.geometry.x[dmesh.entities_to_geometry(meshed.mesh, 2, facets)]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean(axis=1)
    height = corners[:, :, 2].mean(axis=1) + 20
    assert edges[height < 1].mean() == pytest.approx(0.9, rel=0.3)
    assert edges[height > 12].mean() == pytest.approx(3.0, rel=0.15)
    plain = Ventricle(spacing=3.0, layers=1).counts()[1]
    assert shape.counts()[1] > 1.5 * plain
