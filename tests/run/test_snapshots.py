"""Snapshots: whole files or none, whatever happens, and a run that goes on continues them."""

import errno
import os
import shutil

from myostrain import Case, ComputationError, InputError
from myostrain.output import fields as fields_module
from myostrain.output.fields import FieldWriter, write_vtx
from myostrain.output.figures.data import Recording
from myostrain.output.folder import on_first, part_of
from myostrain.output.snapshots import Snapshots

import dolfinx.io
import numpy as np
import pytest

from small_cases import ALONE, LINE, SHEET
from snapshot_files import frame, write_snapshots

X, CELLS = np.linspace(0, 1, 3)[:, None], np.array([[0, 1], [1, 2]])
TIMES = np.array([0.0, 0.5, 1.0])


@pytest.fixture
def written(tmp_path):
    """A folder with three frames, v = t (1 + X)."""
    v = TIMES[:, None] * (1 + X[:, 0])
    write_snapshots(tmp_path, X, CELLS, TIMES, activation_time=[np.nan, 1.0, 0.5], potential=v)
    return tmp_path


@pytest.fixture(params=[LINE, SHEET], ids=["line", "sheet"])
def model(request):
    model = Case.from_dict(request.param).build(ALONE)
    model.start()
    return model


def listing(folder):
    return sorted(path.name for path in folder.iterdir())


def test_what_is_read(written):
    """The files' content, in double precision, by field and frame."""
    snapshots = Snapshots(written)
    np.testing.assert_array_equal(snapshots.points, X)
    np.testing.assert_array_equal(snapshots.cells, CELLS)
    np.testing.assert_array_equal(snapshots.times, TIMES)
    assert snapshots.names == {"potential"}
    np.testing.assert_array_equal(snapshots.field("potential"), 1 + X[:, 0])
    np.testing.assert_array_equal(snapshots.field("potential", 1), 0.5 * (1 + X[:, 0]))
    np.testing.assert_array_equal(snapshots.activation(), [np.nan, 1.0, 0.5])


@pytest.mark.parametrize("content", [b"", b"garbage", "half"], ids=str)
def test_frames_survive_a_run_killed_while_it_wrote(written, content):
    """A frame that was being written when the run was killed is not there; all others are."""
    if content == "half":
        content = frame(written, 2).read_bytes()[:200]
    part_of(frame(written, 3)).write_bytes(content)
    np.testing.assert_array_equal(Snapshots(written).times, TIMES)
    np.testing.assert_array_equal(Recording(written).history("potential")[1], 0.5 * (1 + X[:, 0]))


def flipped(content):
    """One bit of a value turned, so that only the checksum tells."""
    at = content.index(np.float64(1.5).tobytes()) + 3
    return content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :]


