"""Prescribed displacements, tractions, reactions and stress of a case, from its file to its results."""

import csv
import os
import signal

from myostrain.case.case import Case
from myostrain.case.running import run_case
from myostrain.engine import MPI
from myostrain.errors import InputError, Interrupted
from myostrain.output.snapshots import Snapshots

import numpy as np
import pytest

MU, PULL = 2.0, 0.5
BAR = {
    "geometry": {"kind": "rectangle", "size": [2.0, 1.0], "spacing": 0.5},
    "fibres": {"direction": [1.0, 0.0]},
    "drive": {"potential": 0.0},
    "material": {"model": "NeoHookean", "mu": MU},
    "mechanics": {"kinematics": "plane-stress", "sliding": ["left", "bottom"], "tolerance": 1e-10},
    "time": {"step": 0.25, "end": 1.0, "scheme": "implicit"},
    "output": {"every": 0.25, "fields": ["displacement", "stress", "stress_trace"]},
}


def changed(**mechanics):
    return {**BAR, "mechanics": {**BAR["mechanics"], **mechanics}}


def rows(folder):
    table = csv.DictReader((folder / "measures.csv").read_text().splitlines())
    return [{name: float(value) for name, value in row.items()} for row in table]


def run(case, folder, **others):
    return run_case(Case.from_dict(case), folder, comm=MPI.COMM_SELF, figures=False, **others)


def test_reactions_and_stress_of_a_drawn_bar(tmp_path):
    """Drawn to λ(t) = 1 + t/4, the end bears P₁₁ = μ (λ − λ⁻²), and σ₁₁ = λ P₁₁ is the only stress."""
    case = changed(displacement={"right": {"x": [[0.0, 0.0], [1.0, PULL]]}})
    results = run(case, tmp_path / "out")
    for row in rows(tmp_path / "out"):
        stretch = 1 + row["time"] / 4
        piola = MU * (stretch - stretch**-2)
        assert row["reaction_right_x"] == pytest.approx(piola, abs=1e-7)
        assert row["reaction_left_x"] == pytest.approx(-piola, abs=1e-7)
        assert row["reaction_bottom_y"] == pytest.approx(0.0, abs=1e-7)
    assert results["metrics"]["reaction_right_x"] == pytest.approx(piola, abs=1e-7)
    frames = Snapshots(tmp_path / "out")
    wanted = {"stress_xx": piola * 1.25, "stress_trace": piola * 1.25}
    last = len(frames.times) - 1
    for name in [f"stress_{ij}" for ij in ("xx", "xy", "xz", "yy", "yz", "zz", "trace")]:
        np.testing.assert_allclose(frames.field(name, last), wanted.get(name, 0.0), atol=1e-6)


def test_a_traction_that_grows(tmp_path):
    """A dead load T(t) on the end is μ (λ − λ⁻²); the plane opposite bears it."""
    run(changed(traction={"right": [[0.0, [0.0, 0.0]], [1.0, [PULL, 0.0]]]}), tmp_path / "out")
    for row in rows(tmp_path / "out"):
        assert row["reaction_left_x"] == pytest.approx(-PULL * row["time"], abs=1e-7)


class Stop:
    """Ends a run after half of its steps, as a user does."""

    def __call__(self, name, steps, end):
        return self

    def update(self, number, time):
        if number == 2:
            os.kill(os.getpid(), signal.SIGTERM)


def test_a_run_goes_on_with_other_loads(tmp_path):
    """A run that was stopped is resumed with another load, and with one of another kind besides."""
    pull = {"right": [[0.0, 0.0], [1.0, -0.8]]}
    with pytest.raises(Interrupted):
        run(changed(pressure=pull), tmp_path / "out", progress=Stop())
    gentle = {"right": [[0.0, 0.0], [1.0, -0.4]]}
    run(changed(pressure=gentle, traction={"right": [0.1, 0.0]}), tmp_path / "out", resume=True)
    run(changed(pressure=gentle, traction={"right": [0.1, 0.0]}), tmp_path / "whole")
    assert rows(tmp_path / "out")[-1] == pytest.approx(rows(tmp_path / "whole")[-1], abs=1e-7)


WRONG = [
    (dict(displacement={"right": 0.3}), "mechanics.displacement.right", "give a table"),
    (dict(displacement={"right": {"q": 0.3}}), "mechanics.displacement.right.q", "'x', 'y' or 'z'"),
    (dict(displacement={"top": {"x": [[0.0, 0.0], [0.0, 1.0]]}}), "mechanics.displacement.top.x", "ascend"),
    (dict(traction={"right": 0.3}), "mechanics.traction.right", "a list"),
    (dict(traction={"right": [[1.0, [0.0, 0.0]], [0.0, [1.0, 0.0]]]}), "mechanics.traction.right", "ascend"),
]


@pytest.mark.parametrize("keys, key, words", WRONG)
def test_wrong_keys(keys, key, words):
    """A case's message names the key and what is allowed."""
    with pytest.raises(InputError) as caught:
        Case.from_dict(changed(**keys))
    assert caught.value.key == key
    assert words in str(caught.value)


@pytest.mark.parametrize("normals", ["smooth", "facets"])
def test_the_normals_that_a_case_names_are_those_of_its_supports(normals):
    """mechanics.normals: "normals of robin_normal and damping_normal"."""
    model = Case.from_dict(changed(normals=normals)).simulation(MPI.COMM_SELF).model
    assert model.mechanics.supports.normals == normals
