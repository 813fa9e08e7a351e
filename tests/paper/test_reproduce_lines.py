"""What the page measures of a pulse on a line or a strip: `reproduce.measurements.lines`."""

import math

from myostrain.reproduce.measurements import lines, signals

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from reference.line_fd import Line, solve

TIMES = np.linspace(0.0, 2.0, 401)


def bell(times, centre, width=0.1):
    return np.exp(-(((times - centre) / width) ** 2))


@pytest.mark.parametrize("scale", [1.0, 0.3])
def test_half_width_is_the_full_width_at_half_maximum(scale):
    """A Gaussian exp(−(X/s)²) exceeds half its maximum over 2 s √ln 2, whatever its height.

    Its top is on a node here, as the maximum is the nodes'.
    """
    X = np.linspace(-20.0, 20.0, 81)
    found = lines.half_width(X, scale * bell(X, 0.5, 4.0))
    assert found == pytest.approx(2 * 4.0 * math.sqrt(math.log(2)), rel=1e-4)  # measured 2e-5


def test_half_width_takes_the_leading_pulse_and_needs_both_ends():
    """Two pulses: the one at larger X counts. A front has no back."""
    X = np.linspace(0.0, 100.0, 401)
    two = bell(X, 20.0, 8.0) + bell(X, 70.0, 4.0)
    assert lines.half_width(X, two) == pytest.approx(8.0 * math.sqrt(math.log(2)), rel=1e-3)
    assert lines.half_width(X, 1 / (1 + np.exp(X - 50.0))) is None
    assert lines.half_width(X, -bell(X, 50.0)) is None


def test_delays_of_a_shifted_copy():
    """Section 8, "the delay between potential upstroke and mechanical contraction": a contraction that is the
    potential, later and weaker, comes later by the shift, peak after peak and rise after rise."""
    shift = 0.0837
    found = signals.delays(TIMES, 0.9 * bell(TIMES, 0.6), 0.2 * bell(TIMES, 0.6 + shift))
    assert found["peak_delay"] == pytest.approx(shift, abs=5e-5)  # measured 1e-6; the samples are 5e-3 apart
    assert found["rise_delay"] == pytest.approx(shift, abs=2e-4)  # measured 5e-6


def test_a_longer_contraction_peaks_and_rises_later_by_different_times():
    """With its peak 0.3 later and three times as long, the rise is later by 0.3 − 2 · 0.1 √ln 2."""
    found = signals.delays(TIMES, bell(TIMES, 0.6), bell(TIMES, 0.9, 0.3))
    assert found["peak_delay"] == pytest.approx(0.3, abs=1e-4)
    assert found["rise_delay"] == pytest.approx(0.3 - 0.2 * math.sqrt(math.log(2)), abs=2e-4)


@pytest.mark.parametrize("shortening", [np.zeros_like(TIMES), TIMES])
def test_no_delay_without_a_peak(shortening):
    """A rigid line does not shorten, and what still shortens at the last sample has no peak."""
    assert set(signals.delays(TIMES, bell(TIMES, 0.6), shortening).values()) == {None}


def test_lowest_of_unequal_places():
    """The bottom of a parabola, from places that are not equally far apart; an end is no minimum."""
    x = np.array([-3.0, -1.0, -0.2, 0.5, 2.0])
    place, value = signals.lowest(x, 1.5 + 0.7 * (x - 0.13) ** 2)
    assert (place, value) == (pytest.approx(0.13), pytest.approx(1.5))
    with pytest.raises(ValueError, match="at an end"):
        signals.lowest(x, x)


@pytest.mark.parametrize("ratio, order", [(2.0, 2.0), (4.0, 2.0), (2.0, 1.0)])
def test_extrapolation_removes_the_leading_error(ratio, order):
    """Richardson: from a + b h^p at two h comes a."""
    assert signals.extrapolated(3.0 + 0.5 * 0.4**order, 3.0 + 0.5 * (0.4 / ratio) ** order, ratio, order) == (
        pytest.approx(3.0)
    )


SHORT = ("geometry.length=90.0", "time.end=1.3", "probes={a=[30.0], b=[55.0]}", "output.rigid_twin=false")


