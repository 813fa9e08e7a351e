"""Fibres from files: nodes and cells, any order, any length scale; what is no fibre is refused."""

import itertools
import json
import shutil
import subprocess
import sys
from pathlib import Path

from myostrain import InputError
from myostrain.geometry import FileFibres, MeshFile, Rectangle, Slab

import numpy as np
import pytest

from mesh_files import msh
from small_cases import ALONE

gmsh = pytest.importorskip("gmsh", exc_type=ImportError)


def pattern(x):
    """Unit directions that turn with the last coordinate (n, dim), and others across them."""
    angle = x[:, -1]
    pad = np.zeros((len(x), x.shape[1] - 2))
    return (
        np.column_stack([np.cos(angle), np.sin(angle), pad]),
        np.column_stack([-np.sin(angle), np.cos(angle), pad]),
    )


def cells_of(mesh):
    """Nodes of the cells, as places in ``mesh.geometry.x``."""
    return mesh.geometry.dofmaps[0]


def directions(fibres, dim):
    """f0 of the cells (cells, dim) of one process."""
    return fibres.f0.x.array.reshape(-1, dim)


def axis(d):
    """The axis that directions (n, dim) are closest to, in the mean square."""
    return np.linalg.eigh(d.T @ d)[1][:, -1]


@pytest.mark.parametrize("unit", [1.0, 1e-5], ids=["", "micrometres in metres"])
@pytest.mark.parametrize("shape", [Rectangle, Slab])
def test_nodes_are_averaged_in_any_order(tmp_path, shape, unit):
    """FileFibres docstring: "A cell takes the mean of the points that lie in it or on its boundary"."""
    dim = 2 if shape is Rectangle else 3
    meshed = shape(size=tuple(unit * n for n in (3.0, 2.0, 2.0)[:dim]), spacing=0.5 * unit).mesh(ALONE)
    x, cells = meshed.mesh.geometry.x[:, :dim], cells_of(meshed.mesh)
    f0, _ = pattern(x / unit)
    flip = np.where(np.random.default_rng(0).random(len(x)) < 0.5, -3.0, 0.2)[:, None]
    expected = np.array([axis(f0[cell]) for cell in cells])
    orders = (np.arange(len(x)), np.argsort(x[:, -1]), np.argsort(-x[:, -1]))
    for order, scale in itertools.product(orders, (1.0, flip)):
        np.savez(tmp_path / "f.npz", points=x[order], f0=(scale * f0)[order])
        found = directions(FileFibres(path=tmp_path / "f.npz").directions_on(meshed), dim)
        along = np.abs((found * expected).sum(axis=1))
        np.testing.assert_allclose(along, 1.0, atol=1e-12)


def test_nodes_in_single_precision(tmp_path):
    """FileFibres: "within 1e-6 of the body's extent": each cell has all its nodes where cells are small."""
    meshed = Rectangle(size=(1.0, 1.0), spacing=1 / 96).mesh(ALONE)
    x = meshed.mesh.geometry.x[:, :2] + np.array([0.1, 0.7])
    meshed.mesh.geometry.x[:, :2] = x
    f0, _ = pattern(10 * x)
    np.savez(tmp_path / "f.npz", points=x.astype(np.float32), f0=f0)
    found = directions(FileFibres(path=tmp_path / "f.npz").directions_on(meshed), 2)
    expected = np.array([axis(f0[cell]) for cell in cells_of(meshed.mesh)])
    np.testing.assert_allclose(np.abs((found * expected).sum(axis=1)), 1.0, atol=1e-12)


def with_data(path, kind, names, rows):
    """A unit square of two triangles with data of three components."""
    text = msh().decode()
    for name in names:
        lines = "\n".join(f"{i} {row}" for i, row in enumerate(rows, 1))
        head = f'1\n"{name}"\n1\n0.0\n3\n0\n3\n{len(rows)}'
        text += f"${kind}\n{head}\n{lines}\n$End{kind}\n"
    path.write_text(text)
    return path


