"""[initial], [[initial]], [stimulus] and [[stimulus]] of case files."""

import tomllib

import myostrain as ms
from myostrain import Case, InputError
from myostrain.activation import Relaxing
from myostrain.case import building

import numpy as np
import pytest

from coupled import coordinates
from small_cases import ALONE, LINE, REMOVED, changed

TWO = [
    {"potential": 0.9, "center": [0.0], "radius": 5.0},
    {"states": {"recovery": 0.1}, "potential": 0.2, "box": [[3.0], [8.0]]},
]
PULSES = [
    {"strength": 50.0, "duration": 2e-3, "boundary": ["right"], "depth": 3.0},
    {
        "strength": 10.0,
        "duration": 1e-3,
        "start": 1e-3,
        "period": 4e-3,
        "count": 2,
        "center": [9.0],
        "radius": 1.0,
    },
]


def again(case):
    return Case.from_dict(tomllib.loads(case.to_toml()), name=case.name)


def test_several_places_to_begin():
    """[[initial]]: later ones win; the resolved case reads back the same."""
    case = Case.from_dict(changed(LINE, {"initial": TWO}))
    assert case.initial == (
        ms.InitialValues(where=ms.Place(center=(0.0,), radius=5.0), potential=0.9),
        ms.InitialValues(where=ms.Place(box=((3.0,), (8.0,))), potential=0.2, states={"recovery": 0.1}),
    )
    assert again(case) == case
    potential = case.build(ALONE).potential
    X = coordinates(potential)[:, 0]
    second = (X >= 3 - 1e-9) & (X <= 8 + 1e-9)
    v, w = potential.field_values().values()
    np.testing.assert_array_equal(v, np.where(second, 0.2, np.where(X <= 5, 0.9, 0.0)))
    np.testing.assert_array_equal(w, np.where(second, 0.1, 0.0))


@pytest.mark.parametrize("initial", [REMOVED, LINE["initial"]], ids=["without [initial]", "with"])
def test_stimuli_in_place_of_initial_values(initial):
    """[[stimulus]] excites a body at rest; with an initial potential besides, too."""
    case = Case.from_dict(changed(LINE, {"initial": initial, "stimulus": PULSES}))
    assert again(case) == case
    assert case.stimuli == (
        ms.Stimulus(where=ms.Place(boundary=("right",), depth=3.0), strength=50.0, duration=2e-3),
        ms.Stimulus(
            where=ms.Place(center=(9.0,), radius=1.0),
            strength=10.0,
            start=1e-3,
            duration=1e-3,
            period=4e-3,
            count=2,
        ),
    )
    simulation = case.simulation(ALONE)
    simulation.run()
    potential = simulation.model.potential
    X = coordinates(potential)[:, 0]
    assert 0.05 < potential.v.x.array[np.argmax(X)] < 1.0


def test_one_of_each_is_a_section():
    """One of a kind may be a section by itself, and is one in the resolved case."""
    one = Case.from_dict(changed(LINE, {"stimulus": PULSES[0]}))
    listed = Case.from_dict(changed(LINE, {"stimulus": PULSES[:1], "initial": [LINE["initial"]]}))
    assert one == listed
    assert isinstance(one.parameters["stimulus"], dict)
    assert isinstance(one.parameters["initial"], dict)
    both = Case.from_dict(changed(LINE, {"stimulus": PULSES}))
    assert len(both.parameters["stimulus"]) == 2


WRONG = [
    ({"initial": REMOVED}, "initial", "nothing excites the body"),
    ({"initial": []}, "initial", "nothing excites the body"),
    ({"initial": 3}, "initial", "a section"),
    ({"initial": [3]}, "initial", "a section"),
    ({"initial": [TWO[0], TWO[1] | {"center": [1.0]}]}, "initial.2", "not center and radius and box"),
    (
        {"initial": [TWO[0], TWO[0] | {"radius": -1.0}]},
        "initial.2.radius",
        "than 0",
    ),
    ({"initial.potential": REMOVED}, "initial", "give potential, or states"),
    ({"initial.states": {"recovery": "much"}}, "initial.states.recovery", "number"),
    ({"initial.sampling": "mena"}, "initial.sampling", "'nodal' or 'mean'"),
    ({"stimulus": {"strength": 1.0, "center": [0.0], "radius": 1.0}}, "stimulus.duration", "missing"),
    ({"stimulus": PULSES[0] | {"durration": 1.0}}, "stimulus.durration", "'duration'"),
    ({"stimulus": PULSES[0] | {"count": 2}}, "stimulus", "several pulses need a period"),
    ({"stimulus": PULSES[0] | {"strength": "big"}}, "stimulus.strength", "number"),
    ({"stimulus": {"strength": 1.0, "duration": 1.0}}, "stimulus", "give one of center and radius"),
]


@pytest.mark.parametrize("changes, key, words", WRONG)
def test_wrong_places_in_a_case(changes, key, words):
    """InputError names the key, with its number where there are several, and what is allowed."""
    with pytest.raises(InputError) as caught:
        Case.from_dict(changed(LINE, changes))
    assert caught.value.key == key
    assert words in str(caught.value)
    assert "ArgsKwargs" not in str(caught.value)


WRONG_ON_THE_MESH = [
    ({"initial.states": {"recvery": 0.1}}, "initial.states", "'recovery'"),
    ({"stimulus": PULSES[0] | {"boundary": ["rihgt"]}}, "stimulus.boundary", "'right'"),
    (
        {"stimulus": {"strength": 1.0, "duration": 1.0, "center": [99.0], "radius": 1.0}},
        "stimulus.radius",
        "no node",
    ),
]


@pytest.mark.parametrize("changes, key, words", WRONG_ON_THE_MESH)
def test_wrong_places_on_the_mesh(changes, key, words):
    """What shows on the mesh only is refused before the first step."""
    with pytest.raises(InputError) as caught:
        Case.from_dict(changed(LINE, changes)).build(ALONE)
    assert caught.value.key == key
    assert words in str(caught.value)


def test_a_relaxing_law():
    """[activation] law = "relaxing": its keys, an active deformation beside it; β ≥ 1/2 is well-posed."""
    section = {"law": "relaxing", "beta": 0.6, "rise": 0.02, "fall": 0.1, "deformation": "fibre"}
    case = Case.from_dict(changed(LINE, {"activation": section}))
    assert case.law == Relaxing(beta=0.6, rise=0.02, fall=0.1)
    assert again(case) == case
    assert case.parameters["activation"] == section | {"threshold": 0.05}
    simulation = case.simulation(ALONE)
    simulation.run()
    assert -0.3 < simulation.model.mechanics.activation.x.array.min() < -0.1


def test_a_table_of_times_beside_the_case(tmp_path):
    """stimulus.times is relative to the case file, and one of the files with which a run is resumed."""
    table = tmp_path / "times.csv"
    table.write_text("x,time\n0,0.001\n12,0.003\n")
    given = {**PULSES[0], "times": "times.csv"}
    case = Case.from_dict(changed(LINE, {"stimulus": [given]}), folder=tmp_path)
    assert case.stimuli[0].times == table
    assert again(case) == case
    assert building._files(case)["stimulus.times"] == (table,)
    assert case.build(ALONE).potential.stimuli == case.stimuli
