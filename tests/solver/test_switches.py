"""The implicit scheme where a membrane switches at a potential and no iterate fits its own side."""

import myostrain as ms

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from coupled import line

#: Where the toy switches, and its rates below and above.
AT, BELOW, ABOVE = 0.5, 1.0, 2.0


class Switching(ms.membranes.Membrane):
    """A potential that falls at a constant rate, faster above 1/2 than below."""

    range = (0.0, 1.0)
    states = ()

    def resting_states(self):
        return ()

    def current(self, v, states):
        return np.where(v > AT, ABOVE, BELOW)

    def rates(self, v, states):
        return ()


def points(membrane, potentials, states=()):
    """Nodes that do not see each other, from these potentials, by the implicit scheme."""
    body = ms.build(ms.geometry.Line(length=len(potentials) - 1.0, spacing=1.0))
    potential = ms.Potential(body, membrane=membrane, diffusivity=1e-12)
    order = np.argsort(potential.v.function_space.tabulate_dof_coordinates()[:, 0])
    potential.v.x.array[order] = potentials
    if states:
        potential.states = np.repeat(np.array(states)[:, None], len(potentials), axis=1)
    model = ms.Electromechanics(potential, scheme=ms.Implicit())
    model.start()
    return model, order


@pytest.mark.parametrize("step", [5e-4, 2.5e-4])
def test_points_cross_a_switch(step):
    """Implicit: "keeps its iterate for the rest of the step"; the error is less than the swing, h (2 − 1)."""
    begun = AT + np.linspace(0.2, 5.0, 25) * step
    model, order = points(Switching(), begun)
    for number in range(1, 9):
        model.step(number * step)
    exact = AT - BELOW * (8 * step - (begun - AT) / ABOVE)
    assert 5 <= model.switches <= len(begun)  # at most once a node
    assert np.abs(model.potential.v.x.array[order] - exact).max() < step * (ABOVE - BELOW)
    assert model.coupling_iterations < 8 * 30


def test_a_human_cell_repolarises_through_its_switch():
    """BuenoOrovio2008 at θ_w, where the slow outward current sets in: against SciPy, started on each side."""
    cell, step = ms.membranes.BuenoOrovio2008(), 0.02
    theta, states = -84 + 85.7 * cell.theta_w, (0.0, 0.25, 0.08)
    begun = theta + np.linspace(0.02, 0.1, 9)
    model, order = points(cell, begun, states)
    for number in range(1, 6):
        model.step(number * step)

    def rates(t, y, v):
        return [-cell.current(v, y[1:]), *cell.rates(v, y[1:])]

    def crossing(t, y):
        return y[0] - theta

    crossing.terminal = True
    for found, v in zip(model.potential.v.x.array[order], begun, strict=True):
        # To the switch as above it, from there as below: the integrator must not see the jump.
        above = solve_ivp(
            lambda t, y: rates(t, y, max(y[0], theta + 1e-9)), (0, 5 * step), [v, *states], events=crossing
        )
        after = solve_ivp(
            lambda t, y: rates(t, y, min(y[0], theta)), (above.t[-1], 5 * step + 1e-9), above.y[:, -1]
        )
        assert found == pytest.approx(after.y[0, -1], abs=0.02 * 85.7 * step)
    assert model.switches > 0


def test_a_contracting_line_crosses_a_switch():
    """The same with J v balanced on a free line that contracts: all nodes at once, (J v)′ = −J I."""
    beta, step, v = 0.3, 5e-4, 0.5031
    model = line(
        ms.Implicit(), length=4.0, beta=beta, membrane=Switching(), initial=lambda X: np.full(len(X), v)
    )
    model.start()
    for number in range(1, 13):
        model.step(number * step)

    def until(t, v, current):
        def rate(t, v):
            return -current * (1 - beta * v) / (1 - 2 * beta * v)

        def crossing(t, v):
            return v[0] - AT + (t < 0)

        crossing.terminal = current == ABOVE
        return solve_ivp(rate, (t, 12 * step), [v], events=crossing, rtol=1e-10, atol=1e-12)

    above = until(0.0, v, ABOVE)
    exact = until(above.t[-1], above.y[0, -1], BELOW).y[0, -1]
    assert model.switches == len(model.potential.v.x.array)
    assert np.abs(model.potential.v.x.array - exact).max() < 2 * step


def test_wide_swings_are_still_refused():
    """A swing of more than a thousandth of the range is not held: a smaller step is asked for."""
    model, _ = points(Switching(), np.full(2, AT + 0.15))
    with pytest.raises(ms.ComputationError, match="did not converge") as caught:
        model.step(0.1)
    assert "smaller time step" in caught.value.advice
