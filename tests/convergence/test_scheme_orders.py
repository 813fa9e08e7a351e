"""Every scheme declares its order in time, and this measures it (the design, "Numbers").

On the elastic line the finite-difference reference solves the same equations in X (both have J = 1 − βv at
the nodes and between them its mean), and in time to a tolerance far below the schemes' errors, so the errors
are against an independent solution: 3e-7 at the smallest, the reference's own is below 1e-9.
Elsewhere the errors are differences between runs at successively halved steps.
"""

import itertools
from functools import cache

import myostrain as ms

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from coupled import BANDS, TIGHT, advance, coordinates, gaussian, line, observed_orders, rms, sheet
from reference.line_fd import Line, solve

#: Every public class that declares an order and advances: a new scheme is measured without a new test.
DECLARED = sorted(
    (
        c
        for c in (getattr(ms, name) for name in ms.__all__)
        if isinstance(c, type) and hasattr(c, "order") and hasattr(c, "advance")
    ),
    key=lambda c: c.__name__,
)

SCHEMES = {
    # The fixed point to a tolerance below the errors.
    cls.__name__: cls(tolerance=1e-11) if cls is ms.Implicit else cls()
    for cls in DECLARED
} | {
    # Fewer solves of mechanics keep the order (the docstrings of Staggered and SecondOrder).
    "Staggered, every 4": ms.Staggered(every=4),
    "SecondOrder, every 2": ms.SecondOrder(every=2),
    "SecondOrder, every 4": ms.SecondOrder(every=4),
}

END = 0.04  # the bump rises from 0.9 to 0.95 and widens by half
RELEASE = (
    0.012  # a solve of mechanics with every scheme: else the fields at the end are not smooth in the step
)
STEPS = (1e-3, 5e-4, 2.5e-4)


def steps_for(scheme, steps=STEPS):
    """Steps to measure with; the implicit scheme, which takes longest, shows its order at larger ones."""
    return (2e-3, 1e-3, 5e-4) if isinstance(scheme, ms.Implicit) else steps


each_scheme = pytest.mark.parametrize("name", list(SCHEMES))


def assert_declared_order(scheme, observed, what):
    low, high = BANDS[scheme.order]
    assert low < observed < high, f"order {observed:.3f} in {what}, declared {scheme.order}"


def test_the_schemes_are_those_of_the_interface():
    """Readings of the model: the paper's implicit scheme, a staggered one and one of second order."""
    assert [(cls.__name__, cls.order) for cls in DECLARED] == [
        ("Implicit", 1),
        ("SecondOrder", 2),
        ("Staggered", 1),
    ]


@cache
def reference(balance, held, height, beta=0.3):
    """Potential and recovery at the end by finite differences."""
    return solve(
        Line(
            balance=balance,
            beta=beta,
            imposed_stretch=held,
            length=40.0,
            end=END,
            sample=0.01,
            probes=(),
            initial=lambda X: gaussian(X, height),
            rtol=1e-11,
            atol=1e-13,
        )
    )


@pytest.mark.parametrize(
    "balance, held",
    [
        ("conservative", None),
        ("advective", None),
        ("conservative", (1.0, RELEASE)),
        ("advective", (1.1, RELEASE)),
    ],
)
@each_scheme
def test_coupled_elastic_line(name, balance, held):
    """(4.4)–(4.7): v and w converge to the finite-difference solution at the declared order, released or not.

    "The first step, and the one after a released stretch, are of first order, which costs no order."
    Measured: 0.97..1.02 and 1.97..2.12.
    """
    scheme = SCHEMES[name]
    height = 0.9 if held is None else 0.5
    exact = reference(balance, held, height)
    errors = []
    for step in steps_for(scheme):
        model = line(scheme, balance=balance, held=held, initial=lambda X: gaussian(X, height))
        found = advance(model, step, END)
        order = np.argsort(coordinates(model.potential)[:, 0])
        errors.append([rms(found["potential"][order] - exact.v), rms(found["recovery"][order] - exact.w)])
    for what, observed in zip(("potential", "recovery"), observed_orders(errors)[-1], strict=True):
        assert_declared_order(scheme, observed, what)


def test_second_order_where_the_body_feeds_back_strongly():
    """SecondOrder's docstring: where J follows v strongly (β > 0.4) its steps are iterated, with its order.

    β = 0.45, close to the limit of well-posedness, v up to 0.93, against finite differences: measured 2.02.
    """
    exact = reference("conservative", None, 0.8, beta=0.45)
    errors = []
    for step in (2e-3, 1e-3, 5e-4):
        model = line(ms.SecondOrder(), beta=0.45, initial=lambda X: gaussian(X, 0.8))
        found = advance(model, step, END)
        order = np.argsort(coordinates(model.potential)[:, 0])
        errors.append(rms(found["potential"][order] - exact.v))
    assert_declared_order(model.scheme, observed_orders(errors)[-1], "potential")


