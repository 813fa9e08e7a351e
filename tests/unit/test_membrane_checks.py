"""What is no membrane model is refused when the potential is made, with the reason."""

import myostrain as ms
from myostrain.membranes import Membrane, check_membrane

import numpy as np
import pytest


class Good:
    """Two states, one of them the calcium; in millivolts."""

    states = ("gate", "calcium")
    range = (-90.0, 40.0)
    threshold = -40.0
    calcium = "calcium"

    def resting_potential(self):
        return -85.0

    def resting_states(self):
        return (0.1, 1e-4)

    def current(self, v, states):
        # Comparisons and numpy.where are fine.
        return np.where(np.real(v) > self.threshold, 0.3, 0.1) * (v + 85.0) * np.tanh(states[0])

    def rates(self, v, states):
        return (np.exp(v / 40.0) - states[0], -states[1])


def changed(**attributes):
    """An object of a class like the good one, with other attributes; None removes one."""
    kept = {k: v for k, v in vars(Good).items() if k not in ("__dict__", "__weakref__")} | attributes
    return type("Mine", (), {k: v for k, v in kept.items() if v is not None})()


def without_states(**attributes):
    return changed(states=None, calcium=None, resting_states=None, rates=None, **attributes)


WRONG = {
    "a class": (Good, r"the class Good is not an object: give Good\(\)"),
    "no current": (changed(current=None), "Mine is not a membrane model: it has no method current"),
    "no resting potential": (changed(resting_potential=None), "no method resting_potential"),
    "no resting states": (changed(resting_states=None), "has states, but no method resting_states$"),
    "initial_states": (
        changed(resting_states=None, initial_states=lambda self: (0.1, 0.0)),
        r"resting_states \(initial_states of earlier versions\)",
    ),
    "no rates": (changed(rates=None), "has states, but no method rates"),
    "states in one text": (
        changed(states="r", calcium=None, resting_states=lambda self: (0.0,)),
        r"Mine\.states is 'r'; give a sequence of names",
    ),
    "a state twice": (changed(states=("calcium", "calcium")), "give each state a name of its own"),
    "a taken name": (changed(states=("potential", "calcium")), "'potential', which is the name of another"),
    "Python's if": (
        changed(current=lambda self, v, states: 0.0 * v if v > 0 else v),
        r"Mine\.current failed: ValueError: it decides by Python's if.* take numpy\.where",
    ),
    "one rate for two states": (
        changed(rates=lambda self, v, states: (v - states[0],)),
        r"rates gives 1 for the states \['gate', 'calcium'\]; give one each",
    ),
    "a rate by itself": (changed(rates=lambda self, v, states: 0.0), "rates gives one value for the states"),
    "a resting state too few": (changed(resting_states=lambda self: (0.1,)), "finite number for each"),
    "a resting state that is no number": (
        changed(resting_states=lambda self: (0.1, np.nan)),
        "finite number for each",
    ),
    "no resting number": (changed(resting_potential=lambda self: np.nan), "resting_potential gives nan"),
    "what cannot be traced": (
        without_states(current=lambda self, v, states: np.abs(np.nan_to_num(v + 40.0))),
        r"Mine\.current is not analytic",
    ),
    "abs in a rate": (
        changed(rates=lambda self, v, states: (v - states[0], abs(np.nan_to_num(v)) - states[1])),
        r"Mine\.rates\[1\] is not analytic",
    ),
    "a list": (
        without_states(current=lambda self, v, states: list(v + 85.0)),
        r"Mine\.current gives a list; give an array",
    ),
    "what mixes nodes": (
        without_states(current=lambda self, v, states: v - np.mean(v)),
        r"Mine\.current of a node changes with the other nodes",
    ),
    "writing into what it is given": (
        changed(rates=lambda self, v, states: (states[0].__iadd__(1.0), v)),
        r"Mine\.rates failed: ValueError",
    ),
    "a unit by number": (changed(time_unit=3), r'Mine\.time_unit is 3; give a text, such as "ms"'),
    "a time in parsec": (
        changed(time_unit="parsec"),
        r"""Mine\.time_unit is 'parsec'; a membrane counts time in "ms", in "s", or has None""",
    ),
    "a stimulus in a word": (changed(pacing="strong"), r"Mine\.pacing is 'strong'; give strength"),
    "a stimulus without end": (changed(pacing=(1.0,)), r"Mine\.pacing is \(1\.0,\); give strength"),
    "another shape": (
        without_states(current=lambda self, v, states: np.zeros(3)),
        r"values of shape \(3,\) for 7 nodes; give one a node",
    ),
    "an error of its own": (
        changed(current=lambda self, v, states: states[2] * v),
        r"Mine\.current failed: IndexError",
    ),
    "a range that is none": (changed(range=(1.0, 0.0)), r"Mine\.range is \(1\.0, 0\.0\)"),
    "a threshold out of range": (changed(threshold=50.0), r"Mine\.threshold is 50\.0"),
    "no range": (
        changed(range=None, threshold=None, current=lambda self, v, states: v + 85.0),
        r"Mine rests at -85, far out of its range \(0\.0, 1\.0\): declare the range",
    ),
    "a range in a word": (changed(range="wide"), r"Mine\.range is 'wide'"),
    "a threshold in a word": (changed(threshold="high"), r"Mine\.threshold is 'high'"),
    "gates by number": (changed(gates=3), r"Mine\.gates is 3; give names"),
    "no current back": (
        changed(current=lambda self, v, states: None),
        r"Mine\.current gives None; give a num",
    ),
    "truth for current": (
        changed(current=lambda self, v, states: v > 0),
        r"Mine\.current gives array\(\[False",
    ),
    "no rate back": (
        changed(rates=lambda self, v, states: (None, -states[1])),
        r"Mine\.rates\[0\] gives None",
    ),
    "rates by name": (
        changed(rates=lambda self, v, states: {"gate": v, "calcium": v}),
        r"Mine\.rates gives a dict; give a sequence",
    ),
    "rates by node": (
        changed(rates=lambda self, v, states: np.zeros((7, 2))),
        "rates gives 7 for the states",
    ),
    "a rate of another length": (
        changed(rates=lambda self, v, states: (np.zeros(3), -states[1])),
        r"Mine\.rates\[0\] gives values of shape \(3,\) for 7 nodes",
    ),
    "a column": (changed(current=lambda self, v, states: np.zeros((7, 1))), r"shape \(7, 1\) for 7 nodes"),
    "one state by itself": (
        changed(resting_states=lambda self: 0.1),
        r"resting_states gives 0\.1; give a finite",
    ),
    "a resting state in a word": (
        changed(resting_states=lambda self: ("open", 0.1)),
        r"resting_states gives \('open', 0\.1\)",
    ),
    "no resting potential back": (
        changed(resting_potential=lambda self: None),
        "resting_potential gives None",
    ),
    "infinite": (
        changed(rates=lambda self, v, states: (v * np.inf, -states[1])),
        r"Mine\.rates\[0\] is nowhere finite",
    ),
    "a division by zero": (changed(current=lambda self, v, states: 1 / 0), "failed: ZeroDivisionError"),
    "an unknown name": (changed(current=lambda self, v, states: missing * v), "failed: NameError"),  # noqa: F821
    "other arguments": (changed(current=lambda self, v: v), "Mine.current failed: TypeError"),
    "an unknown calcium": (changed(calcium="Cai"), r"calcium is 'Cai', which is none of its states"),
}


