"""0D models of the circulation: the wall replaced by an elastance, against SciPy; mass; valves; orders."""

from functools import cache

from myostrain.circulation import Circuit, ClosedLoop, Isovolumetric, Windkessel
from myostrain.errors import InputError

import numpy as np
import pytest
from scipy.integrate import solve_ivp

#: Of a human, in mmHg, mL and s.
HUMAN = Windkessel(
    resistance=1.0,
    compliance=1.5,
    impedance=0.05,
    inlet_resistance=0.02,
    filling_pressure=10.0,
    arterial_pressure=80.0,
    venous_pressure=3.0,
)
PERIOD, REST = 0.8, 10.0


def elastance(time):
    """mmHg/mL: a smooth beat every 0.8 s, between 0.08 and 2.5."""
    return 0.08 + 2.42 * np.sin(np.pi * (time % PERIOD) / PERIOD) ** 4


def beat(model, step, order, end):
    """Volume, pressure and states (times, ...) of a ventricle of this elastance, each step implicit."""
    circuit = Circuit(model)
    pressure = circuit.prepare(0.0, 1)[0]
    circuit.tied(np.zeros(1), np.array([pressure]))
    pressure = model.preload
    circuit.accept(0.0, np.array([REST + pressure / elastance(0.0)]), np.array([pressure]))
    found = [[circuit.volumes[0], pressure, *circuit.states]]
    for number in range(1, round(end / step) + 1):
        time = number * step
        guess = circuit.prepare(time, order)
        for _ in range(30):
            volume = REST + guess / elastance(time)
            value, by_volume, by_pressure = circuit.tied(volume, guess)
            correction = value / (by_volume[0, 0] / elastance(time) + by_pressure[0, 0])
            guess = guess - correction
            if abs(correction[0]) < 1e-11 * (1 + abs(guess[0])):
                break
        else:
            raise AssertionError(f"no pressure at {time}")
        volume = REST + guess / elastance(time)
        circuit.tied(volume, guess)
        circuit.accept(time, volume, guess)
        found.append([volume[0], guess[0], *circuit.states])
    return np.array(found)


@pytest.fixture(scope="module")
def exact():
    """The same as an ordinary differential equation for volume and arterial pressure, by SciPy."""

    def rates(time, values):
        volume, arteries = values
        p = elastance(time) * (volume - REST)
        inflow = max(10.0 - p, 0.0) / 0.02
        outflow = max(p - arteries, 0.0) / 0.05
        return [inflow - outflow, (outflow - (arteries - 3.0) / 1.0) / 1.5]

    begun = [REST + 10.0 / elastance(0.0), 80.0]
    return solve_ivp(
        rates, (0.0, 1.6), begun, method="LSODA", rtol=1e-11, atol=1e-11, max_step=5e-4, dense_output=True
    ).sol


def errors(exact, step, order):
    found = beat(HUMAN, step, order, 1.6)
    times = step * np.arange(len(found))
    volume, arteries = exact(times)
    return np.array([np.abs(found[:, 0] - volume).max(), np.abs(found[:, 2] - arteries).max()])


@pytest.mark.parametrize("order, size", [(1, 1.5), (2, 0.4)])
def test_order_of_the_coupling(exact, order, size):
    """Two beats, valves that open and shut among them: the declared order, and small errors (mL, mmHg)."""
    coarse, fine = (errors(exact, step, order) for step in (8e-3, 2e-3))
    assert coarse.max() < size
    observed = np.log(coarse / fine) / np.log(4)
    assert np.all(observed > order - 0.3), observed


def test_valves_and_mass():
    """Nothing flows back, the volume stays while both valves are shut, and no blood is lost in a beat."""
    found = beat(HUMAN, 2e-3, 2, 1.6)
    volume, pressure, arteries, inflow, outflow = found.T
    assert min(np.diff(inflow).min(), np.diff(outflow).min()) > -1e-11
    np.testing.assert_allclose(volume - inflow + outflow, volume[0], rtol=1e-12)
    shut = (pressure > 10.0) & (pressure < arteries)
    long_shut = shut[3:] & shut[2:-1] & shut[1:-2] & shut[:-3]
    assert long_shut.sum() > 20
    assert np.abs(np.diff(volume)[2:][long_shut]).max() < 0.02
    runs = np.diff(np.concatenate([[False], shut]).astype(int))
    assert (runs == 1).sum() == 4  # two isovolumetric phases a beat: no chatter


