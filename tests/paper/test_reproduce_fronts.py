"""What the page measures of equilibria and fronts, against formulas and finite differences of their own."""

from myostrain.reproduce.measurements import fronts
from myostrain.reproduce.measurements.cases import resolved
from myostrain.theory import profile, speed, steepness

import numpy as np
import pytest

from reference.line_fd import Line, solve

RIGID = "mechanics.imposed_stretch={value=1.0, until=inf}"
ADVECTIVE = 'potential.balance="advective"'
TINY = (
    "geometry.length=4.0",
    "probes={middle=[2.0]}",
    "mechanics.tolerance=1e-13",
    "solver.potential={ksp_rtol=1e-14}",
)
D = A = 100.0
ALPHA, BETA, TAU = 0.1, 0.3, 0.2


def by_hand(v, beta):
    """Eigenvalues of the conservative (4.6), (4.7) about (v, τv), differentiated by hand; rigid at β = 0.

    (1 − 2βv) v̇ = (1 − βv) f and (1 − βv) ẇ − βw v̇ = (1 − βv) g for small deviations.
    """
    slope = -A * (3 * v**2 - 2 * (1 + ALPHA) * v + ALPHA)
    quick = (1 - beta * v) / (1 - 2 * beta * v)
    top = quick * np.array([slope, -A])
    bottom = np.array([1.0, -1 / TAU]) + beta * TAU * v / (1 - beta * v) * top
    return np.linalg.eigvals(np.array([top, bottom]))


