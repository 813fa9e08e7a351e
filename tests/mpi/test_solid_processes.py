"""Solids on two processes against one, by both solvers."""

import json

import pytest

pytestmark = pytest.mark.mpi

#: A slab contracts in two steps; positions of its corners, by each solver.
DRIVER = """
import json
import myostrain as ms
from myostrain.engine import MPI
from myostrain.kinematics import Solid
from myostrain.materials import NeoHookean
from myostrain.output.ordering import Ordering

found = {}
for name, solid, options in [
    ("kept", Solid(), None),
    ("block", Solid(), {"pc_type": "fieldsplit"}),
    ("nearly", Solid(bulk_modulus=10.0), None),
    ("multigrid", Solid(bulk_modulus=10.0), {"pc_type": "gamg"}),
]:
    fibres = ms.UniformFibres(direction=(2.0, 1.0, 0.5), sheet=(-1.0, 2.0, 0.0))
    body = ms.build(ms.geometry.Slab(size=(2.0, 1.0, 1.0), spacing=0.5), fibres)
    slab = ms.Mechanics(
        body, kinematics=solid, material=NeoHookean(), supports=ms.Supports(fixed=["left"]), options=options,
    )
    for step in range(3):
        slab.activation.interpolate(lambda x: -0.2 * step / 2 * (0.5 + x[0] / 4))
        if step:
            slab.solve(step / 2)
            slab.accept(step / 2)
        else:
            slab.start()
    whole = Ordering(slab.u.function_space).gather(slab.u.x.array)
    if whole is not None:
        displacements = whole[: 3 * 225] if solid.has_pressure else whole
        assert solid.has_pressure or len(whole) == 3 * 225
        found[name] = displacements.tolist()
if MPI.COMM_WORLD.rank == 0:
    print(json.dumps(found))
"""


def test_solids_do_not_depend_on_processes_or_solver(on_processes):
    """Issue 5, Parallel: the same displacements on one and two processes, by factors and by blocks."""
    one, two = (json.loads(on_processes(number, DRIVER).splitlines()[-1]) for number in (1, 2))
    for name, other in (("kept", "block"), ("nearly", "multigrid")):
        reference = one[name]
        assert max(map(abs, reference)) > 0.1
        for found in (one[other], two[name], two[other]):
            # The tolerance of each is 1e-10 of the extent 2.4.
            assert max(abs(a - b) for a, b in zip(reference, found, strict=True)) < 1e-9
