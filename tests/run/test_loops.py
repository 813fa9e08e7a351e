"""Numbers of pressure–volume loops in closed form, their units, and their pictures."""

from types import SimpleNamespace

from myostrain.output.clinical import clinical
from myostrain.output.figures.draw import draw
from myostrain.output.figures.loops import isovolumetric
from myostrain.output.figures.measures import since_first
from myostrain.output.loops import loop_numbers, units_of_loops
from myostrain.output.peaks import Peaks
from myostrain.output.segments import KINDS
from myostrain.sweeping.loops import draw_loops
from myostrain.sweeping.members import Member

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
    assert min(found["loop.png"], found["cavities.png"], found["wiggers.png"]) > 5000


def test_phases_of_constant_volume():
    """Rows between two others of the same volume; a slow change is one."""
    volume = np.array([100.0, 100, 100, 80, 60, 60, 60, 80, 100])
    np.testing.assert_array_equal(isovolumetric(volume), [1, 1, 0, 0, 0, 1, 0, 0, 0])


def test_what_a_cardiologist_reads():
    """Clinical units, from mm, kPa and ms; without cavities nothing."""
    units = {"volume_max": "mm^3", "pressure_max": "kPa", "dpdt_max": "kPa/ms", "stroke_work": "kPa mm^3"}
    metrics = {
        "celerity": None,
        "volume_max": 120e3,
        "ejection_fraction": 0.6,
        "pressure_max": 16.0,
        "dpdt_max": 0.2,
        "stroke_work": 1.1e6,
        "twist": 14.0,  # since rest
        "twist_beat": 11.0,
        "longitudinal_strain_peak": -0.18,
        "fibre_stress_3": 1.0,
    }
    rows = {name: (value, unit) for name, value, unit in clinical(metrics, units)}
    assert rows == {
        "end-diastolic volume": (pytest.approx(120.0), "mL"),
        "ejection fraction": (pytest.approx(60.0), "%"),
        "greatest pressure": (pytest.approx(120.0, rel=1e-3), "mmHg"),
        "greatest dP/dt": (pytest.approx(1500.1, rel=1e-3), "mmHg/s"),
        "stroke work": (pytest.approx(1.1), "J"),
        "twist": (11.0, "degrees"),
        "greatest longitudinal strain": (pytest.approx(-18.0), "%"),
    }
    assert next(iter(rows)) == "end-diastolic volume"
    two = {"volume_max_left": 1.0, "stroke_volume_change_right": 0.01}
    assert [name for name, _, _ in clinical(two, {})] == [
        "end-diastolic volume, left",
        "change of stroke volume, right",
    ]
    assert clinical({"twist_beat": 3.0, "celerity": 1.0}, units) == []


def test_strains_since_the_beginning():
    """The largest mean strain of a wall that was stretched by a tenth before the run began."""
    peaks = Peaks()
    for strain in (0.1, -0.01, 0.045):
        peaks.observe({"longitudinal_strain": strain})
    assert peaks.found["longitudinal_strain_peak"] == pytest.approx(0.99 / 1.1 - 1)
    again = Peaks(peaks.found)
    again.observe({"longitudinal_strain": -0.12})
    assert again.found["longitudinal_strain_peak"] == pytest.approx(0.88 / 1.1 - 1)


def test_a_wall_since_the_beginning():
    """Twist, thickening and shortening of a wall that had them when the run began, and since rest."""
    peaks = Peaks()
    for twist, thickening, shortening in ((-2.0, -0.2, -0.1), (-3.0, 0.0, 0.01), (5.0, 0.2, 0.12)):
        values = {"wall_thickening": thickening, "longitudinal_shortening": shortening}
        peaks.observe({"twist": twist, **values})
    assert peaks.found["twist"] == 5.0
    assert peaks.found["twist_beat"] == 7.0
    assert peaks.found["wall_thickening_beat"] == pytest.approx(1.2 / 0.8 - 1)
    assert peaks.found["longitudinal_shortening_beat"] == pytest.approx(1 - 0.88 / 1.1)
    again = Peaks(peaks.found)
    again.observe({"twist": -12.0, "wall_thickening": 0.3})
    assert again.found["twist_beat"] == -10.0
    assert again.found["wall_thickening_beat"] == pytest.approx(1.3 / 0.8 - 1)
    assert again.found["wall_thickening_begin"] == -0.2


def test_pictures_of_segments(tmp_path):
    """Strains over time and a bull's eye, since the first row, from measures.csv alone."""
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    write_snapshots(tmp_path, points, np.array([[0, 1, 2, 3]]), [0.0], potential=np.zeros((1, 4)))
    finish(tmp_path)
    time = np.linspace(0, 1, 20)
    columns = {"time": time, "volume_ratio": 1 + 0 * time, "twist": 10 * time}
    for kind in KINDS:
        columns |= {f"{kind}_{n}": 0.1 + n * 0.01 * time for n in range(1, 18)}
    table = np.column_stack(list(columns.values()))
    np.savetxt(tmp_path / "measures.csv", table, delimiter=",", header=",".join(columns), comments="")
    found = {path.name: path.stat().st_size for path in draw(tmp_path)}
    assert min(found[f"{name}.png"] for name in ("measures", "strains", "bullseye")) > 5000
    strains = since_first(columns, "radial")
    np.testing.assert_allclose(strains[16], (1.1 + 0.17 * time) / 1.1 - 1, rtol=1e-12)


def test_loops_of_a_sweep(tmp_path):
    """The last beats of runs over each other, those without cavities left out."""
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    members = []
    for number, width in enumerate([20.0, 30.0, 40.0, None]):
        folder = tmp_path / f"00{number}"
        folder.mkdir()
        write_snapshots(folder, points, np.array([[0, 1, 2, 3]]), [0.0], potential=np.zeros((1, 4)))
        finish(folder)
        members.append(Member(folder.name, {"circulation.preload": number}, SimpleNamespace(title="loops")))
        if width:
            columns = np.column_stack(ellipse([width], 50))
            header = "time,volume_left,pressure_left"
            np.savetxt(folder / "cavities.csv", columns, delimiter=",", header=header, comments="")
    (tmp_path / "figures").mkdir()
    (found,) = draw_loops(tmp_path, members)
    assert found.stat().st_size > 5000
    assert draw_loops(tmp_path, members[3:]) == []
