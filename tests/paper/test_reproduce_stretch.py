"""The chapters on stretch currents: thresholds and estimates against SciPy, verdicts from the numbers."""

import myostrain as ms
from myostrain.reproduce.chapters.stretch_feedback import numbers as feedback
from myostrain.reproduce.chapters.stretch_feedback.numbers import readings as of_feedback
from myostrain.reproduce.chapters.stretch_threshold import jobs, numbers
from myostrain.reproduce.chapters.stretch_threshold.numbers import readings
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements import (
    clamped_sheet,
    matched,
    premature,
    stretch_threshold,
    stretched_lines,
)
from myostrain.reproduce.verdict import claims, judge
from myostrain.theory import least_drive, least_drive_of_a_cubic

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

ALIEV_PANFILOV = {"model": "AlievPanfilov1996"}


def rates(t, y, drive, k=8.0, a=0.15, eps0=0.002, mu1=0.2, mu2=0.3):
    """Aliev and Panfilov's equations with a stretch current, written again."""
    v, r = y
    current = k * v * (v - a) * (v - 1) + v * r + drive * (v - 1)
    return [-current, (eps0 + mu1 * r / (v + mu2)) * (-r - k * v * (v - a - 1))]


def independent_threshold():
    """The drive from which on SciPy's solve_ivp sees a point fire, by bisection."""

    def fires(drive):
        found = solve_ivp(rates, (0, 80), [0.0, 0.0], args=(drive,), rtol=1e-8, atol=1e-10)
        return found.y[0].max() > 0.5

    low, high = 0.04, 0.08
    while high - low > 1e-6:
        middle = (low + high) / 2
        low, high = (low, middle) if fires(middle) else (middle, high)
    return high


def fires(stretch, g, ramp=0.0):
    """Whether a line fires in the program that is held at a stretch, or brought there within a time."""
    line, current = stretch_threshold.held_line(stretch, ramp, np.inf), [ms.StretchCurrent(conductance=g)]
    model = ms.membranes.AlievPanfilov1996()
    return stretch_threshold.excited(line, model, current, 0.2, 60.0, since=ramp, balance="advective")[0]


@pytest.mark.parametrize("g", [0.7, 2.5])
def test_the_threshold_of_a_held_line_is_that_of_an_independent_integrator(g):
    """The chapter's threshold of g (λ − 1), 0.054013, is SciPy's, and the program's for other g."""
    exact = independent_threshold()
    assert exact == pytest.approx(0.054013, abs=2e-6)
    assert fires(1 + 0.996 * exact / g, g) is None
    assert fires(1 + 1.004 * exact / g, g) is not None


@pytest.mark.parametrize("k, a", [(8.0, 0.15), (8.0, 0.05), (30.0, 0.3)])
def test_the_estimate_is_where_two_equilibria_meet(k, a):
    """least_drive: beyond it the membrane "has nowhere to stop before its threshold", k a²/4 of a cubic."""
    found = least_drive(ms.membranes.AlievPanfilov1996(k=k, a=a), 1.0)
    assert found == pytest.approx(least_drive_of_a_cubic(k, a), rel=1e-6)

    def current(v, drive):
        return k * v * (v - a) * (v - 1) + drive * (v - 1)

    below = brentq(current, 0.0, a / 2, args=(0.999 * found,))
    assert 0 < below < a / 2
    assert np.all(current(np.linspace(0, 0.5, 10001), 1.001 * found) < 0)


def test_the_estimate_of_a_membrane_in_millivolts():
    """least_drive: any membrane and reversal, here a passive one whose current is 0.1 (v + 80)."""

    class Leak(ms.membranes.Membrane):
        range, threshold = (-80.0, 40.0), -40.0

        def resting_potential(self):
            return -80.0

        def current(self, v, states):
            return 0.1 * (v + 80)

    assert least_drive(Leak(), -10.0) == pytest.approx(0.1 * 40 / 30, rel=1e-3)


