"""kinematics = "rigid" in a case: no mechanics is made, and the potential is that of a body that is held."""

import contextlib
from unittest import mock

from myostrain.case.case import Case
from myostrain.case.running import run_case
from myostrain.errors import ComputationError, InputError

import numpy as np
import pytest

from small_cases import LINE, REMOVED, SHEET, SOLID, changed

#: Without what a rigid body has no use for.
RIGID = {"kinematics": "rigid"}


def rigid(case, **more):
    """A small case on a rigid body."""
    kept = {key: value for key, value in case.items() if key not in ("activation", "material")}
    return changed({**kept, "mechanics": dict(RIGID)}, more)


@pytest.mark.parametrize("case, dim", [(LINE, 1), (SHEET, 2), (SOLID, 3)])
def test_a_rigid_case_is_a_script_without_mechanics(case, dim, tmp_path):
    """docs/howto/case-file.md, mechanics: nothing of the mechanics is made, written or counted."""
    made = Case.from_dict(rigid(case))
    assert made.dim == dim
    found = run_case(made, tmp_path / "run", figures=False)
    assert "mechanics" not in {*found["solver"], *found["unknowns"], *found["tolerances"]}
    assert found["metrics"]["displacement_max"] == 0.0
    assert found["seconds"]["mechanics"] == 0.0
    header = (tmp_path / "run" / "probes.csv").read_text().splitlines()[0]
    assert header == "time,a_potential,a_recovery,b_potential,b_recovery"
    again = Case.from_file(tmp_path / "run" / "case.toml")  # what was written is the same case
    assert again.parameters == made.parameters
    assert "material" not in again.parameters


def test_the_potential_is_that_of_a_body_that_is_held():
    """On a line that is held at the stretch 1 the potential is the same, step by step."""
    held = changed(LINE, {"mechanics.imposed_stretch": {"value": 1.0, "until": float("inf")}})
    values = []
    for case in (held, rigid(LINE)):
        model = Case.from_dict(case).build()
        model.start()
        for number in range(1, 11):
            model.step(number * 1e-3)
        values.append(model.potential.v.x.array.copy())
    assert np.ptp(values[0]) > 0.5
    np.testing.assert_allclose(values[1], values[0], rtol=0, atol=1e-12)


def test_a_finer_mesh_of_a_rigid_body_is_the_body_of_half_the_spacing():
    """potential.refinement with a rigid body: the mesh itself is finer."""
    potentials = []
    for case in (rigid(LINE, **{"potential.refinement": 1}), rigid(LINE, **{"geometry.spacing": 0.5})):
        model = Case.from_dict(case).build()
        model.start()
        model.step(1e-3)
        order = np.argsort(model.potential.v.function_space.tabulate_dof_coordinates()[:, 0])
        potentials.append(model.potential.v.x.array[order])
    np.testing.assert_allclose(*potentials, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    "changes, key",
    [
        ({"material": {"model": "Spring"}}, "material"),
        ({"activation": {"beta": 0.2}}, "activation"),
        ({"mechanics.robin": 1.0}, "mechanics.robin"),
        ({"mechanics.every": 2}, "mechanics.every"),
        ({"solver": {"mechanics": {"ksp_type": "cg"}}}, "solver.mechanics"),
        ({"output.rigid_twin": True}, "output.rigid_twin"),
    ],
)
def test_what_a_rigid_body_has_no_use_for_is_refused(changes, key):
    """No key is silently without effect."""
    with pytest.raises(InputError, match=rf"^{key}: a rigid body has no use for this (key|section)"):
        Case.from_dict(rigid(LINE, **changes))


def test_a_step_longer_than_an_upstroke_is_said(caplog):
    """v of Bueno-Orovio 2008 grows at (1.55 + 0.3 − 2 u)/0.11 per ms where u is above 0.3, at most 11.4."""
    excited = {"potential": -54.0, "center": [0.0], "radius": 5.0}
    cell = {"model": "BuenoOrovio2008"}
    base = changed(
        rigid(LINE), {"cell": cell, "initial": excited, "potential.diffusivity": 0.1, "probes": REMOVED}
    )
    for step, said in ((0.25, 1), (0.08, 0)):
        caplog.clear()
        model = Case.from_dict(changed(base, {"time.step": step, "time.end": 3.0})).build()
        model.start()
        places = mock.Mock(wraps=model.potential._place)
        model.potential._place = places
        with contextlib.suppress(ComputationError):  # the matrix is indefinite, a run would try again
            for number in range(1, 9):
                model.step(number * step)
        told = [r.getMessage() for r in caplog.records if "too long for BuenoOrovio2008" in r.getMessage()]
        assert len(told) == said, told  # once, not at each step
        assert places.call_count == said  # each takes longer than a step of the membrane
        assert all(each.endswith("Take time.step = 0.1 or less") for each in told)
