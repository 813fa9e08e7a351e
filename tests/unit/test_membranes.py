"""Published membranes: rates and beats against other implementations, rest, sets of parameters, cases."""

import dataclasses
import json
from pathlib import Path

import myostrain as ms
from myostrain import Case, InputError
from myostrain.membranes.equilibrium import equilibrium

import numpy as np
import pytest

from membrane_tools import last_beat
from small_cases import LINE, changed, write_case

DATA = Path(__file__).parents[1] / "data"

#: What another code gives, by model and set; where it is from the files say.
RATES, BEATS = (
    json.loads((DATA / f"membrane_{what}.json").read_text(encoding="utf-8")) for what in ("rates", "beats")
)
MODELS = {
    "AlievPanfilov1996": ms.membranes.AlievPanfilov1996,
    "MitchellSchaeffer2003": ms.membranes.MitchellSchaeffer2003,
    "BuenoOrovio2008": ms.membranes.BuenoOrovio2008,
    "FentonKarma1998": ms.membranes.FentonKarma1998,
    "LuoRudy1991": ms.membranes.LuoRudy1991,
}
#: Every model with every set.
ALL = [(name, word) for name, cls in MODELS.items() for word in getattr(cls, "sets", [None])]

#: Factors and zeros of our units in the other code's: of the potential, and of calcium.
POTENTIAL = {"BuenoOrovio2008": (85.7, -84.0)}
CALCIUM = {"LuoRudy1991": 1e3}


def made(name, word, **parameters):
    return MODELS[name](**parameters) if word is None else MODELS[name](set=word, **parameters)


def reference(table, name, word):
    return table[name] if word is None else table[name][word]


def rates(membrane, y):
    """Rates of potential and states (1 + states, points)."""
    found = [-membrane.current(y[0], y[1:]), *membrane.rates(y[0], y[1:])]
    return np.array([np.broadcast_to(f, y.shape[1:]) for f in found])


@pytest.mark.parametrize("name, word", ALL)
def test_rates_number_by_number(name, word):
    """Every set: current and rates at points drawn at random are those of another code, to round-off."""
    given = reference(RATES, name, word)
    y, expected = (np.array(given[key]).T for key in ("points", "rates"))
    factor, zero = POTENTIAL.get(name, (1.0, 0.0))
    units = np.full(len(y), 1.0)
    units[0], units[-1] = factor, CALCIUM.get(name, 1.0)
    y, expected = y * units[:, None], expected * units[:, None]
    y[0] += zero
    found = rates(made(name, word), y)
    # Measured 2e-13; the reference has 14 digits.
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-13 * factor)


@pytest.mark.parametrize("name, word", ALL)
def test_every_set_rests(name, word):
    """docs/membranes.md: at rest "neither the potential nor a state changes"."""
    membrane = made(name, word)
    ms.membranes.check_membrane(membrane)
    y = np.array([membrane.resting_potential(), *membrane.resting_states()])
    assert np.abs(rates(membrane, y)).max() < 1e-13
    low, high = membrane.range
    assert low <= y[0] < membrane.threshold < high


@pytest.mark.parametrize(
    "name, word, parameters, rest",
    [
        # Potassium outside raises the rest of a cell, as Nernst's potential says, 20.4 mV.
        ("LuoRudy1991", None, {"Ko": 11.6}, (-68.0, 3.0)),
        ("LuoRudy1991", None, {"g_b": 0.0}, (-87.8, 0.1)),
        # With a third of what holds it, it rests between potassium's potential and the background's.
        ("LuoRudy1991", None, {"g_K1": 0.2}, (-77.0, 1.0)),
        ("FentonKarma1998", "MLR-I", {"k": 3.0}, (3e-4, 3e-4)),
        ("BuenoOrovio2008", "EPI", {"u0": 0.01, "k_s": 4.0}, (-84.0 + 0.857, 1e-12)),
    ],
)
def test_rest_follows_the_parameters(name, word, parameters, rest):
    """docs/membranes.md: rest is solved for "with whatever parameters"."""
    membrane = made(name, word, **parameters)
    y = np.array([membrane.resting_potential(), *membrane.resting_states()])
    assert np.abs(rates(membrane, y)).max() < 1e-13
    assert y[0] == pytest.approx(rest[0], abs=rest[1])


