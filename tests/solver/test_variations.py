"""Parameters of the membrane that differ between places: each node is the cell that its parameters make."""

import dataclasses

import myostrain as ms
from myostrain.membranes.reaction import Reaction, Step
from myostrain.membranes.variants import variant
from myostrain.pointwise import compiler

import numpy as np
import pytest

from coupled import coordinates
from membrane_tools import last_beat

#: So little that the sum with anything is that; and a solver that then only divides.
ALONE = {"diffusivity": 1e-200, "options": {"ksp_type": "preonly", "pc_type": "lu"}}
RIGHT = ms.Place(box=((6.5,), (20.0,)))
PLACE = ms.Place(box=((-1.0,), (20.0,)))
KICK = ms.Stimulus(where=PLACE, strength=40.0, duration=2.0)

LR = ms.membranes.LuoRudy1991


def body(length=12.0):
    return ms.build(ms.geometry.Line(length=length, spacing=1.0))


def end(membrane, variations=(), *, step=0.05, steps=60, scheme=None):
    """Coordinates, potential and states (1 + states, nodes) at the end of some steps."""
    potential = ms.Potential(body(), membrane=membrane, variations=variations, stimuli=[KICK], **ALONE)
    model = ms.Electromechanics(potential, scheme=scheme)
    model.start()
    for number in range(1, steps + 1):
        model.step(number * step)
    return coordinates(potential)[:, 0], np.array(list(potential.field_values().values()))


@pytest.fixture
def without_compiler(monkeypatch):
    monkeypatch.setenv(compiler.SWITCH, "1")
    compiler.compiler.cache_clear()
    yield
    monkeypatch.undo()
    compiler.compiler.cache_clear()


TTP, BO, FK = (
    ms.membranes.TenTusscherPanfilov2006,
    ms.membranes.BuenoOrovio2008,
    ms.membranes.FentonKarma1998,
)
#: A membrane, a variation of it without a place, and the membrane that it makes.
HALVES = {
    "a set": (BO(), {"set": "M"}, BO(set="M")),
    "a set and more": (
        BO(tau_si=2.0),
        {"set": "ENDO", "parameters": {"tau_w1m": 9.0}},
        BO(set="ENDO", tau_w1m=9.0),
    ),
    "a set keeps what is none of its own, and factors": (
        TTP(g_Na=9.0),
        {"set": "ENDO", "parameters": {"slope": 1.8, "g_Ks": 0.2}},
        TTP(set="ENDO", slope=1.8, g_Na=9.0, g_Ks=0.2),
    ),
    "an equilibrium": (LR(), {"parameters": {"Ko": 8.0, "g_si": 0.05}}, LR(Ko=8.0, g_si=0.05)),
    "another equilibrium": (FK(), {"set": "Set 3"}, FK(set="Set 3")),
    "two states": (
        ms.membranes.FitzHughNagumo(),
        {"parameters": {"alpha": 0.2}},
        ms.membranes.FitzHughNagumo(alpha=0.2),
    ),
}


@pytest.mark.parametrize("name", HALVES)
def test_halves_are_the_uniform_bodies(name, request):
    """Bit by bit: potential and all states, in an upstroke, of each half."""
    if name.startswith("an"):  # the others are compiled
        request.getfixturevalue("without_compiler")
    membrane, said, other = HALVES[name]
    X, both = end(membrane, [ms.Variation(where=RIGHT, **said)])
    right = X > 6.5
    assert 0 < right.sum() < len(X)
    _, here = end(membrane)
    _, there = end(other)
    assert (np.abs(here - there).max(axis=0) > 0).all()  # they are not alike
    np.testing.assert_array_equal(both, np.where(right, there, here))


@pytest.mark.parametrize(
    "cell, others",
    [(TTP, ("ENDO", "M")), (ms.membranes.ToRORd2019, ("EPI",)), (LR, None)],
    ids=lambda x: getattr(x, "__name__", ""),
)
def test_without_a_compiler_too(cell, others, without_compiler):
    """The interpreted formulas with what varies are those of each node's own cell, flags included."""
    members = [cell(), *(cell(set=o) for o in others)] if others else [cell(), cell(Ko=8.0), cell(g_K1=0.5)]
    states = np.array([m.resting_states() for m in members]).T
    v = np.array([m.resting_potential() for m in members]) + 15.0
    names = [
        n
        for n, x in vars(members[0]).items()
        if isinstance(x, bool | float) and len({getattr(m, n) for m in members}) > 1
    ]
    varying = {n: np.array([float(getattr(m, n)) for m in members]) for n in names}

    def solved(reaction, at):
        step = Step(0.05, 20.0, states[:, at], states[:, at].copy(), v[at] - 5.0, 2)
        return reaction.solve(v[at], states[:, at].copy(), step)

    together = Reaction(members[0], varying=varying)
    found = solved(together, slice(None))
    assert not together.compiled
    assert found[3] == -1
    for n, member in enumerate(members):
        alone = solved(Reaction(member), slice(n, n + 1))
        for whole, one in zip(found[:3], alone[:3], strict=True):
            np.testing.assert_array_equal(np.atleast_2d(whole)[:, n : n + 1], np.atleast_2d(one))


