"""Where results go: nothing is overwritten that was not asked for, and nothing foreign ever."""

import contextlib
import fcntl
import os
import shutil
import subprocess
import sys
from pathlib import Path

from myostrain import Case, InputError, run_case
from myostrain.kernel_cache import claim_cache, sure_of_the_compiler
from myostrain.output.folder import free_name, prepare, write_json

import pytest

from small_cases import ALONE, LINE, changed, command_line, strict_json, write_case

#: A line without fields, and so without pictures.
BARE = changed(LINE, {"output.fields": []})


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


FOREIGN = (
    *("notes.txt", "figures/mine.png", "snapshots/mine.npz", "rigid/notes.txt", "old/results.json"),
    *("fields.bp/mine", "fields.bp/deep/mine", "checkpoint/mine.ckpt", "checkpoint/step-1-mine.ckpt"),
    *("rigid/checkpoint/mine.ckpt", "snapshots/frame-000009999.npz", "measures.txt", "lines.csv"),
)


@pytest.fixture(scope="module")
def twins(tmp_path_factory):
    """A result folder with that of a rigid twin in it."""
    out = tmp_path_factory.mktemp("twins") / "out"
    run_case(Case.from_dict(changed(LINE, {"output.rigid_twin": True})), out, comm=ALONE, figures=False)
    return out


@pytest.mark.parametrize("foreign", FOREIGN)
def test_force_never_removes_what_no_run_has_written(tmp_path, twins, foreign):
    """folder.prepare: "results of an earlier run in it may be removed. Other files are never touched"."""
    out = tmp_path / "out"
    shutil.copytree(twins, out)
    (out / foreign).parent.mkdir(parents=True, exist_ok=True)
    (out / foreign).write_text("mine")
    before = snapshot_of(out)
    with pytest.raises(InputError, match="no run has written"):
        prepare(out, force=True, comm=ALONE)
    assert snapshot_of(out) == before


@pytest.mark.parametrize("foreign", ["run.log", "probes.csv", ".manifest", ".lock"])
def test_force_in_a_folder_of_no_run_removes_nothing(tmp_path, foreign):
    """A file that is called as one of ours is not ours for that."""
    (tmp_path / foreign).write_text("mine")
    with pytest.raises(InputError, match="--out"):
        prepare(tmp_path, force=True, comm=ALONE)
    assert snapshot_of(tmp_path) == {foreign: b"mine"}


@pytest.mark.parametrize("name", [".lock", ".manifest", ".case.toml.part", "case.toml", "run.log"])
def test_links_are_not_followed(tmp_path, name):
    """A link in the place of a file of ours: what it names stays as it is, whatever is asked."""
    precious, out = tmp_path / "precious", tmp_path / "out"
    precious.write_text("mine")
    for again in (False, True):
        if again and name != ".case.toml.part":
            run_case(Case.from_dict(LINE), tmp_path / "other", comm=ALONE, figures=False, force=True)
            out = tmp_path / "other"
            (out / name).unlink(missing_ok=True)
        out.mkdir(exist_ok=True)
        if not (out / name).is_symlink():
            (out / name).symlink_to(precious)
        with contextlib.suppress(InputError):
            run_case(Case.from_dict(LINE), out, comm=ALONE, force=True, figures=False)
        assert precious.read_text() == "mine"


@pytest.mark.parametrize("kind", ["pipe", "folder", "device"])
def test_a_lock_that_is_none_is_left_alone(tmp_path, kind):
    """Neither a hang nor a traceback."""
    lock = tmp_path / ".lock"
    if kind == "pipe":
        os.mkfifo(lock)
    elif kind == "folder":
        lock.mkdir()
    else:
        lock.symlink_to("/dev/null")
    with pytest.raises(InputError, match=r"\.lock is not a lock"):
        prepare(tmp_path, force=True, comm=ALONE)
    assert lock.exists()


@pytest.mark.parametrize("left", [(".case.toml.part",), (".writable",), (".lock", ".manifest")])
def test_what_a_kill_leaves_is_in_nobodys_way(tmp_path, left):
    """Killed before anything was written: the same command runs, without --force."""
    for name in left:
        (tmp_path / name).touch()
    command = ("run", write_case(tmp_path.with_name("mine.toml"), BARE), "--out", tmp_path)
    for more in (("--resume",), ("--force",)):
        assert command_line(*command, *more).status == 0
    (tmp_path / "clean").mkdir()
    for name in left:
        (tmp_path / "clean" / name).touch()
    assert command_line(*command[:-1], tmp_path / "clean").status == 0


