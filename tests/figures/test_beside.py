"""Drawing in a process beside the run: it draws the same, and ends with the run however that ends."""

import os
import signal
import subprocess
import sys
import time

from myostrain import InputError
from myostrain.output.figures import beside
from myostrain.output.figures.beside import Artist
from myostrain.output.figures.draw import draw

import numpy as np
import pytest

from snapshot_files import write_snapshots

LINE = ["evolution.png", "potential.png", "space-time.png"]
PATIENCE = 60.0


def line(folder):
    X, time = np.arange(101.0), np.linspace(0, 1, 7)
    v = np.exp(-(((X - 60 * time[:, None]) / 10) ** 2))
    cells = np.column_stack([np.arange(100), np.arange(1, 101)])
    write_snapshots(folder, X[:, None], cells, time, potential=v, recovery=v / 4)
    (folder / "case.toml").write_text('title = "A line"\n')


def alive(number):
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    return True


def test_it_draws_what_is_drawn_here(tmp_path):
    for folder in ("here", "beside"):
        (tmp_path / folder).mkdir()
        line(tmp_path / folder)
    draw(tmp_path / "here")
    with Artist() as artist:
        process = artist._process
        artist.draw(tmp_path / "beside")
        assert process.poll() is not None  # it has ended, and has been waited for
    for name in LINE:
        one, other = ((tmp_path / folder / "figures" / name).read_bytes() for folder in ("here", "beside"))
        assert one == other


def test_warnings_come_across(tmp_path, caplog, monkeypatch):
    (tmp_path / "sitecustomize.py").write_text(
        "import logging, myostrain.output.figures as figures, types, sys\n"
        "module = types.ModuleType('myostrain.output.figures.draw')\n"
        "module.draw = lambda folder: logging.getLogger('myostrain').warning('no %s', 'pictures')\n"
        "sys.modules[module.__name__] = module\n"
    )
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")
    with caplog.at_level("WARNING", logger="myostrain"), Artist() as artist:
        artist.draw(tmp_path)
    assert caplog.messages == ["no pictures"]


@pytest.mark.parametrize("end", ["none", "killed", "not started"])
def test_without_it_the_figures_are_drawn_here(tmp_path, monkeypatch, end):
    if end == "not started":
        monkeypatch.setattr(sys, "executable", str(tmp_path / "nothing"))
    line(tmp_path)
    with Artist(beside=end != "none") as artist:
        if end == "killed":
            artist._process.kill()
        artist.draw(tmp_path)
    assert sorted(path.name for path in (tmp_path / "figures").iterdir()) == LINE


def test_what_is_wrong_is_said_here_and_once(tmp_path, capfd):
    with Artist() as artist, pytest.raises(InputError, match="holds no frames"):
        artist.draw(tmp_path)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_it_ends_when_the_run_is_killed(number):
    """Nobody is left who could tell it to; and a Ctrl-C at the keyboard is the run's business."""
    code = (
        "import time; from myostrain.output.figures.beside import Artist\n"
        "print(Artist()._process.pid, flush=True); time.sleep(600)"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as run:
        drawing = int(run.stdout.readline())
        time.sleep(0.5)
        assert alive(drawing)
        run.send_signal(number)
        run.wait()
    begin = time.monotonic()
    while alive(drawing) and time.monotonic() - begin < PATIENCE:
        time.sleep(0.1)
    assert not alive(drawing)


def test_where_it_saves_nothing_there_is_none(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 1})
    monkeypatch.delitem(sys.modules, "matplotlib", raising=False)
    assert beside.worth_it(1)
    assert not beside.worth_it(2)  # all cores are busy
    monkeypatch.setitem(sys.modules, "matplotlib", sys)
    assert not beside.worth_it(1)  # there is nothing left to load
