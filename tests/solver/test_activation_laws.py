"""Activation laws at the nodes: what drives them, their states over time, and wrong ones refused at once."""

import myostrain as ms
from myostrain.activation import ActiveStress, FibreTension, Proportional, Relaxing
from myostrain.engine import fem

import numpy as np
import pytest
import ufl
from dolfinx import mesh as dmesh
from scipy.integrate import solve_ivp

from coupled import coordinates, gaussian, line
from mechanics_tools import described


class Law:
    """A law of a user's own: γ is a function of the drivers."""

    def __init__(self, drivers, function, **others):
        self.drivers, self._function = drivers, function
        for name, value in others.items():
            setattr(self, name, value)

    def activation(self, states, drivers):
        return self._function(drivers)


class Delayed:
    """A law of a user's own with states: γ₁ follows −βv, γ₂ follows γ₁."""

    drivers, states = ("potential",), ("first", "second")

    def initial_states(self, drivers):
        return (0.0, np.zeros_like(drivers["potential"]))

    def advance(self, states, drivers, step):
        rates = np.array([-0.3 * drivers["potential"] - states[0], states[0] - states[1]])
        return states + step * rates

    def activation(self, states, drivers):
        return states[1]


# What is refused.


def symbolic(drivers):
    unit = dmesh.create_unit_interval(ms.engine.MPI.COMM_SELF, 2)
    return ufl.SpatialCoordinate(unit)[0]


def function(drivers):
    unit = dmesh.create_unit_interval(ms.engine.MPI.COMM_SELF, 2)
    return fem.Function(fem.functionspace(unit, ("Lagrange", 1)))


def former():
    class Former:
        def gamma(self, v):
            return -0.2 * v

    return Former()


def delayed(**changes):
    law = Delayed()
    for name, value in changes.items():
        setattr(law, name, value)
    return law


def endless():
    law = Law(POTENTIAL, lambda d: law.activation((), d))
    return law


def remembering():
    memory = [0.0]

    def later(drivers):
        memory[0] = 0.9 * memory[0] - 0.01 * drivers["time"] - 1e-4
        return memory[0]

    return Law(("time",), later)