DAMAGES = {
    "empty": lambda content: b"",
    "cut": lambda content: content[: len(content) // 2],
    "text": lambda content: b"no archive",
    "npy": lambda content: b"\x93NUMPY\x01\x00",
    "pickle": lambda content: b"\x80\x04N.",
    "bit": flipped,
}


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("name", ["frame-000000002.npz", "mesh.npz"])
def test_a_damaged_file_is_named(written, name, damage):
    """One message of the user's kind that names the file and says what to do."""
    path = written / "snapshots" / name
    if name == "mesh.npz":
        np.savez(path, points=1.5 * X, cells=CELLS)
    path.write_bytes(DAMAGES[damage](path.read_bytes()))
    advice = "remove it" if name != "mesh.npz" else "run the case again"
    with pytest.raises(InputError, match=rf"{name} cannot be read.*{advice}"):
        Snapshots(written).field("potential")


@pytest.mark.parametrize("name, holds", [("mesh.npz", "time"), ("frame-000000000.npz", "potential")])
def test_a_file_without_what_it_must_hold_is_named(written, name, holds):
    """An archive that no run has written."""
    np.savez(written / "snapshots" / name, **{holds: TIMES})
    with pytest.raises(InputError, match=f"{name} cannot be read"):
        Snapshots(written)


def test_pickled_objects_are_never_loaded(written):
    """A result folder of somebody else's executes nothing."""
    np.savez(frame(written, 2), time=1.0, potential=np.array([None], dtype=object))
    with pytest.raises(InputError, match=r"frame-000000002.npz cannot be read.*allow_pickle=False"):
        Snapshots(written).field("potential")


def test_a_resumed_run_continues_the_frames(model, tmp_path):
    """truncate(step): frames up to the step stay, later ones and leavings of the killed run go."""
    writer = FieldWriter(model, tmp_path, ("potential", "displacement"))
    for step in (0, 40, 120):
        writer.write(step, step * 1e-3)
    writer.close({"activation_times": np.zeros((1, len(model.potential.v.x.array)))})
    part_of(frame(tmp_path, 160)).write_bytes(b"cut")
    kept = frame(tmp_path, 40).read_bytes()

    again = FieldWriter(model, tmp_path, ("potential", "displacement"))
    again.truncate(40)
    assert listing(tmp_path / "snapshots") == [f"frame-{n:09d}.npz" for n in (0, 40)] + ["mesh.npz"]
    assert frame(tmp_path, 40).read_bytes() == kept
    model.step(1e-3)
    again.write(80, 0.08)
    again.close()
    np.testing.assert_array_equal(Snapshots(tmp_path).times, [0.0, 0.04, 0.08])
    assert Snapshots(tmp_path).activation() is None


def test_fields_are_in_the_order_of_the_mesh(model, tmp_path):
    """Values, displacements and cells belong to the points that they are written with."""
    dim = model.potential.body.dim
    model.potential.v.interpolate(lambda x: 1 + x[0] - 2 * x[dim - 1])
    model.mechanics.u.interpolate(lambda x: np.stack([x[i] * (i + 2) for i in range(dim)]))
    writer = FieldWriter(model, tmp_path, ("potential", "displacement"))
    writer.write(0, 0.0)
    writer.close({"activation_times": 3 * model.potential.v.x.array[None, :]})
    found = Snapshots(tmp_path)
    expected = 1 + found.points[:, 0] - 2 * found.points[:, -1]
    np.testing.assert_allclose(found.field("potential"), expected, rtol=0, atol=1e-13)
    np.testing.assert_allclose(found.activation(), 3 * expected, rtol=0, atol=1e-13)
    stretched = found.points * np.arange(2, dim + 2)
    np.testing.assert_allclose(found.field("displacement"), stretched, rtol=0, atol=1e-13)
    edges = found.points[found.cells]
    volumes = np.abs(np.linalg.det(edges[:, 1:] - edges[:, :1]))
    assert volumes.min() > 0.05 * volumes.mean()  # neighbours are neighbours
    assert len(found.cells) == model.potential.body.cells


def no_space(*_, **__):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize("function", ["os.fsync", "numpy.savez"])
def test_a_full_disk_is_a_failed_computation(model, tmp_path, monkeypatch, function):
    """Requirements, "a full disk": what was written stays whole, and the message says how to go on."""
    writer = FieldWriter(model, tmp_path, ("potential",))
    writer.write(0, 0.0)
    with monkeypatch.context() as full:
        full.setattr(function, no_space)
        with pytest.raises(ComputationError) as failed:
            writer.write(4, 4e-3)
    assert str(failed.value) == (
        f"{frame(tmp_path, 4)} cannot be written: No space left on device. "
        "Try: free space, then `myostrain run --resume --out DIR`."
    )
    assert listing(tmp_path / "snapshots") == ["frame-000000000.npz", "mesh.npz"]
    writer.write(4, 4e-3)
    np.testing.assert_array_equal(Snapshots(tmp_path).times, [0.0, 4e-3])


def test_what_cannot_be_written_is_a_failed_computation(tmp_path):
    """on_first: every failure of the system is one, with its path, and leaves nothing unfinished behind."""
    part = part_of(tmp_path / "x")

    def denied():
        part.mkdir()
        (part / "deep").touch()
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    with pytest.raises(
        ComputationError, match=r"x cannot be written: Permission denied\. Try: make it writable"
    ):
        on_first(ALONE, denied, tmp_path / "x")
    assert listing(tmp_path) == []
    with pytest.raises(ZeroDivisionError):  # a mistake in the program is no full disk
        on_first(ALONE, lambda: 1 / 0, tmp_path / "x")


# fields.bp.


def test_vtx_does_not_fit(model, tmp_path, monkeypatch):
    """It is refused beforehand, the earlier one stays; where the run has failed, nothing hides why."""
    writer = FieldWriter(model, tmp_path, ("potential", "displacement"))
    writer.write(0, 0.0)
    writer.close()
    before = {path.name: path.read_bytes() for path in (tmp_path / "fields.bp").iterdir()}
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(fields_module.shutil, "disk_usage", lambda _: usage._replace(free=1000))
    with pytest.raises(ComputationError, match=r"fields.bp cannot be written: No space left.*--resume"):
        writer.close({"activation_times": np.zeros((1, len(model.potential.v.x.array)))})
    writer.close()
    assert {path.name: path.read_bytes() for path in (tmp_path / "fields.bp").iterdir()} == before
    assert listing(tmp_path) == ["fields.bp", "snapshots"]


def test_size_of_vtx_is_known_beforehand(tmp_path):
    """The estimate of a file that is mostly numbers: no less than the file, and not twice as much."""
    case = Case.from_dict({**SHEET, "geometry": {**SHEET["geometry"], "spacing": 0.3}})
    model = case.build(ALONE)
    writer = FieldWriter(model, tmp_path, ("potential", "displacement"))
    for step in range(4):
        writer.write(step, 0.1 * step)
    writer.close()
    size = sum(path.stat().st_size for path in (tmp_path / "fields.bp").iterdir())
    space = model.potential.v.function_space
    estimate = 4 * fields_module._frame_bytes(space, ["potential", "displacement"])
    assert 1.0 < estimate / size < 1.5


def test_vtx_is_made_of_the_snapshots(model, tmp_path, monkeypatch):
    """Every time with its own values at the right nodes, and none without a frame."""
    seen = []

    class Spy:
        def __init__(self, comm, path, functions):
            self.functions = functions

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def write(self, time):
            seen.append((time, {f.name: f.x.array.copy() for f in self.functions}))

    monkeypatch.setattr(dolfinx.io, "VTXWriter", Spy)
    writer = FieldWriter(model, tmp_path, ("potential", "displacement"))
    writer.close()
    assert not (tmp_path / "fields.bp").exists()
    kept = []
    for step in range(3):
        model.step(1e-3 * (step + 1))
        writer.write(step, model.time)
        u = model.mechanics.displacement()
        kept.append((model.time, {"potential": model.potential.v.x.array.copy(), u.name: u.x.array.copy()}))
    writer.close()
    assert [time for time, _ in seen] == [time for time, _ in kept]
    for (_, found), (_, expected) in zip(seen, kept, strict=True):
        assert found.keys() == expected.keys()
        for name, values in expected.items():
            np.testing.assert_array_equal(found[name], values)
    assert (tmp_path / "fields.bp").is_dir()
    assert not part_of(tmp_path / "fields.bp").exists()


def test_vtx_of_a_damaged_frame(model, tmp_path):
    """The message names the frame; no half file is left."""
    writer = FieldWriter(model, tmp_path, ("potential",))
    for step in range(2):
        writer.write(step, float(step))
    content = frame(tmp_path, 1).read_bytes()
    at = content.index(model.potential.v.x.array[:1].tobytes())
    frame(tmp_path, 1).write_bytes(content[:at] + b"x" + content[at + 1 :])
    with pytest.raises(InputError, match=r"frame-000000001.npz cannot be read"):
        write_vtx(tmp_path, model.potential.v.function_space)
    assert listing(tmp_path) == ["snapshots"]
