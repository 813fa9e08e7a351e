"""Integrators of a membrane's states: their orders, against an independent integrator."""

import itertools

import myostrain as ms
from myostrain.membranes import (
    GeneralizedRushLarsen,
    LinearlyImplicit,
    LuoRudy1991,
    MitchellSchaeffer2003,
    RushLarsen,
    Step,
    TenTusscherPanfilov2006,
)
from myostrain.membranes.reaction import Reaction

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from coupled import observed_orders

END = 8.0
MODELS = [LuoRudy1991(), TenTusscherPanfilov2006()]
INTEGRATORS = [RushLarsen(), GeneralizedRushLarsen(), GeneralizedRushLarsen(substeps=2)]
each_model = pytest.mark.parametrize("membrane", MODELS, ids=lambda m: type(m).__name__)


def potential(t):
    """A smooth course that stays below -40 mV, where rates of both models jump."""
    return -84.0 + 42.0 * np.sin(np.pi * t / 10.0) ** 2


def start(membrane):
    return np.array(membrane.resting_states(), dtype=float)


@pytest.fixture(scope="module")
def exact():
    """States at the end by SciPy, for models by name."""
    found = {}
    for membrane in MODELS:
        solved = solve_ivp(
            lambda t, s, m=membrane: np.array(
                [np.ravel(r)[0] for r in m.rates(np.array([potential(t)]), s[:, None])]
            ),
            (0, END),
            start(membrane),
            "Radau",
            rtol=1e-10,
            atol=1e-13,
            max_step=0.1,
        )
        found[type(membrane).__name__] = solved.y[:, -1]
    return found


def advanced(membrane, integrator, count, order):
    """States at the end after so many steps of a given potential."""
    reaction = Reaction(membrane, integrator)
    states, h = start(membrane)[:, None], END / count
    for number in range(count):
        before, after = (np.array([potential((number + i) * h)]) for i in (0, 1))
        step = Step(h, 1 / h, -states / h, states, before, order)
        states, *_, bad = reaction.solve(after, states.copy(), step)
        assert bad == -1
    return states[:, 0]


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=str)
@pytest.mark.parametrize("order", [1, 2])
@each_model
def test_exponential_integrators_have_their_order(membrane, integrator, order, exact):
    """RushLarsen, GeneralizedRushLarsen: order 1 or 2, as the scheme asks; the worst state counts."""
    wanted = exact[type(membrane).__name__]
    scale = np.maximum(np.abs(wanted), 1e-3)
    errors = [
        np.abs((advanced(membrane, integrator, count, order) - wanted) / scale).max() for count in (800, 1600)
    ]
    assert errors[1] < (2e-2 if order == 1 else 2e-3)
    assert observed_orders(errors)[-1] == pytest.approx(order, abs=0.15)


def test_substeps_halve_the_steps_of_the_membrane():
    """The potential is linear in time between: with one that is, two substeps are two steps, to the bit."""
    membrane, h = LuoRudy1991(), 0.05
    states, v = start(membrane)[:, None], [np.array([x]) for x in (-80.0, -70.0, -60.0)]
    whole, *_ = Reaction(membrane, GeneralizedRushLarsen(substeps=2)).solve(
        v[2], states.copy(), Step(h, 1 / h, -states / h, states, v[0], 2)
    )
    single = Reaction(membrane, GeneralizedRushLarsen())
    for before, after in ((v[0], v[1]), (v[1], v[2])):
        states, *_ = single.solve(after, states.copy(), Step(h / 2, 2 / h, -states, states, before, 2))
    np.testing.assert_array_equal(whole, states)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=str)
@pytest.mark.parametrize("order", [1, 2])
def test_gates_stay_in_bounds_and_concentrations_positive(integrator, order):
    """Issue: "No state can go negative by extrapolation", with steps far above those that one takes."""
    membrane = TenTusscherPanfilov2006()
    gates = [membrane.states.index(name) for name in membrane.gates]
    states = start(membrane)[:, None]
    reaction = Reaction(membrane, integrator)
    for before, after in 10 * [(-85.0, 40.0), (40.0, 40.0), (40.0, -85.0), (-85.0, -85.0)]:
        step = Step(0.2, 5.0, -5 * states, states, np.array([before]), order)
        states, *_, bad = reaction.solve(np.array([after]), states.copy(), step)
        assert bad == -1
        assert (states >= 0).all()
        assert (states[gates] <= 1).all()


def test_a_gate_that_leaves_its_bounds_stops_the_run():
    """ "A gate that leaves [0, 1] or a NaN names state, place and time": here one that starts far outside."""
    body = ms.build(ms.geometry.Line(length=10.0, spacing=1.0))
    wrong = ms.InitialValues(where=ms.Place(center=(7.0,), radius=0.2), states={"h": -3.0})
    potential = ms.Potential(
        body,
        membrane=MitchellSchaeffer2003(),
        diffusivity=0.1,
        integrator=LinearlyImplicit(),
        initial=[wrong],
    )
    model = ms.Electromechanics(potential)
    model.start()
    with pytest.raises(ms.ComputationError, match=r"the gate h has left \[0, 1\].* near \[7\.0\]") as caught:
        model.step(0.1)
    assert caught.value.time == 0.1


@pytest.mark.parametrize(
    "scheme, order", [(ms.Staggered(), 1), (ms.Implicit(), 1), (ms.SecondOrder(), 2)], ids=str
)
def test_coupled_schemes_keep_their_order(scheme, order):
    """A line that contracts by an ionic model with gates: potential, gates and stretch."""

    def run(count):
        body = ms.build(ms.geometry.Line(length=8.0, spacing=1.0))
        mechanics = ms.Mechanics(body, kinematics=ms.kinematics.Line(), material=ms.materials.Spring())
        smooth = ms.Potential(
            body,
            membrane=MitchellSchaeffer2003(tau_in=2.0),
            diffusivity=1.0,
            deformation=mechanics.deformation,
            source=lambda X, t: 0.2 * np.exp(-((t - 4.0) ** 2)) * np.cos(np.pi * X[:, 0] / 8.0) ** 2,
            initial=[ms.InitialValues(where=ms.Place(box=((-1.0,), (9.0,))), potential=0.3)],
        )
        model = ms.Electromechanics(
            smooth, mechanics, law=ms.activation.Proportional(beta=0.2), scheme=scheme
        )
        model.start()
        for number in range(1, count + 1):
            model.step(6.0 * number / count)
        values = [*model.potential.field_values().values(), mechanics.displacement().x.array]
        return np.concatenate([np.ravel(v) for v in values])

    found = [run(count) for count in (100, 200, 400)]
    errors = [np.abs(a - b).max() for a, b in itertools.pairwise(found)]
    assert errors[-1] < 5e-3
    assert observed_orders(errors)[-1] == pytest.approx(order, abs=0.15)
