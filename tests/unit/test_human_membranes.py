"""Human ventricular membranes against public implementations of them, number by number."""

import json
from pathlib import Path

from myostrain.errors import InputError
from myostrain.membranes import TenTusscherPanfilov2006, ToRORd2019, check_membrane
from myostrain.membranes.channels import sodium_inactivation
from myostrain.membranes.ten_tusscher_panfilov_2006 import SLOPES

import numpy as np
import pytest
from scipy.integrate import solve_ivp

DATA = Path(__file__).parents[1] / "data"

#: Samples of each set and slope, from another implementation; what it is the files say.
REFERENCES = {
    membrane: json.loads((DATA / name).read_text(encoding="utf-8"))
    for membrane, name in {
        TenTusscherPanfilov2006: "ten_tusscher_panfilov_2006.json",
        ToRORd2019: "to_ror_d_2019.json",
    }.items()
}
SAMPLES = [
    pytest.param(membrane, reference["states"], sample, id=f"{membrane.__name__}-{number}")
    for membrane, reference in REFERENCES.items()
    for number, sample in enumerate(reference["samples"])
]

MODELS = {
    **{f"TTP06 {layer}": TenTusscherPanfilov2006(set=layer) for layer in ("EPI", "ENDO", "M")},
    **{f"ToR-ORd {layer}": ToRORd2019(set=layer) for layer in ("ENDO", "EPI", "MID")},
}

#: How far from equilibrium the published states are: the drift of v, mV/ms. The potential of TTP06 ENDO lies
#: 1 mV below what its gates belong to.
DRIFTS = {
    "TTP06 EPI": 0.0004,
    "TTP06 ENDO": 0.258,
    "TTP06 M": 0.001,
    "ToR-ORd ENDO": 0.0002,
    "ToR-ORd EPI": 0.0001,
    "ToR-ORd MID": 0.0002,
}


def scaled(values):
    """Samples as arrays, one row a state."""
    return np.array(values).T


@pytest.mark.parametrize("kind, names, sample", SAMPLES)
def test_number_by_number(kind, names, sample):
    """Current and rates of every set and slope are those of another implementation, to 1e-9."""
    chosen = {key: sample[key] for key in ("set", "slope") if key in sample}
    membrane = kind(**chosen, **sample.get("parameters", {}))
    assert list(membrane.states) == names
    v, states = np.array([sample["v"]]), scaled([sample["states"]])
    np.testing.assert_allclose(membrane.current(v, states), sample["current"], rtol=1e-9)
    np.testing.assert_allclose(np.concatenate(membrane.rates(v, states)), sample["rates"], rtol=1e-9)


def test_every_set_and_slope_is_among_the_samples():
    """More than once each."""
    for kind, count, each in ((TenTusscherPanfilov2006, 12, 2), (ToRORd2019, 3, 3)):
        found = [(s["set"], s.get("slope")) for s in REFERENCES[kind]["samples"]]
        assert len(set(found)) == count
        assert len(found) == each * count


def test_sodium_inactivation_changes_its_formula_at_minus_forty():
    """sodium_inactivation: "one below −40 mV and another above"."""
    h_speed, j_speed = sodium_inactivation(np.array([-40.0 - 1e-9, -40.0]))
    high = 0.77 / (0.13 * (1.0 + np.exp(29.34 / 11.1)))
    low = 0.057 * np.exp(-40.0 / 6.8) + 2.7 * np.exp(-3.16) + 3.1e5 * np.exp(-13.94)
    np.testing.assert_allclose(h_speed, [low, high], rtol=1e-8)
    assert j_speed[1] == pytest.approx(0.6 * np.exp(-2.28) / (1.0 + np.exp(0.8)), rel=1e-12)
    assert abs(j_speed[0] / j_speed[1] - 1.0) > 1e-3


@pytest.mark.parametrize("name", MODELS)
def test_published_states_are_near_rest(name):
    """resting_states: "no equilibrium", but near one."""
    membrane = MODELS[name]
    check_membrane(membrane)
    v, states = np.array([membrane.resting_potential()]), scaled([membrane.resting_states()])
    assert np.abs(membrane.current(v, states)) < DRIFTS[name]
    gates = [membrane.states.index(name) for name in membrane.gates]
    assert ((states[gates] >= 0) & (states[gates] <= 1)).all()


@pytest.mark.parametrize("membrane", MODELS.values(), ids=MODELS.keys())
def test_finite_and_smooth_at_any_potential(membrane):
    """Neither 0/0 where a flux has a removable singularity, nor an overflow far away."""
    far = np.concatenate([np.linspace(-1000.0, 1000.0, 4001), [-40.0, 0.0, 15.0]])
    rest = scaled([membrane.resting_states()])
    with np.errstate(all="raise", under="ignore"):
        found = [membrane.current(far, rest), *membrane.rates(far, rest)]
    assert all(np.isfinite(values).all() for values in found)
    # The series and the formula meet: no step where one takes over from the other, to round-off.
    for centre in (0.0, 15.0):
        v = centre + np.linspace(-1.0, 1.0, 2001)
        current = membrane.current(v, rest)
        third = np.abs(np.diff(current, 3))
        assert third.max() < 1e-9 * np.abs(current).max()