POTENTIAL = ("potential",)
WRONG = {
    "a UFL expression": (Law(POTENTIAL, symbolic), "gives a Indexed of UFL.*in NumPy"),
    "a function": (Law(POTENTIAL, function), "gives a Function of UFL.*in NumPy"),
    "a list of them": (Law(POTENTIAL, lambda d: [symbolic(d)]), "of UFL.*in NumPy"),
    "a function of UFL": (
        Law(POTENTIAL, lambda d: -0.2 * ufl.tanh(d["potential"])),
        r"(?s)Law\.activation failed.*UFL",
    ),
    "another shape": (Law(("time",), lambda d: np.zeros(3)), r"shape \(3,\); wanted"),
    "two values a node": (Law(POTENTIAL, lambda d: np.array([d["potential"]] * 2)), "shape|broadcast"),
    "complex values": (Law(POTENTIAL, lambda d: 1j * d["potential"]), "no array of real numbers"),
    "a text": (Law(POTENTIAL, lambda d: "much"), "no array of real numbers"),
    "a driver that it did not name": (Law(POTENTIAL, lambda d: d["time"] * 0), "KeyError: 'time'"),
    "no law": (object(), "object is not an activation law: it has no method activation"),
    "a law of earlier versions": (former(), r"gamma\(v\).*now `activation\(states, drivers\)`"),
    "a class": (Proportional, r"the class Proportional is not an object: give Proportional\(\)"),
    "no drivers": (Law(None, lambda d: 0.0), r"Law\.drivers is None"),
    "drivers in one text": (Law("potential", lambda d: 0.0), r"Law\.drivers is 'potential'; give names"),
    "a driver twice": (Law(("time", "time"), lambda d: 0.0), "name twice"),
    "an unknown driver": (Law(("strech",), lambda d: 0.0), "'strech' drives Law.*did you mean 'stretch'"),
    "no calcium": (
        Law(("calcium",), lambda d: 0.0),
        "'calcium' drives Law, and FitzHughNagumo has none.*Bueno",
    ),
    "states in one text": (delayed(states="r"), r"Delayed\.states is 'r'; give names"),
    "steps without states": (delayed(states=()), r"Delayed has a method advance, but no states: name them"),
    "no initial states": (delayed(initial_states=None), "no method initial_states"),
    "no advance": (delayed(advance=None), "no method advance"),
    "one initial state for two": (
        delayed(initial_states=lambda d: (0.0,)),
        r"gives 1 values; give one for each of the states \['first', 'second'\]",
    ),
    "a number for initial states": (delayed(initial_states=lambda d: 0.0), r"gives 0\.0; give one for each"),
    "no initial value": (delayed(initial_states=lambda d: None), "gives None; give one for each"),
    "a text for initial states": (delayed(initial_states=lambda d: "00"), "gives '00'; give one for each"),
    "a function for initial states": (delayed(initial_states=function), "give one for each"),
    "no return": (Law(POTENTIAL, lambda d: None), r"Law\.activation gives None: it has to end with return"),
    "masked values": (Law(("time",), lambda d: np.ma.masked_all(6)), "Law gives what is not finite"),
    "a division by zero": (Law(POTENTIAL, lambda d: 1 / 0), "activation failed: ZeroDivisionError"),
    "an unknown name": (Law(POTENTIAL, lambda d: unknown), "activation failed: NameError"),  # noqa: F821
    "a law that calls itself": (endless(), "activation failed: RecursionError"),
    "a memory without states": (remembering(), "called again.*what it remembers belongs in states"),
    "initial states of another shape": (
        delayed(initial_states=lambda d: (0.0, np.zeros(3))),
        r"initial_states gives values of shape \(3,\)",
    ),
    "neither strain nor tension": (
        Law(POTENTIAL, lambda d: 0.0, yields="stress"),
        'give "strain" or "tension"',
    ),
    "a tension for a strain": (ActiveStress(), r"yields a tension.*takes a strain.*FibreTension\(\)"),
}


@pytest.mark.parametrize("law, message", WRONG.values(), ids=WRONG.keys())
def test_wrong_laws_are_refused_before_the_first_step(law, message):
    """NodalActivation, Raises: "Something is missing in the law, or of a wrong kind or shape"."""
    with pytest.raises(ms.InputError, match=message) as caught:
        line(law=law, length=5.0).start()
    assert caught.value.key == "activation.law"


def test_one_rate_for_two_states_is_refused():
    """The states after a step must have the shape of those before it."""
    model = line(law=delayed(advance=lambda states, drivers, step: states[:1]), length=5.0)
    model.start()
    with pytest.raises(ms.InputError, match=r"advance gives values of shape \(1, 6\); wanted is \(2, 6\)"):
        model.step(1e-3)


def test_a_strain_for_a_tension_is_refused():
    """A law that yields γ, where the mechanics takes a tension."""
    body = ms.build(ms.geometry.Line(length=2.0))
    parts = dict(kinematics=ms.kinematics.Line(), material=ms.materials.Spring(), fixed=["left"])
    mechanics = ms.Mechanics(
        body,
        active=FibreTension(),
        **described(parts),
    )
    with pytest.raises(ms.InputError, match="yields a strain, and the mechanics takes a tension"):
        ms.Electromechanics(ms.GivenPotential(body), mechanics, law=Proportional())


@pytest.mark.parametrize(
    "former, said",
    [
        ("law", r"Electromechanics\(\.\.\., law="),
        ("deformation", "called active"),
        ("active_stress", "FibreTension"),
        ("activity", r"Electromechanics\(\.\.\., activity="),
        ("activity_max", "not needed"),
    ],
)
def test_former_keywords_of_mechanics(former, said):
    """Keywords of earlier versions say what became of them; any other is a TypeError."""
    body = ms.build(ms.geometry.Line(length=2.0))
    parts = dict(kinematics=ms.kinematics.Line(), material=ms.materials.Spring(), fixed=["left"])
    with pytest.raises(ms.InputError, match=f"Mechanics takes no '{former}' any more: .*{said}"):
        ms.Mechanics(
            body,
            **described(dict(**parts, **{former: None})),
        )
    with pytest.raises(TypeError, match="'lwa'"):
        ms.Mechanics(
            body,
            lwa=None,
            **described(parts),
        )


