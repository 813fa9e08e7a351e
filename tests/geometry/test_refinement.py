"""A mesh that is nested in another: cells, names and fibres."""

import dataclasses

import myostrain as ms
from myostrain.engine import fem
from myostrain.geometry import Meshed, Microstructure, refined
from myostrain.geometry.body import Body

import numpy as np
import pytest
import ufl
from dolfinx import mesh as dmesh

LINE = ms.build(ms.geometry.Line(length=10.0, spacing=1.0))
SHEET = ms.build(ms.geometry.Ellipse(size=(3.0, 2.0), spacing=0.4), ms.UniformFibres(direction=(1.0, 1.0)))


def solid():
    """A box of tetrahedra of all shapes: nodes inside and out are moved at random."""
    body = ms.build(
        ms.geometry.Slab(size=(2.0, 1.0, 1.0), spacing=0.5),
        ms.UniformFibres(direction=(1.0, 1.0, 0.0), sheet=(0.0, 0.0, 1.0)),
    )
    body.mesh.geometry.x[:] += np.random.default_rng(1).uniform(-0.08, 0.08, body.mesh.geometry.x.shape)
    return body


SOLID = solid()
BODIES = {"line": LINE, "sheet": SHEET, "solid": SOLID}


def corners(body):
    """Coordinates of the cells' corners, (cells, corners, dim)."""
    return body.mesh.geometry.x[body.mesh.geometry.dofmaps[0]][..., : body.dim]


def sizes(body):
    """Volumes of the cells, but for a factor."""
    x = corners(body)
    return np.abs(np.linalg.det(x[:, 1:] - x[:, :1]))


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("name", BODIES)
def test_cells_lie_in_their_parents(name, levels):
    """Places and parents say where the corners are; children of equal size fill every parent."""
    body = BODIES[name]
    fine = refined(body, levels)
    shares = np.concatenate([1 - fine.places.sum(axis=2, keepdims=True), fine.places], axis=2)
    assert shares.min() >= 0
    np.testing.assert_allclose(shares @ corners(body)[fine.parents], corners(fine), atol=1e-13)
    children = 2 ** (body.dim * levels)
    assert (np.bincount(fine.parents, minlength=body.cells) == children).all()
    np.testing.assert_allclose(sizes(fine), sizes(body)[fine.parents] / children, rtol=1e-9)
    # A hole or an overlap would show as a surface inside.
    outside = [len(dmesh.exterior_facet_indices(b.mesh.topology)) for b in (body, fine) if not connect(b)]
    assert outside[1] == outside[0] * 2 ** ((body.dim - 1) * levels)


def connect(body):
    """Make the connectivity that facets of the surface are found by."""
    body.mesh.topology.create_connectivity(body.dim - 1, body.dim)


def test_the_shortest_diagonal_is_taken():
    """All three ways to divide a tetrahedron occur; the one taken is the shortest."""
    first, second = np.triu_indices(4, 1)
    x = corners(SOLID)
    middles = (x[:, first] + x[:, second]) / 2
    diagonals = np.linalg.norm(middles[:, :3] - middles[:, :2:-1], axis=2)  # of opposite edges
    assert set(diagonals.argmin(axis=1)) == {0, 1, 2}
    fine = refined(SOLID, 1)
    y = corners(fine)
    centres = x.mean(axis=1)[fine.parents]  # where the diagonals cross
    edges = (y[:, first] + y[:, second]) / 2
    taken = np.linalg.norm(edges - centres[:, None], axis=2) < 1e-9
    assert (taken.sum(axis=1).reshape(-1) <= 1).all()
    cell, edge = np.nonzero(taken)
    lengths = np.linalg.norm(y[cell, first[edge]] - y[cell, second[edge]], axis=1)
    assert (np.bincount(fine.parents[cell]) == 4).all()
    np.testing.assert_allclose(lengths, diagonals.min(axis=1)[fine.parents[cell]], rtol=1e-12)


