"""Ventricles with fibres from files of openCARP, VTK and cardiac-geometriesx, written by the tests."""

import json

import myostrain as ms
from myostrain import Case, InputError
from myostrain.engine import MPI, compile_form, fem
from myostrain.geometry import FileFibres, MeshFile, UniformFibres, write_opencarp
from myostrain.geometry.meshed import Meshed

import numpy as np
import pytest
import ufl
from dolfinx import io
from dolfinx import mesh as dmesh

from small_cases import ALONE

PARTS = ("endocardium_left", "endocardium_right", "epicardium", "base")


@pytest.fixture(scope="module")
def heart():
    """Two ventricles with fibres and sheets, and two regions."""
    bare = ms.build(
        ms.geometry.Biventricle(spacing=14.0), UniformFibres(direction=(1.0, 0.0, 0.0)), ALONE
    ).meshed
    mesh = bare.mesh
    cells = np.arange(mesh.topology.index_map(3).size_local, dtype=np.int32)
    high = mesh.geometry.x[mesh.geometry.dofmaps[0]].mean(axis=1)[:, 2] > -10
    tags = dmesh.meshtags(mesh, 3, cells, np.where(high, 7, 2).astype(np.int32))
    meshed = Meshed(mesh, bare.facet_tags, bare.boundaries, tags, {"7": 7, "2": 2})
    return ms.geometry.Body(meshed, ms.geometry.RuleBasedFibres().directions_on(meshed))


def numbers(body, *, directions=True):
    """Volume, areas of the boundaries, volumes of the regions, and moments of fibres and sheets."""
    X, meshed = ufl.SpatialCoordinate(body.mesh), body.meshed
    dx = ufl.Measure(
        "dx", domain=body.mesh, subdomain_data=meshed.cell_tags, metadata={"quadrature_degree": 2}
    )
    one = fem.Constant(body.mesh, 1.0)
    forms = [X[2] * body.boundary_measure([name], 2) for name in PARTS]
    forms += [one * dx(tag) for tag in (7, 2)]
    if directions:
        middle = ufl.Measure("dx", domain=body.mesh, metadata={"quadrature_degree": 1})
        for d in (body.f0, body.fibres.s0):
            forms += [X[i] * d[i] * d[j] * middle for i in range(3) for j in range(3)]
    return np.array([body.comm.allreduce(fem.assemble_scalar(compile_form(form))) for form in forms])


@pytest.fixture(scope="module")
def expected(heart):
    return numbers(heart)


def arrays(body):
    """Nodes, cells, sides of each boundary, all by numbers of the nodes; regions and directions of cells."""
    mesh = body.mesh
    X, cells = mesh.geometry.x, mesh.geometry.dofmaps[0]
    sides = {name: dmesh.entities_to_geometry(mesh, 2, body.boundary_facets([name])) for name in PARTS}
    order = np.argsort(body.meshed.cell_tags.indices)
    found = [ms.geometry.opencarp.CellFields(mesh, d, 0).values() for d in (body.f0, body.fibres.s0)]
    return X, cells, sides, body.meshed.cell_tags.values[order], *found


def write_vtu(path, body, scale=1.0, **names):
    pyvista = pytest.importorskip("pyvista")
    X, cells, sides, regions, f0, s0 = arrays(body)
    triangles = np.concatenate(list(sides.values()))
    tags = np.repeat(np.arange(10, 10 + len(sides)), [len(side) for side in sides.values()])
    grid = pyvista.UnstructuredGrid({10: cells, 5: triangles}, X * scale)
    first = grid.celltypes == 10
    for name, of_cells, of_sides in (
        ("tags", regions, tags),
        (names.get("f0", "f0"), f0, np.zeros((len(tags), 3))),
        (names.get("s0", "s0"), s0, np.zeros((len(tags), 3))),
    ):
        values = np.zeros((len(first), *of_cells.shape[1:]), dtype=of_cells.dtype)
        values[first], values[~first] = of_cells, of_sides
        grid.cell_data[name] = values
    grid.save(path)
    return {name: 10 + number for number, name in enumerate(sides)}


