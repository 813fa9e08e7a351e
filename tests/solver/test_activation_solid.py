"""Active deformations and active tensions of solids: formulas, and blocks with closed forms."""

import myostrain as ms
from myostrain.activation import ActiveStress, Fibre, FibreTension, Orthotropic, TransverselyIsotropic
from myostrain.geometry import Microstructure, Slab, UniformFibres
from myostrain.kinematics import Line, PlaneStress, Solid
from myostrain.materials import Guccione1995, HolzapfelOgden2009, NeoHookean, Spring, Usyk2002
from myostrain.validation import with_constants

import numpy as np
import pytest
import ufl

from mechanics_tools import (
    at_midpoints,
    deformations,
    described,
    field,
    gradient,
    put,
    rotations,
    sample_mesh,
    sheet,
)

N = 48
MU, GAMMA = 1.7, -0.2


@pytest.fixture
def rng():
    return np.random.default_rng(2014)


def stretches(deformation, gamma):
    """Fo in the frame of its own fibres (n, 3), by UFL without a mesh."""
    axes = Microstructure(*(ufl.as_vector(list(row)) for row in np.eye(3)))
    Fo = deformation.tensor(ufl.as_ufl(gamma), axes)
    return np.array([[float(Fo[i, j](())) for j in range(3)] for i in range(3)])


@pytest.mark.parametrize("gamma", [-0.3, -0.05, 0.1])
def test_isochoric_deformations_keep_the_volume(gamma):
    """TransverselyIsotropic and Orthotropic, docstrings: det Fo = 1; with κ = 1 these are one, κ scales the
    normal's strain, and no other direction is strained than f0, s0, n0.
    """
    alike = stretches(TransverselyIsotropic(), gamma)
    np.testing.assert_allclose(
        alike, np.diag([1 + gamma, (1 + gamma) ** -0.5, (1 + gamma) ** -0.5]), rtol=1e-15
    )
    np.testing.assert_allclose(stretches(Orthotropic(kappa=1.0), gamma), alike, rtol=1e-14, atol=1e-15)
    for kappa in (-1.0, 0.0, 0.5, 2.0):
        Fo = stretches(Orthotropic(kappa=kappa), gamma)
        assert np.linalg.det(Fo) == pytest.approx(1.0, rel=1e-14)
        assert Fo[0, 0] == pytest.approx(1 + gamma, rel=1e-15)
        assert Fo[2, 2] == pytest.approx(1 + kappa * ((1 + gamma) ** -0.5 - 1), rel=1e-15)
        np.testing.assert_array_equal(Fo, np.diag(np.diag(Fo)))


def test_kappa_may_vary_through_the_wall():
    """Orthotropic, docstring: κ may be a UFL scalar, here κ_endo + (κ_epi − κ_endo) ξ."""
    mesh = sample_mesh(N)
    xi = ufl.SpatialCoordinate(mesh)[0]
    axes = Microstructure(*(ufl.as_vector(list(row)) for row in np.eye(3)))
    Fo = with_constants(Orthotropic(kappa=0.75 - 0.5 * xi), mesh).tensor(ufl.as_ufl(-0.2), axes)
    values = at_midpoints(ufl.diag_vector(Fo), mesh)()
    kappa = 0.75 - 0.5 * (np.arange(N) + 0.5) / N
    np.testing.assert_allclose(values[:, 2], 1 + kappa * (0.8**-0.5 - 1), rtol=1e-14)
    np.testing.assert_allclose(values.prod(axis=1), 1, rtol=1e-14)


