"""A result folder as data: ``ms.open`` reads what the run computed, and loads no solver."""

import json
import subprocess
import sys

import myostrain as ms
from myostrain.case.running import run_case
from myostrain.output.quantities import attributes
from myostrain.output.reader import Reader

import numpy as np
import pytest

from small_cases import ALONE, LINE, SHEET, SOLID, changed

UNITS = {"length": "mm", "time": "ms", "potential": "mV", "stress": "kPa"}

#: A slab with units, in which a wave is long enough for beats; a probe's name begins with another's.
CASE = changed(
    SOLID,
    {
        "units": {name: unit for name, unit in UNITS.items() if name != "potential"},  # it has none
        "title": "A <slab>",
        "probes": {"a": [2.0, 1.0, 0.5], "a_b": [4.0, 1.0, 0.5]},
        "output.fields": ["potential", "displacement", "activation"],
    },
)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A run's folder and what it returned."""
    folder = tmp_path_factory.mktemp("open") / "out"
    return folder, run_case(ms.Case.from_dict(CASE), folder, comm=ALONE, figures=False)


def test_it_needs_no_solver(finished):
    """Interface: "`ms.open(DIR)` reads a result folder without a solver"."""
    code = f"""
import sys
for name in ("dolfinx", "dolfinx_solver", "mpi4py", "petsc4py", "ufl"):
    sys.modules[name] = None  # importing it fails
import myostrain as ms
run = ms.open({str(finished[0])!r})
assert "matplotlib" not in sys.modules and "xarray" not in sys.modules
print(run, run._repr_html_(), run.probes, run.measures, run.frames.history("potential"), run.maps)
print(run.frames[-1].deformed, run.metrics.to_xarray(), run.rigid, run.tips, run.electrodes)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "A <slab>" in done.stdout
    assert "<b>A &lt;slab&gt;</b>" in done.stdout


def test_metrics_have_units(finished):
    folder, returned = finished
    run = ms.open(folder)
    assert dict(run.metrics) == json.loads(json.dumps(returned["metrics"]))
    units = run.metrics.units
    assert {name: units[name] for name in ("celerity", "displacement_max", "volume_ratio")} == {
        "celerity": "mm/ms",
        "displacement_max": "mm",
        "volume_ratio": "1",
    }
    assert units["reaction_left_x"] == "kPa mm^2"
    whole = run.metrics.to_xarray()
    assert whole["displacement_max"].item() == returned["metrics"]["displacement_max"]
    assert whole["displacement_max"].attrs["units"] == "mm"
    assert "mm/ms" in repr(run.metrics)
    assert run.finished
    assert run.case["activation"]["beta"] == 0.3


def test_a_misspelt_name_finds_the_known_one(finished):
    """Of a metric and of a field; ``get`` and ``in`` are those of any mapping."""
    run = ms.open(finished[0])
    for names, word, known in (
        (run.metrics, "celerty", "celerity"),
        (run.frames[0], "potentail", "potential"),
    ):
        with pytest.raises(ms.InputError, match=f"'{word}'.* did you mean '{known}'") as caught:
            names[word]
        assert isinstance(caught.value, KeyError)
        assert names.get(word, 3) == 3
        assert word not in names
        assert known in names


def test_a_time_outside_of_the_run_has_no_frame(finished):
    """The frames are 0.01 apart: half of that beyond the last is still nearest to it, more is a mistake."""
    frames = ms.open(finished[0]).frames
    half = np.diff(frames.times).max() / 2
    assert frames.at(frames.times[-1] + 0.9 * half).time == frames.times[-1]
    for time in (1000.0, -1.0, frames.times[-1] + 1.1 * half, np.nan):
        with pytest.raises(ms.InputError, match="is not between the first and the last frame, 0 and "):
            frames.at(time)


def test_probes_and_measures_are_the_tables(finished):
    """Every number of the CSV files, under its probe, its quantity, its time; names are not mixed up."""
    folder, returned = finished
    run = ms.open(folder)
    table = np.genfromtxt(folder / "probes.csv", delimiter=",", names=True)
    assert table.dtype.names[:3] == ("time", "a_potential", "a_recovery")
    np.testing.assert_array_equal(run.probes["time"], table["time"])
    for name in ("a", "a_b"):
        for quantity in ("potential", "recovery", "activation", "displacement_x", "displacement_z"):
            values = run.probes[quantity].sel(probe=name)
            np.testing.assert_array_equal(values, table[f"{name}_{quantity}"])
        position = [float(run.probes[axis].sel(probe=name)) for axis in "XYZ"]
        assert position == CASE["probes"][name]
        beats = run.probes["activation_times"].sel(probe=name).dropna("beat")
        np.testing.assert_array_equal(beats, returned["probes"][name]["activation_times"])
    assert run.probes["potential"].attrs == {"long_name": "potential"}
    assert run.probes["time"].attrs["units"] == "ms"
    measures = np.genfromtxt(folder / "measures.csv", delimiter=",", names=True)
    assert sorted(run.measures) == sorted(set(measures.dtype.names) - {"time"})
    for name in run.measures:
        np.testing.assert_array_equal(run.measures[name], measures[name])


def test_frames_and_maps_are_those_of_the_snapshots(finished):
    """Arrays, the deformed body, and a grid of PyVista, whose cells have the volume of the slab."""
    run = ms.open(finished[0])
    frames = run.frames
    assert len(frames) == len(frames.times) == 4
    assert frames.at(0.021).time == pytest.approx(0.02)
    assert [frame.time for frame in frames[:2]] == frames.times[:2].tolist()
    last = frames[-1]
    assert sorted(last) == ["activation", "displacement", "potential"] == frames.names
    np.testing.assert_allclose(last["activation"], -0.3 * last["potential"])
    np.testing.assert_array_equal(last.deformed, frames.points + last["displacement"])
    np.testing.assert_array_equal(frames.history("potential")[-1], last["potential"])
    grid = last.grid(deformed=True)
    np.testing.assert_array_equal(grid.points, last.deformed.astype(grid.points.dtype))
    np.testing.assert_array_equal(grid["potential"], last["potential"])
    assert grid.cell_data["fibres"].shape == (len(frames.cells), 3)
    assert last.grid().volume == pytest.approx(5 * 2 * 1)
    np.testing.assert_array_equal(run.activation_times[0], Reader(finished[0]).activation())
    assert run.activation_times.attrs == {"long_name": "activation time", "units": "ms"}
    np.testing.assert_array_equal(run.maps["X"], frames.points[:, 0])
    with pytest.raises(ms.InputError, match=r"no field 'strain' .*known: activation"):
        last["strain"]


def test_a_sheet_in_two_dimensions_and_without_units(tmp_path):
    case = ms.Case.from_dict(changed(SHEET, {"output.fields": ["displacement"], "time.end": 4e-3}))
    run_case(case, tmp_path / "out", comm=ALONE, figures=False)
    run = ms.open(tmp_path / "out")
    assert run.metrics.units["celerity"] == "1"
    assert run.frames[-1].grid().n_points == len(run.frames.points)
    assert set(run.probes.coords) >= {"X", "Y"}
    assert "Z" not in run.probes.coords


def test_without_fields_there_are_numbers(tmp_path):
    case = ms.Case.from_dict(changed(SHEET, {"output.fields": [], "time.end": 4e-3}))
    run_case(case, tmp_path / "out", comm=ALONE)
    run = ms.open(tmp_path / "out")
    assert run.metrics.units["reaction_boundary_x"] == "1"
    assert "none (output.fields)" in repr(run)
    with pytest.raises(ms.InputError, match=r"output\.fields"):
        run.frames  # noqa: B018


def test_what_is_no_result_folder_is_said(finished, tmp_path):
    """None, a file, something else, a cell's: one message each that says what to do."""
    (tmp_path / "file").write_text("")
    (tmp_path / "cell").mkdir()
    (tmp_path / "cell" / "trace.csv").write_text("time\n")
    (tmp_path / "cell" / "results.json").write_text("{}")
    (tmp_path / "sweep").mkdir()
    (tmp_path / "sweep" / "sweep.json").write_text("{}")
    for name, words in {
        "none": "is not there",
        "file": "is a file",
        ".": "holds no results of a run",
        "cell": "myostrain cell",
        "sweep": "is a sweep: open one of its runs",
    }.items():
        with pytest.raises(ms.InputError, match=words):
            ms.open(tmp_path / name)