# What drives them.


def test_what_each_driver_is():
    """ActivationLaw.drivers: potential, states of the membrane, time and stretch are those of the step's end.

    The stretch is that of the last bodies, extrapolated: along an elastic line 1 + γ at the nodes, but for
    what a step changes, and for the mean around a node.
    """
    seen = {}

    def remember(drivers):
        seen.update({name: np.array(value) for name, value in drivers.items()})
        return -0.2 * drivers["potential"]

    law = Law(("potential", "recovery", "time", "stretch"), remember)
    model = line(ms.SecondOrder(), law=law, spacing=0.5)
    model.start()
    for number in range(1, 6):
        model.step(number * 1e-3)
        fields = model.potential.field_values()
        np.testing.assert_array_equal(seen["potential"], fields["potential"])
        np.testing.assert_array_equal(seen["recovery"], fields["recovery"])
        assert seen["time"] == number * 1e-3
    assert fields["recovery"].max() > 1e-3
    np.testing.assert_allclose(seen["stretch"], 1 + model.mechanics.activation.x.array, rtol=0, atol=5e-3)
    assert seen["stretch"].min() < 0.85


def test_activity_scales_what_the_law_yields():
    """Electromechanics: activity is a factor, a number or one at each node."""
    for activity in (0.5, np.linspace(0.0, 1.0, 11)):
        body = ms.build(ms.geometry.Line(length=10.0))
        parts = dict(kinematics=ms.kinematics.Line(), material=ms.materials.Spring(), fixed=["left"])
        mechanics = ms.Mechanics(
            body,
            **described(parts),
        )
        given = ms.GivenPotential(body, ms.Drive(potential=0.8))
        ms.Electromechanics(given, mechanics, law=Proportional(beta=0.4), activity=activity).start()
        np.testing.assert_allclose(mechanics.activation.x.array, -0.32 * activity, rtol=1e-14)


# A law with states.


@pytest.mark.parametrize("v, constant", [(0.9, 0.1), (0.0, 0.4), (-0.1, 0.4)])
def test_relaxing_is_exact_for_a_frozen_potential(v, constant):
    """Relaxing: τ(v) dγ/dt = −β v − γ, with τ = rise above the threshold and fall elsewhere: the closed form
    after any step, which an integrator of ordinary differential equations confirms.
    """
    law = Relaxing(beta=0.3, rise=0.1, fall=0.4, threshold=0.05)
    start, step = np.array([[-0.15, 0.0]]), 0.23
    found = law.advance(start, {"excitation": np.full(2, v)}, step)
    np.testing.assert_allclose(
        found[0], -0.3 * v + (start[0] + 0.3 * v) * np.exp(-step / constant), rtol=1e-14
    )
    solved = solve_ivp(
        lambda _, gamma: (-0.3 * v - gamma) / constant, (0, step), start[0], "DOP853", rtol=1e-12, atol=1e-14
    )
    np.testing.assert_allclose(found[0], solved.y[:, -1], rtol=0, atol=1e-11)


