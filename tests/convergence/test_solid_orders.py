"""Measured orders of solids in space: stress-free bending and torsion, and a manufactured solution."""

import functools

import myostrain as ms
from myostrain.activation import Fibre, Orthotropic
from myostrain.engine import compile_form, fem, jit_options
from myostrain.geometry import Body, Microstructure
from myostrain.kinematics import PlaneStrain, PlaneStress, Solid
from myostrain.materials import NeoHookean
from myostrain.theory import active_stretches

import numpy as np
import pytest
import ufl
from scipy.integrate import solve_ivp

from mechanics_tools import GivenStrain, described
from order_tools import norm, orders
from solid_tools import DEFORMATIONS, Solids, block, frame, quick_kernels

MU = 1.3
ONE = ufl.Identity(3)


class Growing:
    """An active deformation of a user's own: γ is the UFL expression given times what the nodes have."""

    def __init__(self, gamma, deformation=None):
        self.value, self.deformation = gamma, deformation or Fibre()

    def tensor(self, gamma, fibres):
        return self.deformation.tensor(gamma * self.value, fibres)


def integrals(expressions, degree=8):
    dx = ufl.dx(metadata={"quadrature_degree": degree})
    return np.array([fem.assemble_scalar(compile_form(expression * dx)) for expression in expressions])


def modulo_rigid_motion(found, exact, volume):
    """The difference of two placements of a body, the one brought nearest to the other in L2."""
    pairs = [found[i] * exact[j] for i in range(3) for j in range(3)]
    m = integrals([*found, *exact, *pairs]) / volume
    U, _, Vt = np.linalg.svd(m[6:].reshape(3, 3) - np.outer(m[:3], m[3:6]))
    R = U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt
    return found - ufl.as_vector(m[:3]) - ufl.as_matrix(R.tolist()) * (exact - ufl.as_vector(m[3:6]))


def cofactor(F):
    """det F F⁻ᵀ written out."""
    rows = [ufl.as_vector([F[i, j] for j in range(3)]) for i in range(3)]
    crosses = [ufl.cross(rows[1], rows[2]), ufl.cross(rows[2], rows[0]), ufl.cross(rows[0], rows[1])]
    return ufl.as_tensor([[cross[j] for j in range(3)] for cross in crosses])


# Free bodies that bend and twist without stress. An isochoric deformation of which one principal stretch is
# one, λ and 1/λ the others, is Fo of Orthotropic(κ = 0) times a rotation, with 1 + γ = 1/λ along the fibre.


def bent(X):
    """Bending (reference README, with the sheets taking all thickening): x = r (cos θ, sin θ, Z), r² = 2aX +
    b, θ = Y/a, F = diag(a/r, r/a, 1) in turned axes: fibres along Y, sheets along X, γ = r/a − 1.
    """
    a, b = 2.0, 2.0  # r/a from 0.71 to 1.22
    r, theta = ufl.sqrt(2 * a * X[0] + b), X[1] / a
    x = ufl.as_vector([r * ufl.cos(theta), r * ufl.sin(theta), X[2]])
    f0, s0, n0 = ufl.as_vector([0, 1.0, 0]), ufl.as_vector([1.0, 0, 0]), ufl.as_vector([0, 0, 1.0])
    return x, r / a - 1, (f0, s0, n0)


def bent_between_plates(X):
    """Bending with Fo = 1 + γ n⊗n: the same placement, γ = (2aX + b)/a² − 1 (reference README)."""
    x, strain, directions = bent(X)
    return x, (1 + strain) ** 2 - 1, directions


def twisted(X, twist=0.5):
    """Torsion by ``twist`` a length about an axis along Z beside the bar: a simple shear k = R twist in the
    cylinders about it, λ = k/2 + √(1 + k²/4). The fibre is the direction that shortens to 1/λ.
    """
    Y = ufl.as_vector([X[0] + 0.5, X[1] + 0.5])
    R = ufl.sqrt(ufl.dot(Y, Y))
    c, s = ufl.cos(twist * X[2]), ufl.sin(twist * X[2])
    x = ufl.as_vector([c * Y[0] - s * Y[1], s * Y[0] + c * Y[1], X[2]])
    k = R * twist
    lam = k / 2 + ufl.sqrt(1 + k**2 / 4)
    around, along = ufl.as_vector([-Y[1] / R, Y[0] / R, 0]), ufl.as_vector([0, 0, 1.0])
    length = ufl.sqrt(1 + lam**2)
    f0, s0 = (along - lam * around) / length, (lam * along + around) / length
    return x, 1 / lam - 1, (f0, s0, ufl.as_vector([Y[0] / R, Y[1] / R, 0]))


