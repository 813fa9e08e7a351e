"""The memory of a run does not grow with its steps, on one process and on two."""

import json

import pytest

from small_cases import LINE, REMOVED, changed

pytestmark = pytest.mark.mpi

#: Nodes of the line, and steps: a vector that each step leaves behind is 8 · NODES · STEPS bytes.
NODES, STEPS = 1000, 40

#: Prints by how many bytes a step the memory of every case grew, on the process where it grew most; with the
#: last case also by how many a checkpoint, and a step by the last remedy of a failed one.
DRIVER = """
import json, sys
from pathlib import Path
from myostrain import Case
from myostrain.engine import MPI
from myostrain.run.checkpoint import Checkpoints
from myostrain.run.retries import Recovery

comm, (folder, steps, cases) = MPI.COMM_WORLD, sys.argv[1:]
steps = int(steps)

def memory():
    status = Path("/proc/self/status").read_text()
    return 1024 * int(status.split("VmRSS:")[1].split()[0])

def growth(repeat, times):
    for _ in range(times // 2):  # until what is kept is there
        repeat()
    before = memory()
    for _ in range(times):
        repeat()
    return comm.allreduce(memory() - before, MPI.MAX) / times

found = {}
for name, case in json.loads(cases).items():
    model = Case.from_dict(case).build(comm)
    recovery, step = Recovery(model), case["time"]["step"]
    recovery.start()

    def advance():
        recovery.step(model.time + step)

    found[name] = growth(advance, steps)

def save():
    checkpoints.write(model.steps, model.state())

def remedy():
    with model.potential.solver.direct_solver(), model.mechanics.solver.direct_solver():
        advance()

spaces = [model.potential.v.function_space, model.mechanics.u.function_space]
checkpoints = Checkpoints(Path(folder), spaces)
found["a checkpoint"], found["a remedy"] = growth(save, 20), growth(remedy, 20)
if comm.rank == 0:
    print(json.dumps(found))
"""


def lines():
    """A line by every scheme, balance and mass."""
    found = {}
    for scheme in ("implicit", "staggered", "second-order"):
        for balance in ("conservative", "advective"):
            for mass in ("lumped", "averaged"):
                changes = {
                    "geometry": {"kind": "line", "length": 400.0, "spacing": 400.0 / NODES},
                    "time.scheme": scheme,
                    "mechanics.every": REMOVED if scheme == "implicit" else 1,
                    "potential.balance": balance,
                    "potential.mass": mass,
                }
                found[f"{scheme} {balance} {mass}"] = changed(LINE, changes)
    return found


@pytest.mark.parametrize("processes", [1, 2])
def test_memory_does_not_grow(on_processes, tmp_path, processes):
    """A step may leave less than half a vector behind; a matrix is four vectors and more.

    A remedy, repeated twenty times, may leave the pages that the allocator keeps (up to 18 kB seen); the
    factorizations that it once left were 950 kB.
    """
    printed = on_processes(processes, DRIVER, tmp_path, STEPS, json.dumps(lines()))
    growth = json.loads(printed.splitlines()[-1])
    vector = 8 * NODES / processes
    rare = {name: growth.pop(name) for name in ("a checkpoint", "a remedy")}
    assert len(growth) == 12
    assert {name: by for name, by in growth.items() if by > vector / 2} == {}
    assert {name: by for name, by in rare.items() if by > 20 * vector} == {}
