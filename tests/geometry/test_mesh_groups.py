"""Physical groups of gmsh files as other programs write them; messages that say what to do; flat bodies."""

import os

import myostrain as ms
from myostrain import InputError
from myostrain.engine import fem
from myostrain.geometry import MeshFile

import pytest

from mesh_files import SQUARE, TRIANGLES, msh
from small_cases import ALONE, SHEET, changed, other_process, write_case

gmsh = pytest.importorskip("gmsh", exc_type=ImportError)


def named(content, *names):
    """The content with names of physical groups, as '1 8 "side"'."""
    section = "\n".join(("$PhysicalNames", str(len(names)), *names, "$EndPhysicalNames\n"))
    return content.replace(b"$Nodes", section.encode() + b"$Nodes")


def body_of(path, content):
    path.write_bytes(content)
    return ms.build(MeshFile(path=path), ms.UniformFibres(direction=(1, 0)), ALONE)


def lengths(body):
    one = fem.Constant(body.mesh, 1.0)
    return {
        name: fem.assemble_scalar(fem.form(one * body.boundary_measure([name], 1)))
        for name in body.meshed.boundaries
    }


EDGES = ["1 2 8 1 1 2", "1 2 9 2 2 3", "1 2 10 3 3 4", "1 2 11 4 4 1"]


@pytest.mark.parametrize("order", [1, -1])
def test_groups_of_one_name_are_one_part(tmp_path, order):
    """MeshFile docstring: "Groups of one name are one part", whichever the file names first, and whatever
    region has that name, too."""
    names = ['1 8 "side"', '1 9 "other"', '1 10 "side"', '2 7 "side"', '1 11 "side"'][::order]
    body = body_of(tmp_path / "body.msh", named(msh(elements=[*TRIANGLES, *EDGES]), *names))
    assert lengths(body) == pytest.approx({"side": 3.0, "other": 1.0})
    assert list(body.meshed.regions) == ["side"]


def test_regions_of_one_name(tmp_path):
    """The same of regions, of which no cell is lost."""
    content = named(msh(elements=["2 2 7 1 1 2 3", "2 2 8 2 1 3 4"]), '2 7 "wall"', '2 8 "wall"')
    body = body_of(tmp_path / "body.msh", content)
    assert list(body.meshed.regions) == ["wall"]
    assert len(body.meshed.cell_tags.find(body.meshed.regions["wall"])) == 2


WRONG = {
    "a name that is another's number": (
        named(msh(elements=[*TRIANGLES, *EDGES[:2]]), '1 8 "9"'),
        ("number 9 without a name", "another called '9'"),
    ),
    "a name in another encoding": (
        named(msh(elements=[*TRIANGLES, *EDGES[:1]]), '1 8 "Rücken"').decode().encode("latin-1"),
        ("not UTF-8",),
    ),
    "a side in two groups": (
        msh(elements=[*TRIANGLES, "1 2 8 1 1 2", "1 2 9 2 2 1"]),
        ("1 boundary facets twice, with two tags: 8 and 9 at nodes 1, 2",),
    ),
    "elements without numbers of entities": (
        msh(elements=["2 2 7 0 1 2 3", "2 2 8 0 1 3 4"]),
        ("'7' and '8'", "meshio", "gmsh:geometrical"),
    ),
    "groups lost by SaveAll": (
        named(msh(elements=["2 2 0 1 1 2 3", "2 2 0 1 1 3 4"]), '2 7 "body"'),
        ("Mesh.SaveAll", "4.1"),
    ),
    "off the plane": (
        msh([*SQUARE[:3], "0 1 0.00001"]),
        ("not flat", "node 4 at [0.0, 1.0, 1e-05]", "1e-05 off the plane", "1e-06 is allowed"),
    ),
}


@pytest.mark.parametrize("content, words", WRONG.values(), ids=WRONG)
def test_wrong_groups(tmp_path, content, words):
    """A message says what is wrong and how the program that wrote the file avoids it."""
    with pytest.raises(InputError, match=r"^geometry\.path: ") as caught:
        body_of(tmp_path / "body.msh", content)
    assert all(word in str(caught.value) for word in words), str(caught.value)
    assert "\n" not in str(caught.value)


def test_surfaces_without_a_volume(tmp_path):
    """The usual slip: only surfaces are in physical groups, and gmsh saves no tetrahedra."""
    path = tmp_path / "body.msh"
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(2, [1], 1, "left")
        gmsh.model.mesh.generate(3)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    with pytest.raises(InputError, match=r'dimension 2 but none of dimension 3.*`Physical Volume\("body"\)'):
        ms.build(MeshFile(path=path), ms.UniformFibres(direction=(1, 0, 0)), ALONE)


@pytest.mark.parametrize("unit", [1.0, 1e-6])
@pytest.mark.parametrize("off", ["1e-17", "5e-7", "-5e-7"])
def test_flat_to_single_precision(tmp_path, off, unit):
    """checks.FLATNESS: 1e-6 of the extent, in any unit."""
    nodes = [" ".join(repr(unit * float(x)) for x in node.split()) for node in (*SQUARE[:3], f"0 1 {off}")]
    body = body_of(tmp_path / "body.msh", msh(nodes))
    assert body.dim == 2
    assert body.extent()[1] == pytest.approx([unit, unit])


@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_nothing_is_read_from_pipes(tmp_path, kind):
    """geometry.readable: a pipe or a device is refused, not waited for."""
    path = tmp_path / "body.msh"
    if kind == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/zero")
    with pytest.raises(InputError, match=r"it is a pipe, a socket or a device") as caught:
        ms.build(MeshFile(path=path), ms.UniformFibres(direction=(1, 0)), ALONE)
    assert str(path) in str(caught.value)


def test_a_name_in_no_encoding(tmp_path):
    """A folder may have any bytes in its name; a case, which is UTF-8, cannot name it, and says so."""
    folder = tmp_path / os.fsdecode(b"\xff\xe4")
    folder.mkdir()
    assert body_of(folder / "body.msh", msh()).cells == 2
    geometry = {"kind": "file", "path": "body.msh"}
    write_case(folder / "case.toml", changed(SHEET, {"geometry": geometry, "fibres": {"direction": [1, 0]}}))
    for cwd, file in ((folder, "case.toml"), (tmp_path, folder / "case.toml")):
        done = other_process("run", file, "--out", tmp_path / "out", cwd=cwd)
        assert done.status == 2, done.err
        assert "is not UTF-8" in done.err
        assert "\\udcff" in done.err
    assert not (tmp_path / "out").exists()