class Killed(BaseException):
    """In place of SIGKILL, which no handler sees."""


def test_killed_while_drawing_the_pictures_are_drawn_by_the_next_run(tmp_path, monkeypatch):
    """All are there, whole, when the run is resumed; and no more is drawn then."""
    case, out = Case.from_dict(LINE), tmp_path / "out"
    replace = Path.replace

    def killed(self, target):
        if self.name == ".evolution.png.part":
            raise Killed
        return replace(self, target)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", killed)
        with pytest.raises(Killed):
            run_case(case, out, comm=ALONE)
    assert [path.name for path in (out / "figures").glob("*.png")] == ["potential.png"]
    done = command_line("run", "--resume", "--out", out)
    assert (done.status, "figures" in done.out.splitlines()[0]) == (0, True)
    pictures = {"potential.png", "evolution.png", "space-time.png", "deformation.png", "probes.png"}
    assert {path.name for path in (out / "figures").glob("*.png")} == pictures
    drawn = {path.name: path.stat().st_mtime_ns for path in (out / "figures").iterdir()}
    again = command_line("run", "--resume", "--out", out)
    assert again.out.splitlines()[0].endswith("had ended already")
    assert {path.name: path.stat().st_mtime_ns for path in (out / "figures").iterdir()} == drawn
    prepare(out, force=True, comm=ALONE)
    assert not (out / "figures").exists()


@pytest.mark.parametrize("content", [b"", b"[]", b"{}", b"[1, 2]", b"3", b"\xff\0", b'{"steps": 1}', None])
@pytest.mark.parametrize("command", [("run", "--resume", "--out"), ("plot",)])
def test_results_that_are_none_are_refused(tmp_path, twins, content, command):
    """Empty, a list, a folder: one message that names the file, exit status 2. Figures need less of it."""
    if command == ("plot",) and content in (b"{}", b'{"steps": 1}'):
        content = b'{"metrics": []}'
    out = tmp_path / "out"
    shutil.copytree(twins, out)
    path = out / "results.json"
    path.unlink()
    path.mkdir() if content is None else path.write_bytes(content)
    done = command_line(*command, out)
    assert (done.status, "results.json" in done.err) == (2, True)
    assert "Traceback" not in done.err


@pytest.mark.parametrize("name", ["results.json", "probes.csv", "case.toml", "snapshots/frame-000000010.npz"])
def test_pipes_and_devices_are_refused(tmp_path, twins, name):
    """What never ends is not read."""
    out = tmp_path / "out"
    shutil.copytree(twins, out)
    for make in (os.mkfifo, lambda path: path.symlink_to("/dev/zero")):
        (out / name).unlink()
        make(out / name)
        done = command_line("plot", out)
        assert (done.status, name in done.err) == (2, True), done.err


def test_force_replaces_an_earlier_run_wholly(tmp_path):
    """--force: what an earlier run wrote is gone, also what the new one does not write."""
    out = tmp_path / "out"
    run_case(Case.from_dict(changed(LINE, {"output.rigid_twin": True})), out, comm=ALONE)
    (out / "failure.json").write_text("{}")
    assert (out / "rigid").exists()
    run_case(Case.from_dict(changed(LINE, {"probes": {}})), out, comm=ALONE, force=True, figures=False)
    left = {path.name for path in out.iterdir()}
    written = {"case.toml", "results.json", "fields.bp", "snapshots", "checkpoint", "run.log", "measures.csv"}
    assert left == {*written, "references.bib", ".manifest"}


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


@pytest.mark.parametrize(
    "command", [("run", "LINE"), ("run", "LINE", "--resume"), ("run", "--resume"), ("plot",)]
)
@pytest.mark.parametrize("kind", ["long", "loop"])
def test_names_that_cannot_be_folders(tmp_path, command, kind):
    """A name of 300 characters, links in a circle: one message, exit status 2."""
    name = tmp_path / ("x" * 300 if kind == "long" else "loop")
    if kind == "loop":
        name.symlink_to(name)
    words = [write_case(tmp_path / "mine.toml", LINE) if word == "LINE" else word for word in command]
    done = command_line(*words, *(() if command == ("plot",) else ("--out",)), name)
    assert (done.status, "cannot be used" in done.err) == (2, True), done.err
    assert done.err.count("\n") == 1


