"""Figure 1, a pulse on the contracting line: `pulse-1d` against finite differences.

The line is shorter than the case's and the probes are nearer, as the reference's are; the pulse has settled.
"""

from dataclasses import replace

import myostrain as ms
from myostrain import cases

import pytest
from scipy.interpolate import CubicSpline

from reference.line_fd import Line, solve

SHORT = dict(length=120.0, probes=(40.0, 90.0))
LONG = dict(length=160.0, probes=(60.0, 120.0), end=2.2)  # the widest pulse settles last

ROWS = {
    # name: the reference's case, and what ours has beside the grid
    "rigid": (Line(mechanics="rigid", **SHORT, end=2.05), "mechanics.imposed_stretch={value=1.0, until=inf}"),
    "conservative": (Line(**LONG), "mechanics.relaxation_time=0.0"),
    "advective": (Line(balance="advective", **SHORT, end=1.85), "potential.balance=advective"),
    "viscous, 0.4 τ": (
        Line(mechanics="viscoelastic", relaxation_time=0.08, **SHORT, end=1.85),
        "mechanics.relaxation_time=0.08",
    ),
    "viscous, 0.45 τ": (
        Line(mechanics="viscoelastic", relaxation_time=0.09, **SHORT, end=1.85),
        "mechanics.relaxation_time=0.09",
    ),
}

NAMES = ("celerity", "width_material", "width_spatial", "potential_max", "potential_min")


def ours(name, spacing=1.0, step=1e-3, *more):
    case, setting = ROWS[name]
    grid = [f"geometry.length={case.length}", f"geometry.spacing={spacing}"]
    grid += [f"probes={{a=[{case.probes[0]}], b=[{case.probes[1]}]}}"]
    times = [f"time.step={step}", f"time.end={case.end}"]
    run = ms.Case.from_file(cases.path("pulse-1d"), [setting, *grid, *times, *more]).simulation().run()
    return {key: run["metrics"][key] for key in NAMES}


def reference(name, spacing=1.0):
    """The same numbers from finite differences; widths by a cubic spline through all nodes."""
    found = solve(replace(ROWS[name][0], spacing=spacing))
    above = CubicSpline(found.X, found.v - 0.5).roots(extrapolate=False)
    back, front = above[-2:]
    x = CubicSpline(found.X, found.x)
    return {
        "celerity": found.celerity,
        "width_material": front - back,
        "width_spatial": float(x(front) - x(back)),
        "potential_max": found.potential_max,
        "potential_min": found.potential_min,
    }


@pytest.fixture(scope="module")
def table():
    """All rows at the paper's Δx = 1, Δt = 1e-3, scheme of second order: ours and the reference's."""
    return {name: (ours(name), reference(name)) for name in ROWS}


@pytest.mark.parametrize("row", list(ROWS))
def test_rows_agree_with_finite_differences(table, row):
    """Celerity, widths in X and x and the extremes of v, on the same nodes.

    Measured, relative: celerity 4e-5, widths 3e-4, extremes of v 4e-5.
    """
    found, expected = table[row]
    assert found["celerity"] == pytest.approx(expected["celerity"], rel=2e-4)
    for name in ("width_material", "width_spatial"):
        assert found[name] == pytest.approx(expected[name], rel=1e-3)
    for name in ("potential_max", "potential_min"):
        assert found[name] == pytest.approx(expected[name], rel=2e-4)


@pytest.mark.parametrize(
    "row, celerity, width, extremes",
    [
        ("rigid", 1.0, 1.0, None),
        ("conservative", 1.26, 1.12, (0.864, -0.144)),
        ("advective", 1.11, 0.86, (0.854, -0.167)),
        ("viscous, 0.4 τ", 1.10, 0.76, (0.871, -0.132)),
        ("viscous, 0.45 τ", 1.09, 0.75, (0.871, -0.134)),
    ],
)
def test_ratios_to_the_rigid_line_are_those_of_the_table(table, row, celerity, width, extremes):
    """The ratios by finite differences; the conservative pulse, the widest, is still 0.4 % wider here than
    farther along."""
    found, rigid = table[row][0], table["rigid"][0]
    assert found["celerity"] / rigid["celerity"] == pytest.approx(celerity, abs=0.006)
    assert found["width_spatial"] / rigid["width_spatial"] == pytest.approx(width, rel=0.01)
    if extremes:
        assert (found["potential_max"], found["potential_min"]) == pytest.approx(extremes, abs=0.0015)
    else:
        assert rigid["celerity"] == pytest.approx(46.7, abs=0.2)
        assert rigid["width_spatial"] == pytest.approx(15.5, abs=0.05)


def test_what_the_paper_says_of_figure_1(table):
    """The paper: "of order 10 %" faster and "about 25 %" shorter. Not so by (4.6) at β = 0.3, whose
    pulse is wider, but so on a viscous line of λ ≈ 0.4 τ."""
    rigid = table["rigid"][0]
    elastic, viscous = table["conservative"][0], table["viscous, 0.4 τ"][0]
    assert elastic["celerity"] / rigid["celerity"] > 1.2
    assert elastic["width_spatial"] > rigid["width_spatial"]
    assert 1.05 < viscous["celerity"] / rigid["celerity"] < 1.15
    assert 0.7 < viscous["width_spatial"] / rigid["width_spatial"] < 0.8


@pytest.mark.slow
@pytest.mark.parametrize("row", list(ROWS))
def test_rows_on_a_fine_mesh(table, row):
    """On a fine mesh the rigid line has 47.0 and 15.6, the ratios are unchanged to a percent.

    Δx = 0.25, Δt = 5e-4.

    Measured, relative: celerity 1e-5, widths 2e-5, extremes 7e-5; 1 % from those at Δx = 1.
    """
    found, expected = ours(row, 0.25, 5e-4), reference(row, 0.25)
    assert found["celerity"] == pytest.approx(expected["celerity"], rel=2e-4)
    for name in ("width_material", "width_spatial"):
        assert found[name] == pytest.approx(expected[name], rel=1e-3)
    for name in ("celerity", "width_spatial"):
        assert found[name] == pytest.approx(table[row][0][name], rel=0.015)
    if row == "rigid":
        assert found["celerity"] == pytest.approx(47.0, abs=0.05)
        assert found["width_spatial"] == pytest.approx(15.6, abs=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["implicit", "staggered"])
def test_schemes_of_first_order_tend_to_the_reference(table, scheme):
    """Figure 1 by the paper's implicit scheme and the staggered one: 0.2 % and 0.6 % too fast at Δt = 1e-3,
    and right when extrapolated in the time step (measured 2e-5)."""
    expected = table["conservative"][1]
    coarse, fine = (ours("conservative", 1.0, step, f"time.scheme={scheme}") for step in (1e-3, 5e-4))
    assert 1e-3 < coarse["celerity"] / expected["celerity"] - 1 < 8e-3
    assert 2 * fine["celerity"] - coarse["celerity"] == pytest.approx(expected["celerity"], rel=2e-4)
