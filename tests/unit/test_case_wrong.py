"""Case files that are wrong: one message that says what to do, random ones are in tests/fuzz."""

import datetime as dt
import math

from myostrain import Case, InputError

import pytest

from small_cases import ALONE, LINE, REMOVED, SHEET, changed, command_line, write_case

INF, NAN = math.inf, math.nan
IMPLICIT = changed(LINE, {"time.scheme": "implicit"})

# (a case, changes, words that the message must hold)
WRONG = [
    *((LINE, {f"{key}": value}, (key, words)) for key, values, words in (
        ("geometry.length", (0, -1.0), "greater than 0"),
        ("geometry.length", (INF, NAN), "finite"),
        ("geometry.length", ("long", "20", [20.0], True, {}), "number"),
        ("geometry.length", (REMOVED,), "missing; give a number > 0"),
        ("geometry.spacing", (0.0, -1), "greater than 0"),
        ("geometry.spacing", (1e-9, 1e-300), "cells"),
        ("geometry.kind", ("lin",), "'line'"),
        ("geometry.kind", (3, []), "ellipse, file, line, rectangle"),
        ("geometry.kind", (REMOVED,), "line, rectangle, ellipse, slab"),
        ("geometry", (5, "line", []), "section"),
        ("geometry", (REMOVED,), "missing"),
        ("mechanics", (REMOVED,), "missing"),
        ("time", (REMOVED,), "missing"),
        ("initial", (REMOVED,), "missing"),
        ("cell.alpha", (0, -0.1), "greater than 0"),
        ("cell.alpha", (1, 2.5), "less than 1"),
        ("cell.alpha", ("0.1", True, dt.date(2020, 1, 1)), "number"),
        ("cell.tau", (0, -0.2), "greater than 0"),
        ("cell.tau", (INF,), "finite"),
        ("cell.A", (-1,), "greater than or equal to 0"),
        ("cell.recovery", ("no", 1, 0.0), "boolean"),
        ("cell.model", ("FitzHugh",), "'FitzHughNagumo'"),
        ("potential.diffusivity", (0, -100.0, [100.0, -25.0]), "greater than 0"),
        ("potential.diffusivity", ("fast", True, [100.0, "x"]), "number"),
        ("potential.diffusivity", ([1, 2, 3], [1], []), "potential.diffusivity"),
        ("potential.balance", ("conserved", 1), "'conservative' or 'advective'"),
        ("initial.potential", (INF, NAN), "finite"),
        ("initial.potential", ("high", True), "number"),
        ("initial.potential", (4.0,), "singular"),
        ("initial.center", ([], [1, 2, 3, 4]), "coordinate"),
        ("initial.center", (3.0, "middle"), "initial.center"),
        ("initial.radius", (0, -5.0), "greater than 0"),
        ("activation.beta", (-0.1,), "greater than or equal to 0"),
        ("activation.beta", (1, 1.5), "less than 1"),
        ("activation.beta", (0.5, 0.9), "ill-posed"),
        ("activation.law", ("hill",), "proportional"),
        ("activation.deformation", ("fiber",), "'fibre'"),
        ("material.mu", (0, -1), "greater than 0"),
        ("material.model", ("Sprng",), "'Spring'"),
        ("material.model", ("NeoHookean",), "Spring"),
        ("mechanics.kinematics", ("plane-strss",), "'plane-stress'"),
        ("circulation", ({},), "circulation.kind: missing"),
        ("circulation", ({"kind": "volume", "volume": -1.0},), "circulation.volume: -1 is not a volume"),
        ("circulation", ({"kind": "volume", "volume": 1.0, "preload": 1.0},), "circulation.preload"),
        ("circulation", ({"kind": "isovolumetric", "beats": 0},), "greater than or equal to 1"),
        ("mechanics.kinematics", (REMOVED,), "line, plane-stress, plane-strain"),
        ("mechanics.robin", (-1,), "greater than or equal to 0"),
        ("mechanics.robin", (NAN, INF), "finite"),
        ("mechanics.relaxation_time", (-1,), "greater than or equal to 0"),
        ("mechanics.fixed", (["lft"],), "'left'"),
        ("mechanics.fixed", ("left", 3), "mechanics.fixed"),
        ("mechanics.robin_boundary", (["rihgt"],), "'right'"),
        ("mechanics.every", (0, -2), "greater than or equal to 1"),
        ("mechanics.every", (1.5, "two", True), "integer"),
        ("mechanics.tolerance", (0.0,), "greater than 0"),
        ("mechanics.constraint", ("elastic",), "line has no constraint"),
        ("mechanics.imposed_stretch", ({"value": 0.0}, {"value": -1}), "greater than 0"),
        ("mechanics.imposed_stretch", ({"value": 1.0, "until": 0}, {"until": NAN}), "positive number or inf"),
        ("mechanics.imposed_stretch", ({"valeu": 1.0},), "'value'"),
        ("mechanics.imposed_stretch", ({"value": [1.0, 1.0]}, {"value": []}, 1.0), "imposed_stretch"),
        ("time.step", (0, -1e-3), "greater than 0"),
        ("time.step", (INF, NAN), "finite"),
        ("time.step", ("fast", "1e-3", True), "number"),
        ("time.step", (0.02,), "time.end"),
        ("time.step", (REMOVED,), "missing"),
        ("time.end", (0, -1.0), "greater than 0"),
        ("time.end", (INF,), "finite"),
        ("time.scheme", ("euler", 2), "implicit, second-order, staggered"),
        ("probes.a", ([30.0], [-0.001]), "outside"),
        ("probes.a", ([NAN], [INF], []), "finite"),
        ("probes.a", (5.0, "x", ["x"], [[1.0]], {}), "coordinates"),
        ("output.every", (0, -1), "greater than 0"),
        ("output.fields", (["potental"],), "'potential'"),
        ("output.fields", ("potential",), "output.fields"),
        ("output.rigid_twin", ("maybe", 1), "boolean"),
        ("solver.potential.ksp_typ", ("cg",), "solver.potential.ksp_typ"),
        ("solver.potential.ksp_rtol", ([1.0], NAN, INF, -1.0, True, "small"), "give a finite number"),
        ("solver.potential.snes_rtol", (1.0,), "ksp_"),
        ("solver.potential", (1,), "PETSc options"),
    ) for value in values),
    (LINE, {"initial.center": [1000.0]}, ("initial.", "no node", "1000")),
    (LINE, {"solver.potental": {}}, ("solver.potental", "'potential'")),
    (LINE, {"solver.potential": {"ksp_type": "cgg"}}, ("solver.potential", "ksp_type", "cgg")),
    (LINE, {"solver.potential": {"ksp_max_it": "many"}}, ("solver.potential", "ksp_max_it", "many")),
    (LINE, {"time.every": 2}, ("time.every", "mechanics.every")),
    (IMPLICIT, {"mechanics.every": 5}, ("mechanics.every", "staggered")),
    (IMPLICIT, {"time.max_iterations": 0}, ("time.max_iterations", "greater than or equal to 1")),
    *((SHEET, {f"{key}": value}, (key, words)) for key, values, words in (
        ("fibres", (REMOVED, {}), "fibres.direction"),
        ("fibres.direction", ([0, 0], [1.0, 0.0, 0.0], [NAN, 1.0], []), "fibres.direction"),
        ("fibres.direction", (1.0, "x", [True, False]), "fibres.direction"),
        ("fibres.regions", ({"apex": [1, 0]},), "no named regions"),
        ("geometry.size", ([20.0, 0.0], [20.0, -1.0]), "greater than 0"),
        ("geometry.size", ([20.0], 20.0, [1, 2, 3]), "geometry.size"),
        ("geometry.size", (REMOVED,), "missing; give a list of 2 numbers > 0"),
        ("geometry.spacing", (1e-6, 1e-200, 1e-300), "cells"),
        ("geometry.distortion", (0.9,), "less than or equal to 0.5"),
        ("mechanics.kinematics", ("line",), "dimension"),
        ("mechanics.constraint", ("elastc",), "'elastic'"),
        ("mechanics.robin_boundary", ([], ["boundry"]), "mechanics.robin_boundary"),
        ("mechanics.fixed", (["left"],), "known: boundary"),
        ("mechanics.imposed_stretch", ({"value": [1.0, 1.0, 1.0]},), "mechanics.imposed_stretch"),
        ("material.model", ("Spring",), "NeoHookean"),
        ("initial.center", ([10.0],), "coordinates"),
        ("initial.potential", (4.0,), "singular"),
        ("probes.a", ([10.0],), "coordinates"),
        ("probes.a", ([0.0, 0.0],), "outside"),
        ("activation.beta", (1.0,), "less than 1"),
    ) for value in values),
    (SHEET, {"activation.transmural_between": ["a", "b"]}, ("activation.transmural_between: ", "no effect")),
    (SHEET, {"geometry": {"kind": "file"}}, ("geometry.path", "missing; give a path")),
    (SHEET, {"geometry": {"kind": "file", "path": 3}}, ("geometry.path",)),
    (SHEET, {"geometry": {"kind": "file", "path": "none.msh"}}, ("geometry.path", "none.msh")),
    (SHEET, {"material": {"model": "MooneyRivlin", "mu_2": -1.0}}, ("material.mu_2", "greater than")),
]  # fmt: skip


