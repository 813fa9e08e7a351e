"""What the chapters on delay and on human pulses measure with: courses, filters, pulses that travel."""

import copy
import functools
import operator

from myostrain.activation import Rossi2014
from myostrain.activation.force_length import force_length
from myostrain.reproduce.chapters.delay import jobs, numbers
from myostrain.reproduce.chapters.human_pulse import jobs as human_jobs
from myostrain.reproduce.chapters.human_pulse import numbers as human_numbers
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements import contraction, signals
from myostrain.reproduce.measurements.contraction import course_job, pulse, timing
from myostrain.reproduce.verdict import claims, judge

import numpy as np
import pytest
from scipy.integrate import solve_ivp

TIMES = np.linspace(0.0, 10.0, 4001)
HALF, TENTH = np.sqrt(np.log(2)), np.sqrt(np.log(10))


def bell(times, centre, width):
    return np.exp(-(((times - centre) / width) ** 2))


def test_when_a_place_contracts_and_for_how_long():
    """All of `timing` on bells, in closed form."""
    found = timing(TIMES, bell(TIMES, 3.0, 1.0), 0.2 * bell(TIMES, 4.0, 1.5))
    upstroke = 3.0 - HALF
    wanted = {
        "upstroke": upstroke,
        "excitation_peak": 1.0,
        "duration": 2 * HALF,
        "repolarization": HALF + TENTH,
        "peak": 0.2,
        "peak_delay": 4.0 - upstroke,
        "rise_delay": 4.0 - 1.5 * HALF - upstroke,
        "half_end": 4.0 + 1.5 * HALF - upstroke,
        "tenth_end": 4.0 + 1.5 * TENTH - upstroke,
        "half_length": 1.5,
        "tenth_length": (4.0 + 1.5 * TENTH - upstroke) / (HALF + TENTH),
        "delay_share": (4.0 - upstroke) / (HALF + TENTH),
    }
    assert found == pytest.approx(wanted, abs=2e-6, rel=2e-5)


def test_what_has_not_happened_is_none():
    """No upstroke, no contraction, a contraction that still grows, one that has not ended."""
    flat = np.zeros_like(TIMES)
    assert timing(TIMES, flat, flat)["upstroke"] is None
    none = timing(TIMES, bell(TIMES, 3.0, 1.0), flat)
    assert none["repolarization"] is not None
    assert none["peak_delay"] is None
    assert timing(TIMES, bell(TIMES, 3.0, 1.0), TIMES)["tenth_length"] is None
    open_end = timing(TIMES, bell(TIMES, 3.0, 1.0), bell(TIMES, 9.0, 2.0))
    assert open_end["peak_delay"] == pytest.approx(6.0 + HALF, abs=1e-5)
    assert open_end["tenth_length"] is None
    assert signals.last_fall(TIMES, np.cos(2 * np.pi * TIMES / 4), 0.0) == pytest.approx(9.0)


def test_a_pulse_that_travels():
    """sech² with x′ = 1 − s v: celerity, both widths and both steepnesses in closed form."""
    c, size, s = 2.0, 0.8, 0.3
    X = np.linspace(4, 14, 101)

    def v(X, t):
        return 1 / np.cosh((X - c * t) / size) ** 2

    lines = v(X, TIMES[:, None])
    arrival, stretch = contraction.arrivals(TIMES, lines, 1 - s * lines)
    np.testing.assert_allclose(arrival, (X - size * np.arccosh(np.sqrt(2))) / c, atol=1e-5)
    np.testing.assert_allclose(stretch, 1 - s / 2, atol=1e-9)
    arrays = {
        "times": TIMES,
        "excitation": v(10, TIMES),
        "shortening": s * v(10, TIMES),
        "X": X,
        "arrival": arrival,
    }
    width = 2 * size * np.arccosh(np.sqrt(2))
    y = np.linspace(0, 1, 100_001)
    assert pulse(arrays, (6.0, 10.0)) == pytest.approx(
        {
            "celerity": c,
            "width_material": width,
            "width_spatial": width - 2 * s * size * np.tanh(width / 2 / size),
            "steepness_material": 4 / (3 * np.sqrt(3)) / size,
            # v′ = 2 v √(1 − v)/size, over x′ = 1 − s v
            "steepness_spatial": (2 * y * np.sqrt(1 - y) / size / (1 - s * y)).max(),
        },
        rel=2e-5,
    )
    arrival[-1] = np.nan
    assert set(pulse(arrays, (6.0, 14.0)).values()) == {None}
    assert np.isnan(contraction.arrivals(TIMES, 0 * lines, lines)[0]).all()


