"""Active sheets in equilibrium: closed forms in plane stress and plane strain, supports, and bad use."""

import myostrain as ms
import myostrain.mechanics.equilibrium
from myostrain.engine import compile_form, fem
from myostrain.geometry import Body, Microstructure
from myostrain.kinematics import Line, PlaneStrain, PlaneStress
from myostrain.materials import MooneyRivlin, NeoHookean, Spring

import numpy as np
import pytest
import ufl
from scipy.optimize import brentq

from mechanics_tools import (
    GivenStrain,
    Recorded,
    active,
    at_midpoints,
    described,
    gradient,
    moduli,
    plane_stress_cauchy,
    random_activation,
    sheet,
)

GAMMA = -0.3
NEO, MOONEY = NeoHookean(mu=1.7), MooneyRivlin(mu=1.7, mu_2=0.6)
N = np.array([2.0, 1.0]) / np.sqrt(5)  # the fibre
ACROSS = np.array([-N[1], N[0]])
NEAR = 2e-11  # for quantities of order one, solved to 1e-13 of the diagonal: measured 3e-12 at most


def make(kinematic, material, body=None, **parts):
    parts = dict(tolerance=1e-13) | parts  # of the diagonal: as near to the closed forms as round-off lets
    return ms.Mechanics(
        body or sheet(),
        kinematics=kinematic,
        material=material,
        **described(parts),
    )


def contracted(kinematic, material, **parts):
    """A mechanics in equilibrium with γ everywhere."""
    mechanics = make(kinematic, material, **parts)
    mechanics.activation.x.array[:] = GAMMA
    mechanics.start()
    return mechanics


def displacement_dofs(mechanics):
    """Displacements (n, 2) at all their nodes, and the nodes' positions."""
    if mechanics.kinematics.has_pressure:
        space, dofs = mechanics.u.function_space.sub(0).collapse()
        return mechanics.u.x.array[dofs].reshape(-1, 2), space.tabulate_dof_coordinates()[:, :2]
    return mechanics.u.x.array.reshape(-1, 2), mechanics.u.function_space.tabulate_dof_coordinates()[:, :2]


def free_stretches(kinematic):
    """Stretches along and across the fibre of a free body (README, closed forms; F = Fo if Fe is
    isochoric).
    """
    a = 1 + GAMMA
    if kinematic.constraint == "elastic":
        return a, 1.0
    return (a ** (2 / 3), a ** (-1 / 3)) if isinstance(kinematic, PlaneStress) else (a**0.5, a**-0.5)


@pytest.mark.parametrize("material", [NEO, MOONEY], ids=str)
@pytest.mark.parametrize("constraint", ["total", "elastic"])
@pytest.mark.parametrize("cls", [PlaneStress, PlaneStrain])
def test_free_uniform_contraction(cls, constraint, material, monkeypatch):
    """README, closed forms: stretch along n (1 + γ)^(2/3) in plane stress, (1 + γ)^(1/2) in plane strain;
    F = Fo and no stress where Fe is isochoric. A rotation aside, the pins do nothing: the forces there
    vanish. In plane strain with J = 1 the plates carry σ₃₃ = μγ + μ₂γ/(1 + γ), and p = μ + μ₂ (1 + 1/(1 +
    γ)).
    """
    monkeypatch.setattr(myostrain.mechanics.equilibrium, "ChordNewton", Recorded)
    kinematic = cls(constraint=constraint)
    mechanics = contracted(kinematic, material)
    along, across = free_stretches(kinematic)
    U = along * np.outer(N, N) + across * np.outer(ACROSS, ACROSS)

    F = gradient(mechanics)
    np.testing.assert_allclose(F.transpose(0, 2, 1) @ F, np.broadcast_to(U @ U, F.shape), rtol=0, atol=NEAR)
    u, X = displacement_dofs(mechanics)
    pin = np.argmin(np.abs(u).sum(1))
    np.testing.assert_allclose(u - u[pin], (X - X[pin]) @ (F[0] - np.eye(2)).T, rtol=0, atol=NEAR)
    forces = fem.assemble_vector(compile_form(mechanics.solver.residual)).array
    np.testing.assert_allclose(forces, 0, rtol=0, atol=NEAR)  # at the pins too

    mu, mu_2 = moduli(material)
    held = isinstance(kinematic, PlaneStrain) and constraint == "total"
    trace = GAMMA * (mu + mu_2 / (1 + GAMMA)) if held else 0.0
    np.testing.assert_allclose(mechanics.stress_trace(), trace, rtol=0, atol=NEAR)
    if kinematic.has_pressure:
        p = mechanics.u.x.array[mechanics.u.function_space.sub(1).collapse()[1]]
        expected = mu + mu_2 * (1 + 1 / (1 + GAMMA)) if held else mu + 2 * mu_2
        np.testing.assert_allclose(p, expected, rtol=0, atol=NEAR)


