"""Places: a ball, a box, parts of the boundary, regions; initial values in them."""

import myostrain as ms
from myostrain.engine import fem
from myostrain.geometry import Body, Meshed

import numpy as np
import pytest
from dolfinx import mesh as dmesh

from coupled import coordinates

SIZE = (8.0, 4.0)


def rectangle(spacing=1.0):
    shape = ms.geometry.Rectangle(size=SIZE, spacing=spacing)
    return ms.build(shape, ms.UniformFibres(direction=(1.0, 0.0)))


def slab():
    shape = ms.geometry.Slab(size=(4.0, 3.0, 2.0), spacing=1.0)
    return ms.build(shape, ms.UniformFibres(direction=(1.0, 0.0, 0.0)))


def share(body, key="here", **place):
    """What the place has of each node, and the nodes (n, dim)."""
    space = fem.functionspace(body.mesh, ("Lagrange", 1))
    return ms.Place(**place).share(body, space, key), space.tabulate_dof_coordinates()[:, : body.dim]


def with_regions(body, regions):
    """The body with cells tagged by a function of their midpoints."""
    mesh, dim = body.mesh, body.dim
    cells = np.arange(mesh.topology.index_map(dim).size_local, dtype=np.int32)
    values = regions(dmesh.compute_midpoints(mesh, dim, cells)).astype(np.int32)
    tags = dmesh.meshtags(mesh, dim, cells, values)
    meshed = body.meshed
    return Body(Meshed(mesh, meshed.facet_tags, meshed.boundaries, tags, {"a": 1, "b": 2}), body.fibres)


def test_a_ball():
    """The nodes within the radius of the centre, those on it too, in whatever dimension."""
    for body, center in ((rectangle(), (2.0, 1.0)), (slab(), (1.0, 1.0, 1.0))):
        found, X = share(body, center=center, radius=2.0)
        inside = np.linalg.norm(X - center, axis=1) <= 2.0 + 1e-12
        assert 0 < inside.sum() < len(X)
        np.testing.assert_array_equal(found, inside)


def test_coordinates_that_the_body_has_not_are_left_out():
    """Place: "at least as many as the body has dimensions; more are zero"."""
    found, X = share(rectangle(), center=(2.0, 1.0, 0.0), radius=1.5)
    np.testing.assert_array_equal(found, np.linalg.norm(X - (2.0, 1.0), axis=1) <= 1.5)


def test_a_box():
    """The nodes between two corners, those on its sides too."""
    found, X = share(rectangle(), box=((1.0, 0.5), (3.0, 2.0)))
    inside = (X >= (1.0, 0.5)).all(axis=1) & (X <= (3.0, 2.0)).all(axis=1)
    assert inside.sum() == 3 * 2
    np.testing.assert_array_equal(found, inside)


def test_a_part_of_the_boundary():
    """With depth 0 the nodes on the parts only, in one, two and three dimensions."""
    found, X = share(rectangle(), boundary=("left", "top"))
    np.testing.assert_array_equal(found, np.isclose(X[:, 0], 0) | np.isclose(X[:, 1], SIZE[1]))
    found, X = share(slab(), boundary=("bottom",))
    np.testing.assert_array_equal(found, np.isclose(X[:, 2], 0))
    line = ms.build(ms.geometry.Line(length=5.0))
    found, X = share(line, boundary=("right",))
    np.testing.assert_array_equal(found, np.isclose(X[:, 0], 5.0))


def test_a_layer_of_some_depth():
    """The nodes no further from the parts than the depth; at a corner the nearest part counts."""
    body = rectangle(spacing=0.5)
    found, X = share(body, boundary=("left", "top"), depth=1.5)
    distance = np.minimum(X[:, 0], SIZE[1] - X[:, 1])
    np.testing.assert_array_equal(found, distance <= 1.5 + 1e-9)
    # From one end of the bottom: the corner of a part is round.
    found, X = share(slab(), boundary=("front",), depth=1.0)
    np.testing.assert_array_equal(found, X[:, 1] <= 1.0 + 1e-9)
    line = ms.build(ms.geometry.Line(length=5.0))
    found, X = share(line, boundary=("left", "right"), depth=1.0)
    np.testing.assert_array_equal(found, (X[:, 0] <= 1.0 + 1e-9) | (X[:, 0] >= 4.0 - 1e-9))


def test_a_layer_keeps_its_depth_on_another_mesh():
    """With a depth the layer is that of the body, not of the cells: its mass tends to area times depth."""
    for spacing, within in ((0.5, 0.13), (0.25, 0.07)):
        body = rectangle(spacing)
        potential = ms.Potential(body, membrane=ms.membranes.FitzHughNagumo(A=0.0))
        found, _ = share(body, boundary=("left",), depth=2.0)
        assert np.sum(potential.weight * found) == pytest.approx(2.0 * SIZE[1], rel=within)


def test_a_region():
    """The nodes of the cells of named regions."""
    body = with_regions(rectangle(), lambda x: np.where(x[:, 0] < 3.0, 1, 2))
    found, X = share(body, region=("a",))
    np.testing.assert_array_equal(found, X[:, 0] <= 3.0 + 1e-9)
    found, _ = share(body, region=("a", "b"))
    assert found.all()


