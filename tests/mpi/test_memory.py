"""The memory of a run does not grow with its steps, on one process and on two."""

import ctypes
import json

import pytest

from small_cases import LINE, REMOVED, changed

pytestmark = [
    pytest.mark.mpi,
    pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallinfo2"), reason="the C library does not count"),
]

#: Nodes of the line; steps between two looks at the memory.
NODES, STEPS = 400, 4

#: Prints by how many bytes a step the memory in use grew, on the process where it grew most, of every case;
#: with the last case also by how many a checkpoint, and a step by the last remedy of a failed one. What the C
#: library has handed out is exact; the pages of the process are not: what is left behind may fill gaps.
DRIVER = """
import ctypes, gc, itertools, json, statistics, sys
from pathlib import Path
from myostrain import Case
from myostrain.engine import MPI
from myostrain.run.checkpoint import Checkpoints
from myostrain.run.retries import Recovery

comm, (folder, steps, cases) = MPI.COMM_WORLD, sys.argv[1:]
steps = int(steps)

class Usage(ctypes.Structure):
    _fields_ = [(name, ctypes.c_size_t) for name in
                ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks",
                 "fordblks", "keepcost")]

mallinfo = ctypes.CDLL(None).mallinfo2
mallinfo.restype = Usage

def memory():
    gc.collect()
    used = mallinfo()
    return used.hblkhd + used.uordblks

def growth(repeat, times):
    kept = []
    for _ in range(5):
        for _ in range(times):
            repeat()
        kept.append(memory())
    # What comes or goes once, such as a preconditioner made anew, is in one of the differences.
    return comm.allreduce(statistics.median(b - a for a, b in itertools.pairwise(kept[1:])), MPI.MAX) / times

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
found["a checkpoint"], found["a remedy"] = growth(save, 2), growth(remedy, 2)
if comm.rank == 0:
    print(json.dumps(found))
"""


def lines():
    """A line by every scheme, balance and mass; any two of the three choices meet in some case."""
    found = {}
    for scheme, swapped in (("implicit", False), ("staggered", True), ("second-order", False)):
        for balance in ("conservative", "advective"):
            mass = "lumped" if (balance == "conservative") is not swapped else "averaged"
            changes = {
                "geometry": {"kind": "line", "length": 0.4 * NODES, "spacing": 0.4},
                "time.scheme": scheme,
                "mechanics.every": REMOVED if scheme == "implicit" else 1,
                "potential.balance": balance,
                "potential.mass": mass,
            }
            if scheme == "implicit":
                changes["time.tolerance"] = 1e-4
            found[f"{scheme} {balance} {mass}"] = changed(LINE, changes)
    return found


@pytest.mark.parametrize("processes", [1, 2])
def test_memory_does_not_grow(on_processes, tmp_path, processes):
    """A step leaves nothing behind; measured: 8 bytes, and 192 on two processes, of messages.

    A remedy left 670 bytes at most; the factorizations that it once left were hundreds of vectors.
    """
    every = lines()
    cases = every if processes == 1 else {name: every[name] for name in list(every)[1:5:3]}
    printed = on_processes(processes, DRIVER, tmp_path, STEPS, json.dumps(cases))
    growth = json.loads(printed.splitlines()[-1])
    vector = 8 * NODES / processes
    rare = {name: growth.pop(name) for name in ("a checkpoint", "a remedy")}
    assert growth.keys() == cases.keys()
    assert len(every) == 6
    assert {name: by for name, by in growth.items() if by > vector / 2} == {}
    assert {name: by for name, by in rare.items() if by > vector} == {}