def test_values_of_the_set_and_of_the_user():
    """Parameters come from the set and the slope, unless they are given."""
    given = TenTusscherPanfilov2006(set="M", slope=1.8, g_Ks=0.2, factor_f_tau=1.0)
    assert (given.g_Ks, given.g_to, given.s_offset) == (0.2, 0.294, 20.0)
    assert (given.factor_f_tau, given.factor_g_pCa) == (1.0, 7.0)
    given = ToRORd2019(set="MID", GKr=0.03)
    assert (given.GKr, given.GNaL, given.PCa, given.relScale) == (0.03, 0.0279, 2.0 * 8.3757e-05, 1.7)
    assert (given.delta_epi, ToRORd2019(set="EPI").delta_epi) == (False, True)


NOT_TAKEN = [
    ({"slope": 1.2}, r"1\.2 is not a slope of TenTusscherPanfilov2006; known: 0\.7, 1\.1, 1\.4, 1\.8"),
    ({"set": "MID"}, "set: this should be 'EPI', 'ENDO' or 'M', not 'MID'"),
    ({"g_Ks": None}, "g_Ks: give a number, not None"),
    (
        {"set": "M", "g_Ks": 0.392, "g_to": 0.073, "s_offset": 28.0, "s_variant": True},
        'this is "M", but the numbers beside it are all those of "ENDO": leave them out',
    ),
    (
        dict.fromkeys(SLOPES[1.1], 1.0) | {"slope": 1.8},
        r"this is 1\.8, but the numbers beside it are all those of 1\.1: leave them out",
    ),
]


@pytest.mark.parametrize("given, said", NOT_TAKEN)
def test_what_does_not_go_together(given, said):
    """An unknown set or slope, no number, and a set or slope with the numbers of another are refused."""
    with pytest.raises(InputError, match=said):
        TenTusscherPanfilov2006(**given)


def paced(membrane, beats, cycle=1000.0):
    """The last of several beats by LSODA: time (ms), potential and calcium."""
    strength, duration = membrane.pacing
    y = np.array([membrane.resting_potential(), *membrane.resting_states()])

    def slope(applied):
        def function(_, y):
            v, states = y[:1], y[1:, None]
            rates = [applied - membrane.current(v, states), *membrane.rates(v, states)]
            return np.concatenate(rates)

        return function

    at = np.arange(duration, cycle, 0.1)
    for _ in range(beats):
        upstroke = solve_ivp(slope(strength), (0.0, duration), y, method="LSODA", rtol=1e-6, atol=1e-8)
        beat = solve_ivp(
            slope(0.0),
            (duration, cycle),
            upstroke.y[:, -1],
            "LSODA",
            t_eval=[*at, cycle],
            rtol=1e-6,
            atol=1e-8,
        )
        y = beat.y[:, -1]
    calcium = 1 + membrane.states.index(membrane.calcium)
    return beat.t, beat.y[0], beat.y[calcium]


@pytest.mark.slow
def test_ten_tusscher_panfilov_at_one_hertz():
    """The tenth beat of EPI is that of an independent integration, within one per cent."""
    t, v, calcium = paced(TenTusscherPanfilov2006(), 10)
    wanted = np.loadtxt(DATA / "ten_tusscher_panfilov_2006_epi_1hz.csv", delimiter=",", skiprows=1)
    wanted = wanted[wanted[:, 0] > 11.0]  # stimulated at 10 ms
    at = wanted[:, 0] - 10.0
    np.testing.assert_allclose(np.interp(at, t, v), wanted[:, 1], atol=0.01 * 126.0)
    np.testing.assert_allclose(np.interp(at, t, calcium), wanted[:, 2], atol=0.01 * 0.767)
    assert v[-1] == pytest.approx(-85.50, abs=0.02)
    assert v.max() == pytest.approx(38.67, abs=0.1)
    level = v.max() - 0.9 * (v.max() - v[-1])
    assert t[v > level][-1] - 0.9 == pytest.approx(306.1, abs=0.5)


#: From the published states, by the code that to_ror_d_2019.json names and LSODA: peak, last potential and
#: highest calcium of the first beat, and when it is repolarised by nine tenths.
TOR_ORD_BEATS = {
    "ENDO": (32.956, -88.869, 0.3857, 272.25),
    "EPI": (31.942, -89.094, 0.7385, 237.30),
    "MID": (30.207, -89.099, 1.1404, 329.50),
}


@pytest.mark.slow
@pytest.mark.parametrize("layer", TOR_ORD_BEATS)
def test_to_ror_d_at_one_hertz(layer):
    """The first beat of each set is that of an independent code, also where MID empties its junction."""
    membrane = ToRORd2019(set=layer)
    t, v, calcium = paced(membrane, 1)
    peak, last, high, repolarised = TOR_ORD_BEATS[layer]
    assert v.max() == pytest.approx(peak, abs=0.06)  # sampled each 0.1 ms
    assert v[-1] == pytest.approx(last, abs=0.003)
    assert calcium.max() == pytest.approx(high, rel=1e-3)
    level = v.max() - 0.9 * (v.max() - membrane.resting_potential())
    assert t[v > level][-1] == pytest.approx(repolarised, abs=0.15)
