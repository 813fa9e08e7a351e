"""Tips, electrodes and beats of a run that goes on with another number of processes."""

from myostrain import Case, run_case
from myostrain.case.running import load_results
from myostrain.errors import Interrupted
from myostrain.output.snapshots import Snapshots

import numpy as np
import pytest

from small_cases import ALONE, SHEET, changed, write_case

pytestmark = pytest.mark.mpi

CASE = changed(
    SHEET,
    {
        "geometry": {"kind": "ellipse", "size": [24.0, 30.0], "spacing": 3.0, "distortion": 0.15},
        "potential.refinement": 1,
        "initial": [
            {"potential": 0.9, "center": [17.0, 6.0], "radius": 5.0},
            {"states": {"recovery": 0.1}, "box": [[18.0, 0.0], [24.0, 30.0]]},
        ],
        "time": {"step": 4e-3, "end": 0.16, "scheme": "second-order"},
        "mechanics.every": 1,
        "electrodes": {"V1": [12.0, 12.0, 6.0], "V2": [40.0, 12.0, 0.0]},
        "output": {
            "every": 0.04,
            "repolarization": [20, 90],
            "checkpoint_every": 0.04,
            "tip": {"potential": 0.2, "state": "recovery", "value": 0.05, "every": 4e-3},
        },
    },
)

#: Runs a case on these processes: all of it into one folder, a part of it or the rest into another.
DRIVER = """
import sys
from pathlib import Path
from myostrain import Case, run_case
from myostrain.errors import Interrupted
case, folder = Case.from_file(sys.argv[1]), Path(sys.argv[2])
class Stop:
    def update(self, number, time):
        if number == 23:
            raise Interrupted(15, time)
try:
    run_case(case, folder / "two-one", figures=False, progress=lambda *_: Stop())
except Interrupted:
    pass
run_case(case, folder / "one-two", resume=True, figures=False)
"""


class Stop:
    """Stops a run on this process after a step that is no checkpoint's."""

    def update(self, number, time):
        """Raise what a signal would."""
        if number == 23:
            raise Interrupted(15, time)


def rows(folder, name):
    return np.loadtxt(folder / name, delimiter=",", skiprows=1)


def close(a, b, what):
    """Numbers, lists of them, or None, which is only close to None."""
    a, b = (np.asarray(each, dtype=float) for each in (a, b))
    np.testing.assert_allclose(a, b, rtol=1e-6, atol=1e-7, err_msg=str(what))


def test_begun_on_one_and_ended_on_two_and_the_other_way_round(on_processes, tmp_path):
    """docs/howto/resume.md: on any number of processes; tables, beats and metrics are those of one run."""
    file = write_case(tmp_path / "case.toml", CASE)
    case = Case.from_file(file)
    run_case(case, tmp_path / "one", comm=ALONE, figures=False)
    with pytest.raises(Interrupted):
        run_case(case, tmp_path / "one-two", comm=ALONE, figures=False, progress=lambda *_: Stop())
    on_processes(2, DRIVER, file, tmp_path)
    run_case(case, tmp_path / "two-one", comm=ALONE, resume=True, figures=False)
    whole = load_results(tmp_path / "one")
    for name, processes in (("one-two", 2), ("two-one", 1)):
        found = load_results(tmp_path / name)
        assert found["processes"] == processes
        log = (tmp_path / name / "run.log").read_text(encoding="utf-8")
        assert "resumed at t = 0.092, step 23" in log  # where the stop left a checkpoint
        for table in ("tip.csv", "ecg.csv", "probes.csv"):
            wanted = rows(tmp_path / "one", table)
            assert len(wanted) > 20
            np.testing.assert_allclose(
                rows(tmp_path / name, table), wanted, rtol=1e-5, atol=1e-6, err_msg=table
            )
        assert found["probes"].keys() == whole["probes"].keys()
        for probe, values in whole["probes"].items():
            for key, value in values.items():
                close(found["probes"][probe][key], value, (name, probe, key))
        for key, value in whole["metrics"].items():
            if not key.startswith("reaction"):
                close(found["metrics"][key], value, (name, key))
        maps, others = (Snapshots(tmp_path / run).maps() for run in (name, "one"))
        assert maps.keys() == others.keys() >= {"activation_times", "repolarization_times_20"}
        for key, values in others.items():
            np.testing.assert_allclose(maps[key], values, rtol=1e-5, atol=1e-6, err_msg=key)