def integrated(rate, sub=40):
    """A course by SciPy at every 40th of the times."""
    solution = solve_ivp(rate, (0, 10), [0.0], t_eval=TIMES[::sub], rtol=1e-9, atol=1e-11, max_step=0.1)
    return solution.y[0]


def v_of(t):
    return bell(t, 3.0, 1.0)


def test_laws_at_one_place_are_those_of_an_independent_integrator():
    """Viscosity, rise and fall times and Rossi's law with λ = 1 + γ, against SciPy."""
    v = v_of(TIMES)
    found = contraction.viscous(TIMES, v, 0.3, np.array([0.2, 1.0]))
    for one, lam in zip(found.T, (0.2, 1.0), strict=True):

        def rate(t, y, lam=lam):
            gamma = -0.3 * v_of(t)
            return (gamma / (1 + gamma) - y) / lam

        exact = -integrated(rate) * (1 - 0.3 * v[::40])
        np.testing.assert_allclose(one[::40], exact, atol=2e-6)
    found = contraction.relaxing(TIMES, v, 0.3, np.array([0.2]), np.array([1.5]), np.array([0.05]))
    exact = integrated(lambda t, y: (0.3 * v_of(t) - y) / np.where(v_of(t) > 0.05, 0.2, 1.5))
    np.testing.assert_allclose(found[::40, 0], exact, atol=1e-4)  # the switch lies between two times
    law = Rossi2014(alpha=-4.0, mu=5.0)

    def calcium(t):
        return 0.1 + 0.8 * v_of(t)

    def driven(t, g):
        c = calcium(t)
        force = -4.0 * np.maximum(c - 0.2155, 0) ** 2 * force_length(1 + g)
        return (force + 2 * (1 + g) ** 2 * ((1 + g) ** -3 - 1)) / (5.0 * c**2)

    found = contraction.driven(TIMES, calcium(TIMES), law)
    exact = -integrated(driven)
    assert exact.max() > 0.05
    np.testing.assert_allclose(found[::40], exact, atol=5e-4)


LINE = ("geometry.length=30.0", "geometry.spacing=1.0", "probes={}", "output.rigid_twin=false")


def test_a_place_of_a_free_line_contracts_by_itself():
    """The coupled line's shortening is its own potential put through the law; steps may grow."""
    stages = ((4e-3, 0.6), (8e-3, 1.4))
    relaxing = "activation={law='relaxing', rise=0.05, fall=0.3}"
    job = course_job("pulse-1d", (*LINE, relaxing), stages=stages, watch=15.0, places=(10.0, 20.0))
    found = job.run()
    times, v = found.arrays["times"], found.arrays["excitation"]
    assert np.diff(times).max() == pytest.approx(8e-3)
    alone = contraction.relaxing(times, v, 0.3, *(np.array([value]) for value in (0.05, 0.3, 0.05)))[:, 0]
    # x′ is that of the two cells at the node.
    np.testing.assert_allclose(found.arrays["shortening"], alone, atol=4e-3)
    assert found.numbers["peak"] == pytest.approx(alone.max(), abs=5e-4)
    uniform = course_job(
        "pulse-1d", (*LINE, relaxing), stages=((4e-3, 1.4),), watch=15.0, places=(10.0, 20.0)
    )
    other = uniform.run().numbers
    assert {k: v for k, v in found.numbers.items() if v is not None} == pytest.approx(
        {k: v for k, v in other.items() if v is not None}, rel=0.02
    )


