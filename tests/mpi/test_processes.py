"""Two processes against one: the same numbers, one message, no hanging."""

import json

from myostrain import Case, run_case
from myostrain.case.running import load_results
from myostrain.output.snapshots import Snapshots

import numpy as np
import pytest

from small_cases import ALONE, LINE, SHEET, changed, other_process, write_case
from snapshot_files import check_vtx

pytestmark = pytest.mark.mpi

# The wave reaches the first two probes.
PULSE = changed(
    LINE,
    {
        "geometry": {"kind": "line", "length": 60.0, "spacing": 1.0},
        "probes": {"a": [15.0], "b": [20.3], "c": [59.5]},
        "time": {"step": 2e-3, "end": 0.4, "scheme": "second-order"},
        "output": {"every": 0.1},
    },
)
STRESS = changed(
    SHEET,
    {
        "geometry": {"kind": "ellipse", "size": [24.0, 30.0], "spacing": 1.5, "distortion": 0.15},
        "initial": [
            {"potential": 0.9, "center": [17.0, 6.0], "radius": 5.0},
            {"states": {"recovery": 0.1}, "box": [[18.0, 0.0], [24.0, 30.0]]},
        ],
        "probes": {"a": [12.0, 12.0], "b": [10.1, 15.3], "c": [4.0, 24.0]},
        "potential.diffusivity": [100.0, 40.0],
        "time": {"step": 2.5e-3, "end": 0.25, "scheme": "second-order"},
        "mechanics.every": 5,
        "electrodes": {"V1": [12.0, 12.0, 6.0]},
        "output": {
            "every": 0.1,
            "repolarization": [20, 90],
            "tip": {"potential": 0.2, "state": "recovery", "value": 0.05},
        },
    },
)
# Without a support: held at points, which must be the same on any number of processes.
STRAIN = changed(
    STRESS,
    {
        "geometry.spacing": 3.0,
        "initial": {"potential": 0.9, "center": [17.0, 6.0], "radius": 5.0},
        "mechanics": {"kinematics": "plane-strain", "constraint": "elastic"},
        "material": {"model": "MooneyRivlin", "mu": 1.0, "mu_2": 0.5},
        "time": {"step": 5e-3, "end": 0.25, "scheme": "staggered"},
    },
)
RECTANGLE = changed(
    STRESS,
    {
        "geometry": {"kind": "rectangle", "size": [20.0, 12.0], "spacing": 1.5},
        "initial": {"potential": 0.9, "center": [0.0, 0.0], "radius": 6.0},
        "probes": {"a": [7.0, 3.0], "b": [9.1, 4.2]},
        "mechanics": {"kinematics": "plane-stress", "fixed": ["left"]},
        "time": {"step": 1e-2, "end": 0.3, "scheme": "implicit", "tolerance": 1e-10},
    },
)
# The potential on a mesh of its own; J follows the activation.
NESTED = changed(
    STRESS, {"geometry.spacing": 3.0, "potential.refinement": 1, "mechanics.constraint": "elastic"}
)
CASES = {
    "line": PULSE,
    "plane-stress": STRESS,
    "plane-strain": STRAIN,
    "rectangle": RECTANGLE,
    "nested": NESTED,
}

DRIVER = """
import sys
from pathlib import Path
from myostrain import Case, run_case
for file in map(Path, sys.argv[1:]):
    run_case(Case.from_file(file), file.parent / "two" / file.stem, figures=False)
"""


@pytest.fixture
def two(mpiexec):
    """The launcher of two processes."""
    return (mpiexec, "-n", "2")


@pytest.fixture(scope="module")
def runs(on_processes, tmp_path_factory):
    """The folder in which every case ran: one/NAME on one process, two/NAME on two."""
    folder = tmp_path_factory.mktemp("runs")
    files = [write_case(folder / f"{name}.toml", case) for name, case in CASES.items()]
    on_processes(2, DRIVER, *files)
    for file in files:
        run_case(Case.from_file(file), folder / "one" / file.stem, comm=ALONE, figures=False)
    return folder


def difference(one, two):
    """Largest difference of two dictionaries of numbers, relative to each number; None only beside None."""
    assert {k for k, v in one.items() if v is None} == {k for k, v in two.items() if v is None}
    pairs = np.array([(v, two[k]) for k, v in one.items() if v is not None])
    return np.max(np.abs(pairs[:, 0] - pairs[:, 1]) / np.maximum(1e-3, np.abs(pairs[:, 0])))


