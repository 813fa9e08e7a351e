"""Orders in time of a coupled line whose activation has a time of its own, or follows the stretch."""

import itertools

import myostrain as ms
from myostrain.activation import Relaxing

import pytest

from coupled import BANDS, advance, gaussian, line, observed_orders, rms


class Feedback:
    """γ = −0.3 v (1 + 2 (λ − 1)): less where the fibre is short, as muscle does."""

    drivers = ("potential", "stretch")

    def activation(self, states, drivers):
        return -0.3 * drivers["potential"] * (1 + 2 * (drivers["stretch"] - 1))


# One time constant: a switch in the middle of a step is of first order in any scheme.
LAWS = {"relaxing": Relaxing(beta=0.3, rise=0.05, threshold=-1.0), "stretch": Feedback()}
STEPS = {
    "Implicit": (2e-3, 1e-3, 5e-4),
    "Staggered": (1e-3, 5e-4, 2.5e-4),
    "SecondOrder": (1e-3, 5e-4, 2.5e-4),
}


def measured(scheme, law, relaxation_time):
    """Order in each field from the differences of three runs, γ among them."""
    runs = []
    for step in STEPS[type(scheme).__name__]:
        model = line(scheme, law=law, relaxation_time=relaxation_time, initial=lambda X: gaussian(X, 0.8))
        found = advance(model, step, 0.04)
        runs.append({**found, "activation": model.activation.values.copy()})
    return {
        name: observed_orders([rms(a[name] - b[name]) for a, b in itertools.pairwise(runs)])[-1]
        for name in runs[0]
    }


@pytest.mark.parametrize("law, relaxation_time", [("relaxing", 0.0), ("stretch", 0.08)])
@pytest.mark.parametrize(
    "scheme", [ms.Implicit(tolerance=1e-11), ms.Staggered(), ms.SecondOrder()], ids=lambda s: type(s).__name__
)
def test_the_scheme_keeps_its_order(scheme, law, relaxation_time):
    """schemes: the declared order, also for γ, v, w and u of a law with states, whose step has its drivers
    frozen at the end (first order) or at the middle (second), and of a law that sees the stretch.
    """
    orders = measured(scheme, LAWS[law], relaxation_time)
    assert set(orders) == {"potential", "recovery", "displacement", "activation"}
    low, high = BANDS[scheme.order]
    for what, order in orders.items():
        assert low < order < high, (what, orders)
