"""Reactions of supports, and the balance of loads on a free body, on two processes against one."""

import json

import pytest

pytestmark = pytest.mark.mpi

#: Reactions of a sheet that is fixed, moved, pulled and pressed; what is refused of one that is free.
DRIVER = """
import json
import myostrain as ms
from myostrain.engine import MPI
from myostrain.kinematics import PlaneStress
from myostrain.materials import NeoHookean

body = ms.build(ms.geometry.Rectangle(size=(2.0, 1.0), spacing=0.25), ms.UniformFibres(direction=(1.0, 1.0)))


def made(**parts):
    mechanics = ms.Mechanics(body, kinematics=PlaneStress(), material=NeoHookean(), tolerance=1e-11, **parts)
    mechanics.activation.x.array[:] = -0.2
    return mechanics


held = made(
    supports=ms.Supports(fixed=["left"], displacement={"right": {"x": 0.3}}, robin={"top": 0.5}),
    loads=ms.Loads(traction={"top": [0.1, 0.0]}, pressure={"bottom": 0.1}),
)
held.start()
found = {"reactions": held.reactions.values()}
free = made(loads=ms.Loads(pressure={"left": -0.5, "right": -0.5}))
try:
    free.start()
except ms.ComputationError as error:
    found["refused"] = str(error)
if MPI.COMM_WORLD.rank == 0:
    print(json.dumps(found))
"""


def test_supports_do_not_depend_on_processes(on_processes):
    """Reactions, and the message with the net force and moment, are the same on one and two processes."""
    one, two = (json.loads(on_processes(number, DRIVER).splitlines()[-1]) for number in (1, 2))
    assert set(one["reactions"]) >= {"reaction_left_y", "reaction_right_x", "reaction_top_x"}
    assert min(abs(value) for value in one["reactions"].values()) > 1e-4
    assert two["reactions"] == pytest.approx(one["reactions"], abs=1e-9)
    assert "moment (" in one["refused"]
    assert two["refused"] == one["refused"]