def test_viscoelastic_pulse_is_that_of_finite_differences():
    """Figure 1 and section 4.2, λ = 0.4 τ: celerity, place in X and x, widths, and the wave of contraction,
    from the reference's nodes by cubic splines, on the same mesh.

    Measured, relative: celerity 5e-5, places 1e-4, widths 6e-4, lengths 4e-4.
    """
    found = lines.pulse_job("pulse-1d", (*SHORT, "mechanics.relaxation_time=0.08"), watch=40.0).run()
    case = Line(mechanics="viscoelastic", relaxation_time=0.08, length=90.0, end=1.3, probes=(30.0, 55.0))
    exact = solve(case)
    back, front = CubicSpline(exact.X, exact.v - 0.5).roots(extrapolate=False)[-2:]
    x = CubicSpline(exact.X, exact.x)
    numbers = found.numbers
    assert numbers["celerity"] == pytest.approx(exact.celerity, rel=2e-4)
    assert numbers["front_material"] == pytest.approx(front, rel=5e-4)
    assert numbers["front_spatial"] == pytest.approx(float(x(front)), rel=5e-4)
    assert numbers["width_material"] == pytest.approx(front - back, rel=2e-3)
    assert numbers["width_spatial"] == pytest.approx(float(x(front) - x(back)), rel=2e-3)
    for name, values in (("half_width", exact.v), ("shortening_half_width", 1 - exact.J)):
        ends = CubicSpline(exact.X, values / values.max() - 0.5).roots(extrapolate=False)[-2:]
        assert numbers[name] == pytest.approx(ends[1] - ends[0], rel=2e-3)
    assert numbers["shortening_max"] == pytest.approx(1 - exact.J.min(), rel=3e-3)
    # A steady wave: what is behind the front in X by a distance comes later by it over the celerity.
    behind = exact.X[np.argmax(exact.v)] - exact.X[np.argmax(1 - exact.J)]
    assert numbers["peak_delay"] == pytest.approx(behind / exact.celerity, abs=1.1 / exact.celerity)
    assert found.arrays["watch_times"].shape == found.arrays["watch_shortening"].shape == (1300,)


def test_elastic_line_contracts_with_the_potential():
    """(4.3): on the elastic line the contraction is as long as the potential and comes at once."""
    numbers = lines.pulse_job("pulse-1d", (*SHORT, "time.step=2e-3"), watch=40.0).run().numbers
    assert numbers["shortening_half_width"] == pytest.approx(numbers["half_width"], rel=3e-3)  # 1e-3: cells
    assert numbers["shortening_max"] == pytest.approx(0.3 * numbers["potential_max"], rel=2e-3)
    assert abs(numbers["peak_delay"]) < 5e-3  # measured 2e-3: the peak of a mean over two cells
    assert abs(numbers["rise_delay"]) < 5e-4


@pytest.mark.parametrize("kinematics, power", [("plane-strain", 1 / 2), ("plane-stress", 2 / 3)])
def test_a_free_strip_contracts_by_the_closed_form(kinematics, power):
    """A free incompressible strip with fibres along it has its least μ/2 (1 + γ)(|F Fo⁻¹|² − 3) at the
    stretch (1 + γ)^½ in plane strain and (1 + γ)^⅔ in plane stress; measured 2e-9."""
    settings = (
        'geometry={kind="rectangle", size=[12.0, 1.0], spacing=1.0}',
        "fibres={direction=[1.0, 0.0]}",
        "initial={potential=0.8, center=[0.0, 0.0], radius=100.0}",
        "material.model=NeoHookean",
        "mechanics.fixed=[]",
        f"mechanics.kinematics={kinematics}",
        "mechanics.tolerance=1e-10",
        "time.end=5e-3",
        "probes={}",
        "output.rigid_twin=false",
    )
    found = lines.pulse_job("pulse-1d", settings).run()
    v = found.arrays["potential"][-1]
    assert np.ptp(v) < 1e-9
    assert found.arrays["x"][-1][-1] == pytest.approx(12.0 * (1 - 0.3 * v[0]) ** power, rel=1e-6)
    assert found.numbers["shortening_max"] == pytest.approx(1 - (1 - 0.3 * v[0]) ** power, rel=1e-6)