def test_a_place_of_a_sheet():
    """A free sheet in plane stress shortens by 1 − (1 + γ)^(2/3) where γ is uniform."""
    overrides = (
        'geometry={kind="rectangle", size=[4.0, 2.0], spacing=1.0}',
        "fibres.direction=[1.0, 0.0]",
        "initial={potential=0.0, center=[0.0, 0.0], radius=1.0}",
        "activation={law='timed', gamma_min=-0.2, start=0.0, end=0.2, period=1.0}",
        "mechanics={kinematics='plane-stress'}",
        "probes={}",
    )
    job = course_job("sheet-2d", overrides, stages=((0.01, 0.05), (0.05, 0.2)), watch=(2.0, 1.0))
    found = job.run().arrays
    gamma = -0.2 * np.sin(np.pi * found["times"] / 0.2) ** 2
    np.testing.assert_allclose(found["shortening"], 1 - (1 + gamma) ** (2 / 3), atol=1e-5)
    assert found["shortening"].max() > 0.1


def made_up():
    """Outcomes of a membrane whose viscosity is never both, and whose relaxing law is."""
    settings = jobs.map_settings("BOCF", True)

    n = len(settings["relaxation"])
    arrays = {
        "viscosity delay_share": np.linspace(0.05, 0.6, n),
        "viscosity tenth_length": np.linspace(1.0, 1.5, n),
        "viscosity peak": np.linspace(0.3, 0.1, n),
    }
    shape = (2, len(settings["rise"]), len(settings["fall"]))
    arrays |= {
        "relaxing delay_share": np.broadcast_to(np.linspace(0.1, 0.5, shape[1])[:, None], shape),
        "relaxing tenth_length": np.full(shape, 1.4),
        "relaxing peak": np.full(shape, 0.2),
        "relaxing left": np.zeros(shape),
    }
    rossi = {"delay_share": 0.6, "tenth_length": np.nan, "peak": 0.05}
    arrays |= {f"rossi {key}": np.full(4, value) for key, value in rossi.items()}
    return settings, Found({"repolarization": 200.0}, arrays)


def test_which_laws_are_a_hearts():
    """Counts and bounds from the arrays of a map, one by one."""
    settings, made = made_up()
    found = numbers._map(made, settings, {"peak": 0.25})
    share, length = (made.arrays[f"viscosity {key}"] for key in ("delay_share", "tenth_length"))
    inside = [50 / 270 <= s <= 100 / 270 for s in share]
    assert found["viscosity"]["delayed"] == sum(inside)
    assert found["viscosity"]["outlasting"] == sum(one >= 1.25 for one in length)
    assert found["viscosity"]["both"] == sum(a and b >= 1.25 for a, b in zip(inside, length, strict=True))
    assert found["viscosity"]["longest_of_delayed"] == max(length[inside])
    assert found["viscosity"]["least_delay_of_outlasting"] == min(share[length >= 1.25])
    assert found["viscosity"]["compared"] == pytest.approx(
        np.interp(75 / 270, share, made.arrays["viscosity peak"]) / 0.25
    )
    # Not back by the end of the run outlasts it.
    assert found["rossi"] == {"laws": 4, "delayed": 0, "outlasting": 4, "both": 0, "longest_of_delayed": None,
                              "least_delay_of_outlasting": 0.6, "shortening_of_delayed": None,
                              "shortening_of_both": None}  # fmt: skip
    assert found["relaxing"]["both"] == found["relaxing"]["delayed"]


def test_the_verdict_on_viscosity_follows_the_numbers():
    """Borne out as it is; not if one viscosity were both, or if none delayed."""
    claim = claims("delay")["viscosity"]
    good = {"membranes_delayed": 2, "laws_with_both": 0, "longest_of_delayed": 1.15,
            "human_delay_of_outlasting_ms": 128.0}  # fmt: skip
    assert judge(claim, {"as measured": good}).kind == "agrees"
    for fault in ({"laws_with_both": 1}, {"membranes_delayed": 1}, {"longest_of_delayed": 1.3}):
        assert judge(claim, {"as measured": good | fault}).kind == "does not agree"


