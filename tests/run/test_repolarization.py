"""The end of each beat: of a point's own amplitude, the last fall, NaN without one; what runs say of it."""

import myostrain as ms
from myostrain.errors import InputError
from myostrain.output.beats import Activations, Repolarization

import numpy as np
import pytest

NAN = np.nan


class Seen:
    """One point whose potential the test gives as corners (time, v) joined by straight lines."""

    def __init__(self, *corners, percents=(50.0, 90.0), rest=0.0, threshold=0.5, step=0.25):
        self.act, self.rep = Activations(1, threshold), Repolarization(1, percents, rest)
        times, values = np.array(corners, dtype=float).T
        self.t = np.arange(times[0], times[-1] + step / 2, step)
        self.v = np.interp(self.t, times, values)[:, None]
        self.rep.start(self.v[0], self.act.start(self.v[0], self.t[0]))
        self.k = 0

    def go(self, steps=None):
        last = len(self.t) - 1 if steps is None else self.k + steps
        while self.k < last:
            before, now, start, end = *self.v[self.k : self.k + 2], *self.t[self.k : self.k + 2]
            new = self.act.observe(before, now, start, end)
            self.rep.observe(before, now, start, end, self.act, new)
            self.k += 1
        return self

    def ends(self, percent):
        return [float(row[0]) for row in self.rep.beats[percent].times]


def test_the_level_is_of_the_amplitude():
    """From −80 to 20 at t = 2, down to −80 in 10: 50 % at t = 7, 90 % at t = 11, whatever the threshold."""
    for threshold in (-60.0, 0.0):
        seen = Seen((0, -80), (1, -80), (2, 20), (12, -80), (13, -80), rest=-80.0, threshold=threshold).go()
        np.testing.assert_allclose((seen.ends(50.0), seen.ends(90.0)), [[7.0], [11.0]], atol=1e-12)


def test_each_beat_has_its_own_peak_and_rest():
    """The second beat rises from the least value after the first, −0.1, to 0.7: 90 % is at −0.02."""
    seen = Seen((0, 0), (1, 1), (11, 0), (12, -0.1), (14, 0), (15, 0.7), (23, -0.1), (24, -0.1)).go()
    np.testing.assert_allclose(seen.ends(90.0), [10.0, 15 + 0.72 / 0.1], atol=1e-12)
    np.testing.assert_allclose(seen.ends(50.0), [6.0, 19.0], atol=1e-12)


def test_the_rest_is_that_since_the_last_beat():
    """Once at −0.05, but at 0 since the first beat ended: the second one, to 0.7, ends at 0.07."""
    seen = Seen((0, -0.05), (1, 0), (2, 1), (12, 0), (14, 0), (15, 0.7), (22, 0), (23, 0)).go()
    assert seen.ends(90.0)[1] == pytest.approx(21.3, abs=1e-12)


def test_the_last_fall_counts():
    """Through a notch down to 0.3 and a dome at 0.8, v falls by 50 % twice; the second time is the end."""
    seen = Seen((0, 0), (1, 1), (2, 0.3), (4, 0.8), (12, 0), (13, 0), threshold=0.25).go()
    np.testing.assert_allclose(seen.ends(50.0), [7.0], atol=1e-12)


def test_a_peak_after_the_notch_counts():
    """The dome at 1.2 is the peak, and the level 0.12."""
    seen = Seen((0, 0), (1, 1), (2, 0.8), (4, 1.2), (16, 0), (17, 0)).go()
    np.testing.assert_allclose(seen.ends(90.0), [4 + 10.8], atol=1e-12)


def test_a_beat_that_is_cut_off_has_no_end():
    """Activated again at 0.2, above its 90 %: the second beat keeps the rest of the first."""
    seen = Seen((0, 0), (1, 1), (9, 0.2), (10, 1), (20, 0), (21, 0)).go()
    ends = seen.ends(90.0)
    assert np.isnan(ends[0])
    assert ends[1] == pytest.approx(19.0, abs=1e-12)


def test_without_an_end_and_without_a_beginning():
    """A point that stays up, and one that never comes up though it falls."""
    assert np.isnan(Seen((0, 0), (1, 1), (20, 0.9)).go().ends(90.0)).all()
    assert np.isnan(Seen((0, 0), (1, 0.4), (2, -0.4), (3, 0)).go().ends(90.0)).all()


def test_what_starts_excited_rises_from_the_membranes_rest():
    """v = 1 at the start, rest −1: 90 % is at −0.8."""
    seen = Seen((0, 1), (10, -1), (11, -1), rest=-1.0).go()
    np.testing.assert_allclose(seen.ends(90.0), [9.0], atol=1e-12)


@pytest.mark.parametrize("steps", [3, 20, 40, 50])
def test_goes_on_from_a_state(steps):
    """In the upstroke, the downstroke and later: the same bits as without a stop."""
    corners = (0, 0), (1, 1), (11, 0), (12, -0.1), (14, 0), (15, 0.7), (23, -0.1), (24, -0.1)
    whole, seen, other = Seen(*corners).go(), Seen(*corners).go(steps), Seen(*corners)

    class One:
        def allreduce(self, value, op=None):
            return value

    kept = seen.rep.state(lambda values: values.tolist(), One())
    other.rep.restore(kept, np.array)
    other.act.put(np.array(seen.act.times))
    other.k = seen.k
    other.go()
    for percent in (50.0, 90.0):
        np.testing.assert_array_equal(other.ends(percent), whole.ends(percent))


def pulse(**options):
    body = ms.build(ms.geometry.Line(length=60.0, spacing=1.0))
    bump = ms.InitialValues(where=ms.Place(center=(0.0,), radius=5.0), potential=0.9)
    potential = ms.Potential(body, membrane=ms.membranes.FitzHughNagumo(), diffusivity=100.0, initial=[bump])
    simulation = ms.Simulation(
        ms.Electromechanics(potential), step=2e-3, end=1.0, probes={"p": (30.0,)}, **options
    )
    return potential, simulation


def test_a_runs_durations_are_those_of_the_trace():
    """APD50 and APD90 at a probe against those found afterwards in all of its values."""
    trace = []
    _, simulation = pulse(
        repolarization=[50, 90],
        on_step=[lambda s: trace.append((s.model.time, s.probes.local(s.model.potential.v.x.array)[0]))],
    )
    results = simulation.run()
    t, v = np.array(trace).T
    top = v.argmax()
    bottom = top + v[top:].argmin()
    peak, rest = v[top], v[:top].min()
    rise = np.interp(0.5, v[: top + 1], t[: top + 1])
    for percent in (50, 90):
        level = peak - percent / 100 * (peak - rest)
        fall = np.interp(-level, -v[top : bottom + 1], t[top : bottom + 1])
        assert results["probes"]["p"][f"apd{percent}"] == pytest.approx([fall - rise], abs=1e-9)
    low, middle, high = (results["metrics"][f"apd90_{what}"] for what in ("min", "median", "max"))
    assert low < middle < high
    assert low <= results["probes"]["p"]["apd90"][0] <= high


def test_no_beat_that_has_ended():
    """None, and not NaN, in the results."""
    _, simulation = pulse()
    simulation.steps = 20
    results = simulation.run()
    assert results["metrics"]["apd90_median"] is None
    assert results["probes"]["p"]["apd90"] == []


@pytest.mark.parametrize("wrong", [0.0, 100.0, "90", [90, -1]])
def test_percentages_are_checked(wrong):
    """Simulation: between 0 and 100."""
    with pytest.raises(InputError, match=r"output.repolarization"):
        pulse(repolarization=wrong)