@pytest.mark.parametrize("gamma", [-0.24, -0.1, 0.05])
def test_the_normal_may_shorten_with_the_fibre(gamma):
    """Orthotropic, docstring: Rossi et al. 2014, γ_n = 4 γ_f, γ_s = 1/((1 + γ_f)(1 + γ_n)) − 1; and the sum
    of both that svFSI takes for Barbarotta et al. 2018, γ_n = (1 − ξ) 4 γ + ξ ((1 + γ)^(−½) − 1).
    """
    rossi = np.diag([1 + gamma, 1 / ((1 + gamma) * (1 + 4 * gamma)), 1 + 4 * gamma])
    np.testing.assert_allclose(stretches(Orthotropic(kappa=0.0, ratio=4.0), gamma), rossi, rtol=1e-14)
    xi = 0.3
    mixed = stretches(Orthotropic(kappa=xi, ratio=4 * (1 - xi)), gamma)
    normal = 1 + (1 - xi) * 4 * gamma + xi * ((1 + gamma) ** -0.5 - 1)
    np.testing.assert_allclose(np.diag(mixed)[[0, 2]], [1 + gamma, normal], rtol=1e-14)
    assert np.linalg.det(mixed) == pytest.approx(1.0, rel=1e-14)
    # To first order in γ, κ stands for K = −κ/2.
    by_kappa, by_ratio = (
        np.diag(stretches(Orthotropic(**law), 1e-5 * gamma)) - 1
        for law in ({"kappa": -1.4}, {"kappa": 0.0, "ratio": 0.7})
    )
    np.testing.assert_allclose(by_kappa, by_ratio, rtol=1e-5)  # the next order: 3/4 of 1e-5 γ


def test_a_normal_that_turns_over_is_no_deformation():
    """Orthotropic, docstring: 1 + γ_n ≤ 0 is not admissible, although det Fo = 1; no number comes out, so
    that the check of det Fo before each accepted step sees it.
    """
    mesh = sample_mesh(N)
    axes = Microstructure(*(ufl.as_vector(list(row)) for row in np.eye(3)))
    gamma = -0.5 * ufl.SpatialCoordinate(mesh)[0]
    Fo = with_constants(Orthotropic(kappa=0.0, ratio=4.0), mesh).tensor(gamma, axes)
    values = at_midpoints(ufl.as_vector([ufl.det(Fo)]), mesh)()[:, 0]
    admissible = 2 * (np.arange(N) + 0.5) / N < 1  # 4 γ > −1
    np.testing.assert_allclose(values[admissible], 1, rtol=1e-14)
    assert np.isnan(values[~admissible]).all()
    assert admissible.sum() == N // 2


@pytest.mark.parametrize("given", [True, "much", np.nan, np.inf, ufl.Identity(3)])
def test_coefficients_are_checked(given):
    """Descriptions are validated: κ is a finite number or a scalar field, T positive besides."""
    for make, name in (
        (lambda x: Orthotropic(kappa=x), "kappa"),
        (lambda x: Orthotropic(ratio=x), "ratio"),
        (lambda x: ActiveStress(tension=x), "tension"),
    ):
        with pytest.raises(ValueError, match=name):
            make(given)
    with pytest.raises(ValueError, match="tension"):
        ActiveStress(tension=-1.0)
    with pytest.raises(ValueError, match="transverse"):
        FibreTension(transverse=-0.1)


@pytest.mark.parametrize("transverse", [0.0, 0.3])
def test_a_tension_acts_along_the_fibre(transverse, rng):
    """FibreTension and ActiveStress, docstrings (Land et al. 2015, problem 3): P = F S,
    S = Ta (f0⊗f0 + η (1 − f0⊗f0)), Ta = T v for v > 0, else none; objective; and the energy is zero at rest.
    """
    mesh = sample_mesh(N)
    F_, f_, T_ = field(mesh, (3, 3)), field(mesh, (3,)), field(mesh, ())
    F = ufl.variable(F_)
    active = with_constants(FibreTension(transverse=transverse), mesh)
    W = active.energy(F, Microstructure(f_), T_)
    P = ufl.diff(W, F)
    evaluate = at_midpoints(ufl.as_vector([W, *(P[i, j] for i in range(3) for j in range(3))]), mesh)
    deformed, frame = deformations(N, 3, rng), rotations(N, 3, rng)
    v = rng.uniform(-0.5, 1.0, N)
    tension = ActiveStress(tension=60.0).activation((), {"excitation": v})
    for function, samples in ((F_, deformed), (f_, frame[:, :, 0]), (T_, tension)):
        put(function, samples)
    stress = frame * np.array([1.0, transverse, transverse]) @ frame.transpose(0, 2, 1)
    by_hand = 60.0 * np.maximum(v, 0)[:, None, None] * (deformed @ stress)
    values = evaluate()
    np.testing.assert_allclose(values[:, 1:].reshape(-1, 3, 3), by_hand, rtol=0, atol=1e-12)  # measured 1e-14
    put(F_, rotations(N, 3, rng))
    np.testing.assert_allclose(evaluate()[:, 0], 0, atol=1e-12)
    put(F_, rotations(N, 3, rng) @ deformed)
    np.testing.assert_allclose(evaluate()[:, 0], values[:, 0], rtol=0, atol=1e-12)