def delays():
    """Numbers of the chapter with which each of its claims is borne out."""
    row = {"rise_delay": 0.0, "repolarization": 270.0, "peak_delay": 80.0, "tenth_length": 1.0,
           "delay_share": 0.3, "shortening_share": 0.85, "peak": 0.2}  # fmt: skip
    rows = {name: dict(row) for name in ("BOCF at once", "FHN at once")}
    rows["BOCF at once"]["peak_delay"] = 1.0
    rows |= {name: row | {"tenth_length": 1.4} for name in ("BOCF relaxing", "BOCF relaxing, sheet")}
    weak = row | {"peak_delay": 200.0, "peak": 0.04, "shortening_share": 0.15}
    rows |= {"BOCF rossi": dict(weak), "TTP06 rossi": weak | {"tenth_length": 1.24}}
    viscosity = {"delayed": 8, "both": 0, "longest_of_delayed": 1.15,
                 "least_delay_of_outlasting": 0.47, "compared": 0.86}  # fmt: skip
    one = {
        "repolarization": 270.0,
        "viscosity": viscosity,
        "relaxing": {"delay_by_fall": 0.001, "compared": 0.85},
        "rossi": {"both": 0},
    }
    errors = {"delay_share": 0.003, "tenth_length": 0.005, "peak": 0.004}
    return {"rows": rows, "maps": {"BOCF": copy.deepcopy(one), "FHN": one}, "map_errors": {"BOCF": errors}}


@pytest.mark.parametrize(
    "path, value, claim",
    [
        ("rows.FHN at once.rise_delay", -20.0, "at-once"),
        ("rows.BOCF at once.peak_delay", 5.0, "at-once"),
        ("rows.FHN at once.tenth_length", 0.8, "at-once"),
        ("rows.BOCF at once.tenth_length", 1.2, "at-once"),
        ("maps.FHN.viscosity.delayed", 0, "viscosity"),
        ("maps.BOCF.viscosity.both", 1, "viscosity"),
        ("maps.FHN.viscosity.longest_of_delayed", 1.3, "viscosity"),
        ("maps.BOCF.viscosity.least_delay_of_outlasting", 0.3, "viscosity"),
        ("rows.BOCF relaxing, sheet.delay_share", 0.1, "relaxing"),
        ("rows.BOCF relaxing.delay_share", 0.4, "relaxing"),
        ("rows.BOCF relaxing, sheet.tenth_length", 1.1, "relaxing"),
        ("rows.BOCF relaxing.shortening_share", 0.7, "relaxing"),
        ("maps.FHN.relaxing.delay_by_fall", 0.05, "relaxing"),
        ("rows.TTP06 rossi.peak_delay", 90.0, "calcium"),
        ("rows.TTP06 rossi.tenth_length", 1.0, "calcium"),
        ("rows.BOCF rossi.tenth_length", 1.2, "calcium"),
        ("maps.BOCF.rossi.both", 1, "calcium"),
        ("rows.BOCF rossi.peak", 0.1, "calcium"),
        ("maps.BOCF.viscosity.compared", 0.7, "cost"),
        ("maps.BOCF.relaxing.compared", 0.7, "cost"),
        ("rows.TTP06 rossi.shortening_share", 0.3, "cost"),
        ("map_errors.BOCF.peak", 0.05, "local"),
    ],
)
def test_verdicts_on_delays_turn_with_the_numbers(path, value, claim):
    """Each number that is judged, at its worst of all rows: one that is off turns its own verdict alone."""
    made = delays()
    known = claims("delay")

    def verdicts():
        judged = numbers.readings(made)
        return {name: judge(one, judged[name]).kind == "agrees" for name, one in known.items()}

    assert all(verdicts().values())
    *way, last = path.split(".")
    functools.reduce(operator.getitem, way, made)[last] = value
    assert {name for name, agrees in verdicts().items() if not agrees} == {claim}


