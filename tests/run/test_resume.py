"""Checkpoints, resuming, and steps that are tried again (issue "Runs that survive")."""

import errno
import json
import os
import signal
from pathlib import Path

from myostrain import Case
from myostrain.case.running import run_case
from myostrain.errors import ComputationError, InputError, Interrupted
from myostrain.output.snapshots import Snapshots
from myostrain.run.checkpoint import Checkpoints
from myostrain.solvers.linear import LinearSolver
from myostrain.solvers.newton import ChordNewton

import numpy as np
import pytest

from mesh_files import write_mesh
from small_cases import ALONE, LINE, REMOVED, SHEET, SOLID, STATIC, changed, command_line, write_case

#: Whatever has a history of its own: schemes, viscosity, pressures, held bodies, the other mass matrix.
CASES = {
    "line": (LINE, {}),
    "long-enough-to-activate": (LINE, {"time.end": 0.1}),
    "rigid-twin": (LINE, {"output.rigid_twin": True}),
    "viscous": (LINE, {"mechanics.relaxation_time": 0.08}),
    "held": (LINE, {"mechanics.imposed_stretch": {"value": 0.7, "until": 0.004}}),
    "held-until-later": (LINE, {"mechanics.imposed_stretch": {"value": 0.7, "until": 0.008}}),
    "staggered": (LINE, {"time.scheme": "staggered", "mechanics.every": 3}),
    "implicit": (LINE, {"time.scheme": "implicit"}),
    "iterated": (LINE, {"activation.beta": 0.45}),
    "sheet": (SHEET, {"mechanics.every": 4, "potential.mass": "averaged"}),
    "elastic": (SHEET, {"mechanics.constraint": "elastic", "potential.mass": "averaged"}),
    "waves": (
        SHEET,
        {
            "time.end": 0.2,
            "time.step": 4e-3,
            "potential.reaction": "interpolated",
            "electrodes": {"V1": [10.0, 12.0, 6.0]},
            "output.tip": {"potential": 0.3, "every": 0.02},
            "output.repolarization": [30, 60],
        },
    ),
    "plane-strain": (SHEET, {"mechanics.kinematics": "plane-strain"}),
    "viscous-sheet": (SHEET, {"mechanics.relaxation_time": 0.08, "mechanics.every": 4}),
    "viscous-plane-strain": (
        SHEET,
        {"mechanics.relaxation_time": 0.08, "mechanics.kinematics": "plane-strain"},
    ),
    "inertia": (LINE, {"mechanics.density": 2.0, "mechanics.damping": {"right": 1.0}}),
    "damped": (LINE, {"mechanics.damping": {"right": 1.0}}),
    "inertia-plane-strain": (
        SHEET,
        {
            "mechanics": {
                "kinematics": "plane-strain",
                "density": 1.0,
                "viscosity": 0.1,
                "damping_normal": {"boundary": 0.5},
                "every": 2,
            }
        },
    ),
    "nested": (SHEET, {"potential.refinement": 1, "mechanics.every": 4, "potential.mass": "averaged"}),
    "nested-elastic": (
        SHEET,
        {"potential.refinement": 1, "mechanics.constraint": "elastic", "time.scheme": "implicit"},
    ),
    "stretched": (SHEET, {"cell.stretch_current": {"conductance": 50.0}, "mechanics.every": 4}),
    "calcium": (
        LINE,
        {
            "cell": {"model": "BuenoOrovio2008"},
            "initial.potential": 20.0,
            "potential": {"diffusivity": 1.0, "reaction": "interpolated"},
            "activation": {"law": "rossi-2014", "mu": 500.0},
            "time.step": 2.0,
            "time.end": 40.0,
            "output": {"every": 6.0, "fields": ["activation", "stretch"]},
            "mechanics.every": 3,
        },
    ),
    "front": (
        SOLID,
        {
            "cell": {"model": "TenTusscherPanfilov2006"},
            "potential": {"diffusivity": 0.1, "mass": "averaged", "reaction": "interpolated"},
            "initial.potential": 20.0,
            "mechanics": {"kinematics": "rigid"},
            "activation": REMOVED,
            "material": REMOVED,
            "time.step": 0.1,
            "time.end": 3.0,
            "output.every": 1.0,
        },
    ),
    "solid": (SOLID, {}),
    "varied": (LINE, {"cell.variation": [{"box": [[5.5], [30.0]], "alpha": 0.2, "tau": 0.3}]}),
    "static": (STATIC, {}),
    "direct": (SHEET, {"solver.potential": {"ksp_type": "preonly", "pc_type": "lu"}}),
}

