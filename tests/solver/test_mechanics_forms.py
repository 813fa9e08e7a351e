"""The assembled residual against the stress that the paper prints, and its tangent against finite
differences.
"""

import myostrain as ms
import myostrain.mechanics.equilibrium
from myostrain.engine import compile_form, fem
from myostrain.kinematics import Line, PlaneStrain, PlaneStress
from myostrain.materials import MooneyRivlin, NeoHookean, Spring

import numpy as np
import pytest
import ufl

from mechanics_tools import Recorded, check_tangent, described, random_activation, sheet

DEGREE = 4  # of the quadrature, the same on both sides
ROBIN, BETA = 0.7, 0.35
SHEETS = [
    (cls(constraint=c), MooneyRivlin(mu=1.7, mu_2=0.6))
    for cls in (PlaneStress, PlaneStrain)
    for c in ("total", "elastic")
]
SHEETS += [(PlaneStress(), NeoHookean(mu=1.7))]


def load(mesh):
    """A body force that changes in space."""
    x = ufl.SpatialCoordinate(mesh)
    return ufl.as_vector([0.3 + 0.1 * x[i] ** 2 for i in range(mesh.geometry.dim)])


def make(monkeypatch, body, **parts):
    """A mechanics whose form can be read, in a random state of random activation."""
    monkeypatch.setattr(myostrain.mechanics.equilibrium, "ChordNewton", Recorded)
    mechanics = ms.Mechanics(
        body,
        quadrature_degree=DEGREE,
        **described(parts),
    )
    random_activation(mechanics, BETA)
    rng = np.random.default_rng(2)
    x = mechanics.u.x.array
    scale = 0.08 if mechanics.kinematics.degree == 1 else 0.02  # cells of size 1/4: |Grad u| < 1
    x[:] = scale * rng.uniform(-1, 1, len(x))
    if mechanics.kinematics.has_pressure:
        dofs = mechanics.u.function_space.sub(1).collapse()[1]
        x[dofs] = 1 + 0.3 * rng.uniform(-1, 1, len(dofs))
    return mechanics


def in_3d(A, stretch):
    return ufl.as_tensor([[A[0, 0], A[0, 1], 0], [A[1, 0], A[1, 1], 0], [0, 0, stretch]])


def printed_residual(mechanics, material):
    """(7.5) with the stress (3.3) written out by hand; where there is no pressure unknown, P₃₃ = 0 gives
    it.
    """
    body, kinematic = mechanics.body, mechanics.kinematics
    unknown = mechanics.u
    test = ufl.TestFunction(unknown.function_space)
    (u, p), (w, q) = (
        (ufl.split(unknown), ufl.split(test)) if kinematic.has_pressure else ((unknown, 0), (test, 0))
    )
    n = ufl.as_vector([body.f0[0], body.f0[1], 0])
    gamma = mechanics.activation
    inverse = ufl.Identity(3) - gamma / (1 + gamma) * ufl.outer(n, n)  # Sherman and Morrison's Fo⁻¹
    F2 = ufl.Identity(2) + ufl.grad(u)
    J = 1 if kinematic.constraint == "total" else 1 + gamma
    F = in_3d(F2, 1 if kinematic.has_pressure else J / ufl.det(F2))
    Fe = F * inverse
    B = Fe * Fe.T
    mu_2 = getattr(material, "mu_2", 0.0)
    P = (1 + gamma) * (material.mu * Fe + mu_2 * (ufl.tr(B) * Fe - B * Fe)) * inverse.T
    if not kinematic.has_pressure:
        J, p = P[2, 2] * F[2, 2], 1  # J p from P₃₃ − J p / λ₃ = 0
    else:
        J = ufl.det(F2)
    cofactor = ufl.as_tensor([[F2[1, 1], -F2[1, 0]], [-F2[0, 1], F2[0, 0]]]) / ufl.det(F2)
    P2 = ufl.as_tensor([[P[i, j] - J * p * cofactor[i, j] for j in range(2)] for i in range(2)])
    density = ufl.inner(P2, ufl.grad(w))
    if kinematic.has_pressure:
        density -= q * (ufl.det(F2) - (1 if kinematic.constraint == "total" else 1 + gamma))
    dx = ufl.dx(metadata={"quadrature_degree": DEGREE})
    outer = {"quadrature_degree": 2 * kinematic.degree}
    loads = ROBIN * ufl.dot(u, w) * ufl.ds(metadata=outer) - ufl.dot(load(body.mesh), w) * ufl.dx(
        metadata=outer
    )
    return density * dx + loads


@pytest.mark.parametrize("kinematic, material", SHEETS, ids=str)
def test_residual_is_the_printed_stress_and_the_tangent_its_derivative(kinematic, material, monkeypatch):
    """(1.6), (3.3), (7.5) and (7.8) on a sheet with oblique fibres and varying γ, at an arbitrary state;
    tangent against finite differences of the residual, in a random direction.
    """
    body = sheet(size=(1.0, 0.75))
    parts = dict(kinematics=kinematic, material=material, robin=ROBIN, body_force=load(body.mesh))
    mechanics = make(monkeypatch, body, **parts)
    residual = compile_form(mechanics.solver.residual)
    vector = fem.assemble_vector(residual).array
    printed = fem.assemble_vector(compile_form(printed_residual(mechanics, material))).array
    # Measured 1e-15 of the largest entry.
    np.testing.assert_allclose(vector, printed, rtol=0, atol=1e-12 * np.abs(printed).max())
    check_tangent(mechanics)


@pytest.mark.parametrize("relaxation_time", [0.0, 0.4])
def test_line_residual(relaxation_time, monkeypatch):
    """(4.2) and docs/model/readings.md: stress μ (x′/(1+γ) − 1) + μ λ d/dt[(x′ − 1)/(1 + γ)], with a step of
    0.1 from a state of other displacement and other activation, ends on springs, and a body force.
    """
    body = ms.build(ms.geometry.Line(length=2.0, spacing=0.25))
    parts = dict(kinematics=Line(), material=Spring(mu=2.5), robin=ROBIN, body_force=load(body.mesh))
    mechanics = make(monkeypatch, body, relaxation_time=relaxation_time, **parts)
    u, gamma, step = mechanics.u, mechanics.activation, 0.1
    mechanics.accept(0.0)
    old_u, old_gamma = u.copy(), gamma.copy()
    random_activation(mechanics, BETA, seed=5)
    if relaxation_time:
        mechanics.solve(step, predict=False)  # sets the rates; its solution is not what is looked at
    u.x.array[:] = 0.02 * np.random.default_rng(6).uniform(-1, 1, len(u.x.array))

    w = ufl.TestFunction(u.function_space)

    def strain(u, gamma):
        return u[0].dx(0) / (1 + gamma)

    rate = (strain(u, gamma) - strain(old_u, old_gamma)) / step
    stress = strain(u, gamma) + 1 / (1 + gamma) - 1 + relaxation_time * rate
    dx, more = ufl.dx(metadata={"quadrature_degree": DEGREE}), {"quadrature_degree": 4}
    printed = 2.5 * stress * w[0].dx(0) * dx + ROBIN * u[0] * w[0] * ufl.ds(metadata=more)
    printed -= ufl.dot(load(body.mesh), w) * ufl.dx(metadata=more)
    vector = fem.assemble_vector(compile_form(mechanics.solver.residual)).array
    expected = fem.assemble_vector(compile_form(printed)).array
    np.testing.assert_allclose(
        vector, expected, rtol=0, atol=1e-12 * np.abs(expected).max()
    )  # measured 1e-15
    check_tangent(mechanics)
