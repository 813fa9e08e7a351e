"""Springs by active stress and active strain, (1.7)–(1.10), and (1.12) as the page measures it."""

from myostrain.reproduce.measurements import springs
from myostrain.theory import active_strain_force, active_stress_force, equivalent_active_force

import numpy as np
import pytest

from mechanics_tools import mooney_rivlin_stress

REST, ACTIVE, STIFFNESS = 1.0, 0.7, 1.3
LENGTHS = np.linspace(0.4, 1.8, 57)
SIZES = [0.3 / 2**k for k in range(9)]


def test_equations_as_printed():
    """(1.7)–(1.10), worked at one length by hand: ℓ = 1.2, ℓo = 1, ℓa = 0.7, k = 2, f_a = 0.5."""
    assert active_stress_force(1.2, 1.0, 0.5, stiffness=2.0) == pytest.approx(0.9, rel=1e-14)
    assert active_strain_force(1.2, 0.7, stiffness=2.0) == pytest.approx(1.0, rel=1e-14)
    assert active_stress_force(1.2, 1.0, 0.5, stiffness=2.0, power=3) == pytest.approx(0.516, rel=1e-13)
    assert active_strain_force(1.2, 0.7, stiffness=2.0, power=3) == pytest.approx(0.25, rel=1e-13)


def test_linear_springs_agree_with_the_papers_active_force():
    """Section 1.1: "equivalent provided that f_a = −k(ℓa − ℓo)", at every length: a few round-offs."""
    needed = equivalent_active_force(LENGTHS, REST, ACTIVE, stiffness=STIFFNESS)
    np.testing.assert_allclose(needed, -STIFFNESS * (ACTIVE - REST), rtol=4e-15)  # measured 6e-16


def test_cubic_springs_need_an_active_force_that_is_a_parabola_in_the_length():
    """(1.9), (1.10): −kδ(3e² − 3eδ + δ²), expanded apart from the code, least −kδ³/4 midway."""
    e, delta = LENGTHS - REST, ACTIVE - REST
    needed = equivalent_active_force(LENGTHS, REST, ACTIVE, stiffness=STIFFNESS, power=3)
    np.testing.assert_allclose(needed, -STIFFNESS * delta * (3 * e**2 - 3 * e * delta + delta**2), rtol=1e-13)
    midway = equivalent_active_force(0.85, REST, ACTIVE, stiffness=STIFFNESS, power=3)
    assert midway == pytest.approx(-STIFFNESS * delta**3 / 4, rel=1e-13)
    force = active_stress_force(LENGTHS, REST, needed, stiffness=STIFFNESS, power=3)
    strain = active_strain_force(LENGTHS, ACTIVE, stiffness=STIFFNESS, power=3)
    np.testing.assert_allclose(force, strain, rtol=0, atol=1e-15)


def test_best_constant_leaves_half_the_range():
    """The best constant of a range is its middle: here 0.0315 k of 0.027 … 0.063 k for ℓ in 0.9 … 1.1.

    (δ = −0.3, e = ±0.1: −kδ(0.03 ∓ 0.09 (−1) + 0.09) = 0.3 k (0.12 ± 0.09).)
    """
    found = springs.spring(3, STIFFNESS, REST, ACTIVE, [0.1], 2001).numbers
    assert found["smallest"][0] == pytest.approx(STIFFNESS * 0.3 * 0.03, rel=1e-12)
    assert found["largest"][0] == pytest.approx(STIFFNESS * 0.3 * 0.21, rel=1e-12)
    assert found["best_constant"][0] == pytest.approx(STIFFNESS * 0.3 * 0.12, rel=1e-12)
    assert found["error"][0] == pytest.approx(0.75, rel=1e-12)
    assert springs.spring(1, STIFFNESS, REST, ACTIVE, [0.5], 1001).numbers["constant_difference"][0] < 1e-15


@pytest.mark.parametrize(
    "change, message", [(dict(stiffness=0.0), "stiffness"), (dict(power=2), "power = 2")]
)
@pytest.mark.parametrize("function", [active_strain_force, active_stress_force, equivalent_active_force])
def test_errors_say_what_is_allowed(function, change, message):
    arguments = (1.2, 0.7) if function is active_strain_force else (1.2, 1.0, 0.7)
    with pytest.raises(ValueError, match=message):
        function(*arguments, **change)


MATERIALS = [
    ({"model": "NeoHookean", "mu": 1.7}, 1.7, 0.0),
    ({"model": "MooneyRivlin", "mu": 1.3, "mu_2": 0.6}, 1.3, 0.6),
]


@pytest.mark.parametrize("material, mu, mu_2", MATERIALS)
@pytest.mark.parametrize("form", ["residual-free", "pulled back", "energy alone"])
def test_differences_of_materials_are_those_of_matrices(material, mu, mu_2, form):
    """(1.12) through UFL and DOLFINx, against NumPy with the stress worked out by hand; measured 3e-16."""
    count, seed = 5, 7
    found = springs.small_strains(material, form, False, seed, count, SIZES)
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((count, 1, 3, 3))
    n = rng.standard_normal((count, 1, 3))
    g = rng.uniform(0.5, 1.0, (count, 1, 1, 1)) * rng.choice([-1.0, 1.0], (count, 1, 1, 1))
    p = 0.0 if form == "energy alone" else mu + 2 * mu_2

    def stress(F):
        return mooney_rivlin_stress(F, mu, mu_2) - p * np.linalg.det(F)[:, None, None] * np.linalg.inv(
            F
        ).transpose(0, 2, 1)

    for i in range(count):
        unit = n[i, 0] / np.linalg.norm(n[i, 0])
        eps = np.array(SIZES)[:, None, None]
        F = np.eye(3) + eps * A[i, 0] / np.linalg.norm(A[i, 0])
        Fo = np.eye(3) + eps * g[i] * np.outer(unit, unit)
        inverse = np.linalg.inv(Fo)
        strained = stress(F @ inverse)
        if form == "pulled back":
            strained = np.linalg.det(Fo)[:, None, None] * strained @ inverse.transpose(0, 2, 1)
        expected = np.linalg.norm(strained - stress(F) + stress(Fo), axis=(1, 2))
        np.testing.assert_allclose(found.arrays["differences"][i], expected, rtol=1e-8, atol=1e-14)


@pytest.mark.parametrize("form", ["residual-free", "pulled back"])
@pytest.mark.parametrize("material, mu, mu_2", [*MATERIALS, ({"model": "Spring", "mu": 2.0}, None, None)])
def test_order_of_1_12_is_two(material, mu, mu_2, form):
    """(1.12): of second order in every direction; measured 1.997 … 2.003 at ε = 0.0012."""
    found = springs.small_strains(material, form, False, 11, 50, SIZES).numbers
    assert 1.99 < found["smallest_order"] <= found["largest_order"] < 2.01
    assert found["pressure"] == pytest.approx(0.0 if mu is None else mu + 2 * mu_2, rel=1e-14)


@pytest.mark.parametrize("material, mu, mu_2", MATERIALS)
def test_with_a_residual_stress_1_12_fails(material, mu, mu_2):
    """ "In the absence of residual stress": else the difference tends to P(1), of norm √3 (μ + 2 μ₂)."""
    found = springs.small_strains(material, "energy alone", True, 11, 50, SIZES).numbers
    assert found["limit"] == pytest.approx(np.sqrt(3) * (mu + 2 * mu_2), rel=1e-4)
    assert abs(found["largest_order"]) < 1e-3
