"""XDMF files of other programs: what a good one gives, whoever wrote it; bad and damaged ones are refused."""

import os
import random
import shutil
import subprocess
import sys
from pathlib import Path

import myostrain as ms
from myostrain import InputError
from myostrain.engine import fem
from myostrain.geometry import XdmfFile

import numpy as np
import pytest
import ufl
from dolfinx import mesh as dmesh
from dolfinx.io import XDMFFile

from small_cases import ALONE

TIMES = int(os.environ.get("MYOSTRAIN_FUZZ", "1"))


@pytest.fixture(scope="module")
def block(tmp_path_factory):
    """A block of twelve tetrahedra, [0, 2] × [0, 1] × [0, 1], as DOLFINx writes it."""
    path = tmp_path_factory.mktemp("block") / "block.xdmf"
    mesh = dmesh.create_box(ALONE, [(0, 0, 0), (2, 1, 1)], [2, 1, 1], dmesh.CellType.tetrahedron)
    mesh.topology.create_connectivity(2, 3)
    ends = [dmesh.locate_entities_boundary(mesh, 2, lambda x, a=a: np.isclose(x[0], a)) for a in (0.0, 2.0)]
    facets = np.concatenate(ends)
    order = np.argsort(facets)
    sides = dmesh.meshtags(mesh, 2, facets[order], np.repeat(np.int32([1, 2]), 2)[order])
    middle = dmesh.compute_midpoints(mesh, 3, np.arange(12, dtype=np.int32))[:, 0]
    halves = dmesh.meshtags(
        mesh, 3, np.arange(12, dtype=np.int32), np.where(middle < 1, 4, 5).astype(np.int32)
    )
    sides.name, halves.name = "sides", "halves"
    with XDMFFile(ALONE, str(path), "w") as file:
        file.write_mesh(mesh)
        for tags in (sides, halves):
            file.write_meshtags(tags, mesh.geometry)
    return path


@pytest.fixture
def copy(block, tmp_path):
    """The block in a folder of its own, to be damaged."""
    for name in ("block.xdmf", "block.h5"):
        shutil.copy(block.parent / name, tmp_path)
    return tmp_path / "block.xdmf"


PLACES = {
    "topology": "Mesh/mesh/topology",
    "geometry": "Mesh/mesh/geometry",
    "sides": "MeshTags/sides/topology",
    "values": "MeshTags/sides/Values",
    "cells": "MeshTags/halves/topology",
}

CHANGE = """
import sys, h5py, numpy as np
name, place, statement, options = sys.argv[1:]
with h5py.File(name, "a") as file:
    names = {"a": file[place][()], "np": np}
    exec(statement, names)
    del file[place]
    file.create_dataset(place, data=names["a"], **eval(options))
"""


def change(path, array, statement, options="{}"):
    """Change an array ``a`` of the HDF5 file; elsewhere, since h5py and DOLFINx bring an HDF5 each."""
    arguments = [str(path.with_suffix(".h5")), PLACES[array], statement, options]
    subprocess.run([sys.executable, "-c", CHANGE, *arguments], check=True)


def made(path, **given):
    """Volume of the body, areas by name, and volumes of regions by name."""
    shape = XdmfFile(path=path, **{"facet_tags": "sides", "cell_tags": "halves", **given})
    body = ms.build(shape, ms.UniformFibres(direction=(1.0,) * 3), ALONE)
    meshed, one = body.meshed, fem.Constant(body.mesh, 1.0)

    def total(measure):
        return fem.assemble_scalar(fem.form(one * measure))

    areas = {name: total(body.boundary_measure([name], 1)) for name in meshed.boundaries}
    dx = ufl.Measure("dx", domain=body.mesh, subdomain_data=meshed.cell_tags)
    return total(dx), areas, {name: total(dx(tag)) for name, tag in meshed.regions.items()}


GOOD = (pytest.approx(2.0), pytest.approx({"1": 1.0, "2": 1.0}), pytest.approx({"4": 1.0, "5": 1.0}))


def refusal(path, **given):
    with pytest.raises(InputError, match=r"^geometry\.") as caught:
        made(path, **given)
    message = str(caught.value)
    assert str(path.parent) in message or "/dev/zero" in message
    assert "\n" not in message
    return message


def test_good(block):
    """What is damaged below is good before; a name is for one tag, and a tag may have two names."""
    assert made(block) == GOOD
    _, areas, _ = made(block, boundaries={"left": 1, "low": 1})
    assert areas == pytest.approx({"left": 1.0, "low": 1.0, "2": 1.0})