@pytest.mark.parametrize("setting, beta", [((), BETA), ((RIGID,), 0.0), ((ADVECTIVE,), 0.0)])
def test_equilibria_stay_and_grow_as_linear_algebra_says(setting, beta):
    """Section 4: "the points of equilibrium are not modified"; an advective line's rates are the rigid one's.

    Measured drift 9e-14; rates of the steps are off by 3e-5 at Δt = 1e-4.
    """
    case = resolved("front-1d", [*TINY, "cell.recovery=true", *setting])
    found = fronts.homogeneous(case, [0.0, 0.5, 0.6], [2e-3, 0.02], [1e-4, 1e-3, 1e-4]).numbers
    assert max(found["drift"]) < 1e-12
    assert max(found["bent"]) < 1e-4
    for v, rates, predicted in zip([0.0, 0.5, 0.6], found["rates"], found["predicted"], strict=True):
        expected = np.array(sorted([z.real, z.imag] for z in by_hand(v, beta).astype(complex)))
        np.testing.assert_allclose(predicted, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
        np.testing.assert_allclose(rates, expected, rtol=0, atol=1e-3 * np.abs(expected).max())
    assert [max(re for re, _ in rates) > 0 for rates in found["rates"]] == [False, True, True]


def test_a_state_that_is_no_equilibrium_drifts():
    """The drift sees what it has to: at v = 0.3 the cubic is 4.2, in 0.02 a change of 0.1."""
    case = resolved("front-1d", list(TINY))
    found = fronts.homogeneous(case, [0.3], [2e-3, 0.02], [1e-4, 1e-3, 1e-4]).numbers
    assert 0.08 < found["drift"][0] < 0.2


def test_temporal_variation_is_enhanced_by_the_contraction():
    """(4.5) and what follows: the rate is (1 − βv)/(1 − 2βv) times the rigid −A v (v − α)(v − 1).

    Measured 1.4e-4 off, of the step 1e-6; the zeros 1e-5, of the cubic through four states.
    """
    v = np.linspace(-0.1, 1.1, 24)
    case = resolved("front-1d", [*TINY, "time.scheme=implicit", "time.tolerance=1e-13"])
    found = fronts.temporal_variation(case, v.tolist(), 1e-6)
    exact = -A * v * (v - ALPHA) * (v - 1) * (1 - BETA * v) / (1 - 2 * BETA * v)
    np.testing.assert_allclose(found.arrays["rate"], exact, rtol=5e-4)
    np.testing.assert_allclose(found.numbers["zeros"], [0.0, ALPHA, 1.0], rtol=0, atol=5e-5)


@pytest.mark.parametrize(
    "setting, factor",
    [((), 1 / (0.7 * 0.85)), ((ADVECTIVE,), 1 / 0.85**2), ((RIGID,), 1.0)],
)
def test_contraction_makes_diffusion_greater(setting, factor):
    """(4.5): D q²/((1 − 2βv)(1 − βv)), advective D q²/(1 − βv)²; measured 2e-4 off, of h = 0.25."""
    line = ("geometry.length=20.0", "geometry.spacing=0.25", "cell.A=0.0", "time.end=0.02")
    found = fronts.spreading(resolved("front-1d", [*TINY, *line, *setting]), 0.5, 1e-3).numbers
    assert found["rate"] == pytest.approx(factor * D * (np.pi / 20) ** 2, rel=1e-3)


@pytest.mark.parametrize(
    "alpha, beta, balance, direction",
    [(0.1, 0.3, "conservative", -1), (0.8, 0.3, "conservative", 1), (0.1, 0.3, "advective", -1)],
)
def test_travelling_front_is_that_of_finite_differences_and_of_the_closed_form(
    alpha, beta, balance, direction
):
    """(4.8)–(4.12) with v(−∞) = 0, v(+∞) = 1: for α < 1/2 the front goes towards −X, so c < 0.

    Against finite differences on the same nodes, exact in time: measured 1.5e-3 at most in v (Δt = 1e-3 and
    the different discrete fluxes). Against the closed form at h = 0.5: c 0.2 %, a 0.1 %, v 8e-4, x 1e-3.
    """
    start, length, end = (35.0, 60.0, 0.2) if direction < 0 else (20.0, 70.0, 0.2)
    case = resolved(
        "front-1d",
        [
            f"cell.alpha={alpha}",
            f"activation.beta={beta}",
            f"potential.balance={balance}",
            f"geometry.length={length}",
            "geometry.spacing=0.5",
            "time.step=1e-3",
            f"time.end={end}",
            "probes={middle=[10.0]}",
        ],
    )
    found = fronts.travel(case, start)
    theory = dict(diffusivity=D, A=A, balance=balance)
    reference = solve(
        Line(
            alpha=alpha,
            beta=beta,
            balance=balance,
            recovery=False,
            length=length,
            spacing=0.5,
            end=end,
            sample=0.1,
            probes=(),
            initial=lambda X: profile(X - start, alpha, beta, **theory),
        )
    )
    np.testing.assert_allclose(found.arrays["v"], reference.v, rtol=0, atol=3e-3)
    np.testing.assert_allclose(found.arrays["x"], reference.x, rtol=0, atol=5e-3)
    numbers = found.numbers
    assert np.sign(numbers["c"]) == direction
    assert abs(numbers["c"]) == pytest.approx(abs(speed(alpha, beta, **theory)), rel=4e-3)
    assert numbers["c"] / numbers["c_exact"] == pytest.approx(1, rel=4e-3)
    assert numbers["steepness"] == pytest.approx(steepness(alpha, beta, **theory), rel=3e-3)
    assert numbers["slope"] == pytest.approx(numbers["steepness"] * (1 - beta / 2) / 4, rel=6e-3)
    assert numbers["potential_error"] < 2e-3
    assert numbers["place_error"] < 3e-3
    assert numbers["unsettled"] < 1e-3
    # From v = 0.1 to 0.9 the logistic function in x takes 2 log 9 / a.
    assert numbers["width_spatial"] == pytest.approx(2 * np.log(9) / numbers["steepness_exact"], rel=5e-3)
    assert numbers["width_material"] > numbers["width_spatial"] / (1 - 0.2 * beta)


def test_search_finds_the_fronts_of_the_closed_form_and_none_beyond():
    """ "A traveling front solution exists only if αβ < 1/2", by shooting that does not know (4.9).

    Measured 0.3 % off in c, of the 121 speeds.
    """
    alpha = 0.9
    betas = [0.0, 0.3, 0.5, 0.54, 0.57, 0.65, 0.8]
    found = fronts.shooting(alpha, betas, 8.0, 121, 800).numbers["c"]
    np.testing.assert_allclose(found[:4], -np.asarray(speed(alpha, betas[:4])), rtol=1e-2)
    assert found[4:] == [None, None, None]


def test_a_line_that_is_not_parabolic_is_refused_with_the_reason():
    """(4.6) with β ≥ 1/2 is refused in the conservative balance, and only there (docs/model/readings.md)."""
    refused = fronts.refusal(resolved("front-1d", ["activation.beta=0.5"])).numbers
    assert refused["refused"] == 1
    assert "ill-posed" in refused["message"]
    for setting in (["activation.beta=0.499"], ["activation.beta=0.5", ADVECTIVE]):
        assert fronts.refusal(resolved("front-1d", setting)).numbers["refused"] == 0