@pytest.mark.parametrize("scheme", [ms.Implicit(), ms.Staggered(), ms.SecondOrder()], ids=str)
def test_a_given_potential_drives_a_relaxing_law_exactly(scheme):
    """v = 1 from the start: γ = −β (1 − exp(−t/rise)) whatever the steps."""
    body = ms.build(ms.geometry.Line(length=4.0))
    mechanics = ms.Mechanics(
        body,
        kinematics=ms.kinematics.Line(),
        material=ms.materials.Spring(),
        supports=ms.Supports(fixed=["left"]),
    )
    law = Relaxing(beta=0.3, rise=0.1)
    model = ms.Electromechanics(
        ms.GivenPotential(body, ms.Drive(potential=1.0)), mechanics, law=law, scheme=scheme
    )
    model.start()
    assert not mechanics.activation.x.array.any()  # what is excited at the start has not contracted yet
    for time in (0.01, 0.04, 0.05, 0.3):
        model.step(time)
        gamma = -0.3 * (1 - np.exp(-time / 0.1))
        np.testing.assert_allclose(mechanics.activation.x.array, gamma, rtol=1e-13)
        np.testing.assert_allclose(mechanics.displacement().x.array.min(), 4 * gamma, rtol=1e-8)


def test_a_relaxing_law_is_not_bound_by_the_limit_of_beta():
    """A law with a time of its own does not follow v at once: β ≥ 1/2 is well-posed on an elastic line."""
    model = line(ms.SecondOrder(), law=Relaxing(beta=0.6), length=20.0)
    assert model.feedback == 0.0
    model.start()
    for number in range(1, 11):
        model.step(number * 1e-3)
    assert np.isfinite(model.potential.v.x.array).all()
    assert model.mechanics.activation.x.array.min() < -0.02


def test_a_run_goes_on_from_the_states_of_a_law():
    """state() and restore(): the next steps have the same bits."""

    def made():
        return line(ms.SecondOrder(), law=Delayed(), length=20.0, initial=gaussian)

    first, second = made(), made()
    first.start()
    for number in range(1, 4):
        first.step(number * 1e-3)
    second.start()
    second.restore(first.state())
    for model in (first, second):
        for number in range(4, 7):
            model.step(number * 1e-3)
    assert np.abs(first.activation.states).max() > 1e-3
    np.testing.assert_array_equal(second.activation.states, first.activation.states)
    np.testing.assert_array_equal(second.mechanics.u.x.array, first.mechanics.u.x.array)
    assert coordinates(first.potential).shape == (21, 1)


class Writing(Delayed):
    """The same law; it writes in what it gets."""

    def advance(self, states, drivers, step):
        v = drivers["potential"]
        v *= -0.3
        rates = np.array([v - states[0], states[0] - states[1]])
        states += step * rates
        return states

    def activation(self, states, drivers):
        drivers["potential"][:] = np.nan
        states[0] = np.nan
        return states[1]


@pytest.mark.parametrize("scheme", [ms.SecondOrder(), ms.Staggered()], ids=str)
def test_a_law_may_write_in_what_it_gets(scheme):
    """LawWithStates.advance: it gets copies, so that `states += ...` spoils nothing."""
    found = []
    for law in (Delayed(), Writing()):
        model = line(scheme, law=law, length=5.0)
        model.start()
        for number in range(1, 4):
            model.step(number * 1e-3)
        found.append((model.activation.states, model.activation.values, model.potential.v.x.array))
    assert np.abs(found[0][0]).max() > 1e-4
    for plain, written in zip(*found, strict=True):
        np.testing.assert_array_equal(written, plain)


# How strongly a law follows the potential: measured.


class Placed:
    """γ = −β v with a β for each node, and a factor that the stretch gives: arrays of the nodes in a law."""

    drivers = ("potential", "stretch")

    def __init__(self, beta):
        self.beta = beta

    def activation(self, states, drivers):
        return -self.beta * drivers["potential"] * drivers["stretch"]


class Mixed:
    """γ = −0.3 v w with a state w that has its own time: what follows v at once in it is measured too."""

    drivers, states = ("potential",), ("w",)

    def __init__(self, w=1.0, time=1.0, size=0.3):
        self.w, self.time, self.size = w, time, size

    def initial_states(self, drivers):
        return (self.w,)

    def advance(self, states, drivers, step):
        return 1 + (states - 1) * np.exp(-step / self.time)

    def activation(self, states, drivers):
        return -self.size * drivers["potential"] * states[0]