def test_nodes_of_a_msh(tmp_path):
    """FileFibres docstring: "``$ElementData`` or ``$NodeData``"."""
    path = with_data(tmp_path / "f.msh", "NodeData", ["f0"], ["1 0 0", "1 0 0", "1 1 0", "0 -2 0"])
    meshed = MeshFile(path=path).mesh(ALONE)
    found = directions(FileFibres(path=path).directions_on(meshed), 2)
    f0 = np.array([[1, 0], [1, 0], [0.5**0.5, 0.5**0.5], [0, -1.0]])
    x = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    for cell, direction in zip(cells_of(meshed.mesh), found, strict=True):
        nodes = [int(np.argmin(np.abs(x - p).sum(axis=1))) for p in meshed.mesh.geometry.x[cell][:, :2]]
        assert abs(direction @ axis(f0[nodes])) == pytest.approx(1.0, abs=1e-12)


def refusal(path, meshed):
    with pytest.raises(InputError, match=r"^fibres\.path: ") as caught:
        FileFibres(path=path).directions_on(meshed)
    message = str(caught.value)
    assert str(path) in message
    assert "\n" not in message
    return message


@pytest.mark.parametrize(
    "change, words",
    [
        ({"f0": np.ones((2, 2)) * (1 + 1j)}, "'f0' of type complex128"),
        ({"points": np.ones((2, 2), dtype=complex)}, "'points' of type complex128"),
        ({"f0": np.array([["a", "b"]] * 2)}, "'f0' of type <U1"),
        ({"f0": np.array([[True, False]] * 2)}, "'f0' of type bool"),
        ({"f0": np.array([[1, None]] * 2, dtype=object)}, "an array holds objects"),
        ({"f0": np.array([[1.0, np.nan]] * 2)}, "zero or not finite"),
        ({"f0": np.array([[1.0, np.inf]] * 2)}, "zero or not finite"),
        (
            {"points": np.array([[0.3, 0.1], [np.nan, 0.5]])},
            "1 points that are not finite",
        ),
        ({"points": np.array([[0.7, 0.3]] * 2), "f0": np.eye(2)}, "no direction in 1 cells of the body"),
        (
            {"points": np.array([[0.7, 0.3], [0.7, 0.3], [0.3, 0.7]]), "f0": np.eye(2)[[0, 1, 0]]},
            "directions 'f0' without a mean in 1 cells",
        ),
    ],
)
def test_arrays_that_are_no_directions(tmp_path, change, words):
    """FileFibres, Raises: complex numbers, texts and objects; no numbers; cells without an answer."""
    (tmp_path / "body.msh").write_bytes(msh())
    meshed = MeshFile(path=tmp_path / "body.msh").mesh(ALONE)
    good = {"points": np.array([[0.7, 0.3], [0.3, 0.7]]), "f0": np.array([[1.0, 1.0], [1.0, 0.0]])}
    np.savez(tmp_path / "f.npz", **good)
    FileFibres(path=tmp_path / "f.npz").directions_on(meshed)
    np.savez(tmp_path / "f.npz", **{**good, **change})
    assert words in refusal(tmp_path / "f.npz", meshed)


def test_directions_of_any_length(tmp_path):
    """FileFibres docstring: "Directions may have any length"."""
    (tmp_path / "body.msh").write_bytes(msh())
    meshed = MeshFile(path=tmp_path / "body.msh").mesh(ALONE)
    points = np.array([[0.7, 0.3], [0.3, 0.7]])
    np.savez(tmp_path / "f.npz", points=points, f0=np.array([[3e200, 4e200], [3e-200, 4e-200]]))
    found = directions(FileFibres(path=tmp_path / "f.npz").directions_on(meshed), 2)
    np.testing.assert_allclose(found, [[0.6, 0.8]] * 2, rtol=1e-15)


