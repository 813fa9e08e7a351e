"""Activation laws with a time of their own, by themselves: closed forms, and independent integrators."""

import itertools
from pathlib import Path

import myostrain as ms
from myostrain.activation import (
    Bestel2001,
    GoektepeKuhl2010,
    Hunter1998,
    NashPanfilov2004,
    Rossi2014,
    Timed,
)
from myostrain.activation.force_length import force_length
from myostrain.activation.units import conversion
from myostrain.mechanics import Bestel2001Pressure

import numpy as np
import pytest
from scipy.integrate import solve_ivp

DATA = Path(__file__).parents[1] / "data"


def integrated(rate, start, end, **options):
    """The end of an ordinary differential equation, by an implicit integrator of another library."""
    return solve_ivp(rate, (0, end), [start], "LSODA", rtol=1e-11, atol=1e-13, **options).y[0, -1]


# Rossi et al. 2014.


@pytest.mark.parametrize(
    "length, share", [(1.8, 0.686), (1.95, 0.886), (2.2, 0.980), (2.4, 0.549), (1.69, 0.0), (2.61, 0.0)]
)
def test_force_over_length(length, share):
    """force_length: published values, and zero outside 1.7 to 2.6 μm."""
    assert force_length(length / 1.95) == pytest.approx(share, abs=5e-4)
    assert force_length(length / 2.1, sarcomere=2.1) == pytest.approx(share, abs=5e-4)


def test_force_over_length_is_never_negative():
    """The series is −0.02 at 1.7 μm."""
    shares = force_length(np.linspace(0.0, 2.0, 2001))
    assert shares.min() == 0.0
    assert np.count_nonzero(shares) > 400


RNG = np.random.default_rng(7)
CALCIUM, STRETCH = RNG.uniform(0.05, 1.2, 40), RNG.uniform(0.8, 1.2, 40)


@pytest.mark.parametrize(
    "law", [Rossi2014(), Rossi2014(alpha=-9.0, c0=0.1, mu=500.0, sarcomere=2.1)], ids=["published", "other"]
)
def test_rossi_tends_to_its_equilibrium(law):
    """Rossi2014: γ = (1 − F/(2 I4f))^(−1/3) − 1 for frozen calcium and stretch, from both sides."""
    force = law.alpha * np.maximum(CALCIUM - law.c0, 0) ** 2 * force_length(STRETCH, law.sarcomere)
    wanted = (1 - force / (2 * STRETCH**2)) ** (-1 / 3) - 1
    assert -0.5 < wanted.min() < -0.1
    drivers = {"calcium": CALCIUM, "stretch": STRETCH}
    for start in (-0.4, 0.0, 0.5):
        found = law.advance(np.full((1, 40), start), drivers, 1e9)
        np.testing.assert_allclose(found[0], wanted, rtol=0, atol=1e-13)
    # and stays there, whatever the step
    for step in (1e-9, 1.0, 1e3):
        np.testing.assert_allclose(law.advance(wanted[None], drivers, step)[0], wanted, rtol=0, atol=1e-13)


@pytest.mark.parametrize("step", [1e-3, 0.3, 10.0, 200.0])
@pytest.mark.parametrize("start", [-0.6, -0.1, 0.0, 0.4])
def test_rossi_steps_exactly(start, step):
    """Rossi2014, "The step is exact for frozen calcium and stretch": as the equation, integrated by SciPy."""
    law = Rossi2014(mu=700.0, alpha=-7.0)
    c, stretch = CALCIUM[:6], STRETCH[:6]
    found = law.advance(np.full((1, 6), start), {"calcium": c, "stretch": stretch}, step)
    for node in range(6):
        force = law.alpha * max(c[node] - law.c0, 0) ** 2 * force_length(stretch[node])

        def rate(_, gamma, node=node, force=force):
            passive = 2 * stretch[node] ** 2 * ((1 + gamma) ** -3 - 1)
            return (force + passive) / (law.mu * c[node] ** 2)

        assert found[0, node] == pytest.approx(integrated(rate, start, step), abs=1e-9)


def test_rossi_at_extremes():
    """No calcium, hardly any stretch left, a start that is nearly crushed, no node: finite, at the limit."""
    law = Rossi2014()
    with np.errstate(all="raise", under="ignore"):
        crushed = law.advance(
            np.array([[-0.999, -0.1, 5.0]]),
            {"calcium": np.array([0.0, 1e-12, 3.0]), "stretch": np.array([1.0, 0.3, 1.9])},
            0.5,
        )
        empty = law.advance(np.zeros((1, 0)), {"calcium": np.zeros(0), "stretch": np.zeros(0)}, 0.5)
    np.testing.assert_allclose(crushed[0, :2], 0.0, atol=1e-12)  # without calcium nothing resists the force
    assert 0 < crushed[0, 2] < 5.0
    assert empty.shape == (1, 0)


