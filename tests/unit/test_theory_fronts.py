"""The closed-form fronts (4.8)-(4.12) against the equations they claim to solve."""

from myostrain.theory import profile, spatial_coordinate, speed, steepness

import numpy as np
import pytest

CASES = [
    # alpha, beta, D, A, balance
    pytest.param(0.1, 0.3, 100.0, 100.0, "conservative", id="paper"),
    pytest.param(0.1, 0.3, 1.0, 1.0, "conservative", id="paper-section-4"),
    pytest.param(0.25, 0.45, 3.0, 0.7, "conservative", id="conservative-strong"),
    pytest.param(0.7, 0.2, 1.0, 2.0, "conservative", id="conservative-retreating"),
    pytest.param(0.1, 0.0, 2.0, 5.0, "conservative", id="rigid"),
    pytest.param(0.1, 0.3, 100.0, 100.0, "advective", id="advective"),
    pytest.param(0.4, 0.8, 3.0, 0.7, "advective", id="advective-strong"),
    pytest.param(0.8, 0.3, 1.0, 1.0, "advective", id="advective-retreating"),
]


def derivative(f, h):
    """Eighth-order central difference of samples a distance h apart; four samples shorter at either end."""
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
    return np.convolve(f, weights[::-1], mode="valid") / h


def residual(alpha, beta, D, A, balance, c, v, h):
    """(4.8), or its advective counterpart, from samples of v alone; divided by A."""
    dv = derivative(v, h)
    diffusion = -D * derivative(dv / (1 - beta * v[4:-4]), h)
    v, dv = v[8:-8], dv[4:-4]
    storage = 1 - 2 * beta * v if balance == "conservative" else 1 - beta * v
    reaction = -A * (1 - beta * v) * v * (v - alpha) * (v - 1)
    return (-c * storage * dv + diffusion - reaction) / A


@pytest.mark.parametrize("alpha, beta, D, A, balance", CASES)
def test_profile_and_speed_solve_the_travelling_wave_equation(alpha, beta, D, A, balance):
    """Equation (4.8): finite differences of the profile, which know nothing of (4.9), leave no residual."""
    parameters = dict(diffusivity=D, A=A, balance=balance)
    a = steepness(alpha, beta, **parameters)
    h = 0.04 / a
    v = profile(np.arange(-600, 601) * h, alpha, beta, **parameters)
    c = -speed(alpha, beta, **parameters)

    assert v[0] < 1e-8
    assert v[-1] > 1 - 1e-2  # behind, 1 - v decays as exp(-a (1 - beta) X)
    # Truncation and round-off together measure 5e-13 at most; a speed wrong by 1e-6 shows as 1e-7.
    assert np.abs(residual(alpha, beta, D, A, balance, c, v, h)).max() < 5e-12
    wrong = residual(alpha, beta, D, A, balance, c + 1e-6 * np.sqrt(D * A), v, h)
    assert np.abs(wrong).max() > 5e-8


@pytest.mark.parametrize("alpha, beta, D, A, balance", CASES)
def test_steepness_is_that_of_the_first_order_equation(alpha, beta, D, A, balance):
    """Equation (4.9): v' = a v (1 - v) (1 - beta v)."""
    parameters = dict(diffusivity=D, A=A, balance=balance)
    a = steepness(alpha, beta, **parameters)
    h = 0.04 / a
    v = profile(np.arange(-600, 601) * h, alpha, beta, **parameters)
    inner = v[4:-4]
    expected = a * inner * (1 - inner) * (1 - beta * inner)
    np.testing.assert_allclose(derivative(v, h), expected, rtol=0, atol=1e-12 * a)


