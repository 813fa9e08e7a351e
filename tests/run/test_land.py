"""The problems of Land et al. 2015 (Proc. R. Soc. A 471: 20150641), beside what is published of them.

Bands are from self-convergence (docs/land.md): the distance from the converged value that was measured on
several meshes.
"""

import json
import shutil
import subprocess
import sys
from pathlib import Path

from myostrain.case.case import Case
from myostrain.case.running import changed_problem, run_case
from myostrain.cases import path
from myostrain.engine import MPI
from myostrain.geometry import Slab, UniformFibres, build
from myostrain.kinematics import Solid
from myostrain.materials import NeoHookean
from myostrain.mechanics import Mechanics, Supports
from myostrain.output import published as benchmark
from myostrain.output.figures.published import draw_benchmark

import numpy as np
import pytest

from reference import land_axisymmetric

MPIEXEC = shutil.which("mpiexec", path=str(Path(sys.executable).parent)) or shutil.which("mpiexec")
LINES = {"endocardium": 0.0, "midwall": 0.5, "epicardium": 1.0}


def bent():
    """A slab with a displacement that is quadratic, (0.1 z², 0, 0.02 x²), set and not solved for."""
    body = build(Slab(size=(2.0, 1.0, 1.0), spacing=0.5), UniformFibres(direction=(1.0, 0.0, 0.0)))
    mechanics = Mechanics(
        body,
        kinematics=Solid(),
        material=NeoHookean(mu=1.0),
        supports=Supports(fixed=["left"]),
    )
    mechanics.u.sub(0).interpolate(lambda x: np.stack([0.1 * x[2] ** 2, 0 * x[0], 0.02 * x[0] ** 2]))
    mechanics.u.x.scatter_forward()
    return mechanics


POINTS = np.array([[0.3, 0.4, 0.7], [2.0, 0.5, 1.0], [1.9, 0.2, -0.05]])


def test_positions_are_those_of_the_quadratic_displacement():
    """benchmark.positions, docstring: the displacement as it is, also a little outside of the mesh."""
    x, _, z = POINTS.T
    expected = POINTS + np.stack([0.1 * z**2, 0 * x, 0.02 * x**2], axis=1)
    np.testing.assert_allclose(benchmark.positions(bent(), POINTS), expected, rtol=0, atol=1e-13)


@pytest.mark.mpi
@pytest.mark.skipif(MPIEXEC is None, reason="there is no mpiexec beside this Python or on the path")
def test_positions_on_two_processes():
    """benchmark.positions, docstring: on every process, and the same as on one."""
    script = (
        "import sys; sys.path[:0] = ['tests', 'tests/run']\n"
        "from test_land import POINTS, bent\nfrom myostrain.output import published as benchmark\n"
        "from myostrain.engine import MPI\n"
        "found = benchmark.positions(bent(), POINTS)\n"
        "assert MPI.COMM_WORLD.size == 2\n"
        "sys.stdout.write(f'{found.tolist()}\\n')\n"
    )
    run = subprocess.run(
        [MPIEXEC, "-n", "2", sys.executable, "-c", script],
        check=False,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert run.returncode == 0, run.stderr
    lines = run.stdout.split("\n")[:2]
    for line in lines:
        found = np.array(json.loads(line))
        np.testing.assert_allclose(found, benchmark.positions(bent(), POINTS), rtol=0, atol=1e-13)


def wall(stretch, turn=0.0):
    """Points of the wall of a tube: 3 lines of 5 points, stretched by (radius, height), turned by a rate."""
    R, Z = np.meshgrid([1.0, 1.5, 2.0], np.linspace(0, 4, 5), indexing="ij")
    r, z, angle = stretch[0] * R, stretch[1] * Z, turn * Z
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=2)


def test_strains_of_a_tube():
    """benchmark.wall_strains, docstring: ℓ/L − 1 along, around and through a wall; a twist lengthens what
    runs along by the chord of its turn, and nothing else.
    """
    rest = wall((1.0, 1.0))
    longitudinal, circumferential, radial = benchmark.wall_strains(rest, wall((1.3, 0.9)))
    np.testing.assert_allclose(longitudinal, -0.1, atol=1e-14)
    np.testing.assert_allclose(circumferential, 0.3, atol=1e-14)
    np.testing.assert_allclose(radial, 0.3, atol=1e-14)
    longitudinal, circumferential, radial = benchmark.wall_strains(rest, wall((1.0, 1.0), turn=0.4))
    chord = np.sqrt(1 + (2 * np.array([1.0, 1.5, 2.0]) * np.sin(0.2)) ** 2) - 1
    np.testing.assert_allclose(longitudinal, np.broadcast_to(chord[:, None], (3, 5)), atol=1e-14)
    np.testing.assert_allclose(circumferential, 0, atol=1e-14)
    np.testing.assert_allclose(radial, 0, atol=1e-14)
    on_axis = rest * [0.0, 1.0, 1.0]
    assert np.isnan(benchmark.wall_strains(on_axis, rest)[1]).all()


def solved(name, *overrides):
    """What a shipped case gives beside the published numbers, with keys changed."""
    simulation = Case.from_file(path(name), overrides).simulation()
    simulation.run()
    return benchmark.find(name).measure(simulation.model.mechanics)


