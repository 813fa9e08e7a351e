"""What may change between a run and the one that goes on from its checkpoint, and what is no checkpoint."""

import hashlib
import io
import json
import os
import shutil
import signal
from types import SimpleNamespace

import myostrain as ms
from myostrain import Case, InputError
from myostrain.case.running import run_case
from myostrain.electrics.place import Place
from myostrain.errors import Interrupted
from myostrain.run.checkpoint import FORMAT
from myostrain.run.resume import built

import numpy as np
import pytest

from small_cases import ALONE, LINE, STATIC, changed, command_line, write_case

BARE = changed(LINE, {"output.fields": [], "output.checkpoint_every": 2e-3})


def test_boxes_of_stimuli_are_compared():
    """The corners of a box are seen, and nobody is told that they cannot be."""
    told = []
    for corner in (0.0, 0.5):
        place = Place(box=((corner, 0.0), (1.0, 1.0)))
        model = SimpleNamespace(potential=SimpleNamespace(stimuli=[SimpleNamespace(where=place)]))
        told.append(built(model, told.append))
    assert [first["potential"]["stimuli"][0]["where"]["box"][0] for first in told] == [[0.0, 0.0], [0.5, 0.0]]


class Stop:
    """Sends a signal to this process after some steps."""

    def __init__(self, after):
        self.after = after

    def __call__(self, name, steps, end):
        return self

    def update(self, step, time):
        if step == self.after:
            os.kill(os.getpid(), signal.SIGTERM)


class Enough(Exception):
    """What a script stops a run with."""


def test_a_script_that_stops_a_run_leaves_a_checkpoint(tmp_path):
    """Its exception comes through, and the run goes on from the step after which it was raised."""
    case = Case.from_dict(changed(BARE, {"output.checkpoint_every": 1.0}))

    class Stopping(Stop):
        def update(self, step, time):
            if step == self.after:
                raise Enough

    with pytest.raises(Enough):
        run_case(case, tmp_path, comm=ALONE, figures=False, progress=Stopping(3))
    assert [path.name for path in (tmp_path / "checkpoint").glob("*.ckpt")] == ["step-000000003.ckpt"]
    assert "the script stopped the run" in (tmp_path / "run.log").read_text()
    run_case(case, tmp_path, comm=ALONE, figures=False, resume=True)
    assert "step 3" in (tmp_path / "run.log").read_text()


def stopped(case, out, after):
    with pytest.raises(Interrupted):
        run_case(Case.from_dict(case), out, comm=ALONE, figures=False, progress=Stop(after))


def test_loads_may_change(tmp_path):
    """A run that diverged at too large a load goes on with a smaller one, and says so; an elastic body in
    equilibrium does not know what it was loaded by before.
    """
    case = changed(STATIC, {"output.fields": []})
    less = changed(
        case,
        {
            "mechanics.pressure": {"bottom": [[0.0, 0.0], [1.0, 0.01]]},
            "mechanics.tolerance": 1e-9,
            "solver.mechanics": {"ksp_type": "gmres", "pc_type": "lu", "pc_factor_mat_solver_type": "mumps"},
        },
    )
    stopped(case, tmp_path / "out", 2)
    found = run_case(Case.from_dict(less), tmp_path / "out", comm=ALONE, figures=False, resume=True)
    exact = run_case(Case.from_dict(less), tmp_path / "less", comm=ALONE, figures=False)
    assert found["metrics"]["displacement_max"] == pytest.approx(
        exact["metrics"]["displacement_max"], rel=1e-6
    )
    changes = {change["key"]: change for change in found["changes"]}
    assert {"mechanics.pressure.bottom", "mechanics.tolerance", "solver.mechanics.ksp_type"} <= changes.keys()
    record = {"time": 0.5, "key": "mechanics.tolerance", "from": 1e-7, "to": 1e-9}
    assert changes["mechanics.tolerance"] == record
    assert exact["changes"] == []


