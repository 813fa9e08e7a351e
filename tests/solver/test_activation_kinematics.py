"""Activation laws, active deformations, and what a line or a sheet means in three dimensions."""

import myostrain as ms
from myostrain import activation, kinematics
from myostrain.activation import Fibre, FibreTension, Orthotropic, Proportional
from myostrain.geometry import Microstructure
from myostrain.kinematics import Deformation, Line, PlaneStrain, PlaneStress
from myostrain.materials import MooneyRivlin

import numpy as np
import pytest
import ufl

from mechanics_tools import (
    active,
    at_midpoints,
    deformations,
    directions,
    field,
    lifted,
    mooney_rivlin_energy,
    put,
    rotations,
    sample_mesh,
)

N = 48
EXPORTS = [
    getattr(activation, name)
    for name in activation.__all__
    if not getattr(getattr(activation, name), "_is_protocol", False)
    and name not in ("NodalActivation", "Yield")  # what owns a law's states, and a type
]
LAWS = [cls for cls in EXPORTS if hasattr(cls, "activation")]
DEFORMATIONS = [cls for cls in EXPORTS if hasattr(cls, "tensor")]
TENSIONS = [cls for cls in EXPORTS if hasattr(cls, "energy")]
SHEETS = [cls(constraint=c) for cls in (PlaneStress, PlaneStrain) for c in ("total", "elastic")]


@pytest.fixture
def rng():
    return np.random.default_rng(142)


class Active:
    """Fo of a deformation at N samples, in UFL and evaluated; frames have f0, s0, n0 as columns.

    In less than three dimensions there are fibres only.
    """

    def __init__(self, deformation, dim):
        mesh = sample_mesh(N)
        self._gamma = field(mesh, ())
        self._directions = [field(mesh, (dim,)) for _ in range(3 if dim == 3 else 1)]
        self._evaluate = at_midpoints(
            deformation.tensor(self._gamma, Microstructure(*self._directions)), mesh
        )

    def __call__(self, gamma, frame):
        put(self._gamma, gamma)
        for i, direction in enumerate(self._directions):
            put(direction, frame[:, :, i])
        return self._evaluate()


def test_every_export_is_a_law_a_deformation_or_a_tension():
    """activation/__init__: a law has activation(states, drivers), a deformation has tensor(gamma, fibres), a
    tension has energy(F, fibres, tension); each export is one of them.
    """
    assert {Proportional} <= set(LAWS)
    assert {Fibre} <= set(DEFORMATIONS)
    assert {FibreTension} <= set(TENSIONS)
    assert all(sum(cls in kind for kind in (LAWS, DEFORMATIONS, TENSIONS)) == 1 for cls in EXPORTS)


#: Where nothing is by default.
NEEDED = {"Timed": {"gamma_min": -0.13, "start": 0.0, "end": 1.0}}


@pytest.mark.parametrize("law", [cls(**NEEDED.get(cls.__name__, {})) for cls in LAWS], ids=str)
def test_law_conformance(law):
    """interface: no activation at rest; at full excitation contraction without singular Fo, or a tension;
    pointwise, and neither states nor drivers are changed. A law with states is taken to its end for frozen
    drivers, in one step or many alike.
    """
    v = np.linspace(0.0, 1.0, N)
    every = {
        "excitation": v,
        "potential": 120 * v - 80,
        "calcium": 0.1 + 0.9 * v,
        "stretch": np.ones(N),
        "time": 0.5,
    }
    assert set(law.drivers) <= every.keys()
    drivers = {name: np.copy(every[name]) for name in law.drivers}
    states = np.zeros((0, N))
    if names := getattr(law, "states", ()):
        found = law.initial_states(drivers)
        start = np.array([np.broadcast_to(s, (N,)) for s in found])
        assert len(start) == len(names)
        kept, walked = start.copy(), start
        states = law.advance(start, drivers, 1e5)
        np.testing.assert_array_equal(start, kept)
        assert states.shape == (len(names), N)
        for _ in range(5):
            walked = law.advance(walked, drivers, 0.02)
        np.testing.assert_allclose(walked, law.advance(start, drivers, 0.1), rtol=1e-12, atol=1e-15)
    found = np.broadcast_to(law.activation(states, drivers), (N,))
    for name in law.drivers:
        np.testing.assert_array_equal(drivers[name], every[name])
    if "time" not in law.drivers:
        assert abs(found[0]) < 1e-12
    if law.yields == "strain":
        assert -1 < found[-1] < 0
    else:
        assert found[-1] > 0
    some = slice(7, 23)
    part = {name: values[some] if np.ndim(values) else values for name, values in drivers.items()}
    np.testing.assert_allclose(law.activation(states[:, some], part), found[some], rtol=1e-14)