def test_problem_1_converges(tmp_path):
    """land-1: z of (10, 0.5, 1) is 4.169 on fine meshes, within the published 4.0 to 4.2.

    At spacing 1/2 it is 0.038 less (measured; docs/land.md has other meshes). And what a run
    leaves: results.json, lines.csv, the picture.
    """
    case = Case.from_file(path("land-1"), ["geometry.spacing=0.5"])
    results = run_case(case, tmp_path / "out", figures=False)
    found = results["benchmark"]["deflection"]
    assert results["metrics"]["deflection"] == found["value"]
    assert found["value"] - found["converged"] == pytest.approx(-0.0378, abs=0.004)
    assert found["within"]
    assert found["published"] == [4.0, 4.2]
    assert json.loads((tmp_path / "out" / "results.json").read_text())["benchmark"]["deflection"] == found
    line = np.genfromtxt(tmp_path / "out" / "lines.csv", delimiter=",", skip_header=1)[:, 1:]
    fine = benchmark.find("land-1").lines["centre"]
    np.testing.assert_array_equal(line[:, :3], fine.points)
    # Measured: 0.029 off at the tip, less elsewhere.
    np.testing.assert_allclose(line[:, 3:], fine.converged, rtol=0, atol=0.034)
    assert np.abs(line[-1, 3:] - fine.converged[-1]).max() > 0.014
    assert [file.name for file in draw_benchmark(tmp_path / "out", results)] == ["land.png"]


CHANGES = [
    (["geometry.spacing=1.0", "time.step=0.5", "mechanics.tolerance=1e-5"], []),
    (["mechanics.pressure.bottom=0.002"], ["mechanics.pressure.bottom"]),
    (["material.C=3.0"], ["material.C"]),
    (["geometry.size=[9.0, 1.0, 1.0]"], ["geometry.size"]),
    (["time.end=0.5"], ["time.end"]),
]


@pytest.mark.parametrize("overrides, keys", CHANGES)
def test_another_problem_is_not_judged(overrides, keys):
    """What the published numbers are of is the shipped problem; meshes, steps and solvers may differ."""
    assert list(changed_problem(Case.from_file(path("land-1"), overrides))) == keys


def test_results_say_that_nothing_was_compared(tmp_path):
    """``notes`` has the key; no number is judged."""
    changes = ["geometry.spacing=1.0", "mechanics.pressure.bottom=0.0001", "time.step=1.0"]
    results = run_case(Case.from_file(path("land-1"), changes), tmp_path / "out", figures=False)
    assert "benchmark" not in results
    assert "deflection" not in results["metrics"]
    assert "mechanics.pressure.bottom" in results["notes"]["benchmark"]
    assert not (tmp_path / "out" / "lines.csv").exists()


@pytest.mark.parametrize("number", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_converged_lines_are_those_of_the_axisymmetric_solution(number):
    """cases/land, docstring: the lines and quantities of problems 2 and 3 are what tests/reference gives."""
    known = benchmark.find(f"land-{number}")
    at = land_axisymmetric.solve(number, 3, 16, degree=2, step=0.1)
    s = np.linspace(0, 1, 11)
    for name, t in LINES.items():
        R, Z = land_axisymmetric.at_rest(t, s)
        np.testing.assert_allclose(known.lines[name].points, np.stack([R, 0 * R, Z], axis=1), atol=1e-4)
        r, turn, z = at(np.full(11, t), s).T
        found = np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)
        # Measured at 3 × 16 quadratic cells: 0.013 in problem 2; at the apex of problem 3 0.1.
        np.testing.assert_allclose(
            found, known.lines[name].converged, rtol=0, atol={2: 0.02, 3: 0.15}[number]
        )
        apex = known.quantities.get(f"apex_{name}")
        if apex is not None:
            assert apex.converged == pytest.approx(known.lines[name].converged[0, 2], abs=5e-3)
            assert apex.published[0] < apex.converged < apex.published[1]


def test_problem_2_on_a_coarse_mesh():
    """Land et al. 2015, problem 2: the apices within 0.15 % on wide, curved cells, as in docs/land.md.

    Straight cells gave −26.285, −28.047; dead in place of follower pressure, or no augmentation, would end
    elsewhere or not at all.
    """
    case = Case.from_file(path("land-2"), ["geometry.spacing=3.0"])
    results = case.simulation(MPI.COMM_SELF).run()
    converged = np.array([-26.613, -28.281])
    found = np.array([results["metrics"][f"apex_{wall}"] for wall in ("endocardium", "epicardium")])
    np.testing.assert_allclose(found, converged, atol=0.04)  # measured −26.608, −28.247
    assert results["metrics"]["volume_ratio"] == pytest.approx(1, abs=1e-5)


@pytest.mark.slow
def test_problem_3_as_shipped():
    """Land et al. 2015, problem 3: the apices of the shipped resolution, 3 % from the converged ones."""
    results = Case.from_file(path("land-3")).simulation(MPI.COMM_SELF).run()
    found = [results["metrics"][f"apex_{wall}"] for wall in ("endocardium", "epicardium")]
    np.testing.assert_allclose(found, [-11.952, -15.572], atol=0.05)