def test_compiled_or_not(request):
    """The compiled formulas with what varies agree with NumPy's."""
    said = [ms.Variation(where=RIGHT, set="ENDO")]
    _, compiled = end(TTP(), said)
    request.getfixturevalue("without_compiler")
    _, interpreted = end(TTP(), said)
    np.testing.assert_allclose(compiled, interpreted, rtol=1e-9, atol=1e-12)


def test_a_number_that_makes_the_numbers_those_of_another_set():
    """M differs from EPI by this one only; it is given on purpose, unlike all those of a resolved case."""
    made = variant(TTP(), {"g_Ks": 0.098}, "cell.variation")
    assert (made.set, made.g_Ks, made.g_to) == ("EPI", 0.098, TTP().g_to)
    assert variant(TTP(g_Ks=0.5), {"g_to": 0.1}, "cell.variation").g_Ks == 0.5


def test_later_ones_win_parameter_by_parameter():
    """Three that overlap: of each parameter the last one counts."""
    names = ("tau_si", "tau_w1m", "tau_fi")
    said = [
        ms.Variation(where=ms.Place(box=((2.5,), (9.5,))), set="M"),
        ms.Variation(where=ms.Place(box=((5.5,), (20.0,))), parameters={"tau_si": 5.0}),
        ms.Variation(where=ms.Place(center=(9.0,), radius=1.2), parameters={"tau_w1m": 5.0, "tau_si": 6.0}),
    ]
    potential = ms.Potential(body(), membrane=BO(), variations=said)
    X = coordinates(potential)[:, 0]
    epi, m = BO(), BO(set="M")
    within = (X > 2.5) & (X < 9.5)
    ball = np.abs(X - 9) < 1.2
    wanted = {
        "tau_si": np.where(ball, 6.0, np.where(X > 5.5, 5.0, np.where(within, m.tau_si, epi.tau_si))),
        "tau_w1m": np.where(ball, 5.0, np.where(within, m.tau_w1m, epi.tau_w1m)),
        "tau_fi": np.where(within, m.tau_fi, epi.tau_fi),
    }
    for name in names:
        np.testing.assert_array_equal(potential.varying[name], wanted[name])
    assert "k_s" not in potential.varying  # the same in all sets


def test_durations_are_those_of_single_cells():
    """APD90 of two layers that are not coupled, beside SciPy's of each cell."""
    members = [BO(), BO(set="ENDO")]
    potential = ms.Potential(
        body(),
        membrane=members[0],
        variations=[ms.Variation(where=RIGHT, set="ENDO")],
        stimuli=[dataclasses.replace(KICK, strength=BO.pacing[0], duration=BO.pacing[1])],
        **ALONE,
    )
    model = ms.Electromechanics(potential)
    model.start()
    X, v = coordinates(potential)[:, 0], []
    times = np.concatenate([np.arange(1, 101) * 0.1, np.arange(21, 600) * 0.5])
    for time in times:
        model.step(time)
        v.append(potential.v.x.array[[np.argmin(X), np.argmax(X)]])
    wanted = [last_beat(m, 400.0, 1, method="LSODA").crossing_apd for m in members]
    assert abs(wanted[0] - wanted[1]) > 4
    for wave, member, apd in zip(np.array(v).T, members, wanted, strict=True):
        level = wave.max() - 0.9 * (wave.max() - member.resting_potential())
        up = int(np.argmax(wave > member.threshold))
        top = int(np.argmax(wave))
        down = top + int(np.argmax(wave[top:] < level))
        crossings = [
            np.interp(at, wave[[i - 1, i]][:: 1 if rises else -1], times[[i - 1, i]][:: 1 if rises else -1])
            for at, i, rises in ((member.threshold, up, True), (level, down, False))
        ]
        assert crossings[1] - crossings[0] == pytest.approx(apd, abs=0.5)


LAYERS = [
    ms.Variation(where=ms.Place(box=((-1.0,), (4.5,))), set="ENDO"),
    ms.Variation(where=ms.Place(box=((4.5,), (8.5,))), set="M"),
]


