"""The scripts that newcomers copy: they run, do what they say, and are those of the README."""

import contextlib
import io
import re
from pathlib import Path

import myostrain as ms
from myostrain import Case, cases

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize, minimize_scalar

from small_cases import ALONE

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))


def run(name, **numbers):
    """Run an example in the present folder, with other numbers for some of its keyword arguments.

    Returns:
        Its names, and what it prints.
    """
    text = (ROOT / "examples" / f"{name}.py").read_text(encoding="utf-8")
    for key, value in numbers.items():
        text, found = re.subn(rf"\b{key}=[\d.e+-]+", f"{key}={value}", text)
        assert found == 1, f"{name}.py has no {key}= that is a number"
    names, out = {"__name__": "__main__"}, io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(text, f"{name}.py", "exec"), names)
    return names, out.getvalue()


def test_readme_script_is_the_example():
    """Requirements, "Python": "that script is in the README and in examples/, and a test runs it"."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"<!-- sheet-script -->\n```python\n(.*?)```\n<!-- /sheet-script -->", readme, re.S)
    assert shown == (ROOT / "examples" / "sheet.py").read_text(encoding="utf-8")


def test_sheet_is_about_fifteen_lines():
    """Requirements: "a coupled sheet in about fifteen lines over the public names"."""
    lines = (ROOT / "examples" / "sheet.py").read_text(encoding="utf-8").splitlines()
    code = [line for line in lines if line.strip() and not line.startswith(('"""', "import"))]
    assert len(code) <= 18
    assert [line for line in lines if "import" in line] == ["import myostrain as ms"]
    assert not re.search(r"\._", "\n".join(lines))  # public names only


def test_sheet_is_the_shipped_case(tmp_path, monkeypatch):
    """Its docstring: the paper's figure 3, on a coarser mesh; the same numbers as the case on that mesh."""
    monkeypatch.chdir(tmp_path)
    names, out = run("sheet", end=0.1)
    results = names["results"]
    settings = (
        "geometry.spacing=2.0",
        "initial.sampling=nodal",  # as in a script that does not ask for anything else
        "mechanics.tolerance=1e-8",
        "time.end=0.1",
        "probes={near=[80.0, 50.0], far=[50.0, 130.0]}",
    )
    case = Case.from_file(cases.path("sheet-2d"), settings)
    expected = case.simulation(ALONE).run()
    assert (results["cells"], results["steps"]) == (expected["cells"], expected["steps"])
    for name in ("potential_max", "potential_min", "amount", "displacement_max"):
        assert results["metrics"][name] == pytest.approx(expected["metrics"][name], rel=1e-5), name
    assert str(results["metrics"]) in out
    written = {path.name for path in (tmp_path / "runs" / "sheet").iterdir()}
    assert written >= {"results.json", "probes.csv", "fields.bp", "snapshots"}
    run("sheet", end=0.01)  # again, over the results of the first time


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """The names of the script with objects of its own, run for a moment."""
    with contextlib.chdir(tmp_path_factory.mktemp("own")):
        names, out = run("own_material", end=1)
        assert Path("runs/own-material/results.json").exists()
    assert "displacement_max" in out
    assert names["model"].time == 1.0
    assert 0.01 < names["model"].mechanics.displacement().x.array.max() < 1.0
    return names


@pytest.mark.parametrize("v", [0.3, 1.0])
def test_own_material_and_law(own, v):
    """The script's W and γ by its formulas: a free, uniformly active sheet has the stretch of least energy.

    F = diag(λ, λ^−½, λ^−½) along the fibre in plane stress with J = 1; Fe = F Fo⁻¹, Fo = 1 + γ n⊗n.
    """
    body = ms.build(ms.geometry.Rectangle(size=(2, 1)), ms.UniformFibres(direction=(1, 0)), ALONE)
    mechanics = ms.Mechanics(
        body,
        kinematics=ms.kinematics.PlaneStress(),
        material=own["FibreReinforced"](mu=1.5, kappa=4.0),
    )
    law = own["Saturating"](beta=0.25, half=0.3)
    model = ms.Electromechanics(ms.GivenPotential(body, ms.Drive(potential=v)), mechanics, law=law)
    model.start()
    active = 1 - 0.25 * v**2 / (v**2 + 0.09)

    def energy(stretch):
        squared = (stretch / active) ** 2
        return 1.5 / 2 * (squared + 2 / stretch - 3) + 4.0 / 4 * (squared - 1) ** 2

    expected = minimize_scalar(energy, bounds=(0.5, 1.2), method="bounded", options={"xatol": 1e-10}).x
    X = body.mesh.geometry.x[:, :2]
    ends = (X + mechanics.displacement().x.array.reshape(-1, 2))[
        (X[:, 1] == 0.0) & np.isin(X[:, 0], (0.0, 2.0))
    ]
    found = np.linalg.norm(ends[1] - ends[0]) / 2.0  # a free body may turn
    assert found == pytest.approx(expected, abs=1e-7)  # measured 5e-9
    assert found < 0.99


