"""Membrane models: equilibrium at rest, the paper's (2.1)–(2.2), and a user's own object in the potential."""

import myostrain as ms

import numpy as np
import pytest

from coupled import TIGHT, line

#: Every exported membrane; the protocol is none, and one of a file needs a file.
OTHERS = (ms.membranes.Membrane, ms.membranes.FileMembrane)
EXPORTED = [
    cls
    for name in ms.membranes.__all__
    if hasattr(cls := getattr(ms.membranes, name), "current") and cls not in OTHERS
]


class Gated:
    """A user's own membrane: one gate that closes when v rises, written with NumPy functions."""

    states = ("gate",)

    def resting_potential(self):
        return 0.0

    def resting_states(self):
        return (0.5 * (1 + np.tanh(0.13 / 0.05)),)

    def current(self, v, states):
        return -states[0] * v**2 * (1 - v) / 0.03 + v / 0.6

    def rates(self, v, states):
        open_ = 0.5 * (1 - np.tanh((v - 0.13) / 0.05))
        return ((open_ - states[0]) / (0.5 + 0.1 * np.exp(-v)),)

    def slope(self, v, gate):
        """∂current/∂v by hand."""
        return -gate * (2 * v - 3 * v**2) / 0.03 + 1 / 0.6


class PaperByHand:
    """FitzHugh–Nagumo's ∂current/∂v by hand."""

    def __init__(self, cell):
        self.cell = cell

    def slope(self, v, w):
        cell = self.cell
        return cell.A * (3 * v**2 - 2 * (1 + cell.alpha) * v + cell.alpha)


#: Their published initial states drift for minutes, as test_human_membranes.py measures.
DRIFTING = {ms.membranes.TenTusscherPanfilov2006, ms.membranes.ToRORd2019}
RESTING = [cls() for cls in EXPORTED if cls not in DRIFTING]


@pytest.mark.parametrize("cell", [*RESTING, ms.membranes.FitzHughNagumo(recovery=False)])
def test_rest_is_an_equilibrium(cell):
    """CONTRIBUTING.md: "states, their resting values and rates": at rest neither v nor any state changes."""
    v, states = np.float64(cell.resting_potential()), list(cell.resting_states())
    assert len(states) == len(cell.states) == len(cell.rates(v, states))
    assert cell.current(v, states) == pytest.approx(0.0, abs=1e-12)
    assert list(cell.rates(v, states)) == pytest.approx([0.0] * len(states), abs=1e-12)


def test_fitzhugh_nagumo_is_the_papers():
    """(2.1): current A v (v − α)(v − 1) + A w; (2.2): v − w/τ; its parameters those of every figure."""
    cell = ms.membranes.FitzHughNagumo()
    assert (cell.alpha, cell.tau, cell.A) == (0.1, 0.2, 100.0)
    cell = ms.membranes.FitzHughNagumo(alpha=0.13, tau=0.7, A=30.0)
    v, w = np.random.default_rng(1).uniform(-0.3, 1.2, (2, 100))
    np.testing.assert_allclose(
        cell.current(v, [w]), 30 * (v**3 - 1.13 * v**2 + 0.13 * v) + 30 * w, rtol=0, atol=1e-13 * 30
    )
    np.testing.assert_allclose(cell.rates(v, [w])[0], v - w / 0.7, rtol=0, atol=1e-15)
    # The zeros of the current without recovery are rest, threshold and excitation.
    without = ms.membranes.FitzHughNagumo(alpha=0.13, recovery=False)
    np.testing.assert_array_equal(without.current(np.array([0.0, 0.13, 1.0]), []), 0.0)
    assert without.states == without.resting_states() == without.rates(0.5, []) == ()


@pytest.mark.parametrize("alpha", [0.0, 1.0, -0.1, float("nan")])
def test_threshold_lies_between_rest_and_excitation(alpha):
    """The paper's 0 < α < 1; the message names the value."""
    with pytest.raises(ValueError, match="alpha"):
        ms.membranes.FitzHughNagumo(alpha=alpha)


@pytest.mark.parametrize("cell", [ms.membranes.FitzHughNagumo(), Gated()])
def test_one_step_uses_the_exact_slope_of_the_current(cell):
    """Potential.solve linearises the current about the guess g, by the complex step, exactly.

    Where v is uniform nothing diffuses, and one backward Euler step from v0 gives
    v = (v0/h − I(g, s) + I′ g)/(1/h + I′), with s the state solved at g; I′ by hand.
    """
    slope = cell.slope if isinstance(cell, Gated) else PaperByHand(cell).slope
    h, v0 = 1e-2, 0.35
    potential = ms.Potential(ms.build(ms.geometry.Line(length=20.0)), membrane=cell, options=TIGHT)
    potential.v.x.array[:] = v0
    potential.start()
    s0 = cell.resting_states()[0]
    nodes = len(potential.v.x.array)
    for g in (-0.2, 0.35, 0.8, 1.1):
        potential.states[:] = s0
        potential.solve(h, np.full(nodes, g), np.array([1 / h, -1 / h]))
        # Rates are linear in the state, so that one linearised solve is the implicit one.
        at0, at1 = cell.rates(g, [0.0])[0], cell.rates(g, [1.0])[0]
        s = (s0 / h + at0) / (1 / h - (at1 - at0))
        expected = (v0 / h - cell.current(g, [s]) + slope(g, s) * g) / (1 / h + slope(g, s))
        # Measured 2e-16.
        np.testing.assert_allclose(potential.v.x.array, expected, rtol=0, atol=1e-14)
        np.testing.assert_allclose(potential.states[0], s, rtol=0, atol=1e-14)


def test_a_users_own_membrane_drives_a_contracting_line():
    """Design: "In a user's own script the instance is passed directly (no registry)".

    A half excited line fires, contracts by γ(v) and the gate closes.
    """
    initial = dict(length=10.0, initial=lambda X: np.full_like(X, 0.3))
    model = line(ms.SecondOrder(), membrane=Gated(), **initial)
    model.start()
    assert model.potential.state_names == ("gate",)
    gate = model.potential.field_values()["gate"]
    np.testing.assert_array_equal(gate, Gated().resting_states()[0])
    for number in range(1, 101):
        model.step(number * 2e-3)
    v, gate = model.potential.field_values().values()
    # Measured: v = 0.92, gate = 0.69; J is that of the extrapolated body, off by O(h²): 4e-5.
    assert 0.8 < v.min() < v.max() < 1.0
    # A gate belongs to material points: that the ends are stretched otherwise does not show in it.
    assert gate.min() > 0.6
    assert np.ptp(gate) < 1e-3
    np.testing.assert_allclose(model.potential.ratio, 1 - 0.3 * v, rtol=0, atol=3e-4)
