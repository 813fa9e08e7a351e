"""Stimuli: what pulses add to the potential is exact, whatever the steps and the scheme."""

import myostrain as ms

import numpy as np
import pytest

INERT = ms.membranes.FitzHughNagumo(A=0.0)
EVERYWHERE = ms.Place(box=((-1.0,), (99.0,)))
PULSES = {
    "one": dict(strength=3.0, start=0.1, duration=0.25),
    "from the beginning": dict(strength=3.0, duration=0.25),
    "negative": dict(strength=-2.0, start=0.3, duration=0.1),
    "three": dict(strength=5.0, start=0.05, duration=0.1, period=0.3, count=3),
    "for ever": dict(strength=5.0, start=0.05, duration=0.1, period=0.3),
    "without a break": dict(strength=1.0, start=0.2, duration=0.1, period=0.1, count=4),
}
#: Equal steps whose ends are no edges of pulses, and steps longer than pulses and periods.
TIMES = {
    "small": np.linspace(0.0, 1.2, 35)[1:],
    "on the edges": np.linspace(0.0, 1.2, 25)[1:],
    "large": np.array([0.37, 0.74, 1.11, 1.2]),
    "unequal": np.array([0.01, 0.07, 0.3, 0.31, 0.9, 1.2]),
}
each_pulse = pytest.mark.parametrize("pulses", PULSES.values(), ids=PULSES.keys())


def added(time, strength, duration, start=0.0, period=np.inf, count=None):
    """What the pulses have added until a time, one by one."""
    count = 1 if np.isinf(period) else 1000 if count is None else count
    begin = start + (period * np.arange(count) if count > 1 else np.zeros(1))
    return strength * np.clip(time - begin, 0.0, duration).sum()


