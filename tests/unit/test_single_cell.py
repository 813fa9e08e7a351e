"""Membranes without a body: the time loop, what a beat measures, the fallback, wrong input."""

import myostrain as ms
from myostrain.pointwise.compiler import compiler
from myostrain.single_cell import pacing
from myostrain.single_cell.beat import measure_beat

import numpy as np
import pytest
from scipy.integrate import solve_ivp

M = ms.membranes


def exact(membrane, beats, cycle):
    """Potential and states after some beats by SciPy's Radau, to 1e-10."""
    strength, duration = membrane.pacing
    y = np.array([membrane.resting_potential(), *membrane.resting_states()])

    def rates(t, y, applied):
        found = [applied - membrane.current(y[0], y[1:]), *membrane.rates(y[0], y[1:])]
        return np.array(found, dtype=float)

    for _ in range(beats):
        for length, applied in ((duration, strength), (cycle - duration, 0.0)):
            y = solve_ivp(rates, (0, length), y, "Radau", args=(applied,), rtol=1e-10, atol=1e-12).y[:, -1]
    return y


def test_second_order_in_the_step():
    """Amid the repolarisation, against SciPy's Radau; of a model whose rates do not jump."""
    membrane, cycle = M.AlievPanfilov1996(), 21.0
    true = exact(membrane, 1, cycle)[0]
    steps = (0.1, 0.05, 0.025)
    ends = [ms.cell(membrane, cycle=cycle, beats=1, step=h).end["potential"] for h in steps]
    errors = np.abs(np.array(ends) - true)
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2.0, atol=0.1)


def test_the_error_of_the_default_step():
    """Luo and Rudy amid the repolarisation, where the potential falls by 1 mV/ms: 3e-3 mV are 3e-3 ms."""
    membrane, cycle = M.LuoRudy1991(), 350.0
    true = exact(membrane, 1, cycle)[0]
    assert ms.cell(membrane, cycle=cycle, beats=1).end["potential"] == pytest.approx(true, abs=6e-3)


#: The tenth beat by other integrations, independent of this one: APD90 and peak.
KNOWN = {
    "AlievPanfilov1996": (20.9, 0.9933),
    "MitchellSchaeffer2003": (286.6, None),
    "FentonKarma1998": (244.2, None),
    "BuenoOrovio2008": (268.8, 41.1),
    "LuoRudy1991": (360.7, 47.0),
}


@pytest.mark.parametrize("name", KNOWN)
def test_tenth_beat(name):
    """docs/membranes.md, the table, at the default step and cycle, within 0.2 ms."""
    last = ms.cell(getattr(M, name)()).last
    apd, peak = KNOWN[name]
    assert last["apd90"] == pytest.approx(apd, abs=0.2 if apd > 100 else 0.03)
    if peak is not None:
        assert last["peak"] == pytest.approx(peak, rel=2e-3)
    assert last["apd30"] < last["apd50"] < last["apd90"]


def test_the_human_ventricle():
    """Ten Tusscher and Panfilov at 1 Hz: an independent integration's APD90, rest and calcium."""
    paced = ms.cell(M.TenTusscherPanfilov2006())
    last = paced.last
    assert last["apd90"] == pytest.approx(306, abs=1)
    assert last["rest"] == pytest.approx(-85.50, abs=0.02)
    assert last["calcium_peak"] == pytest.approx(0.870, rel=0.01)
    assert paced.calcium[paced.time > 9000].max() == pytest.approx(last["calcium_peak"], rel=1e-3)
    assert len(paced.beats) == 10
    assert paced.alternans == abs(paced.beats[9]["apd90"] - paced.beats[8]["apd90"])


def test_a_duration_ends_with_the_last_fall():
    """docs/howto/cells.md: "until the potential falls, for the last time": here it rises once more."""
    time = np.arange(9.0)
    v = np.array([0.0, 1.0, 0.8, 0.4, 0.6, 0.8, 0.2, 0.05, 0.0])
    found, notes = measure_beat(time, v[None], 0.5, (1.0, 1.0))
    assert not notes
    # From 0.5 at t = 0.5; 0.7 and 0.5 are passed downwards twice, 0.1 once.
    expected = {"apd30": 5 + 1 / 6 - 0.5, "apd50": 5.5 - 0.5, "apd90": 6 + 2 / 3 - 0.5}
    assert {name: found[name] for name in expected} == pytest.approx(expected)


