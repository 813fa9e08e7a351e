"""What is refused of a mesh file: that it is seen, and where."""

from pathlib import Path

import myostrain as ms
from myostrain import Case, InputError
from myostrain.geometry.checks import components

import numpy as np
import pytest

from mesh_files import SQUARE, TRIANGLES, msh, write_mesh
from small_cases import ALONE, LINE, SHEET, changed, other_process, write_case

try:
    import gmsh
except (ImportError, OSError) as missing:
    pytest.skip(f"gmsh cannot be loaded: {missing}", allow_module_level=True)

SHEETS = {
    "inverted": (
        msh([*SQUARE, "2 0 0"], [*TRIANGLES, "2 2 7 1 2 3 5"]),
        ("1 inverted cells among 3", "[1.333333, 0.3333333]", "ReverseMesh Surface"),
    ),
    "a stray node": (
        msh([*SQUARE, "9 8 0"], [*TRIANGLES, "15 2 0 9 5"]),
        ("1 nodes that no cell of the body uses", "node 5 at [9.0, 8.0, 0.0]", "Coherence Mesh"),
    ),
    "two parts": (
        msh([*SQUARE, "5 5 0", "6 5 0", "6 6 0"], [*TRIANGLES, "2 2 7 1 5 6 7"]),
        ("2 parts", "of 1 cells near [5.666667, 5.333333]", "of 2 cells"),
    ),
    "a cell in no group": (msh(elements=[TRIANGLES[0], "2 2 0 2 1 3 4"]), ("1 cells", "no physical group")),
    "not finite": (msh([*SQUARE[:3], "0 nan 0"]), ("not finite", "node 4")),
    "not flat": (msh([*SQUARE[:3], "0 1 0.25"]), ("not flat", "node 4 at [0.0, 1.0, 0.25]")),
    "a cell twice": (msh(elements=[*TRIANGLES, TRIANGLES[0]]), ("twice", "near [0.6666667, 0.3333333]")),
    "no size": (
        msh([*SQUARE, "0.5 1e-15 0"], [*TRIANGLES, "2 2 7 1 1 5 2"]),
        ("no size", "near [0.5, 3.333333e-16]"),
    ),
    "a side of nothing": (msh(elements=[*TRIANGLES, "1 2 8 1 2 4"]), ("not sides of a cell", "nodes 2, 4")),
}  # fmt: skip

LINES = {
    "inverted": (
        msh(["0 0 0", "1 0 0", "3 0 0"], ["1 2 7 1 1 2", "1 2 7 1 3 2"]),
        ("1 inverted cells among 2", "near [", "ReverseMesh Curve"),
    ),
    "two parts": (
        msh(["0 0 0", "1 0 0", "3 0 0", "4 0 0", "5 0 0"], ["1 2 7 1 1 2", "1 2 7 1 3 4", "1 2 7 1 4 5"]),
        ("2 parts", "of 1 cells near [0.5]", "of 2 cells"),
    ),
    "a stray node": (
        msh(["0 0 0", "1 0 0", "7 0 0"], ["1 2 7 1 1 2", "15 2 0 9 3"]),
        ("node 3 at [7.0, 0.0, 0.0]",),
    ),
}


@pytest.mark.parametrize(
    "content, words", [*SHEETS.values(), *LINES.values()], ids=[*SHEETS, *(f"line, {name}" for name in LINES)]
)
def test_a_wrong_mesh_is_refused_with_a_place(tmp_path, content, words):
    """Requirements, "Input": inverted or zero-volume cells, unreferenced nodes, parts: named, located."""
    path = tmp_path / "body.msh"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        ms.build(ms.geometry.MeshFile(path=path), ms.UniformFibres(direction=(1, 0)), ALONE)
    assert all(word in str(caught.value) for word in ("geometry.path", str(path), *words)), str(caught.value)


@pytest.mark.parametrize("order", [1, -1])
def test_one_orientation_is_good_whichever_it_is(tmp_path, order):
    """Only a mesh of both is inverted somewhere."""
    cells = [" ".join([*c.split()[:4], *c.split()[4:][::order]]) for c in TRIANGLES]
    (tmp_path / "body.msh").write_bytes(msh(elements=cells))
    body = ms.build(
        ms.geometry.MeshFile(path=tmp_path / "body.msh"), ms.UniformFibres(direction=(1, 0)), ALONE
    )
    assert body.cells == 2


