"""The conduction velocity from activation times, against waves in closed form."""

import myostrain as ms
from myostrain.output.conduction import conduction_velocity

import numpy as np
import pytest
from dolfinx import fem

FIBRES = {1: (1.0,), 2: (1.0, 0.0), 3: (1.0, 0.0, 0.0)}


def space_of(geometry):
    body = ms.build(
        geometry, ms.UniformFibres(direction=FIBRES[len(np.atleast_1d(getattr(geometry, "size", 1.0)))])
    )
    space = fem.functionspace(body.mesh, ("Lagrange", 1))
    return space, space.tabulate_dof_coordinates()[:, : body.dim]


@pytest.mark.parametrize(
    "geometry, slowness",
    [
        (ms.geometry.Line(length=10.0, spacing=0.7), (2.0,)),
        (ms.geometry.Ellipse(size=(8.0, 10.0), spacing=1.1, distortion=0.15), (0.3, -1.1)),
        (ms.geometry.Slab(size=(4.0, 3.0, 2.0), spacing=0.8), (0.3, -1.1, 0.7)),
    ],
    ids=["line", "sheet", "solid"],
)
def test_a_plane_wave_has_its_speed_everywhere(geometry, slowness):
    """T = 9 + s·X: 1 / |s| at every node, to round-off."""
    space, X = space_of(geometry)
    found = conduction_velocity(space, 20 + X @ slowness)
    np.testing.assert_allclose(found, 1 / np.linalg.norm(slowness), rtol=1e-12)


def elliptic(spacing, along=0.6, across=0.3):
    """Largest relative errors, inside and in all, of an elliptic wave away from its source."""
    space, X = space_of(ms.geometry.Rectangle(size=(10.0, 10.0), spacing=spacing))
    T = np.hypot(X[:, 0] / along, X[:, 1] / across)
    with np.errstate(invalid="ignore", divide="ignore"):
        exact = T / np.hypot(X[:, 0] / along**2, X[:, 1] / across**2)
    far = np.hypot(*X.T) > 3.0
    found = conduction_velocity(space, T)
    assert np.nanmin(exact[far]) < 0.302
    assert np.nanmax(exact[far]) > 0.598
    inner = far & (X > 1e-9).all(axis=1) & (X < 10 - 1e-9).all(axis=1)
    return np.abs(found / exact - 1)[inner].max(), np.abs(found / exact - 1)[far].max()


def test_an_elliptic_wave_has_the_speed_of_each_direction():
    """T = √((X/a)² + (Y/b)²), speed T / |(X/a², Y/b²)|: second order inside, first at the boundary."""
    (coarse, coarse_edge), (fine, fine_edge) = elliptic(0.5), elliptic(0.25)
    assert fine < 0.01
    assert coarse / fine > 3.0
    assert fine_edge < 0.05
    assert coarse_edge / fine_edge > 1.7


def test_no_speed_where_waves_meet_begin_or_are_missing():
    """On a line: begun in the middle of the left half, met at 8, blocked beyond 12; and activated at once."""
    space, X = space_of(ms.geometry.Line(length=16.0, spacing=1.0))
    x = X[:, 0]
    T = 1 + np.minimum(np.abs(x - 4), np.abs(x - 12) + 0.0) / 2
    T[x > 12.5] = np.nan
    found = conduction_velocity(space, T)[np.argsort(x)]
    expected = np.full(17, 2.0)
    expected[[4, 8]] = np.nan  # begin, meet
    expected[13:] = np.nan
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    assert np.isnan(conduction_velocity(space, np.full_like(T, 3.0))).all()
    uneven = conduction_velocity(space, 1 + np.minimum(x / 2, 16 - x + 1 / 3))[np.argsort(x)]
    assert np.isnan(uneven[11])  # where a slow wave and a fast one meet
    np.testing.assert_allclose(uneven[[*range(10), *range(12, 17)]], [2.0] * 10 + [1.0] * 5, rtol=1e-12)
    begun = conduction_velocity(space, np.maximum(0.0, (x - 5.5) / 2))[np.argsort(x)]
    assert np.isnan(begun[:6]).all()  # excited from the start
    np.testing.assert_allclose(begun[7:], 2.0, rtol=1e-12)


def test_a_runs_median_is_its_celerity():
    """A front on a rigid line: the median of the map is the speed between two probes."""
    body = ms.build(ms.geometry.Line(length=60.0, spacing=0.5))
    bump = ms.InitialValues(where=ms.Place(center=(0.0,), radius=5.0), potential=0.9)
    potential = ms.Potential(body, membrane=ms.membranes.FitzHughNagumo(), diffusivity=100.0, initial=[bump])
    simulation = ms.Simulation(
        ms.Electromechanics(potential), step=2e-3, end=1.0, probes={"a": (25.0,), "b": (45.0,)}
    )
    metrics = simulation.run()["metrics"]
    assert metrics["conduction_velocity_median"] == pytest.approx(metrics["celerity"], rel=0.02)
