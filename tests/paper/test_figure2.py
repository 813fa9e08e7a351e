"""Figure 2, a pulse started by holding the line: `startup-1d` against finite differences, and its window."""

from dataclasses import replace

import myostrain as ms
from myostrain import cases

import pytest

from reference.line_fd import STARTUP, solve, startup_threshold

HELD = "mechanics.imposed_stretch={value=1.0, until=0.01}"
SCHEMES = ["implicit", "staggered", "second-order"]


def peak(*settings):
    """Largest potential at the end, t = 0.3."""
    case = ms.Case.from_file(cases.path("startup-1d"), settings)
    return case.simulation().run()["metrics"]["potential_max"]


def reference(spacing, held):
    return solve(
        replace(STARTUP, spacing=spacing, imposed_stretch=(1.0, 0.01) if held else None)
    ).potential_max


@pytest.mark.parametrize("scheme", SCHEMES)
def test_at_the_papers_spacing_the_held_line_fires_and_the_coupled_one_does_not(scheme):
    """Section 6: v = 0.6 on −1 ≤ X ≤ 1, Δx = 1, decays coupled and fires, with peak 0.86, if
    held at x′ = 1 for 0 < t < 0.01.

    Measured: the peaks are off the finite differences' 0.8624 by 4e-4 (implicit), 1.3e-3 (staggered), 1e-6.
    """
    coupled, held = peak(f"time.scheme={scheme}"), peak(f"time.scheme={scheme}", HELD)
    assert coupled < 0.01
    assert held == pytest.approx(0.862, abs=0.002)
    limit = {"implicit": 1e-3, "staggered": 2e-3, "second-order": 1e-5}[scheme]
    assert held == pytest.approx(reference(1.0, held=True), abs=limit)
    # What is left of the decaying bump: 17 %, 17 % and 3 % of 4.7e-4 less.
    decayed = reference(1.0, held=False)
    assert decayed * 0.75 < coupled < decayed * 1.01


@pytest.mark.parametrize("scheme", SCHEMES)
def test_on_a_fine_mesh_the_same_bump_decays_in_both(scheme):
    """On a fine mesh the bump of figure 2 decays in both cases; Δx = 0.25."""
    fine = ("geometry.spacing=0.25", f"time.scheme={scheme}")
    assert peak(*fine, HELD) < 1e-3
    if scheme == "second-order":
        assert peak(*fine) < 1e-3


def test_close_to_the_threshold_the_peak_still_agrees():
    """At Δx = 0.5 the held bump is so near its threshold that the peak at t = 0.3 is 0.672, still rising.

    The scheme of second order finds 0.656 and 0.669 at Δt = 5e-4 and 2.5e-4, extrapolated 0.673: the time of
    the release, the jump and the bump are those of the finite differences.
    """
    settings = ("geometry.spacing=0.5", "time.scheme=second-order", HELD)
    coarse, fine = (peak(*settings, f"time.step={step}") for step in (5e-4, 2.5e-4))
    exact = reference(0.5, held=True)
    assert fine + (fine - coarse) / 3 == pytest.approx(exact, abs=2e-3)
    assert 3.0 < (exact - coarse) / (exact - fine) < 6.0  # measured 4.7


def threshold(held, low=0.3, high=0.5, tolerance=1e-3):
    """The least v of a bump of half-width 2 that fires at Δx = 0.25, by bisection."""
    settings = ["geometry.spacing=0.25", "initial.radius=2.0", "time.scheme=second-order", "time.step=5e-4"]
    settings += [HELD] if held else []
    assert peak(*settings, f"initial.potential={low}") < 0.5 < peak(*settings, f"initial.potential={high}")
    while high - low > tolerance:
        middle = (low + high) / 2
        if peak(*settings, f"initial.potential={middle}") > 0.5:
            high = middle
        else:
            low = middle
    return (low + high) / 2


@pytest.mark.slow
@pytest.mark.parametrize("held, expected", [(False, 0.433), (True, 0.375)])
def test_window_of_the_effect(held, expected):
    """The least height that fires for a half-width of 2, coupled and held, at Δx = 0.25.

    By finite differences 0.433 and 0.375, to the bisection's 1e-3."""
    found = threshold(held)
    case = replace(STARTUP, radius=2.0, spacing=0.25, imposed_stretch=(1.0, 0.01) if held else None)
    assert found == pytest.approx(expected, abs=2e-3)
    assert found == pytest.approx(startup_threshold(case), abs=1.5e-3)