def stress_free_errors(deformed, material, rest, size, spacing, *, from_rest, **parts):
    """Errors of the position modulo rigid motions, its gradient, and the pressure."""
    body = ms.build(ms.geometry.Slab(size=size, spacing=spacing), ms.UniformFibres(direction=(1, 0, 0)))
    X = ufl.SpatialCoordinate(body.mesh)
    exact, gamma, directions = deformed(X)
    active = Growing(gamma, parts.pop("active", Orthotropic(kappa=0.0)))
    mechanics = ms.Mechanics(
        Body(body.meshed, Microstructure(*directions)),
        kinematics=Solid(),
        material=material,
        active=active,
        **described(parts),
    )
    mechanics.activation.x.array[:] = 1.0
    u, p = ufl.split(mechanics.u)
    if from_rest:
        mechanics.start()
    else:  # the nodes that are held stay where the exact solution has them: the body is as free as elsewhere
        space = mechanics.u.function_space.sub(0).collapse()[0]
        expression = fem.Expression(exact - X, space.element.interpolation_points, jit_options=jit_options())
        mechanics.u.sub(0).interpolate(expression)
        mechanics.u.sub(1).interpolate(lambda X: np.full(X.shape[1], rest))
        mechanics.solver.solve()
    error = modulo_rigid_motion(X + u, exact, np.prod(size))
    return [norm(error), norm(ufl.grad(error)), norm(p - rest)]


STRESS_FREE = {
    # placement, material, its pressure at rest, size, what mechanics takes besides
    "bending": (bent, NeoHookean(mu=MU), MU, (1.0, 1.0, 0.5), {}),
    "bending between plates": (
        bent_between_plates,
        NeoHookean(mu=MU),
        MU,
        (1.0, 1.0, 0.5),
        {"active": Fibre(), "sliding": ["bottom", "top"]},
    ),
    "torsion": (twisted, NeoHookean(mu=MU), MU, (0.5, 0.5, 1.0), {}),
}


@pytest.mark.parametrize(
    "case",
    [
        "bending between plates",
        pytest.param("bending", marks=pytest.mark.slow),
        pytest.param("torsion", marks=pytest.mark.slow),
    ],
)
def test_bodies_that_bend_and_twist_without_stress(case):
    """Closed forms with active strain: a free body whose Fo is compatible takes it, with P = 0 and the
    pressure of rest; between plates (reference README) with P = 0 in the plane. P2–P1
    finds that with orders 3 and 2, the constant pressure with 2 at least; coarse from rest, fine from the
    solution.
    """
    deformed, material, rest, size, parts = STRESS_FREE[case]
    with quick_kernels():
        errors = [
            stress_free_errors(deformed, material, rest, size, h, from_rest=h == 1 / 2, **parts)
            for h in (1 / 2, 1 / 4, 1 / 8)
        ]
    measured = orders(errors)
    for order, (low, high) in zip(measured[-1], [(2.8, 3.2), (1.8, 2.2), (1.9, 3.2)], strict=True):
        assert low < order < high, measured


# A manufactured solution, with the paper's stress by hand.


def flat(z):
    """One at the bottom, and of second order at the top z = 1/2, which is free: no force acts there."""
    return (1 - 2 * z) ** 2


def displacement(constraint, x, y, z, m):
    """u* with functions of numpy or UFL: where J = 1 is asked for, two shears, one after the other."""
    w = flat(z)
    if constraint == "total":
        dx = 0.2 * w * m.sin(2 * y + 0.3)
        return dx, 0.15 * w * m.cos(1.5 * (x + dx)), 0 * z
    return 0.2 * w * m.sin(2 * y), 0 * z, 0.1 * w * m.cos(x + 2 * y)


def pressure(x, y, z, m):
    return MU + flat(z) * m.sin(4 * x - 3 * y)


def manufactured_errors(constraint, spacing):
    """Errors of u in L2, of Grad u in L2, of p in L2."""
    fibres = ms.UniformFibres(direction=(2.0, 1.0, -1.0))
    body = ms.build(ms.geometry.Slab(size=(1.0, 1.0, 0.5), spacing=spacing), fibres)
    X = ufl.SpatialCoordinate(body.mesh)
    u_exact, p_exact = ufl.as_vector(displacement(constraint, *X, ufl)), pressure(*X, ufl)
    F = ONE + ufl.grad(u_exact)
    # Where J = Jo, γ is what makes u* admissible.
    gamma = -0.2 * flat(X[2]) * (1 + ufl.sin(2 * X[0] - X[1]) / 2)
    if constraint == "elastic":
        gamma = ufl.det(F) - 1
    inverse = ONE - gamma / (1 + gamma) * ufl.outer(body.f0, body.f0)  # of Fo, by Sherman and Morrison
    P = (1 + gamma) * MU * F * inverse * inverse - p_exact * cofactor(F)
    mechanics = ms.Mechanics(
        body,
        kinematics=Solid(constraint=constraint),
        material=NeoHookean(mu=MU),
        active=GivenStrain(gamma),
        supports=ms.Supports(fixed=["left", "right", "front", "back", "bottom"]),
        loads=ms.Loads(body_force=-ufl.div(P)),
    )
    # Solved from the exact solution, whose values at the fixed parts stay: Newton does not touch these.
    mechanics.u.sub(0).interpolate(lambda X: np.array(displacement(constraint, *X, np)))
    mechanics.u.sub(1).interpolate(lambda X: pressure(*X, np))
    mechanics.solver.solve()
    u, p = ufl.split(mechanics.u)
    return [norm(u - u_exact), norm(ufl.grad(u - u_exact)), norm(p - p_exact)]