def test_own_membrane(own):
    """The script's membrane is Aliev's and Panfilov's (1996), integrated at a point by scipy.

    dv/dt = −k v (v − a)(v − 1) − v r, dr/dt = (ε + μ₁ r/(μ₂ + v)) (−r − k v (v − a − 1)).
    """

    def rates(_, y):
        v, r = y
        return (
            -8 * v * (v - 0.15) * (v - 1) - v * r,
            (0.002 + 0.2 * r / (0.3 + v)) * (-r - 8 * v * (v - 0.15 - 1)),
        )

    body = ms.build(ms.geometry.Line(length=2), comm=ALONE)
    potential = ms.Potential(body, membrane=own["AlievPanfilov"](), diffusivity=1.0)
    potential.v.x.array[:] = 0.4
    model = ms.Electromechanics(potential)
    ms.Simulation(model, step=5e-3, end=10.0).run()
    expected = solve_ivp(rates, (0, 10.0), (0.4, 0.0), rtol=1e-10, atol=1e-12).y[:, -1]
    # Measured 3e-6, of second order in the time step.
    np.testing.assert_allclose(potential.v.x.array, expected[0], rtol=0, atol=1e-5)
    np.testing.assert_allclose(potential.field_values()["recovery"], expected[1], rtol=0, atol=1e-5)
    assert expected[1] > 0.05


@pytest.fixture(scope="module")
def solid(tmp_path_factory):
    """The names of the script of a solid with objects of its own, run for a moment."""
    with contextlib.chdir(tmp_path_factory.mktemp("solid")):
        names, out = run("own_solid", end=0.016)
        assert Path("runs/own-solid/measures.csv").exists()
    assert "fibre_shortening" in out
    return names


@pytest.mark.parametrize("v", [0.4, 1.0])
def test_own_material_and_deformation_of_a_solid(solid, v):
    """The script's W and Fo by its formulas: a uniformly active block has the stretches of least energy.

    F = diag(λ₁, λ₂, 1/(λ₁ λ₂)) along f0, s0, n0 where J = 1; Fe = F Fo⁻¹, det Fo = 1.
    """
    fibres = ms.UniformFibres(direction=(1, 0, 0), sheet=(0, 1, 0))
    body = ms.build(ms.geometry.Slab(size=(2, 1, 1)), fibres, ALONE)
    mechanics = ms.Mechanics(
        body,
        kinematics=ms.kinematics.Solid(),
        material=solid["Reinforced"](mu=1.5, kappa_f=3.0, kappa_s=0.7),
        active=solid["Biaxial"](share=0.4),
        supports=ms.Supports(sliding=["left", "front", "bottom"]),
        loads=ms.Loads(pressure={"right": -0.5}),  # without a pull Fe = 1, whatever W is
    )
    mechanics.activation.x.array[:] = -0.25 * v
    mechanics.start()
    along, sheet = 1 - 0.25 * v, 1 - 0.4 * 0.25 * v
    active = np.array([along, sheet, 1 / (along * sheet)])

    def energy(stretch):
        squared = (np.array([*stretch, 1 / np.prod(stretch)]) / active) ** 2
        W = 1.5 / 2 * (squared.sum() - 3)
        W += 3.0 / 4 * (squared[0] - 1) ** 2 + 0.7 / 4 * (squared[1] - 1) ** 2
        # The pull's work on a block of volume one, over the sides' present area 1/λ₁: 0.5 ∫ dλ₁/λ₁.
        return W - 0.5 * np.log(stretch[0])

    expected = minimize(energy, active[:2], method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-14}).x
    u = mechanics.displacement()
    X = u.function_space.tabulate_dof_coordinates()
    corner = X.sum(axis=1).argmax()
    found = 1 + u.x.array.reshape(-1, 3)[corner] / X[corner]
    np.testing.assert_allclose(found[:2], expected, rtol=0, atol=3e-8)  # measured 3.5e-9
    assert found[0] > 1.02 * active[0]


def test_active_strain_and_active_stress(tmp_path, monkeypatch):
    """The script's stretches by the closed form of its block: Guccione's W, J = 1, free sides.

    With Fo = 1 + γ n⊗n, a = 1 + γ, the energy along the fibre is a W(λ/a, λ^−½) + T/2 (λ² − 1), and the
    Cauchy stress, λ times its derivative, is the pull: none, then 5 kPa.
    """
    monkeypatch.chdir(tmp_path)
    names, out = run("strain_and_stress")

    def stress(stretch, active, tension):
        def energy(s):
            along, across = ((s / active) ** 2 - 1) / 2, (1 / s - 1) / 2
            W = 2.0 / 2 * (np.exp(8.0 * along**2 + 2.0 * 2 * across**2) - 1)
            return active * W + tension / 2 * (s**2 - 1)

        return stretch * (energy(stretch + 1e-6) - energy(stretch - 1e-6)) / 2e-6

    for name, given in {"active strain": (0.85, 0.0), "active stress": (1.0, 2.83)}.items():
        for found, pull in zip(names["stretches"][name], (0.0, 5.0), strict=True):
            expected = brentq(lambda s, *g: stress(s, *g) - pull, 0.6, 1.4, args=given)  # noqa: B023
            assert found == pytest.approx(expected, abs=1e-8), name  # measured 5e-12 when free
            assert f"{found:.4f}" in out


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sheet", "own_material", "own_solid"])
def test_example_as_it_is(tmp_path, monkeypatch, name):
    """Each example of a wave, as it is: it passes both probes at its membrane's speed, and moves the body."""
    monkeypatch.chdir(tmp_path)
    results = run(name)[0]["results"]
    low, high = {"sheet": (42.0, 52.0), "own_material": (1.1, 1.4), "own_solid": (55.0, 68.0)}[name]
    assert low < results["metrics"]["celerity"] < high  # measured 49.0, 1.22 and 61.3
    assert results["metrics"]["displacement_max"] > 0.5


def test_every_example_is_tested():
    """No script in examples/ that nothing runs."""
    assert {path.stem for path in EXAMPLES} == {"sheet", "own_material", "own_solid", "strain_and_stress"}
