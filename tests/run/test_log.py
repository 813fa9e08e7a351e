"""`run.log`: what a user attaches to a bug report, and that it never gets in the way of a run."""

import logging
import re
import shutil
import tomllib
import warnings
from datetime import UTC, datetime, timedelta

from myostrain import Case, ComputationError, InputError
from myostrain.engine import jit_options, versions
from myostrain.output.log import RunLog, log_end, log_start, logger

import pytest

from small_cases import ALONE, LINE, changed


class Other:
    """A process that is not the first."""

    rank, size = 1, 2


def lines(folder):
    return (folder / "run.log").read_text(encoding="utf-8").splitlines()


def texts(folder):
    """The lines without their times."""
    return [line.partition("Z ")[2] for line in lines(folder)]


@pytest.fixture(autouse=True)
def _everything_is_put_back():
    before = logger.handlers[:], logger.level, warnings.showwarning
    yield
    assert (logger.handlers, logger.level, warnings.showwarning) == before


def test_a_line_is_time_in_utc_level_and_text(tmp_path, monkeypatch):
    """The issue: UTC times, level, text; a line is in the file as soon as it is logged."""
    monkeypatch.setenv("TZ", "Asia/Tokyo")
    with RunLog(tmp_path, ALONE):
        logger.info("step %d", 7)
        logger.debug("too much")
        (line,) = lines(tmp_path)
        logger.warning("again with half the step")
    assert texts(tmp_path) == ["INFO step 7", "WARNING again with half the step"]
    stamp = re.fullmatch(r"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z) INFO step 7", line)
    assert abs(datetime.fromisoformat(stamp[1]) - datetime.now(UTC)) < timedelta(minutes=1)


def test_without_an_open_log_nothing_is_printed(capfd):
    logger.error("nobody listens")
    assert capfd.readouterr() == ("", "")


def test_a_resumed_run_goes_on_a_new_one_begins_again(tmp_path):
    for append, expected in ((False, ["a"]), (True, ["a", "b"]), (False, ["c"])):
        with RunLog(tmp_path, ALONE, append):
            logger.info(expected[-1])
        assert texts(tmp_path) == [f"INFO {text}" for text in expected]


def test_only_the_first_process_writes(tmp_path):
    with RunLog(tmp_path, Other()):
        logger.info("elsewhere")
    assert list(tmp_path.iterdir()) == []


def test_a_run_within_a_run_has_its_own_log(tmp_path):
    """The rigid twin runs inside the run: each file has its own run's lines, an exception has passed both."""
    inner = tmp_path / "rigid"
    inner.mkdir()

    def both():
        with RunLog(tmp_path, ALONE):
            logger.info("before")
            with RunLog(inner, ALONE):
                logger.info("twin")
            logger.info("between")
            with RunLog(inner, ALONE, append=True):
                warnings.warn("odd", RuntimeWarning, stacklevel=1)
                raise ComputationError("no convergence", time=0.3, advice="less.")

    with pytest.warns(RuntimeWarning, match="odd"), pytest.raises(ComputationError):
        both()
    failure = "ERROR ComputationError: at t = 0.3: no convergence. Try: less."
    assert texts(tmp_path) == ["INFO before", "INFO between", failure]
    twin = texts(inner)
    assert twin[0] == "INFO twin"
    assert re.fullmatch(r"WARNING RuntimeWarning: odd \(test_log\.py:\d+\)", twin[1])
    assert twin[2:] == [failure]


def test_a_log_within_one_that_could_not_be_opened(tmp_path):
    logs = RunLog(tmp_path / "gone", ALONE), RunLog(tmp_path, ALONE)
    with pytest.warns(UserWarning, match="once"), logs[0], logs[1]:
        warnings.warn("once", stacklevel=1)
    assert len(lines(tmp_path)) == 1


def test_python_warnings_are_logged_and_still_shown(tmp_path):
    """Whoever runs a script sees its warnings as ever; `pytest.warns` is one who does."""
    with pytest.warns(UserWarning, match="two") as caught, RunLog(tmp_path, ALONE):
        warnings.warn("two\nlines", stacklevel=1)
    assert len(caught) == 1
    assert "two" in lines(tmp_path)[0]