def strength(beta):
    """β v/(1 − β v) at v = 1."""
    return beta / (1 - beta)


def test_the_feedback_is_measured_at_the_nodes():
    """check_well_posed: the worst node counts, with the other drivers and states as they are."""
    beta = np.linspace(0.1, 0.45, 6)
    model = line(law=Placed(beta), length=5.0)
    assert model.feedback == pytest.approx(strength(0.45), rel=1e-9)
    with pytest.raises(ms.InputError, match="ill-posed"):
        line(law=Placed(beta + 0.06), length=5.0)
    model = line(law=Mixed(w=0.5), length=5.0)
    model.start()
    assert model.feedback == pytest.approx(strength(0.15), rel=1e-9)
    with pytest.raises(ms.InputError, match="ill-posed"):
        line(law=Mixed(w=2.0), length=5.0).start()


def test_the_feedback_counts_the_potential_from_rest():
    """check_well_posed, "v counted from rest": β < 1/2 is the bound with a membrane in millivolts, too."""

    def made(beta):
        membrane = ms.membranes.BuenoOrovio2008()
        law = Proportional(beta=beta)
        return line(law=law, membrane=membrane, length=5.0, initial=lambda X: np.full_like(X, -84.0))

    assert made(0.45).feedback == pytest.approx(strength(0.45), rel=1e-9)
    with pytest.raises(ms.InputError, match="ill-posed"):
        made(0.51)


@pytest.mark.parametrize("scheme", [ms.Staggered(), ms.SecondOrder()], ids=lambda s: type(s).__name__)
def test_the_feedback_within_a_step_is_measured(scheme):
    """over_a_step: of β, what the state takes over in a step; with drivers at its middle half of the change.

    A law that is fast beside the step is iterated as one that follows at once.
    """
    for rise, step in ((1e-2, 1e-3), (1e-2, 4e-3), (1e-6, 1e-3)):
        law = Relaxing(beta=0.4, rise=rise, fall=rise)
        model = line(scheme, law=law, length=5.0, initial=lambda X: 0 * X)
        model.start()
        assert model.feedback == 0.0
        model.step(step)
        taken = 0.4 * (1 - np.exp(-step / rise)) / scheme.order
        assert model.feedback == pytest.approx(strength(taken), rel=1e-6)
    assert line(law=Relaxing(beta=0.6), length=5.0, balance="advective").feedback == 0.0


def test_a_fast_law_is_iterated_and_says_so_to_mechanics_every_few_steps():
    """Electromechanics: where J follows strongly within a step, mechanics every few steps is refused."""
    law = Relaxing(beta=0.45, rise=1e-6, fall=1e-6)
    model = line(ms.Staggered(), law=law, length=5.0)
    model.start()
    model.step(1e-3)
    assert model.feedback > 0.66
    fast = Mixed(w=1.0, size=0.42)
    iterated = line(ms.SecondOrder(), law=fast, length=5.0)
    iterated.start()
    iterated.step(1e-3)
    assert iterated.coupling_iterations > 1
    with pytest.raises(ms.InputError, match="J follows the potential so strongly") as caught:
        line(ms.SecondOrder(every=2), law=fast, length=5.0).start()
    assert caught.value.key == "mechanics.every"


@pytest.mark.parametrize(
    "given",
    [
        lambda d: function(d) * d["time"],
        lambda d: np.ones(6) * function(d),
        lambda d: function(d) * np.ones(6),
        lambda d: [[function(d)] * 6],
        lambda d: np.where(np.ones(6) > 0, function(d), 0.0),
        lambda d: fem.Constant(function(d).function_space.mesh, 1.0),
        lambda d: np.sum(np.ones(6) * symbolic(d)),
    ],
)
def test_nothing_of_ufl_makes_a_start_hang(given):
    """ "no evaluation of a user's law that can hang": UFL in arrays, lists, products is refused at once."""
    with pytest.raises(ms.InputError, match=r"of UFL.*in NumPy|no array of real numbers"):
        line(law=Law(("time",), given), length=5.0).start()
