"""docs/numerics.md, Checkpoints: which runs on several processes have the same bits."""

import json

import pytest

from small_cases import LINE, SHEET, changed

pytestmark = pytest.mark.mpi

#: Runs each case twice, and once resumed in the middle; prints how far v and u are from the first run's.
DRIVER = """
import json, sys
import numpy as np
from myostrain import Case
from myostrain.engine import MPI

comm, found = MPI.COMM_WORLD, {}
for name, case in json.loads(sys.argv[1]).items():
    ends = []
    for interrupted in (False, False, True):
        model = Case.from_dict(case).build(comm)
        model.start()
        for step in range(8):
            if interrupted and step == 4:
                state = model.state()
                model = Case.from_dict(case).build(comm)
                model.restore(state)
            model.step((step + 1) * 1e-3)
        ends.append(np.concatenate([model.potential.v.x.array, model.mechanics.u.x.array]))
    off = [float(np.abs(end - ends[0]).max()) for end in ends[1:]]
    found[name] = [comm.allreduce(value, MPI.MAX) for value in off]
if comm.rank == 0:
    print(json.dumps(found))
"""

RIGID = {"value": 1.0, "until": 1.0}
CASES = {
    "line": LINE,
    "sheet": changed(SHEET, {"potential.mass": "averaged", "mechanics.every": 2}),
    "rigid line": changed(LINE, {"mechanics.imposed_stretch": RIGID}),
    "rigid sheet": changed(SHEET, {"potential.mass": "averaged", "mechanics.imposed_stretch": RIGID}),
}


@pytest.mark.parametrize("processes", [1, 2])
def test_bits_of_repeated_runs(on_processes, processes):
    """One process: the same bits. Two: of a rigid body; of a deforming one up to round-off."""
    found = json.loads(on_processes(processes, DRIVER, json.dumps(CASES)).splitlines()[-1])
    assert found.keys() == CASES.keys()
    for name, off in found.items():
        same = processes == 1 or name.startswith("rigid")
        assert max(off) <= (0.0 if same else 1e-12), name
