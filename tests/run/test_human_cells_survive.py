"""A human cell on a body through the command line: killed in a stimulus, gates out of bounds, wrong input."""

import json
import signal
import subprocess
import sys

from myostrain import Case, run_case
from myostrain.output.snapshots import Snapshots

import pytest

from small_cases import COMMAND, changed, command_line, write_case

#: A rigid line, in the middle of a long stimulus for most of its time; a layer of its own.
CASE = {
    "geometry": {"kind": "line", "length": 4.0, "spacing": 0.5},
    "cell": {"model": "TenTusscherPanfilov2006", "variation": [{"box": [[2.2], [9.0]], "set": "M"}]},
    "potential": {"diffusivity": 0.15},
    "stimulus": {"center": [0.0], "radius": 1.0, "strength": 15.0, "start": 0.5, "duration": 3.5},
    "mechanics": {"kinematics": "rigid"},
    "time": {"step": 0.05, "end": 4.0},
    "probes": {"a": [0.7], "b": [3.2]},
    "output": {"every": 1.0, "checkpoint_every": 0.5},
}

#: Kills itself, as no handler can see, after a step.
KILLED = """
import os, signal, sys
from myostrain import Case, run_case

class Kill:
    def update(self, step, time):
        if step == 47:
            os.kill(os.getpid(), signal.SIGKILL)

run_case(Case.from_file(sys.argv[1]), sys.argv[2], figures=False, progress=lambda *_: Kill())
"""


@pytest.mark.parametrize("processes", [1, 2])
def test_killed_in_a_stimulus(tmp_path, request, processes):
    """SIGKILL at t = 2.35, between two edges of the stimulus; what goes on has the bits of the whole run."""
    file = write_case(tmp_path / "case.toml", CASE)
    start = [request.getfixturevalue("mpiexec"), "-n", "2"] if processes == 2 else []
    killed = [*start, sys.executable, "-c", KILLED, str(file), str(tmp_path / "cut")]
    status = subprocess.run(killed, check=False, timeout=200, capture_output=True).returncode
    assert status == -signal.SIGKILL if processes == 1 else status != 0
    kept = sorted((tmp_path / "cut" / "checkpoint").glob("*.ckpt"))
    assert kept[-1].name == "step-000000040.ckpt"
    assert not (tmp_path / "cut" / "results.json").exists()
    run = [*start, *COMMAND, "run", "--quiet"]
    if processes == 1:
        resumed = command_line("run", "--resume", "--out", tmp_path / "cut")
        assert resumed.status == 0, resumed.err
        run_case(Case.from_file(file), tmp_path / "whole", figures=False)
    else:
        subprocess.run([*run, "--resume", "--out", str(tmp_path / "cut")], check=True, timeout=200)
        subprocess.run([*run, str(file), "--out", str(tmp_path / "whole")], check=True, timeout=200)
    found = []
    for name in ("cut", "whole"):
        results = json.loads((tmp_path / name / "results.json").read_text())
        frames = Snapshots(tmp_path / name)
        fields = {n: [frames.field(n, i).tolist() for i in range(len(frames.times))] for n in frames.names}
        table = (tmp_path / name / "probes.csv").read_text()
        found.append((fields, table, results["metrics"], results["probes"], results["solver"]))
    assert max(found[0][0]["potential"][-1]) > 0  # it has fired
    assert len(found[0][0]) > 18  # all states
    assert found[0] == found[1]


@pytest.mark.parametrize(
    "state, value, words",
    [
        ("h", 1.5, r"the gate h has left [0, 1]: 1.4"),
        ("Ca_i", -1e-3, "the state Ca_i is nan"),
    ],
)
def test_a_state_out_of_bounds(tmp_path, state, value, words):
    """Status 3; the state, the place and the time are named."""
    start = {"states": {state: value}, "center": [2.0], "radius": 0.2}
    file = write_case(tmp_path / "case.toml", changed(CASE, {"initial": start}))
    done = command_line("run", file, "--out", tmp_path / "out")
    assert done.status == 3
    last = done.err.strip().splitlines()[-1]
    assert words in last
    assert "near [2.0]" in last
    assert "at t = 0.05" in last


ODE = "parameters(a=2.0)\nstates(v=0.0, w=0.5)\ndv_dt = -aa*v - w\ndw_dt = a*v\n"

#: What the issue names as bad input, and what the one message must hold.
WRONG = {
    "parameter": ({"cell.g_Nax": 3.0}, "cell.g_Nax: no such key; did you mean 'g_Na'"),
    "set": ({"cell.set": "MID"}, "cell.set: this should be 'EPI', 'ENDO' or 'M'"),
    "slope": ({"cell.slope": 1.2}, "cell.slope: 1.2 is not a slope"),
    "varied parameter": (
        {"cell.variation": [{"box": [[2.2], [9.0]], "g_Nax": 3.0}]},
        "cell.variation.1.g_Nax: TenTusscherPanfilov2006 has no such parameter; did you mean 'g_Na'",
    ),
    "varied set": (
        {"cell.variation": [{"box": [[2.2], [9.0]], "set": "MID"}]},
        "cell.variation.1.set: 'MID' is not a set of TenTusscherPanfilov2006; did you mean 'M'?",
    ),
    "undefined name": ({"cell": {"model": "file", "path": "bad.ode"}}, "bad.ode: aa, of which dv_dt is made"),
    "CellML": ({"cell": {"model": "file", "path": "bad.cellml"}}, "bad.cellml: Myokit cannot read it"),
    "stimulus outside": ({"stimulus.center": [50.0]}, "stimulus.radius: no node of the mesh"),
    "stimulus of no boundary": (
        {"stimulus": [{"boundary": ["lft"], "strength": 1.0, "duration": 1.0}]},
        "stimulus.boundary: no boundary is called 'lft'; did you mean 'left'",
    ),
    "duration": ({"stimulus.duration": -1.0}, "stimulus.duration: this should be greater than 0"),
    "refinement": ({"potential.refinement": 30}, "potential.refinement: this gives about"),
    "units": ({"units": {"time": "s"}}, "units.time: TenTusscherPanfilov2006 counts the time in ms, not s"),
}


@pytest.mark.parametrize("name", WRONG)
def test_bad_input(tmp_path, name):
    """One message with the key, status 2, and nothing is written."""
    changes, words = WRONG[name]
    (tmp_path / "bad.ode").write_text(ODE, encoding="utf-8")
    (tmp_path / "bad.cellml").write_text("<model", encoding="utf-8")
    file = write_case(tmp_path / "case.toml", changed(CASE, changes))
    done = command_line("run", file, "--out", tmp_path / "out")
    assert done.status == 2
    assert words in done.err
    assert len(done.err.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()