def test_without_a_current_nothing_is_excited_and_with_one_it_is():
    """unexcited: "Bodies without a stretch current"; the same with one would be seen."""
    found = stretch_threshold.unexcited(ALIEV_PANFILOV, "conservative", 1.4, 0.2, 2.0).numbers
    assert found == {"held": 0.0, "moved": 0.0, "sheared": 0.0}
    line = stretch_threshold.held_line(1.4, 1.0, np.inf)
    current = [ms.StretchCurrent(conductance=1.0)]
    assert stretch_threshold.excited(line, ms.membranes.AlievPanfilov1996(), current, 0.2, 5.0)[0] < 4.0


def test_a_slow_stretch_is_that_of_an_independent_integrator():
    """A line whose end is moved within 20: SciPy's drive s t/T, held from T on, has the same threshold."""

    def peak(drive):
        ramp = solve_ivp(lambda t, y: rates(t, y, drive * t / 20), (0, 20), [0.0, 0.0], rtol=1e-8, atol=1e-10)
        rest = solve_ivp(rates, (20, 60), ramp.y[:, -1], args=(drive,), rtol=1e-8, atol=1e-10)
        return max(ramp.y[0].max(), rest.y[0].max())

    threshold = brentq(lambda drive: peak(drive) - 0.5, 0.05, 0.2, xtol=1e-5)
    assert threshold > 1.2 * 0.054013
    assert fires(1 + 0.985 * threshold, 1.0, ramp=20.0) is None
    assert fires(1 + 1.015 * threshold, 1.0, ramp=20.0) is not None


def test_held_points_rest_where_cubic_and_recovery_add_up():
    """held_on: fired or not, v = s/(k a + s) in the end."""
    drives = [0.03, 0.2, 1.0]
    found = stretch_threshold.held_on(ALIEV_PANFILOV, drives, 0.2, 120.0)
    assert found.numbers["fired"] == [False, True, True]
    s = np.array(drives)
    np.testing.assert_allclose(found.arrays["potential"][-1], s / (8 * 0.15 + s), rtol=1e-4)


def numbers_of(drive=0.054):
    """Numbers as the chapter makes them."""
    one = {"estimate": 0.045, "mean_drive": drive, "spread": 1e-3}
    return {
        "thresholds": {"AlievPanfilov1996": one, "FitzHughNagumo": {**one, "mean_drive": 0.23}},
        "largest_without": 0.0,
        "closed_form_error": 1e-9,
        "segments": {"drive": [0.09, 0.056]},
        "ramp": {"stretch": [1.055, 1.13]},
        "brief": {"stretch": [1.2, 1.07]},
        "held": {"largest_swing": 1e-8, "first_fired": 0.056, "last_silent": 0.053},
    }


@pytest.mark.parametrize(
    "changed, claim",
    [
        ({}, None),
        ({"largest_without": 1e-9}, "without"),
        ({"segments": {"drive": [0.06, 0.056]}}, "part"),
        ({"ramp": {"stretch": [1.055, 1.06]}}, "rapid"),
        ({"brief": {"stretch": [None, 1.07]}}, "rapid"),
        ({"held": {"largest_swing": 0.5, "first_fired": 0.056, "last_silent": 0.053}}, "once"),
        ({"thresholds": numbers_of(0.044)["thresholds"]}, "with"),
    ],
)
def test_verdicts_follow_from_the_numbers(changed, claim):
    """Each claim fails when its numbers do, and no other one with it."""
    read = readings(numbers_of() | changed)
    failed = [
        name for name, one in claims("stretch-threshold").items() if judge(one, read[name]).kind != "agrees"
    ]
    if claim == "with":  # what others are measured by
        assert claim in failed
    else:
        assert failed == ([] if claim is None else [claim])