def test_without_a_compiler_scipy_takes_its_place(monkeypatch):
    """The same numbers, by LSODA."""
    membrane = M.BuenoOrovio2008()
    fast = ms.cell(membrane, beats=1, cycle=400.0)
    monkeypatch.setattr(pacing, "_compiled", lambda *_: None)
    slow = ms.cell(membrane, beats=1, cycle=400.0)
    assert (fast.step, slow.step) == (0.01 if compiler() else None, None)
    for name in ("apd30", "apd90", "peak", "calcium_peak"):
        assert slow.last[name] == pytest.approx(fast.last[name], rel=3e-4)
    np.testing.assert_allclose(slow.time, fast.time, atol=1e-9)


def test_a_beat_of_straight_lines():
    """Up from 0 to 1 in [1, 2], down to 0 in [4, 8]: durations from v = 0.5 on, in closed form."""
    time = np.linspace(0, 10, 1001)
    v = np.interp(time, [0, 1, 2, 4, 8], [0, 0, 1, 1, 0])
    found, notes = measure_beat(time, np.array([v, time * (10 - time)]), 0.5, (0.0, 0.5))
    assert found["apd30"] == pytest.approx(4 + 0.3 * 4 - 1.5, abs=0.01)
    assert found["apd90"] == pytest.approx(4 + 0.9 * 4 - 1.5, abs=0.01)
    assert found["upstroke_velocity"] == pytest.approx(1.0)
    assert (found["peak"], found["rest"], found["calcium_time"]) == (1.0, 0.0, 5.0)
    assert notes == {}
    found, notes = measure_beat(time[:600], v[np.newaxis, :600], 0.5, (0.0, 0.5))
    assert found["apd30"] is not None
    assert found["apd90"] is None
    assert notes["apd90"].startswith("the potential has not fallen so far")


def test_a_stimulus_that_is_too_weak():
    """No value, and why."""
    paced = ms.cell(M.LuoRudy1991(), beats=2, stimulus=(5.0, 1.0))
    assert paced.last["apd90"] is None
    assert paced.alternans is None
    assert paced.notes["apd90"].startswith("the stimulus did not excite: the potential reached -")


def test_a_gate_that_leaves_its_bounds():
    """The state and the time."""
    with pytest.raises(
        ms.ComputationError, match=r"^at t = \d.*LuoRudy1991: the gate m has left .0, 1.: 2.4"
    ):
        ms.cell(M.LuoRudy1991(), beats=1, initial={"m": 3.0})


def test_a_state_may_be_called_as_anything():
    """Fenton and Karma call a gate v; potential and gate stay apart."""
    assert "v" in M.FentonKarma1998().states
    end = ms.cell(M.FentonKarma1998(), beats=1, cycle=100.0).end
    assert end["potential"] > 0.5 > end["v"]


@pytest.mark.parametrize(
    "given, message",
    [
        ({"cycle": 0.5}, "^cycle: 0.5: give a time longer than the stimulus, which lasts 1"),
        ({"beats": 0}, "^beats: 0"),
        ({"step": -1.0}, "^step: -1"),
        ({"stimulus": (1.0, 0.0)}, "^stimulus: "),
    ],
)
def test_numbers_that_cannot_be(given, message):
    with pytest.raises(ms.InputError, match=message):
        ms.cell(M.MitchellSchaeffer2003(), **given)


def test_it_goes_on_from_its_end():
    """Two beats at once are one and one."""
    membrane = M.MitchellSchaeffer2003()
    once = ms.cell(membrane, beats=2)
    first = ms.cell(membrane, beats=1)
    second = ms.cell(membrane, beats=1, initial=first.end)
    assert second.end == once.end
    assert second.last["apd90"] == pytest.approx(once.last["apd90"], rel=1e-9)
