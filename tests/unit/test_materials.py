"""Conformance of every exported material, and the formulas of those that the paper prints."""

import dataclasses

from myostrain import materials
from myostrain.materials import MooneyRivlin, NeoHookean, Spring

import numpy as np
import pytest

from material_tools import N, Points, changed
from mechanics_tools import (
    deformations,
    moduli,
    mooney_rivlin_energy,
    mooney_rivlin_stress,
    rotations,
)

CLASSES = [cls for name in materials.__all__ if (cls := getattr(materials, name)) is not materials.Material]


@pytest.fixture(scope="module", params=[(cls, other) for cls in CLASSES for other in (False, True)], ids=str)
def points(request):
    cls, other = request.param
    return Points(changed(cls()) if other else cls())


@pytest.fixture
def rng():
    return np.random.default_rng(20110217)


def samples(dim, rng, **others):
    """Deformations of up to a quarter, and frames; exponential laws at more are all in one sample."""
    return deformations(N, dim, rng, low=0.8, high=1.25, **others), rotations(N, dim, rng)


def difference(f, h):
    """Sixth-order central difference of f at 0."""
    once, twice, thrice = (f(i * h) - f(-i * h) for i in (1, 2, 3))
    return (45 * once - 9 * twice + thrice) / (60 * h)


def test_stress_and_tangent_are_the_derivatives_of_the_energy(points, rng):
    """CONTRIBUTING: "stress and tangent are derivatives that UFL takes", here against finite differences."""
    F, frame = samples(points.dim, rng)
    H = rng.standard_normal(F.shape)
    H /= np.linalg.norm(H, axis=(1, 2), keepdims=True)
    _, P, tangent = points(F, frame, H)
    h = 2e-5  # the steepest switch takes some 0.01
    energy_rate = difference(lambda h: points(F + h * H, frame)[0], h)
    stress_rate = difference(lambda h: points(F + h * H, frame)[1], h)
    # Measured 3e-12 of the largest value, round-off / h. None of these samples is so near to a jump of the
    # third derivative (the switch of tension in HolzapfelOgden2009) that the differences reach across.
    np.testing.assert_allclose(
        energy_rate, (P * H).sum((1, 2)), rtol=0, atol=1e-10 * np.abs(energy_rate).max()
    )
    np.testing.assert_allclose(stress_rate, tangent, rtol=0, atol=1e-10 * np.abs(stress_rate).max())


def test_objectivity(points, rng):
    """(1.3) with frame indifference: W(Q Fe) = W(Fe) and P(Q Fe) = Q P(Fe)."""
    F, frame = samples(points.dim, rng)
    Q = rotations(N, points.dim, rng)
    W, P, _ = points(F, frame)
    turned_W, turned_P, _ = points(Q @ F, frame)
    # Measured 1e-15 of the largest value.
    np.testing.assert_allclose(turned_W, W, rtol=0, atol=1e-13 * np.abs(W).max())
    np.testing.assert_allclose(turned_P, Q @ P, rtol=0, atol=1e-13 * np.abs(P).max())


def test_symmetry_is_that_of_the_fibres_and_sheets(points, rng):
    """W(Fe Qᵀ, Q f0, Q s0, Q n0) = W(Fe, f0, s0, n0), and the same with any of them reversed: nothing else is
    a special direction, and these have no sense.
    """
    F, frame = samples(points.dim, rng)
    Q = rotations(N, points.dim, rng)
    W = points(F, frame)[0]
    turned = points(F @ Q.transpose(0, 2, 1), Q @ frame)[0]
    np.testing.assert_allclose(turned, W, rtol=0, atol=1e-13 * np.abs(W).max())  # measured 1e-15
    for reversed_one in np.eye(points.dim):
        W_reversed = points(F, frame * (1 - 2 * reversed_one))[0]
        np.testing.assert_allclose(W_reversed, W, rtol=0, atol=1e-13 * np.abs(W).max())


