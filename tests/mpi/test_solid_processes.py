"""Solids on two processes against one, by both solvers."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

MPIEXEC = shutil.which("mpiexec", path=str(Path(sys.executable).parent)) or shutil.which("mpiexec")

pytestmark = [
    pytest.mark.mpi,
    pytest.mark.skipif(MPIEXEC is None, reason="there is no mpiexec beside this Python or on the path"),
]

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


def run(*launcher):
    done = subprocess.run(
        [*launcher, sys.executable, "-c", DRIVER], capture_output=True, text=True, timeout=200, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.strip().splitlines()[-1])


def test_solids_do_not_depend_on_processes_or_solver():
    """Issue 5, Parallel: the same displacements on one and two processes, by factors and by blocks."""
    one, two = run(), run(str(MPIEXEC), "-n", "2")
    for name, other in (("kept", "block"), ("nearly", "multigrid")):
        reference = one[name]
        assert max(map(abs, reference)) > 0.1
        for found in (one[other], two[name], two[other]):
            # The tolerance of each is 1e-10 of the extent 2.4.
            assert max(abs(a - b) for a, b in zip(reference, found, strict=True)) < 1e-9