def _label(entry):
    changes = ", ".join(f"{k}={'removed' if v is REMOVED else v}" for k, v in entry[1].items())
    return f"{'line' if entry[0]['geometry']['kind'] == 'line' else 'sheet'}:{changes}"


@pytest.mark.parametrize("case, changes, words", WRONG, ids=map(_label, WRONG))
def test_wrong_value_gets_one_message_and_nothing_is_written(tmp_path, case, changes, words):
    """Requirements, "Bad input": one clear message (key, what is allowed), exit status 2, nothing written."""
    out = tmp_path / "out"
    done = command_line("run", write_case(tmp_path / "case.toml", changed(case, changes)), "--out", out)
    assert done.status == 2, done.err
    message = done.err.strip()
    assert message.startswith("myostrain: ")
    assert "\n" not in message
    assert "ArgsKwargs" not in message
    assert all(word in message for word in words), message
    assert not out.exists()


@pytest.mark.parametrize("kind", ["line", "rectangle", "ellipse"])
def test_absurd_spacing_is_no_crash(kind):
    """Too fine a mesh is refused before it is made; too coarse a spacing gives the coarsest mesh."""
    size = {"length": 20.0} if kind == "line" else {"size": [20.0, 24.0]}
    base = LINE if kind == "line" else SHEET
    fine, coarse = (
        changed(base, {"geometry": {"kind": kind, "spacing": spacing, **size}}) for spacing in (1e-200, 1e200)
    )
    assert Case.from_dict(coarse).geometry.mesh(ALONE).mesh.topology.index_map(0).size_global < 20
    with pytest.raises(InputError, match=r"geometry\.spacing.* cells"):
        Case.from_dict(fine).geometry.mesh(ALONE)
