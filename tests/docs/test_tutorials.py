"""The tutorials are notebooks: they run, print what they show, and are short and small."""

import contextlib
import io
import json
from pathlib import Path

import matplotlib as mpl
import pytest

FOLDER = Path(__file__).parents[2] / "docs" / "tutorials"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


def cells(path, kind):
    found = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return [cell for cell in found if cell["cell_type"] == kind]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_tutorial_prints_what_it_shows(path, tmp_path, monkeypatch):
    """Every cell runs, in an empty folder, and prints what is stored with it; pictures are there."""
    monkeypatch.chdir(tmp_path)
    names, pictures = {"__name__": "__main__"}, 0
    with mpl.rc_context({"backend": "agg"}):
        for cell in cells(path, "code"):
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                exec(compile("".join(cell["source"]), path.name, "exec"), names)
            stored = [each for each in cell["outputs"] if each["output_type"] == "stream"]
            assert "".join("".join(each["text"]) for each in stored) == out.getvalue()
            pictures += sum("image/png" in each.get("data", {}) for each in cell["outputs"])
    assert pictures >= 1


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_tutorial_is_short_and_small(path):
    """Text between the cells, few lines in each, and no more than a page's worth of bytes."""
    assert path.stat().st_size < 150_000
    assert len(cells(path, "markdown")) >= 4
    assert all(len(cell["source"]) <= 45 for cell in cells(path, "code"))
