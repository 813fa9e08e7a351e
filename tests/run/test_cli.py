"""The command line: what it prints, its exit statuses, and that nothing is lost on the way."""

import json
import os
import signal
import subprocess
import time
import tomllib

import myostrain as ms
from myostrain import Case, ComputationError, cases
from myostrain.case import building
from myostrain.output.snapshots import Snapshots
from myostrain.run import progress
from myostrain.run.retries import REMEDIES

import numpy as np
import pytest

from small_cases import COMMAND, LINE, changed, command_line, other_process, write_case

STEPS = {"time.end": 0.02, "output.fields": ["potential"]}


@pytest.fixture
def line(tmp_path, monkeypatch):
    """A case file; commands are called in its folder."""
    monkeypatch.chdir(tmp_path)
    return write_case(tmp_path / "line.toml", changed(LINE, STEPS))


def test_list_has_a_line_for_every_case(tmp_path):
    """Interface, list: "the named cases, a line each: what it shows, size, time it takes"."""
    done = other_process("list", cwd=tmp_path)
    assert (done.status, done.err) == (0, "")
    lines = done.out.splitlines()
    assert [text.split()[0] for text in lines] == cases.names()
    for text, name in zip(lines, cases.names(), strict=True):
        case = Case.from_file(cases.path(name))
        assert case.title in text
        assert case.cost in text
        assert {"cells", "triangles", "tetrahedra"} & set(case.cost.replace(",", "").split())
        assert case.cost.endswith(" s")


@pytest.mark.parametrize("name", cases.names())
def test_show_prints_the_file(name):
    """Interface, show: "a case's file, commented: copy it, edit it, run it"."""
    done = command_line("show", name)
    assert (done.status, done.err) == (0, "")
    assert done.out == cases.path(name).read_text(encoding="utf-8")
    assert "#" in done.out


def test_shown_case_runs_as_a_file(tmp_path, monkeypatch):
    """Interface: the copy of a case's file is the case."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(command_line("show", "startup-1d").out, encoding="utf-8")
    metrics = []
    for case in ("mine.toml", "startup-1d"):
        done = command_line("run", case, "--set", "time.end=0.02", "--out", f"out of {case}", "--quiet")
        assert done.status == 0, done.err
        results = json.loads((tmp_path / f"out of {case}" / "results.json").read_text())
        metrics.append(results["metrics"])
    assert metrics[0] == metrics[1]
    assert results["case"] == "startup-1d"


def test_run_prints_the_metrics(line):
    """Requirements: "the numbers beside the picture", with units; where they are is said too."""
    done = command_line("run", line, "--set", 'units={length="mm", time="ms"}', "--out", "out")
    assert (done.status, done.err) == (0, "")
    units = ms.open(line.parent / "out").metrics.units
    assert units["celerity"] == "mm/ms"
    results = json.loads((line.parent / "out" / "results.json").read_text())
    for name, value in results["metrics"].items():
        shown = [text.split() for text in done.out.splitlines() if text.split()[:1] == [name]]
        unit = [] if units.get(name, "1") == "1" else units[name].split()
        assert shown == ([] if value is None else [[name, f"{value:.5g}", *unit]])
    assert "20 steps to t = 0.02 on 20 cells" in done.out
    assert "out/results.json" in done.out
    assert "out/figures" in done.out


def test_run_without_out_takes_a_new_folder(line):
    """Interface: nothing is overwritten: runs/NAME, then runs/NAME-2."""
    for folder in ("runs/line", "runs/line-2"):
        done = command_line("run", line, "--quiet")
        assert done.status == 0, done.err
        assert folder + "/results.json" in done.out
        assert (line.parent / folder / "results.json").exists()


def test_set_reaches_the_run_and_the_record(line):
    """Interface, --set and DIR/case.toml: "the case as it ran, everything resolved"."""
    arguments = ("--set", "cell.alpha=0.13", "--set", "mechanics.imposed_stretch={value=1.0, until=0.01}")
    done = command_line("run", line, "--set", "initial.potential=0.6", *arguments, "--out", "out")
    assert done.status == 0, done.err
    resolved = tomllib.loads((line.parent / "out" / "case.toml").read_text(encoding="utf-8"))
    assert resolved["cell"]["alpha"] == 0.13
    assert resolved["mechanics"]["imposed_stretch"] == {"value": 1.0, "until": 0.01}
    assert json.loads((line.parent / "out" / "results.json").read_text())["parameters"] == resolved


def test_no_fields_are_no_failure(line):
    """Interface, exit status 0 is "done": a run that wrote no fields has nothing to draw, and is done."""
    done = command_line("run", line, "--set", "output.fields=[]", "--out", "out")
    assert (done.status, done.err) == (0, "")


def test_plot_draws_again(line):
    """Interface, plot DIR: "pictures from a result folder", the same as the run's."""
    assert command_line("run", line, "--out", "out").status == 0
    figures = line.parent / "out" / "figures"
    drawn = sorted(path.name for path in figures.iterdir())
    assert drawn
    for name in drawn:
        (figures / name).unlink()
    done = command_line("plot", "out")
    assert (done.status, done.err) == (0, "")
    assert sorted(path.name for path in figures.iterdir()) == drawn
    assert sorted(os.path.basename(text) for text in done.out.split()) == drawn  # noqa: PTH119