def human(celerities):
    """Outcomes of all lines of the chapter on human pulses, from made-up celerities."""
    made = {}
    for name in human_jobs.jobs(True):
        kind = name.removeprefix("BOCF ").removeprefix("TTP06 ")
        numbers_of = dict.fromkeys(human_numbers.NAMES, 2.0) | {"celerity": celerities(kind)}
        X = np.linspace(0, 24, 121)
        made[name] = Found(numbers_of, {"X": X, "arrival": X / 0.7, "front_stretch": np.full(121, 1.1)})
    return made


def test_what_is_left_of_the_gain():
    """Shares of a gain that falls as the estimate says; half of it is left where the estimate has it."""
    foot = human_jobs.diffusivity() / 0.8**2

    def celerity(kind):
        if kind.startswith("conservative rise"):
            return 0.8 * (1 + 0.25 / (1 + float(kind.split()[-1]) / foot))
        return {"conservative": 1.0, "advective": 0.88, "relaxing": 0.804, "held": 0.72}.get(kind, 0.8)

    n = human_numbers.numbers(human(celerity), True)
    assert n["foot"] == pytest.approx(foot)
    for row in n["sweep"]["conservative"]:
        assert row["left"] == pytest.approx(row["predicted"]) == pytest.approx(1 / (1 + row["rise"] / foot))
    assert n["left"]["BOCF"] == pytest.approx({"conservative": 0.02, "advective": 0.0})
    assert n["ratios"]["TTP06"]["advective"]["celerity"] == pytest.approx(1.1)
    held = n["held"]["held"]
    assert held["celerity_ratio"] == pytest.approx(0.9)
    assert held["spatial_ratio"] == pytest.approx(0.99)
    assert held["late_ms"] == pytest.approx(17 / 0.7 - 17 / 0.8)
    judged = human_numbers.readings(n)
    assert judged["how-soon"]["as measured"]["half_rise_ms"] == pytest.approx(foot, rel=0.15)
    blocking = judged["blocking"]["as measured"]
    assert blocking["least_loss_at_once"] == pytest.approx(1 - 0.8 / 0.88)
    assert blocking["largest_change_late"] == pytest.approx(1 - 0.8 / 0.804)
    assert (
        judge(claims("human-pulse")["celerity"], judged["celerity"]).reading == "advective balance, J ∂v/∂t"
    )


@pytest.mark.parametrize(
    "claim, fault",
    [
        ("delayed", {"largest_left": 0.1}),
        ("held", {"celerity_ratio": 1.02}),
        ("blocking", {"largest_change_late": 0.02}),
        ("how-soon", {"half_rise_ms": 5.0}),
    ],
)
def test_verdicts_on_human_pulses_turn_with_the_numbers(claim, fault):
    """Each is borne out within its bounds, and not with the number that would speak against it."""
    asked = claims("human-pulse")[claim]
    good = {name: (max(low, -1e3) + min(high, 1e3)) / 2 for name, (low, high) in asked.bounds.items()}
    assert judge(asked, {"as measured": good}).kind == "agrees"
    assert judge(asked, {"as measured": good | fault}).kind == "does not agree"


def test_the_front_of_a_line_that_is_held_stretched_keeps_its_speed_in_space():
    """With x′ = λ for ever D in the material is D/λ²: in X the celerity is over λ, the steepness times λ."""
    found = {}
    for stretch in (1.0, 1.25):
        law = f"mechanics.imposed_stretch={{value={stretch}, until=inf}}"
        # The same nodes in space, so that both are one discrete problem.
        line = (f"geometry.length={40.0 / stretch}", f"geometry.spacing={1.0 / stretch}", "probes={}")
        bump = f"initial.radius={5.0 / stretch}"
        places = (16.0 / stretch, 28.0 / stretch)
        job = course_job(
            "pulse-1d-rigid", (*line, bump, law), stages=((4e-3, 0.8),), watch=places[0], places=places
        )
        found[stretch] = job.run().numbers
    for name, power in (("celerity", -1), ("steepness_material", 1), ("steepness_spatial", 0)):
        assert found[1.25][name] == pytest.approx(found[1.0][name] * 1.25**power, rel=1e-5)