@pytest.mark.parametrize(
    "given, key, words",
    [
        ({"facet_tags": "halves"}, "geometry.facet_tags", "tags of tetrahedra"),
        ({"cell_tags": "sides"}, "geometry.cell_tags", "tags of triangles"),
        ({"boundaries": {"2": 1}}, "geometry.boundaries.2", "choose another name"),
    ],
)
def test_tags_of_something_else(block, given, key, words):
    """XdmfFile.mesh, Raises: "tags of another kind"; names that are numbers of others."""
    with pytest.raises(InputError) as caught:
        made(block, **given)
    assert key in str(caught.value)
    assert words in str(caught.value)


def test_compressed(copy):
    """Other programs compress their arrays (meshio, by default) and hold numbers in 32 bits."""
    for array, kind in (("topology", "int32"), ("geometry", "float32")):
        change(copy, array, f"a = a.astype('{kind}')", "{'compression': 'gzip', 'chunks': True}")
    assert made(copy) == GOOD


def test_written_by_hand(tmp_path):
    """Numbers in the XML itself; a sheet whose nodes have a third coordinate and one that no cell uses."""
    path = tmp_path / "sheet.xdmf"
    text = """<Xdmf><Domain><Grid Name="Grid">
    <Geometry GeometryType="XYZ"><DataItem Format="XML" Dimensions="5 3">
      9 9 3  0 0 3  1 0 3  1 1 3.0000002  0 1 3</DataItem></Geometry>
    <Topology TopologyType="Triangle" NumberOfElements="2">
      <DataItem Format="XML" NumberType="Int" Dimensions="2 3">1 2 3  1 3 4</DataItem></Topology>
    </Grid></Domain></Xdmf>"""
    path.write_text(text)
    body = ms.build(XdmfFile(path=path, grid="Grid"), ms.UniformFibres(direction=(1, 0)), ALONE)
    assert (body.dim, body.cells) == (2, 2)
    assert body.extent()[1].tolist() == [1.0, 1.0]
    path.write_text(text.replace("3.0000002", "3.1"))
    with pytest.raises(InputError, match=r"not flat: node 3 at \[1.0, 1.0, 3.1\] is 0.1 off the plane"):
        ms.build(XdmfFile(path=path, grid="Grid"), ms.UniformFibres(direction=(1, 0)), ALONE)


def test_a_line_of_dolfinx(tmp_path):
    """DOLFINx writes the nodes of a line with two coordinates, and tags of its ends."""
    mesh = dmesh.create_interval(ALONE, 3, (0.0, 6.0))
    ends = dmesh.meshtags(mesh, 0, np.int32([0, 3]), np.int32([1, 2]))
    ends.name = "ends"
    mesh.topology.create_connectivity(0, 1)
    with XDMFFile(ALONE, str(tmp_path / "line.xdmf"), "w") as file:
        file.write_mesh(mesh)
        file.write_meshtags(ends, mesh.geometry)
    body = ms.build(XdmfFile(path=tmp_path / "line.xdmf", facet_tags="ends"), None, ALONE)
    assert (body.dim, body.cells, sorted(body.meshed.boundaries)) == (1, 3, ["1", "2"])
    facets = body.boundary_facets(["2"])
    assert body.mesh.geometry.x[facets].max() == 6.0


@pytest.mark.parametrize(
    "array, statement, words",
    [
        ("topology", "a[3, 1] = -1", "node -1; there are nodes 0 to 11"),
        ("topology", "a[3, 1] = 12", "node 12; there are nodes 0 to 11"),
        ("topology", "a[3, 1] = 2**62", f"node {2**62}"),
        ("topology", "a = a + 0.5", "whole numbers"),
        ("topology", "a = a * np.nan", "whole numbers"),
        ("topology", "a = a.T", "has the shape (4, 12), not (12, 4)"),
        ("topology", "a = a[:-1]", "has the shape (11, 4), not (12, 4)"),
        ("geometry", "a[0, 0] = np.nan", "not finite"),
        ("geometry", "a = a * 1j", "type complex128"),
        ("geometry", "a = np.full(a.shape, b'x')", "real numbers"),
        ("sides", "a[0, 0] = 99", "node 99"),
        ("sides", "a[0] = [0, 1, 11]", "not sides of a cell"),
        ("sides", "a[:] = a[0]", "twice, with two tags"),
        ("cells", "a[0] = a[1]", "two tags for a cell"),
        ("cells", "a[0] = [0, 1, 2, 11]", "1 tetrahedra that are not cells"),
        ("values", "a = a + 0.5", "whole numbers"),
        ("values", "a = a.astype(np.int64) + 2**40", "32 bits"),
    ],
)
def test_wrong_numbers(copy, array, statement, words):
    """XdmfFile.mesh, Raises: numbers of nodes that are not there, shapes and types that are no mesh."""
    change(copy, array, statement)
    assert words in refusal(copy)


