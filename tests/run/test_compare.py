"""Runs beside each other: differences are those of their numbers, and the page needs nothing beside it."""

import csv
import re
import shutil
import subprocess
import sys

import myostrain as ms
from myostrain.case.running import run_case

import numpy as np
import pytest
from PIL import Image

from small_cases import ALONE, STATIC, changed, command_line


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two folders of one name, and a third; units, measures, and fields in none."""
    folder = tmp_path_factory.mktemp("compare")
    base = changed(STATIC, {"units": {"length": "mm", "stress": "kPa"}, "output.fields": []})
    for name, tension in (("one/run", 0.3), ("two/run", 0.2), ("other", 0.3)):
        case = ms.Case.from_dict(changed(base, {"activation.tension": tension}))
        run_case(case, folder / name, comm=ALONE)
    return folder


def test_differences_are_those_of_the_numbers(runs):
    found = ms.compare(runs / "one" / "run", runs / "two" / "run")
    assert found.names == ["one/run", "two/run"]
    assert found.case == {"activation.tension": [0.3, 0.2]}
    first, second = (ms.open(runs / name / "run").metrics for name in ("one", "two"))
    np.testing.assert_array_equal(
        found.metrics["displacement_max"], [first["displacement_max"], second["displacement_max"]]
    )
    assert found.metrics["displacement_max"].attrs == {"units": "mm"}
    row = next(row for row in found.rows() if row[0] == "displacement_max")
    change = second["displacement_max"] - first["displacement_max"]
    assert row[:2] == ["displacement_max", "mm"]
    assert row[2:4] == [f"{first['displacement_max']:.5g}", f"{second['displacement_max']:.5g}"]
    assert row[4] == f"{change:+.3g} ({100 * change / first['displacement_max']:+.3g} %)"
    assert "celerity" not in repr(found)  # neither has one
    assert "<td" in found._repr_html_()


def test_what_is_zero_but_for_rounding_has_no_difference(runs, monkeypatch):
    """Forces that cancel, and small pure numbers, would differ by hundreds of per cent."""
    found = ms.compare(runs / "one" / "run", runs / "two" / "run")
    first, second = found.runs
    monkeypatch.setattr(type(first), "least_force", 1e-6)
    for run, share in ((first, 0.1), (second, -0.9)):
        run.metrics._values["reaction_left_x"] = share * first.least_force
        run.metrics._values["twist"] = share * 1e-10
        run.metrics.units["twist"] = "degree"
    rows = {row[0]: row for row in found.rows()}
    assert rows["reaction_left_x"][-1] == rows["twist"][-1] == "rounding"
    second.metrics._values["reaction_left_x"] = 1.1 * first.least_force
    second.metrics._values["twist"] = 1.1e-10
    rows = {row[0]: row for row in found.rows()}
    assert rows["reaction_left_x"][-1].endswith("(+1e+03 %)")
    assert rows["twist"][-1].endswith("(+1e+03 %)")


def test_equal_runs_are_the_same(runs):
    found = ms.compare(runs / "one" / "run", runs / "other")
    assert found.names == ["run", "other"]
    assert {row[-1] for row in found.rows()} == {"same"}
    assert repr(found).startswith("the cases are the same")


def test_the_command_writes_table_picture_and_page(runs, tmp_path, monkeypatch):
    """The page holds the picture and loads nothing; the table has the differences as numbers."""
    monkeypatch.chdir(tmp_path)
    folders = [runs / "one" / "run", runs / "two" / "run", runs / "other"]
    done = command_line("compare", *folders, "--html")
    assert (done.status, done.err) == (0, "")
    out = tmp_path / "runs" / "compare"
    assert sorted(path.name for path in out.iterdir()) == ["compare.png", "index.html", "metrics.csv"]
    text = (out / "index.html").read_text()
    assert re.findall(r'(?:src|href)="(?!data:)', text) == []
    assert "activation.tension" in text
    with (out / "metrics.csv").open(newline="") as stream:
        rows = {row["metric"]: row for row in csv.DictReader(stream)}
    first, second = (float(rows["displacement_max"][name]) for name in ("one/run", "two/run"))
    less = float(rows["displacement_max"]["two/run less one/run"])
    assert less == pytest.approx(second - first, rel=1e-6)
    pixels = np.asarray(Image.open(out / "compare.png").convert("RGB")).reshape(-1, 3)
    for colour in ((0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00)):  # of two runs that differ
        assert (np.abs(pixels - colour).max(axis=1) < 30).sum() > 300
    assert command_line("compare", *folders, "--out", folders[0]).status == 2


def test_loops_over_each_other(runs, tmp_path):
    """Of two runs with cavities, each in its colour; a run without cavities is left out, one alone too."""
    folders = [shutil.copytree(runs / "other", tmp_path / str(number)) for number in range(3)]
    angle = np.linspace(0, 2 * np.pi, 50)
    for folder, width in zip(folders[1:], (20.0, 40.0), strict=True):
        columns = np.column_stack([angle, 100 + width * np.sin(angle), 60 + 50 * np.cos(angle)])
        header = "time,volume_left,pressure_left"
        np.savetxt(folder / "cavities.csv", columns, delimiter=",", header=header, comments="")
    written = ms.compare(*folders).write(tmp_path / "out", page=True)
    assert written[-2] == tmp_path / "out" / "loops.png"
    pixels = np.asarray(Image.open(written[-2]).convert("RGB")).reshape(-1, 3)
    for colour in ((0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00)):
        assert (np.abs(pixels - colour).max(axis=1) < 30).sum() > 300
    assert "Pressure–volume loops" in (tmp_path / "out" / "index.html").read_text()
    assert ms.compare(*folders[:2]).draw_loops(tmp_path / "none.png") is None


def test_it_needs_no_solver_and_two_folders(runs):
    code = f"""
import sys
for name in ("dolfinx", "mpi4py", "petsc4py"):
    sys.modules[name] = None
import myostrain as ms
print(ms.compare({str(runs / "one" / "run")!r}, {str(runs / "other")!r}))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    with pytest.raises(ms.InputError, match="two result folders"):
        ms.compare(runs / "other")
    with pytest.raises(ms.InputError, match="is not there"):
        ms.compare(runs / "other", runs / "none")