@pytest.mark.parametrize("dim", [1, 2, 3])
@pytest.mark.parametrize("deformation", [cls() for cls in DEFORMATIONS], ids=str)
def test_active_deformation_conformance(deformation, dim, rng):
    """(1.2): Fo = 1 without activation, Fo is positive definite, and turning fibres and sheets turns Fo:
    Fo(Q n) = Q Fo(n) Qᵀ. What needs sheets says so where there are none.
    """
    if dim < 3 and isinstance(deformation, Orthotropic):
        with pytest.raises(ms.InputError, match=r"fibres\.sheet"):
            Active(deformation, dim)
        return
    evaluate = Active(deformation, dim)
    gamma, frame, Q = rng.uniform(-0.6, 0.6, N), rotations(N, dim, rng), rotations(N, dim, rng)
    Fo = evaluate(gamma, frame)
    one = np.broadcast_to(np.eye(dim), Fo.shape)
    np.testing.assert_allclose(evaluate(np.zeros(N), frame), one, rtol=0, atol=1e-15)
    assert np.linalg.eigvalsh(Fo).min() > 0
    turned = evaluate(gamma, Q @ frame)
    np.testing.assert_allclose(turned, Q @ Fo @ Q.transpose(0, 2, 1), rtol=0, atol=1e-14)  # measured 1e-15


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_fibre_deforms_the_fibre_alone(dim, rng):
    """(1.4): Fo n = (1 + γ) n, Fo m = m across, so det Fo = 1 + γ."""
    gamma, frame = rng.uniform(-0.6, 0.6, N), rotations(N, dim, rng)
    Fo, n = Active(Fibre(), dim)(gamma, frame), frame[:, :, 0]
    across = rng.standard_normal((N, dim))
    across -= (across * n).sum(1, keepdims=True) * n
    np.testing.assert_allclose(np.einsum("nij,nj->ni", Fo, n), (1 + gamma)[:, None] * n, rtol=0, atol=1e-14)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", Fo, across), across, rtol=0, atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(Fo), 1 + gamma, rtol=1e-13)


def test_proportional_law():
    """(3.4): γ = −β v; β = 0.3 unless given, 0 ≤ β < 1."""

    def gamma(law, v):
        return law.activation((), {"excitation": v})

    assert gamma(Proportional(), 1.0) == -0.3
    np.testing.assert_array_equal(
        gamma(Proportional(beta=0.5), np.array([0.0, 0.5, -0.2])), [0.0, -0.25, 0.1]
    )
    assert gamma(Proportional(beta=0.0), 0.7) == 0


@pytest.mark.parametrize("beta", [-0.1, 1.0, 1.5, np.nan, np.inf, "much"])
def test_proportional_law_refuses(beta):
    """Proportional: 0 ≤ β < 1; at β = 1 the active deformation is singular."""
    with pytest.raises(ValueError, match="beta"):
        Proportional(beta=beta)


class Lifted:
    """A kinematics' lift, volume ratio and constraint at N samples; the energy of a material on the lift."""

    def __init__(self, kinematic, material=None):
        mesh = sample_mesh(N)
        dim, tensor_dim = kinematic.dim, kinematic.tensor_dim
        self._F, self._gamma, self._n = field(mesh, (dim, dim)), field(mesh, ()), field(mesh, (tensor_dim,))
        Fo = Fibre().tensor(self._gamma, Microstructure(self._n))
        Jo = ufl.det(Fo)
        F = kinematic.lift(self._F, Jo)
        terms = [F[i, j] for i in range(tensor_dim) for j in range(tensor_dim)]
        terms += [ufl.as_ufl(kinematic.volume_ratio(self._F, Jo))]
        terms += [kinematic.constraint_residual(self._F, Jo) if kinematic.has_pressure else 0]
        terms += [Jo * material.energy(F * ufl.inv(Fo), Microstructure(self._n)) if material else 0]
        self._evaluate, self._dim = at_midpoints(ufl.as_vector(terms), mesh), tensor_dim

    def __call__(self, F, gamma, n):
        put(self._F, F)
        put(self._gamma, gamma)
        put(self._n, n)
        values = self._evaluate()
        return values[:, :-3].reshape(N, self._dim, self._dim), *values[:, -3:].T


