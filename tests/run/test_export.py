"""Exported files hold the frames: VTK's own readers give back every number, at every time."""

import xml.etree.ElementTree as ET
from pathlib import Path

import myostrain as ms

import h5py
import numpy as np
import pytest
import pyvista
import vtk

from small_cases import command_line
from snapshot_files import write_snapshots

#: A body of each dimension: two cells at most.
BODIES = {
    1: (np.array([[0.0], [1.0], [3.0]]), np.array([[0, 1], [1, 2]])),
    2: (np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]), np.array([[0, 1, 2], [1, 3, 2]])),
    3: (
        np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]),
        np.array([[0, 1, 2, 3], [1, 2, 3, 4]]),
    ),
}
TIMES = np.array([0.0, 0.5, 2.0])


@pytest.fixture(params=BODIES)
def folder(request, tmp_path):
    """Results with a potential, a displacement that bends the edges, and a fibre of each cell."""
    points, cells = BODIES[request.param]
    dim, n = points.shape[1], len(points)
    edges = len(np.unique(np.sort(np.array([c[[i, j]] for c in cells for i, j in pairs(dim)])), axis=0))
    rng = np.random.default_rng(1)
    write_snapshots(
        tmp_path,
        points,
        cells,
        TIMES,
        activation_time=np.arange(n) + 0.25,
        potential=rng.random((3, n)),
        displacement=0.1 * rng.random((3, n, dim)),
        **{"displacement.middles": 0.1 * rng.random((3, edges, dim))},
    )
    with np.load(tmp_path / "snapshots" / "mesh.npz") as mesh:
        np.savez(tmp_path / "snapshots" / "mesh.npz", **{**mesh, "fibres": rng.random((len(cells), dim))})
    return tmp_path


def pairs(dim):
    return list(zip(*np.triu_indices(dim + 1, 1), strict=True))


def nodes(run, frame, name):
    """What nodes have in a file: the frame's numbers, then those of the middles."""
    ends, _ = run._reader.snapshots.edges
    values = {"activation_time": run._reader.activation()}.get(name)
    values = frame[name] if values is None else values
    middles = values[ends].mean(axis=1)
    if name == "displacement":
        middles = run._reader.snapshots.middles(frame._number)
    whole = np.concatenate([values, middles])
    return whole if whole.ndim == 1 else np.pad(whole, ((0, 0), (0, 3 - whole.shape[1])))


def fibres(run):
    """The directions of the cells, with three components."""
    given = run.frames.fibres
    return np.pad(given, ((0, 0), (0, 3 - given.shape[1])))


def read(path):
    """Times and grids of a file, by VTK's own readers."""
    if path.suffix == ".pvd":
        reader = pyvista.get_reader(path)
        for number, time in enumerate(reader.time_values):
            reader.set_active_time_point(number)
            yield time, reader.read()[0]
        return
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    steps = vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS()
    for number, time in enumerate(reader.GetOutputInformation(0).Get(steps)):
        reader.SetStep(number)
        reader.Update()
        yield time, pyvista.wrap(reader.GetOutput()).copy()


@pytest.mark.parametrize("kind, opened", [("vtu", "fields.pvd"), ("vtkhdf", "fields.vtkhdf")])
def test_vtk_reads_all_of_it(folder, kind, opened):
    run = ms.open(folder, unfinished=True)
    path = run.export(kind)
    assert path == folder / "export" / opened
    for (time, grid), frame in zip(read(path), run.frames, strict=True):
        assert time == frame.time
        for name in ("potential", "displacement", "activation_time"):
            np.testing.assert_array_equal(grid.point_data[name], nodes(run, frame, name))
        np.testing.assert_array_equal(grid.cell_data["fibres"], fibres(run))
        exact = frame.grid(quadratic=True)
        np.testing.assert_array_equal(grid.cells, exact.cells)
        np.testing.assert_array_equal(grid.celltypes, exact.celltypes)
        np.testing.assert_allclose(grid.points, exact.points, atol=1e-7)


def test_xdmf_names_what_its_file_holds(folder):
    """Read as any reader of XDMF does: times, cells, points and fields by the paths in the description."""
    run = ms.open(folder, unfinished=True)
    path = run.export("xdmf", deformed=True)
    grids = ET.parse(path).getroot().findall("./Domain/Grid/Grid")
    assert [float(grid.find("Time").get("Value")) for grid in grids] == TIMES.tolist()
    for grid, frame in zip(grids, run.frames, strict=True):

        def data(item, where=path.parent):
            name, place = item.text.split(":")
            with h5py.File(where / name) as file:
                values = file[place][()]
            assert list(values.shape) == [int(size) for size in item.get("Dimensions").split()]
            return values

        exact = frame.grid(deformed=True, quadratic=True)
        np.testing.assert_array_equal(
            data(grid.find("Topology/DataItem")), exact.cells.reshape(len(run.frames.cells), -1)[:, 1:]
        )
        np.testing.assert_allclose(data(grid.find("Geometry/DataItem")), exact.points, atol=1e-7)
        fields = {each.get("Name"): each for each in grid.findall("Attribute")}
        np.testing.assert_array_equal(data(fields.pop("fibres").find("DataItem")), fibres(run))
        assert set(fields) == {"potential", "displacement", "activation_time"}
        for name, each in fields.items():
            np.testing.assert_array_equal(data(each.find("DataItem")), nodes(run, frame, name))


def test_chosen_and_straight(folder):
    """Some fields and times, straight cells, the deformed body over time, by the command."""
    done = command_line(
        *("export", folder, "--format", "vtkhdf", "--times", "0.4,2.1", "--fields", "potential"),
        *("--linear", "--deformed", "--out", folder / "here"),
    )
    assert done.status == 0, done.err
    run = ms.open(folder, unfinished=True)
    (first, _), (second, grid) = read(Path(done.out.strip()))
    assert (first, second) == (0.5, 2.0)
    assert grid.point_data.keys() == ["potential"]
    dim = run.frames.points.shape[1]
    np.testing.assert_allclose(grid.points[:, :dim], run.frames[2].deformed, atol=1e-7)
    for arguments, words in {
        ("--format", "vtk"): "no such format; ",
        ("--fields", "strain"): "no field 'strain' was written",
        ("--times", "soon"): "give numbers with commas",
        ("--times", "1000"): "--times: 1000 is not between the first and the last frame",
        ("--times", "nan"): "--times: nan is not between",
    }.items():
        done = command_line("export", folder, *arguments)
        assert done.status == 2
        assert words in done.err
