"""Closed forms of strong ellipticity against the energies' own second derivatives by differences."""

from myostrain.theory import (
    critical_slope,
    kinking_stretch,
    least_with_strain,
    least_with_tension,
    line_answer,
)

import numpy as np
import pytest

ONE = np.eye(3)
FIBRE = np.array([1.0, 0.0, 0.0])


def second(energy, F, a, m, h=1e-3):
    """d²/dε² of the energy along F + ε a⊗m, by differences of fourth order."""
    weights = zip((-2, -1, 0, 1, 2), (-1, 16, -30, 16, -1), strict=True)
    return sum(w * energy(F + k * h * np.outer(a, m)) for k, w in weights) / (12 * h**2)


def amplitudes(F, m, n):
    """Unit amplitudes a with a·F⁻ᵀm = 0."""
    normal = np.linalg.inv(F).T @ m
    across = np.linalg.svd(normal[None])[2][1:]
    angles = np.linspace(0, np.pi, n, endpoint=False)
    return np.cos(angles)[:, None] * across[0] + np.sin(angles)[:, None] * across[1]


def uniaxial(stretch):
    return np.diag([stretch, stretch**-0.5, stretch**-0.5])


@pytest.mark.parametrize("active", [(0.7, 1.0, 1.0), (1.2, 1.0, 1.0), (0.7, 0.7**-0.5, 0.7**-0.5)])
def test_neo_hookean_with_active_strain(active):
    """Least μ Jo/a², whatever F, over directions and amplitudes."""
    Fo, mu = np.diag(active), 1.3
    back = np.linalg.inv(Fo)

    def energy(F):
        return np.linalg.det(Fo) * mu / 2 * (((F @ back) ** 2).sum() - 3)

    F = np.array([[1.0, 0.4, 0.0], [0.0, 1.0, -0.3], [0.2, 0.0, 1.0]])
    rng = np.random.default_rng(0)
    tried = [*ONE, *rng.standard_normal((200, 3))]
    found = min(second(energy, F, ONE[0], m / np.linalg.norm(m)) for m in tried)
    assert found == pytest.approx(least_with_strain(active, mu), rel=1e-7)


@pytest.mark.parametrize(
    "stretch, tension, slope",
    [
        (1.2, 0.5, -4.0),
        (1.0, 1.0, -5.0),
        (0.8, 0.0, -3.0),
        (1.1, 2.0, 1.0),
        (1.3, -0.4, 0.0),
        (1.1, 1.0, -9.0),
    ],
)
def test_neo_hookean_with_a_tension_that_follows_the_stretch(stretch, tension, slope):
    """The energy is μ/2 (I₁ − 3) + ∫ T(λ) λ dλ: T here linear about the stretch."""

    def energy(F):
        lam = np.linalg.norm(F @ FIBRE)
        rise = tension - slope * stretch
        return ((F**2).sum() - 3) / 2 + rise * lam**2 / 2 + slope * lam**3 / 3

    F = uniaxial(stretch)
    found = min(
        second(energy, F, a, np.array([np.cos(t), np.sin(t), 0.0]))
        for t in np.linspace(0, np.pi / 2, 181)
        for a in amplitudes(F, np.array([np.cos(t), np.sin(t), 0.0]), 8)
    )
    assert found == pytest.approx(least_with_tension(stretch, tension, slope), abs=2e-3)
    assert found > least_with_tension(stretch, tension, slope) - 1e-6


def test_critical_slope():
    """At the slope of the closed form the least eigenvalue vanishes, near λ = 1 too; a little before, not."""
    T = np.array([0.0, 0.5, 3.0])
    for stretch, within in ((1.0, 1e-12), (1 + 1e-6, 1e-4)):
        np.testing.assert_allclose(least_with_tension(stretch, T, critical_slope(T)), 0, atol=within)
    assert np.all(least_with_tension(1.0, T, 0.99 * critical_slope(T)) > 0)


def test_kinking_of_fibres():
    """The second variation of W = C/2 (exp Q − 1) across the fibre changes its sign at the stretch."""
    b, shear, C = 8.0, 3.0, 0.7

    def energy(F):
        E = (F.T @ F - ONE) / 2
        return C / 2 * np.expm1(b * E[0, 0] ** 2 + 2 * shear * (E[0, 1] ** 2 + E[0, 2] ** 2) + E[1, 1] ** 2)

    for across in (1.0, 1.2):
        critical = float(kinking_stretch(b, shear, across))
        low, high = (
            second(energy, np.diag([critical * share, across, across]), ONE[1], FIBRE)
            for share in (0.999, 1.001)
        )
        assert low < 0 < high
    assert kinking_stretch(1.0, 2.0) == 0.0


def test_line():
    """d(ln Fe)/d(ln J) with V = J v kept, by differences; zero at βv = 1/2."""
    for b in (0.0, 0.3, 0.5, 0.8):
        low, high = (np.log(J / (1 - b / J)) for J in (1 - 1e-5, 1 + 1e-5))
        assert (high - low) / 2e-5 == pytest.approx(line_answer(b), abs=1e-7)
    assert line_answer(0.5) == 0.0
