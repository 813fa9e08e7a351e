"""The nonlinear solver: what it finds, what it costs, what it says when it fails; the user's PETSc
options.
"""

import subprocess
import sys
import time

import myostrain as ms
import myostrain.mechanics.equilibrium
from myostrain.engine import MPI, PETSc, compile_form, fem
from myostrain.kinematics import Line, PlaneStrain, PlaneStress
from myostrain.materials import NeoHookean, Spring
from myostrain.solvers.linear import make_ksp
from myostrain.solvers.newton import ChordNewton
from myostrain.solvers.timing import timed

import numpy as np
import pytest
import ufl
from dolfinx import mesh as dmesh

import coupled
from mechanics_tools import GivenStrain, Recorded, described, random_activation, sheet

GMRES = {"ksp_type": "gmres", "pc_type": "jacobi", "ksp_rtol": 1e-8}


def make(kinematic=None, **parts):
    """A sheet on springs, or a line fixed at its left end."""
    if isinstance(kinematic, Line):
        body = ms.build(ms.geometry.Line(length=10.0, spacing=1.0))
        parts = dict(material=Spring(), fixed=["left"]) | parts
    else:
        body, parts = sheet(size=(2.0, 2.0)), dict(material=NeoHookean(), robin=1.0) | parts
    return ms.Mechanics(
        body,
        kinematics=kinematic or PlaneStress(),
        **described(parts),
    )


def solved_afresh(mechanics, gamma):
    """The unknown for γ from the reference state, with a fresh tangent in every solve."""
    mechanics.activation.x.array[:] = gamma
    mechanics.u.x.array[:] = 0.0
    for _ in range(2):
        mechanics.solver.forget()
        mechanics.solver.solve()
    return mechanics.u.x.array.copy()


class Cubic:
    """−u″ + u³ = f with f constant and u = 0 at the ends, on a ChordNewton of its own."""

    def __init__(self, f=1.0, **parts):
        mesh = dmesh.create_interval(MPI.COMM_SELF, 12, [0.0, 1.0])
        space = fem.functionspace(mesh, ("Lagrange", 1))
        self.f, self.u = fem.Constant(mesh, f), fem.Function(space)
        w = ufl.TestFunction(space)
        ends = fem.locate_dofs_geometrical(space, lambda x: np.isclose(x[0] * (1 - x[0]), 0))
        conditions = [fem.dirichletbc(0.0, ends, space)]
        form = (ufl.dot(ufl.grad(self.u), ufl.grad(w)) + self.u**3 * w - self.f * w) * ufl.dx
        self.solver = ChordNewton(form, self.u, conditions, **parts)


# The tolerance, "largest error of the displacement, relative to the body's extent" (Mechanics).


@pytest.mark.parametrize("kinematic", [PlaneStress(), PlaneStrain(constraint="elastic"), Line()], ids=str)
def test_a_kept_tangent_changes_nothing(kinematic):
    """ChordNewton: "an old tangent costs iterations, never accuracy". From small changes of γ
    to large ones and back, every solution is within the tolerance (times the body's extent) of one with
    fresh tangents.
    """
    mechanics, fresh = make(kinematic), make(kinematic)
    random_activation(mechanics)
    pattern = mechanics.activation.x.array.copy()
    mechanics.activation.x.array[:] = 0.0
    mechanics.start()
    measured = np.arange(len(mechanics.u.x.array))
    if mechanics.kinematics.has_pressure:
        measured = np.asarray(mechanics.u.function_space.sub(0).collapse()[1])
    errors = {}
    for number, scale in enumerate([1e-7, 1e-5, 1e-4, 1e-2, 0.1, 1.0, 1e-3, 1.0, 0.0, 1.0], start=1):
        mechanics.activation.x.array[:] = scale * pattern
        mechanics.solve(float(number), predict=False)
        error = mechanics.u.x.array - solved_afresh(fresh, scale * pattern)
        errors[number, scale] = np.abs(error[measured]).max() / mechanics.size
    # Ten times the tolerance, which is compared with an estimate; measured 4e-10 with a pressure.
    assert max(errors.values()) < 1e-9, errors