@pytest.mark.parametrize(
    "arguments, words",
    [
        ([], "Usage"),
        (["lst"], "list"),
        (["run"], "CASE"),
        (["run", "pulse-1d", "--fast"], "--fast"),
        (["run", "pulse-1d", "--set"], "--set"),
        (["run", "pulse-1d", "sheet-2d"], "sheet-2d"),
        (["list", "all"], "all"),
        (["run", "puls-1d"], "'pulse-1d'"),
        (["show", "sheet"], "'sheet-2d'"),
        (["show", "nothing-like-it"], "pulse-1d-rigid"),
        (["run", "none.toml"], "none.toml"),
        (["run", "below/none.toml"], "none.toml"),
        (["run", "."], "no case is called '.'"),
        (["run", "empty.toml"], "empty"),
        (["run", "blank.toml"], "no section"),
        (["run", "binary.toml"], "TOML"),
        (["run", "broken.toml"], "line 2"),
        (["run", "title.toml"], "geometry"),
        (["plot", "none"], "none"),
        (["plot", "."], "snapshots"),
        (["plot", "line.toml"], "line.toml"),
        (["run", "line.toml", "--out", "line.toml"], "is a file"),
        (["run", "line.toml", "--out", "line.toml/out"], "cannot be written"),
        (["run", "line.toml", "--out", "."], "--force"),
        (["run", "line.toml", "--out", ".", "--force"], "what no run has written"),
    ],
    ids=" ".join,
)
def test_wrong_use(line, arguments, words):
    """Interface, exit status 2: "the user's input is wrong", one message, nothing written."""
    for name, content in (
        ("empty.toml", b""),
        ("blank.toml", b"# nothing\n"),
        ("binary.toml", b"\xff\xfe\x00\x01"),
        ("broken.toml", b"[cell]\nalpha = \n"),
        ("title.toml", b'title = "a title"\n'),
    ):
        (line.parent / name).write_bytes(content)
    before = sorted(line.parent.iterdir())
    done = command_line(*arguments)
    assert done.status == 2
    assert words in done.err + done.out
    assert "Traceback" not in done.err
    assert sorted(line.parent.iterdir()) == before


def test_version():
    """Interface: `myostrain --version`."""
    done = command_line("--version")
    assert (done.status, done.err) == (0, "")
    assert done.out == f"myostrain {ms.__version__}\n"


def test_help_is_no_error():
    """Every command and option of the interface is in the help."""
    done = command_line("--help")
    assert (done.status, done.err) == (0, "")
    assert {"list", "show", "run", "plot"} <= set(done.out.split())
    assert done.out.index("  show ") < done.out.index("  run ") < done.out.index("  sweep ")
    assert "..." not in done.out.partition("Commands:")[2]  # each line is whole
    done = command_line("run", "--help")
    assert done.status == 0
    assert {"--set", "--out", "--quiet", "--force"} <= set(done.out.replace("]", " ").split())


@pytest.mark.parametrize(
    "case, changes",
    [
        # A line that springs back where 4 β v x′ > 1 has no equilibrium that conserves J v.
        (LINE, {"mechanics.imposed_stretch": {"value": 0.95, "until": 0.004}}),
        (LINE, {"mechanics.imposed_stretch": {"value": 0.95, "until": 0.004}, "output.fields": []}),
    ],
    ids=["fields", "no-fields"],
)
def test_failed_computation(tmp_path, case, changes):
    """Interface, exit status 3: physical time and reason; the case stays, results.json does not."""
    out = tmp_path / "out"
    done = command_line("run", write_case(tmp_path / "case.toml", changed(case, changes)), "--out", out)
    assert done.status == 3
    *retries, last = done.err.strip().splitlines()
    assert last.startswith("myostrain: the computation failed at t = 0.004: no equilibrium conserves")
    assert len(retries) == len(REMEDIES)
    assert done.out == ""
    assert not (out / "results.json").exists()
    failure = json.loads((out / "failure.json").read_text())
    assert failure["time"] == 0.004
    assert failure["reason"] in done.err
    assert failure["advice"] in done.err
    assert Case.from_file(out / "case.toml") == Case.from_dict(changed(case, changes), name="case")


