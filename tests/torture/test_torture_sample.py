"""A sample of the torture campaign, `make torture`: whatever happens, the result is the same."""

import json
import shutil
from pathlib import Path

import myostrain as ms
from myostrain import cases

import numpy as np
import pytest

from torture.campaign import Campaign
from torture.live import BARE, LINE, MPIEXEC, Row, difference

SEED = 20


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    return Campaign(tmp_path_factory.mktemp("torture"), SEED)


def survived(row: Row, faults: int) -> None:
    """All faults of a row were survived, every result is that of the undisturbed run, to 1e-12."""
    assert row.problems == []
    assert row.clean
    assert row.faults == faults


def test_killed_at_any_moment_a_resumed_run_ends_with_the_same_result(campaign):
    """SIGKILL in start-up, setting up, stepping, output, checkpoint writing, at the end and while drawing."""
    survived(campaign.kills(LINE, 7), 7)


@pytest.mark.slow  # as test_cli and test_resume do with a line
def test_interrupted_it_leaves_a_checkpoint(campaign):
    """Interface: exit status 130 after SIGINT and 143 after SIGTERM, each after a checkpoint."""
    survived(campaign.signals(BARE, 1), 1)


@pytest.mark.slow  # as tests/mpi do
@pytest.mark.mpi
@pytest.mark.skipif(MPIEXEC is None, reason="there is no mpiexec beside this Python or on the path")
def test_a_run_goes_on_with_another_number_of_processes(campaign):
    """Design: the result does not depend on the number of processes; to 1e-6 here."""
    survived(campaign.other_processes(BARE, 2, 1), 1)


def test_a_damaged_checkpoint_is_noticed_and_the_one_before_it_is_used(campaign):
    """A flipped bit is noticed and the file named; in both checkpoints it is one message, exit status 2."""
    survived(campaign.damage(BARE, flips=1, kinds=("middle",)), 2)


def test_a_full_disk_is_a_failure_that_a_resumed_run_repairs(campaign):
    """Interface: exit status 3 and a message."""
    survived(campaign.file_limit(BARE, (0.8,)), 1)


@pytest.mark.slow  # as test_resume does
def test_one_run_a_folder(campaign):
    """A folder in use is refused to `--resume` and to `--force`, the run in it is not disturbed."""
    survived(campaign.in_use(BARE), 2)


class Spoiler:
    """Makes a node's values NaN after some step, as a bug or a bad memory cell would."""

    def __init__(self, model, step):
        self.potential, self.step = model.potential, step

    def update(self, step, time):
        if step == self.step:
            for v, states in [(self.potential.v.x.array, ()), *self.potential.past.values]:
                for array in (v, *states):
                    array[3] = np.nan


def test_a_nan_is_noticed_in_the_step_and_said_where(tmp_path):
    """The issue: a ComputationError that names the time and the place; results.json is not written."""
    settings = [*LINE.settings, "geometry.length=20.0", "probes={a=[15.0]}", "time.end=0.02"]
    case = ms.Case.from_file(cases.path("pulse-1d"), settings)
    simulation = case.simulation(ms.engine.MPI.COMM_SELF, tmp_path / "run")
    X = simulation.model.potential.v.function_space.tabulate_dof_coordinates()[3, 0]
    with pytest.raises(ms.ComputationError) as failure:
        simulation.run(Spoiler(simulation.model, 7))
    assert failure.value.time == pytest.approx(0.008, abs=1.1e-3)
    assert f"{X:g}" in str(failure.value)
    assert not (tmp_path / "run" / "results.json").exists()


def test_the_comparison_sees_what_it_should(campaign, tmp_path):
    """Planted: one digit of a metric, of a probe's row and of a frame, a missing row and a missing frame."""
    whole = campaign.reference(LINE).folder

    def changed(name, change) -> tuple[float, list[str]]:
        copy = tmp_path / name
        shutil.copytree(whole, copy)
        change(copy)
        return difference(whole, copy)

    def metric(folder: Path) -> None:
        path = folder / "results.json"
        data = json.loads(path.read_text())
        data["metrics"]["celerity"] *= 1 + 2e-12
        path.write_text(json.dumps(data))

    def rows(change):
        def apply(folder: Path) -> None:
            path = folder / "probes.csv"
            path.write_text("\n".join(change(path.read_text().splitlines())) + "\n")

        return apply

    def frame(folder: Path) -> None:
        path = sorted((folder / "snapshots").glob("frame-*.npz"))[3]
        with np.load(path) as file:
            data = {key: file[key].copy() for key in file}
        data["potential"].reshape(-1)[2] += 1e-4
        np.savez(path, **data)

    assert changed("same", lambda folder: None) == (0.0, [])
    assert changed("metric", metric)[0] > 1e-12
    assert changed("row", rows(lambda lines: [*lines[:-1], lines[-1][:-1] + "7"]))[0] > 0
    assert changed("missing", rows(lambda lines: [*lines[:5], *lines[6:]]))[1]
    assert changed("double", rows(lambda lines: [*lines[:5], *lines[4:]]))[1]
    assert changed("frame", frame)[0] > 1e-5
    assert changed("no-frame", lambda folder: next((folder / "snapshots").glob("frame-*")).unlink())[1]
