"""Parameters that vary over the body, on two processes against one."""

import json

import numpy as np
import pytest

from small_cases import SHEET, changed

pytestmark = pytest.mark.mpi

CASE = changed(
    SHEET,
    {
        "geometry": {"kind": "rectangle", "size": [8.0, 6.0], "spacing": 1.0},
        "cell.variation": [
            {"transmural": [0.0, 0.5], "transmural_between": ["bottom", "top"], "alpha": 0.15},
            {"boundary": ["left"], "depth": 2.0, "tau": 0.3},
            {"center": [0.0, 0.0], "radius": 1.6, "alpha": 0.2},
        ],
        "potential.refinement": 1,
        "initial": {"potential": 0.9, "center": [8.0, 6.0], "radius": 3.0},
        "probes": {},
    },
)

#: Nodes with their parameters and the potential after some steps; and a parameter wrong on one process only.
DRIVER = """
import json, sys
import numpy as np
import myostrain as ms
from myostrain.engine import MPI

comm, model = MPI.COMM_WORLD, ms.Case.from_dict(json.loads(sys.argv[1])).build()
model.start()
for step in range(5):
    model.step(1e-3 * (step + 1))
potential = model.potential
space = potential.v.function_space
own = space.dofmap.index_map.size_local
X = space.tabulate_dof_coordinates()[:own, :2]
varying = potential.varying
rows = np.column_stack([X, *(x[:own] for x in (varying["alpha"], varying["tau"], potential.v.x.array))])
length = len(potential.v.x.array) + (comm.rank == comm.size - 1)
place = ms.Place(box=((-1.0, -1.0), (1.0, 1.0)))
said = ms.Variation(where=place, parameters={"alpha": np.full(length, 0.2)})
try:
    ms.Potential(potential.body, membrane=potential.membrane, variations=[said])
    refused = ""
except ms.InputError as error:
    refused = str(error)
found = comm.gather((rows.tolist(), refused))
if comm.rank == 0:
    print(json.dumps([sum((rows for rows, _ in found), []), [words for _, words in found]]))
"""


def test_the_same_nodes_on_two_processes(on_processes):
    """The same parameters at the same nodes, the same potential; an array is refused by all or none."""
    found = [json.loads(on_processes(n, DRIVER, json.dumps(CASE)).splitlines()[-1]) for n in (1, 2)]
    one, two = (np.array(sorted(rows)) for rows, _ in found)
    one, two = (rows[np.lexsort(rows[:, :2].round(6).T)] for rows in (one, two))
    assert set(one[:, 2]) == {0.1, 0.15, 0.2}
    assert set(one[:, 3]) == {0.2, 0.3}
    np.testing.assert_array_equal(one[:, 2:4], two[:, 2:4])
    np.testing.assert_allclose(one[:, 4], two[:, 4], rtol=0, atol=1e-8)
    assert all(
        "cell.variation.1.alpha: give a number, or an array" in words for _, said in found for words in said
    )