@pytest.mark.parametrize(
    "case, changes",
    [
        (
            LINE,
            {"solver.potential": {"pc_type": "none", "ksp_max_it": 1}, "time.end": 3e-3, "output.fields": []},
        ),
        (
            LINE,
            {
                "solver.mechanics": {"ksp_type": "cg", "pc_type": "none", "ksp_max_it": 1},
                "time.end": 3e-3,
                "output.fields": [],
            },
        ),
    ],
    ids=["potential", "mechanics"],
)
def test_a_poor_solver_is_replaced(tmp_path, case, changes):
    """ "fallback solver": what a user's options cannot solve direct solvers do, and everybody is told."""
    file = write_case(tmp_path / "case.toml", changed(case, changes))
    done = command_line("run", file, "--out", tmp_path / "out")
    assert done.status == 0, done.err
    results = json.loads((tmp_path / "out" / "results.json").read_text())
    assert results["retries"][-1]["helped"]
    assert "direct" in results["retries"][-1]["remedy"]
    assert "trying" in done.err
    other = command_line(
        "run",
        write_case(tmp_path / "usual.toml", changed(case, {"time.end": 3e-3, "output.fields": []})),
        "--out",
        tmp_path / "usual",
    )
    usual = json.loads((tmp_path / "usual" / "results.json").read_text())["metrics"]["potential_max"]
    # Steps of a sixteenth of the size have less error in time; measured 2e-3.
    assert results["metrics"]["potential_max"] == pytest.approx(usual, rel=1e-2), other.err


def test_plot_after_a_failure(line, monkeypatch):
    """Requirements: what was computed before a failure "stays readable": by `myostrain plot` too."""
    from myostrain import Electromechanics

    step = Electromechanics.step

    def fails_later(model, end, **others):
        if end > 0.0105:
            raise ComputationError("planted", advice="nothing.")
        step(model, end, **others)

    monkeypatch.setattr(Electromechanics, "step", fails_later)
    done = command_line("run", line, "--out", "out")
    assert done.status == 3
    *retries, last = done.err.strip().splitlines()
    assert last == "myostrain: the computation failed at t = 0.01: planted. Try: nothing."
    assert len(retries) == len(REMEDIES)
    assert all(line.startswith("myostrain: step from t = 0.01 failed (planted); trying") for line in retries)
    drawn = command_line("plot", "out")
    assert drawn.status == 0, drawn.err
    assert len(drawn.out.split()) > 1


def test_unexpected_error_is_not_hidden(line, monkeypatch):
    """An error that is neither the user's nor the computation's ends with status 1 and its traceback."""

    def breaks(*_, **__):
        raise RuntimeError("a defect")

    monkeypatch.setattr(building, "model", breaks)
    done = command_line("run", line, "--out", "out")
    assert done.status == 1
    assert "RuntimeError: a defect" in done.err


def test_progress_without_a_terminal_is_a_line_every_few_seconds(line, monkeypatch):
    """Interface: under --quiet or without a terminal "a line every few seconds": time, step, time left."""
    monkeypatch.setattr(progress, "QUIET_INTERVAL", 0.0)
    done = command_line("run", line, "--quiet", "--out", "out")
    assert done.status == 0
    lines = done.err.splitlines()
    assert len(lines) == 20
    assert lines[9].startswith("line: t = 0.01 of 0.02, step 10 of 20, ")
    assert lines[9].endswith(" s left")


def interrupt(folder, arguments, seconds=60.0):
    """Start a run in a process of its own, send SIGINT once it has written probes, and wait for its end."""
    # Where SIGINT is ignored, as in a shell's background, a new Python ignores it too.
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    process = subprocess.Popen(
        [*COMMAND[:-1], heard + COMMAND[-1], *map(str, arguments)],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        until, probes = time.monotonic() + seconds, folder / "out" / "probes.csv"
        while not (probes.exists() and probes.read_text().count("\n") > 1):
            assert process.poll() is None, process.communicate()
            assert time.monotonic() < until, "the run did not begin"
            time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=seconds)
    finally:
        process.kill()
    return process.returncode, out, err


def test_interrupted_run(line):
    """Interface: exit status 130; what was written is readable, results.json is not there."""
    long = changed(LINE, {"time.end": 200.0, "output.every": 0.1})
    write_case(line, long)
    status, out, err = interrupt(line.parent, ["run", line, "--out", "out", "--quiet"])
    assert status == 130
    assert out == ""
    assert "interrupted" in err
    assert "Traceback" not in err
    folder = line.parent / "out"
    assert not (folder / "results.json").exists()
    snapshots = Snapshots(folder)
    assert len(snapshots.times) >= 1
    assert {"potential", "displacement"} <= snapshots.names
    assert np.isfinite(snapshots.field("potential")).all()
    assert (folder / "fields.bp").is_dir()
    rows = (folder / "probes.csv").read_text().splitlines()
    assert {row.count(",") for row in rows} == {rows[0].count(",")}
    assert Case.from_file(folder / "case.toml").time.end == 200.0
    assert command_line("plot", folder).status == 0
