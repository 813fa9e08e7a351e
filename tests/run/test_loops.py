"""Numbers of pressure–volume loops in closed form, their units, and their pictures."""

from myostrain.output.figures.draw import draw
from myostrain.output.loops import loop_numbers, units_of_loops

import numpy as np
import pytest

from picture_tools import finish
from snapshot_files import write_snapshots


def ellipse(amplitudes, points=4000):
    """Beats of unit time around (100, 60): half-widths in volume, and one in pressure, anticlockwise."""
    time = np.linspace(0, len(amplitudes), len(amplitudes) * points + 1)
    width = np.array([*amplitudes, amplitudes[-1]])[time.astype(int)]
    return time, 100 - width * np.sin(2 * np.pi * time), 60 + 50 * np.cos(2 * np.pi * time)


def test_an_elliptic_loop():
    """Stroke volume 2a, work π a b, greatest dp/dt 2π b of the last beat; the change since the one before."""
    found = loop_numbers(*ellipse([20.0, 40.0]), beats=2)
    assert found["stroke_volume"] == pytest.approx(80)
    assert found["volume_max"] == pytest.approx(140)
    assert found["ejection_fraction"] == pytest.approx(80 / 140)
    assert found["stroke_work"] == pytest.approx(np.pi * 40 * 50, rel=1e-5)
    assert found["pressure_max"] == pytest.approx(110)
    assert found["dpdt_max"] == pytest.approx(2 * np.pi * 50, rel=1e-5)
    assert found["stroke_volume_change"] == pytest.approx(1.0, rel=1e-6)
    assert "stroke_volume_change" not in loop_numbers(*ellipse([20.0]), beats=1)


def test_units():
    """Those of the run, put together."""
    wanted = {
        "stroke_volume": "mm^3",
        "stroke_work": "kPa mm^3",
        "pressure_max": "kPa",
        "dpdt_max": "kPa/ms",
        "ejection_fraction": "1",
        "volume_max_left": "mm^3",
    }
    assert units_of_loops(list(wanted), {"length": "mm", "stress": "kPa", "time": "ms"}) == wanted


def test_pictures(tmp_path):
    """A loop and the courses over time, of what is in cavities.csv."""
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    write_snapshots(tmp_path, points, np.array([[0, 1, 2, 3]]), [0.0], potential=np.zeros((1, 4)))
    finish(tmp_path)
    time, volume, pressure = ellipse([20.0, 40.0], 50)
    columns = np.column_stack([time, volume, pressure, 0 * time + 30])
    header = "time,volume_left,pressure_left,pressure_arteries"
    np.savetxt(tmp_path / "cavities.csv", columns, delimiter=",", header=header, comments="")
    found = {path.name: path.stat().st_size for path in draw(tmp_path)}
    assert min(found["loop.png"], found["cavities.png"]) > 5000
