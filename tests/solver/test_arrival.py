"""Stimuli that come to each node at its own time: from tables, and by fronts over a surface."""

import json
import re

import myostrain as ms
from myostrain import InputError
from myostrain.electrics.arrival import shortest_ways

import numpy as np
import pytest

INERT = ms.membranes.FitzHughNagumo(A=0.0)
BODY = ms.build(
    ms.geometry.Slab(size=(6.0, 4.0, 2.0), spacing=1.0), ms.UniformFibres(direction=(1.0, 0.0, 0.0))
)
TOP = ms.Place(boundary=("top",))


def potential_with(**pulse):
    stimulus = ms.Stimulus(where=TOP, strength=3.0, duration=0.25, **pulse)
    return ms.Potential(BODY, membrane=INERT, diffusivity=1e-12, mass="lumped", stimuli=[stimulus])


def course(X):
    """Activation times of a front that is no plane."""
    return 0.1 * X[:, 0] + 0.013 * X[:, 1] ** 2


def table_at(path, points, times, names="x,y,z,time"):
    np.savetxt(path, np.column_stack([points, times]), delimiter=",", header=names, comments="")
    return path


def nodes():
    return potential_with().v.function_space.tabulate_dof_coordinates()


@pytest.mark.parametrize("by", ["point", "node"])
@pytest.mark.parametrize("times", [np.linspace(0, 1.4, 23)[1:], np.array([0.37, 0.8, 1.4])], ids=len)
def test_each_node_begins_at_its_own_time(tmp_path, by, times):
    """What is added is exact at every node at the end of every step, whatever the steps."""
    X = nodes()
    if by == "point":
        path = table_at(tmp_path / "t.csv", X, course(X))
    else:
        geometry = BODY.mesh.geometry
        numbers = geometry.input_global_indices[:, None]
        path = table_at(tmp_path / "t.csv", numbers, course(geometry.x), "node,time")
    potential = potential_with(times=path, start=0.05)
    model = ms.Electromechanics(potential)
    model.start()
    for time in times:
        model.step(time)
        due = 3.0 * np.clip(time - 0.05 - course(X), 0.0, 0.25) * (X[:, 2] > 2 - 1e-9)
        np.testing.assert_allclose(potential.v.x.array, due, rtol=0, atol=1e-8)


def test_between_the_points_of_a_table(tmp_path):
    """A node takes a mean of the nearest points, by the inverse squares of their distances."""
    path = table_at(
        tmp_path / "t.csv", [[0, 0, 2], [3, 0, 2], [6, 4, 2], [0, 4, 2], [6, 0, 2]], [1, 4, 9, 2, 3]
    )
    delays = ms.Stimulus(where=TOP, strength=1.0, duration=1.0, times=path).delays(
        BODY, potential_with().v.function_space
    )
    X = nodes()
    at = np.argmin(np.linalg.norm(X - [1.0, 0.0, 2.0], axis=1))
    assert delays[at] == pytest.approx(
        (1 + 4 / 4 + 9 / 41 + 2 / 17 + 3 / 25) / (1 + 1 / 4 + 1 / 41 + 1 / 17 + 1 / 25)
    )
    assert np.isinf(delays[X[:, 2] < 1.9]).all()


def unit_square(n):
    x = np.linspace(0, 1, n + 1)
    X = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    corner = (n + 1) * i + j
    lower = np.stack([corner, corner + n + 1, corner + n + 2], axis=1)
    upper = np.stack([corner, corner + n + 2, corner + 1], axis=1)
    return X, np.concatenate([lower, upper])


def test_plane_fronts_are_exact():
    """|∇d| = 1 between two sides of a square: the front is plane."""
    X, triangles = unit_square(7)
    begun = np.where(X[:, 0] == 0, 0.0, np.inf)
    np.testing.assert_allclose(shortest_ways(X, triangles, begun), X[:, 0], rtol=0, atol=1e-12)


def test_round_fronts_are_of_first_order():
    """From a corner of a square, and rolled up on a cylinder, where the ways are the same."""
    errors = []
    for n in (20, 40, 80):
        X, triangles = unit_square(n)
        distance = np.linalg.norm(X, axis=1)
        begun = np.where(distance < 0.1001, distance, np.inf)
        rolled = np.column_stack([np.cos(X[:, 0]), np.sin(X[:, 0]), X[:, 1]])
        errors += [np.abs(shortest_ways(Y, triangles, begun) - distance).max() for Y in (X, rolled)]
    flat, rolled = errors[::2], errors[1::2]
    assert flat[2] < 0.55 * flat[1] < 0.55**2 * flat[0] < 0.004
    assert rolled[2] < 0.55 * rolled[1] < 0.55**2 * rolled[0] < 0.004