def test_equations_4_10_and_4_11_as_printed():
    """At A = 1 the conservative formulas are the paper's."""
    alpha, beta, D = 0.1, 0.3, 7.0
    assert steepness(alpha, beta, diffusivity=D) ** 2 == pytest.approx(
        (1 - 2 * alpha * beta) / (1 - beta) / (2 * D), rel=1e-14
    )
    assert speed(alpha, beta, diffusivity=D) == pytest.approx(
        (1 - 2 * alpha) / 2 * (2 * D / ((1 - beta) * (1 - 2 * alpha * beta))) ** 0.5, rel=1e-14
    )


def test_numbers_of_the_papers_parameters():
    """alpha = 0.1, beta = 0.3, D = A = 100, the formulas worked apart from the code."""
    paper = dict(alpha=0.1, beta=0.3, diffusivity=100.0, A=100.0)
    assert speed(**paper) == pytest.approx(69.737, abs=1e-3)
    assert speed(**paper, balance="advective") == pytest.approx(62.299, abs=1e-3)
    assert speed(**(paper | dict(beta=0.0))) == pytest.approx(56.569, abs=1e-3)
    assert steepness(**paper) == pytest.approx(0.81941, abs=1e-5)
    assert steepness(**paper, balance="advective") == pytest.approx(0.75538, abs=1e-5)


@pytest.mark.parametrize("balance", ["conservative", "advective"])
def test_without_contraction_the_front_is_the_hyperbolic_tangent(balance):
    """Section 4.1: "in the case of beta = 0 we recover ... the ... explicit hyperbolic tangent solution"."""
    D, A, alpha = 3.0, 5.0, 0.2
    X = np.linspace(-20, 20, 401)
    parameters = dict(diffusivity=D, A=A, balance=balance)
    a = steepness(alpha, 0.0, **parameters)
    assert a == pytest.approx(np.sqrt(A / (2 * D)), rel=1e-14)
    assert speed(alpha, 0.0, **parameters) == pytest.approx((1 - 2 * alpha) * np.sqrt(D * A / 2), rel=1e-14)
    v = profile(X, alpha, 0.0, center=1.5, **parameters)
    np.testing.assert_allclose(v, (1 + np.tanh(a * (X - 1.5) / 2)) / 2, rtol=0, atol=2e-15)
    np.testing.assert_array_equal(spatial_coordinate(X, alpha, 0.0, **parameters), X)


def test_small_beta_tends_to_none():
    X = np.linspace(-10, 10, 101)
    difference = np.abs(profile(X, 0.1, 1e-9) - profile(X, 0.1, 0.0)).max()
    assert 1e-12 < difference < 1e-8


@pytest.mark.parametrize("alpha, beta, D, A, balance", CASES)
def test_spatial_coordinate_is_the_integral_of_the_stretch(alpha, beta, D, A, balance):
    """Equation (4.12), by Gauss-Legendre quadrature of v over X from far ahead of the front."""
    parameters = dict(diffusivity=D, A=A, balance=balance, center=2.0)
    a = steepness(alpha, beta, diffusivity=D, A=A, balance=balance)
    edges = 2.0 + np.linspace(-40, 30, 141) / a
    points, weights = np.polynomial.legendre.leggauss(12)
    half = (edges[1:] - edges[:-1]) / 2
    nodes = (edges[1:] + edges[:-1])[:, None] / 2 + half[:, None] * points
    integral = np.cumsum(half * (profile(nodes, alpha, beta, **parameters) @ weights))
    x = spatial_coordinate(edges[1:], alpha, beta, **parameters)
    np.testing.assert_allclose(x, edges[1:] - beta * integral, rtol=0, atol=1e-12 / a)


def test_in_space_the_front_is_the_logistic_function_and_shortens_the_line_behind_it():
    """(4.9) and x' = 1 - beta v give dv/dx = a v (1 - v), whatever beta."""
    alpha, beta = 0.1, 0.3
    a = steepness(alpha, beta)
    X = np.linspace(-30, 60, 901)
    x, v = spatial_coordinate(X, alpha, beta), profile(X, alpha, beta)
    middle = spatial_coordinate(0.0, alpha, beta)
    np.testing.assert_allclose(v, 1 / (1 + np.exp(-a * (x - middle))), rtol=0, atol=1e-14)
    assert np.diff(x)[-1] / np.diff(X)[-1] == pytest.approx(1 - beta, abs=1e-9)
    assert x[0] - X[0] == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("beta", [0.0, 0.3, 0.9, 0.999])
