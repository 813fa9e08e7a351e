"""Meshes from gmsh files: what a good one gives, and what is said of a bad one."""

import os

import myostrain as ms
from myostrain import Case, InputError
from myostrain.engine import fem

import numpy as np
import pytest
import ufl

from mesh_files import SQUARE, TRIANGLES, msh, write_mesh
from small_cases import ALONE, SHEET, changed, command_line, other_process, write_case

try:
    import gmsh  # noqa: F401
except (ImportError, OSError) as missing:
    pytest.skip(f"gmsh cannot be loaded: {missing}", allow_module_level=True)


def a_case(path, **changes):
    """A sheet on a mesh file, fixed at its left end, fibres across it in its second half."""
    return changed(
        SHEET,
        {
            "geometry": {"kind": "file", "path": str(path)},
            "fibres": {"direction": [2.0, 0.0], "regions": {"second": [0.0, 3.0]}},
            "mechanics": {"kinematics": "plane-stress", "fixed": ["left"]},
            "initial": {"potential": 0.9, "center": [4.0, 3.0], "radius": 5.0},
            "probes": {"a": [5.0, 3.0], "b": [15.0, 3.0]},
            **changes,
        },
    )


@pytest.mark.parametrize("end, other", [("left", "right"), ("right", "left")])
def test_run_on_a_file(tmp_path, monkeypatch, end, other):
    """Requirements, "gmsh .msh file with tags": named ends hold the body, named regions turn the fibres.

    the interface: the path is relative to the case file's folder, wherever the command is called.
    """
    (tmp_path / "here").mkdir()
    write_mesh(tmp_path / "here" / "body.msh")
    file = write_case(tmp_path / "here" / "case.toml", a_case("body.msh", **{"mechanics.fixed": [end]}))
    monkeypatch.chdir(tmp_path)
    simulation = Case.from_file(file).simulation(ALONE)
    model, body = simulation.model, simulation.model.potential.body
    results = simulation.run()

    assert set(body.meshed.regions) == {"first", "second"}
    assert set(body.meshed.boundaries) == {"left", "right"}
    area = fem.assemble_scalar(fem.form(fem.Constant(body.mesh, 1.0) * ufl.dx(domain=body.mesh)))
    assert area == pytest.approx(120.0, rel=1e-12)
    centres = body.mesh.geometry.x[body.mesh.geometry.dofmaps[0]].mean(axis=1)
    across = centres[:, 0] > 10
    np.testing.assert_array_equal(body.f0.x.array.reshape(-1, 2), np.column_stack([~across, across]))
    x, u = body.mesh.geometry.x, model.mechanics.displacement().x.array.reshape(-1, 2)
    at = {"left": x[:, 0] == 0.0, "right": x[:, 0] == 20.0}
    assert np.abs(u[at[end]]).max() == 0.0
    assert np.abs(u[at[other]]).min() >= 0.0
    assert np.linalg.norm(u[at[other]], axis=1).min() > 1e-3
    assert results["metrics"]["displacement_max"] > 1e-3


def test_unknown_names_of_a_file_name_the_nearest(tmp_path):
    """errors.nearest, for the parts of a mesh that the case file names."""
    path = write_mesh(tmp_path / "body.msh")
    for changes, words in (
        ({"mechanics.fixed": ["lefft"]}, ("mechanics.fixed", "'left'")),
        ({"fibres.regions": {"secnd": [0, 1]}}, ("fibres.regions", "'second'")),
        ({"fibres.regions": {"second": [0, 0]}}, ("fibres.regions.second", "non-zero")),
    ):
        with pytest.raises(InputError) as caught:
            Case.from_dict(a_case(path, **changes)).build(ALONE)
        assert all(word in str(caught.value) for word in words)


def test_written_by_hand(tmp_path):
    """The files below are good but for one thing; a group without a name is called by its number."""
    (tmp_path / "body.msh").write_bytes(msh(elements=[*TRIANGLES, "1 2 8 1 1 2"]))
    body = ms.build(
        ms.geometry.MeshFile(path=tmp_path / "body.msh"), ms.UniformFibres(direction=(1, 1)), ALONE
    )
    assert body.cells == 2
    assert (dict(body.meshed.regions), dict(body.meshed.boundaries)) == ({"7": 7}, {"8": 8})
    assert len(body.boundary_facets(["8"])) == 1