def test_rests_that_differ_excite_nothing():
    """Each node begins at its own cell's rest; nothing contracts there, and no wave leaves a border."""
    potential = ms.Potential(body(), membrane=TTP(), diffusivity=0.15, variations=LAYERS)
    X, v = coordinates(potential)[:, 0], potential.v.x.array
    cells = [TTP(set=word) for word in ("ENDO", "M", "EPI")]
    rests = np.select(
        [X < 4.5, X < 8.5], [c.resting_potential() for c in cells[:2]], cells[2].resting_potential()
    )
    np.testing.assert_array_equal(v, rests)
    np.testing.assert_array_equal(potential.local_rest, rests)
    np.testing.assert_array_equal(potential.excitation, 0.0)
    np.testing.assert_array_equal(potential.states[3][X > 8.5], cells[2].resting_states()[3])
    model = ms.Electromechanics(potential)
    model.start()
    for step in range(1, 101):
        model.step(0.2 * step)
        assert v.max() < -84.0


def test_an_equilibrium_stays_where_it_is_alone():
    """A rest that follows from the parameters is that of the local ones: nothing moves."""
    said = [ms.Variation(where=RIGHT, parameters={"Ko": 8.0})]
    potential = ms.Potential(body(), membrane=LR(), variations=said, **ALONE)
    before = np.array(list(potential.field_values().values()))
    assert before[0].max() - before[0].min() > 5
    model = ms.Electromechanics(potential)
    model.start()
    for step in range(1, 21):
        model.step(0.5 * step)
    np.testing.assert_allclose(list(potential.field_values().values()), before, rtol=1e-9)


def test_between_the_nodes_too():
    """A membrane that acts between the nodes has the parameters there: varied everywhere, it is that cell."""
    start = ms.InitialValues(where=ms.Place(center=(0.0,), radius=1.5), potential=0.0)
    kept = {"diffusivity": 0.3, "reaction": "interpolated", "initial": [start]}
    bodies = [
        ms.Potential(body(), membrane=BO(), variations=[ms.Variation(where=PLACE, set="M")], **kept),
        ms.Potential(body(), membrane=BO(set="M"), **kept),
    ]
    found = []
    for potential in bodies:
        model = ms.Electromechanics(potential)
        model.start()
        for step in range(1, 21):
            model.step(0.1 * step)
        found.append(np.array(list(potential.field_values().values())))
    np.testing.assert_allclose(*found, rtol=1e-12)  # a mean of two equal numbers is that but for round-off


def deforming(variations):
    line = body()
    mechanics = ms.Mechanics(
        line,
        kinematics=ms.kinematics.Line(),
        material=ms.materials.Spring(),
        supports=ms.Supports(fixed=["left"]),
    )
    potential = ms.Potential(
        line, membrane=TTP(), variations=variations, diffusivity=1e-3, deformation=mechanics.deformation
    )
    return ms.Electromechanics(potential, mechanics, law=ms.activation.Proportional(beta=0.3))


def test_no_layer_contracts_at_rest():
    """On a deforming body: γ counts from the rest of each node, and what J balances does so too."""
    model = deforming(LAYERS)
    model.start()
    for step in range(1, 4):
        model.step(0.02 * step)
    # The published initial states are no equilibrium: they drift, by far less than the rests differ.
    assert np.abs(model.activation.values).max() < 0.3 * 0.1 / 130
    assert abs(model.potential.amount()) < 0.1 * 12


def test_values_at_the_nodes():
    """Arrays of a script vary within a place, and give way to later numbers."""
    sheet = ms.build(
        ms.geometry.Rectangle(size=(4.0, 2.0), spacing=1.0), ms.UniformFibres(direction=(1.0, 0.0))
    )
    g_Ks = ms.geometry.transmural(sheet, (0.4, 0.1), ("left", "right"))
    said = [
        ms.Variation(where=ms.Place(box=((-1.0, -1.0), (5.0, 5.0))), parameters={"g_Ks": g_Ks}),
        ms.Variation(where=ms.Place(transmural=(0.5, 1.0), transmural_between=("left", "right")), set="M"),
    ]
    potential = ms.Potential(sheet, membrane=TTP(), variations=said)
    x = coordinates(potential)[:, 0]
    np.testing.assert_allclose(
        potential.varying["g_Ks"], np.where(x > 1.9, 0.098, 0.4 - 0.075 * x), rtol=1e-9
    )


class Mine:
    """No dataclass; decides by NumPy."""

    states = ("w",)

    def __init__(self):
        self.a, self.steep = 0.1, 2

    def resting_potential(self):
        return 0.0

    def resting_states(self):
        return (0.0,)

    def current(self, v, states):
        return np.where(np.real(v) < self.a, 1.0, self.steep) * v + states[0]

    def rates(self, v, states):
        return (v - states[0],)


class Decides(Mine):
    """Asks for one number."""

    def current(self, v, states):
        return (v if self.a > 0.05 else -v) + states[0]


class Opaque(Mine):
    """Of which no formula can be written down."""

    def current(self, v, states):
        return self.a * np.nan_to_num(v) + states[0]