def transient(law, calcium, step, end, stretch):
    """γ over time by the law's steps, drivers at the middle of each; ``stretch`` of γ."""
    gamma, times = [np.zeros((1, 1))], np.arange(0, end + step / 2, step)
    for before, after in itertools.pairwise(times):
        middle = np.array([calcium((before + after) / 2)])
        # The stretch at the middle, extrapolated as the coupling does.
        past = gamma[-1] + (gamma[-1] - gamma[-2]) / 2 if len(gamma) > 1 else gamma[-1]
        gamma.append(law.advance(gamma[-1], {"calcium": middle, "stretch": stretch(past[0])}, step))
    return times, np.array(gamma)[:, 0, 0]


STRETCHES = {"isometric": np.ones_like, "free": lambda gamma: 1 + gamma}


@pytest.mark.parametrize("held", STRETCHES)
@pytest.mark.parametrize(
    "parameters",
    [{}, {"mu": 10000.0}, {"mu": 500.0, "alpha": -6.0}, {"c0": 0.12, "sarcomere": 2.05}],
    ids=str,
)
def test_rossi_transients_of_a_given_calcium(parameters, held):
    """A transient of calcium: γ within 1 % of its peak of SciPy's, at a step of 0.5 ms."""

    def calcium(t):
        return 0.1 + 0.77 * t / 40 * np.exp(1 - t / 40)

    law, stretch = Rossi2014(**parameters), STRETCHES[held]
    times, found = transient(law, calcium, 0.5, 400.0, stretch)

    def rate(t, gamma):
        c, fibre = calcium(t), stretch(np.array(gamma))
        force = law.alpha * max(c - law.c0, 0) ** 2 * force_length(fibre, law.sarcomere)
        return (force + 2 * fibre**2 * ((1 + gamma) ** -3 - 1)) / (law.mu * c**2)

    solved = solve_ivp(rate, (0, 400.0), [0.0], "LSODA", t_eval=times, rtol=1e-9, atol=1e-11, max_step=2.0)
    largest = np.abs(solved.y[0]).max()
    assert largest > 0.01
    assert np.abs(found - solved.y[0]).max() < 0.01 * largest


BEATS = {
    # membrane, μ, λ: γ at its lowest, and when after the upstroke, paced at 1 Hz
    "TTP06 isometric": ("TenTusscherPanfilov2006", 5000.0, "isometric", -0.0348, 167.0),
    "TTP06 free": ("TenTusscherPanfilov2006", 5000.0, "free", -0.0343, None),
    "BOCF isometric": ("BuenoOrovio2008", 5000.0, "isometric", -0.0468, 200.0),
    "BOCF free": ("BuenoOrovio2008", 5000.0, "free", -0.0455, None),
    "BOCF fast": ("BuenoOrovio2008", 500.0, "isometric", -0.1286, 113.0),
    "BOCF fast free": ("BuenoOrovio2008", 500.0, "free", -0.0994, None),
}


@pytest.fixture(scope="module")
def paced():
    """Time, calcium and potential of a beat at 1 Hz: Bueno-Orovio's fifth, of a file ten Tusscher's tenth."""
    cell = ms.cell(ms.membranes.BuenoOrovio2008(), beats=5)
    last = cell.time >= 4000.0
    table = np.loadtxt(DATA / "ten_tusscher_panfilov_2006_epi_1hz.csv", delimiter=",", skiprows=1)
    time, potential, calcium = table.T
    return {
        "BuenoOrovio2008": (cell.time[last] - 4000.0, cell.states["s"][last], cell.potential[last]),
        "TenTusscherPanfilov2006": (time, calcium, potential),
    }


@pytest.mark.parametrize("case", BEATS)
def test_rossi_with_paced_membranes(paced, case):
    """Rossi2014, "these γ is weak, some −0.035 to −0.05": contraction by the calcium of ten Tusscher and
    Bueno-Orovio, against numbers that another program computed; γ to 0.5 %, its time to 6 ms (of which 5 are
    the file's).
    """
    name, mu, held, lowest, when = BEATS[case]
    time, calcium, potential = paced[name]
    times, gamma = transient(
        Rossi2014(mu=mu), lambda t: np.interp(t % 1000, time, calcium), 1.0, 2000.0, STRETCHES[held]
    )
    last = times >= 1000.0
    assert gamma[last].min() == pytest.approx(lowest, rel=5e-3)
    if when is not None:
        upstroke = 1000 + time[np.argmax(potential > 0.0)]
        assert times[last][gamma[last].argmin()] - upstroke == pytest.approx(when, abs=6.0)


