"""Where results go: nothing is overwritten that was not asked for, and nothing foreign ever."""

from myostrain import Case, InputError, run_case
from myostrain.output.folder import OWN, free_name, prepare, write_json

import pytest

from small_cases import ALONE, LINE, changed, strict_json


def snapshot_of(folder):
    return {str(p.relative_to(folder)): p.is_dir() or p.read_bytes() for p in sorted(folder.rglob("*"))}


def test_held_folder_is_refused_untouched(tmp_path):
    """Requirements, "an output folder that exists ...: nothing overwritten without --force"."""
    for name in ("results.json", "notes.txt", ".hidden"):
        folder = tmp_path / f"with {name}"
        folder.mkdir()
        (folder / name).write_text("mine")
        before = snapshot_of(folder)
        with pytest.raises(InputError, match=r"--out: .*--force"):
            run_case(Case.from_dict(LINE), folder, comm=ALONE)
        assert snapshot_of(folder) == before


@pytest.mark.parametrize(
    "foreign", ["notes.txt", "figures/mine.png", "snapshots/mine.npz", "rigid/notes.txt", "old/results.json"]
)
def test_force_never_removes_what_no_run_has_written(tmp_path, foreign):
    """folder.prepare: "results of an earlier run in it may be removed. Other files are never touched"."""
    out = tmp_path / "out"
    run_case(Case.from_dict(LINE), out, comm=ALONE, figures=False)
    (out / foreign).parent.mkdir(parents=True, exist_ok=True)
    (out / foreign).write_text("mine")
    (out / "results.json").write_text("old")
    try:
        run_case(Case.from_dict(LINE), out, comm=ALONE, force=True, figures=False)
    except InputError:
        assert (out / "results.json").read_text() == "old"
    assert (out / foreign).read_text() == "mine"


def test_force_replaces_an_earlier_run_wholly(tmp_path):
    """--force: what an earlier run wrote is gone, also what the new one does not write."""
    out = tmp_path / "out"
    run_case(Case.from_dict(changed(LINE, {"output.rigid_twin": True})), out, comm=ALONE)
    (out / "failure.json").write_text("{}")
    assert (out / "rigid").exists()
    run_case(Case.from_dict(changed(LINE, {"probes": {}})), out, comm=ALONE, force=True, figures=False)
    left = {path.name for path in out.iterdir()}
    assert left == {"case.toml", "results.json", "fields.bp", "snapshots", "checkpoint", "run.log"}
    assert left < set(OWN)


def test_folder_that_cannot_be_written(tmp_path):
    """Requirements, "an output folder that ... cannot be written": one message, nothing computed."""
    (tmp_path / "file").write_text("mine")
    for path, words in (
        (tmp_path / "file", "is a file"),
        (tmp_path / "file" / "below", "cannot be written"),
        ("/proc/nonexistent/out", "cannot be written"),
    ):
        with pytest.raises(InputError, match=f"--out: .*{words}"):
            prepare(tmp_path / path, force=True, comm=ALONE)
    assert (tmp_path / "file").read_text() == "mine"


def test_new_and_empty_folders_are_taken(tmp_path):
    """interface.md, --out DIR: made with its parents where it is not there, used where it is empty."""
    (tmp_path / "empty").mkdir()
    for path in (tmp_path / "empty", tmp_path / "a" / "b"):
        lock = prepare(path, force=False, comm=ALONE)
        assert lock is not None
        lock.release()
        assert list(path.iterdir()) == []


def test_names_and_numbers(tmp_path):
    """Without --out nothing is overwritten: the first free name; JSON holds no infinity and refuses NaN."""
    base = tmp_path / "case"
    for expected in ("case", "case-2", "case-3"):
        assert free_name(base).name == expected
        free_name(base).mkdir()
    write_json(tmp_path / "x.json", {"until": float("inf"), "deep": [{"a": (1.5, None)}]})
    assert strict_json((tmp_path / "x.json").read_text()) == {"until": "inf", "deep": [{"a": [1.5, None]}]}
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(tmp_path / "x.json", {"x": float("nan")})
    assert sorted(path.name for path in tmp_path.iterdir() if path.is_file()) == ["x.json"]
    assert strict_json((tmp_path / "x.json").read_text())["until"] == "inf"