def test_no_rest_is_said():
    """Where the inward current wins below the threshold, or the rest is above it, nothing is at rest."""
    for wrong in ({"u_c": 1e-10}, {"k": 0.1, "C_si": 10.0}):
        with pytest.raises(InputError, match=r"^cell\.u_c: at .* the slow inward current is larger"):
            ms.membranes.FentonKarma1998(**wrong)
    with pytest.raises(InputError, match=r"^cell\.u0: the membrane rests there: give less than theta_v = 0"):
        ms.membranes.BuenoOrovio2008(u0=0.2)

    with pytest.raises(InputError, match=r"^cell\.model: LuoRudy1991 has no rest below -40 mV"):
        ms.membranes.LuoRudy1991(g_K1=0.0).resting_states()

    class Drifting(ms.membranes.Membrane):
        def current(self, v, states):
            return 1.0 + v * v

    with pytest.raises(InputError, match=r"^cell\.model: Drifting has no rest near 0\.3 with these"):
        equilibrium(Drifting(), 0.3, ())


def test_luo_rudy_where_its_formulas_are_nought_over_nought():
    """At −47.13 and −77 mV: finite, no warning, and in line with what lies beside."""
    membrane = ms.membranes.LuoRudy1991()
    states = np.array(membrane.resting_states())[:, None]
    for pole in (-47.13, -77.0):
        v = pole + np.array([-2e-2, -1e-2, -1e-6, 0.0, 1e-6, 1e-2, 2e-2])
        with np.errstate(all="raise", under="ignore"):
            found = rates(membrane, np.vstack([v, np.repeat(states, len(v), axis=1)]))
        assert np.isfinite(found).all()
        # Where series and formula meet, on a parabola: what is left is of fourth order.
        middle = (4 * (found[:, 1] + found[:, 5]) - found[:, 0] - found[:, 6]) / 6
        np.testing.assert_allclose(found[:, 3], middle, rtol=1e-8, atol=1e-10)
        np.testing.assert_allclose(found[:, [2, 4]].mean(axis=1), found[:, 3], rtol=1e-12, atol=1e-13)
    far = np.linspace(-1000.0, 1000.0, 4001)
    with np.errstate(all="raise", under="ignore"):
        found = rates(membrane, np.vstack([far, np.repeat(states, len(far), axis=1)]))
    assert np.isfinite(found).all()


def test_luo_rudy_follows_the_concentrations():
    """Each current reverses at Nernst's potential of the published concentrations, as codes print it."""
    membrane = ms.membranes.LuoRudy1991()
    zero = dict.fromkeys(("g_si", "g_K", "g_K1", "g_Kp", "g_b"), 0.0)
    gates = [1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.1]
    for parameters, reversal in (
        ({**zero}, 54.79446393509185),
        ({**zero, "g_Na": 0.0, "g_K": 0.282}, -77.56758438531939),
        ({**zero, "g_Na": 0.0, "g_K1": 0.6047}, -87.8929017138025),
        ({**zero, "g_Na": 0.0, "g_Kp": 0.0183}, -87.8929017138025),
        ({**zero, "g_Na": 0.0, "g_b": 0.03921}, -59.87),
    ):
        near = np.array([reversal - 1e-3, reversal, reversal + 1e-3])
        current = ms.membranes.LuoRudy1991(**parameters).current(near, gates)
        assert current[0] < 0 < current[2], parameters
        assert abs(current[1]) < 1e-12, parameters
    doubled = ms.membranes.LuoRudy1991(C=2.0)
    v = np.linspace(-90.0, 40.0, 7)
    np.testing.assert_allclose(doubled.current(v, gates), membrane.current(v, gates) / 2, rtol=1e-15)