@pytest.mark.parametrize("membrane, message", WRONG.values(), ids=WRONG.keys())
def test_what_is_no_membrane_model_is_refused(membrane, message):
    """check_membrane: "Something is missing, has a wrong shape, or is not analytic; ..."."""
    with pytest.raises(ms.InputError, match=message) as caught:
        ms.Potential(ms.build(ms.geometry.Line(length=2.0)), membrane=membrane)
    assert caught.value.key == "cell.model"


def test_good_ones_are_taken():
    """Neither jumps nor a missing state, nor a subclass of the protocol with its defaults, are faults."""
    check_membrane(Good())
    check_membrane(without_states(current=lambda self, v, states: 0.1 * (v + 85.0)))

    class Mine(Membrane):
        def current(self, v, states):
            return v * (v - 0.1) * (v - 1)

    check_membrane(Mine())
    assert (Mine().range, Mine().threshold, Mine().calcium) == ((0.0, 1.0), 0.5, None)


def test_the_potential_begins_at_its_rest():
    """Potential: "It begins at the membrane's rest"."""
    potential = ms.Potential(ms.build(ms.geometry.Line(length=2.0)), membrane=Good())
    assert potential.range == (-90.0, 40.0)
    assert potential.calcium == "calcium"
    for name, value in {"potential": -85.0, "gate": 0.1, "calcium": 1e-4}.items():
        np.testing.assert_array_equal(potential.field_values()[name], value)


@pytest.mark.parametrize(
    "former, said", [("cell", "called membrane"), ("stimulus", r"called source; .*stimuli=\[Stimulus")]
)
def test_former_keywords_of_the_potential(former, said):
    """Keywords of earlier versions say what became of them; any other is a TypeError."""
    body = ms.build(ms.geometry.Line(length=2.0))
    with pytest.raises(ms.InputError, match=f"Potential takes no '{former}' any more: .*{said}"):
        ms.Potential(body, membrane=Good(), **{former: None})
    with pytest.raises(TypeError, match="'memrane'"):
        ms.Potential(body, membrane=Good(), memrane=None)


@pytest.mark.parametrize("name", ["cells", "Bump", "BoundaryBump"])
def test_former_names(name):
    """Names of earlier versions say what took their place."""
    with pytest.raises(AttributeError, match=f"ms.{name} is now ms."):
        getattr(ms, name)