def self_convergence(scheme, make, steps=STEPS, end=END):
    """Order of each field from the differences of three runs."""
    runs = [advance(make(scheme), step, end) for step in steps_for(scheme, steps)]
    return {
        name: observed_orders([rms(a[name] - b[name]) for a, b in itertools.pairwise(runs)])[-1]
        for name in runs[0]
    }


@pytest.mark.parametrize(
    "balance, held",
    [("conservative", None), ("conservative", (1.0, RELEASE)), ("advective", (1.0, RELEASE))],
)
@each_scheme
def test_coupled_viscous_line(name, balance, held):
    """(4.14) with λ = 0.4 τ: the declared order in v, w and u, also when an imposed stretch is let go.

    Measured: 0.91..1.04 and 1.92..2.15.
    """
    scheme = SCHEMES[name]
    height = 0.9 if held is None else 0.5

    def make(scheme):
        return line(
            scheme,
            balance=balance,
            relaxation_time=0.08,
            held=held,
            initial=lambda X: gaussian(X, height),
        )

    for what, observed in self_convergence(scheme, make).items():
        assert_declared_order(scheme, observed, what)


SHEETS = {
    "plane stress, J = 1": (dict(kinematics=ms.kinematics.PlaneStress()), STEPS),
    # γ drives J too, and the steps have to be smaller for the order to show.
    "plane stress, det Fe = 1": (
        dict(kinematics=ms.kinematics.PlaneStress(constraint="elastic"), diffusivity=(100.0, 25.0)),
        (5e-4, 2.5e-4, 1.25e-4),
    ),
    "plane strain, J = 1": (dict(kinematics=ms.kinematics.PlaneStrain()), STEPS),
    "viscous": (dict(kinematics=ms.kinematics.PlaneStress(), relaxation_time=0.08), STEPS),
}


@pytest.mark.parametrize("body", list(SHEETS))
@pytest.mark.parametrize("name", [name for name in SCHEMES if name != "Staggered, every 4"])
def test_coupled_sheet(name, body):
    """(7.1)–(7.3): the declared order in v, w and u on a sheet of 265 nodes, whatever is isochoric.

    Measured: 0.96..1.01 and 1.99..2.26.
    """
    scheme, (parts, steps) = SCHEMES[name], SHEETS[body]
    orders = self_convergence(scheme, lambda scheme: sheet(scheme, **parts), steps, end=0.02)
    for what, observed in orders.items():
        assert_declared_order(scheme, observed, what)


class AlievPanfilov:
    """The user's own membrane, in plain arithmetic: nonlinear in its state, which enters with v."""

    states = ("recovery",)

    def resting_potential(self):
        return 0.0

    def resting_states(self):
        return (0.0,)

    def current(self, v, states):
        return 8 * v * (v - 0.15) * (v - 1) + v * states[0]

    def rates(self, v, states):
        w = states[0]
        return ((0.002 + 0.2 * w / (v + 0.3)) * (-w - 8 * v * (v - 1.15)),)


class Oscillator:
    """Two states that drive each other, and a NumPy function."""

    states = ("a", "b")

    def resting_potential(self):
        return 0.0

    def resting_states(self):
        return (0.2, 0.1)

    def current(self, v, states):
        return 20 * (v * (v - 0.1) * (v - 1) + states[0] * v)

    def rates(self, v, states):
        a, b = states
        return (v - 3 * b - a**2, 1 - np.exp(-4 * a) - b)


@pytest.mark.parametrize("cell", [AlievPanfilov(), Oscillator()], ids=lambda cell: type(cell).__name__)
@pytest.mark.parametrize("name", [cls.__name__ for cls in DECLARED])
def test_membrane_of_the_users_own(name, cell):
    """(2.1)–(2.2) at a point, any membrane (the design: passed directly, no registry): v and each state
    converge to SciPy's solution at the declared order, in the rms over twenty times."""
    scheme = SCHEMES[name]

    def rates(_, y):
        return [-cell.current(y[0], y[1:]), *cell.rates(y[0], y[1:])]

    start, times = [0.6, *cell.resting_states()], np.linspace(0.05, 1.0, 20)
    exact = solve_ivp(rates, (0, 1), start, method="DOP853", t_eval=times, rtol=1e-12, atol=1e-13).y
    errors = []
    for substeps in (5, 10, 20):
        potential = ms.Potential(ms.build(ms.geometry.Line(length=2.0)), membrane=cell, options=TIGHT)
        potential.v.x.array[:] = start[0]
        model = ms.Electromechanics(potential, None, scheme=scheme)
        model.start()
        found = np.empty_like(exact)
        for row, time in enumerate(times):
            for part in range(1, substeps + 1):
                model.step(time - 0.05 * (1 - part / substeps))
            found[:, row] = [values[0] for values in potential.field_values().values()]
        errors.append([rms(e) for e in found - exact])
    for name, observed in zip(potential.field_values(), observed_orders(errors)[-1], strict=True):
        assert_declared_order(scheme, observed, name)