@pytest.mark.parametrize("cls", [NeoHookean, MooneyRivlin])
def test_isotropy(cls, rng):
    """(3.1) sees invariants of Fe Feᵀ only: W(Fe Q) = W(Fe) whatever the fibre."""
    points = Points(changed(cls()))
    F, frame = samples(3, rng)
    W = points(F, frame)[0]
    turned = points(F @ rotations(N, 3, rng), frame)[0]
    np.testing.assert_allclose(turned, W, rtol=0, atol=1e-13 * np.abs(W).max())


def test_natural_state(points, rng):
    """W(1) = 0 and the stress there is a pressure (none on a line); W > 0 in every other isochoric state."""
    deformed, frame = samples(points.dim, rng, isochoric=points.dim > 1)
    one = np.broadcast_to(np.eye(points.dim), deformed.shape)
    W, P, _ = points(one, frame)
    pressure = np.trace(P, axis1=1, axis2=2) / points.dim
    size = max(1.0, np.abs(points(deformed, frame)[1]).max() / 100)  # of laws in Pa
    np.testing.assert_allclose(W, 0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(P, pressure[:, None, None] * one, rtol=0, atol=1e-14 * size)
    if points.dim == 1:
        np.testing.assert_allclose(P, 0, rtol=0, atol=1e-14)
    assert points(deformed, frame)[0].min() > 0


@pytest.mark.parametrize(
    "material", [NeoHookean(mu=1.7), MooneyRivlin(mu=1.7, mu_2=0.6), MooneyRivlin(mu=0.4)], ids=str
)
def test_incompressible_materials_are_the_papers(material, rng):
    """(3.1), (3.2) against numpy, with the second invariant as |cof Fe|²; pressure μ + 2 μ₂ at rest."""
    points = Points(material)
    F, frame = deformations(N, 3, rng), rotations(N, 3, rng)
    W, P, _ = points(F, frame)
    np.testing.assert_allclose(W, mooney_rivlin_energy(F, *moduli(material)), rtol=0, atol=1e-13 * W.max())
    np.testing.assert_allclose(P, mooney_rivlin_stress(F, *moduli(material)), rtol=0, atol=1e-13 * P.max())
    mu, mu_2 = moduli(material)
    at_rest = points(np.broadcast_to(np.eye(3), F.shape), frame)[1]
    np.testing.assert_allclose(at_rest[:, 0, 0], mu + 2 * mu_2, rtol=1e-14)


def test_spring_is_linear(rng):
    """(4.2): P = μ (Fe − 1), so that the least energy is at Fe = 1 (docs/model/readings.md)."""
    Fe = rng.uniform(0.2, 2.0, (N, 1, 1))
    W, P, _ = Points(Spring(mu=2.5))(Fe, np.ones((N, 1, 1)))
    np.testing.assert_allclose(P, 2.5 * (Fe - 1), rtol=0, atol=1e-14)
    np.testing.assert_allclose(W, 1.25 * (Fe[:, 0, 0] - 1) ** 2, rtol=0, atol=1e-14)


@pytest.mark.parametrize("cls, name", [(cls, f.name) for cls in CLASSES for f in dataclasses.fields(cls)])
@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, "stiff"])
def test_parameters_are_checked(cls, name, value):
    """Design: descriptions are validated. What is no number, infinite or negative is refused at once."""
    with pytest.raises(ValueError, match=name):
        cls(**{name: value})


@pytest.mark.parametrize("cls", [NeoHookean, MooneyRivlin, Spring])
def test_a_modulus_is_positive(cls):
    """The docstrings: μ is positive."""
    with pytest.raises(ValueError, match="mu"):
        cls(mu=0.0)


def test_descriptions_are_frozen_and_know_their_names():
    """Design: descriptions are frozen and validated; options are never silently ignored."""
    with pytest.raises(ValueError, match="mu_2"):
        MooneyRivlin(mu_2=-0.1)
    with pytest.raises(ValueError, match="mu_2"):
        NeoHookean(mu_2=0.1)
    with pytest.raises(dataclasses.FrozenInstanceError):
        NeoHookean().mu = 2.0
