"""Probes, activation times and the numbers of a pulse, on analytic fields."""

import itertools

import myostrain as ms
from myostrain import InputError
from myostrain.engine import fem
from myostrain.geometry import Ellipse, Line, Rectangle, UniformFibres
from myostrain.output.beats import Activations
from myostrain.output.metrics import LEVEL, leading_pulse
from myostrain.output.probes import ActivationTimes, Probes

import numpy as np
import pytest

from small_cases import ALONE

BODIES = {
    "line": Line(length=7.0, spacing=0.7),
    "rectangle": Rectangle(size=(7.0, 5.0), spacing=0.7),
    "ellipse": Ellipse(size=(7.0, 5.0), spacing=0.7, distortion=0.3),
}


@pytest.fixture(params=BODIES)
def space(request):
    shape = BODIES[request.param]
    fibres = None if request.param == "line" else UniformFibres(direction=(1.0, 0.0))
    return fem.functionspace(ms.build(shape, fibres, ALONE).mesh, ("Lagrange", 1))


def nodes(space):
    return space.tabulate_dof_coordinates()[:, : space.mesh.geometry.dim]


def places(space):
    """Points of the body by name: anywhere in cells, on edges (and so on the boundary), and at nodes."""
    corners = space.mesh.geometry.x[space.mesh.geometry.dofmaps[0]][..., : space.mesh.geometry.dim]
    weights = np.random.default_rng(1).dirichlet(np.ones(corners.shape[1]), len(corners))
    inside = np.einsum("ij,ijk->ik", weights, corners)
    found = np.concatenate([inside, corners[:, :2].mean(axis=1), nodes(space)])
    return {f"p{i}": tuple(point) for i, point in enumerate(found)}


def test_linear_fields_are_exact_anywhere(space):
    """Probes docstring: interpolation of P1 fields, so linear ones are reproduced; scalars and vectors."""
    points = places(space)
    probes = Probes(space, points)
    x, at = nodes(space), np.array(list(points.values()))
    slope = np.array([0.7, -1.3])[: x.shape[1]]
    values = 2.0 + x @ slope
    np.testing.assert_allclose(probes.local(values), 2.0 + at @ slope, rtol=0, atol=1e-12)  # measured 1e-14
    two = probes.local(np.column_stack([values, -3 * values]))
    np.testing.assert_allclose(two, np.column_stack([2.0 + at @ slope] * 2) * [1, -3], rtol=0, atol=1e-12)
    np.testing.assert_array_equal(probes.gather(two), two)
    np.testing.assert_array_equal(probes.positions[:, : x.shape[1]], at)
    assert list(probes.names) == list(points)


def test_points_outside_are_refused(space):
    """Requirements, "Bad input", and the interface: the message names the probe and what is allowed."""
    dim = space.mesh.geometry.dim
    highest = nodes(space).max(axis=0)
    for point in (highest + 1e-5, [-1e-5] * dim, [1e9] * dim):
        with pytest.raises(InputError, match=r"probes\.b: .* outside the body"):
            Probes(space, {"a": nodes(space)[0], "b": point})
    what = "a finite coordinate" if dim == 1 else f"{dim} finite coordinates"
    for point in ([np.nan] * dim, [np.inf] * dim, [1.0] * (dim - 1), [1.0] * 4):
        with pytest.raises(InputError, match=rf"probes\.b: .*give {what}"):
            Probes(space, {"a": nodes(space)[0], "b": point})


def test_points_may_have_three_coordinates(space):
    """Interface, [probes]: NAME = [x, y, z]; those beyond the body's dimension must be zero."""
    point = nodes(space)[3]
    probes = Probes(space, {"a": [*point, *[0.0] * (3 - len(point))]})
    np.testing.assert_allclose(probes.local(nodes(space)), point[None], atol=1e-14)
    with pytest.raises(InputError, match=r"probes\.a: .*outside"):
        Probes(space, {"a": [*point, *[1.0] * (3 - len(point))]})