@pytest.mark.parametrize("name", CASES)
def test_numbers_do_not_depend_on_the_processes(runs, name):
    """Design: "does not depend on the number of processes beyond round-off of the solvers' tolerances"."""
    one, two = (load_results(runs / processes / name) for processes in ("one", "two"))
    assert (one["processes"], two["processes"]) == (1, 2)
    times = [{k: p["activation_time"] for k, p in r["probes"].items()} for r in (one, two)]
    assert times[0]["a"] < times[0]["b"]
    assert one["metrics"]["celerity"] > 10
    # Each process has incomplete factors of its own, so that a linear solve differs by its tolerance, 1e-10.
    # Measured after 50 steps: 3e-10 in times and celerity, 1.1e-8 in the least potential.
    assert difference(*times) < 1e-8
    assert difference(one["metrics"], two["metrics"]) < 5e-8
    for key in ("steps", "time", "cells", "unknowns", "parameters"):
        assert one[key] == two[key]


@pytest.mark.parametrize("name", CASES)
def test_files_do_not_depend_on_the_processes(runs, name):
    """The same of the snapshots and the probe table: whole fields in a file, whatever process has a node."""
    tables = [
        np.loadtxt(runs / processes / name / "probes.csv", delimiter=",", skiprows=1)
        for processes in ("one", "two")
    ]
    np.testing.assert_allclose(tables[1], tables[0], rtol=0, atol=1e-6)
    one, two = (Snapshots(runs / processes / name) for processes in ("one", "two"))
    np.testing.assert_array_equal(two.points, one.points)
    np.testing.assert_array_equal(two.cells, one.cells)
    np.testing.assert_array_equal(two.times, one.times)
    assert two.names == one.names == {"potential", "recovery", "displacement", "stress_trace"}
    for field in one.names:
        for frame in range(len(one.times)):
            np.testing.assert_allclose(two.field(field, frame), one.field(field, frame), rtol=0, atol=1e-6)
    assert two.maps().keys() == one.maps().keys() >= {"activation_times", "conduction_velocity"}
    for key, values in one.maps().items():
        np.testing.assert_allclose(two.maps()[key], values, rtol=1e-5, atol=1e-6)
    for table in ("tip.csv", "ecg.csv"):
        if name == "plane-stress":
            rows = [
                np.loadtxt(runs / processes / name / table, delimiter=",", skiprows=1)
                for processes in ("one", "two")
            ]
            assert len(rows[0]) > 10
            np.testing.assert_allclose(rows[1], rows[0], rtol=1e-5, atol=1e-6)
    check_vtx(runs / "two" / name)


@pytest.mark.parametrize(
    "case, changes, status, words",
    [
        (LINE, {"cell.alpah": 0.1}, 2, "'alpha'"),
        (LINE, {"mechanics.fixed": ["lft"]}, 2, "'left'"),
        (SHEET, {"probes.a": [500.0, 0.0]}, 2, "outside"),
        (LINE, {"mechanics.imposed_stretch": {"value": 0.95, "until": 0.004}}, 3, "failed at t = 0.004"),
    ],
    ids=["key", "boundary", "probe", "solver"],
)
def test_one_message_and_no_hanging(two, tmp_path, case, changes, status, words):
    """Interface, exit statuses: on two processes too, with one message."""
    file = write_case(tmp_path / "case.toml", changed(case, changes))
    done = other_process("run", file, "--out", "out", launcher=two, cwd=tmp_path, timeout=200)
    assert done.status == status, done.err
    assert done.err.count("myostrain: ") == 1 + done.err.count("; trying ")
    assert words in done.err
    assert done.out == ""
    assert (tmp_path / "out").exists() is (status == 3)
    if status == 3:
        assert json.loads((tmp_path / "out" / "failure.json").read_text())["reason"] in done.err
        assert not (tmp_path / "out" / "results.json").exists()


def test_command_on_two_processes(two, tmp_path):
    """README: `mpiexec -n 2 myostrain run`; one report; with nothing to draw no process waits for ever."""
    file = write_case(tmp_path / "case.toml", changed(LINE, {"output.fields": []}))
    done = other_process("run", file, "--out", "out", "--quiet", launcher=two, cwd=tmp_path, timeout=200)
    assert done.status == 0, done.err
    assert done.out.count("numbers in") == 1
    assert load_results(tmp_path / "out")["processes"] == 2
