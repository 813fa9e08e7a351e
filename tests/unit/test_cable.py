"""Conduction velocities against finite differences; the wanted one; no wave; wrong input."""

import json
from dataclasses import replace
from pathlib import Path

import myostrain as ms
from myostrain.conduction import Cable, Wave, measuring, travel

import numpy as np
import pytest

M = ms.membranes
DATA = Path(__file__).parents[1] / "data"

#: By a code that shares nothing with this one; what it is the file says.
KNOWN = json.loads((DATA / "conduction_velocities.json").read_text(encoding="utf-8"))


def aliev_panfilov(v, r):
    """As in docs/membranes.md, written down again."""
    rate = (0.002 + 0.2 * r / (v + 0.3)) * (-r - 8 * v * (v - 0.15 - 1))
    return -8 * v * (v - 0.15) * (v - 1) - v * r, rate


def mitchell_schaeffer(v, h):
    return h * v**2 * (1 - v) / 0.3 - v / 6, np.where(v < 0.13, (1 - h) / 120, -h / 150)


def finite_differences(rates, state, D, h, dt, length):
    """Velocity between 0.5 and 0.9 of a cable: central differences, classical Runge–Kutta method."""
    X = np.arange(round(length / h) + 1) * h
    y = np.array([np.full_like(X, value) for value in (np.where(length / 8 > X, 1.0, 0.0), state)])
    first, second = round(0.5 * length / h), round(0.9 * length / h)

    def slope(y):
        v, wide = y[0], np.pad(y[0], 1, mode="reflect")
        dv, dstate = rates(v, y[1])
        return np.array([dv + D / h**2 * (wide[2:] - 2 * v + wide[:-2]), dstate])

    times, t = [], 0.0
    for node in (first, second):
        while y[0, node] < 0.5:
            old, t = y[0, node], t + dt
            k1 = slope(y)
            k2 = slope(y + dt / 2 * k1)
            k3 = slope(y + dt / 2 * k2)
            y = y + dt / 6 * (k1 + 2 * k2 + 2 * k3 + slope(y + dt * k3))
        times.append(t - dt * (y[0, node] - 0.5) / (y[0, node] - old))
    return (X[second] - X[first]) / (times[1] - times[0])


@pytest.mark.parametrize(
    "membrane, rates, rest, D, h, length",
    [
        (M.AlievPanfilov1996(), aliev_panfilov, 0.0, 1.0, 0.5, 50.0),
        (M.MitchellSchaeffer2003(), mitchell_schaeffer, 1.0, 0.1, 0.2, 20.0),
    ],
)
def test_against_finite_differences(membrane, rates, rest, D, h, length):
    """The lumped mass on the same nodes is those differences; the velocity without their error is reported.

    Measured: 1e-4 on the same nodes, 5e-4 of the extrapolated ones.
    """
    coarse, fine = (finite_differences(rates, rest, D, x, 0.2 * x**2 / D, length) for x in (h, h / 2))
    beside = Cable(D, h, 0.02 if D == 1.0 else 0.05, length, 0.15 * length, (2.0, 1.0), 1.0, "lumped")
    assert travel(membrane, beside).velocity == pytest.approx(coarse, rel=5e-4)
    found = ms.cable(membrane, diffusivity=D)
    assert found.velocity == pytest.approx(fine + (fine - coarse) / 3, rel=1.5e-3)
    assert found.error < 1e-3 * found.velocity


SLOW = [pytest.param(*row, marks=pytest.mark.slow) for row in KNOWN["velocities"]]


@pytest.mark.parametrize(
    "name, parameters, D, converged, at_spacing",
    [row for row in KNOWN["velocities"] if row[0] == "BuenoOrovio2008" and row[1] == {"set": "EPI"}] + SLOW,
)
def test_against_other_codes(name, parameters, D, converged, at_spacing):
    """docs/membranes.md, the table: within 0.5 % of other codes, on their nodes and in the limit."""
    membrane = getattr(M, name)(**parameters)
    spacing, there = at_spacing
    strength, duration = membrane.pacing
    length = 300 * spacing if membrane.time_unit else 500 * spacing
    step = 0.2 * spacing if membrane.time_unit else 0.005 if name.startswith("A") else 0.001
    beside = Cable(D, spacing, step, length, 0.1 * length, (2 * strength, duration), 1.0, "lumped")
    assert travel(membrane, beside).velocity == pytest.approx(there, rel=5e-3)
    if converged is None:
        return
    found = ms.cable(membrane, diffusivity=D)
    assert found.velocity == pytest.approx(converged, rel=5e-3)
    assert found.error < 3e-3 * found.velocity


def test_the_extrapolation_cancels_an_error_of_second_order():
    """Of 2 (1 + 4 e) and 2 (1 + e) it is 2; the error is what it is from the finer mesh."""
    X = np.linspace(0.0, 10.0, 101)
    waves = [
        Wave(Cable(1.0, h, 0.01, 10.0, 1.0, (1.0, 1.0), 1.0), X, X / (2.0 * (1 + h**2)))
        for h in (0.2, 0.1, 0.05)
    ]
    found = measuring.Conducted(M.MitchellSchaeffer2003(), waves)
    assert found.velocity == pytest.approx(2.0, rel=1e-12)
    assert found.error == pytest.approx(2.0 * 0.05**2, rel=1e-9)


