"""A law with a state under a potential that grows in time, against its closed form."""

import myostrain as ms
from myostrain.electrics import Drive, GivenPotential

import numpy as np
import pytest

BETA, TAU, END = 0.3, 0.4, 1.0


def error(scheme, steps):
    """Error of γ at the end for v = t and τ γ′ = −β v − γ: γ = −β (t − τ (1 − exp(−t/τ)))."""
    body = ms.build(ms.geometry.Line(length=2.0))
    mechanics = ms.Mechanics(
        body,
        kinematics=ms.kinematics.Line(),
        material=ms.materials.Spring(),
        supports=ms.Supports(fixed=("left",)),
    )
    given = GivenPotential(body, Drive(potential=((0.0, 0.0), (END, END))))
    law = ms.activation.Relaxing(beta=BETA, rise=TAU, fall=TAU)
    model = ms.Electromechanics(given, mechanics, law=law, scheme=scheme)
    model.start()
    for number in range(1, steps + 1):
        model.step(number * END / steps)
    exact = -BETA * (END - TAU * (1 - np.exp(-END / TAU)))
    return np.abs(model.activation.values - exact).max()


@pytest.mark.parametrize("scheme, order", [(ms.SecondOrder(), 2), (ms.Staggered(), 1), (ms.Implicit(), 1)])
def test_the_order_is_that_to_the_closed_form(scheme, order):
    """Law contract: drivers frozen at the middle of a step (second order), or at its end (first order)."""
    errors = [error(scheme, steps) for steps in (10, 20, 40)]
    observed = np.log2(np.array(errors[:-1]) / errors[1:])
    assert ((order - 0.1 < observed) & (observed < order + 0.1)).all(), (errors, observed)