def passes(error, folder):
    """Let an exception pass through a log; returns the log's text."""
    with pytest.raises(type(error)), RunLog(folder, ALONE):
        raise error
    return "\n".join(texts(folder)[:1] + lines(folder)[1:])


@pytest.mark.parametrize(
    "error, expected",
    [
        (InputError("no such key", "cell.alpah"), "ERROR InputError: cell.alpah: no such key"),
        (ComputationError("diverged\nfar", time=1.0), "ERROR ComputationError: at t = 1: diverged far"),
        (KeyboardInterrupt(), "ERROR KeyboardInterrupt"),
        (SystemExit(143), "ERROR SystemExit: 143"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_an_expected_failure_is_one_line(tmp_path, error, expected):
    assert passes(error, tmp_path) == expected


def test_an_unexpected_failure_comes_with_its_traceback(tmp_path):
    text = passes(ZeroDivisionError("100 % wrong"), tmp_path)
    assert text.startswith("ERROR ZeroDivisionError: 100 % wrong\nTraceback")
    assert "in passes" in text


def test_a_full_disk_is_not_the_runs_concern(tmp_path, capfd):
    """/dev/full takes nothing: no exception, no complaint on the screen."""
    (tmp_path / "run.log").symlink_to("/dev/full")
    with RunLog(tmp_path, ALONE):
        logger.info("lost")
        logger.info("x" * 100_000)
    assert capfd.readouterr() == ("", "")


def test_a_vanished_folder_is_not_the_runs_concern(tmp_path, capfd):
    folder = tmp_path / "run"
    folder.mkdir()
    with RunLog(folder, ALONE):
        shutil.rmtree(folder)
        logger.info("lost")
    with RunLog(folder, ALONE):
        logger.info("lost too")
    assert not folder.exists()
    assert capfd.readouterr() == ("", "")


def test_other_loggers_and_handlers_are_left_alone(tmp_path):
    """A script that listens to the logger goes on hearing it."""
    heard = []
    handler = logging.Handler()
    handler.emit = lambda record: heard.append(record.getMessage())
    logger.addHandler(handler)
    try:
        with RunLog(tmp_path, ALONE):
            logger.info("both")
            logging.getLogger("other").error("not ours")
    finally:
        logger.removeHandler(handler)
    assert heard == ["both"]
    assert texts(tmp_path) == ["INFO both"]


@pytest.fixture(scope="module")
def small_run():
    options = {"ksp_rtol": 1e-11}
    case = Case.from_dict(changed(LINE, {"solver.potential": options, "mechanics.imposed_stretch": {}}))
    simulation = case.simulation(ALONE)
    return case, simulation.model, simulation.run()


def test_what_a_bug_report_needs(tmp_path, small_run):
    """The issue: versions, options, timings. The case in the log is the case that ran, whole."""
    case, model, results = small_run
    with RunLog(tmp_path, ALONE):
        log_start(case.parameters, model, 3)
        log_end(results)
    text = (tmp_path / "run.log").read_text(encoding="utf-8")
    for version in versions().values():
        assert version in text
    for flag in jit_options()["cffi_extra_compile_args"]:
        assert flag in text
    for words in ("processes 3", "cores ", "threads ", "cells: 20, unknowns: potential 21, states 21"):
        assert words in text
    assert re.search(r"INFO solver\.potential: .*ksp_rtol 1e-11", text)
    assert re.search(r"INFO solver\.mechanics: .*pc_type cholesky", text)
    assert re.search(r"INFO done: 10 steps to t = 0\.01; seconds: total \d+\.\d\d, setup ", text)
    assert re.search(r"INFO solver\.potential: solves 10, ", text)
    toml = [line[4:] for line in text.splitlines() if line.startswith("    ")]
    assert Case.from_dict(tomllib.loads("\n".join(toml))) == case


def test_a_rigid_model_of_a_script(tmp_path, small_run):
    """No mechanics, no case file: what there is, is logged."""
    _, model, _ = small_run
    model = type(model)(model.potential)
    with RunLog(tmp_path, ALONE):
        log_start({}, model, 1)
    assert "INFO solver.mechanics: " in (tmp_path / "run.log").read_text(encoding="utf-8")