@pytest.mark.parametrize("constraint", ["total", pytest.param("elastic", marks=pytest.mark.slow)])
def test_orders_in_space(constraint):
    """Issue: "Manufactured solutions with orders (u: 3 in L2, p: 2) for P2–P1": (1.6), (3.3) with an active
    strain that varies along and across oblique fibres, J = 1 or det Fe = 1.
    """
    with quick_kernels():
        errors = [manufactured_errors(constraint, h) for h in (1 / 2, 1 / 4, 1 / 8)]
    measured = orders(errors)
    for order, (low, high) in zip(measured[-1], [(2.8, 3.2), (1.8, 2.2), (1.8, 2.2)], strict=True):
        assert low < order < high, measured


# The Kelvin–Voigt solid in time: a free block, of which ordinary differential equations are the solution.

LAMBDA = 0.4


def active_of(name, gamma):
    """(a_f, a_s, a_n), κ = 1/2 for the orthotropic one."""
    return active_stretches(gamma, {"Fibre": None, "TransverselyIsotropic": 1.0, "Orthotropic": 0.5}[name])


def exact_stretches(course, name, constraint, times):
    """λ (times, 3) from rest: Jo μ λᵢ/aᵢ² + λᵢ Sᵢ = p/λᵢ with S = 2 λ μ Jo a⁻⁴ λ λ′, and d/dt ln(λ₁λ₂λ₃) =
    d/dt ln J gives p.
    """

    def rate(t, stretches):
        a, h = active_of(name, course(t)), 1e-5
        Jo = np.prod(a)
        drag = 2 * LAMBDA * MU * Jo * stretches**2 / a**4
        log_J = 0.0
        if constraint == "elastic":
            ahead, behind = (np.prod(active_of(name, course(t + sign * h))) for sign in (1, -1))
            log_J = (np.log(ahead) - np.log(behind)) / (2 * h)
        pull = Jo * MU * stretches / a**2
        p = (log_J + np.sum(pull / drag / stretches)) / np.sum(1 / (drag * stretches**2))
        return (p / stretches - pull) / drag

    solved = solve_ivp(rate, (0, times[-1]), np.ones(3), "DOP853", times, rtol=1e-10, atol=1e-12)
    return solved.y.T


@functools.cache
def viscous_block():
    return Solids(
        block(size=(1.0, 1.0, 1.0)), [NeoHookean(mu=MU)], [c() for c in DEFORMATIONS], relaxation_time=LAMBDA
    )


def measured_stretches(course, name, constraint, times, order):
    """Stretches (times, 3) along f0, s0, n0 of the free block, one step to each time."""
    solids = viscous_block()
    mechanics = solids.choose("NeoHookean", name, constraint)
    axes, gamma, found = frame(mechanics.body), mechanics.activation.x.array, []
    gamma[:] = course(0.0)
    mechanics.start(0.0)
    for t in times:
        gamma[:] = course(t)
        mechanics.solve(t, order=order)
        mechanics.accept(t)
        found.append(np.linalg.norm(solids.gradient() @ axes, axis=1).mean(axis=0))
    np.testing.assert_allclose(solids.cauchy(), 0, rtol=0, atol=1e-8)  # viscous part included
    return np.array(found)


def contraction(t):
    return -0.3 * np.sin(np.pi * t) ** 2


@pytest.mark.parametrize(
    "name, constraint", [("Fibre", "total"), ("Fibre", "elastic"), ("Orthotropic", "total")]
)
@pytest.mark.parametrize("order, band, finest", [(1, (0.95, 1.05), 3e-3), (2, (1.9, 2.1), 2e-4)])
def test_viscous_block_in_time(name, constraint, order, band, finest):
    """Issue: "Frame-indifferent Kelvin–Voigt in 3D": S = 2 λ μ Jo Fo⁻¹Fo⁻ᵀ Ė Fo⁻¹Fo⁻ᵀ at finite strains, of
    a free block with oblique fibres, against ordinary differential equations; the order of the rate in time.
    """
    errors = []
    for steps in (20, 40, 80):
        times = np.linspace(0, 1, steps + 1)[1:]
        exact = exact_stretches(contraction, name, constraint, times)
        errors.append(np.abs(measured_stretches(contraction, name, constraint, times, order) - exact).max())
    measured = orders(errors)
    assert band[0] < measured[-1] < band[1], (errors, measured)
    assert errors[-1] < finest
    assert 1 - exact.min() > 0.05  # there is something to see


