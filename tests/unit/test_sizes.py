"""Sizes told before meshing, and what is refused for them."""

import dataclasses
import math
import resource
import shutil
import tracemalloc
from collections import namedtuple

from myostrain import Case, InputError
from myostrain.case import size_estimate as sizes
from myostrain.run import free_space as resources

import pytest

from small_cases import ALONE, LINE, SHEET, changed, command_line, write_case

RECTANGLE = changed(SHEET, {"geometry": {"kind": "rectangle", "size": [20.0, 24.0], "spacing": 1.0}})
SOLID = changed(
    RECTANGLE, {"mechanics.kinematics": "solid", "probes": {}, "fibres.direction": [1.0, 0.0, 0.0]}
)
SLAB = changed(SOLID, {"geometry": {"kind": "slab", "size": [4.0, 3.0, 2.0], "spacing": 1.0}})
VENTRICLE = changed(
    SOLID, {"geometry": {"kind": "ventricle", "spacing": 3.0}, "fibres": {"kind": "ellipsoidal"}}
)


@pytest.mark.parametrize(
    "data",
    [
        LINE,
        SHEET,
        RECTANGLE,
        changed(SHEET, {"mechanics.kinematics": "plane-strain"}),
        changed(LINE, {"potential.refinement": 3}),
        changed(RECTANGLE, {"potential.refinement": 1}),
        changed(SLAB, {"potential.refinement": 2, "initial.center": [0.0, 0.0, 0.0]}),
    ],
    ids=["line", "ellipse", "rectangle", "plane strain", "finer line", "finer rectangle", "finer slab"],
)
def test_estimate_is_what_comes_out(data):
    """Cells and nodes exactly where the spacing divides the body, else within the rings' rounding."""
    case = Case.from_dict(data)
    size, simulation = sizes.estimate(case), case.simulation(ALONE)
    potential, mechanics = simulation.model.potential, simulation.model.mechanics
    nodes = len(potential.v.x.array)
    unknowns = nodes * (1 + len(potential.states)) + len(mechanics.u.x.array)
    # Ellipse: 3.98 rings are rounded to 4. Unknowns of P2: a body of few cells has fewer edges than 3 a node.
    assert size.nodes == pytest.approx(nodes, rel=0.02)
    assert size.cells == pytest.approx(potential.body.cells, rel=0.02)
    assert size.unknowns == pytest.approx(unknowns, rel=0.15)
    assert size.steps == simulation.steps == 10
    assert size.frames == 2 + 5


def a_case(base, changes):
    return Case.from_dict(changed(base, changes))


@pytest.mark.parametrize(
    "base, spacing, key",
    [
        (LINE, 1e-6, "geometry.spacing"),
        (SHEET, 1e-2, "geometry.spacing"),
        (RECTANGLE, 1e-2, "geometry.spacing"),
        (SLAB, 1e-2, "geometry.spacing"),
        (VENTRICLE, 1e-2, "geometry.spacing"),
    ],
    ids=["line", "ellipse", "rectangle", "slab", "ventricle"],
)
def test_too_fine_is_refused_before_meshing(monkeypatch, base, spacing, key):
    """Requirements, "Input": a message before memory runs out, with a spacing that fits."""
    monkeypatch.setattr(sizes, "free_memory", lambda: sizes.BASE + 1e8)
    tracemalloc.start()
    with pytest.raises(InputError) as caught:
        a_case(base, {"geometry.spacing": spacing}).simulation(ALONE)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 1e7
    message = str(caught.value)
    assert message.startswith(key)
    assert all(word in message for word in ("nodes", "unknowns", "GB", "free", "at least"))
    offered = float(message.rpartition("at least ")[2])
    fits, finer = (sizes.estimate(a_case(base, {"geometry.spacing": h})) for h in (offered, 0.85 * offered))
    assert fits.bytes <= sizes.BASE + 1e8 < finer.bytes  # what is offered fits, and little finer does not