@pytest.mark.parametrize(
    "old, new, words",
    [
        ('Format="HDF"', 'Format="Binary"', "format BINARY; HDF and XML are read"),
        ('Dimensions="12 4"', 'Dimensions="99999999999 4"', "product is 2e+08 at most"),
        ('Dimensions="12 4"', 'Dimensions="-12 -4"', 'Dimensions "-12 -4"'),
        ('Dimensions="12 4"', "", 'Dimensions ""'),
        ('Name="halves" GridType', 'Name="mesh" GridType', "2 grids called 'mesh'"),
        ("block.h5:", "nothing.h5:", "there is no file"),
        ("block.h5:", "/dev/zero:", "a device"),
        ("block.h5:", "block.xdmf:", "not an HDF5 file"),
        ("/Mesh/mesh/topology", "/Mesh/mesh", "cannot be read"),
        ("/Mesh/mesh/topology", "", "cannot be read"),
        ('TopologyType="Tetrahedron"', 'TopologyType="Mixed"', "kind mixed"),
        ('TopologyType="Tetrahedron"', 'TopologyType="Triangle"', "triangles of 4 nodes"),
        ("DataItem", "Item", "has no Topology/DataItem"),
        ('<?xml version="1.0"?>', '<?xml version="1.0" encoding="nonsense"?>', "not an XDMF file"),
    ],
)
def test_wrong_text(copy, old, new, words):
    """XdmfFile.mesh, Raises: data that are elsewhere, in another format, or of another size."""
    text = copy.read_text()
    assert old in text
    copy.write_text(text.replace(old, new))
    assert words in refusal(copy, cell_tags=None)


@pytest.mark.parametrize("which", ["block.xdmf", "block.h5"])
def test_pipes(copy, which):
    """geometry.readable: nothing is read from a pipe, which would wait for ever."""
    (copy.parent / which).unlink()
    os.mkfifo(copy.parent / which)
    assert XdmfFile(path=copy).counts() == ((0.0, 0.0) if which == "block.xdmf" else (12, 12))
    assert f"{which}: it is a pipe" in refusal(copy)


def test_a_name_in_no_encoding(block, tmp_path):
    """A folder may have any bytes in its name."""
    folder = os.fsdecode(os.fsencode(tmp_path) + b"/\xff\xe4")
    shutil.copytree(block.parent, folder)
    assert made(Path(folder) / "block.xdmf") == GOOD


def test_a_reader_that_hangs_or_dies(copy, monkeypatch):
    """read_alone: a process that never ends, or is killed, is an error of the file."""
    from myostrain.geometry import foreign, xdmf_arrays

    monkeypatch.setattr(xdmf_arrays, "READ", "import os, signal; os.kill(os.getpid(), signal.SIGBUS)")
    assert "HDF5 dies of it (SIGBUS)" in refusal(copy)
    monkeypatch.setattr(xdmf_arrays, "READ", "import time; time.sleep(60)")
    monkeypatch.setattr(foreign, "PATIENCE", 0.2)
    assert "HDF5 never finishes reading it" in refusal(copy)


def mutated(content, chance):
    """A file with flipped bits, random bytes, bytes at another place, zeros, or its end cut off."""
    data, length = bytearray(content), len(content)
    what, place = chance.choice(["flip", "flip", "bytes", "swap", "zeros", "cut"]), chance.randrange(length)
    if what == "flip":
        for _ in range(chance.randint(1, 3)):
            data[chance.randrange(length)] ^= 1 << chance.randrange(8)
    elif what == "bytes":
        data[place : place + 8] = chance.randbytes(8)
    elif what == "swap":
        other = chance.randrange(length)
        data[place], data[other] = data[other], data[place]
    elif what == "zeros":
        data[place : place + 32] = bytes(32)
    else:
        del data[place:]
    return bytes(data)


#: DOLFINx's own reader never finishes with 28, 39, 51 and 54 of the first.
SEEDS = [("block.h5", [*range(8), 28, 39, 51, 54]), ("block.xdmf", range(32))]


@pytest.mark.parametrize("name, seeds", SEEDS, ids=["block.h5", "block.xdmf"])
def test_damaged(copy, name, seeds):
    """A damaged file is read as it is, or refused by name; nothing dies of it or waits for ever."""
    file = copy.parent / name
    good, outcomes = file.read_bytes(), []
    for seed in [*seeds, *range(100, 100 + len(seeds) * (TIMES - 1))]:
        file.write_bytes(mutated(good, random.Random(seed)))
        volume, regions, message = 0.0, {}, ""
        try:
            volume, _, regions = made(copy)
        except InputError as error:
            message = str(error)
        if message:
            assert str(copy.parent) in message, seed
            assert "\n" not in message, seed
            outcomes.append("refused")
        else:
            # Damage in the coordinates or tags themselves makes another good file.
            assert np.isfinite(volume), seed
            assert volume > 0, seed
            assert sum(regions.values()) == pytest.approx(volume), seed
            outcomes.append("read")
    assert {"refused", "read"} == set(outcomes)