def test_numbers_of_the_outcomes():
    """From made-up outcomes: mean and spread of drives, estimates beside closed forms, which points fired."""
    estimates = {"AlievPanfilov1996": 0.045, "FitzHughNagumo": 0.26, "MitchellSchaeffer2003": 0.01}
    found = {name: Found({"drive": [0.05, 0.06], "estimate": estimates[name]}) for name in jobs.MEMBRANES}
    still = {"held": 0.0, "moved": 1e-17, "sheared": 0.0}
    both = ("conservative", "advective")
    found |= {f"{name} {balance}": Found(dict(still)) for name in jobs.WITHOUT for balance in both}
    found[f"{list(jobs.WITHOUT)[-1]} advective"].numbers["sheared"] = 1e-3
    found |= {name: Found({"stretch": [1.1, 1.2]}) for name in ("ramp", "brief")}
    fired = {"fired": [False, False, True, True], "swing": [1e-8, 2e-8, 1e-5, 0.0]}
    found |= {
        "segments": Found({"drive": [0.09, 0.06]}),
        "held": Found(fired, {"drives": np.array([0.03, 0.05, 0.06, 2.0])}),
    }
    made = numbers.numbers(found, True)
    assert made["largest_without"] == 1e-3
    assert made["thresholds"]["AlievPanfilov1996"]["mean_drive"] == pytest.approx(0.055)
    assert made["thresholds"]["AlievPanfilov1996"]["spread"] == pytest.approx(0.01 / 0.055)
    assert made["closed_form_error"] == pytest.approx(0.04)
    held = made["held"]
    assert (held["last_silent"], held["first_fired"], held["largest_swing"]) == (0.05, 0.06, 1e-5)


@pytest.mark.parametrize(
    "silent, beats, pacemaker", [(None, 3.0, True), (None, 2.9, False), (50.0, 4.0, False)]
)
def test_what_a_pacemaker_is(silent, beats, pacemaker):
    """ "a pacemaker has three upstrokes at least by t = 60 and goes on"."""
    judged = feedback._judged(Found({"silent": silent, "beats": beats}, {"excited": np.array([0.1, 0.4])}))
    assert (judged["pacemaker"], judged["widest"]) == (pacemaker, 0.4)


# What a stretch current does on clamped bodies.


def test_strain_is_the_stress_that_is_matched_but_for_the_softening():
    """matched: Jo W(F Fo⁻¹) of a neo-Hookean body is Jo times its energy with T = μ ((1 − β)⁻² − 1)."""
    beta, mu = 0.3, 1.7
    tension = matched.matched(beta, "free", mu)
    assert matched.matched(beta, "held", mu) == pytest.approx((1 - beta) * tension)
    rng = np.random.default_rng(3)
    for axes in ((0,), (0, 1)):
        Fo = np.diag([1 - beta if axis in axes else 1.0 for axis in range(3)])
        F = np.eye(3) + 0.2 * rng.standard_normal((3, 3))
        active = np.linalg.det(Fo) * mu / 2 * ((F @ np.linalg.inv(Fo)) ** 2).sum()
        passive = mu / 2 * (F**2).sum() + tension / 2 * sum((F[:, axis] ** 2).sum() for axis in axes)
        assert active == pytest.approx(np.linalg.det(Fo) * passive, rel=1e-12)


@pytest.mark.parametrize("approach", ["strain in plane", "stress in plane"])
def test_free_squares_shorten_by_the_same(approach):
    """activation_of, "stress" (matched free), in plane: a free sheet shortens to (1 − β)^⅓."""
    active, _ = matched.activation_of(approach, 0.3, 10.0, 1.0)
    body = ms.build(
        ms.geometry.Rectangle(size=(2.0, 2.0), spacing=1.0), ms.UniformFibres(direction=(1.0, 0.0))
    )
    mechanics = ms.Mechanics(
        body, kinematics=ms.kinematics.PlaneStress(), material=ms.materials.NeoHookean(), active=active
    )
    value = -0.3 if approach.startswith("strain") else matched.matched(0.3, "free")
    mechanics.activation.x.array[:] = value
    mechanics.start()
    assert mechanics.fibre_stretch() == pytest.approx(0.7 ** (1 / 3), abs=1e-8)