def block(direction=(1.0, 0.0, 0.0), sheet_direction=(0.0, 1.0, 0.0)):
    """Twelve tetrahedra."""
    fibres = UniformFibres(direction=direction, sheet=sheet_direction)
    return ms.build(Slab(size=(2.0, 1.0, 1.0), spacing=1.0), fibres)


def settled(body, activation=GAMMA, **parts):
    """Mechanics in equilibrium with a uniform γ, or tension."""
    parts = {"kinematics": Solid(), "material": NeoHookean(mu=MU), **parts}
    mechanics = ms.Mechanics(
        body,
        **described(parts),
    )
    mechanics.activation.x.array[:] = activation
    mechanics.start()
    return mechanics


def fibre_frame(body):
    """Directions f0, s0, n0 as columns."""
    return np.column_stack([d.value for d in (body.fibres.f0, body.fibres.s0, body.fibres.n0)])


def cauchy(mechanics):
    return at_midpoints(mechanics.cauchy(), mechanics.body.mesh)()


OBLIQUE = {"direction": (1.0, 0.5, -0.3), "sheet_direction": (0.2, 1.0, 0.4)}
ALIKE = [1 + GAMMA, (1 + GAMMA) ** -0.5, (1 + GAMMA) ** -0.5]
ORTHOTROPIC = np.diag(stretches(Orthotropic(), GAMMA))
FREE = [
    (Fibre(), "total", NeoHookean(mu=MU), [(1 + GAMMA) ** (2 / 3), *[(1 + GAMMA) ** (-1 / 3)] * 2]),
    (Fibre(), "elastic", NeoHookean(mu=MU), [1 + GAMMA, 1.0, 1.0]),
    (TransverselyIsotropic(), "total", Guccione1995(), ALIKE),
    (Orthotropic(), "elastic", Usyk2002(), ORTHOTROPIC),
    pytest.param(TransverselyIsotropic(), "elastic", NeoHookean(mu=MU), ALIKE, marks=pytest.mark.slow),
    pytest.param(Orthotropic(), "total", NeoHookean(mu=MU), ORTHOTROPIC, marks=pytest.mark.slow),
]


@pytest.mark.parametrize("deformation, constraint, material, expected", FREE)
def test_free_block_takes_the_active_deformation(deformation, constraint, material, expected):
    """A free block under uniform γ is without stress, and takes Fo itself where det Fo is what the constraint
    asks for, as any passive law is at its minimum in Fe = 1. With Fo = 1 + γ f⊗f and J = 1 the neo-Hookean
    block minimizes λ²/(1+γ)² + 2/λ: λ³ = (1+γ)².
    """
    body = block(**OBLIQUE)
    kinematics = Solid(constraint=constraint)
    mechanics = settled(body, kinematics=kinematics, active=deformation, material=material)
    F, frame = gradient(mechanics), fibre_frame(body)
    C = frame @ np.diag(np.square(expected)) @ frame.T
    np.testing.assert_allclose(F.transpose(0, 2, 1) @ F, np.broadcast_to(C, F.shape), rtol=0, atol=1e-9)
    np.testing.assert_allclose(cauchy(mechanics), 0, rtol=0, atol=1e-8)


ISOMETRIC = [
    # Jo ∂W/∂Fe Fo⁻ᵀ in F = 1: μ Jo Fo⁻¹ Fo⁻ᵀ for the neo-Hookean block.
    ({"active": Fibre()}, MU * (1 + GAMMA) * ((1 + GAMMA) ** -2 - 1)),
    ({"active": TransverselyIsotropic()}, MU * ((1 + GAMMA) ** -2 - (1 + GAMMA))),
    ({"active": FibreTension(transverse=0.25), "activation": 2.0}, 2.0 * (1 - 0.25)),
]