@pytest.mark.parametrize("kinematic", [PlaneStress(), PlaneStrain()], ids=str)
def test_a_free_body_knows_no_frame(kinematic, monkeypatch):
    """Supports: a free body is held without stress. The body turned and shifted, with its fibres, has the
    same strain and stress although other points are pinned, and no force acts at them, under an
    incompatible activation.
    """
    monkeypatch.setattr(myostrain.mechanics.equilibrium, "ChordNewton", Recorded)
    results = []
    for angle, shift in ((0.0, 0.0), (2.2, 7.0)):
        R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        body = sheet()
        x = body.mesh.geometry.x
        x[:, :2] = x[:, :2] @ R.T + shift
        mechanics = make(
            kinematic, NEO, body=Body(body.meshed, Microstructure(fem.Constant(body.mesh, R @ N)))
        )
        random_activation(mechanics)
        mechanics.start()
        forces = fem.assemble_vector(compile_form(mechanics.solver.residual)).array
        np.testing.assert_allclose(forces, 0, rtol=0, atol=NEAR)
        F = gradient(mechanics)
        results.append((R.T @ F.transpose(0, 2, 1) @ F @ R, mechanics.stress_trace()))
    (C, trace), (turned_C, turned_trace) = results
    assert np.abs(trace).max() > 0.05  # the activation does stress the body
    np.testing.assert_allclose(turned_C, C, rtol=0, atol=NEAR)
    np.testing.assert_allclose(turned_trace, trace, rtol=0, atol=NEAR)