def agree(name, word, beats):
    """A beat by our equations and scipy, against the same of another code's equations."""
    membrane = made(name, word)
    method = "LSODA" if name == "LuoRudy1991" else "RK45"
    beat = last_beat(membrane, 100.0 if name == "AlievPanfilov1996" else 1000.0, beats, method)
    other = reference(BEATS, name, word)[str(beats)]
    unit = beat.time[-1] / 1e5  # a hundredth of a millisecond
    size = membrane.range[1] - membrane.range[0]
    assert beat.rest == pytest.approx(other["rest"], abs=1e-5 * size)
    assert beat.peak == pytest.approx(other["peak"], abs=1e-4 * size)
    assert beat.apd == pytest.approx(other["apd90"], abs=5 * unit)
    # docs/membranes.md: "from the crossing of the threshold it is the same within a millisecond".
    assert beat.crossing_apd == pytest.approx(beat.apd, abs=100 * unit)
    if membrane.calcium is not None:
        calcium = beat.values[1 + membrane.states.index(membrane.calcium)]
        assert calcium.max() == pytest.approx(other["calcium_peak"], rel=1e-4)
        assert beat.time[calcium.argmax()] == pytest.approx(other["calcium_time"], abs=30 * unit)
    return beat


#: Of another integration, independent of both: APD90, and how near, at 1 Hz (a cycle of 100), tenth beat.
KNOWN = {
    ("AlievPanfilov1996", None): (20.9, 0.06),
    ("MitchellSchaeffer2003", None): (286.7, 0.5),
    ("BuenoOrovio2008", "EPI"): (268.8, 0.5),
    ("FentonKarma1998", "MLR-I"): (244.2, 0.5),
}


@pytest.mark.parametrize("name, word", [*KNOWN, ("LuoRudy1991", None)])
def test_first_beat(name, word):
    """One beat from rest: APD90, peak, rest and calcium of another code."""
    agree(name, word, 1)


@pytest.mark.slow
@pytest.mark.parametrize("name, word", ALL)
def test_tenth_beat(name, word):
    """docs/membranes.md, the table: every set at 1 Hz."""
    beat = agree(name, word, 10)
    if (name, word) in KNOWN:
        value, near = KNOWN[name, word]
        assert beat.apd == pytest.approx(value, abs=near)


def test_a_set_fills_what_is_not_given():
    """docs/membranes.md: "What is given beside a set wins"."""
    cell = ms.membranes.BuenoOrovio2008(set="ENDO", tau_w1m=70.0)
    assert (cell.tau_w1m, cell.tau_w2m, cell.tau_si) == (70.0, 140.0, 2.9013)
    assert ms.membranes.BuenoOrovio2008() == ms.membranes.BuenoOrovio2008(set="EPI")
    assert ms.membranes.FentonKarma1998().tau_d == 0.172


def test_a_case_names_models_sets_and_parameters(tmp_path):
    """The resolved case holds every number, and repeats itself; a set may be changed in it."""
    for name, word in ALL:
        cell = {"model": name} | ({} if word is None else {"set": word})
        case = Case.from_dict(changed(LINE, {"cell": cell}))
        assert case.cell == made(name, word)
        assert None not in case.parameters["cell"].values()
        (tmp_path / "case.toml").write_text(case.to_toml(), encoding="utf-8")
        again = Case.from_file(tmp_path / "case.toml")
        assert again.cell == case.cell
        assert again.parameters == case.parameters
    changes = ["cell.set=ENDO", "cell.tau_w1m=70"]
    case = write_case(tmp_path / "epi.toml", changed(LINE, {"cell": {"model": "BuenoOrovio2008"}}))
    first = Case.from_file(case, changes)
    assert first.cell == made("BuenoOrovio2008", "ENDO", tau_w1m=70.0)
    (tmp_path / "resolved.toml").write_text(first.to_toml(), encoding="utf-8")
    # What the user gave stays, what the former set gave goes.
    second = Case.from_file(tmp_path / "resolved.toml", ["cell.set=M", "cell.tau_si=3.0"])
    assert second.cell == made("BuenoOrovio2008", "M", tau_w1m=70.0, tau_si=3.0)
    assert Case.from_file(tmp_path / "resolved.toml", ["time.end=0.02"]).cell == first.cell
    with pytest.raises(InputError, match=r"^cell\.set: 'X' is not a set"):
        Case.from_file(tmp_path / "resolved.toml", ["cell.set=X"])
    with pytest.raises(
        InputError, match=r'^cell\.set: this is "ENDO", but the numbers .* all those of "EPI"'
    ):
        dataclasses.replace(made("BuenoOrovio2008", "EPI"), set="ENDO")