def test_other_formats(tmp_path):
    """FileFibres docstring: "Four formats": others are refused by naming these, not by a word on pickle."""
    meshed = Rectangle(size=(1.0, 1.0), spacing=1.0).mesh(ALONE)
    (tmp_path / "f.dat").write_text("1\n1 0 0\n0 1 0\n")
    message = refusal(tmp_path / "f.dat", meshed)
    assert all(word in message for word in (".msh", ".npz", ".lon of openCARP", ".vtu", "'points'"))
    np.save(tmp_path / "f.npy", np.eye(2))
    assert ".npz" in refusal(tmp_path / "f.npy", meshed)
    shutil.copy(tmp_path / "f.npy", tmp_path / "f.npz")
    assert "not an archive" in refusal(tmp_path / "f.npz", meshed)


@pytest.mark.parametrize("kind", ["ElementData", "NodeData"])
def test_damaged_msh(tmp_path, kind):
    """A damaged .msh is refused by its own name, in one line, whatever is wrong with the data in it."""
    path = with_data(tmp_path / "f.msh", kind, ["f0"], ["1 0 0"] * (2 if kind == "ElementData" else 4))
    meshed = MeshFile(path=path).mesh(ALONE)
    FileFibres(path=path).directions_on(meshed)
    good = path.read_text()
    head, data = good.split(f"${kind}\n")
    for number, bad in enumerate(
        (
            data.replace("1 1 0 0", "1 np.float64(1.0) 0 0"),
            data.replace("1 1 0 0", "9 1 0 0"),
            data.replace("1 1 0 0", "-1 1 0 0"),
            data.replace("1 1 0 0", "18446744073709551615 1 0 0"),
            data.replace("1 1 0 0", "1 nan 0 0"),
            data.replace("\n3\n0\n3\n", "\n3\n0\n9\n"),
            data.replace("\n3\n0\n3\n", "\n3\n0\n-3\n"),
            data.replace("\n3\n0\n3\n", "\n3\n7\n3\n"),
            data[: len(data) // 2],
        )
    ):
        assert bad != data, number
        path.write_text(f"{head}${kind}\n{bad}")
        assert "/tmp/tmp" not in refusal(path, meshed)


DRIVER = """
import json, sys
import numpy as np
import myostrain as ms
from myostrain.engine import MPI, fem
import ufl
comm = MPI.COMM_WORLD
body = ms.build(ms.geometry.Slab(size=(3.0, 2.0, 2.0), spacing=0.5), ms.geometry.FileFibres(path=sys.argv[1]))
x, f = ufl.SpatialCoordinate(body.mesh), body.f0
dx = ufl.Measure("dx", domain=body.mesh, metadata={"quadrature_degree": 2})
pairs = [(i, j) for i in range(3) for j in range(i + 1)]
forms = [fem.form(f[i] * f[j] * (1 + x[2]) * dx) for i, j in pairs]
moments = [comm.allreduce(fem.assemble_scalar(form)) for form in forms]
if comm.rank == 0:
    print(json.dumps(moments))
"""


@pytest.mark.mpi
def test_nodes_on_two_processes(tmp_path):
    """FileFibres docstring: "numbering, order and partition do not matter"."""
    mpiexec = shutil.which("mpiexec", path=str(Path(sys.executable).parent)) or shutil.which("mpiexec")
    if mpiexec is None:
        pytest.skip("there is no mpiexec beside this Python or on the path")
    x = Slab(size=(3.0, 2.0, 2.0), spacing=0.5).mesh(ALONE).mesh.geometry.x
    np.savez(tmp_path / "f.npz", points=x, f0=pattern(x)[0])
    found = [
        json.loads(
            subprocess.run(
                [mpiexec, "-n", str(n), sys.executable, "-c", DRIVER, str(tmp_path / "f.npz")],
                capture_output=True,
                text=True,
                timeout=200,
                check=True,
            ).stdout
        )
        for n in (1, 2)
    ]
    np.testing.assert_allclose(found[1], found[0], atol=1e-11)
