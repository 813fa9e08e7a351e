"""The N-version benchmark of Niederer et al. 2011 (docs/niederer.md): the case, and published times."""

from myostrain.case.case import Case
from myostrain.case.running import changed_problem, run_case
from myostrain.cases import path
from myostrain.output.codes import CONVERGED, compare_times, published_times
from myostrain.output.figures import codes
from myostrain.output.figures.codes import draw_codes

import numpy as np
import pytest

from reference import niederer_fd

POINTS = [f"P{i}" for i in range(1, 10)]


def case(*changes):
    """The shipped case with keys set."""
    return Case.from_file(path("niederer-3d"), list(changes))


def test_the_case_is_the_benchmark():
    """docs/niederer.md: conductivities over χ Cm, the stimulus, and the published initial states."""
    shipped = case()
    chi_cm = 140 * 0.01
    along, across = 0.17 * 0.62 / (0.17 + 0.62) / chi_cm, 0.019 * 0.24 / (0.019 + 0.24) / chi_cm
    assert shipped.potential.diffusivity == pytest.approx((along, across), rel=1e-8)
    assert shipped.stimuli[0].strength == pytest.approx(50 / chi_cm, rel=1e-12)
    assert (shipped.cell.resting_potential(), shipped.cell.threshold) == (-85.23, 0.0)
    assert shipped.cell.resting_states()[5:9] == (0.9073, 0.00621, 0.4712, 0.0095)
    assert shipped.is_rigid
    assert list(shipped.probes) == POINTS


@pytest.mark.parametrize(
    "changes, another",
    [
        (["geometry.spacing=0.5", "time.step=0.01", "time.end=150", "potential.mass=lumped"], set()),
        (["stimulus.strength=30"], {"stimulus.strength"}),
        (["cell.set=ENDO"], {"cell.set"}),
    ],
)
def test_another_problem_is_not_compared(changes, another):
    """docs/niederer.md: mesh, step and end are no part of the problem."""
    found = set(changed_problem(case(*changes)))
    assert another <= found
    assert bool(found) == bool(another)


def test_results_are_beside_the_published_codes(tmp_path):
    """docs/niederer.md: metrics and results.json hold P1 to P9, None where the run ended before."""
    changes = ["geometry.spacing=0.75", "time.step=0.1", "time.end=6", "output.fields=[]"]
    found = run_case(case(*changes), tmp_path / "run", figures=False)
    assert list(found["published"]["times"]) == POINTS
    # The corner is stimulated itself: no mesh and no step matters (published: 1.22 to 1.35).
    assert found["metrics"]["P1"] == pytest.approx(1.23, abs=0.05)
    assert found["metrics"]["P8"] is None
    assert list(found["published"]["error"]) == ["P1"]
    assert {code["code"] for code in found["published"]["codes"]} == {"fenicsx-beat", "Cardioid", "Chaste"}


def test_what_codes_tend_to_is_that_of_the_finite_differences():
    """tests/reference/niederer_fd.py: its extrapolated times, rounded.

    A grid between the two lies on their line against the slowness across, to 0.08 ms.
    """
    assert list(CONVERGED["niederer-3d"].values()) == pytest.approx(niederer_fd.limit(), abs=0.006)
    assert CONVERGED["niederer-3d"]["P8"] == pytest.approx(42.2, abs=0.3)  # what is published
    coarse, middle, fine = (np.array(niederer_fd.FOUND[0.1, h]) for h in (0.1, 0.0667, 0.05))
    slow = {h: 1 / c for h, c in niederer_fd.ACROSS.items()}
    share = (slow[0.0667] - slow[0.05]) / (slow[0.1] - slow[0.05])
    np.testing.assert_allclose(middle, fine + share * (coarse - fine), rtol=0, atol=0.08)


def test_published_times_and_their_picture(tmp_path, monkeypatch):
    """The data are those of the codes' own files, and a run is set beside them."""
    finest = {c["code"]: c["P8"] for c in published_times("niederer-3d") if c["spacing"] == 0.1}
    assert finest == {"fenicsx-beat": 37.93, "Cardioid": 45.13}
    found = compare_times("niederer-3d", {p: {"activation_time": 10.0} for p in POINTS})
    assert found["error"]["P8"] == pytest.approx(10 / 42.19 - 1)
    assert compare_times("niederer-3d", {"P8": {"activation_time": None}})["error"] == {}
    assert compare_times("slab-3d", {}) == {}
    results = {"published": found, "parameters": {"title": "a run"}, "units": {"length": "mm", "time": "ms"}}
    (file,) = draw_codes(tmp_path, results)
    assert file.stat().st_size > 10_000
    monkeypatch.setattr(codes, "save", lambda figure, path: figure)
    (panel,) = draw_codes(tmp_path, results)[0].axes
    assert panel.get_ylabel() == "activation time (ms)"
    assert panel.get_legend().get_texts()[0].get_text() == "fenicsx-beat, P1 consistent mass, 0.5 mm"
    assert draw_codes(tmp_path, {"parameters": {}}) == []