@each_pulse
def test_the_amount_is_the_integral_of_the_rate(pulses):
    """Stimulus.amount: "Integral of the rate from time 0"; also at the pulses' edges and long after."""
    stimulus = ms.Stimulus(where=EVERYWHERE, **pulses)
    edges = [0.0, 0.05, 0.1, 0.2, 0.3, 0.35, 0.1 + 0.2, 0.45, 0.6, 0.65, 0.75]
    for time in [*edges, *np.random.default_rng(1).uniform(0, 3, 50), 40.0]:
        assert stimulus.amount(time) == pytest.approx(added(time, **pulses), rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("times", TIMES.values(), ids=TIMES.keys())
@pytest.mark.parametrize("scheme", [ms.Implicit(), ms.Staggered(), ms.SecondOrder()], ids=str)
@each_pulse
def test_what_is_added_is_exact_whatever_the_steps(pulses, scheme, times):
    """Stimulus: "what a pulse adds to v is exact whatever the steps", at the end of every step.

    A uniform potential without a reaction: nothing else changes it.
    """
    stimulus = ms.Stimulus(where=EVERYWHERE, **pulses)
    potential = ms.Potential(ms.build(ms.geometry.Line(length=3.0)), membrane=INERT, stimuli=[stimulus])
    model = ms.Electromechanics(potential, scheme=scheme)
    model.start()
    for time in times:
        model.step(time)
        np.testing.assert_allclose(potential.v.x.array, added(time, **pulses), rtol=0, atol=1e-9)


@pytest.mark.parametrize("mass", ["lumped", "averaged"])
def test_the_amount_in_a_place(mass):
    """While it spreads, ∫ v is what the pulses have added, each in its place; they add up."""
    body = ms.build(
        ms.geometry.Rectangle(size=(6.0, 4.0), spacing=0.5), ms.UniformFibres(direction=(1.0, 0.5))
    )
    stimuli = [
        ms.Stimulus(where=ms.Place(center=(1.0, 1.0), radius=1.1), strength=4.0, start=0.013, duration=0.05),
        ms.Stimulus(where=ms.Place(boundary=("right",), depth=1.0), strength=2.0, duration=0.03),
    ]
    options = {"ksp_rtol": 1e-14}
    parts = dict(membrane=INERT, diffusivity=(3.0, 1.0), mass=mass, stimuli=stimuli, options=options)
    potential = ms.Potential(body, **parts)
    space = potential.v.function_space
    volumes = [np.sum(potential.weight * stimulus.share(body, space)) for stimulus in stimuli]
    model = ms.Electromechanics(potential)
    model.start()
    for time in np.linspace(0, 0.1, 8)[1:]:
        model.step(time)
        due = sum(v * s.amount(time) for v, s in zip(volumes, stimuli, strict=True))
        assert potential.amount() == pytest.approx(due, rel=1e-11)
    assert potential.v.x.array.max() > 1.5 * potential.v.x.array.min()


def test_a_stimulus_excites_a_line_at_rest():
    """A wave begins where and when the stimulus acts; a second one follows a period later."""
    body = ms.build(ms.geometry.Line(length=60.0))
    left = ms.Place(boundary=("left",), depth=4.0)
    stimulus = ms.Stimulus(where=left, strength=60.0, start=0.1, duration=0.02, period=1.2, count=2)
    potential = ms.Potential(
        body, membrane=ms.membranes.FitzHughNagumo(), diffusivity=100.0, stimuli=[stimulus]
    )
    model = ms.Electromechanics(potential)
    order = np.argsort(potential.v.function_space.tabulate_dof_coordinates()[:, 0])
    middle, above = order[30], []
    model.start()
    for number in range(1, 1101):
        model.step(number * 2e-3)
        above.append(potential.v.x.array[middle] > 0.5)
    arrivals = 2e-3 * (1 + np.flatnonzero(np.diff(np.array(above, dtype=int)) == 1))
    assert len(arrivals) == 2
    assert arrivals[0] > 0.3  # 30 units of length at some 55
    # The second wave runs through what the first one left: a little later at most.
    assert arrivals[1] - arrivals[0] == pytest.approx(1.2, abs=0.15)


class Ramp:
    """A stimulus of a script's own: a rate that grows with time, everywhere."""

    def share(self, body, space):
        return np.ones(len(space.tabulate_dof_coordinates()))

    def amount(self, time):
        return time**2


def test_a_stimulus_of_a_users_own():
    """electrics.stimulus.Applied: an object with share and amount."""
    potential = ms.Potential(ms.build(ms.geometry.Line(length=3.0)), membrane=INERT, stimuli=[Ramp()])
    model = ms.Electromechanics(potential)
    model.start()
    for time in (0.1, 0.5, 0.7):
        model.step(time)
        np.testing.assert_allclose(potential.v.x.array, time**2, rtol=1e-9)


@pytest.mark.parametrize(
    "wrong, message",
    [
        (dict(strength=0.0), "does nothing"),
        (dict(strength=np.nan), "finite"),
        (dict(duration=0.0), "greater than 0"),
        (dict(start=-1.0), "greater than or equal to 0"),
        (dict(period=0.05), r"period = 0\.05 is shorter than duration = 0\.1"),
        (dict(count=2), "several pulses need a period"),
        (dict(period=1.0, count=0), "greater than or equal to 1"),
    ],
)
def test_wrong_stimuli(wrong, message):
    """Messages say what is wrong."""
    with pytest.raises(ValueError, match=message):
        ms.Stimulus(**(dict(where=EVERYWHERE, strength=1.0, duration=0.1) | wrong))


def test_a_stimulus_outside_the_body():
    """The place is looked for when the potential is made; the message names the section."""
    stimulus = ms.Stimulus(where=ms.Place(center=(50.0,), radius=1.0), strength=1.0, duration=0.1)
    with pytest.raises(ms.InputError, match=r"stimulus\.radius: no node"):
        ms.Potential(ms.build(ms.geometry.Line(length=3.0)), membrane=INERT, stimuli=[stimulus])