def in_plane(rng):
    """Gradients (N, 2, 2), active strains and fibres (N, 3) in the plane."""
    n = np.pad(directions(N, 2, rng), ((0, 0), (0, 1)))
    return deformations(N, 2, rng), rng.uniform(-0.6, 0.6, N), n


@pytest.mark.parametrize("kinematic", SHEETS, ids=str)
def test_sheets_in_three_dimensions(kinematic, rng):
    """Readings of the model, and (3.8): λ₃ = J / det F₂ in plane stress, 1 in plane strain, where the
    pressure drives det F₂ − J to zero; J = 1 for the body, Jo where the elastic part is isochoric. The
    energy is that of 3D.
    """
    mu, mu_2 = 1.7, 0.6
    F2, gamma, n = in_plane(rng)
    F, J, constraint, energy = Lifted(kinematic, MooneyRivlin(mu=mu, mu_2=mu_2))(F2, gamma, n)

    target = np.ones(N) if kinematic.constraint == "total" else 1 + gamma
    area = np.linalg.det(F2)
    plane_stress = isinstance(kinematic, PlaneStress)
    expected = lifted(F2, target / area if plane_stress else np.ones(N))
    np.testing.assert_allclose(F, expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(J, target, rtol=1e-14)
    if plane_stress:
        np.testing.assert_allclose(np.linalg.det(F), target, rtol=1e-13)
    else:
        np.testing.assert_allclose(constraint, area - target, rtol=0, atol=1e-14)
    Fe = expected @ np.linalg.inv(active(gamma, n))
    by_hand = (1 + gamma) * mooney_rivlin_energy(Fe, mu, mu_2)
    np.testing.assert_allclose(energy, by_hand, rtol=0, atol=1e-13 * by_hand.max())  # measured 1e-15


def test_plane_stress_energy_is_model_mds(rng):
    """Readings of the model: energy density μ/2 (1 + γ)(|F₂ Fo⁻¹|² + 1/(det F₂)² − 3) for the neo-Hookean
    sheet.
    """
    F2, gamma, n = in_plane(rng)
    *_, energy = Lifted(PlaneStress(), ms.materials.NeoHookean(mu=1.7))(F2, gamma, n)
    Fe = F2 @ np.linalg.inv(active(gamma, n[:, :2]))
    density = 0.85 * (1 + gamma) * ((Fe**2).sum((1, 2)) + np.linalg.det(F2) ** -2 - 3)
    np.testing.assert_allclose(energy, density, rtol=0, atol=1e-13 * density.max())


def test_line_is_one_dimensional(rng):
    """Readings of the model: F = J = x′, no transverse direction."""
    F = rng.uniform(0.5, 1.5, (N, 1, 1))
    F_seen, J, *_ = Lifted(Line())(F, rng.uniform(-0.5, 0.5, N), np.ones((N, 1)))
    np.testing.assert_array_equal(F_seen, F)
    np.testing.assert_array_equal(J, F[:, 0, 0])


@pytest.mark.parametrize("name", ["Line", "PlaneStress", "PlaneStrain"])
def test_kinematics_describe_themselves(name):
    """kinematics.Kinematics: dimensions are consistent, and where no pressure is unknown there is no
    constraint.
    """
    kinematic = getattr(kinematics, name)()
    assert (kinematic.dim, kinematic.tensor_dim) in {(1, 1), (2, 3)}
    if not kinematic.has_pressure:
        with pytest.raises(NotImplementedError):
            kinematic.constraint_residual(np.eye(kinematic.dim), 1.0)


@pytest.mark.parametrize("cls", [PlaneStress, PlaneStrain])
def test_constraint_is_one_of_two(cls):
    """Interface: constraint = "total" | "elastic"."""
    with pytest.raises(ValueError, match="constraint"):
        cls(constraint="none")


def test_isochoric_by_construction():
    """Deformation: J is the float one where the constraint says so, and no other J passes for it."""
    assert Deformation(F=None).isochoric
    assert Deformation(F=None, J=PlaneStress().volume_ratio(None, 0.7)).isochoric
    assert not Deformation(F=None, J=PlaneStress(constraint="elastic").volume_ratio(None, 0.7)).isochoric
    assert not Deformation(F=None, J=0.7).isochoric
