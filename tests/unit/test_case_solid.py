"""Case files of solids: what their keys do, through the command line; wrong ones are refused."""

import csv
import json
import tomllib

import myostrain as ms
from myostrain import Case, InputError
from myostrain.activation import ActiveStress, FibreTension, Orthotropic, Proportional

import numpy as np
import pytest

from small_cases import ALONE, SOLID, STATIC, changed, command_line, write_case


def run(tmp_path, case, name="run"):
    """What results.json holds, and the folder."""
    out = tmp_path / name
    done = command_line("run", write_case(tmp_path / f"{name}.toml", case), "--out", out, "--quiet")
    assert done.status == 0, done.err
    return json.loads((out / "results.json").read_text()), out


def column(path, name):
    with path.open() as stream:
        return np.array([float(row[name]) for row in csv.DictReader(stream)])


def test_a_coupled_slab_from_the_command_line(tmp_path):
    """Interface: results, probes, measures and pictures of a solid; its volume is kept."""
    results, out = run(tmp_path, SOLID)
    assert results["completed"] is True
    assert results["cells"] == 60
    assert results["unknowns"]["mechanics"] == 3 * 11 * 5 * 3 + 6 * 3 * 2
    assert results["metrics"]["volume_ratio"] == pytest.approx(1, abs=1e-8)
    assert results["metrics"]["fibre_shortening"] > 0.02
    assert column(out / "measures.csv", "time")[-1] == pytest.approx(0.03)
    assert {"potential.png", "stress.png", "fibres.png"} <= {p.name for p in (out / "figures").iterdir()}


def test_a_static_case_follows_its_loads(tmp_path):
    """[drive]: nothing is solved for the potential; v and the pressure are those of each time."""
    results, out = run(tmp_path, STATIC)
    assert results["solver"]["potential"] == {}
    assert results["unknowns"]["potential"] == 36
    np.testing.assert_allclose(column(out / "probes.csv", "a_potential"), np.linspace(0, 1, 5), atol=1e-12)
    found = column(out / "probes.csv", "b_displacement_z")
    assert (np.diff(found) > 0).all()
    parameters = tomllib.loads((out / "case.toml").read_text())
    assert "cell" not in parameters
    assert "potential" not in parameters
    assert parameters["mechanics"]["pressure"] == {"bottom": [[0.0, 0.0], [1.0, 0.02]]}


def test_the_case_builds_what_it_says():
    """The keys of a case are the arguments of Mechanics: the same displacement by either way."""
    case = Case.from_dict(
        changed(
            STATIC,
            {
                "activation": {"law": "proportional", "beta": 0.2, "deformation": "orthotropic", "kappa": 0.3}
                | {"transmural": [0.5, 1.5], "transmural_between": ["bottom", "top"]},
                "drive.potential": 0.6,
                "fibres.sheet": [0.0, 0.0, 1.0],
                "mechanics": {
                    "kinematics": "solid",
                    "constraint": "elastic",
                    "bulk_modulus": 50.0,
                    "robin": {"left": 0.7},
                    "robin_normal": {"front": 0.2},
                    "sliding": ["bottom"],
                    "pressure": {"right": 0.1},
                    "tolerance": 1e-10,
                },
            },
        )
    )
    model = case.build(ALONE)
    body = ms.build(
        ms.geometry.Slab(size=(5.0, 2.0, 1.0)),
        ms.UniformFibres(direction=(1.0, 0.0, 0.0), sheet=(0.0, 0.0, 1.0)),
        ALONE,
    )
    mechanics = ms.Mechanics(
        body,
        kinematics=ms.kinematics.Solid(constraint="elastic", bulk_modulus=50.0),
        material=ms.materials.NeoHookean(mu=1.0),
        active=Orthotropic(kappa=0.3),
        supports=ms.Supports(robin={"left": 0.7}, robin_normal={"front": 0.2}, sliding=["bottom"]),
        loads=ms.Loads(pressure={"right": 0.1}),
    )
    given = ms.GivenPotential(body, ms.Drive(potential=0.6))
    activity = ms.geometry.transmural(body, (0.5, 1.5), ("bottom", "top"))
    by_hand = ms.Electromechanics(given, mechanics, law=Proportional(beta=0.2), activity=activity)
    model.start()
    by_hand.start()
    assert np.abs(mechanics.u.x.array).max() > 0.1
    np.testing.assert_allclose(model.mechanics.u.x.array, mechanics.u.x.array, rtol=0, atol=1e-8)