def test_strain_and_stress_follow_with_the_same_time_constants():
    """activation_of: the laws' states rise and fall alike where β v and the tension are scaled to one."""
    laws = [matched.activation_of(f"{kind}", 0.3, 10.0, 1.0)[1] for kind in ("strain", "stress")]
    scales = (-0.3, matched.matched(0.3, "free"))
    for v, before in ((1.0, 0.2), (0.0, 0.7)):
        after = [
            law.advance(np.array([[before * scale]]), {"excitation": np.array([v])}, 0.5)[0, 0] / scale
            for law, scale in zip(laws, scales, strict=True)
        ]
        exact = v + (before - v) * np.exp(-0.5 / (10.0 if v > 0.05 else 1.0))
        assert after == pytest.approx([exact, exact], rel=1e-12)


def test_when_a_point_can_be_excited_again_is_that_of_an_independent_integrator():
    """window: the earliest delay after which a stretch excites, against SciPy, to two steps."""
    found = stretched_lines.window(ALIEV_PANFILOV, [0.2], 10.0, 0.2, 45.0).numbers
    course = solve_ivp(rates, (0, 45), [1.0, 0.0], args=(0.0,), rtol=1e-9, atol=1e-11, dense_output=True).sol
    assert found["duration"] == pytest.approx(brentq(lambda t: course(t)[0] - 0.5, 15, 40), abs=0.02)

    def fires(delay):
        again = solve_ivp(rates, (0, 10), course(delay), args=(0.2,), rtol=1e-9, atol=1e-11)
        return again.y[0].max() >= 0.5

    (earliest,) = found["earliest"]
    assert fires(earliest + 0.4)
    assert not fires(earliest - 0.4)


def test_the_vulnerable_window_is_that_of_an_independent_integrator():
    """premature.window without contraction: its borders are between delays at which SciPy's line differs."""
    given = {"beta": 0.0, "length": 30.0, "spacing": 1.0, "strength": 1.0, "lasting": 1.0, "half": 2.5}
    found = premature.window(ALIEV_PANFILOV, conductance=0.0, step=0.25, apart=1.0, **given).numbers
    X = np.linspace(0.0, 30.0, 31)

    def line(t, y, begin):
        v, r = y.reshape(2, -1)
        beyond = np.concatenate([v[1:2], v, v[-2:-1]])
        pulse = np.where((begin <= t <= begin + 1) & (np.abs(X - 15) <= 2.5), 1.0, 0.0)
        dv, dr = rates(t, [v, r], 0.0)
        return np.concatenate([dv + np.diff(beyond, 2) + pulse, dr])

    def run(y, begin, end, stimulated):
        return solve_ivp(
            line, (begin, end), y, args=(stimulated,), max_step=0.5, rtol=1e-4, atol=1e-6, dense_output=True
        )

    first = run(np.concatenate([0.9 * (X <= 5), 0 * X]), 0.0, 60.0, np.inf).sol
    upstroke = brentq(lambda t: first(t)[15] - 0.5, 0.1, 15.0)
    assert found["upstroke"] == pytest.approx(upstroke, abs=0.2)

    def ways(delay):
        again = run(first(upstroke + delay), upstroke + delay, upstroke + delay + 25, upstroke + delay)
        v = again.sol(np.linspace(upstroke + delay, upstroke + delay + 25, 200))[:31]
        return tuple((np.diff((v[node] > 0.5).astype(int)) > 0).any() for node in (5, 25))

    assert [ways(found["back"] + late) for late in (-2, 2)] == [(False, False), (True, False)]
    assert [ways(found["forth"] + late) for late in (-2, 2)] == [(True, False), (True, True)]