def test_relaxation_of_a_free_block():
    """A free block that is activated at once, γ = −0.3, relaxes to (1 + γ)^(2/3) along the fibre, as slowly
    as the ordinary differential equations say.
    """
    times = LAMBDA * np.concatenate([np.linspace(0, 1, 41)[1:], np.linspace(1, 12, 56)[1:]])
    found = measured_stretches(lambda t: -0.3, "Fibre", "total", times, 2)
    exact = exact_stretches(lambda t: -0.3, "Fibre", "total", times)
    np.testing.assert_allclose(found, exact, rtol=0, atol=4e-4)  # measured 1.7e-4
    assert exact[0, 0] > 0.97
    assert found[-1, 0] == pytest.approx(0.7 ** (2 / 3), abs=1e-4)  # measured 2e-5


# A thin solid is a sheet.


class QuadraticSheet(PlaneStress):
    """A sheet in plane stress as exact in its plane as the solid."""

    degree = 2


def strain_in_the_plane(X):
    """Incompatible: a sheet and a solid are stressed by it."""
    return -0.2 * (1 + ufl.sin(2 * X[0]) * ufl.cos(X[1]))


def distances(geometry, fibre, kinematics, plane=None, **parts):
    """Distances between all points of a grid in the body, deformed from rest: no rigid motion matters."""
    body = ms.build(geometry, ms.UniformFibres(direction=fibre))
    mechanics = ms.Mechanics(
        body,
        kinematics=kinematics,
        material=NeoHookean(mu=MU),
        active=Growing(strain_in_the_plane(ufl.SpatialCoordinate(body.mesh))),
        **described(parts),
    )
    mechanics.activation.x.array[:] = 1.0
    mechanics.start()
    space, u = mechanics.u.function_space, mechanics.u.x.array
    if kinematics.has_pressure:
        space, dofs = space.sub(0).collapse()
        u = u[dofs]
    X, u = space.tabulate_dof_coordinates(), u.reshape(-1, body.dim)
    grid = np.isclose(X[:, :2] * 2, np.round(X[:, :2] * 2)).all(axis=1)
    if plane is not None:
        grid &= np.isclose(X[:, 2], plane)
    assert grid.sum() == 15
    order = np.lexsort(np.round(X[grid, :2], 6).T)
    x = (X[grid, : body.dim] + u[grid])[order]
    return np.linalg.norm(x[:, None] - x[None], axis=2)


def test_a_thin_solid_is_a_sheet_in_plane_stress():
    """Issue: "The plane cases of the sheet are recovered by a thin solid"; docs/model/readings.md. With its
    thickness t the difference of the solid from the sheet with free faces vanishes like t², under an active
    strain that varies in the plane, fibres oblique in it.
    """
    size, spacing, fibre = (2.0, 1.0), 0.125, (2.0, 1.0)
    with quick_kernels():
        sheet = distances(ms.geometry.Rectangle(size=size, spacing=spacing), fibre, QuadraticSheet())
        differences = []
        for t in (0.4, 0.2):
            upper_half = ms.geometry.Slab(size=(*size, t / 2), spacing=spacing)
            solid = distances(upper_half, (*fibre, 0.0), Solid(), plane=0.0, sliding=["bottom"])
            differences.append(np.abs(solid - sheet).max())
    assert 3 < differences[0] / differences[1] < 5, differences  # measured 3.7, and 3.8 for t = 0.1
    assert differences[1] < 1e-3  # measured 8e-4, of a body of length 2


def test_a_solid_between_plates_is_a_sheet_in_plane_strain():
    """The same of a solid that slides between two planes, and plane strain, whatever its thickness: what is
    left is the elements' error, which vanishes with their size.
    """
    size, fibre, differences = (2.0, 1.0), (2.0, 1.0), []
    with quick_kernels():
        for spacing in (1 / 4, 1 / 8):
            sheet = distances(ms.geometry.Rectangle(size=size, spacing=spacing), fibre, PlaneStrain())
            slab = ms.geometry.Slab(size=(*size, 0.25), spacing=spacing)
            solid = distances(slab, (*fibre, 0.0), Solid(), plane=0.0, sliding=["bottom", "top"])
            differences.append(np.abs(solid - sheet).max())
    assert differences[0] / differences[1] > 3  # measured 3.8
    assert differences[1] < 5e-4  # measured 3e-4