@pytest.mark.parametrize("material", [NEO, MOONEY], ids=str)
def test_clamped_all_around_is_isometric(material):
    """README, closed forms: at λ = 1 the stress along n is μ (1 + γ)((1 + γ)⁻² − 1), here plus the same
    with μ₂, and there is none across: a sheet clamped all around stays, with this trace.
    """
    mechanics = contracted(PlaneStress(), material, fixed=["left", "right", "bottom", "top"])
    a = 1 + GAMMA
    np.testing.assert_allclose(mechanics.u.x.array, 0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(mechanics.stress_trace(), sum(moduli(material)) * a * (a**-2 - 1), rtol=1e-12)


def test_clamped_all_around_in_plane_strain():
    """(3.3), (3.8): an isochoric body clamped all around leaves its pressure open by a constant. That is
    refused, or the constant is fixed; stresses that depend on where the iteration began are none.
    """
    try:
        mechanics = make(PlaneStrain(), NEO, fixed=["left", "right", "bottom", "top"])
    except ms.InputError:
        return
    random_activation(mechanics)
    mechanics.start()
    trace = mechanics.stress_trace()
    mechanics.u.x.array[mechanics.u.function_space.sub(1).collapse()[1]] = 3.0
    mechanics.solver.forget()
    mechanics.solver.solve()
    np.testing.assert_allclose(mechanics.stress_trace(), trace, rtol=0, atol=NEAR)


@pytest.mark.parametrize("kinematic", [PlaneStress(), PlaneStrain()], ids=str)
def test_held_at_rest_without_activation_there_is_no_stress(kinematic):
    """(3.3): P = 0 at F = Fo = 1, with p = μ; also where the reference configuration is imposed."""
    mechanics = make(kinematic, NEO, imposed_stretch=ms.ImposedStretch())
    mechanics.start()
    np.testing.assert_allclose(mechanics.stress_trace(), 0, rtol=0, atol=1e-13)


@pytest.mark.parametrize("stretch", [0.8, 1.0, 1.25])
def test_uniaxial_stress_of_the_readme(stretch):
    """README, closed forms: P/μ = (1 + γ)(λ/(1 + γ)² − λ⁻²) along n with free sides; the trace of σ is λ
    P.
    """
    held = ms.ImposedStretch(value=(stretch, stretch**-0.5))
    mechanics = contracted(PlaneStress(), NEO, body=sheet(fibre=(1.0, 0.0)), imposed_stretch=held)
    P = NEO.mu * (1 + GAMMA) * (stretch / (1 + GAMMA) ** 2 - stretch**-2)
    np.testing.assert_allclose(mechanics.stress_trace(), stretch * P, rtol=0, atol=1e-13)


@pytest.mark.parametrize("constraint", ["total", "elastic"])
def test_uniaxial_stress_at_an_angle_to_the_fibre(constraint):
    """(3.3) in 3D algebra: stretched along X, at an angle to the fibre and without shear, the transverse
    stretch where the Mooney–Rivlin sheet has no transverse stress, found by scipy; the trace of σ is that
    of numpy.
    """
    Fo = active(np.array([GAMMA]), np.pad(N, (0, 1))[None])
    mu_mu2 = moduli(MOONEY)

    def cauchy(transverse):
        return plane_stress_cauchy(np.diag([1.2, transverse])[None], Fo, *mu_mu2, constraint)[0]

    transverse = brentq(lambda t: cauchy(t)[1, 1], 0.5, 1.5, xtol=1e-14)
    held = ms.ImposedStretch(value=(1.2, transverse))
    mechanics = contracted(PlaneStress(constraint=constraint), MOONEY, imposed_stretch=held)
    expected = np.trace(cauchy(transverse))
    assert expected > 1  # under tension
    np.testing.assert_allclose(mechanics.stress_trace(), expected, rtol=1e-12)


class Diagonal:
    """A user's own active deformation, diag(f₁, f₂, 1): not one of the package."""

    def __init__(self, first, second):
        self.first, self.second = first, second

    def tensor(self, gamma, fibres):
        return ufl.as_tensor([[self.first, 0, 0], [0, self.second, 0], [0, 0, 1.0]])


@pytest.mark.parametrize("material", [NEO, MOONEY], ids=str)
def test_sheet_between_two_springs(material):
    """(7.8), P N = −k u, in closed form. Two opposite sides of width L on springs; Fo = diag(f₁, λ, 1)
    makes λ along X leave the other sides where they are (F = diag(λ, 1, 1/λ), σ₂₂ = σ₃₃ = 0); f₁ from P₁₁
    = −k (λ − 1) L/2.
    """
    k, length, stretch = 0.9, 2.0, 0.85

    def imbalance(f):
        Fo = np.diag([f, stretch, 1.0])[None]
        sigma = plane_stress_cauchy(np.diag([stretch, 1.0])[None], Fo, *moduli(material), "total")[0]
        assert abs(sigma[1, 1]) < 1e-12
        return sigma[0, 0] / stretch + k * (stretch - 1) * length / 2

    deformation = Diagonal(brentq(imbalance, 0.3, 1.0, xtol=1e-14), stretch)
    parts = dict(robin=k, robin_boundary=["left", "right"], active=deformation)
    mechanics = contracted(PlaneStress(), material, body=sheet(size=(length, 1.0)), **parts)
    u, X = displacement_dofs(mechanics)
    expected = np.column_stack([(stretch - 1) * (X[:, 0] - length / 2), np.zeros(len(X))])
    np.testing.assert_allclose(u, expected, rtol=0, atol=NEAR)


@pytest.mark.parametrize("kinematic", [PlaneStress(), PlaneStrain()], ids=str)
def test_springs_balance_the_load(kinematic):
    """(7.8), (1.6): the springs of the named sides alone carry the body force and its moment about the
    origin.
    """
    body = sheet()
    x, k, b = ufl.SpatialCoordinate(body.mesh), 1.3, ufl.as_vector([0.2, -0.3])
    parts = dict(robin=k, robin_boundary=["left", "top"], body_force=b)
    mechanics = make(kinematic, NEO, body=body, **parts)
    random_activation(mechanics)
    mechanics.start()
    u = ufl.split(mechanics.u)[0] if kinematic.has_pressure else mechanics.u
    ds, y = body.boundary_measure(["left", "top"], degree=4), x + u
    carried = [fem.assemble_scalar(fem.form(k * u[i] * ds)) for i in range(2)]
    np.testing.assert_allclose(carried, [0.2 * 2, -0.3 * 2], rtol=0, atol=NEAR)  # the area is 2
    moment = k * (y[0] * u[1] - y[1] * u[0]) * ds - (y[0] * b[1] - y[1] * b[0]) * ufl.dx(degree=4)
    np.testing.assert_allclose(fem.assemble_scalar(fem.form(moment)), 0, rtol=0, atol=NEAR)


SIDES = {"left": (0, 0.0), "right": (0, 2.0), "bottom": (1, 0.0), "top": (1, 1.0)}


@pytest.mark.parametrize("kinematic", [PlaneStress(), PlaneStrain()], ids=str)
@pytest.mark.parametrize("side", SIDES)
def test_fixed_side(side, kinematic):
    """Mechanics: u = 0 on the named part of the boundary, and there alone."""
    mechanics = make(kinematic, NEO, fixed=[side])
    mechanics.activation.x.array[:] = 0.3 * GAMMA
    mechanics.start()
    u, X = displacement_dofs(mechanics)
    axis, position = SIDES[side]
    on_side = np.isclose(X[:, axis], position)
    assert not u[on_side].any()
    assert np.linalg.norm(u[~on_side], axis=1).min() > 1e-3


def test_plane_stress_is_free_of_stress_on_its_faces():
    """Readings of the model: σ₃₃ = 0, and the Cauchy stress is symmetric, where the stress varies."""
    mechanics = make(PlaneStress(), MOONEY, robin=1.0)
    random_activation(mechanics)
    mechanics.start()
    sigma = at_midpoints(mechanics.cauchy(), mechanics.body.mesh)()
    assert np.abs(sigma).max() > 0.1
    np.testing.assert_allclose(sigma[:, 2, :], 0, rtol=0, atol=1e-13)
    np.testing.assert_allclose(sigma, sigma.transpose(0, 2, 1), rtol=0, atol=1e-13)
    expected = plane_stress_cauchy(
        gradient(mechanics),
        active(
            at_midpoints(mechanics.activation, mechanics.body.mesh)(), np.tile([*N, 0.0], (len(sigma), 1))
        ),
        *moduli(MOONEY),
        "total",
    )
    np.testing.assert_allclose(sigma, expected, rtol=0, atol=1e-12)


def test_displacement_at_the_mesh_nodes():
    """Mechanics.displacement: P1, the values of the quadratic field at the vertices."""
    mechanics = make(PlaneStrain(), NEO, fixed=["left"])
    random_activation(mechanics)
    mechanics.start()
    nodal = mechanics.displacement()
    u, X = displacement_dofs(mechanics)
    vertices = nodal.function_space.tabulate_dof_coordinates()[:, :2]
    nearest = np.argmin(np.linalg.norm(X[None] - vertices[:, None], axis=2), axis=1)
    np.testing.assert_allclose(nodal.x.array.reshape(-1, 2), u[nearest], rtol=0, atol=1e-14)


LINE = ms.geometry.Line(length=1.0, spacing=0.5)
BAD = {
    "a spring is no sheet": (dict(material=Spring()), "material.model", "NeoHookean"),
    "plane stress is no line": (dict(body=LINE), "mechanics.kinematics", "dimension"),
    "a line is no sheet": (dict(kinematics=Line()), "mechanics.kinematics", "dimension"),
    "no line of rubber": (dict(body=LINE, kinematics=Line()), "material.model", "Spring"),
    "negative spring": (dict(robin=-1.0), "mechanics.robin", "greater than or equal to 0"),
    "spring not a number": (dict(robin=np.nan), "mechanics.robin", "finite"),
    "endless spring": (dict(robin=np.inf), "mechanics.robin", None),
    "unknown fixed side": (dict(fixed=["lft"]), None, "did you mean 'left'"),
    "unknown side on springs": (dict(robin=1.0, robin_boundary=["lft"]), None, "did you mean 'left'"),
    "unknown side, no springs": (dict(robin_boundary=["lft"]), None, "did you mean 'left'"),
    "springs nowhere": (dict(robin=1.0, robin_boundary=[]), None, None),
    "negative time": (dict(relaxation_time=-1.0), "mechanics.relaxation_time", "greater than or equal to 0"),
    "stretch of three directions": (
        dict(imposed_stretch=ms.ImposedStretch(value=(1.0, 1.0, 1.0))),
        "mechanics.imposed_stretch",
        None,
    ),
    "loaded and not held": (dict(body_force=ufl.as_vector([1.0, 0.0])), None, None),
}


@pytest.mark.parametrize("parts, key, said", BAD.values(), ids=BAD.keys())
def test_parts_that_do_not_fit(parts, key, said):
    """Mechanics: InputError names the key and what is allowed, before anything is solved (the interface)."""
    parts = dict(kinematics=PlaneStress(), material=NEO) | parts
    geometry = parts.pop("body", None)
    body = ms.build(geometry) if geometry else sheet()
    with pytest.raises(ms.InputError, match=said) as caught:
        ms.Mechanics(
            body,
            **described(parts),
        )
    assert key is None or caught.value.key == key


@pytest.mark.parametrize("until", [0.0, -1.0, np.nan])
def test_imposed_stretch_refuses_a_time_that_is_none(until):
    """ImposedStretch: a positive time or inf."""
    with pytest.raises(ValueError, match="until"):
        ms.ImposedStretch(until=until)


@pytest.mark.parametrize("value", [0.0, -1.0, (1.0, 0.0), np.inf])
def test_imposed_stretch_is_positive(value):
    """ImposedStretch: stretches are positive numbers."""
    with pytest.raises(ValueError, match="value"):
        ms.ImposedStretch(value=value)


def test_inverted_sheet_is_an_error():
    """Mechanics.solve: ComputationError where the body is inverted; det Fo = 1 + γ < 0 is no deformation
    (1.2).
    """
    mechanics = make(PlaneStress(), NEO, active=GivenStrain(-1.5), robin=1.0)
    with pytest.raises(ms.ComputationError):
        mechanics.start()