def test_a_later_end(tmp_path):
    """A run that ended goes on to a later end, as one that was to go there from the beginning."""
    file, out = write_case(tmp_path / "mine.toml", BARE), tmp_path / "out"
    later = ("--set", "time.end=0.02")
    assert command_line("run", file, "--out", out).status == 0
    for wrong, words in (
        (("--set", "time.end=0.005"), "later time.end"),
        (("--set", "output.every=0.001"), "later time.end"),
        (("--set", "time.end=0.0125"), "steps of 0.001 "),
        ((*later, "--set", "cell.alpha=0.2"), "cell.alpha is 0.2, it was 0.1"),
    ):
        done = command_line("run", "--resume", "--out", out, *wrong)
        assert (done.status, words in done.err) == (2, True), done.err
    assert command_line("run", "--resume", "--out", out, *later).status == 0
    assert command_line("run", file, "--out", tmp_path / "whole", *later).status == 0
    one, two = (json.loads((f / "results.json").read_text()) for f in (out, tmp_path / "whole"))
    assert (one["steps"], one["time"]) == (20, pytest.approx(0.02))
    for name, value in two["metrics"].items():
        assert one["metrics"][name] == (value if value is None else pytest.approx(value, rel=1e-12)), name
    assert [change["key"] for change in one["changes"]] == ["time.end"]
    again = command_line("run", "--resume", "--out", out)
    assert "had ended already" in again.out


class Stiffer:
    """A material of a script, by a class and an attribute."""

    tensor_dim = 1
    modulus = 1.0

    def __init__(self, mu):
        self.mu = mu

    def energy(self, Fe, fibres):
        return self.mu / 2 * (Fe[0, 0] - 1) ** 2


def script(out, *, resume=False, material=None, kinematics=None, scheme=None, law=None, step=1e-3, **others):
    """A line as a script builds it; two steps, and two more when it is resumed."""
    body = ms.build(ms.geometry.Line(length=20.0))
    potential = {key: others.pop(key) for key in ("membrane", "diffusivity", "mass") if key in others}
    probes = others.pop("probes", {"a": [6.0]})
    mechanics = ms.Mechanics(
        body,
        kinematics=kinematics or ms.kinematics.Line(),
        material=material or ms.materials.Spring(mu=1.0),
        supports=ms.Supports(fixed=("left",), robin=others.pop("robin", 0.0)),
        **others,
    )
    v = ms.Potential(
        body,
        **{"membrane": ms.membranes.FitzHughNagumo(), **potential},
        deformation=mechanics.deformation,
    )
    model = ms.Electromechanics(v, mechanics, law=law or ms.activation.Proportional(beta=0.3), scheme=scheme)
    end = 4e-3 if resume else 2e-3
    return ms.Simulation(model, step=step, end=end, out=out, probes=probes, fields=[], resume=resume).run()


CHANGED = [
    ("law.beta", {"law": ms.activation.Proportional(beta=0.2)}),
    ("mechanics.material", {"material": ms.materials.Spring(mu=2.0)}),
    ("mechanics.material", {"material": Stiffer(1.0)}),
    ("potential.membrane", {"membrane": ms.membranes.FitzHughNagumo(alpha=0.2)}),
    ("potential.diffusivity", {"diffusivity": 2.0}),
    ("potential.mass", {"mass": "averaged"}),
    ("scheme", {"scheme": ms.Staggered()}),
    ("mechanics.*robin", {"robin": 1.0}),
    ("mechanics.relaxation_time", {"relaxation_time": 0.1}),
    ("probes.a", {"probes": {"a": [7.0]}}),
    ("time.end", {"step": 2e-3}),
]


@pytest.mark.parametrize("key, change", CHANGED, ids=[str(list(change)) + key for key, change in CHANGED])
def test_another_model_of_a_script_is_refused(tmp_path, key, change):
    """Design: "An object of the user's script is checked like a case file"; the key is named."""
    script(tmp_path / "out")
    with pytest.raises(InputError, match=key):
        script(tmp_path / "out", resume=True, **change)


def test_the_same_model_of_a_script_goes_on(tmp_path):
    """And tolerances may change; objects of the script's own are compared by what they hold."""
    script(tmp_path / "one", material=Stiffer(1.0))
    found = script(tmp_path / "one", resume=True, material=Stiffer(1.0), tolerance=1e-12)
    assert found["steps"] == 4
    assert [change["key"] for change in found["changes"]] == ["mechanics.tolerance"]
    script(tmp_path / "two", material=Stiffer(1.0))
    with pytest.raises(InputError, match=r"mechanics\.material\.mu is 2\.0, it was 1\.0"):
        script(tmp_path / "two", resume=True, material=Stiffer(2.0))