def test_activation_times_are_linear_in_time(space):
    """Interface: "first time v crosses 0.5 upward at the probe, linear in time between steps".

    v rises linearly in time and falls again; the time T(X) of its crossing is linear in X. Steps are unequal,
    so that a crossing at the middle, or at an end, of a step is a wrong one.
    """
    points = places(space)
    x, at = nodes(space), np.array(list(points.values()))
    slope = np.array([0.05, 0.02])[: x.shape[1]]
    v = fem.Function(space)
    times = np.cumsum([0.0, 0.07, 0.2, 0.11, 0.3, 0.02, 0.4, 0.19, 0.3])

    def potential(t):  # rises until 0.8 with slope 3, then falls, and rises again after 1.1
        rise = np.interp(t, [0.0, 0.8, 1.0, 1.1, 1.6], [0.0, 0.8, 0.0, 0.0, 0.5])
        return LEVEL + 3 * (rise - 0.1 - x @ slope)

    v.x.array[:] = potential(0.0)
    activation = ActivationTimes(v, Probes(space, points), LEVEL)
    for start, end in itertools.pairwise(times):
        v.x.array[:] = potential(end)
        activation.observe(start, end)
    expected = 0.1 + at @ slope
    assert 0.1 <= expected.min() < expected.max() < times[4]
    found = np.array([first for first, *_ in activation.at_probes().values()])
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)  # measured 2e-16
    np.testing.assert_allclose(activation.nodes, 0.1 + x @ slope, rtol=0, atol=1e-13)


@pytest.mark.parametrize("history", [(0.0, 0.499, 0.2), (0.9, 0.6, 0.7), (0.9, 0.2, 0.1)])
def test_no_activation_time_without_an_upward_crossing(space, history):
    """Interface: null if never; a point that begins above 0.5 does not cross it upward."""
    v = fem.Function(space)
    v.x.array[:] = history[0]
    activation = ActivationTimes(v, Probes(space, {"a": nodes(space)[1]}), LEVEL)
    for step, value in enumerate(history[1:]):
        v.x.array[:] = value
        activation.observe(step, step + 1)
    assert activation.at_probes() == {"a": []}
    assert np.isnan(activation.nodes).all()


def test_reactivation_from_above_counts():
    """Interface: the first *upward* crossing: a point above 0.5 at first has one if it rises again."""
    before, after = np.array([0.2, 0.2, 0.9, 0.5, 0.2]), np.array([0.8, 0.4, 0.1, 0.9, 0.5])
    seen = Activations(5, 0.5)
    assert seen.observe(before, after, 1.0, 3.0).tolist() == [0, 4]
    np.testing.assert_allclose(seen.times, [[2.0, np.nan, np.nan, np.nan, 3.0]], atol=1e-15)


# The leading pulse.

WIDTH, SKEW = 0.85, 1.5
#: Where the skewed front's argument makes it 0.5, and its steepness there.
HALF = np.log(2 ** (1 / SKEW) - 1)
STEEPNESS = SKEW / (2 * WIDTH) * (1 - 2 ** (-1 / SKEW))


def front(X, place, skew=SKEW):
    """v falls from 1 to 0 and is 0.5 at a place: (1 − tanh)/2 of section 4.1 to a power (1: the tanh itself).

    The power makes it asymmetric: even derivatives of tanh vanish at 0.5, which flatters an interpolation.
    """
    half = HALF if skew == SKEW else np.log(2 ** (1 / skew) - 1)
    return ((1 - np.tanh(((X - place) / WIDTH + half) / 2)) / 2) ** skew


def spatial(X):
    """A smooth, increasing deformation of the line."""
    return 0.7 * X + 0.004 * X**2


def errors(cells, measure):
    """Largest error over where the crossings lie between two nodes, (quantities,)."""
    h = 40.0 / cells
    X = np.linspace(0.0, 40.0, cells + 1)
    return np.max([np.abs(measure(X, shift * h)) for shift in np.linspace(0.05, 0.95, 10)], axis=0)


def orders(measure):
    found = np.array([errors(cells, measure) for cells in (160, 320, 640)])
    return np.log2(found[:-1] / found[1:])


def front_error(X, shift):
    found = leading_pulse(X, spatial(X), front(X, 20.0 + shift))
    assert (found.back, found.width_spatial, found.width_material) == (None, None, None)
    return found.front - 20.0 - shift, found.slope - STEEPNESS


