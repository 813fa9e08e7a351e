"""[drive]: a potential that is given over time, and over space by a file; peaks between steps; units."""

import logging

import myostrain as ms
from myostrain.course import missed_peaks
from myostrain.electrics import Drive, GivenPotential

import numpy as np
import pytest

from small_cases import LINE, changed

DRIVEN = {
    "geometry": {"kind": "line", "length": 4.0, "spacing": 0.5},
    "mechanics": {"kinematics": "line", "fixed": ["left"]},
    "drive": {"potential": [[0.0, 0.0], [0.1, 1.0], [0.2, 0.5]]},
    "time": {"step": 0.05, "end": 0.2},
}


def pattern_file(path, points, pattern, **others):
    np.savez(path, points=points, pattern=pattern, **others)
    return path


def test_a_pattern_over_space(tmp_path):
    """Drive, docstring: a factor on v at the file's points, whatever their order; γ follows it."""
    points = np.random.default_rng(2).permutation(np.linspace(0, 4, 41))[:, None]
    file = pattern_file(tmp_path / "pattern.npz", points, points[:, 0] / 4)
    case = ms.Case.from_dict(changed(DRIVEN, {"drive.path": str(file), "activation.beta": 0.2}))
    model = case.build()
    model.start()
    for step in (1, 2, 3):
        model.step(0.05 * step)
    X = model.potential.v.function_space.tabulate_dof_coordinates()[:, 0]
    np.testing.assert_allclose(model.potential.v.x.array, 0.75 * X / 4, atol=1e-14)
    np.testing.assert_allclose(model.mechanics.activation.x.array, -0.2 * 0.75 * X / 4, atol=1e-14)


@pytest.mark.parametrize(
    "arrays, message",
    [
        ({"points": np.zeros((3, 1))}, "has no array 'pattern'"),
        ({"points": np.zeros((3, 1)), "pattern": np.zeros(2)}, "needs real numbers"),
        ({"points": np.zeros((3, 1)), "pattern": np.zeros(3, complex)}, "needs real numbers"),
        ({"points": np.zeros((3, 1)), "pattern": np.full(3, np.nan)}, "not finite"),
        ({"points": np.array([[0.0], [1.0]]), "pattern": np.ones(2)}, "no point nearer than 3"),
    ],
)
def test_files_that_give_no_pattern(tmp_path, arrays, message):
    """One message with the key, that says what is missing."""
    np.savez(tmp_path / "pattern.npz", **arrays)
    body = ms.build(ms.geometry.Line(length=4.0, spacing=0.5))
    with pytest.raises(ms.InputError, match=rf"drive\.path: .*{message}"):
        GivenPotential(body, Drive(path=tmp_path / "pattern.npz"))


def test_peaks_between_steps():
    """missed_peaks, docstring: peaks that lie between two steps, and no others."""
    course = [(0.0, 0.0), (0.1, 1.0), (0.2, 0.5), (0.23, 0.7), (0.35, 0.1), (0.4, 0.1)]
    assert missed_peaks(course, 0.05, 1.0) == [(0.23, 0.7)]
    assert missed_peaks(course, 0.04, 1.0) == [(0.1, 1.0), (0.23, 0.7)]
    assert missed_peaks(course, 0.04, 0.2) == [(0.1, 1.0)]
    assert missed_peaks(2.0, 0.04, 1.0) == []


def test_a_peak_between_steps_is_said(caplog):
    """A case whose [drive] or pressure peaks between two steps warns with key, value and time."""
    with caplog.at_level(logging.WARNING, logger="myostrain"):
        ms.Case.from_dict(DRIVEN).simulation().close()
    assert not caplog.records
    with caplog.at_level(logging.WARNING, logger="myostrain"):
        ms.Case.from_dict(changed(DRIVEN, {"time.step": 0.04})).simulation().close()
    assert "drive.potential: its peak 1 at t = 0.1" in caplog.text


def test_an_interval_that_no_steps_make_is_said(caplog, tmp_path):
    """output.every, a whole number of the steps that solve mechanics: another one is said, and recorded."""
    case = ms.Case.from_dict(
        changed(LINE, {"time.step": 0.01, "time.end": 0.12, "mechanics.every": 2, "output.every": 0.05})
    )
    with caplog.at_level(logging.WARNING, logger="myostrain"):
        case.simulation().close()
    assert not caplog.records  # nothing is written
    with caplog.at_level(logging.WARNING, logger="myostrain"):
        simulation = case.simulation(out=tmp_path / "out")
    assert "output.every = 0.05" in caplog.text
    assert simulation.run()["output"]["every"] == pytest.approx(0.04)


def test_units_that_contradict_the_membrane():
    """A membrane declares its units; [units] that say another one are refused, with both."""
    from myostrain.output.units import units_of

    class InMilliseconds(ms.membranes.Membrane):
        time_unit = "ms"

    assert units_of(InMilliseconds(), {"length": "mm"}) == {"length": "mm", "time": "ms"}
    with pytest.raises(ms.InputError, match=r"units\.time: InMilliseconds counts the time in ms, not s"):
        units_of(InMilliseconds(), {"time": "s"})
