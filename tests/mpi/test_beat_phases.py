"""A small beat with a Windkessel: stopped in each phase it goes on bit by bit; on two processes."""

from myostrain import Case, run_case
from myostrain.case.running import load_results
from myostrain.errors import Interrupted
from myostrain.output.snapshots import Snapshots

import numpy as np
import pytest
from test_cavities_processes import CLOSED

from small_cases import ALONE, changed, write_case

pytestmark = [pytest.mark.mpi, pytest.mark.slow]

#: Half a sphere of a few cells, activated and released over time, between an atrium and arteries.
BEAT = changed(
    CLOSED,
    {
        "geometry.spacing": 8.0,
        "drive.potential": [[0.0, 0.0], [2.0, 1.0], [4.0, 1.0], [5.5, 0.0]],
        "mechanics.robin_normal": {"epicardium": 0.05},
        "circulation": {
            "kind": "windkessel",
            "cavity": "endocardium",
            "filling_pressure": 0.25,
            "inlet_resistance": 2e-4,
            "resistance": 0.05,
            "compliance": 400.0,
            "impedance": 2e-4,
            "arterial_pressure": 0.38,
        },
        "time": {"step": 0.25, "end": 7.0},
        "output": {"every": 7.0, "checkpoint_every": 0.25, "fields": ["displacement"]},
    },
)

DRIVER = """
import sys
from pathlib import Path
from myostrain import Case, run_case
folder = Path(sys.argv[1])
run_case(Case.from_file(folder / "beat.toml"), folder / "two", figures=False)
"""


class Stop:
    """Interrupts this process at a time; remembers where it began."""

    def __init__(self, after):
        self.after, self.first = after, None

    def update(self, number, time):
        self.first = time if self.first is None else self.first
        if time > self.after - 1e-9:
            raise Interrupted(15, time)


def phases(found):
    """The steps of each phase: both valves shut, ejection, both shut again, filling."""
    pressure = found["pressure_endocardium"]
    ejects, fills = pressure > found["pressure_arteries"], pressure < 0.25 - 1e-9
    kinds = np.where(ejects, 1, np.where(fills, 2, 0))[1:]
    ends = np.flatnonzero(np.diff(kinds)) + 1
    parts = np.split(np.arange(1, len(kinds) + 1), ends)
    assert [kinds[part[0] - 1] for part in parts[:4]] == [0, 1, 0, 2], kinds
    return parts[:4]


def test_stopped_in_each_phase(on_processes, tmp_path):
    """Five parts of a beat are the whole one to the bit, two processes the same to 1e-7; no blood is lost."""
    case = Case.from_file(write_case(tmp_path / "beat.toml", BEAT))
    run_case(case, tmp_path / "whole", comm=ALONE, figures=False)
    whole, parts = tmp_path / "whole" / "cavities.csv", tmp_path / "parts"
    found = np.genfromtxt(whole, delimiter=",", names=True)
    begun = 0.0
    for number, steps in enumerate(phases(found)):
        assert len(steps) > 2
        stop = Stop(0.25 * steps[len(steps) // 2])
        with pytest.raises(Interrupted):
            run_case(case, parts, comm=ALONE, figures=False, resume=number > 0, progress=lambda *_, s=stop: s)
        assert stop.first > begun - 0.01  # not from the beginning again
        begun = stop.after
    run_case(case, parts, comm=ALONE, figures=False, resume=True)
    assert (parts / "cavities.csv").read_bytes() == whole.read_bytes()
    ends = [Snapshots(folder).field("displacement") for folder in (parts, tmp_path / "whole")]
    np.testing.assert_array_equal(*ends)

    on_processes(2, DRIVER, tmp_path)
    assert load_results(tmp_path / "two")["processes"] == 2
    other = np.genfromtxt(tmp_path / "two" / "cavities.csv", delimiter=",", names=True)
    for name in found.dtype.names:
        np.testing.assert_allclose(other[name], found[name], rtol=0, atol=1e-7 * np.abs(found[name]).max())

    held = found["volume_endocardium"] - found["inflow"] + found["outflow"]
    assert found["outflow"][-1] > 40.0
    np.testing.assert_allclose(held, held[0], rtol=0, atol=1.5e-5)  # the table has nine digits