def test_opencarp_there_and_back(heart, expected, tmp_path):
    """What is written for openCARP, in micrometres, is read again: nodes, regions, surfaces, directions."""
    write_opencarp(heart, tmp_path / "heart", scale=1e3)
    body = ms.build(
        MeshFile(path=tmp_path / "heart.pts", scale=1e-3),
        FileFibres(path=tmp_path / "heart.lon", scale=1e-3),
        ALONE,
    )
    assert set(body.meshed.boundaries) == set(PARTS)
    np.testing.assert_allclose(numbers(body), expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())
    lines = (tmp_path / "heart.elem").read_text().splitlines()
    assert int(lines[0]) == len(lines) - 1 == heart.cells
    assert lines[1].split()[0] == "Tt"
    assert {line.split()[5] for line in lines[1:]} == {"2", "7"}


def test_turned_tetrahedra_are_taken(heart, expected, tmp_path):
    """Elements whose nodes are the other way round are the same elements."""
    write_opencarp(heart, tmp_path / "heart")
    file = tmp_path / "heart.elem"
    first, *rows = (line.split() for line in file.read_text().splitlines())
    turned = [[row[0], row[2], row[1], *row[3:]] for row in rows]
    file.write_text("\n".join(" ".join(row) for row in [first, *turned]) + "\n")
    surfaces = {name: f"heart.{name}.surf" for name in PARTS}
    body = ms.build(MeshFile(path=file, boundaries=surfaces), FileFibres(path=tmp_path / "heart.lon"), ALONE)
    np.testing.assert_allclose(numbers(body), expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())


def test_a_vtu_file(heart, expected, tmp_path):
    """Tetrahedra and triangles with tags; fibres and sheets by names that others use."""
    tags = write_vtu(tmp_path / "heart.vtu", heart, 10.0, f0="fiber", s0="sheet")
    body = ms.build(
        MeshFile(path=tmp_path / "heart.vtu", scale=0.1, boundaries=tags, regions={"high": 7}),
        FileFibres(path=tmp_path / "heart.vtu", scale=0.1),
        ALONE,
    )
    assert body.meshed.regions == {"high": 7, "2": 2}
    np.testing.assert_allclose(numbers(body), expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())


def write_folder(folder, body):
    """A folder as cardiac-geometriesx writes it, with its names."""
    folder.mkdir()
    mesh = body.mesh
    mesh.name, body.meshed.facet_tags.name, body.meshed.cell_tags.name = "Mesh", "Facet tags", "Cell tags"
    with io.XDMFFile(MPI.COMM_SELF, folder / "mesh.xdmf", "w") as file:
        file.write_mesh(mesh)
        for tags in (body.meshed.cell_tags, body.meshed.facet_tags):
            mesh.topology.create_connectivity(tags.dim, 3)
            where = "/Xdmf/Domain/Grid[@Name='Mesh']/Geometry"
            file.write_meshtags(tags, mesh.geometry, geometry_xpath=where)
    theirs = dict(zip(PARTS, ("ENDO_LV", "ENDO_RV", "EPI", "BASE"), strict=True))
    markers = {theirs[name]: [tag, 2] for name, tag in body.meshed.boundaries.items()}
    (folder / "markers.json").write_text(json.dumps({**markers, "LV": [7, 3]}))


def test_a_folder_of_cardiac_geometriesx(heart, expected, tmp_path):
    """mesh.xdmf and markers.json: its names of boundaries become those that are known here."""
    write_folder(tmp_path / "lv", heart)
    body = ms.build(MeshFile(path=tmp_path / "lv"), UniformFibres(direction=(1.0, 0.0, 0.0)), ALONE)
    assert body.meshed.regions == {"LV": 7, "2": 2}
    found = numbers(body, directions=False)
    np.testing.assert_allclose(found, expected[: len(found)], rtol=1e-6)