def test_another_set_of_a_resolved_human_membrane(tmp_path):
    """The same where a second word chooses numbers, the slope."""
    human = {"model": "TenTusscherPanfilov2006", "set": "ENDO", "slope": 1.4}
    case = Case.from_dict(changed(LINE, {"cell": human, "activation.beta": 1e-3}))
    (tmp_path / "case.toml").write_text(case.to_toml(), encoding="utf-8")
    other = Case.from_file(tmp_path / "case.toml", ["cell.set=M", "cell.slope=0.7"])
    assert other.cell == ms.membranes.TenTusscherPanfilov2006(set="M", slope=0.7)


@pytest.mark.parametrize(
    "cell, message",
    [
        (
            {"model": "BuenoOrovio2008", "set": "EDNO"},
            r"^cell\.set: 'EDNO' is not a set .*; did you mean 'ENDO'\? \(known: ENDO, EPI, M, PB, TNNP\)$",
        ),
        ({"model": "FentonKarma1998", "set": "Set 2"}, r"^cell\.set: 'Set 2' is not a set .*known: MLR-I"),
        ({"model": "FentonKarma1998", "set": 3}, r"^cell\.set: give a text, not 3$"),
        ({"model": "BuenoOrovio2008", "tau_w1": 60.0}, r"^cell\.tau_w1: no such key; .* 'tau_w1m'"),
        ({"model": "LuoRudy1991", "set": "EPI"}, r"^cell\.set: no such key"),
        ({"model": "LuoRudy1991", "g_na": 3.0}, r"^cell\.g_na: no such key; did you mean 'g_Na'\?"),
        ({"model": "LuoRudy1991", "Ko": 0.0}, r"^cell\.Ko: .*greater than 0, not 0\.0$"),
        ({"model": "AlievPanfilov1996", "a": 1.0}, r"^cell\.a: .*less than 1, not 1\.0$"),
        ({"model": "BuenoOrovio"}, r"^cell\.model: 'BuenoOrovio' is not known here; .* 'BuenoOrovio2008'"),
    ],
)
def test_what_no_membrane_is(cell, message):
    """One message that names the key and the nearest known word."""
    with pytest.raises(InputError, match=message):
        Case.from_dict(changed(LINE, {"cell": cell}))


def test_the_table_of_the_docs():
    """docs/membranes.md: the table holds the numbers that the tenth beats are compared with."""
    page = (Path(__file__).parents[2] / "docs" / "membranes.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in page.splitlines()]
    found = {(row[0], row[1] or None): row[2:] for row in rows if row[0] in MODELS and len(row) == 6}
    assert found.keys() == set(ALL)
    for (name, word), (rest, peak, apd, calcium) in found.items():
        expected = reference(BEATS, name, word)["10"]
        near = 0.051 if MODELS[name].potential_unit == "mV" else 5.1e-4
        assert float(rest.replace("−", "-")) == pytest.approx(expected["rest"], abs=near)
        assert float(peak) == pytest.approx(expected["peak"], abs=near)
        assert float(apd) == pytest.approx(expected["apd90"], abs=0.051)
        assert (calcium != "") == (MODELS[name].calcium is not None)
        if calcium:
            assert float(calcium.split()[0]) == pytest.approx(expected["calcium_peak"], abs=5.1e-4)
            assert float(calcium.split()[2]) == pytest.approx(expected["calcium_time"], abs=0.51)