# γ over time.


def test_timed_form():
    """Timed: γ_min sin²(π (t − start)/(end − start)), and again after a period."""
    law = Timed(gamma_min=-0.13, start=170.0, end=480.0, period=1000.0)
    for time in (0.0, 170.0, 200.0, 325.0, 470.0, 480.0, 999.0):
        inside = 170 < time < 480
        wanted = -0.13 * np.sin(np.pi * (time - 170) / 310) ** 2 if inside else 0.0
        for beat in (0, 1, 7):
            found = law.activation((), {"time": time + 1000 * beat})
            assert found == pytest.approx(wanted, abs=1e-12)
    assert law.activation((), {"time": 325.0}) == pytest.approx(-0.13, rel=1e-14)
    once = Timed(gamma_min=-0.13, start=170.0, end=480.0)
    assert once.activation((), {"time": 1325.0}) == 0.0


def test_timed_table():
    """Timed: a table joined by straight lines, once or periodic."""
    table = ((10.0, 0.0), (20.0, -0.2), (50.0, 0.0))
    once, periodic = Timed(table=table), Timed(table=table, period=100.0)
    for law in (once, periodic):
        assert [law.activation((), {"time": t}) for t in (0.0, 15.0, 20.0, 35.0, 90.0)] == pytest.approx(
            [0.0, -0.1, -0.2, -0.1, 0.0]
        )
    assert periodic.activation((), {"time": 415.0}) == pytest.approx(-0.1)
    assert once.activation((), {"time": 415.0}) == 0.0
    assert Timed(table=-0.1).activation((), {"time": 3.0}) == -0.1


@pytest.mark.parametrize(
    "given, said",
    [
        ({}, "give gamma_min, start and end, or a table"),
        ({"gamma_min": -0.1, "start": 1.0}, "give gamma_min, start and end, or a table"),
        ({"gamma_min": -0.1, "start": 2.0, "end": 2.0}, "end = 2.0 should be later than start = 2.0"),
        ({"gamma_min": -1.0, "start": 1.0, "end": 2.0}, "gamma_min"),
        ({"gamma_min": -0.1, "table": ((0.0, 0.0),)}, "a table takes the place of"),
        ({"table": ((0.0, 0.0), (1.0, -1.2))}, "γ in the table should be greater than -1"),
        ({"table": ((1.0, 0.0), (0.0, -0.1))}, "ascending times"),
        ({"gamma_min": -0.1, "start": 1.0, "end": 3.0, "period": 2.0}, "from 0 to the period 2.0"),
        ({"table": ((0.0, 0.0), (1.0, -0.1)), "period": 1.0}, "end as it begins"),
    ],
)
def test_wrong_timed_laws(given, said):
    """Timed: what is no course of γ is refused."""
    with pytest.raises(ms.InputError, match=said):
        Timed(**given)


# Tensions.


@pytest.mark.parametrize("above", [10.0, 0.1])
@pytest.mark.parametrize("v", [-0.2, 0.0, 0.04, 0.06, 1.0])
def test_nash_panfilov_steps_exactly(v, above):
    """NashPanfilov2004: dTa/dt = ε(v) (kTa v − Ta), ε = rate below 0.05 and above · rate from there on."""
    law, step = NashPanfilov2004(tension=47.9, rate=0.8, above=above), 0.7
    found = law.advance(np.array([[0.0, 30.0]]), {"excitation": np.full(2, v)}, step)
    rate = 0.8 if v < 0.05 else 0.8 * above
    for start, value in zip((0.0, 30.0), found[0], strict=True):
        solved = integrated(lambda _, tension: rate * (47.9 * max(v, 0) - tension), start, step)
        assert value == pytest.approx(solved, abs=1e-8)
    # Rises fast and falls slowly as published, the other way round in later papers.
    rise = law.advance(np.zeros((1, 1)), {"excitation": np.ones(1)}, 0.1)[0, 0]
    fall = law.advance(np.full((1, 1), 47.9), {"excitation": np.zeros(1)}, 0.1)[0, 0]
    assert (rise > 47.9 - fall) == (above > 1)