DAMAGE = {
    "no nodes": ("pts", lambda text: None, "there is no file"),
    "short": ("pts", lambda text: text[: len(text) // 2], "its first line says|is damaged"),
    "no header": ("pts", lambda text: text.partition("\n")[2], "begins with"),
    "words": ("pts", lambda text: text.replace("0.", "O.", 5), "is damaged"),
    "too few elements": ("elem", lambda text: text.rpartition("Tt")[0], "its first line says"),
    "hexahedra": ("elem", lambda text: text.replace("Tt", "Hx"), "has elements 'Hx'"),
    "a node that is not": ("elem", lambda text: text.replace("Tt ", "Tt 9999", 1), "has a node that is not"),
    "binary": ("elem", lambda text: "\xff\xfe" + text, "is not a text file"),
    "too few directions": ("lon", lambda text: text[: text[:-1].rindex("\n")], "has .* rows of 6"),
    "one direction": ("lon", lambda text: "1" + text[1:], "need as many rows of 3"),
    "three directions": ("lon", lambda text: "3" + text[1:], "not with 1 or 2 directions"),
}  # fmt: skip


@pytest.mark.parametrize("ending, change, message", DAMAGE.values(), ids=DAMAGE.keys())
def test_damaged_files_of_opencarp(heart, tmp_path, ending, change, message):
    """One message that names the file."""
    write_opencarp(heart, tmp_path / "heart")
    file = tmp_path / f"heart.{ending}"
    content = change(file.read_text())
    if content is None:
        file.unlink()
    else:
        file.write_text(content, encoding="latin-1")
    with pytest.raises(InputError, match=rf"^(geometry|fibres)\.path: .*({message})") as said:
        ms.build(MeshFile(path=tmp_path / "heart.elem"), FileFibres(path=tmp_path / "heart.lon"), ALONE)
    assert f"heart.{ending}" in str(said.value)


def test_wrong_vtu_files(heart, tmp_path):
    """Files that are none, without fibres, with other tags, and keys for other formats."""
    file = tmp_path / "heart.vtu"
    file.write_text("<VTKFile>")
    with pytest.raises(InputError, match=r"^geometry\.path: .*heart\.vtu"):
        MeshFile(path=file).mesh(ALONE)
    write_vtu(file, heart, f0="u", s0="v")
    with pytest.raises(InputError, match=r"^fibres\.path: .*has no fibres: name them f0"):
        ms.build(MeshFile(path=file), FileFibres(path=file), ALONE)
    with pytest.raises(InputError, match=r"^geometry\.tags: no data on cells is called 'tag'"):
        MeshFile(path=file, tags="tag").mesh(ALONE)
    with pytest.raises(InputError, match=r"^geometry\.boundaries\.lid: nothing has the tag 3"):
        MeshFile(path=file, boundaries={"lid": 3}).mesh(ALONE)
    with pytest.raises(InputError, match=r"^geometry\.scale: this is not for heart\.msh"):
        MeshFile(path=tmp_path / "heart.msh", scale=2.0).mesh(ALONE)


def test_wrong_folders(heart, tmp_path):
    """Without markers, and with damaged ones."""
    folder = tmp_path / "lv"
    write_folder(folder, heart)
    (folder / "markers.json").write_text('{"EPI": 3}')
    with pytest.raises(InputError, match=r"^geometry\.path: .*markers\.json is damaged"):
        MeshFile(path=folder).mesh(ALONE)
    (folder / "markers.json").unlink()
    with pytest.raises(InputError, match=r"^geometry\.path: there is no file .*markers\.json"):
        MeshFile(path=folder).mesh(ALONE)


def test_a_case_with_an_own_anatomy(heart, tmp_path):
    """geometry.kind = "file" takes them, relative to the case; the resolved case reads back the same."""
    write_opencarp(heart, tmp_path / "heart")
    case = Case.from_dict(
        {
            "geometry": {"kind": "file", "path": "heart.pts", "boundaries": {"base": "heart.base.surf"}},
            "fibres": {"kind": "file", "path": "heart.lon"},
            "mechanics": {"kinematics": "rigid"},
            "stimulus": {"boundary": ["base"], "strength": 1.0, "duration": 1.0},
            "time": {"step": 0.1, "end": 0.2},
        },
        folder=tmp_path,
    )
    assert case.geometry.path == tmp_path / "heart.pts"
    assert [file.name for file in case.geometry.files] == ["heart.pts", "heart.elem", "heart.base.surf"]
    assert case.geometry.mesh(ALONE).boundaries == {"base": 1}