def test_upstrokes_are_counted():
    """sheet: "the mean number of upstrokes over the sheet, the first included", their times and intervals."""
    values = np.array([[1.0, 0.0], [0.2, 0.6], [0.7, 0.1], [0.2, 0.1], [0.8, 0.1]])
    counted = clamped_sheet._Upstrokes(values[0], 0.5)
    for time, v in enumerate(values[1:], start=1):
        counted.look(float(time), v)
    assert counted.count.tolist() == [3, 1]
    assert counted.first.tolist() == [0, 1]
    assert counted.second[0] == 2
    assert np.isnan(counted.second[1])
    assert counted.period() == 2.0
    assert counted.excited(np.array([1.0, 3.0])) == 0.25


def test_a_square_is_excited_once_or_again_and_again():
    """sheet, threshold: without a current one wave; on a small square with a large one it goes on."""
    given = {
        "membrane": {"model": "QuickRecovery"},
        "approach": "stress in plane",
        "size": 40.0,
        "spacing": 2.0,
        "step": 0.25,
        "every": 4,
        "center": (0.5, 0.5),
    }
    once = clamped_sheet.sheet(conductance=0.0, end=40.0, **given)
    assert once.numbers["beats"] == pytest.approx(1.0, abs=0.01)
    assert once.numbers["silent"] < 40
    assert once.numbers["stretched"] == 0.0
    again = clamped_sheet.sheet(conductance=6.0, end=40.0, **given)
    assert again.numbers["silent"] is None
    assert again.numbers["beats"] > 2


def feedback_numbers():
    """Numbers as the chapter makes them."""

    def one(beats, drive, silent=None):
        return {"beats": beats, "silent": silent, "first_drive": drive}

    return {
        "lines": {str(g): {"middle": t, "beats": 1} for g, t in enumerate((19.0, 9.0, 5.0, 3.6))},
        "free_difference": 0.0,
        "quick": {
            "strain": {"3": one(1.0, 0.05, 28.0)},
            "strain in plane": {"2": one(1.0, 0.028, 28.0), "3": one(4.4, 0.04)},
            "stress in plane": {"2": one(4.6, 0.04)},
            "stress, held in plane": {"2": one(3.8, 0.031)},
        },
        "slow": {"strain": {"3": one(1.0, 0.15, 46.0)}},
        "window": {
            "slow": {"earliest": [40.0], "duration": 26.0},
            "quick": {"earliest": [6.8], "duration": 4.35},
        },
        "premature": {
            "0": {"back": 26.0, "forth": 34.0, "width": 8.0},
            "0.2": {"back": 23.6, "forth": 26.0, "width": 2.4},
        },
        "spirals": {
            "strain": {
                "0": {"period": 34.0, "drift": 0.03, "silent": False},
                "0.5": {"period": 40.0, "drift": 0.19, "silent": False},
                "1": {"period": None, "drift": None, "silent": True},
            }
        },
    }


@pytest.mark.parametrize(
    "path, value, claim",
    [
        (("free_difference",), 1e-17, "line"),
        (("lines", "2", "middle"), 8.9, "line"),
        (("quick", "strain in plane", "3", "silent"), 50.0, "pacemaker"),
        (("quick", "strain", "3", "beats"), 1.2, "fibre"),
        (("quick", "stress, held in plane", "2", "first_drive"), 0.04, "strain-and-stress"),
        (("slow", "strain", "3", "beats"), 2.0, "aliev-panfilov"),
        (("window", "slow", "earliest", 0), None, "window"),
        (("premature", "0.2", "width"), 5.2, "vulnerable"),
        (("premature", "0", "width"), None, "vulnerable"),
        (("spirals", "strain", "0.5", "drift"), 0.04, "spiral"),
        (("spirals", "strain", "1", "silent"), False, "spiral"),
        ((), None, None),
    ],
)
def test_verdicts_on_feedback_follow_from_the_numbers(path, value, claim):
    """Each claim fails when one of its numbers does, and no other with it."""
    numbers = feedback_numbers()
    if path:
        *way, last = path
        place = numbers
        for key in way:
            place = place[key]
        place[last] = value
    read = of_feedback(numbers)
    failed = [n for n, one in claims("stretch-feedback").items() if judge(one, read[n]).kind != "agrees"]
    assert failed == ([] if claim is None else [claim])