@pytest.mark.parametrize("base", [LINE, RECTANGLE, SLAB], ids=["line", "rectangle", "slab"])
def test_too_many_refinements_are_refused(monkeypatch, base):
    """Before anything is meshed, by the key, with how many fit; also of a mesh that says its size late."""
    monkeypatch.setattr(sizes, "free_memory", lambda: sizes.BASE + 5e8)
    case = a_case(base, {"potential.refinement": 25})
    message = r"^potential\.refinement: .*nodes.*GB.*at most \d+$"
    with pytest.raises(InputError, match=message) as caught:
        case.simulation(ALONE)
    most = int(str(caught.value).rpartition(" ")[2])
    fits, finer = (
        sizes.estimate(a_case(base, {"potential.refinement": levels})) for levels in (most, most + 1)
    )
    assert most >= 1
    assert fits.bytes <= sizes.BASE + 5e8 < finer.bytes
    monkeypatch.setattr(sizes, "_counts", lambda form: (0.0, 0.0))
    with pytest.raises(InputError, match=message):
        case.build(ALONE)


@pytest.mark.parametrize("levels", [0, 1])
def test_states_of_a_membrane_take_memory(levels):
    """Of many states the potential's mesh takes more, by what was measured."""
    few = a_case(LINE, {"potential.refinement": levels})
    many = dataclasses.replace(few, cell=namedtuple("Cell", "states")(tuple("abcdefghijklmnopqr")))
    sizes_of = [sizes.estimate(case) for case in (few, many)]
    assert sizes_of[1].bytes - sizes_of[0].bytes >= 17 * sizes.PER_STATE * sizes_of[0].nodes


@pytest.mark.parametrize("value", ["-1", "1.0", "true", '"one"', "1e3", "1000000000000"])
def test_no_number_of_refinements(tmp_path, value):
    """One message with the key, status 2."""
    file = write_case(tmp_path / "case.toml", LINE)
    done = command_line("run", file, "--out", tmp_path / "out", "--set", f"potential.refinement={value}")
    assert done.status == 2
    assert done.err.startswith("myostrain: potential.refinement: ")
    assert done.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_geometry_of_a_script_says_how_many_cells_it_has(monkeypatch):
    """By ``counts()``; one that does not is not checked."""
    monkeypatch.setattr(sizes, "free_memory", lambda: sizes.BASE + 1e8)
    case = a_case(SHEET, {})
    own = namedtuple("Own", "counts")(lambda: (1e9, 2e9))
    assert sizes.estimate(dataclasses.replace(case, geometry=own)).cells == 2e9
    assert sizes.estimate(dataclasses.replace(case, geometry=object())).cells == 0


def test_a_large_file_is_refused(tmp_path, monkeypatch):
    """A mesh file is counted by its size, and never opened."""
    monkeypatch.setattr(sizes, "free_memory", lambda: sizes.BASE + 1e8)
    with (tmp_path / "body.msh").open("wb") as stream:
        stream.truncate(10**10)
    with pytest.raises(InputError, match=r"^geometry\.path.*nodes.*GB"):
        a_case(SHEET, {"geometry": {"kind": "file", "path": str(tmp_path / "body.msh")}}).simulation(ALONE)


def test_too_many_frames_are_refused(tmp_path, monkeypatch):
    """Requirements, "Input": sizes are bounded, on the disk too; the interval offered fits."""
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(0, 0, 10_000))
    out = tmp_path / "not" / "yet"
    done = command_line("run", write_case(tmp_path / "case.toml", LINE), "--out", out)
    assert done.status == 2
    assert "output.every" in done.err
    assert "GB" in done.err
    assert not out.parent.exists()
    offered = float(done.err.partition("at least ")[2].partition(",")[0])
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(0, 0, 20_000))
    size = sizes.estimate(a_case(LINE, {"output.every": offered}))
    assert 5_000 < size.output_bytes <= 10_000