def test_an_unfinished_run_is_read_when_asked_for(tmp_path):
    """A run that failed says when and why; what there is can be read."""
    # A line that springs back where 4 β v x′ > 1 has no equilibrium that conserves J v.
    case = changed(LINE, {"mechanics.imposed_stretch": {"value": 0.95, "until": 0.004}})
    out = tmp_path / "out"
    with pytest.raises(ms.ComputationError) as failed:
        run_case(ms.Case.from_dict(case), out, comm=ALONE)
    with pytest.raises(ms.InputError, match=r"failed at t = 0.004: .*unfinished=True") as error:
        ms.open(out)
    assert failed.value.reason in str(error.value)
    run = ms.open(out, unfinished=True)
    assert not run.finished
    assert not run.metrics
    assert run.failure["reason"] == failed.value.reason
    assert "run not finished" in repr(run)
    assert run.probes["potential"].sel(probe="a").notnull().all()
    with pytest.raises(ms.InputError, match="did not reach its end"):
        run.maps  # noqa: B018
    (out / "failure.json").unlink()
    with pytest.raises(ms.InputError, match=r"has not reached its end.*--resume --out"):
        ms.open(out)


@pytest.mark.parametrize(
    "name", ["results.json", "probes.csv", "measures.csv", "snapshots/mesh.npz", "case.toml"]
)
def test_a_damaged_file_is_named(finished, tmp_path, name):
    folder = tmp_path / "out"
    (folder / "snapshots").mkdir(parents=True)
    for part in ("results.json", "probes.csv", "measures.csv", "snapshots/mesh.npz", "case.toml"):
        (folder / part).write_bytes((finished[0] / part).read_bytes())
    (folder / name).write_bytes(b"time,a\n1,\xff\x00{")
    with pytest.raises(ms.InputError, match=name):
        read_all(folder)