BROKEN = {
    "missing": (None, ("no file",)),
    "empty": (b"", ("empty",)),
    "garbage": (bytes(range(256)) * 8, ("gmsh",)),
    "text": (b"hello\n", ("gmsh",)),
    "cut off": (msh()[:60], ("gmsh",)),
    "without cells": (msh(elements=[]), ("no cells",)),
    "without groups": (msh(elements=["2 2 0 1 1 2 3", "2 2 0 1 1 3 4"]), ("physical group", "Surface(")),
    "quadrilaterals": (msh(elements=["3 2 7 1 1 2 3 4"]), ("Quadrilateral", "triangles")),
    "second order": (
        msh([*SQUARE, "0.5 0 0", "1 0.5 0", "0.5 0.5 0"], ["9 2 7 1 1 2 3 5 6 7"]),
        ("Triangle 6", "straight"),
    ),
    "a cell of no size": (
        msh([*SQUARE, "2 0 0"], [*TRIANGLES, "2 2 7 1 1 2 5"]),
        ("no size", "near [1.0, 0.0]"),
    ),
    "not flat": (msh([*SQUARE[:3], "0 1 0.25"]), ("not flat",)),
    "not finite": (msh([*SQUARE[:3], "0 nan 0"]), ("not finite",)),
    "a node that is not there": (msh(elements=[*TRIANGLES, "2 2 7 1 1 2 9"]), ("gmsh", "9")),
    "a cell twice": (msh(elements=[*TRIANGLES, TRIANGLES[0]]), ("twice",)),
    "points only": (msh(elements=["15 2 7 1 1"]), ()),
}  # fmt: skip


@pytest.mark.parametrize("content, words", BROKEN.values(), ids=BROKEN)
def test_broken_file(tmp_path, content, words):
    """Requirements, "Bad input": a mesh without tags, an empty or unreadable file; the path is named."""
    path, out = tmp_path / "body.msh", tmp_path / "out"
    if content is not None:
        path.write_bytes(content)
    case = a_case(path, fibres={"direction": [1, 0]}, mechanics={"kinematics": "plane-stress"})
    done = command_line("run", write_case(tmp_path / "case.toml", case), "--out", out)
    assert done.status == 2, done.err
    assert "\n" not in done.err.strip()
    assert all(word in done.err for word in ("geometry.path", str(path), *words)), done.err
    assert not out.exists()


def test_boundary_off_the_body(tmp_path):
    """Requirements, "Bad input": named sides that no cell has. DOLFINx may abort: not in this process."""
    path = tmp_path / "body.msh"
    path.write_bytes(msh([*SQUARE, "3 0 0", "4 0 0"], [*TRIANGLES, "1 2 8 1 5 6"]))
    case = a_case(path, fibres={"direction": [1, 0]}, mechanics={"kinematics": "plane-stress"})
    done = other_process("run", write_case(tmp_path / "case.toml", case), cwd=tmp_path)
    assert done.status == 2, done.err
    assert "geometry.path" in done.err


def test_folder_in_place_of_a_file(tmp_path):
    """geometry.readable: a folder is no file."""
    with pytest.raises(InputError, match=r"geometry\.path.*no file"):
        ms.build(ms.geometry.MeshFile(path=tmp_path), ms.UniformFibres(direction=(1, 0)), ALONE)


@pytest.mark.parametrize(
    "twice, names", [({"outer": True}, ("left", "outer")), ({"body": True}, ("first", "body"))]
)
def test_part_in_two_groups_is_refused(tmp_path, twice, names):
    """A part has one tag in the mesh: a second group would be empty, and ``fixed`` of it hold nothing."""
    path = write_mesh(tmp_path / "body.msh", **twice)
    with pytest.raises(InputError) as caught:
        ms.build(ms.geometry.MeshFile(path=path), ms.UniformFibres(direction=(1, 0)), ALONE)
    assert all(name in str(caught.value) for name in ("geometry.path", str(path), *names))


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may read everything")
def test_file_without_permission(tmp_path):
    """Requirements, "an empty or unreadable file"."""
    path = write_mesh(tmp_path / "body.msh")
    path.chmod(0)
    with pytest.raises(InputError, match=r"geometry\.path.*cannot be read"):
        ms.build(ms.geometry.MeshFile(path=path), ms.UniformFibres(direction=(1, 0)), ALONE)


def test_line_from_a_file(tmp_path):
    """MeshFile docstring: "straight lines or triangles"; the ends are groups of points."""
    path = tmp_path / "line.msh"
    nodes = ["0 0 0", "1 0 0", "3 0 0"]
    path.write_bytes(msh(nodes, ["1 2 7 1 1 2", "1 2 7 1 2 3", "15 2 5 1 1"]))
    body = ms.build(ms.geometry.MeshFile(path=path), None, ALONE)
    assert (body.dim, body.cells) == (1, 2)
    assert len(body.boundary_facets(["5"])) == 1