def test_what_is_accepted_twice_is_kept_once():
    """Circuit.accept: "A time that has been accepted keeps what it has"."""

    def beats(often, restored):
        circuit = Circuit(HUMAN)
        for time, pressure in ((0.0, 10.0), (0.01, 12.0), (0.02, 15.0), (0.03, 19.0)):
            circuit.prepare(time, 2)
            pressures = np.array([pressure])
            circuit.tied(np.array([100.0]), pressures)
            for _ in range(often):
                circuit.accept(time, np.array([100.0]), pressures)
            if restored:
                state, circuit = circuit.state(), Circuit(HUMAN)
                circuit.restore(state)
                circuit.accept(time, circuit.volumes, circuit.pressures)
        guess = circuit.prepare(0.04, 2)
        return [
            *guess,
            *np.concatenate(circuit.tied(np.array([100.0]), guess)[:2], axis=None),
            *circuit.states,
        ]

    once = beats(1, False)
    assert np.isfinite(once).all()
    assert beats(2, False) == once
    assert beats(1, True) == once


def test_isovolumetric_keeps_the_volume():
    """To round-off, whatever the steps."""
    circuit = Circuit(Isovolumetric(cavities=2), np.array([1.0, 2.0]))
    circuit.prepare(0.0, 1)
    values, *_ = circuit.tied(np.array([5.0, 6.0]), np.array([1.5, 2.5]))
    np.testing.assert_array_equal(values, [0.5, 0.5])
    circuit.accept(0.0, np.array([5.0, 6.0]), np.array([1.0, 2.0]))
    for time in (0.1, 0.15, 0.4):
        circuit.prepare(time, 2)
        values, by_volumes, by_pressures = circuit.tied(np.array([5.0, 6.5]), np.array([3.0, 4.0]))
        np.testing.assert_allclose(values, [0.0, 0.5], atol=1e-14)
        np.testing.assert_array_equal(by_volumes, np.eye(2))
        np.testing.assert_array_equal(by_pressures, np.zeros((2, 2)))
        circuit.accept(time, np.array([5.0, 6.0]), np.array([1.0, 2.0]))


@cache
def loop_by_hand(end):
    """Left ventricle, atria, right ventricle and arteries of the closed loop, written anew for SciPy."""

    def e(t, rising, falling, begin):
        s = (t - begin) % 0.8
        up, down = np.sin(np.pi * s / rising / 2) ** 2, np.cos(np.pi * (s - rising) / falling / 2) ** 2
        return up if s < rising else (down if s < rising + falling else 0.0)

    def valve(a, b):
        return (a - b) / (0.0075 if a > b else 75006.2)

    def rates(t, y):
        VLA, VLV, VRA, VRV, pas, pvs, pap, pvp, qas, qvs, qap, qvp = y
        LA = (0.18 + 0.07 * e(t, 0.17, 0.17, 0.9)) * (VLA - 4)
        RA = (0.07 + 0.06 * e(t, 0.17, 0.17, 0.9)) * (VRA - 4)
        LV = (0.17 + 4.482 * e(t, 0.25, 0.4, 0.1)) * (VLV - 42)
        RV = (0.029 + 0.2 * e(t, 0.25, 0.4, 0.1)) * (VRV - 16)
        mv, av, tv, pv = valve(LA, LV), valve(LV, pas), valve(RA, RV), valve(RV, pap)
        return [
            *(qvp - mv, mv - av, qvs - tv, tv - pv),
            *((av - qas) / 1.372, (qas - qvs) / 11.363, (pv - qap) / 20, (qap - qvp) / 16),
            *((pas - pvs - 0.733 * qas) / 0.005, (pvs - RA - 0.32 * qvs) / 0.0005),
            *((pap - pvp - 0.046 * qap) / 0.0005, (pvp - LA - 0.0015 * qvp) / 0.0005),
        ]

    begun = [87.183, 118.52, 86.833, 166.177, 87.675, 35.898, 19.545, 15.004, 71.104, 94.039, 94.084, 473.279]
    found = solve_ivp(rates, (0, end), begun, method="Radau", rtol=1e-6, atol=1e-6, max_step=4e-3)
    return found.y[:, -1], found.y.sum(axis=0)


