"""Tips of spirals: a rotating field whose tip is prescribed, on a fixed and on a moved body."""

from types import SimpleNamespace

import myostrain as ms
from myostrain.errors import InputError
from myostrain.output.tips import Tip, TipTable

import numpy as np
import pytest

OMEGA = 3.0


class Rotating:
    """v + i·recovery = level + (z − tip(t)) e^{−iω t}: linear in space, so that elements have it exactly."""

    def __init__(self, folder, tip=None, centre=lambda t: 5.1 + 4.3j, turn=1, u=None, shape=None):
        shape = shape or ms.geometry.Ellipse(size=(10.0, 9.0), spacing=0.9, distortion=0.1)
        body = ms.build(shape, ms.UniformFibres(direction=(1.0, 0.0)))
        self.potential = ms.Potential(body, membrane=ms.membranes.FitzHughNagumo())
        X = self.potential.v.function_space.tabulate_dof_coordinates()
        self.z, self.centre, self.turn = X[:, 0] + 1j * X[:, 1], centre, turn
        model = SimpleNamespace(
            potential=self.potential, time=0.0, displacement=lambda: None if u is None else u(X[:, :2])
        )
        self.model, self.folder = model, folder
        self.table = TipTable(model, tip or Tip(), folder)

    def field(self, t):
        return (self.z - self.centre(t)) * np.exp(-1j * self.turn * OMEGA * t)

    def look(self, t, step=1e-3):
        w = self.field(t)
        self.potential.v.x.array[:] = 0.5 + w.real
        self.potential.states[0] = 0.25 + w.imag
        self.model.time = float(t)
        self.table.add(0.5 + self.field(t - step).real, step)

    def rows(self):
        self.table.close()
        return np.loadtxt(self.folder / "tip.csv", delimiter=",", skiprows=1, ndmin=2)


def circle(t):
    return 5.0 + 4.5j + 1.5 * np.exp(0.7j * t)


@pytest.mark.parametrize("turn", [1, -1], ids=["anticlockwise", "clockwise"])
def test_a_standing_tip_is_found_where_it_is(tmp_path, turn):
    """Potential at its threshold and rate zero: to round-off at all times, with the sense of the rotation."""
    seen = Rotating(tmp_path, turn=turn)
    for t in np.linspace(0.0, 2.0, 7):
        seen.look(t)
    rows = seen.rows()
    assert len(rows) == 7
    np.testing.assert_allclose(rows[:, 0], np.linspace(0.0, 2.0, 7))
    np.testing.assert_allclose(rows[:, 1:5], [[5.1, 4.3, 5.1, 4.3]] * 7, atol=1e-7)  # of nine digits
    assert (rows[:, 5] == turn).all()
    found = seen.table.metrics()
    assert (found["tips"], found["tips_max"], found["tip_period"]) == (1, 1, None)
    assert "too few turns" in seen.table.notes()["tip_period"]


def test_a_moving_tip_by_a_state(tmp_path):
    """On its circle to round-off, where the second isoline is that of a state."""
    # Half of its triangles are numbered clockwise.
    shape = ms.geometry.Rectangle(size=(10.0, 9.0), spacing=0.9)
    seen = Rotating(tmp_path, Tip(potential=0.5, state="recovery", value=0.25), circle, shape=shape)
    times = np.linspace(0.0, 9.0, 20)
    for t in times:
        seen.look(t)
    rows = seen.rows()
    np.testing.assert_allclose(rows[:, 1] + 1j * rows[:, 2], circle(times), atol=1e-7)
    assert (rows[:, 5] == 1).all()
    assert set(seen.table._turn) == {1.0, -1.0}


def test_the_core_is_that_of_the_tip_that_was_alone(tmp_path):
    """Period 2π/0.7 and radius 1.5 of a prescribed circle, though a second tip is beside it for a while."""
    tip = Tip(potential=0.5, state="recovery", value=0.25)
    seen = Rotating(tmp_path, tip, circle, shape=ms.geometry.Rectangle(size=(10.0, 9.0), spacing=0.3))
    z = seen.z
    for t in np.linspace(0.0, 30.0, 150):
        if 20 < t < 24:  # not linear: to the interpolation, by less than 0.05
            field = (z - circle(t)) * np.conj(z - 8.9 - 0.7j) / 5
            seen.potential.v.x.array[:] = 0.5 + field.real
            seen.potential.states[0] = 0.25 + field.imag
            seen.model.time = float(t)
            seen.table.add(np.zeros(len(z)), 1e-3)
        else:
            seen.look(t)
    found = seen.table.metrics()
    assert found["tips_max"] == 2
    assert found["tip_period"] == pytest.approx(2 * np.pi / 0.7, rel=1e-3)
    assert found["tip_radius"] == pytest.approx(1.5, rel=2e-3)
    assert found["tip_drift"] < 1e-3
    assert found["tip_deviation"] < 0.02
    assert seen.table.notes() == {}