def test_active_stress_takes_the_place_of_the_law():
    """[activation] law = "active-stress": a tension, and no active strain; the record says its keys."""
    case = Case.from_dict(changed(STATIC, {"activation.transverse": 0.2}))
    assert (case.law, case.active) == (ActiveStress(tension=0.3), FibreTension(transverse=0.2))
    assert case.parameters["activation"] == {"law": "active-stress", "tension": 0.3, "transverse": 0.2}
    model = case.build(ALONE)
    model.start()
    model.step(0.25)
    assert model.mechanics.yields == "tension"
    np.testing.assert_allclose(model.mechanics.activation.x.array, 0.25 * 0.3, rtol=1e-14)


def test_a_whole_endocardium_may_begin():
    """initial.boundary: the nodes of these parts have the potential, all others rest."""
    bump = {"potential": 0.8, "boundary": ["top", "right"]}
    v = Case.from_dict(changed(SOLID, {"initial": bump})).build(ALONE).potential.v
    x = v.function_space.tabulate_dof_coordinates()
    held = (np.abs(x[:, 2] - 1) < 1e-9) | (np.abs(x[:, 0] - 5) < 1e-9)
    np.testing.assert_array_equal(v.x.array, np.where(held, 0.8, 0.0))


@pytest.mark.parametrize(
    "kind, extra",
    [
        ("ventricle", {"fibres": {"kind": "ellipsoidal", "helix": [60.0, -60.0]}}),
        ("ventricle", {"fibres": {"kind": "uniform", "direction": [1.0, 0.0, 0.0]}}),
        ("biventricle", {"fibres": {"kind": "uniform", "direction": [1.0, 0.0, 0.0]}, "spacing": 12.0}),
    ],
)
def test_words_of_geometry_and_fibres(kind, extra):
    """geometry.kind and fibres.kind choose; the resolved case holds the word and reads back the same."""
    extra = dict(extra)
    geometry = {"kind": kind, "spacing": extra.pop("spacing", 6.0)}
    sections = {"geometry": geometry, "mechanics": {"kinematics": "solid", "fixed": ["base"]}, "probes": {}}
    case = Case.from_dict(changed(STATIC, {**sections, **extra}))
    assert case.parameters["fibres"]["kind"] == extra["fibres"]["kind"]
    assert Case.from_dict(tomllib.loads(case.to_toml())).to_toml() == case.to_toml()
    case.build(ALONE).mechanics.start()


def test_units_are_for_the_record(tmp_path):
    """[units]: no number changes, the record has them; an unknown quantity is refused."""
    with_units = changed(STATIC, {"units": {"length": "mm", "stress": "kPa"}})
    ours, plain = (run(tmp_path, case, name)[0] for name, case in (("mm", with_units), ("none", STATIC)))
    assert ours["metrics"] == plain["metrics"]
    assert ours["parameters"]["units"] == {"length": "mm", "stress": "kPa"}