@pytest.mark.parametrize("seed", range(5))
def test_components(seed):
    """Against the definition: chains and rings of shuffled nodes, of known numbers."""
    rng = np.random.default_rng(seed)
    lengths = rng.integers(2, 400, size=20)
    ends = np.cumsum(lengths)
    chain = np.column_stack([np.arange(ends[-1] - 1), np.arange(1, ends[-1])])
    chain = chain[~np.isin(chain[:, 1], ends)]
    shuffle = rng.permutation(ends[-1])
    part = components(rng.permutation(shuffle[chain]), ends[-1])[shuffle]
    first = [part[end - length : end] for end, length in zip(ends, lengths, strict=True)]
    assert all(np.unique(labels).size == 1 for labels in first)
    assert np.unique(part).size == 20


@pytest.mark.parametrize("name", ["body.msh", "body.py", "body"])
def test_a_mesh_file_is_data(tmp_path, name):
    """Requirements, "Input": no code is evaluated. gmsh would run a script, and the options beside a file."""
    ran = tmp_path / "ran"
    script = f'SystemCall "touch {ran}";\n'
    case = changed(
        SHEET, {"geometry": {"kind": "file", "path": name}, "mechanics": {"kinematics": "plane-stress"}}
    )
    file = write_case(tmp_path / "case.toml", changed(case, {"time.end": 1e-3, "probes": {}}))
    (tmp_path / name).write_text(script)
    done = other_process("run", file, "--out", "out", cwd=tmp_path)
    assert done.status == 2, done.err
    assert "$MeshFormat" in done.err
    (tmp_path / name).write_bytes(msh())
    (tmp_path / f"{name}.opt").write_text(script)
    with pytest.raises(InputError, match="initial"):  # the mesh is read; the wave begins elsewhere
        Case.from_file(file).build(ALONE)
    assert not ran.exists()


@pytest.mark.parametrize(
    "direction, key",
    [
        ({"direction": [float("nan"), 1.0]}, "fibres.direction"),
        ({"direction": [0.0, 0.0]}, "fibres.direction"),
        ({"direction": [1.0]}, "fibres.direction"),
        ({"direction": [1.0, 0.0], "regions": {"7": [0.0, float("inf")]}}, "fibres.regions.7"),
        ({}, "fibres.direction"),
    ],
)
def test_fibres_that_are_none(tmp_path, direction, key):
    """Requirements, "Input": fibres missing, or NaN. Their length is free: the direction is normalized."""
    (tmp_path / "body.msh").write_bytes(msh())
    geometry = {"kind": "file", "path": str(tmp_path / "body.msh")}
    case = changed(SHEET, {"geometry": geometry, "fibres": direction})
    with pytest.raises(InputError) as caught:
        Case.from_dict(case).build(ALONE)
    assert str(caught.value).startswith(key)


@pytest.mark.parametrize("base, kinematics", [(LINE, "plane-stress"), (SHEET, "line")])
def test_wrong_dimension(base, kinematics):
    """Requirements, "Input": the mesh's dimension is not that of the kinematics."""
    case = changed(base, {"mechanics.kinematics": kinematics, "material": {"model": "NeoHookean"}})
    with pytest.raises(InputError, match=r"^mechanics\.kinematics.*dimension"):
        Case.from_dict(case).build(ALONE)


@pytest.mark.parametrize("version", [b"2.2 0 8", b"4 0 8"])
def test_this_process_reads_what_another_has_written(version, tmp_path, monkeypatch):
    """A file of another version than it says makes gmsh write outside of its memory, and go on."""
    path = write_mesh(tmp_path / "body.msh", step=4.0, version=2.2)
    path.write_bytes(path.read_bytes().replace(b"2.2 0 8", version, 1))
    seen = []

    def opened(name, really=gmsh.open):
        seen.append(Path(name).read_bytes())
        really(name)

    monkeypatch.setattr(gmsh, "open", opened)
    if version == b"4 0 8":
        with pytest.raises(InputError, match=r"body\.msh"):
            ms.geometry.MeshFile(path=path).mesh(ALONE)
    else:
        ms.geometry.MeshFile(path=path).mesh(ALONE)
        assert seen
    assert path.read_bytes() not in seen
