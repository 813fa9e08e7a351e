"""A case whose potential has a mesh of its own: what its result folder holds."""

import csv
import json

from myostrain import Case, run_case
from myostrain.output.snapshots import Snapshots

import numpy as np
import pytest

from small_cases import ALONE, LINE, SOLID, changed, command_line, write_case
from snapshot_files import check_vtx


def test_result_folder(tmp_path):
    """Frames, fields.bp and probes are of the fine mesh, and hold the displacement of mechanics itself."""
    fields = ["potential", "activation", "displacement", "stress", "stress_trace"]
    case = changed(
        LINE,
        {
            "geometry.spacing": 2.0,
            "potential.refinement": 2,
            "output": {"fields": fields, "every": 5e-3, "rigid_twin": True},
            "mechanics.robin": 0.3,
        },
    )
    done = command_line("run", write_case(tmp_path / "case.toml", case), "--out", tmp_path / "out")
    assert done.status == 0, done.err
    results = json.loads((tmp_path / "out" / "results.json").read_text())
    assert results["cells"] == 40
    assert results["unknowns"] == {"potential": 41, "states": 41, "mechanics": 21}
    for folder in (tmp_path / "out", tmp_path / "out" / "rigid"):
        found = Snapshots(folder)
        np.testing.assert_allclose(np.sort(found.points[:, 0]), np.linspace(0, 20, 41), atol=1e-12)
        assert found.names == {"potential", "activation", "displacement", "stress_xx", "stress_trace"}
        check_vtx(folder)
    order = np.argsort(Snapshots(tmp_path / "out").points[:, 0])
    u = Snapshots(tmp_path / "out").field("displacement")[order, 0]
    # Quadratic in a cell of mechanics, five nodes: third differences vanish in it, and second ones do not.
    cells = np.array([u[i : i + 5] for i in range(0, 40, 4)])
    assert np.abs(np.diff(cells, 3, axis=1)).max() < 1e-12
    assert np.abs(np.diff(cells, 2, axis=1)).max() > 1e-4
    assert not Snapshots(tmp_path / "out" / "rigid").field("displacement").any()
    with (tmp_path / "out" / "probes.csv").open() as stream:
        last = list(csv.DictReader(stream))[-1]
    X = np.linspace(0, 20, 41)
    assert float(last["a_displacement_x"]) == pytest.approx(np.interp(6.0, X, u), rel=1e-8)
    assert (tmp_path / "out" / "figures").is_dir()


def test_measures_of_a_solid_are_those_of_mechanics(tmp_path):
    """With no wave the body and its measures are what they are on one mesh."""
    found = []
    for levels in (0, 1):
        case = changed(
            SOLID,
            {
                "potential.refinement": levels,
                "activation.beta": 0.0,
                "mechanics.pressure": {"right": [[0.0, 0.0], [0.03, 0.05]]},
            },
        )
        found.append(run_case(Case.from_dict(case), tmp_path / str(levels), comm=ALONE, figures=False))
    one, two = (f["metrics"] for f in found)
    assert one["fibre_stretch_mean"] < 0.999
    for name in ("volume_ratio", "fibre_stretch_mean", "fibre_stretch_min"):
        assert two[name] == pytest.approx(one[name], rel=1e-9)
    assert (tmp_path / "1" / "measures.csv").is_file()


def test_a_changed_refinement_is_not_resumed(tmp_path):
    """Another mesh: refused by a message, whether the run had ended or not."""
    file = write_case(tmp_path / "case.toml", changed(LINE, {"potential.refinement": 1, "output.fields": []}))
    assert command_line("run", file, "--out", tmp_path / "out").status == 0
    for ended in (True, False):
        if not ended:
            (tmp_path / "out" / "results.json").unlink()
        done = command_line("run", "--resume", "--out", tmp_path / "out", "--set", "potential.refinement=2")
        assert done.status == 2
        assert "potential.refinement" in done.err
        assert done.err.count("\n") == 1


def test_a_given_potential_has_no_refinement(tmp_path):
    """With [drive] nothing is solved that a finer mesh would help."""
    case = changed(LINE, {"potential": {"refinement": 1}, "drive": {"potential": 1.0}})
    done = command_line("run", write_case(tmp_path / "case.toml", case), "--out", tmp_path / "out")
    assert done.status == 2
    assert "[drive]" in done.err
