"""A contraction at a closed volume: on other numbers of processes, and stopped and gone on with."""

from myostrain import Case, run_case
from myostrain.case.running import load_results
from myostrain.errors import Interrupted
from myostrain.output.snapshots import Snapshots

import numpy as np
import pytest

from small_cases import ALONE, write_case

pytestmark = pytest.mark.mpi

#: Half a sphere of a few cells, activated over time and shut.
CLOSED = {
    "geometry": {
        "kind": "ventricle",
        "endocardium": [10.0, 10.0],
        "epicardium": [14.0, 14.0],
        "base": 0.0,
        "spacing": 6.0,
        "layers": 1,
    },
    "fibres": {"kind": "ellipsoidal", "endocardium": [10.0, 10.0], "epicardium": [14.0, 14.0]},
    "drive": {"potential": [[0.0, 0.0], [3.0, 1.0]]},
    "activation": {"law": "proportional", "beta": 0.15},
    "material": {"model": "NeoHookean", "mu": 2.0},
    "mechanics": {"kinematics": "solid", "sliding": ["base"], "tolerance": 1e-10},
    "circulation": {"kind": "isovolumetric", "cavity": "endocardium", "preload": 0.2, "beats": 1},
    "time": {"step": 0.5, "end": 3.0},
    "probes": {"a": [12.0, 0.0, -1.0]},
    "output": {"every": 1.0, "checkpoint_every": 1.0},
}

#: Goes on with the run of a folder, and runs it anew.
DRIVER = """
import sys
from pathlib import Path
from myostrain import Case, run_case
folder = Path(sys.argv[1])
case = Case.from_file(folder / "closed.toml")
run_case(case, folder / "resumed-two", resume=True, figures=False)
run_case(case, folder / "two", figures=False)
"""


class Stop:
    """Interrupts this process after three steps."""

    def update(self, number, time):
        if number == 3:
            raise Interrupted(15, time)


def test_closed_cavity_on_processes_and_resumed(on_processes, tmp_path):
    """The volume stays; the numbers are those of one process; a run that is stopped goes on bit by bit."""
    case = Case.from_file(write_case(tmp_path / "closed.toml", CLOSED))
    assert Case.from_dict(case.parameters).cavities == case.cavities
    run_case(case, tmp_path / "one", comm=ALONE, figures=False)
    for name in ("resumed-one", "resumed-two"):
        with pytest.raises(Interrupted):
            run_case(case, tmp_path / name, comm=ALONE, figures=False, progress=lambda *_: Stop())
    run_case(case, tmp_path / "resumed-one", comm=ALONE, figures=False, resume=True)
    on_processes(2, DRIVER, tmp_path)
    one = load_results(tmp_path / "one")["metrics"]
    measured = np.genfromtxt(tmp_path / "one" / "measures.csv", delimiter=",", names=True)
    assert np.ptp(measured["volume_endocardium"]) < 1e-8 * measured["volume_endocardium"][0]
    assert measured["pressure_endocardium"][0] == pytest.approx(0.2, rel=1e-9)
    assert np.all(np.diff(measured["pressure_endocardium"]) > 0.05)
    assert load_results(tmp_path / "resumed-one")["metrics"] == one
    whole, resumed = Snapshots(tmp_path / "one"), Snapshots(tmp_path / "resumed-one")
    for field in whole.names:
        np.testing.assert_array_equal(resumed.field(field), whole.field(field), err_msg=field)
    for name in ("two", "resumed-two"):
        other = load_results(tmp_path / name)
        assert other["processes"] == 2
        for key in ("volume_endocardium", "pressure_endocardium", "cavity_volume", "fibre_stretch_min"):
            assert other["metrics"][key] == pytest.approx(one[key], rel=1e-8), (name, key)