def test_the_tolerance_is_relative_to_the_extent():
    """Mechanics: the tolerance is relative to the body's extent, so that units do not matter."""
    counts = []
    for scale in (1e-3, 1.0, 1e3):
        body = sheet(size=(2.0 * scale, 2.0 * scale), spacing=0.25 * scale)
        mechanics = ms.Mechanics(
            body,
            kinematics=PlaneStress(),
            material=NeoHookean(),
            supports=ms.Supports(robin=1 / scale),
        )
        random_activation(mechanics)
        mechanics.start()
        counts.append((mechanics.solver.counters.as_dict(), mechanics.u.x.array / scale))
    for count, u in counts[1:]:
        assert count == counts[0][0]
        np.testing.assert_allclose(u, counts[0][1], rtol=0, atol=1e-10 * np.sqrt(8))


def test_a_looser_tolerance_costs_less_and_errs_more():
    """Mechanics: ``tolerance`` is the user's; what it buys is measured."""
    exact = make(tolerance=1e-13)
    random_activation(exact)
    exact.start()
    errors, costs = [], []
    for tolerance in (1e-4, 1e-7, 1e-10):
        mechanics = make(tolerance=tolerance)
        random_activation(mechanics)
        mechanics.start()
        errors.append(np.abs(mechanics.u.x.array - exact.u.x.array).max() / mechanics.size)
        costs.append(mechanics.solver.counters.newton)
        assert errors[-1] < 2 * tolerance
    assert costs[0] < costs[2]
    assert costs[1] <= costs[2]
    assert errors[0] > 1e-9


# Counters.


def test_counters_count():
    """Interface, results.json: solves, Newton corrections, linear solves, factorizations are what was
    done. On the line with the activation unchanged everything is linear: one correction, confirmed by a
    second that is nought.
    """
    mechanics = make(Line())
    counters = mechanics.solver.counters
    assert set(counters.as_dict()) >= {"solves", "newton", "linear", "factorizations"}
    assert not any(counters.as_dict().values())
    mechanics.activation.x.array[:] = -0.3
    mechanics.start()
    assert (counters.solves, counters.newton, counters.factorizations) == (1, 1, 1)
    assert 1 <= counters.linear <= 2
    mechanics.solve(1.0)  # nothing has changed: the kept factorization is enough
    assert (counters.solves, counters.newton, counters.factorizations) == (2, 2, 1)
    mechanics.solver.forget()
    mechanics.solve(2.0)
    assert (counters.solves, counters.factorizations) == (3, 2)
    assert mechanics.seconds > 0


def test_iterations_of_the_linear_solver_are_counted():
    """Interface, results.json: "linear" counts the iterations of an iterative solver."""
    direct, iterative = make(), make(options=GMRES)
    for mechanics in (direct, iterative):
        random_activation(mechanics)
        mechanics.start()
    assert iterative.solver.counters.linear > 5 * direct.solver.counters.linear
    # Linear systems to 1e-8 make a slower contraction, not another answer.
    np.testing.assert_allclose(iterative.u.x.array, direct.u.x.array, rtol=0, atol=2e-10 * direct.size)


def test_a_fresh_tangent_contracts_quadratically():
    """ChordNewton: the tangent is the derivative of the residual; renewed in every iteration (refresh =
    0) it is Newton's method, whose error squares: from 1e-3 to below 1e-12 in two corrections.
    """
    problem = Cubic(f=30.0, refresh=0.0, tolerance=1e-13)
    problem.solver.solve()
    exact = problem.u.x.array.copy()
    start = exact + 1e-3 * np.sin(np.linspace(0, np.pi, len(exact)))
    start[[0, -1]] = exact[[0, -1]]
    errors = []
    for corrections in (1, 2):
        problem.u.x.array[:] = start
        for _ in range(corrections):
            problem.solver.forget()
            one = Cubic(f=30.0, tolerance=np.inf)  # stops after one correction
            one.u.x.array[:] = problem.u.x.array
            one.solver.solve()
            problem.u.x.array[:] = one.u.x.array
        errors.append(np.abs(problem.u.x.array - exact).max())
    assert 1e-9 < errors[0] < 3e-6
    assert errors[1] < 3e-12


# Failure.