TABLES = ("probes.csv", "measures.csv", "tip.csv", "ecg.csv")


class Stop:
    """Sends a signal to this process after some steps."""

    def __init__(self, after, number=signal.SIGTERM):
        self.after, self.number = after, number

    def __call__(self, name, steps, end):
        return self

    def update(self, step, time):
        if step == self.after:
            os.kill(os.getpid(), self.number)


def numbers(folder):
    """What is to be equal: results but for times, the table, and every frame."""
    results = json.loads((folder / "results.json").read_text())
    results = {key: results[key] for key in ("metrics", "probes", "steps", "time", "solver", "unknowns")}
    frames = Snapshots(folder)
    arrays = {
        (name, i): frames.field(name, i).tolist() for name in frames.names for i in range(len(frames.times))
    }
    maps = {name: np.nan_to_num(values, nan=-1.0).tolist() for name, values in frames.maps().items()}
    tables = [(folder / name).read_text() for name in TABLES if (folder / name).exists()]
    return results, tables, frames.times.tolist(), arrays, maps


@pytest.mark.parametrize("name", CASES)
def test_resumed_run_is_the_uninterrupted_one(tmp_path, name):
    """ "ends with the same results.json, probes and fields": here bit by bit, counts of solvers included."""
    case = Case.from_dict(changed(*CASES[name]))
    steps = run_case(case, tmp_path / "whole", comm=ALONE, figures=False)["steps"]
    for again in (0, 1):  # the second stop is in the resumed run
        stop = Stop(after=(3 + 4 * again) * steps // 10)
        with pytest.raises(Interrupted) as stopped:
            run_case(case, tmp_path / "cut", comm=ALONE, figures=False, resume=bool(again), progress=stop)
        assert stopped.value.number == signal.SIGTERM
        assert not (tmp_path / "cut" / "results.json").exists()
    run_case(case, tmp_path / "cut", comm=ALONE, figures=False, resume=True)
    assert numbers(tmp_path / "cut") == numbers(tmp_path / "whole")


def test_the_same_command_again_and_again(tmp_path, monkeypatch):
    """A batch script gives one command: it begins, goes on, and shows what there is."""
    monkeypatch.chdir(tmp_path)
    file = write_case(tmp_path / "mine.toml", changed(LINE, {"output.fields": []}))
    command = ("run", file, "--set", "activation.beta=0.2", "--out", "out", "--resume")
    for _ in range(2):
        done = command_line(*command)
        assert done.status == 0, done.err
        assert "numbers in" in done.out
    assert "had ended already" in done.out
    assert command_line("run", "--resume", "--out", "out").status == 0
    other = command_line("run", file, "--out", "out", "--resume")  # without --set
    assert (other.status, "other values" in other.err) == (2, True)
    for wrong in (("--resume",), ("--resume", "--out", "nothing"), ("--resume", "--out", "out", "--force")):
        assert command_line("run", *wrong).status == 2


def interrupted(tmp_path, after=7, **changes):
    """A sheet's run, interrupted, with a checkpoint every two steps."""
    case = Case.from_dict(changed(SHEET, {"output.checkpoint_every": 2e-3, **changes}))
    with pytest.raises(Interrupted):
        run_case(case, tmp_path, comm=ALONE, figures=False, progress=Stop(after))
    return case, sorted((tmp_path / "checkpoint").iterdir())


def test_two_checkpoints_are_kept(tmp_path):
    """ "keeps the last two": of those at steps 2, 4, 6 and 7; no unfinished file is left."""
    _, files = interrupted(tmp_path)
    assert [path.name for path in files] == ["step-000000006.ckpt", "step-000000007.ckpt"]


@pytest.mark.parametrize("offset", [0, 21, 30, 100, 5000, -1])
def test_a_changed_byte_is_found(tmp_path, caplog, offset):
    """ "A damaged newest checkpoint is detected and the one before it used, with a warning"."""
    case, (_, newest) = interrupted(tmp_path)
    content = bytearray(newest.read_bytes())
    content[offset] ^= 0x40
    newest.write_bytes(content)
    with caplog.at_level("WARNING", logger="myostrain"):
        run_case(case, tmp_path, comm=ALONE, figures=False, resume=True)
    assert newest.name in caplog.text
    run_case(case, tmp_path.with_name("whole"), comm=ALONE, figures=False, force=True)
    assert numbers(tmp_path) == numbers(tmp_path.with_name("whole"))


def test_nothing_is_resumed_from_two_damaged_checkpoints(tmp_path):
    """Both damaged: refused, with a way out, and nothing is changed."""
    case, files = interrupted(tmp_path)
    for path in files:
        path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(InputError, match=r"no checkpoint can be used.*case\.toml"):
        run_case(case, tmp_path, comm=ALONE, resume=True)
    assert (tmp_path / "probes.csv").exists()


def test_another_case_is_not_resumed(tmp_path):
    """A case.toml that was edited does not go on from the checkpoint of the one before."""
    interrupted(tmp_path)
    other = Case.from_dict(changed(SHEET, {"output.checkpoint_every": 2e-3, "activation.beta": 0.2}))
    with pytest.raises(InputError, match="changed since"):
        run_case(other, tmp_path, comm=ALONE, resume=True)


@pytest.mark.parametrize("key", ["geometry", "fibres"])
def test_another_file_is_not_resumed(tmp_path, key):
    """file_digests: a mesh whose groups have other names, or other fibres, belong to another run."""
    mesh, fibres = tmp_path / "body.msh", tmp_path / "fibres.npz"
    write_mesh(mesh, step=3.0)
    cells = Case.from_dict(changed(SHEET, {"geometry": {"kind": "file", "path": str(mesh)}})).geometry
    found = cells.mesh(ALONE).mesh.geometry
    centres = found.x[found.dofmaps[0]].mean(axis=1)[:, :2]
    np.savez(fibres, points=centres, f0=centres * 0 + [1.0, 0.0])
    changes = {
        "geometry": {"kind": "file", "path": str(mesh)},
        "fibres": {"kind": "file", "path": str(fibres)},
        "initial.center": [0.0, 3.0],
        "probes": {"a": [10.0, 3.0]},
    }
    case, _ = interrupted(tmp_path / "out", **changes)
    before = {path: path.read_bytes() for path in (mesh, fibres)}
    if key == "geometry":
        mesh.write_bytes(before[mesh].replace(b'"left"', b'"lift"'))
    else:
        np.savez(fibres, points=centres, f0=centres * 0 + [0.0, 1.0])
    with pytest.raises(InputError, match=rf"^{key}\.path: the file was changed since the checkpoint"):
        run_case(case, tmp_path / "out", comm=ALONE, resume=True, figures=False)
    for path, content in before.items():
        path.write_bytes(content)
    assert run_case(case, tmp_path / "out", comm=ALONE, resume=True, figures=False)["completed"]


def test_another_format_is_refused(tmp_path, monkeypatch):
    """ "carries a format version": one that this program does not know is no damage, and is not skipped."""
    monkeypatch.setattr("myostrain.run.checkpoint.FORMAT", "myostrain checkpoint 999")
    case, _ = interrupted(tmp_path)
    monkeypatch.undo()
    with pytest.raises(InputError, match="checkpoint 999"):
        run_case(case, tmp_path, comm=ALONE, resume=True)


def test_a_folder_in_use_is_refused(tmp_path):
    """ "a folder in use by another run (lock with owner and time)", whatever is asked."""
    case = Case.from_dict(SHEET)
    simulation = case.simulation(ALONE, tmp_path / "out")
    for how in ({}, {"force": True}, {"resume": True}):
        with pytest.raises(InputError, match=rf"in use by process {os.getpid()} on .* since 20"):
            case.simulation(ALONE, tmp_path / "out", **how)
    simulation.run()
    assert (tmp_path / "out" / "results.json").exists()
    assert not (tmp_path / "out" / ".lock").exists()


def test_a_retry_begins_where_the_failed_step_began(tmp_path, monkeypatch):
    """ "retried from the last good step": mechanics fails when the potential has made its step already."""
    case = Case.from_dict(SHEET)
    whole = run_case(case, tmp_path / "whole", comm=ALONE, figures=False)
    solve, calls = ChordNewton.solve, [0]

    def sometimes(self):
        calls[0] += 1
        if 6 <= calls[0] < 6 + 8:  # each jump of mechanics by itself too: all, 1/4, 1/8, ..., 1/256
            raise ComputationError("planted")
        return solve(self)

    monkeypatch.setattr(ChordNewton, "solve", sometimes)
    again = run_case(case, tmp_path / "again", comm=ALONE, figures=False)
    assert [retry["helped"] for retry in again["retries"]] == [True]
    # Measured 1.2e-4, the error in time of one step; a step too many is 2 %.
    assert again["metrics"]["amount"] == pytest.approx(whole["metrics"]["amount"], rel=1e-3)


def failing(monkeypatch, times):
    """Make the potential's solver fail, so many times."""
    left = [times]
    solve = LinearSolver.solve

    def sometimes(self, b, x):
        if left[0] and self._name == "potential":
            left[0] -= 1
            raise ComputationError("the linear solver of the potential did not converge (planted)")
        solve(self, b, x)

    monkeypatch.setattr(LinearSolver, "solve", sometimes)


@pytest.mark.parametrize("failures", [1, 2, 3, 4])
def test_a_failed_step_is_tried_again(tmp_path, monkeypatch, failures):
    """ "retried from the last good step with a smaller step, fresh factorization, fallback solver"."""
    case = Case.from_dict(changed(SHEET, {"mechanics.every": 2}))
    whole = run_case(case, tmp_path / "whole", comm=ALONE, figures=False)
    failing(monkeypatch, failures)
    again = run_case(case, tmp_path / "again", comm=ALONE, figures=False)
    remedies = [(retry["remedy"], retry["helped"]) for retry in again["retries"]]
    assert len(remedies) == failures
    assert [helped for _, helped in remedies] == [False] * (failures - 1) + [True]
    assert "half" in remedies[0][0]
    assert failures < 3 or "fresh" in remedies[2][0]
    assert failures < 4 or "direct" in remedies[3][0]
    assert whole["retries"] == []
    assert (again["steps"], again["time"]) == (whole["steps"], whole["time"])
    # One step of ten in smaller ones: the error in time of that one differs; measured 7e-4 at most.
    assert again["metrics"]["potential_max"] == pytest.approx(whole["metrics"]["potential_max"], rel=5e-3)
    assert "planted" in (tmp_path / "again" / "run.log").read_text()


def test_a_step_that_nothing_saves_ends_the_run(tmp_path, monkeypatch):
    """ "Then a checkpoint and exit status 3": the checkpoint is that of the last good step, and goes on."""
    case = Case.from_dict(SHEET)
    run_case(case, tmp_path / "whole", comm=ALONE, figures=False)

    class Break:
        def __call__(self, *arguments):
            return self

        def update(self, step, time):
            if step == 5:
                failing(monkeypatch, 10**6)

    with pytest.raises(ComputationError, match=r"at t = 0\.005: .*planted"):
        run_case(case, tmp_path / "out", comm=ALONE, figures=False, progress=Break())
    assert [path.name for path in (tmp_path / "out" / "checkpoint").iterdir()] == ["step-000000005.ckpt"]
    monkeypatch.undo()
    run_case(case, tmp_path / "out", comm=ALONE, figures=False, resume=True)
    left, right = numbers(tmp_path / "out"), numbers(tmp_path / "whole")
    assert left[1:3] == right[1:3]
    assert not (tmp_path / "out" / "failure.json").exists()


def test_nan_is_found_where_it_is(tmp_path):
    """ "NaN or Inf anywhere stop the step at once", with the place, and are in no checkpoint."""
    case = Case.from_dict(SHEET)
    simulation = case.simulation(ALONE, tmp_path / "out")
    potential = simulation.model.potential

    class Plant:
        def update(self, step, time):
            if step == 4:
                potential.v.x.array[7] = np.nan
                potential.past.values[0][0][7] = np.nan

    with pytest.raises(ComputationError) as caught:
        simulation.run(Plant())
    assert caught.value.where is not None
    point = potential.v.function_space.tabulate_dof_coordinates()[7, :2]
    low, high = potential.body.extent()
    assert np.all((low <= caught.value.where) & (caught.value.where <= high)), point
    assert Checkpoints(tmp_path / "out", [potential.v.function_space]).files() == []


def test_a_full_disk_ends_the_run_and_loses_nothing(tmp_path, monkeypatch):
    """ "A full disk ...: clear message, nothing overwritten, what was there stays readable"."""
    case = Case.from_dict(changed(SHEET, {"output.checkpoint_every": 2e-3}))
    run_case(case, tmp_path / "whole", comm=ALONE, figures=False)
    fsync = os.fsync
    calls = [0]

    def full(handle):
        calls[0] += 1
        if calls[0] > 12:
            raise OSError(errno.ENOSPC, "No space left on device")
        fsync(handle)

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(ComputationError, match=r"No space left on device.*--resume"):
        run_case(case, tmp_path / "out", comm=ALONE, figures=False)
    monkeypatch.undo()
    assert list(Path(tmp_path / "out").rglob(".*.part")) == []
    run_case(case, tmp_path / "out", comm=ALONE, figures=False, resume=True)
    assert numbers(tmp_path / "out") == numbers(tmp_path / "whole")
