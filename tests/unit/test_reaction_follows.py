"""A script's membrane that changes between two steps: the next step takes what it holds then."""

from myostrain.membranes.contracts import Step
from myostrain.membranes.reaction import Reaction

import numpy as np
import pytest


class Word:
    """What a model may hold beside numbers."""

    def __init__(self, factor):
        self.factor = factor


class Changing:
    """A current that depends on a number, an integer, a flag, a word, a table and an object."""

    states = ()

    def __init__(self):
        self.number, self.count, self.flag, self.word = 2.0, 1, False, "once"
        self.table, self.held = np.array([1.0, 2.0]), Word(1.0)

    def resting_potential(self):
        """Zero."""
        return 0.0

    def current(self, v, states):
        """All of them multiply v."""
        factor = (
            self.number * self.count * (3.0 if self.flag else 1.0) * (5.0 if self.word == "five" else 1.0)
        )
        return v * factor * float(self.table.sum()) * self.held.factor


def in_place(model):
    model.table[0] = 10.0


CHANGES = {
    "number": lambda model: setattr(model, "number", 7.0),
    "integer": lambda model: setattr(model, "count", 4),
    "flag": lambda model: setattr(model, "flag", True),
    "word": lambda model: setattr(model, "word", "five"),
    "table": in_place,
    "object": lambda model: setattr(model, "held", Word(9.0)),
    "nodal values": lambda model: setattr(model, "number", np.linspace(1.0, 2.0, 5)),
}


@pytest.mark.parametrize("change", CHANGES)
def test_the_next_step_takes_what_the_model_holds(change):
    """Bit by bit what the equations themselves give, before and after."""
    model, v = Changing(), np.linspace(0.0, 1.0, 5)
    reaction = Reaction(model)
    nothing = np.zeros((0, 5))
    step = Step(0.1, 10.0, nothing, nothing, v, 1)
    for alter in (lambda _: None, CHANGES[change]):
        alter(model)
        _, current, slope, _ = reaction.solve(v, nothing, step)
        np.testing.assert_allclose(current, model.current(v, ()), rtol=1e-14)
        np.testing.assert_allclose(slope, model.current(np.ones(5), ()), rtol=1e-14)
