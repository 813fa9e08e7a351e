"""0D models of the circulation: the wall replaced by an elastance, against SciPy; mass; valves; orders."""

from myostrain.circulation import Circuit, Isovolumetric, Windkessel
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
