"""The body with its circulation in time: orders against SciPy, and the work at the wall over a loop."""

import myostrain as ms
from myostrain.circulation import PrescribedVolume
from myostrain.geometry import EllipsoidalFibres, Ventricle
from myostrain.kinematics import Solid
from myostrain.materials import NeoHookean
from myostrain.output.loops import loop_numbers

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from small_cases import ALONE

END, RESISTANCE, INERTANCE, PRELOAD = 2.0, 8e-4, 2e-4, 0.2


class Pump:
    """An inert column of blood, pushed by a pressure that comes and goes, which flows into the cavity."""

    cavities, states = 1, ("flow",)

    def initial_states(self, pressures, volumes):
        return [0.0]

    def rates(self, time, states, pressures):
        push = PRELOAD + 0.5 * np.sin(np.pi * time / END) ** 2
        return [(push - pressures[0] - RESISTANCE * states[0]) / INERTANCE], [states[0]]


@pytest.fixture(scope="module")
def body():
    shape = Ventricle(endocardium=(10.0, 10.0), epicardium=(14.0, 14.0), base=0.0, spacing=8.0, layers=1)
    return ms.build(
        shape, EllipsoidalFibres(endocardium=shape.endocardium, epicardium=shape.epicardium), ALONE
    )


def mechanics(body, circulation, preload=None):
    return ms.Mechanics(
        body,
        kinematics=Solid(),
        material=NeoHookean(mu=2.0),
        supports=ms.Supports(sliding=["base"]),
        cavities=ms.Cavities(("endocardium",), circulation, preload),
    )


def run(solid, steps, order, gamma=None):
    """Volumes, pressures and flows (times, 3), and the work of the pressure's forces at the wall's nodes."""
    solid.activation.x.array[:] = 0.0
    solid.start(0.0)
    found, ends = [], []
    for number in range(steps + 1):
        time = END * number / steps
        if number:
            if gamma is not None:
                solid.activation.x.array[:] = gamma(time)
            solid.solve(time, order=order)
            solid.accept(time)
        found.append(list(solid.cavities.values().values()))
        forces = -solid.cavities.numbers[0] * solid.cavities.columns()[0]
        ends.append((forces, solid.u.x.array.copy()))
    forces, moved = map(np.array, zip(*ends, strict=True))
    return np.array(found), ((forces[1:] + forces[:-1]) / 2 * np.diff(moved, axis=0)).sum()


@pytest.fixture(scope="module")
def exact(body):
    """Volumes over time by SciPy, with the wall's curve of pressure over volume from prescribed volumes."""
    low, high = 1780.0, 2240.0  # the curve is not extrapolated
    solid = mechanics(body, PrescribedVolume(volume=((0.0, low), (1.0, high))))
    curve = []
    for time in np.linspace(0, 1, 24):
        solid.start(time) if not curve else solid.solve(time)
        solid.accept(time)
        curve.append(list(solid.cavities.values().values()))
    wall, pump = CubicSpline(*np.transpose(curve), extrapolate=False), Pump()
    begun = brentq(lambda volume: wall(volume) - PRELOAD, low + 1, high - 1, xtol=1e-9)

    def rates(time, values):
        (change,), (flow,) = pump.rates(time, values[1:], [wall(values[0])])
        return [flow, change]

    found = solve_ivp(rates, (0.0, END), [begun, 0.0], rtol=1e-9, atol=1e-7, dense_output=True)
    assert np.isfinite(found.y).all()
    return lambda times: found.sol(times)[0]


@pytest.mark.parametrize("order, largest", [(1, 15.0), (2, 1.3)])
def test_order_of_body_and_circulation(body, exact, order, largest):
    """Declared order of the coupled step, against an integrator that knows the wall by its curve alone."""
    solid = mechanics(body, Pump(), PRELOAD)
    volumes, errors = [], []
    for steps in (20, 40):
        found, _ = run(solid, steps, order)
        times = np.linspace(0, END, steps + 1)
        volumes.append(found[:, 0])
        errors.append(np.abs(found[:, 0] - exact(times)).max())
    assert volumes[1][0] == pytest.approx(exact(0.0), abs=1e-3)
    assert np.ptp(volumes[1]) > 300.0
    assert errors[1] < largest
    assert np.log2(errors[0] / errors[1]) > order - 0.15, errors
    # What the steps tend to is the integrator's solution.
    limit = volumes[1][::2] + (volumes[1][::2] - volumes[0]) / (2**order - 1)
    assert np.abs(limit - exact(np.linspace(0, END, 21))).max() < 0.25 * errors[1]


def test_stroke_work_is_the_work_at_the_wall(body):
    """Over a loop −∮ p dV is what the body does on the blood by the forces at its nodes."""
    solid = mechanics(body, Pump(), PRELOAD)
    found, work = run(solid, 60, 2, gamma=lambda time: -0.12 * np.sin(np.pi * time / END) ** 4)
    volume, pressure, _ = found.T
    stroke = loop_numbers(np.linspace(0, END, 61), volume, pressure, 1)["stroke_work"]
    assert abs(stroke) > 20.0
    assert -work == pytest.approx(stroke, rel=5e-3)