@pytest.mark.parametrize(
    "place, volume",
    [
        (dict(center=(4.1, 2.05), radius=1.2), np.pi * 1.2**2),
        (dict(box=((1.3, 0.4), (3.7, 2.6))), 2.4 * 2.2),
    ],
    ids=["ball", "box"],
)
def test_the_mean_around_a_node_keeps_the_integral(place, volume):
    """Sampling "mean": the share's integral is the place's volume on any mesh; that of "nodal" is not.

    The jump is integrated by points: measured 3e-3 at most.
    """
    off = []
    for spacing in (1.0, 0.5):
        body = rectangle(spacing)
        weight = ms.Potential(body, membrane=ms.membranes.FitzHughNagumo(A=0.0)).weight
        mean, _ = share(body, **place, sampling="mean")
        assert np.sum(weight * mean) == pytest.approx(volume, rel=1e-2)
        assert mean.min() >= 0
        assert mean.max() <= 1 + 1e-12
        assert ((mean > 0.01) & (mean < 0.99)).any()
        nodal, _ = share(body, **place)
        off.append(abs(np.sum(weight * nodal) / volume - 1))
    assert max(off) > 0.03


WRONG_DESCRIPTIONS = [
    (dict(), "give one of center and radius, box, boundary, region"),
    (dict(center=(0.0,), radius=1.0, boundary=("left",)), "not center and radius and boundary"),
    (dict(center=(0.0,)), "a ball takes center and radius"),
    (dict(radius=1.0), "a ball takes center and radius"),
    (dict(center=(0.0,), radius=-1.0), "radius"),
    (dict(box=((0.0, 0.0), (1.0,))), "as many coordinates each"),
    (dict(box=((0.0, 1.0), (1.0, 0.0))), "lowest corner"),
    (dict(center=(0.0,), radius=1.0, depth=1.0), "depth goes with boundary"),
    (dict(boundary=("left",), sampling="mean"), "for a ball or a box"),
]


@pytest.mark.parametrize("place, message", WRONG_DESCRIPTIONS)
def test_what_is_no_place(place, message):
    """Place refuses what is none, or several."""
    with pytest.raises(ValueError, match=message):
        ms.Place(**place)


WRONG_HERE = [
    (dict(center=(20.0, 1.0), radius=2.0), "here.radius", r"no node .*nearest is 10 outside.*\[8\.0, 4\.0\]"),
    (dict(box=((9.0, 0.0), (10.0, 1.0))), "here.box", "nearest is 1 outside"),
    (dict(center=(1.0,), radius=2.0), "here.center", "give 2 coordinates"),
    (dict(box=((0.0,), (1.0,))), "here.box", "give 2 coordinates"),
    (dict(center=(1.0, 1.0, 5.0), radius=2.0), "here.center", r"\[1\.0, 1\.0, 5\.0\]: give 2 coordinates"),
    (dict(box=((0.0, 0.0, 1.0), (1.0, 1.0, 2.0))), "here.box", "give 2 coordinates"),
    (dict(boundary=("lft",)), "here.boundary", "did you mean 'left'"),
    (dict(region=("a",)), "here.region", "no named regions"),
]


@pytest.mark.parametrize("place, key, message", WRONG_HERE)
def test_what_is_no_place_of_this_body(place, key, message):
    """InputError names the key, and what the body has."""
    with pytest.raises(ms.InputError, match=message) as caught:
        share(rectangle(), **place)
    assert caught.value.key == key


def test_an_unknown_region_of_several():
    """The names there are."""
    body = with_regions(rectangle(), lambda x: np.where(x[:, 0] < 3.0, 1, 2))
    with pytest.raises(ms.InputError, match=r"no region is called 'c'.*a, b"):
        share(body, region=("c",))


# Initial values.


def begun(*initial, membrane=None):
    potential = ms.Potential(
        rectangle(), membrane=membrane or ms.membranes.FitzHughNagumo(), initial=list(initial)
    )
    return *potential.field_values().values(), coordinates(potential)


def test_initial_values_of_potential_and_states():
    """Potential: "It begins at the membrane's rest, with ``initial`` written over it", later ones win."""
    left, right = ms.Place(boundary=("left",), depth=3.0), ms.Place(box=((2.0, 0.0), (8.0, 4.0)))
    v, w, X = begun(
        ms.InitialValues(where=left, potential=0.8),
        ms.InitialValues(where=right, potential=0.3, states={"recovery": 0.1}),
    )
    np.testing.assert_array_equal(v, np.where(X[:, 0] >= 2.0 - 1e-9, 0.3, 0.8))
    np.testing.assert_array_equal(w, np.where(X[:, 0] >= 2.0 - 1e-9, 0.1, 0.0))
    v, w, X = begun(ms.InitialValues(where=left, states={"recovery": 0.2}))
    assert not v.any()
    np.testing.assert_array_equal(w, np.where(X[:, 0] <= 3.0 + 1e-9, 0.2, 0.0))


def test_initial_values_take_their_share():
    """With the mean around a node it takes as much of the value as of the place."""
    place = dict(center=(4.0, 2.0), radius=1.5, sampling="mean")
    v, _, _ = begun(ms.InitialValues(where=ms.Place(**place), potential=0.8))
    found, _ = share(rectangle(), **place)
    np.testing.assert_allclose(v, 0.8 * found, rtol=1e-14)


def test_wrong_initial_values():
    """Messages: nothing given; an unknown state; a place where no node is, with the section's name."""
    place = ms.Place(boundary=("left",))
    with pytest.raises(ValueError, match="give potential, or states"):
        ms.InitialValues(where=place)
    with pytest.raises(ms.InputError, match=r"initial\.states: 'recvery' is not a state.*'recovery'"):
        begun(ms.InitialValues(where=place, states={"recvery": 0.1}))
    with pytest.raises(ms.InputError, match="this membrane has no states"):
        begun(
            ms.InitialValues(where=place, states={"recovery": 0.1}),
            membrane=ms.membranes.FitzHughNagumo(recovery=False),
        )
    with pytest.raises(ms.InputError, match=r"initial\.radius: no node"):
        begun(ms.InitialValues(where=ms.Place(center=(99.0, 0.0), radius=1.0), potential=0.9))