WRONG = [
    (SOLID, {"drive": {"potential": 1.0}}, "cell", "leave this section out"),
    (STATIC, {"drive": {"potential": [[1.0, 0.0], [0.5, 1.0]]}}, "drive.potential", "ascending"),
    (STATIC, {"drive": {"potental": 1.0}}, "drive.potental", "potential"),
    (STATIC, {"activation.deformation": "fibre"}, "activation.deformation", "leave one out"),
    (STATIC, {"activation.tention": 1.0}, "activation.tention", "tension"),
    (SOLID, {"activation.kappa": 1.0}, "activation.kappa", "beta"),
    (SOLID, {"activation.deformation": "transverse"}, "activation.deformation", "transversely-isotropic"),
    (SOLID, {"mechanics.pressure": {"right": "much"}}, "mechanics.pressure", "number"),
    (
        SOLID,
        {"mechanics.pressure": {"right": [[0.0, 1.0], [0.0, 2.0]]}},
        "mechanics.pressure.right",
        "ascend",
    ),
    (SOLID, {"mechanics.robin": {"left": -1.0}}, "mechanics.robin", "0"),
    (SOLID, {"mechanics.ellipticity": "yes"}, "mechanics.ellipticity", "warn"),
    (SOLID, {"mechanics.bulk_modulus": 0.0}, "mechanics.bulk_modulus", "greater than 0"),
    (SOLID, {"fibres.kind": "ellipsoid"}, "fibres.kind", "ellipsoidal"),
    (SOLID, {"fibres.kind": "file"}, "fibres.direction", "path"),
    (
        SOLID,
        {"initial": {"boundary": ["top"], "potential": 1.0, "radius": 2.0}},
        "initial",
        "give one of center and radius, box, boundary, region, transmural, not center and radius and",
    ),
    (
        SOLID,
        {"mechanics.bulk_modulus": 9.0, "mechanics.augmentation": 9.0},
        "mechanics.augmentation",
        "give it or",
    ),
    (SOLID, {"activation.transmural_between": ["bottom", "top"]}, "activation", "without transmural"),
    (STATIC, {"solver": {"potential": {"ksp_type": "cg"}}}, "solver.potential", "leave it out"),
    (SOLID, {"units": {"lenght": "mm"}}, "units.lenght", "length"),
]


@pytest.mark.parametrize("case, changes, key, words", WRONG)
def test_wrong_keys_of_solids(case, changes, key, words):
    """InputError names the key, what is allowed, the nearest known one (the interface)."""
    with pytest.raises(InputError) as caught:
        Case.from_dict(changed(case, changes))
    assert caught.value.key.startswith(key)
    assert words in str(caught.value)


def test_paths_are_relative_to_the_case_file(tmp_path, monkeypatch):
    """FileFibres, docstring: in a case file, fibres.path is relative to its folder, wherever one is."""
    (tmp_path / "cases").mkdir()
    file = write_case(
        tmp_path / "cases" / "a.toml", changed(SOLID, {"fibres": {"kind": "file", "path": "f.npz"}})
    )
    monkeypatch.chdir(tmp_path)
    assert Case.from_file(file).fibres.path == tmp_path / "cases" / "f.npz"


def test_a_factor_on_the_activation_counts():
    """Electromechanics: a transmural factor that makes the balance ill-posed is refused as β would be."""
    changes = {
        "mechanics.constraint": "elastic",
        "mechanics.every": 1,
        "activation.transmural": [2.0, 1.0],
        "activation.transmural_between": ["bottom", "top"],
    }
    with pytest.raises(InputError, match="ill-posed"):
        Case.from_dict(changed(SOLID, changes)).build(ALONE)
    Case.from_dict(changed(SOLID, {**changes, "activation.transmural": [1.5, 1.0]})).build(ALONE)


@pytest.mark.parametrize("beta", [0.45, 0.55])
def test_a_nearly_incompressible_body_does_not_follow_the_potential(beta):
    """J ≈ 1 whatever γ where the constraint is total: nothing is ill-posed, nothing iterated."""
    case = Case.from_dict(changed(SOLID, {"mechanics.bulk_modulus": 50.0, "activation.beta": beta}))
    assert case.build(ALONE).feedback == 0.0
