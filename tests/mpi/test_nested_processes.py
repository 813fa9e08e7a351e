"""A mesh of the potential's own on other numbers of processes, and a run that goes on there."""

from myostrain import Case, run_case
from myostrain.case.running import load_results
from myostrain.errors import Interrupted
from myostrain.output.snapshots import Snapshots

import numpy as np
import pytest

from small_cases import ALONE, SHEET, SOLID, changed, write_case

pytestmark = pytest.mark.mpi

CASES = {
    "sheet": changed(
        SHEET,
        {
            "potential.refinement": 2,
            "potential.mass": "averaged",
            "mechanics.constraint": "elastic",
            "output": {"every": 5e-3, "fields": ["potential", "activation", "displacement", "stress"]},
        },
    ),
    "calcium": changed(  # a law with states that sees the stretch, fast beside these steps
        SHEET,
        {
            "potential.refinement": 1,
            "potential.reaction": "interpolated",
            "cell": {"model": "BuenoOrovio2008"},
            "initial": {"center": [10.0, 12.0], "radius": 5.0, "potential": 20.0, "states": {"s": 0.9}},
            "activation": {"law": "rossi-2014", "mu": 1e-2},
            "mechanics.every": 2,
            "output": {"every": 4e-3, "fields": ["potential", "activation", "displacement", "stretch"]},
        },
    ),
    "solid": changed(SOLID, {"potential.refinement": 1}),
}

#: Goes on with the cases of a folder, and runs them anew.
DRIVER = """
import sys
from pathlib import Path
from myostrain import Case, run_case
folder = Path(sys.argv[1])
for file in sorted(folder.glob("*.toml")):
    case = Case.from_file(file)
    run_case(case, folder / "resumed" / file.stem, resume=True, figures=False)
    if file.stem == "solid":
        run_case(case, folder / "anew" / file.stem, figures=False)
"""


def stop_at(step):
    """Progress that interrupts this process after so many steps."""

    class Stop:
        def update(self, number, time):
            if number == step:
                raise Interrupted(15, time)

    return lambda *_: Stop()


def test_numbers_do_not_depend_on_the_processes(on_processes, tmp_path):
    """A run on one process; on two; and begun on one and ended on two: the same mesh and numbers."""
    for name, case in CASES.items():
        file = write_case(tmp_path / f"{name}.toml", changed(case, {"output.checkpoint_every": 5e-3}))
        run_case(Case.from_file(file), tmp_path / "one" / name, comm=ALONE, figures=False)
        with pytest.raises(Interrupted):
            run_case(
                Case.from_file(file),
                tmp_path / "resumed" / name,
                comm=ALONE,
                figures=False,
                progress=stop_at(4 if name == "solid" else 7),
            )
        assert list((tmp_path / "resumed" / name / "checkpoint").iterdir())
    on_processes(2, DRIVER, tmp_path)
    for name in CASES:
        one = tmp_path / "one" / name
        wanted, whole = load_results(one)["metrics"], Snapshots(one)
        for other in (p for p in (tmp_path / "anew" / name, tmp_path / "resumed" / name) if p.exists()):
            results, found = load_results(other), Snapshots(other)
            assert results["processes"] == 2
            np.testing.assert_array_equal(found.points, whole.points)
            np.testing.assert_array_equal(found.cells, whole.cells)
            np.testing.assert_array_equal(found.times, whole.times)
            for field in whole.names:
                last = found.field(field), whole.field(field)
                np.testing.assert_allclose(*last, rtol=0, atol=1e-7, err_msg=f"{other}: {field}")
            for key, value in wanted.items():
                if value is not None and not key.startswith("reaction"):
                    assert results["metrics"][key] == pytest.approx(value, rel=1e-7, abs=1e-7), key
