"""Descriptions in a script: one message of our own, with class, parameter and what is allowed."""

import traceback

import myostrain as ms

import pytest

BALL = ms.Place(center=(0.0,), radius=1.0)
WRONG = {
    "negative": (
        lambda: ms.Stimulus(where=BALL, strength=1.0, duration=-1.0),
        "Stimulus.duration: .*greater than 0",
    ),
    "missing": (lambda: ms.Stimulus(strength=1.0, duration=1.0), "Stimulus.where: missing"),
    "size": (ms.geometry.Rectangle, "Rectangle.size: missing; give a list of 2 numbers > 0"),
    "misspelt and so missing": (
        lambda: ms.Stimulus(where=BALL, strenght=1.0, duration=1.0),
        "Stimulus.strenght: no such parameter; did you mean 'strength'",
    ),
    "capitals": (lambda: ms.membranes.BuenoOrovio2008(set="endo"), "did you mean 'ENDO'"),
    "misspelt": (lambda: ms.activation.Proportional(bta=0.3), "Proportional.bta: .*did you mean 'beta'"),
    "together": (lambda: ms.Place(center=(0.0,), radius=1.0, boundary=("a",)), "Place: give one of"),
    "nothing": (lambda: ms.InitialValues(where=BALL), "InitialValues: give potential, or states"),
    "text": (lambda: ms.materials.NeoHookean(mu="1"), "NeoHookean.mu: give a number, not '1'"),
    "callback": (lambda: ms.Callback(print, every=0.0), "Callback.every: give a positive time"),
    "not callable": (lambda: ms.Callback(3), "Callback.call: give a function"),
}


@pytest.mark.parametrize("make, message", WRONG.values(), ids=WRONG.keys())
def test_wrong_values_are_one_message(make, message):
    """A script's objects get the care of a case file: InputError, and no word of the library that checks."""
    with pytest.raises(ms.InputError, match=message) as caught:
        make()
    assert "pydantic" not in str(caught.value)
    assert "ArgsKwargs" not in str(caught.value)


def test_objects_in_the_wrong_place():
    """A word, a class, points without names, two that were mixed up: what to give is said."""
    body = ms.build(ms.geometry.Line(length=4.0))
    potential = ms.Potential(body, membrane=ms.membranes.FitzHughNagumo())
    mechanics = ms.Mechanics(body, kinematics=ms.kinematics.Line(), material=ms.materials.Spring())
    model = ms.Electromechanics(potential)
    for message, wrong in {
        r"geometry: 'pulse-1d': give an object, such as ms\.geometry\.Line": lambda: ms.build("pulse-1d"),
        r"geometry: <class .*: give an object, such": lambda: ms.build(ms.geometry.Line),
        r"potential: .*before the mechanics": lambda: ms.Electromechanics(mechanics, potential),
        r"mechanics: .*such as ms\.Mechanics": lambda: ms.Electromechanics(potential, potential),
        r"time\.scheme: 'implicit': give an": lambda: ms.Electromechanics(potential, scheme="implicit"),
        r"probes: \[\(1\.0,\)\]: .* by name": lambda: ms.Simulation(
            model, step=0.1, end=1.0, probes=[(1.0,)]
        ),
        r"probes\.a: 1\.0: give a finite": lambda: ms.Simulation(model, step=0.1, end=1.0, probes={"a": 1.0}),
        r"'pulse-1d' is a named case, no file": lambda: ms.Case.from_file("pulse-1d"),
    }.items():
        with pytest.raises(ms.InputError, match=message):
            wrong()


def test_a_misspelt_name_of_the_package_is_known_to_python():
    """It names the nearest where it shows the error."""
    with pytest.raises(AttributeError) as caught:
        ms.Simulaton  # noqa: B018
    assert "Did you mean: 'Simulation'?" in "".join(traceback.format_exception(caught.value))


def test_a_potential_without_a_membrane():
    """The keyword of earlier versions is named, and so is what is missing."""
    body = ms.build(ms.geometry.Line(length=2.0))
    with pytest.raises(ms.InputError, match="Potential takes no 'cell' any more: it is called membrane"):
        ms.Potential(body, cell=ms.membranes.FitzHughNagumo())
    with pytest.raises(ms.InputError, match="give a membrane"):
        ms.Potential(body)


SHOCK = ms.Stimulus(where=BALL, strength=1.0, duration=1.0)
NO_LISTS = {
    "not a list": ({"stimuli": SHOCK}, r"stimuli: give a list, \[Stimulus\(...\)\], also of one"),
    "a table": ({"stimuli": [{"center": [0.0]}]}, "stimuli: {'center': .* is no Stimulus: it has no share"),
    "a class": ({"stimuli": [ms.Stimulus]}, "is no Stimulus: it is a class"),
    "of another kind": ({"initial": [SHOCK]}, "initial: .* is no InitialValues: it has no apply"),
    "variations": ({"variations": {"g": 1.0}}, "variations: .* is no Variation"),
    "a word": ({"stretch_currents": "fibre"}, "stretch_currents: 'fibre' is no StretchCurrent"),
}


@pytest.mark.parametrize("given, message", NO_LISTS.values(), ids=NO_LISTS.keys())
def test_what_is_no_list_of_descriptions(given, message):
    """One message that says what to give, not that an object has no attribute."""
    body = ms.build(ms.geometry.Line(length=2.0))
    with pytest.raises(ms.InputError, match=message):
        ms.Potential(body, membrane=ms.membranes.FitzHughNagumo(), **given)


def test_an_unknown_keyword_names_the_nearest():
    """TypeError, as Python has it, with what may have been meant."""
    body = ms.build(ms.geometry.Line(length=2.0))
    with pytest.raises(TypeError, match="Potential takes no 'diffusivty'; did you mean 'diffusivity'"):
        ms.Potential(body, diffusivty=1.0)