@pytest.mark.parametrize(
    "parts", [dict(max_iterations=1), dict(options={"ksp_type": "gmres", "pc_type": "none", "ksp_max_it": 1})]
)
def test_failure_restores_the_unknown(parts):
    """ChordNewton.solve: ComputationError without a time of its own, and the unknown is what it was
    before.
    """
    problem = Cubic(f=1e4, **parts)
    problem.u.x.array[1:-1] = 0.25
    before = problem.u.x.array.copy()
    with pytest.raises(ms.ComputationError, match="mechanics") as caught:
        problem.solver.solve()
    assert caught.value.time is None
    assert caught.value.advice
    assert str(caught.value.at(0.5)).startswith("at t = 0.5: ")
    np.testing.assert_array_equal(problem.u.x.array, before)
    # It can be used again, with a fresh tangent, for a problem that it can solve.
    if "max_iterations" in parts:
        problem.f.value, problem.u.x.array[:] = 0.0, 0.0
        problem.solver.solve()
        assert not problem.u.x.array.any()


@pytest.mark.parametrize("kinematic", [PlaneStress(), PlaneStrain()], ids=str)
def test_singular_activation_is_a_failure(kinematic):
    """Mechanics.solve: ComputationError; not a number never passes for a solution, and the state stays
    finite.
    """
    mechanics = make(kinematic, active=GivenStrain(-1.0))
    before = mechanics.u.x.array.copy()
    with pytest.raises(ms.ComputationError):
        mechanics.start()
    np.testing.assert_array_equal(mechanics.u.x.array, before)


def test_life_goes_on_after_a_failure():
    """ChordNewton.solve restores the unknown: after a failed solve, a solvable one gives the same as
    ever.
    """
    mechanics, fresh = make(), make()
    for gamma in (-0.15, -1.0, -0.18):
        mechanics.activation.x.array[:] = gamma
        if gamma == -1.0:
            with pytest.raises(ms.ComputationError):
                mechanics.solve(1.0, predict=False)
        else:
            mechanics.solve(1.0, predict=False)
    expected = solved_afresh(fresh, -0.18)
    np.testing.assert_allclose(mechanics.u.x.array, expected, rtol=0, atol=2e-10 * mechanics.size)


GOING_AWAY = """
import gc
import myostrain as ms

def made():
    body = ms.build(ms.geometry.Rectangle(size=(2.0, 1.0)), ms.UniformFibres(direction=(1.0, 0.0)))
    parts = dict(kinematics=ms.kinematics.PlaneStress(), material=ms.materials.NeoHookean())
    ms.Mechanics(body, **parts)
    gc.collect()
    return body

try:
    made(), made(), 1 / 0
except ZeroDivisionError:
    print("went on")
"""


def test_bodies_that_go_away_with_an_exception():
    """Design: failure is an exception, never a hang. Bodies may be freed while it propagates; mpi4py 4.1
    then leaves a lock locked if the mesh's own communicator has had a pickling collective (``allreduce``,
    ``allgather``, ``bcast``), and the next one freed waits for ever.
    """
    command = [sys.executable, "-c", GOING_AWAY]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert ended.stdout == "went on\n"


@pytest.mark.parametrize("side", ["left", "top"])
@pytest.mark.parametrize("kinematic", [PlaneStress(), PlaneStrain()], ids=str)
def test_the_papers_contraction_in_one_jump(kinematic, side):
    """Mechanics.start: an elastic body begins contracted where it is activated (docs/model/readings.md). The
    paper's γ = −0.3 everywhere, at once, on a sheet fixed at a side: undamped Newton with fresh tangents
    needs 8 corrections.
    """
    body = sheet(size=(2.0, 1.0))
    parts = dict(kinematics=kinematic, material=NeoHookean(), fixed=[side])
    mechanics, stepped = (
        ms.Mechanics(
            body,
            **described(parts),
        ),
        ms.Mechanics(
            body,
            **described(parts),
        ),
    )
    for gamma in np.linspace(-0.03, -0.3, 10):
        stepped.activation.x.array[:] = gamma
        stepped.solver.solve()
    mechanics.activation.x.array[:] = -0.3
    mechanics.start()
    np.testing.assert_allclose(mechanics.u.x.array, stepped.u.x.array, rtol=0, atol=1e-8)


# The user's PETSc options.


