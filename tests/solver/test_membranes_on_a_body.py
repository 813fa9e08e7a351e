"""Published membranes on a body where nothing varies in space: the beat of a single cell, by our schemes."""

import myostrain as ms

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from membrane_tools import slopes

#: Each model, the potential it starts from, until when, and how near 200 steps come: v by its range, and the
#: states. About thrice what was measured.
STARTS = [
    (ms.membranes.AlievPanfilov1996(), 0.3, 4.0, 1e-5, 6e-5),
    (ms.membranes.MitchellSchaeffer2003(), 0.3, 10.0, 2e-8, 1e-6),
    (ms.membranes.FentonKarma1998(set="Set 3"), 0.3, 4.0, 2e-5, 5e-8),
    (ms.membranes.BuenoOrovio2008(set="ENDO"), -45.0, 4.0, 8e-5, 5e-4),
    (ms.membranes.LuoRudy1991(), -50.0, 4.0, 2e-3, 1.5e-3),
]


@pytest.mark.parametrize(
    "cell, start, end, near, near_states", STARTS, ids=[type(s[0]).__name__ for s in STARTS]
)
def test_a_uniform_body_is_a_single_cell(cell, start, end, near, near_states):
    """By the second-order scheme and the integrator that a model gets: what SciPy gives."""
    body = ms.build(ms.geometry.Line(length=2.0, spacing=1.0))
    everywhere = ms.InitialValues(potential=start, where=ms.Place(box=((-1.0,), (3.0,))))
    model = ms.Electromechanics(ms.Potential(body, membrane=cell, initial=[everywhere]))
    model.start()
    for step in range(1, 201):
        model.step(step * end / 200)
    v, *states = model.potential.field_values().values()
    exact = solve_ivp(
        lambda t, y: slopes(cell, y), (0, end), [start, *cell.resting_states()], method="LSODA", rtol=1e-9
    ).y[:, -1]
    size = cell.range[1] - cell.range[0]
    assert exact[0] > cell.threshold  # it has fired
    np.testing.assert_allclose(v, exact[0], rtol=0, atol=near * size)
    for state, expected in zip(states, exact[1:], strict=True):
        np.testing.assert_allclose(state, expected, rtol=0, atol=near_states)