@pytest.fixture(scope="module")
def cut(tmp_path_factory):
    """The result folder of a run that was stopped, with one checkpoint."""
    out = tmp_path_factory.mktemp("cut") / "out"
    stopped(BARE, out, 5)
    for path in sorted((out / "checkpoint").iterdir())[:-1]:
        path.unlink()
    return out


def signed(payload):
    digest = hashlib.sha256(FORMAT.encode())
    digest.update(payload)
    return f"{FORMAT}\n{digest.hexdigest()}\n".encode() + payload


def archive(tree, **arrays):
    content = io.BytesIO()
    np.savez(content, state=np.frombuffer(json.dumps(tree).encode(), dtype=np.uint8), **arrays)
    return content.getvalue()


def rewritten(path, change):
    """The checkpoint with its tree, or its arrays, changed, and a right checksum."""
    with np.load(io.BytesIO(path.read_bytes().split(b"\n", 2)[2])) as file:
        arrays = {name: file[name] for name in file.files}
    tree = json.loads(arrays.pop("state").tobytes())
    tree, arrays = change(tree, arrays)
    return signed(archive(tree, **arrays))


FORGED = {
    "junk": lambda path: signed(b"junk"),
    "empty": lambda path: signed(b""),
    "no zip": lambda path: signed(b"PK\3\4" + bytes(100)),
    "no state": lambda path: rewritten(path, lambda tree, arrays: ({}, arrays)),
    "a list": lambda path: rewritten(path, lambda tree, arrays: ([1, 2], arrays)),
    "no model": lambda path: rewritten(path, lambda tree, arrays: ({**tree, "model": None}, arrays)),
    "no time": lambda path: rewritten(path, lambda tree, arrays: ({**tree, "model": {"steps": 5}}, arrays)),
    "half a model": lambda path: rewritten(
        path, lambda tree, arrays: ({**tree, "model": {**tree["model"], "mechanics": {}}}, arrays)
    ),
    "text": lambda path: rewritten(path, lambda tree, arrays: ({**tree, "seconds": "long"}, arrays)),
    "retries": lambda path: rewritten(path, lambda tree, arrays: ({**tree, "retries": 3}, arrays)),
    "table": lambda path: rewritten(path, lambda tree, arrays: ({**tree, "table": "x"}, arrays)),
    "no arrays": lambda path: rewritten(path, lambda tree, arrays: (tree, {})),
    "short": lambda path: rewritten(path, lambda tree, arrays: (tree, {k: a[:3] for k, a in arrays.items()})),
    "whole": lambda path: rewritten(
        path, lambda tree, arrays: (tree, {k: np.ones(len(a), dtype=int) for k, a in arrays.items()})
    ),
}


@pytest.mark.parametrize("name", FORGED)
def test_a_forged_checkpoint_is_refused(tmp_path, cut, name):
    """A right checksum and a wrong content: one message, exit status 2."""
    out = tmp_path / "out"
    shutil.copytree(cut, out)
    (path,) = (out / "checkpoint").iterdir()
    path.write_bytes(FORGED[name](path))
    done = command_line("run", "--resume", "--out", out)
    assert done.status == 2, done.err
    assert "checkpoint" in done.err
    assert done.err.count("\n") == 1


@pytest.mark.parametrize("kind", ["pipe", "device", "folder"])
def test_pipes_and_devices_are_no_checkpoints(tmp_path, cut, kind):
    """They are named, and nothing hangs."""
    out = tmp_path / "out"
    shutil.copytree(cut, out)
    path = out / "checkpoint" / "step-000000009.ckpt"
    make = {"pipe": os.mkfifo, "device": lambda path: path.symlink_to("/dev/zero"), "folder": os.mkdir}
    make[kind](path)
    done = command_line("run", "--resume", "--out", out)
    assert (done.status, path.name in done.err) == (0, True), done.err