def test_velocity_goes_with_the_root_of_D():
    """On nodes that go with it: what is wanted is had at once, and the check run says so."""
    membrane = M.MitchellSchaeffer2003()
    found = ms.cable(membrane, velocity=0.5)
    assert found.off == pytest.approx(0.0, abs=1e-9)
    assert len(found.tried) == 2
    assert found.diffusivity == pytest.approx(0.1 * (0.5 / found.tried[0][1]) ** 2, rel=1e-9)
    assert ms.cable(membrane, diffusivity=found.diffusivity).velocity == pytest.approx(0.5, rel=1e-9)


def test_a_wanted_velocity_on_given_nodes():
    """On nodes too far apart v does not go with √D; D is found by the secant, for that mesh."""
    membrane = M.MitchellSchaeffer2003()
    found = ms.cable(membrane, velocity=0.3, spacing=0.5, mass="lumped")
    assert found.waves[0].cable.spacing == 0.5
    assert found.waves[0].velocity == pytest.approx(0.3, rel=1.1e-3)
    assert abs(found.off) < 1.1e-3
    assert len(found.tried) > 2
    assert found.velocity > 1.01 * found.waves[0].velocity


def test_no_wave_is_said():
    """Nodes too far apart; a stimulus that is too weak; a membrane that is not excitable."""
    bueno = M.BuenoOrovio2008()
    with pytest.raises(ms.ComputationError, match=r"no wave: it stops at X = .*Try: a smaller --spacing"):
        ms.cable(bueno, diffusivity=0.002, spacing=0.5, length=20.0)
    with pytest.raises(
        ms.ComputationError, match=r"no wave: the stimulus of 5 for 1 on .*stimulus\.strength"
    ):
        ms.cable(bueno, stimulus=(5.0, 1.0))
    blocked = M.LuoRudy1991(g_Na=0.0, g_si=0.0)
    with pytest.raises(ms.ComputationError, match="no wave: a single cell is not excited"):
        ms.cable(blocked)


class Restless(M.Membrane):
    """Fires everywhere, by itself."""

    states = ()
    pacing = (1.0, 1.0)

    def current(self, v, states):
        return v * 0.0 - 0.3


def test_a_membrane_that_excites_itself():
    """All nodes at once are no wave."""
    beside = Cable(1.0, 0.5, 0.01, 50.0, 5.0, (1e-6, 1.0), 10.0)
    with pytest.raises(ms.ComputationError, match="all of the cable is activated at once"):
        travel(Restless(), beside)


def test_how_steady_a_wave_is():
    """Velocity 1 in the first half of what is measured and 2 in the second; drawn from a straight line."""
    beside, X = Cable(1.0, 0.1, 0.1, 10.0, 1.0, (1.0, 1.0), 1.0), np.linspace(0, 10, 101)
    wave = Wave(beside, X, 3 + np.where(X < 7, X, 7 + (X - 7) / 2))
    assert wave.unsteady == pytest.approx(1.0)
    assert wave.fit(0.0, 0.7) == pytest.approx((1.0, 3.0))


def test_a_wave_that_is_not_steady_is_told(caplog, monkeypatch):
    """On a cable of given length by a warning; otherwise on a longer one."""
    monkeypatch.setattr(measuring, "STEADY", 1e-12)
    ms.cable(M.AlievPanfilov1996(), length=20.0)
    assert "the wave is not steady: its velocity changes by" in caplog.text
    monkeypatch.setattr(measuring, "LENGTHENED", 1)
    found = ms.cable(M.AlievPanfilov1996())
    assert "the wave is not steady: its velocity still changes by" in caplog.text
    assert found.waves[0].cable.length == pytest.approx(124.9, rel=1e-3)


@pytest.mark.parametrize(
    "given, message",
    [
        ({"diffusivity": 0.0}, "^diffusivity: 0: give a positive number"),
        ({"velocity": -1.0}, "^velocity: -1: give a positive number"),
        ({"spacing": float("nan")}, "^spacing: nan: give a positive number"),
        ({"length": 1.0}, "^length: 1: give at least .*, twenty nodes"),
        ({"spacing": 1e-6}, "^spacing: 1e-06: that makes"),
        ({"step": 100.0}, "^step: 100: the upstroke takes"),
        ({"mass": "consistent"}, "^mass: 'consistent' is not a mass matrix; allowed: lumped, averaged"),
    ],
)
def test_numbers_that_cannot_be(given, message):
    with pytest.raises(ms.InputError, match=message):
        ms.cable(M.MitchellSchaeffer2003(), **given)


def test_units_of_the_velocity():
    """cm/s from mm/ms and from mm/s; none where time has none."""
    found = ms.cable(M.MitchellSchaeffer2003())
    assert found.centimetres == 100.0
    assert np.isnan(replace(found, membrane=M.AlievPanfilov1996()).centimetres)
