"""The mass that follows a front (docs/niederer.md): of fourth order in every direction, positive."""

import myostrain as ms
from myostrain.electrics.following import FollowingMass
from myostrain.kinematics import Deformation

import numpy as np
import pytest
import ufl
from test_front import ACROSS, STRENGTH, Cubic

from coupled import observed_orders

#: D along the fibres of docs/niederer.md, mm²/ms.
ALONG = 0.0952983725


class Silent(Cubic):
    """No current; cells of these tests have a third of its range at most."""

    range = (0.0, 3.0)


STRETCHES = (1.2, 0.9, 1.1)


def slab(cells, fibre, deformation=None, D=(1.0, 0.4)):
    """A cube of side 2 without a current."""
    geometry = ms.geometry.Slab(size=(2.0, 2.0, 2.0), spacing=2.0 / cells)
    return ms.Potential(
        ms.build(geometry, ms.geometry.UniformFibres(direction=fibre)),
        membrane=Silent(factor=0.0),
        diffusivity=D,
        mass="averaged",
        reaction="interpolated",
        deformation=deformation,
    )


def wave_errors(cells, fibre, kappa, stretches):
    """How far K v/M v is from κ·Dκ for v = exp(κ·x), as a front's foot is, at a node in the middle.

    With the mass that follows, and with the averaged one.
    """
    F = np.diag(stretches)
    J = float(np.prod(stretches))
    potential = slab(cells, fibre, Deformation(ufl.as_matrix(F.tolist()), ufl.as_ufl(J)))
    x = potential.v.function_space.tabulate_dof_coordinates()
    node = int(np.argmin(np.abs(x - 1.0).sum(axis=1)))
    v = np.exp((x - 1.0) @ kappa)
    potential.v.x.array[:] = v
    potential.start()
    diffusion, past = potential._diffusion, potential.past
    rate = diffusion.rate(1.0, v)[node] * potential.weight[node]
    averaged = diffusion.load(J * v)[node]
    nodal, times, weights = np.zeros((2, len(v))), (1.0, 0.0), np.array([1.0, -1.0])
    added = past.front.solve(v, J * v, nodal, potential.ratio, {}, past.values, times, weights)[0]
    assert abs(added.sum()) < 1e-13  # nothing comes from nowhere
    direction = F @ fibre / np.linalg.norm(F @ fibre)
    seen = np.linalg.solve(F.T, kappa)
    exact = 0.4 * seen @ seen + 0.6 * (seen @ direction) ** 2
    return rate / (averaged + added[node]) / exact - 1, rate / averaged / exact - 1


@pytest.mark.parametrize("stretches", [(1.0, 1.0, 1.0), STRETCHES])
@pytest.mark.parametrize("kappa", [(1.0, 0.0, 0.0), (0.5, 0.0, 0.8), (0.6, 0.6, 0.529)])
def test_fourth_order_in_every_direction(kappa, stretches):
    """On a rigid and on a deformed body; the averaged mass has it along the boxes' edges only."""
    errors = np.array([wave_errors(n, (1.0, 0.0, 0.0), np.array(kappa), stretches) for n in (4, 8)])
    assert abs(errors[1, 0]) < 5e-5
    (follows,), (averaged,) = (observed_orders(np.abs(row)) for row in errors.T)
    assert follows > 3.7
    if kappa[0] != 1.0:
        assert averaged == pytest.approx(2.0, abs=0.2)
        assert abs(errors[0, 1]) > 1e-2


def test_oblique_fibres():
    """Shares that are cut down leave a part of the error."""
    kappa = np.ones(3) / np.sqrt(3)
    follows, averaged = wave_errors(8, (1.0, 0.2, 0.1), kappa, (1.0, 1.0, 1.0))
    assert abs(follows) < 0.1 * abs(averaged)
    assert abs(averaged) > 5e-3