def test_a_folder_where_nothing_can_be_is_not_called_full(tmp_path):
    """/proc has no size: the message is about the folder, not about how many frames would fit."""
    done = command_line("run", write_case(tmp_path / "case.toml", LINE), "--out", "/proc/new")
    assert done.status == 2
    assert "--out: the folder /proc/new cannot be written" in done.err


def test_a_full_disk_is_called_one(tmp_path, monkeypatch):
    """Where not even two frames fit, no interval helps."""
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(0, 0, 100))
    done = command_line("run", write_case(tmp_path / "case.toml", LINE), "--out", tmp_path / "out")
    assert done.status == 2
    assert f"--out: the disk of {tmp_path / 'out'} is full: " in done.err
    assert "another disk" in done.err


@pytest.mark.parametrize(
    "changes, key",
    [
        ({"time.step": 1e-12}, "time.step"),
        ({"time.step": 1e-308}, "time.step"),
        ({"time.end": 1e40}, "time.step"),
        ({"time.end": 1e308}, "time.end"),
        ({"geometry.length": 1e308}, "geometry.length"),
        ({"geometry.length": 1e50}, "geometry.spacing"),
        ({"geometry.spacing": 1e-50}, "geometry.spacing"),
        ({"potential.diffusivity": [1e-308, 1.0]}, "potential.diffusivity"),
        ({"initial.radius": 1e200, "initial.sampling": "mean"}, "initial.radius"),
        ({"mechanics.every": 10**400}, "mechanics.every"),
    ],
)
def test_extreme_ratios_are_refused(changes, key):
    """No OverflowError, MemoryError or endless loop, but the key."""
    with pytest.raises(InputError) as caught:
        a_case(LINE, changes).simulation(ALONE)
    assert str(caught.value).startswith(key), str(caught.value)


def test_an_interval_longer_than_the_run():
    """Its ratio to the step may overflow; the first and the last frame are written."""
    simulation = a_case(LINE, {"output.every": 1e60, "time.step": 1e-6, "time.end": 2e-6}).simulation(ALONE)
    assert simulation.run()["steps"] == 2


@pytest.mark.parametrize(
    "files, free",
    [
        ({"/proc/meminfo": "MemFree: 1 kB\nMemAvailable:  2000 kB\n"}, 2_048_000.0),
        (
            {
                "/proc/meminfo": "MemAvailable: 2000 kB\n",
                "/proc/self/cgroup": "0::/user/me\n",
                "/sys/fs/cgroup/user/me/memory.max": "1000000\n",
                "/sys/fs/cgroup/user/me/memory.current": "600000\n",
                "/sys/fs/cgroup/user/me/memory.stat": "anon 5\ninactive_file 100000\n",
            },
            500_000.0,
        ),
        (
            {
                "/proc/meminfo": "MemAvailable: 2000 kB\n",
                "/proc/self/cgroup": "4:cpu:/x\n7:memory:/docker/abc\n",
                "/sys/fs/cgroup/memory/memory.limit_in_bytes": "1000000\n",
                "/sys/fs/cgroup/memory/memory.usage_in_bytes": "300000\n",
            },
            700_000.0,
        ),
        (
            {
                "/proc/meminfo": "MemAvailable: 2000 kB\n",
                "/proc/self/cgroup": "0::/\n",
                "/sys/fs/cgroup/memory.max": "max\n",
                "/sys/fs/cgroup/memory.current": "600000\n",
            },
            2_048_000.0,
        ),
        ({}, math.inf),
    ],
    ids=["machine", "group", "container of version 1", "no limit", "unknown"],
)
def test_free_memory(monkeypatch, files, free):
    """The smaller of what the machine and the group of processes have left; caches of files are free."""
    monkeypatch.setattr(resources, "_text", lambda path: files.get(str(path), ""))
    assert resources.free_memory() == free


def test_bytes_cover_a_small_run():
    """The constant part is at least what this process has taken by now, but not many times that."""
    Case.from_dict(LINE).simulation(ALONE).run()
    assert 5e7 < sizes.BASE < 4 * 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