def test_front_and_slope_are_of_high_order():
    """metrics._crossing: the cubic through four nodes gives the place to order 4 and the slope to order 3."""
    place, slope = orders(front_error).T
    # Measured 3.99, 4.01 and 3.18, 3.12 (by the line through two nodes: 2 and 1; of tanh: 5 and 4).
    assert ((place > 3.9) & (place < 4.1)).all(), place
    assert ((slope > 2.9) & (slope < 3.3)).all(), slope
    assert errors(160, front_error)[0] < 5e-5  # h = 0.25, measured 4.2e-5


def pulse_error(X, shift):
    back, lead = 11.0 - 0.4 * shift, 29.0 + shift
    found = leading_pulse(X, spatial(X), front(X, lead) - front(X, back))
    return (
        found.front - lead,
        found.back - back,
        found.width_material - (lead - back),
        found.width_spatial - (spatial(lead) - spatial(back)),
    )


def test_pulse_width_is_of_high_order():
    """Interface: width_* is the distance of upstroke and downstroke crossing of v = 0.5, in X and in x.

    The tail of each of the two fronts moves the other by less than 1e-8.
    """
    found = orders(pulse_error)
    assert ((found > 3.9) & (found < 4.1)).all(), found  # measured 3.98 to 4.04


def test_spatial_width_is_that_of_the_deformed_line():
    """Interface: width_spatial is in x; on a line contracted by 0.7 it is 0.7 of the material one."""
    X = np.linspace(0.0, 40.0, 161)
    found = leading_pulse(X, 0.7 * X - 3.0, front(X, 29.0) - front(X, 11.0))
    assert found.width_spatial == pytest.approx(0.7 * found.width_material, rel=1e-12)
    assert found.width_material == pytest.approx(18.0, rel=1e-4)


def test_the_leading_pulse_is_taken():
    """Interface: "of the leading pulse": the one farthest along X, whatever is behind it."""
    X = np.linspace(0.0, 40.0, 401)
    v = (front(X, 12.0) - front(X, 5.0)) + (front(X, 32.0) - front(X, 22.0))
    found = leading_pulse(X, spatial(X), v)
    assert (found.front, found.back) == pytest.approx((32.0, 22.0), abs=1e-4)
    assert found.width_spatial == pytest.approx(spatial(32.0) - spatial(22.0), abs=1e-4)
    # What enters from the right has not yet a front of its own.
    entering = leading_pulse(X, X, v + 1 - front(X, 39.0))
    assert (entering.front, entering.back) == pytest.approx((32.0, 22.0), abs=1e-2)


@pytest.mark.parametrize(
    "v", [np.zeros(50), np.ones(50), np.full(50, 0.499), 1 - front(np.arange(50.0), 25.0)]
)
def test_no_pulse(v):
    """leading_pulse docstring: None where no front travels towards growing X."""
    assert leading_pulse(np.arange(50.0), np.arange(50.0), v) is None


@pytest.mark.parametrize("v, place", [([1.0, 0.0], 0.5), ([1.0, 0.9, 0.1], 1.6046), ([1, 1, 0, 0], 1.5)])
def test_few_nodes(v, place):
    """A crossing is found by the polynomial through as many nodes as there are, at most four."""
    X = np.arange(float(len(v)))
    assert leading_pulse(X, X, np.array(v, dtype=float)).front == pytest.approx(place, abs=1e-4)


@pytest.mark.parametrize("size", [1e-7, 1.0, 1e6])
def test_probes_in_any_unit_of_length(size):
    """cells_at docstring: "on a mesh of straight cells of any size"; a point is in its own cell."""
    mesh = ms.geometry.Slab(size=(size, size, size), spacing=size / 4).mesh(ALONE).mesh
    space = fem.functionspace(mesh, ("Lagrange", 1))
    probes = Probes(space, {"a": (0.3 * size, 0.6 * size, 0.9 * size), "b": (size, size, size)})
    found = probes.local(nodes(space))
    np.testing.assert_allclose(found, probes.positions, rtol=1e-12)
    assert probes._weights.min() > -1e-5
    with pytest.raises(InputError, match="outside the body"):
        Probes(space, {"a": (1.001 * size, 0.5 * size, 0.5 * size)})