def test_a_tip_that_comes_after_all_have_gone_is_another_one(tmp_path):
    """Its way begins anew: half a turn of it is none, whatever there was before."""
    seen = Rotating(tmp_path, Tip(potential=0.5, state="recovery", value=0.25), circle)
    for t in np.linspace(0.0, 30.0, 150):
        seen.look(t)
    assert seen.table.metrics()["tip_period"] == pytest.approx(2 * np.pi / 0.7, rel=1e-6)
    seen.potential.v.x.array[:] = 0.0
    seen.table.add(np.zeros(len(seen.z)), 1e-3)
    for t in np.linspace(30.2, 34.0, 20):
        seen.look(t)
    assert seen.table.metrics()["tip_period"] is None


def test_a_moving_tip_by_the_rate_is_first_order_in_the_step(tmp_path):
    """∂v/∂t at the tip is of the rotation and the tip's own motion: within |tip′| / ω of the centre."""
    errors = []
    for step in (2e-2, 1e-2):
        seen = Rotating(tmp_path, centre=circle)
        seen.look(1.3, step)
        row = seen.rows()[-1]
        # v = level on a line through the centre; the rate is zero where ω Im w = Re(tip′ e^{−iωt}).
        motion = 1.05j * np.exp(0.7j * 1.3) * np.exp(-1j * OMEGA * 1.3)
        exact = circle(1.3) + 1j * (motion.real / OMEGA) * np.exp(1j * OMEGA * 1.3)
        errors.append(abs(row[1] + 1j * row[2] - exact))
    assert errors[1] < 0.02
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)


def test_the_place_in_space_is_that_of_the_moved_body(tmp_path):
    """x = X + u, linear in each element."""
    seen = Rotating(
        tmp_path, u=lambda X: np.column_stack([0.1 * X[:, 0] - 0.2 * X[:, 1], 1 + 0.05 * X[:, 1]])
    )
    seen.look(0.4)
    (row,) = seen.rows()
    np.testing.assert_allclose(row[3:5], [5.1 * 1.1 - 0.2 * 4.3, 1 + 1.05 * 4.3], atol=1e-7)


def test_a_tip_on_a_node_is_one_tip(tmp_path):
    """A point that all cells around a node share is one row."""
    seen = Rotating(tmp_path)
    node = seen.z[np.abs(seen.z - (5 + 4.5j)).argmin()]
    seen.centre = lambda t: node
    seen.look(0.0)
    rows = seen.rows()
    assert len(rows) == 1
    np.testing.assert_allclose(rows[0, 1] + 1j * rows[0, 2], node, atol=1e-7)


def test_two_tips_and_none(tmp_path):
    """A pair of opposite senses, in order of X; and a table without a row where v is at rest."""
    seen = Rotating(tmp_path)
    z, a, b = seen.z, 3.0 + 4.4j, 7.1 + 4.6j
    pair = (z - a) * np.conj(z - b) / 4  # not linear: to the interpolation
    seen.potential.v.x.array[:] = 0.5 + pair.real
    seen.table.add(0.5 + (pair * np.exp(1j * OMEGA * 1e-3)).real, 1e-3)
    seen.potential.v.x.array[:] = 0.0
    seen.table.add(np.zeros(len(z)), 1e-3)
    found = seen.table.metrics()
    assert (found["tips"], found["tips_max"], found["tip_radius"]) == (0, 2, None)
    assert seen.table.notes() == {"tip_period": "no tip is left"}
    rows = seen.rows()
    np.testing.assert_allclose(rows[:, 1] + 1j * rows[:, 2], [a, b], atol=0.2)
    assert rows[:, 5].tolist() == [1, -1]


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"output.tip": {"state": "recovry"}}, "recovery"),
        ({"output.tip": {"stat": "recovery"}}, "'state'"),
        ({"output.tip": {"every": -1.0}}, "output.tip.every"),
        ({"output.tip": 3}, "output.tip"),
    ],
)
def test_wrong_tips(changes, words):
    """One message that names key and value."""
    from small_cases import ALONE, SHEET, changed

    with pytest.raises(InputError) as error:
        ms.Case.from_dict(changed(SHEET, changes)).simulation(ALONE).run()
    assert words in str(error.value)


def test_tips_are_of_sheets():
    """A line has none."""
    from small_cases import LINE, changed

    with pytest.raises(InputError, match=r"output\.tip.*sheets"):
        ms.Case.from_dict(changed(LINE, {"output.tip": {}}))