@pytest.mark.parametrize("cavities", [1, 2])
def test_closed_loop(cavities):
    """Half a beat of the loop with ventricles of given elastance, in mm³, kPa and ms, against SciPy."""
    model, step = ClosedLoop(cavities=cavities), 2.0
    low, high, rest, begun = np.array(
        [(0.17, 4.482, 42.0, 118.52), (0.029, 0.2, 16.0, 166.177)][:cavities]
    ).T * [[0.133322e-3], [0.133322e-3], [1e3], [1e3]]

    def stiffness(time):  # kPa/mm³
        s = (time / 1000 - 0.1) % 0.8
        share = np.sin(np.pi * s / 0.5) ** 2 if s < 0.25 else np.cos(np.pi * min(s - 0.25, 0.4) / 0.8) ** 2
        return low + high * share

    circuit = Circuit(model)
    atria = np.array([0.18 * (87.183 - 4), 0.07 * (86.833 - 4)])[:cavities]
    np.testing.assert_allclose(circuit.prepare(0.0, 1), 0.133322 * atria)
    circuit.accept(0.0, begun, (begun - rest) * stiffness(0.0))
    blood = []
    for number in range(1, 201):
        time = number * step
        p = circuit.prepare(time, 2)
        for _ in range(30):
            value, _, slope = circuit.tied(rest + p / stiffness(time), p)
            change = np.linalg.solve(np.diag(1 / stiffness(time)) + slope, value)
            p = p - change
            if np.abs(change).max() < 1e-10:
                break
        circuit.tied(rest + p / stiffness(time), p)
        circuit.accept(time, rest + p / stiffness(time), p)
        left, *right = circuit.volumes / 1000
        left_atrium, right_atrium, *others = circuit.states
        loop = np.array([left_atrium, left, right_atrium, *right, *others])
        blood.append(loop[:4].sum() + loop[4:8] @ [1.372, 11.363, 20.0, 16.0])
    assert np.ptp(blood) < 1e-8 * blood[0]
    exact, _ = loop_by_hand(0.4)
    np.testing.assert_allclose(loop[:8], exact[:8], rtol=5e-3)


def test_tolerances_do_not_add_up():
    """Walls that are off by a tolerance in each step: the model's blood stays the same to round-off."""
    circuit, moved = Circuit(HUMAN), np.random.default_rng(2)
    circuit.prepare(0.0, 1)
    circuit.accept(0.0, np.array([135.0]), np.array([10.0]))
    for number in range(1, 100):
        circuit.prepare(0.002 * number, 2)
        pressure = np.array([10.0 + number])
        circuit.tied(np.array([130.0]), pressure - 1.0)  # what was tried before
        wanted = -circuit.tied(np.zeros(1), pressure)[0]
        circuit.accept(0.002 * number, wanted + 0.01 * moved.standard_normal(1), pressure)
        _, inflow, outflow = circuit.states
        assert circuit.volumes[0] - inflow + outflow == pytest.approx(135.0, rel=1e-13)
        assert circuit.volumes[0] == pytest.approx(wanted[0], rel=1e-13)


class Wrong:
    """A model whose parts are the test's."""

    cavities = 1

    def __init__(self, states=("a",), initial=(0.0,), rates=((0.0,), (0.0,))):
        self.states, self._initial, self._rates = states, initial, rates

    def initial_states(self, pressures, volumes):
        return self._initial

    def rates(self, time, states, pressures):
        return self._rates


@pytest.mark.parametrize(
    "parts, said",
    [
        ({"initial": (0.0, 1.0)}, r"Wrong.initial_states\(\) gives values of shape \(2,\) for the 1 states"),
        ({"rates": ((), (0.0,))}, r"Wrong.rates\(\) gives shapes \(0,\) and \(1,\)"),
        ({"rates": ((0.0,), (0.0, 0.0))}, "flows into 1 cavities"),
    ],
)
def test_a_model_is_checked(parts, said):
    """Before the first step, with what is wanted."""
    circuit = Circuit(Wrong(**parts))
    with pytest.raises(InputError, match=said):
        circuit.accept(0.0, np.ones(1), np.zeros(1))