def test_user_options_win():
    """Design: users can reach every solver: the option is set on the solver, over the package's own."""
    matrix = PETSc.Mat().createAIJ((3, 3), comm=MPI.COMM_SELF)
    ksp = make_ksp(matrix, "mechanics", {"ksp_type": "preonly", "pc_type": "lu"}, GMRES)
    assert (ksp.getType(), ksp.getPC().getType()) == ("gmres", "jacobi")
    assert ksp.getTolerances()[0] == 1e-8
    default = make_ksp(matrix, "mechanics", {"ksp_type": "preonly", "pc_type": "lu"}, None)
    assert (default.getType(), default.getPC().getType()) == ("preonly", "lu")
    assert default.getOptionsPrefix() != ksp.getOptionsPrefix()


@pytest.mark.parametrize(
    "options, key",
    [
        pytest.param({"snes_type": "newtonls"}, "solver.mechanics.snes_type", id="no linear solver's"),
        pytest.param({"type": "cg"}, "solver.mechanics.type", id="without its prefix"),
        pytest.param({"ksp_type": "congugate"}, "solver.mechanics.ksp_type", id="no such method"),
        pytest.param({"ksp_type": "cg", "ksp_rtol": "small"}, "solver.mechanics.ksp_rtol", id="no number"),
        pytest.param(
            {"ksp_rtol": 1e-8}, "solver.mechanics.ksp_rtol", id="of an iterative solver, not chosen"
        ),
        pytest.param({"ksp_tpye": "cg"}, "solver.mechanics.ksp_tpye", id="misspelt"),
        pytest.param({"pc_gamg_treshold": 0.1}, "solver.mechanics.pc_gamg_treshold", id="of another solver"),
    ],
)
def test_unknown_options_are_refused(options, key):
    """Design warns of silently ignored options; the interface: exit status 2 with one message that
    names the key.
    """
    with pytest.raises(ms.InputError) as caught:
        make(options=options).start()  # some are read when the solver is made, others when it is set up
    assert caught.value.key == key


@pytest.mark.parametrize(
    "options", [GMRES, {"pc_type": "lu", "ksp_type": "preonly"}, {"ksp_type": "cg", "pc_type": "icc"}]
)
def test_options_reach_the_mechanics(options, monkeypatch):
    """Interface, [solver.mechanics]: another linear solver, the same equilibrium (to the tolerance)."""
    reference, mechanics = make(), make(options=options)
    for each in (reference, mechanics):
        random_activation(each)
        each.start()
    np.testing.assert_allclose(mechanics.u.x.array, reference.u.x.array, rtol=0, atol=2e-10 * reference.size)


def test_residual_norm(monkeypatch):
    """ChordNewton.residual_norm: the largest entry, without those of fixed degrees of freedom."""
    monkeypatch.setattr(myostrain.mechanics.equilibrium, "ChordNewton", Recorded)
    mechanics = make(robin=0.0, fixed=["left"])
    # The largest entries are those of the fixed side.
    mechanics.activation.interpolate(lambda x: -0.3 * (1.0 - x[0]))
    x = mechanics.u.function_space.tabulate_dof_coordinates()[:, 0]
    entries = fem.assemble_vector(compile_form(mechanics.solver.residual)).array.reshape(-1, 2)
    free = np.abs(entries[x > 1e-9]).max()
    assert np.abs(entries).max() > free > 0
    assert mechanics.solver.residual_norm() == pytest.approx(free, rel=1e-12)


def test_seconds_of_a_phase_within_itself_count_once():
    """A phase that calls another of the same object, or fails, has the seconds that passed."""

    class Phase:
        seconds = 0.0

        @timed
        def inner(self):
            time.sleep(0.05)

        @timed
        def outer(self):
            self.inner()
            self.inner()
            raise ValueError("failed")

    phase = Phase()
    begin = time.perf_counter()
    with pytest.raises(ValueError, match="failed"):
        phase.outer()
    assert 0.1 <= phase.seconds <= time.perf_counter() - begin


def test_handing_over_is_in_the_timers():
    """The transfer to a nested mesh is the potential's time, the extrapolated body that of mechanics."""
    model = coupled.line()
    model.start()
    model.transfer.hand_over = lambda: time.sleep(0.05)
    model.mechanics.handed.extrapolate = lambda *arguments: time.sleep(0.05)
    before = model.potential.seconds, model.mechanics.seconds
    model.hand_over(0.1)
    assert model.potential.seconds - before[0] >= 0.05
    assert model.mechanics.seconds - before[1] >= 0.05