def test_profile_is_robust_far_away_and_for_strong_contraction(beta):
    """The implicit relation between v and X, evaluated independently in log v and log(1 - v)."""
    alpha = 0.1
    a = steepness(alpha, beta)
    ahead, behind = -np.geomspace(1e-3, 600, 200)[::-1], np.geomspace(1e-3, 30 / (1 - beta), 200)
    X = np.concatenate([ahead, [0.0], behind]) / a
    v = profile(X, alpha, beta)
    assert np.all(np.diff(v) > 0)
    assert profile(0.0, alpha, beta) == pytest.approx(0.5, abs=1e-15)

    def G(v):
        return np.log(v) + (beta * np.log1p(-beta * v) - np.log1p(-v)) / (1 - beta)

    trusted = v < 0.99  # 1 - v from v has lost its digits beyond
    np.testing.assert_allclose(
        (G(v) - G(0.5))[trusted], (a * X)[trusted], rtol=1e-12, atol=1e-12 / (1 - beta)
    )
    # The far ends neither overflow nor leave [0, 1].
    with np.errstate(all="raise", under="ignore"):
        np.testing.assert_array_equal(profile([-1e9, 1e9], alpha, beta), [0.0, 1.0])


def test_shapes_and_broadcasting():
    assert isinstance(profile(0.3, 0.1, 0.3), float)
    assert isinstance(spatial_coordinate(0.3, 0.1, 0.3), float)
    assert isinstance(speed(0.1, 0.3), float)
    assert profile(np.zeros((2, 3)), 0.1, 0.3).shape == (2, 3)
    betas = np.linspace(0, 0.45, 10)
    assert np.all(np.diff(speed(0.1, betas)) > 0)  # "sharper and travels faster than in ... fixed domain"
    assert np.all(np.diff(steepness(0.1, betas)) > 0)


@pytest.mark.parametrize(
    "change, message",
    [
        (dict(alpha=0.9, beta=0.6), "alpha \\* beta < 1/2"),
        (dict(alpha=0.5, beta=0.999), None),  # just below the limit
        (dict(alpha=1.7, beta=0.6, balance="advective"), "alpha \\* beta < 1,"),
        (dict(alpha=0.9, beta=0.6, balance="advective"), None),
        (dict(beta=1.0), "beta"),
        (dict(beta=-0.1), "beta"),
        (dict(alpha=0.0), "alpha"),
        (dict(alpha=1.2), "alpha"),
        (dict(diffusivity=0.0), "diffusivity"),
        (dict(A=-1.0), "A = -1"),
        (dict(alpha=float("nan")), "alpha"),
        (dict(balance="lagrangian"), "'conservative', 'advective'"),
    ],
)
@pytest.mark.parametrize("function", [speed, steepness, profile, spatial_coordinate])
def test_errors_say_what_is_allowed(function, change, message):
    arguments = dict(alpha=0.1, beta=0.3) | change
    if function in (profile, spatial_coordinate):
        arguments["X"] = [0.0, 1.0]
    if message is None:
        assert np.all(np.isfinite(function(**arguments)))
    else:
        with pytest.raises(ValueError, match=message):
            function(**arguments)


def test_a_profile_wants_finite_coordinates_and_single_numbers():
    with pytest.raises(ValueError, match="finite"):
        profile([0.0, np.inf], 0.1, 0.3)
    with pytest.raises(ValueError, match="beta must be one number"):
        profile(0.0, 0.1, [0.1, 0.3])