def test_it_is_positive():
    """Whatever v and D are, with stiffness of both signs between the corners."""
    potential = slab(4, (1.0, 0.7, 0.4), D=(20.0, 1.0))
    following = potential.past.front._following
    cells = np.arange(len(potential.past.front._nodes))
    v = np.random.default_rng(1).normal(size=(4, len(cells)))
    shares = following.shares(cells, v)
    assert (shares < 0).any()
    masses = np.tile(np.eye(4) / 4, (len(cells), 1, 1))
    for share, (i, j) in zip(shares, following._edges, strict=True):
        edge = np.eye(4)[i] - np.eye(4)[j]
        masses -= share[:, None, None] * np.outer(edge, edge)
    assert np.linalg.eigvalsh(masses).min() > 0.02


def test_it_is_given_up_where_a_front_is_as_narrow_as_a_cell():
    """ "Where a cell has a part s of the whole height of the front, it gets 1 − s⁴ of the difference"."""
    following = slab(2, (1.0, 0.0, 0.0)).past.front._following
    cells = np.arange(2)
    shape = np.array([[0.0, 0.2, 0.7, 1.0], [1.0, 0.1, 0.0, 0.4]])  # from the lowest to the highest corner
    values = np.array([[1.0, -0.5, 0.3, 0.8], [0.2, 0.9, -1.0, 0.1]])
    flat = following.difference(cells, 1e-6 * shape, values)
    assert np.abs(flat).max() > 1e-3
    for part in (0.3, 0.6, 0.9, 1.0):
        found = following.difference(cells, part * following._span * shape, values)
        np.testing.assert_allclose(found, (1 - part**4) * flat, rtol=1e-12, atol=1e-16)
    np.testing.assert_allclose(following.difference(cells, 9.0 * shape, values), 0.0, atol=1e-16)


def test_on_a_line_it_is_the_averaged_mass():
    """Whatever v is."""
    body = ms.build(ms.geometry.Line(length=3.0, spacing=1.0))
    potential = ms.Potential(body, membrane=Cubic(), mass="averaged")
    following = FollowingMass(potential.v.function_space, potential._diffusion.conductivity, 1.0)
    v = np.array([[0.0, 0.3, 1.0], [0.3, 1.0, 1.5]])
    np.testing.assert_allclose(following.shares(np.arange(3), v), 1 / 12, rtol=1e-15)
    np.testing.assert_allclose(following.difference(np.arange(3), v.T, v.T), 0.0, atol=1e-16)


def test_corner_of_a_sheet():
    """10 × 4 mm of TTP06: 15.27 and 12.82 ms at the ends of its sides, 20.02 at the corner between.

    Finite differences give these (docs/niederer.md). With cells of 0.2 mm the averaged mass
    is 1.0 % early at the corner and 1.5 % late along the fibre: diagonals are too fast.
    """
    body = ms.build(
        ms.geometry.Rectangle(size=(10.0, 4.0), spacing=0.2), ms.geometry.UniformFibres(direction=(1.0, 0.0))
    )
    box = ms.Place(box=((0.0, 0.0), (1.5, 1.5)), sampling="mean")
    membrane = ms.membranes.TenTusscherPanfilov2006()
    potential = ms.Potential(
        body,
        membrane=membrane,
        diffusivity=(ALONG, ACROSS),
        mass="averaged",
        reaction="interpolated",
        stimuli=[ms.Stimulus(where=box, strength=STRENGTH, duration=2.0)],
    )
    model = ms.Electromechanics(potential)
    model.start()
    x = potential.v.function_space.tabulate_dof_coordinates()[:, :2]
    nodes = [int(np.argmin(np.abs(x - place).sum(axis=1))) for place in ((10, 0), (0, 4), (10, 4))]
    found, before = np.full(3, np.nan), potential.v.x.array[nodes]
    for number in range(1, 411):
        model.step(0.05 * number)
        after = potential.v.x.array[nodes]
        passed = (after >= membrane.threshold) & np.isnan(found)
        part = (after - membrane.threshold) / (after - before)
        found[passed] = 0.05 * (number - part[passed])
        before = after
    late = found / (15.27, 12.82, 20.02) - 1
    np.testing.assert_allclose(late, (0.012, 0.009, -0.002), atol=3e-3)