@pytest.mark.parametrize("v", [-86.0, -60.0, -31.0, -29.0, 30.0])
def test_goektepe_kuhl_steps_exactly(v):
    """GoektepeKuhl2010: dTa/dt = ε(V) (kT (V − Vr) − Ta), ε = ε₀ + (ε∞ − ε₀) exp(−exp(−ξ (V − Vs)))."""
    law, step = GoektepeKuhl2010(), 1.3
    found = law.advance(np.array([[0.0, 0.4]]), {"potential": np.full(2, v)}, step)
    rate = 0.1 + 0.9 * np.exp(-np.exp(-(v + 30)))
    for start, value in zip((0.0, 0.4), found[0], strict=True):
        solved = integrated(lambda _, tension: rate * (0.005 * max(v + 80, 0) - tension), start, step)
        assert value == pytest.approx(solved, abs=1e-9)


def test_goektepe_kuhl_has_no_overflow():
    """The double exponential of a steep switch."""
    with np.errstate(over="raise", invalid="raise"):
        law = GoektepeKuhl2010(steepness=1e3)
        found = law.advance(np.zeros((1, 2)), {"potential": np.array([-90.0, 40.0])}, 1e3)
    np.testing.assert_allclose(found[0], [0.0, 0.6], rtol=1e-12)


def test_hunter_tension():
    """Hunter1998: T (1 + β (λ − 1)) xⁿ/(xⁿ + c₅₀ⁿ), half at c₀ + c₅₀, zero below c₀, never negative."""
    law = Hunter1998()
    drivers = {"calcium": np.array([0.71, 0.1, 0.71, 0.71]), "stretch": np.array([1.0, 1.2, 1.1, 0.2])}
    np.testing.assert_allclose(law.activation((), drivers), [50.0, 0.0, 50 * 1.145, 0.0], rtol=1e-12)


# Units.


@pytest.mark.parametrize(
    "given, wanted, factor",
    [
        ("mM", "μM", 1e3),
        ("μM", "μM", 1.0),
        ("\N{MICRO SIGN}M", "μM", 1.0),
        ("V", "mV", 1e3),
        ("s", "ms", 1e3),
        ("ms", "μM", None),
        (None, "μM", None),
        ("furlong", "mV", None),
    ],
)
def test_units_are_converted(given, wanted, factor):
    """conversion: factors between units of one quantity."""
    found = conversion(given, wanted)
    assert found == (None if factor is None else pytest.approx(factor))


# Bestel, Clément, Sorine 2001.


def window(t, law):
    """f between systole and diastole, and g before diastole."""
    before = (1 + np.tanh((law.t_dias - t) / law.gamma)) / 2
    return (1 + np.tanh((t - law.t_sys) / law.gamma)) / 2 * before, before


@pytest.mark.parametrize(
    "changes", [{}, {"sigma_0": 2e5, "a_max": 9.0, "gamma": 0.02, "t_dias": 0.4}], ids=str
)
def test_bestel_beside_scipy(changes):
    """Bestel2001 and Bestel2001Pressure: the solutions of their equations, by an explicit integrator of order
    eight with short steps; measured 3e-7 of the peak. In any order of the times asked for."""
    law = Bestel2001(**changes)
    pressure = Bestel2001Pressure(**{k: v for k, v in changes.items() if k != "sigma_0"})

    def rates(t, y):
        a = [
            part.a_max * window(t, part)[0] + part.a_min * (1 - window(t, part)[0])
            for part in (law, pressure)
        ]
        g = window(t, pressure)[1]
        b = a[1] + pressure.alpha_pre * g + pressure.alpha_mid
        return (
            -abs(a[0]) * y[0] + law.sigma_0 * max(a[0], 0.0),
            -abs(b) * y[1] + pressure.sigma_mid * max(b, 0.0) + pressure.sigma_pre * g,
        )

    times = np.linspace(0.0, 1.2, 49)
    exact = solve_ivp(rates, (0, 1.2), [0.0, 0.0], "DOP853", times, rtol=1e-10, atol=1e-6, max_step=1e-3).y
    order = RNG.permutation(len(times))
    found = np.empty_like(exact)
    for i in order:
        found[:, i] = law.activation((), {"time": times[i]}), pressure.at(times[i])
    peaks = exact.max(axis=1, keepdims=True)
    assert peaks.min() > 1e4
    np.testing.assert_allclose(found / peaks, exact / peaks, rtol=0, atol=3e-6)


@pytest.mark.parametrize("cls", [Bestel2001, Bestel2001Pressure])
def test_bestel_refuses_what_is_no_beat(cls):
    """Diastole is later than systole; the fall falls."""
    with pytest.raises(ms.InputError, match="t_dias"):
        cls(t_dias=0.1)
    with pytest.raises(ms.InputError, match="a_min"):
        cls(a_min=1.0)
