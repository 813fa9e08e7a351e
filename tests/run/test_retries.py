"""How often a step that fails is tried again."""

from myostrain import Case, Electromechanics, cases
from myostrain.case.running import run_case
from myostrain.errors import ComputationError
from myostrain.run.retries import REMEDIES, STATIC_REMEDIES

import pytest

from small_cases import ALONE


@pytest.mark.parametrize(
    "change, tries",
    [
        ("mechanics.tolerance=1e-6", ()),
        ("solver.mechanics.pc_type=fieldsplit", STATIC_REMEDIES),
        ("mechanics.viscosity=0.1", REMEDIES),
    ],
    ids=["static", "static, by iterations", "viscous"],
)
def test_a_static_run_that_fails_ends_soon(tmp_path, monkeypatch, caplog, change, tries):
    """docs/numerics: smaller steps are tried where time has a part in what is solved, and not where they are
    the smaller loads that mechanics has tried already; nor are direct solvers where they were taken."""
    case = Case.from_file(cases.path("land-1"), ["geometry.spacing=1.0", change])

    def fails(model, end, **others):
        raise ComputationError("planted", advice="nothing.")

    monkeypatch.setattr(Electromechanics, "step", fails)
    with pytest.raises(ComputationError, match="planted"):
        run_case(case, tmp_path / "out", comm=ALONE, figures=False)
    said = [message for message in caplog.messages if "trying" in message]
    assert [message.rsplit("trying ", 1)[1] for message in said] == [remedy[0] for remedy in tries]