@pytest.mark.parametrize("parts, expected", ISOMETRIC, ids=["fibre", "transversely isotropic", "tension"])
def test_isometric_stress_of_a_clamped_block(parts, expected):
    """A block clamped at both ends, its sides free, stays as it is (u = 0), since what the sides feel is a
    pressure; the stress along the fibre is the active one alone.
    """
    mechanics = settled(block(), fixed=["left", "right"], **parts)
    assert np.abs(gradient(mechanics) - np.eye(3)).max() < 1e-9  # measured 1e-14
    stress = np.zeros((3, 3))
    stress[0, 0] = expected
    np.testing.assert_allclose(cauchy(mechanics), np.broadcast_to(stress, (12, 3, 3)), rtol=0, atol=1e-8)


@pytest.mark.parametrize("transverse", [0.0, 0.4])
def test_free_block_under_tension(transverse):
    """The free neo-Hookean block minimizes μ/2 (λ² + 2/λ) + Ta/2 (λ² + 2 η/λ): λ³ = (μ + η Ta)/(μ + Ta)."""
    body = block(**OBLIQUE)
    mechanics = settled(body, 1.0, active=FibreTension(transverse=transverse))
    F, frame = gradient(mechanics), fibre_frame(body)
    along = ((MU + transverse * 1.0) / (MU + 1.0)) ** (1 / 3)
    C = frame @ np.diag([along**2, 1 / along, 1 / along]) @ frame.T
    np.testing.assert_allclose(F.transpose(0, 2, 1) @ F, np.broadcast_to(C, F.shape), rtol=0, atol=1e-9)
    np.testing.assert_allclose(cauchy(mechanics), 0, rtol=0, atol=1e-8)


def test_active_strain_and_stress_shorten_alike_where_these_are_matched():
    """One block, one passive law, both approaches: Ta = μ ((1+γ)⁻² − 1) shortens the free block as
    Fo = 1 + γ f⊗f does, where J = 1 (both λ³ = (1+γ)², by the two closed forms).
    """
    by_strain = gradient(settled(block(), active=Fibre()))
    by_stress = gradient(settled(block(), MU * ((1 + GAMMA) ** -2 - 1), active=FibreTension()))
    np.testing.assert_allclose(by_strain, by_stress, rtol=0, atol=1e-9)


def test_tension_in_a_sheet_and_on_a_line():
    """FibreTension takes F in the dimension of materials: λ³ = μ/(μ + Ta) of a free sheet in plane stress,
    as of a block; a free line has μ (x′ − 1) + Ta x′ = 0.
    """
    F = gradient(settled(sheet(), 1.0, kinematics=PlaneStress(), active=FibreTension()))
    along = (MU / (MU + 1.0)) ** (1 / 3)
    found = np.linalg.eigvalsh(F.transpose(0, 2, 1) @ F)
    np.testing.assert_allclose(found, np.broadcast_to([along**2, 1 / along], found.shape), rtol=1e-8)
    line = ms.build(ms.geometry.Line(length=2.0, spacing=0.5))
    x = gradient(settled(line, 1.0, kinematics=Line(), material=Spring(mu=MU), active=FibreTension()))
    np.testing.assert_allclose(x, MU / (MU + 1.0), rtol=1e-9)


def test_orthotropic_parts_need_sheets():
    """InputError with the key, before anything is compiled, where the body has fibres only."""
    body = ms.build(Slab(size=(1.0, 1.0, 1.0)), UniformFibres(direction=(1.0, 0.0, 0.0)))
    for parts in ({"active": Orthotropic()}, {"material": HolzapfelOgden2009()}):
        with pytest.raises(ms.InputError, match=r"fibres\.sheet"):
            settled(body, **parts)


def test_a_script_may_change_the_tension():
    """Mechanics.activation: the tension at the nodes, which a script may change."""
    mechanics = settled(block(), 0.5, active=FibreTension())
    for value in (0.5, 1.0):
        mechanics.activation.x.array[:] = value
        mechanics.solve(0.0)
        along = np.linalg.norm(gradient(mechanics)[:, :, 0], axis=1)
        np.testing.assert_allclose(along, (MU / (MU + value)) ** (1 / 3), rtol=1e-9)
