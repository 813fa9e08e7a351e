"""A sweep: runs in folders, one that fails is left, a killed one goes on, one table of all."""

import csv
import signal
import subprocess
import time

import myostrain as ms
from myostrain.output.lock import FolderLock

import numpy as np
import pytest
import xarray as xr

from small_cases import COMMAND, LINE, changed, command_line, write_case

#: A line that is held springs back at once where 4 β v x′ > 1: there is no equilibrium then.
CASE = changed(
    LINE,
    {
        "mechanics.imposed_stretch": {"value": 0.95, "until": 1.0},
        "output.fields": [],
        "output.checkpoint_every": 0.05,
    },
)

#: One fails, one ends, one takes long; side by side.
KEYS = ("mechanics.imposed_stretch.until", "time.end")
VALUES = [(0.004, 0.01), (9.0, 0.01), (10.0, 3.0)]


def wait(until, seconds=120.0):
    end = time.monotonic() + seconds
    while not until():
        assert time.monotonic() < end
        time.sleep(0.05)


@pytest.fixture(scope="module")
def killed(tmp_path_factory):
    """The folder of a sweep that was killed by SIGKILL in its last run, with what its runs had left."""
    folder = tmp_path_factory.mktemp("sweep")
    file, out = write_case(folder / "line.toml", CASE), folder / "out"
    sets = [f"{key}={[pair[i] for pair in VALUES]}" for i, key in enumerate(KEYS)]
    command = ["sweep", file, "--list", "--jobs", "2", "--no-figures", "--out", out]
    command += [word for text in sets for word in ("--set", text)]
    process = subprocess.Popen([*COMMAND, *map(str, command)], stderr=subprocess.PIPE, text=True)
    wait(
        lambda: (
            process.poll() is not None
            or (
                (out / "001" / "failure.json").exists()
                and (out / "002" / "results.json").exists()
                and any((out / "003" / "checkpoint").glob("*"))
            )
        )
    )
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL, process.communicate()
    assert not (out / "003" / "results.json").exists(), "it was too fast to be killed"
    return out, command


def test_a_killed_sweep_leaves_no_run_behind_and_goes_on(killed):
    """Issue: "resumable after a kill", "failed members reported and left"."""
    out, command = killed

    def free():
        try:
            FolderLock(out / "003").release()
        except ms.InputError:
            return False
        return True

    wait(free, 10.0)
    before = {name: (out / name / "run.log").stat().st_mtime_ns for name in ("001", "002")}
    refused = command_line(*command)
    assert (refused.status, "holds something already" in refused.err) == (2, True)
    done = command_line("sweep", "--resume", "--out", out, "--no-figures")
    assert done.status == 3
    assert done.err.splitlines()[-1].startswith("myostrain: 001 (mechanics.imposed_stretch.until = 0.004, ")
    assert "at t = 0.004: no equilibrium conserves" in done.err.splitlines()[-1]
    assert "2 of 3 runs done" in done.out
    assert before == {name: (out / name / "run.log").stat().st_mtime_ns for name in before}
    assert "resumed at t =" in (out / "003" / "run.log").read_text()
    assert ms.open(out / "003").results["steps"] == 3000
    with (out / "table.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["status"] for row in rows] == ["failed", "done", "done"]
    assert [(float(row[KEYS[0]]), float(row[KEYS[1]])) for row in rows] == VALUES
    assert rows[0]["potential_max"] == ""
    metrics = ms.open(out / "002").metrics
    assert float(rows[1]["potential_max"]) == pytest.approx(metrics["potential_max"], rel=1e-8)
    table = xr.open_dataset(out / "table.nc")
    assert table["potential_max"].dims == ("run",)
    assert table["potential_max"].sel(run="002").item() == metrics["potential_max"]
    assert np.isnan(table["potential_max"].sel(run="001"))
    assert table["status"].values.tolist() == ["failed", "done", "done"]
    np.testing.assert_array_equal(table["time.end"], [pair[1] for pair in VALUES])
    assert (out / "figures" / "metrics.png").stat().st_size > 5000


def test_a_grid_in_a_script(tmp_path):
    """The table over the keys, with units; each run is that of the command line."""
    case = ms.Case.from_dict(changed(LINE, {"output.fields": [], "units": {"length": "mm", "time": "ms"}}))
    told = []
    found = ms.sweep(
        case,
        {"activation.beta": [0.0, 0.2], "cell.recovery": [True]},
        out=tmp_path / "out",
        jobs=2,
        figures=False,
        plot=["displacement_max"],
        tell=lambda said, done, total: told.append((done, total)),
    )
    assert found.failed == {}
    assert told[-1] == (2, 2)
    assert sorted(told) == told
    table = found.table
    assert table["displacement_max"].dims == ("activation.beta", "cell.recovery")
    assert table["displacement_max"].attrs["units"] == "mm"
    alone = ms.run_case(
        ms.Case.from_dict({**case.parameters, "activation": {"beta": 0.2}}), tmp_path / "alone"
    )
    chosen = table.sel({"activation.beta": 0.2, "cell.recovery": "true"})
    assert chosen["displacement_max"].item() == alone["metrics"]["displacement_max"]
    assert chosen["run"].item() == "002"
    assert found.runs["002"].metrics["displacement_max"] == alone["metrics"]["displacement_max"]
    assert [path.name for path in found.pictures] == ["metrics.png"]
    with pytest.raises(ms.InputError, match="no metric is called 'celerty'; did you mean 'celerity'"):
        ms.sweep(None, out=tmp_path / "out", resume=True, figures=False, plot=["celerty"])


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["startup-1d"], "a list of values"),
        (["startup-1d", "--set", "cell.alpha=[0.1]", "--resume"], "--out DIR"),
        ([], "CASE: name a case"),
        (["--resume", "--out", "nowhere"], "--out: nowhere holds no sweep to go on with"),
        (["startup-1d", "--set", "cell.alpha=[0.1]", "--set", "cell.alpha=[0.2]"], "given twice"),
        (["startup-1d", "--set", "cell.alpha=[0.1]", "--jobs", "0"], "--jobs: 0: give 1 or more"),
        (["none", "--set", "cell.alpha=[0.1]"], "no case is called 'none'"),
    ],
)
def test_wrong_use(tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    done = command_line("sweep", *arguments)
    assert done.status == 2
    assert words in done.err
    assert not list(tmp_path.iterdir())