def test_a_front_over_an_endocardium():
    """It comes to the last node of the endocardium when it was asked to, as with a speed up to a factor."""
    ventricle = ms.geometry.Ventricle(endocardium=(7.0, 17.0), epicardium=(10.0, 20.0), base=5.0, spacing=4.0)
    body = ms.build(ventricle, ms.UniformFibres(direction=(1.0, 0.0, 0.0)))
    space = ms.Potential(body, membrane=INERT).v.function_space
    inside = ms.Place(boundary=("endocardium",))
    roots = ((0.0, 0.0, -17.0),)
    pulse = dict(where=inside, strength=1.0, duration=1.0, roots=roots)
    share = ms.Stimulus(**pulse, speed=1.0).share(body, space) > 0
    timed = ms.Stimulus(**pulse, reached_in=40.0).delays(body, space)
    lengths = ms.Stimulus(**pulse, speed=2.0).delays(body, space) * 2.0
    assert timed[share].max() == pytest.approx(40.0, rel=1e-12)
    np.testing.assert_allclose(timed / 40.0, lengths / lengths[share].max(), rtol=1e-12)
    # Along meridians of the spheroid, from the apex to the base.
    angle = np.linspace(0, np.pi / 2 + np.arcsin(5 / 17), 2001)
    meridian = np.hypot(7 * np.cos(angle), 17 * np.sin(angle))
    exact = np.sum((meridian[1:] + meridian[:-1]) / 2 * np.diff(angle))
    assert lengths[share].max() == pytest.approx(exact, rel=0.05)


BAD = {
    "no column": ("x,y,time\n1,2,3\n", "has no column z"),
    "no number": ("x,y,z,time\n1,2,3,now\n", "is not a table of numbers"),
    "negative": ("x,y,z,time\n0,0,2,1\n1,0,2,-1\n", re.escape("row 3 is [1.0, 0.0, 2.0, -1.0]")),
    "empty": ("x,y,z,time\n", "has no row"),
    "far": ("x,y,z,time\n0,0,0.002,1\n1000,0,2,1\n0.006,0.004,0.002,2\n", "are the units the same"),
    "few nodes": ("node,time\n0,1\n3,1\n", "has no time for"),
    "twice": ("node,time\n1,1\n1,1\n", "several times for one node"),
}


@pytest.mark.parametrize("content, message", BAD.values(), ids=BAD.keys())
def test_bad_tables(tmp_path, content, message):
    """One message that says what is wrong with the table."""
    (tmp_path / "t.csv").write_text(content)
    with pytest.raises(InputError, match=rf"^stimulus\.times: .*{message}"):
        potential_with(times=tmp_path / "t.csv")


def test_bad_fronts(tmp_path):
    """Roots without a surface or a speed, and far away."""
    with pytest.raises(InputError, match="there is no file"):
        potential_with(times=tmp_path / "none.csv")
    with pytest.raises(InputError, match=r"stimulus\.roots: .*is 5 away from top"):
        potential_with(roots=((0.0, 0.0, 7.0),), speed=1.0)
    for keys, message in (
        (dict(roots=((0.0, 0.0, 2.0),)), "one of speed and reached_in"),
        (dict(speed=1.0), "they go with roots"),
        (dict(roots=((0.0, 0.0, 2.0),), speed=1.0, reached_in=1.0), "one of speed and reached_in"),
    ):
        with pytest.raises(InputError, match=message):
            potential_with(**keys)


#: Coordinates of the nodes and their times, by a table and by a front, the same rows in any order.
DRIVER = """
import json, sys
import myostrain as ms
from myostrain.engine import MPI

def times(path):
    slab = ms.geometry.Slab(size=(6.0, 4.0, 2.0), spacing=1.0)
    body = ms.build(slab, ms.UniformFibres(direction=(1.0, 0.0, 0.0)))
    space = ms.Potential(body, membrane=ms.membranes.FitzHughNagumo(A=0.0)).v.function_space
    pulse = dict(strength=1.0, duration=1.0, where=ms.Place(boundary=("top",), depth=1.0))
    own = space.dofmap.index_map.size_local
    X = space.tabulate_dof_coordinates()[:own].round(9).tolist()
    found = []
    for more in (dict(times=path), dict(roots=((0.3, 0.1, 2.0),), reached_in=40.0)):
        delays = ms.Stimulus(**pulse, **more).delays(body, space)[:own].tolist()
        found.append(sorted(sum(MPI.COMM_WORLD.allgather(list(zip(X, delays))), [])))
    return found
"""


@pytest.mark.mpi
def test_the_same_times_on_two_processes(on_processes, tmp_path):
    """Times of nodes do not depend on the number of processes."""
    X = nodes()
    path = str(table_at(tmp_path / "t.csv", X[X[:, 2] > 1.9] + 0.1, course(X[X[:, 2] > 1.9])))
    here = {}
    exec(DRIVER, here)
    said = on_processes(2, f"{DRIVER}\nfound = times(sys.argv[1])\nprint(json.dumps(found))", path)
    for left, right in zip(here["times"](path), json.loads(said.splitlines()[0]), strict=True):
        assert [X for X, _ in left] == [X for X, _ in right]
        np.testing.assert_allclose([t for _, t in left], [t for _, t in right], rtol=1e-12)