def read_all(folder):
    run = ms.open(folder)
    return run.probes, run.measures, run.frames


def test_units_are_made_of_those_of_the_run():
    """Powers and quotients; where a part is not known, or the dimension is not, none is said."""
    assert attributes("conduction_velocity_median", UNITS, 2)["units"] == "mm/ms"
    assert attributes("front_slope", UNITS, 1)["units"] == "mV/mm"
    assert attributes("reaction_left_x", UNITS, 1)["units"] == "kPa"
    assert attributes("reaction_left_x", UNITS, 2)["units"] == "kPa mm"
    assert "units" not in attributes("reaction_left_x", UNITS, None)
    assert "units" not in attributes("front_slope", {"length": "mm"}, 1)
    assert attributes("twist", {}, 3)["units"] == "degree"
    assert attributes("celerity_rigid", UNITS, 1) == {
        "long_name": "celerity between the first two probes, rigid body",
        "units": "mm/ms",
    }
    assert attributes("celerity_ratio", UNITS, 1)["units"] == "1"
    assert attributes("stroke_volume_change", UNITS, 3)["units"] == "1"
    assert attributes("stroke_work_left", UNITS, 3)["units"] == "kPa mm^3"
    assert attributes("w_2", UNITS, 1) == {"long_name": "w 2"}
