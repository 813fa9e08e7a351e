"""The case spiral-2d: its rigid spiral beside an independent one, and what a run says of both."""

from myostrain import Case, cases, run_case
from myostrain.output.rotation import rotation

import numpy as np
import pytest

from reference.spiral_fd import tips
from small_cases import ALONE


def crossed(X, Y):
    """The case's start: v steps along X, the recovery along Y."""
    return np.where(X <= 10.0, 1.0, 0.0), np.where(Y <= 25.0, 2.0, 0.0)


@pytest.mark.slow
def test_the_rigid_spiral_is_that_of_finite_differences(tmp_path):
    """docs/spiral.md: period and core within 2 %; at the same spacing they are 1.0 and 0.3 % apart."""
    way = tips(60.0, 0.5, 0.05, 200.0, 0.2, crossed)
    other = rotation(*way.T)
    case = Case.from_file(cases.path("spiral-2d")).rigid()
    found = run_case(case, tmp_path, comm=ALONE, figures=False)["metrics"]
    assert found["tips"] == found["tips_max"] == 1
    assert found["tip_period"] == pytest.approx(other.period, rel=0.02)
    assert found["tip_radius"] == pytest.approx(other.radius, rel=0.02)


def test_both_are_measured(tmp_path):
    """Some steps of it on a coarse mesh: tips of both, and a note why there is no period yet."""
    changes = ["geometry.spacing=6", "time.end=1.0", "output.every=0.5", "output.tip.every=0.1"]
    case = Case.from_file(cases.path("spiral-2d"), changes)
    results = run_case(case, tmp_path, comm=ALONE, figures=False)
    assert (tmp_path / "rigid" / "tip.csv").exists()
    assert results["metrics"]["tip_period"] is results["metrics"]["tip_period_rigid"] is None
    assert "tip_period" in results["notes"]