@pytest.mark.parametrize("cell", [Mine, Opaque])
def test_a_membrane_of_a_script(cell):
    """A class of one's own varies as those that ship do, with formulas or by NumPy alone."""
    X, both = end(cell(), [ms.Variation(where=RIGHT, parameters={"a": 0.3, "steep": 5})], steps=3)
    there = cell()
    there.a, there.steep = 0.3, 5
    np.testing.assert_array_equal(both, np.where(X > 6.5, end(there, steps=3)[1], end(cell(), steps=3)[1]))


WRONG = {
    "unknown": (BO(), {"parameters": {"tau_q": 1.0}}, r"cell.variation.1.tau_q: .*did you mean 'tau_"),
    "a set": (BO(), {"set": "MID"}, r"cell.variation.1.set: 'MID' is not a set of BuenoOrovio2008; .*EPI"),
    "no sets": (LR(), {"set": "EPI"}, r"cell.variation.1.set: LuoRudy1991 has no sets"),
    "a slope": (TTP(), {"parameters": {"slope": 1.2}}, r"1.slope: 1.2 is not a slope .* 0.7, 1.1, 1.4, 1.8"),
    "the set": (BO(), {"parameters": {"set": "M"}}, r"1.set: give set by itself"),
    "a word": (BO(), {"parameters": {"time_unit": "s"}}, r"1.time_unit: this is 'ms', no number"),
    "states": (
        ms.membranes.FitzHughNagumo(),
        {"parameters": {"recovery": False}},
        "1.recovery: .*which states",
    ),
    "negative": (BO(), {"parameters": {"tau_si": -1.0}}, r"1.tau_si: .*greater than 0, not -1"),
    "a text": (BO(), {"parameters": {"tau_si": "long"}}, r"1.tau_si: .*number, not 'long'"),
    "infinite": (Mine(), {"parameters": {"a": np.inf}}, r"1.a: give a finite number"),
    "a rest above the threshold": (BO(), {"parameters": {"u0": 0.5}}, r"1.u0: the membrane rests there"),
    "another length": (BO(), {"parameters": {"tau_si": np.ones(5)}}, r"1.tau_si: .*array of 13 .*\(5,\)"),
    "NaN": (BO(), {"parameters": {"tau_si": np.full(13, np.nan)}}, r"1.tau_si: .*13 finite"),
    "an array below zero": (
        BO(),
        {"parameters": {"tau_si": np.linspace(-1, 2, 13)}},
        "1.tau_si: .*greater than 0",
    ),
    "the rest of an array": (
        LR(),
        {"parameters": {"Ko": np.linspace(5, 8, 13)}},
        "variation.1: the rest .* on one of Ko",
    ),
    "a decision": (Decides(), {"parameters": {"a": 0.3}}, "cell.variation: a vary.*Decides wants one number"),
    "nothing": (BO(), {}, 'give parameters of the membrane, or set = "..."'),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_cannot_vary(name):
    """Each is refused before the first step, with its key."""
    membrane, said, words = WRONG[name]
    with pytest.raises(ms.InputError, match=words):
        ms.Potential(body(), membrane=membrane, variations=[ms.Variation(where=PLACE, **said)])


@pytest.mark.parametrize(
    "place, words",
    [
        ({"box": ((30.0,), (31.0,))}, "cell.variation.2.box: no node"),
        ({"region": ("scar",)}, "cell.variation.2.region: no region is called 'scar'"),
        ({"transmural": (0.0, 0.5)}, "cell.variation.2.transmural_between: name the two sides of the wall"),
        ({"transmural": (0.0, 0.5), "transmural_between": ("left", "lft")}, "2.transmural_between: .*'left'"),
    ],
)
def test_places_that_are_not_there(place, words):
    """Those of the second variation, say."""
    said = [ms.Variation(where=PLACE, set="M"), ms.Variation(where=ms.Place(**place), set="ENDO")]
    with pytest.raises(ms.InputError, match=words):
        ms.Potential(body(), membrane=BO(), variations=said)


@pytest.mark.parametrize(
    "wrong, words",
    [
        ({"transmural": (0.5, 0.2)}, "from a lower depth to a higher one"),
        ({"transmural": (0.0, 1.5)}, "between 0 and 1"),
        ({"transmural": (0.0, 0.5), "radius": 1.0}, "give one of .* not .*transmural"),
        ({"box": ((0.0,), (1.0,)), "transmural_between": ("left", "right")}, "goes with transmural"),
    ],
)
def test_layers_that_are_none(wrong, words):
    """Depths lie between 0 and 1."""
    with pytest.raises(ms.InputError, match=words):
        ms.Place(**wrong)


def test_a_node_is_in_or_out():
    """Means over what surrounds a node are refused."""
    mean = ms.Place(center=(1.0,), radius=1.0, sampling="mean")
    with pytest.raises(ms.InputError, match="one set of parameters"):
        ms.Variation(where=mean, set="M")