def integral(body, name):
    """Size of a named part of the boundary."""
    return fem.assemble_scalar(fem.form(fem.Constant(body.mesh, 1.0) * body.boundary_measure([name], 1)))


@pytest.mark.parametrize("name", BODIES)
def test_boundaries_keep_their_names(name):
    """Each part is as large as it was."""
    body = BODIES[name]
    fine = refined(body, 2)
    assert fine.meshed.boundaries == body.meshed.boundaries
    for part in body.meshed.boundaries:
        assert integral(fine, part) == pytest.approx(integral(body, part), rel=1e-12)


@pytest.mark.parametrize("name", BODIES)
def test_regions_and_their_fibres_are_inherited(name):
    """A cell is in its parent's region, and has the fibre that was given for it."""
    whole = BODIES[name]
    dim, cells = whole.dim, np.arange(whole.cells, dtype=np.int32)
    tags = dmesh.meshtags(whole.mesh, dim, cells[::2], np.full(len(cells[::2]), 7, dtype=np.int32))
    meshed = dataclasses.replace(whole.meshed, cell_tags=tags, regions={"scar": 7})
    other = tuple(float(i == dim - 1) for i in range(dim))
    fibres = ms.UniformFibres(direction=(1.0,) * dim, regions={"scar": other})
    fine = refined(Body(meshed, fibres.directions_on(meshed)), 1)
    found = np.sort(fine.meshed.cell_tags.find(7))
    np.testing.assert_array_equal(found, np.flatnonzero(fine.parents % 2 == 0))
    f0 = fine.f0.x.array.reshape(-1, dim)
    np.testing.assert_allclose(f0[found], np.broadcast_to(other, (len(found), dim)), atol=1e-15)
    rest = np.setdiff1d(np.arange(fine.cells), found)
    np.testing.assert_allclose(f0[rest], dim**-0.5, atol=1e-15)


def test_fibres_that_turn():
    """Any UFL direction is taken at the new cells' own centres, and the three stay orthonormal."""
    X = ufl.SpatialCoordinate(SOLID.mesh)
    turn = 0.7 * X[0] + 0.3 * X[1]
    f0 = ufl.as_vector([ufl.cos(turn), ufl.sin(turn), 0])
    s0 = ufl.as_vector([-ufl.sin(turn), ufl.cos(turn), 0])
    n0 = ufl.as_vector([0.0 * X[0], 0.0, 1.0])
    fine = refined(Body(SOLID.meshed, Microstructure(f0, s0, n0)), 1)
    x = corners(fine).mean(axis=1)
    angle = 0.7 * x[:, 0] + 0.3 * x[:, 1]
    exact = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    found = [d.x.array.reshape(-1, 3) for d in (fine.f0, fine.fibres.s0, fine.fibres.n0)]
    # Cells are half a unit wide: the parent's centre would be 0.08 off.
    assert np.abs(found[0] - exact).max() < 3e-3
    gram = np.einsum("icd,jcd->cij", found, found)
    np.testing.assert_allclose(gram, np.broadcast_to(np.eye(3), gram.shape), atol=1e-12)


def test_none_is_the_body_itself():
    """Nothing is copied for no refinement."""
    assert refined(SHEET, 0) is SHEET


@pytest.mark.parametrize("levels", [-1, 1.0, True, "one", 40, 10**12])
def test_refused(levels):
    """What is no whole number, or more than any memory holds."""
    with pytest.raises(ms.InputError) as refused:
        refined(LINE, levels)
    assert refused.value.key == "potential.refinement"


def test_a_mesh_without_names():
    """Tags are nothing that a mesh must have."""
    bare = Meshed(SHEET.mesh, None, {}, None, {})
    fine = refined(Body(bare, SHEET.fibres), 1)
    assert fine.meshed.facet_tags is None
    assert fine.meshed.cell_tags is None