def test_kernels_in_a_folder_that_cannot_be_written(tmp_path):
    """The message says which, and how to name another."""
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"file/kernels cannot be written .* XDG_CACHE_HOME"):
        claim_cache(tmp_path / "file" / "kernels")


def test_what_a_killed_compiler_left_is_removed_when_nobody_compiles(tmp_path):
    """FFCx would wait for it for ever: a C file without the one that says that its library is done."""
    marks = ("libffcx_forms_c.c.cached", "libffcx_forms_d.c.failed")  # of sources that somebody removed
    for name in ("libffcx_forms_a.c", "libffcx_forms_b.c", "libffcx_forms_b.c.cached", "mine.c", *marks):
        (tmp_path / name).touch()
    with (tmp_path / ".in-use").open("w") as other:
        fcntl.flock(other, fcntl.LOCK_SH)
        claim_cache(tmp_path)
        assert (tmp_path / "libffcx_forms_a.c").exists()
    # The lock that this process took above is kept until it ends: another folder for another process.
    copy = shutil.copytree(tmp_path, tmp_path / "copy")
    script = "import sys; from pathlib import Path; from myostrain.kernel_cache import claim_cache; "
    script += "claim_cache(Path(sys.argv[1]))"
    subprocess.run([sys.executable, "-c", script, copy], check=True)
    left = {path.name for path in copy.iterdir()}
    assert left == {".in-use", "libffcx_forms_b.c", "libffcx_forms_b.c.cached", "mine.c"}


#: Compiles a form in the folder of its argument.
COMPILES = """
import os, sys
os.environ["XDG_CACHE_HOME"] = sys.argv[1]
import myostrain.engine as engine, ufl
from dolfinx import mesh
cells = mesh.create_interval(engine.MPI.COMM_SELF, 1, [0, 1])
print(engine.fem.assemble_scalar(engine.compile_form(engine.fem.Constant(cells, 7.0) * ufl.dx)))
"""


def test_a_compiler_killed_beside_the_living_is_not_waited_for(tmp_path):
    """A run that was killed while it compiled, another that lives: the next one does not wait 300 s."""

    def compiled():
        done = [sys.executable, "-c", COMPILES, tmp_path]
        return float(subprocess.run(done, check=True, capture_output=True, timeout=60).stdout)

    assert compiled() == 7.0
    (mark,) = tmp_path.glob("myostrain/kernels-*/libffcx_forms_*.c.cached")
    with (mark.parent / ".in-use").open("w") as other:
        fcntl.flock(other, fcntl.LOCK_SH)
        mark.unlink()
        assert compiled() == 7.0
    assert mark.exists()


def test_a_compiler_that_lives_is_waited_for(tmp_path):
    """Its source stays; and if it is killed meanwhile, the one who waits compiles."""
    source, asked = tmp_path / "kernel.c", []
    source.touch()
    find = sure_of_the_compiler(lambda *arguments: asked.append(source.exists()))
    with (tmp_path / "kernel.c.lock").open("w") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        find("kernel", ["f"], tmp_path, 0.3)
    find("kernel", ["f"], tmp_path, 60)
    assert asked == [True, False]
    source.touch()
    (tmp_path / "kernel.c.cached").touch()
    find("kernel", ["f"], tmp_path, 60)
    assert asked == [True, False, True]


def test_kernels_that_nobody_uses_any_more_are_removed(tmp_path, monkeypatch):
    """The folder does not grow without end: the least recently used go, whole, and all object files."""
    monkeypatch.setattr("myostrain.kernel_cache.KEPT", 3)
    endings = (".c", ".c.cached", ".cpython-312-x86_64-linux-gnu.so", ".o")
    for number, name in enumerate(["d", "b", "a", "c", "e"]):
        for ending in endings:
            path = tmp_path / f"libffcx_forms_{name}{ending}"
            path.touch()
            os.utime(path, (1e9 + number, 1e9 + number))
    claim_cache(tmp_path)
    kept = {f"libffcx_forms_{name}{ending}" for name in "ace" for ending in endings[:-1]}
    assert {path.name for path in tmp_path.iterdir()} == {".in-use", *kept}


def test_new_and_empty_folders_are_taken(tmp_path):
    """--out DIR: made with its parents where it is not there, used where it is empty."""
    (tmp_path / "empty").mkdir()
    for path in (tmp_path / "empty", tmp_path / "a" / "b"):
        lock = prepare(path, force=False, comm=ALONE)
        assert lock is not None
        lock.release()
        assert [path.name for path in path.iterdir()] == [".manifest"]


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
