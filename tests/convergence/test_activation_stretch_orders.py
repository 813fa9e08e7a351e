"""Laws that see the stretch, on bodies held or free, against an independent integrator: orders, stability."""

import myostrain as ms
from myostrain.activation import Hunter1998, Rossi2014
from myostrain.activation.force_length import force_length

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from coupled import BANDS, observed_orders


class Calcium(ms.membranes.Membrane):
    """A transient c = 0.1 + 2 (t/40) exp(−t/40), as the solution of two equations."""

    states = ("calcium", "source")
    calcium, calcium_unit, time_unit = "calcium", "μM", "ms"

    def resting_states(self):
        return (0.1, 2.0)

    def current(self, v, states):
        return 0.0 * v

    def rates(self, v, states):
        calcium, source = states
        return [(0.1 + source - calcium) / 40, -source / 40]


def concentration(t):
    return 0.1 + 2.0 * t / 40 * np.exp(-t / 40)


def line(scheme, law, *, held=False, stiffness=1.0):
    """A line of four cells, alike everywhere; held at its length or free."""
    body = ms.build(ms.geometry.Line(length=4.0))
    mechanics = ms.Mechanics(
        body,
        kinematics=ms.kinematics.Line(),
        material=ms.materials.Spring(mu=stiffness),
        active=ms.activation.FibreTension() if law.yields == "tension" else None,
        supports=ms.Supports(fixed=["left"]),
        tolerance=1e-12,
        imposed_stretch=ms.ImposedStretch(value=1.0, until=float("inf")) if held else None,
    )
    potential = ms.Potential(body, membrane=Calcium(), deformation=mechanics.deformation, balance="advective")
    return ms.Electromechanics(potential, mechanics, law=law, scheme=scheme)


def course(model, step, end):
    """γ, or the tension, after each step; the same at all nodes."""
    model.start()
    found = []
    for number in range(1, round(end / step) + 1):
        model.step(number * step)
        values = model.activation.values
        assert np.ptp(values) < 1e-9
        found.append(values[0])
    return np.array(found)


def reference(law, held, times):
    """γ at times, by SciPy."""

    def rate(t, gamma):
        c, stretch = concentration(t), np.ones_like(gamma) if held else 1 + gamma
        force = law.alpha * max(c - law.c0, 0) ** 2 * force_length(stretch)
        return (force + 2 * stretch**2 * ((1 + gamma) ** -3 - 1)) / (law.mu * c**2)

    solved = solve_ivp(rate, (0, times[-1]), [0.0], "LSODA", t_eval=times, rtol=1e-11, atol=1e-13, max_step=2)
    return solved.y[0]


SCHEMES = [
    ms.SecondOrder(),
    ms.SecondOrder(every=4),
    ms.Staggered(),
    ms.Staggered(every=4),
    ms.Implicit(tolerance=1e-11),
]


@pytest.mark.parametrize(
    "scheme, held",
    [(scheme, False) for scheme in SCHEMES] + [(SCHEMES[0], True), (SCHEMES[2], True)],
    ids=str,
)
def test_the_order_holds_with_mechanics_every_few_steps(scheme, held):
    """docs/model/activation.md: "the order of the scheme, with mechanics every N steps too": the stretch is
    extrapolated from the last two bodies (second order), or that of the last one (first order).
    """
    law, end = Rossi2014(mu=500.0), 64.0
    exact = reference(law, held, np.array([end]))[0]
    assert exact < -0.09
    errors = np.array(
        [course(line(scheme, law, held=held), step, end)[-1] - exact for step in (2.0, 1.0, 0.5)]
    )
    low, high = BANDS[scheme.order]
    observed = observed_orders(np.abs(errors))
    assert ((low < observed) & (observed < high)).all(), (errors, observed)


@pytest.mark.parametrize("mu, every", [(5000.0, 10), (5000.0, 20), (500.0, 5)])
def test_rossi_is_stable_at_the_steps_that_the_docs_recommend(mu, every):
    """docs/model/activation.md: mechanics every 20 ms at the published μ, every 5 ms at a tenth of it: a free
    body stays within 1 % of the largest γ, and γ falls once and rises once.
    """
    law, times = Rossi2014(mu=mu), np.arange(1.0, 301.0)
    found, exact = course(line(ms.SecondOrder(every=every), law), 1.0, 300.0), reference(law, False, times)
    assert np.abs(found - exact).max() < 0.01 * np.abs(exact).max()
    changes = np.diff(found)
    assert np.count_nonzero(changes[1:] * changes[:-1] < 0) == 1


def turns(values):
    changes = np.diff(values)
    return np.count_nonzero(changes[1:] * changes[:-1] < 0)


def test_a_tension_that_follows_the_length_at_once_oscillates_under_staggering():
    """Hunter1998, "Tension that grows with the length at once pulls the fibre back in the next step": against
    a soft body it swings from step to step, in smaller steps too, and iterating the step cures it.
    """
    law = Hunter1998(tension=3.0)
    for step in (2.0, 1.0):
        assert turns(course(line(ms.SecondOrder(), law), step, 60.0)) > 10
    assert turns(course(line(ms.Implicit(), law), 2.0, 60.0)) <= 1
    assert turns(course(line(ms.SecondOrder(), law, stiffness=30.0), 2.0, 60.0)) <= 1  # a stiff body


@pytest.mark.parametrize("tension", [3.0, 30.0])
def test_the_implicit_scheme_iterates_until_the_stretch_is_that_of_the_body(tension):
    """Implicit: the tension is that of the calcium and the stretch at the end of the step, however strong.

    At 30 the length answers almost four times to the length that the law saw: plain iteration diverges.
    """
    law = Hunter1998(tension=tension)
    model = line(ms.Implicit(), law)
    model.start()
    for number in range(1, 21):
        model.step(number * 2.0)
        drivers = {
            "calcium": model.potential.field_values()["calcium"],
            "stretch": model.mechanics.fibre_stretch(),
        }
        np.testing.assert_allclose(model.activation.values, law.activation((), drivers), rtol=1e-5)
    assert model.activation.values[0] > 0.5
    assert model.stretch_lag == 0.0
    assert model.coupling_iterations < 20 * 12


def test_the_lag_of_the_stretch_falls_with_the_step_or_not():
    """docs/numerics.md: stretch_lag of one pass, second order where it is stable, and not where it swings."""
    lags = {}
    for tension in (0.05, 3.0):
        for step in (2.0, 1.0):
            model = line(ms.SecondOrder(), Hunter1998(tension=tension))
            course(model, step, 60.0)
            lags[tension, step] = model.stretch_lag
    assert 3.0 < lags[0.05, 2.0] / lags[0.05, 1.0] < 5.0
    assert lags[3.0, 1.0] > 0.5 * lags[3.0, 2.0]
    assert lags[3.0, 1.0] > 0.1
