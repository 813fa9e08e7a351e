"""A membrane whose formulas have no value somewhere: what, where and when are said."""

import logging

import myostrain as ms
from myostrain import ComputationError

import numpy as np
import pytest


class Mine:
    """Of one gate; rises everywhere, and as fast as its potential is high."""

    states = ("h",)
    gates = ("h",)

    def resting_potential(self):
        return 0.0

    def resting_states(self):
        return (0.5,)

    def current(self, v, states):
        return -v

    def rates(self, v, states):
        return (0.0 * states[0],)


class NoCurrent(Mine):
    """Its current has no value above one half."""

    def current(self, v, states):
        return np.where(v > 0.5, np.nan, -v)


class Leaving(Mine):
    """Its gate leaves [0, 1] where v is high; it cannot be traced."""

    def rates(self, v, states):
        return (np.where(np.real(np.nan_to_num(v)) > 0.5, 100.0, 0.0) + 0.0 * states[0],)


def simulated(membrane, **options):
    body = ms.build(ms.geometry.Line(length=4.0, spacing=1.0))
    bump = ms.InitialValues(where=ms.Place(center=(3.0,), radius=0.5), potential=0.9)
    potential = ms.Potential(body, membrane=membrane, diffusivity=0.01, initial=[bump], **options)
    return ms.Simulation(ms.Electromechanics(potential), step=0.1, end=0.2)


@pytest.mark.parametrize(
    "membrane, integrator, words",
    [
        (NoCurrent(), None, r"the current of NoCurrent is nan at v = \S+ near \[3\.0\]\. Try: a smaller"),
        (
            Leaving(),
            ms.membranes.LinearlyImplicit(),
            r"the gate h has left \[0, 1\]: \S+ near \[3\.0\]\. Try: a smaller",
        ),
    ],
)
def test_what_has_no_value_is_named(membrane, integrator, words):
    """A NaN, or a gate that leaves [0, 1], names state, place and time."""
    with pytest.raises(ComputationError, match=words) as caught:
        simulated(membrane, integrator=integrator).run()
    assert caught.value.where == [3.0]
    assert 0 < caught.value.time <= 0.1


def test_numbers_far_from_the_membranes_range_are_said(caplog):
    """A stimulus too strong, and one that begins when the run has ended: warnings, and a note."""
    place = ms.Place(boundary=("left",), depth=1.0)
    strong = ms.Stimulus(where=place, strength=1e3, duration=1.0)
    late = ms.Stimulus(where=place, strength=1.0, duration=1.0, start=0.2)
    with caplog.at_level(logging.WARNING, "myostrain"):
        found = simulated(Mine(), stimuli=[strong, late]).run()
    assert "stimulus 2 begins at 0.2: the run ends at 0.2, before it" in caplog.text
    assert "far out of the membrane's range, 0 to 1" in caplog.text
    assert found["notes"]["potential_max"].startswith("far out of the range")
