"""Loads, springs and prescribed displacements by functions of time: closed forms, and the same as points."""

import myostrain as ms
from myostrain.kinematics import Line, PlaneStress, Solid
from myostrain.materials import NeoHookean, Spring

import numpy as np
import pytest

FIBRES = ms.UniformFibres(direction=(1.0, 0.0))


def line(**parts):
    names = ("fixed", "displacement", "robin", "robin_normal")
    supports = ms.Supports(**{name: parts.pop(name) for name in names if name in parts})
    return ms.Mechanics(
        ms.build(ms.geometry.Line(length=4.0, spacing=2.0)),
        kinematics=Line(),
        material=Spring(mu=2.0),
        supports=supports,
        loads=ms.Loads(**parts),
    )


def ends(mechanics, time):
    """Displacement of both ends at a time."""
    mechanics.solve(time)
    mechanics.accept(time)
    nodal = mechanics.displacement()
    order = np.argsort(nodal.function_space.tabulate_dof_coordinates()[:, 0])
    return nodal.x.array[order[[0, -1]]]


def test_a_line_on_a_spring_that_changes():
    """A traction T(t) stretches the line by T L/μ and its spring by T/k(t): the traction and k are seen."""
    mechanics = line(traction={"right": lambda t: [0.2 * np.sin(t)]}, robin={"left": lambda t: 1.0 + t})
    mechanics.start()
    for time in (0.3, 0.7, 1.9):
        force = 0.2 * np.sin(time)
        left, right = ends(mechanics, time)
        assert left == pytest.approx(force / (1 + time), rel=1e-9)
        assert right - left == pytest.approx(force * 4.0 / 2.0, rel=1e-9)


def test_a_line_that_is_pulled():
    mechanics = line(fixed=("left",), displacement={"right": {"x": lambda t: 0.1 * t**2}})
    mechanics.start()
    assert ends(mechanics, 0.5) == pytest.approx([0.0, 0.025], abs=1e-12)


@pytest.mark.parametrize("kind", ["sheet", "solid"])
def test_a_function_is_what_its_points_are(kind):
    """The same pressure and springs by points, by a number and by functions give the same bits."""
    found = []
    for pressure, stiffness in ((((0.0, 0.0), (1.0, 0.2)), 0.5), (lambda t: 0.2 * t, lambda t: 0.5)):
        if kind == "sheet":
            body = ms.build(ms.geometry.Rectangle(size=(2.0, 1.0), spacing=1.0), FIBRES)
            kinematics = PlaneStress()
        else:
            fibres = ms.UniformFibres(direction=(1.0, 0.0, 0.0))
            body = ms.build(ms.geometry.Slab(size=(1.0, 1.0, 1.0), spacing=1.0), fibres)
            kinematics = Solid()
        mechanics = ms.Mechanics(
            body,
            kinematics=kinematics,
            material=NeoHookean(mu=2.0),
            supports=ms.Supports(robin={"left": stiffness}),
            loads=ms.Loads(pressure={"right": pressure}),
        )
        mechanics.start()
        mechanics.solve(0.5)
        found.append(mechanics.u.x.array.copy())
    assert np.abs(found[0]).max() > 0.01
    np.testing.assert_array_equal(*found)


def test_a_resumed_run_has_the_same_bits(tmp_path):
    """Functions of time go on where the checkpoint is."""

    def run(folder, end, **others):
        mechanics = line(
            traction={"right": lambda t: [np.sin(40 * t)]}, robin={"left": lambda t: 1.0 + 9 * t}
        )
        model = ms.Electromechanics(
            ms.GivenPotential(mechanics.body, drive=ms.Drive(potential=((0.0, 0.0), (0.1, 1.0)))),
            mechanics,
            law=ms.activation.Proportional(beta=0.1),
        )
        out = tmp_path / folder
        ms.Simulation(model, step=1e-2, end=end, out=out, checkpoint_every=0.02, **others).run()
        return mechanics.u.x.array

    whole = run("whole", 0.06)
    run("parts", 0.04)
    np.testing.assert_array_equal(run("parts", 0.06, resume=True), whole)


@pytest.mark.parametrize(
    "parts, words",
    [
        ({"pressure": {"right": lambda: 0.1}}, r"mechanics\.pressure\.right: .*at t = 0 it raises TypeError"),
        ({"pressure": {"right": lambda t: "much"}}, r"pressure\.right: .*raises ValueError"),
        ({"traction": {"right": lambda t: [[1.0]]}}, r"traction\.right: .*it is \[\[1\.0\]\]"),
        ({"traction": {"right": lambda t: [1.0, 2.0]}}, r"traction\.right: give 1 numbers"),
        ({"robin": {"left": lambda t: t - 1}}, r"robin\.left: .*may not be below 0"),
        ({"robin": lambda t: np.nan}, r"mechanics\.robin: .*it is nan"),
        ({"pressure": {"right": float}, "robin": {"left": "k"}}, r"pressure\.right|robin\.left"),
    ],
)
def test_what_is_no_function_of_time_is_said(parts, words):
    """Before the first step, with the key."""
    with pytest.raises(ms.InputError, match=words):
        line(**parts)


def test_a_function_that_fails_later_names_its_time():
    mechanics = line(fixed=("left",), traction={"right": lambda t: [1 / (0.5 - t) if t < 0.5 else np.inf]})
    mechanics.start()
    with pytest.raises(ms.ComputationError, match=r"mechanics\.traction\.right .*inf") as error:
        mechanics.solve(0.5)
    assert error.value.time == 0.5
