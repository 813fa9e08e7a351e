"""Meshes of openCARP: .pts, .elem and .lon beside each other, surfaces as .surf; read and written."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from myostrain.engine import lasting
from myostrain.errors import InputError
from myostrain.geometry.cell_fields import CellFields
from myostrain.geometry.foreign import readable
from myostrain.geometry.mesh_arrays import MeshArrays
from myostrain.geometry.xdmf_arrays import Indices, Simplices

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from myostrain.geometry.body import Body

Array = npt.NDArray[np.float64]

KEY = "geometry.path"

#: Endings of the files that belong together.
ENDINGS = (".pts", ".elem", ".lon")


def files_of(path: Path, boundaries: Mapping[str, int | str] | None) -> tuple[Path, ...]:
    """What is read of a mesh: nodes, elements and surfaces."""
    return (*(path.with_suffix(e) for e in ENDINGS[:2]), *_surfaces(path, boundaries).values())


def read_opencarp(path: Path, boundaries: Mapping[str, int | str] | None, scale: float) -> MeshArrays:
    """Nodes, tetrahedra with their tags, and surfaces.

    Args:
        path: One of the three files.
        boundaries: Names of the surfaces and their files, relative to the folder of the mesh; unless given,
            NAME is in STEM.NAME.surf.
        scale: Factor on the coordinates.

    Raises:
        InputError: A file is missing or damaged, or they do not fit each other.
    """
    points = _table(path.with_suffix(".pts"), 3, float)
    cells, tags = _elements(path.with_suffix(".elem"), "Tt", 4, len(points))
    sides, values, names = [], [], {}
    for number, (name, file) in enumerate(_surfaces(path, boundaries).items(), start=1):
        found, _ = _elements(file, "Tr", 3, len(points))
        sides.append(found)
        values.append(np.full(len(found), number))
        names[name] = number
    tagged = {"cell_tags": Simplices(3, cells, tags)}
    known = {"cell_tags": {str(tag): tag for tag in np.unique(tags).tolist() if tag >= 0}}
    if sides:
        tagged["facet_tags"] = Simplices(2, np.concatenate(sides), np.concatenate(values))
        known["facet_tags"] = names
    found_arrays = MeshArrays(3, points * scale, cells, tagged, known)
    found_arrays.check(path.with_suffix(".elem"))
    return found_arrays


def read_directions(path: Path) -> tuple[Array, dict[str, Array]]:
    """Centres of the elements (n, 3) and, by name, f0 and where there are any s0 (n, 3).

    Args:
        path: One of the three files.

    Raises:
        InputError: A file is missing or damaged, or they do not fit each other.
    """
    key = "fibres.path"
    points = _table(path.with_suffix(".pts"), 3, float, key)
    cells, _ = _elements(path.with_suffix(".elem"), "Tt", 4, len(points), key)
    file = path.with_suffix(".lon")
    readable(file, key)
    header, _, body = _text(file, key).partition("\n")
    if len(header.split()) > 1:  # of earlier versions: no number of directions in the first line
        header, body = "1", f"{header}\n{body}"
    if header.strip() not in ("1", "2"):
        raise InputError(f"{file} begins with '{header.strip()[:30]}', not with 1 or 2 directions", key)
    rows = _numbers(file, body, float, key)
    if rows.shape != (len(cells), 3 * int(header)):
        raise InputError(
            f"{file} has {rows.shape[0]} rows of {rows.shape[1]} numbers; the {len(cells)} elements of "
            f"{path.with_suffix('.elem').name} need as many rows of {3 * int(header)}",
            key,
        )
    given = {"f0": rows[:, :3], **({"s0": rows[:, 3:]} if rows.shape[1] == 6 else {})}
    return points[cells].mean(axis=1), given


def write_opencarp(body: Body, path: str | Path, scale: float = 1.0) -> None:
    """Write a body for openCARP: .pts, .elem with regions as tags, .lon, and STEM.NAME.surf (collective).

    Args:
        body: A solid; where its sheets are known, they are written too.
        path: Where to, with or without an ending.
        scale: Factor on the coordinates; openCARP counts in micrometres.

    Raises:
        InputError: The body is not a solid.
    """
    if body.dim != 3:
        raise InputError("a mesh of openCARP is written of a solid", KEY)
    mesh, comm, stem = body.mesh, lasting(body.comm), Path(path)
    stem = stem.with_suffix("") if stem.suffix in ENDINGS else stem
    owned = mesh.topology.index_map(3).size_local
    numbers = np.asarray(mesh.geometry.input_global_indices, dtype=np.int64)
    cells = numbers[mesh.geometry.dofmaps[0][:owned, :4]]
    tags = np.zeros(owned, dtype=np.int64)
    if (known := body.meshed.cell_tags) is not None:
        mine = known.indices < owned
        tags[known.indices[mine]] = known.values[mine]
    directions = [CellFields(mesh, d, 0).values() for d in (body.fibres.f0, body.fibres.s0) if d is not None]
    mesh.topology.create_connectivity(2, 3)
    mesh.topology.create_connectivity(3, 2)
    surfaces = {name: cells_of(body, name, numbers) for name in body.meshed.boundaries}
    rows = (
        np.asarray(mesh.topology.original_cell_index)[:owned],
        cells,
        tags,
        np.column_stack(directions),
        numbers,
        mesh.geometry.x,
        surfaces,
    )
    parts = comm.gather(rows, root=0)
    if parts is None:
        return
    order, cells, tags, along, numbers, X = (np.concatenate(c) for c in list(zip(*parts, strict=True))[:6])
    known, place = np.unique(numbers, return_index=True)
    first = place[np.isin(known, cells)]  # of curved cells the corners only
    renumbered = np.searchsorted(numbers[first], cells)
    by_file = np.argsort(order)
    _write(stem.with_suffix(".pts"), len(first), X[first] * scale, "%.15g")
    elements = np.column_stack([renumbered, tags])[by_file]
    _write(stem.with_suffix(".elem"), len(cells), elements, "Tt %d %d %d %d %d")
    _write(stem.with_suffix(".lon"), along.shape[1] // 3, along[by_file], "%.15g")
    for name in surfaces:
        sides = np.concatenate([part[6][name] for part in parts])
        sides = np.searchsorted(numbers[first], sides)
        file = stem.with_name(f"{stem.name}.{name}.surf")
        _write(file, len(sides), sides[np.lexsort(np.sort(sides, axis=1).T)], "Tr %d %d %d")


def cells_of(body: Body, name: str, numbers: Indices) -> Indices:
    """Triangles (n, 3) of a part of the boundary that this process owns, by numbers of the file."""
    topology = body.mesh.topology
    facets = body.boundary_facets([name])
    facets = facets[facets < topology.index_map(2).size_local]
    cells, of_cell = topology.connectivity(2, 3), topology.connectivity(3, 2).array.reshape(-1, 4)
    first = cells.array[cells.offsets[facets]]
    # The facet that is opposite to a corner has that corner's number.
    kept = of_cell[first] != facets[:, None]
    return numbers[body.mesh.geometry.dofmaps[0][first, :4][kept].reshape(-1, 3)]


def _write(path: Path, header: int, rows: Any, form: str) -> None:
    np.savetxt(path, rows, fmt=form, header=str(header), comments="")


def _surfaces(path: Path, boundaries: Mapping[str, int | str] | None) -> dict[str, Path]:
    """Files of surfaces by name."""
    if boundaries is None:
        stem = path.with_suffix("").name
        found = sorted(path.parent.glob(f"{stem}.*.surf")) if path.parent.is_dir() else []
        return {file.name[len(stem) + 1 : -len(".surf")]: file for file in found}
    for name, file in boundaries.items():
        if not isinstance(file, str):
            raise InputError(
                f'{file}: give the file of the surface, such as "heart.epi.surf"',
                f"geometry.boundaries.{name}",
            )
    return {name: path.parent / str(file) for name, file in boundaries.items()}


def _text(path: Path, key: str) -> str:
    readable(path, key)
    try:
        return path.read_text(encoding="ascii")
    except (OSError, ValueError) as error:
        raise InputError(f"{path} is not a text file: {error}", key) from error


def _numbers(path: Path, body: str, kind: type, key: str) -> Any:
    if not body.strip():
        raise InputError(f"{path} has no rows", key)
    try:
        return np.loadtxt(io.StringIO(body), ndmin=2, dtype=kind)
    except (ValueError, OverflowError) as error:
        raise InputError(f"{path} is damaged: {' '.join(str(error).split())}", key) from error


def _counted(path: Path, key: str) -> tuple[int, str]:
    """The number in the first line, and what follows."""
    header, _, body = _text(path, key).partition("\n")
    if not header.strip().isdecimal():
        raise InputError(f"{path} begins with '{header.strip()[:30]}', not with the number of its rows", key)
    return int(header), body


def _table(path: Path, columns: int, kind: type, key: str = KEY) -> Any:
    """Rows that the first line counts."""
    count, body = _counted(path, key)
    rows = _numbers(path, body, kind, key)
    if rows.shape != (count, columns):
        raise InputError(
            f"{path} has {rows.shape[0]} rows of {rows.shape[1]} numbers; its first line says {count}, and "
            f"{columns} numbers a row are needed",
            key,
        )
    return rows


def _elements(path: Path, kind: str, corners: int, nodes: int, key: str = KEY) -> tuple[Indices, Indices]:
    """Corners (n, corners) and tags (n,) of elements of one kind."""
    count, body = _counted(path, key)
    words = body.split(maxsplit=1)
    if words and words[0] != kind:
        raise InputError(f"{path} has elements '{words[0][:10]}'; tetrahedra (Tt) and triangles (Tr) go", key)
    rows = _numbers(path, body.replace(kind, " "), np.int64, key)
    if len(rows) != count or rows.shape[1] not in (corners, corners + 1):
        raise InputError(
            f"{path} has {rows.shape[0]} elements of {rows.shape[1]} numbers; its first line says {count}, "
            f"and {corners} nodes and a tag are needed",
            key,
        )
    found = rows[:, :corners]
    if ((found < 0) | (found >= nodes)).any():
        wrong = int(np.argmax(((found < 0) | (found >= nodes)).any(axis=1)))
        raise InputError(
            f"{path}: element {wrong} has a node that is not there, {found[wrong].tolist()}", key
        )
    return found, rows[:, corners] if rows.shape[1] > corners else np.zeros(count, dtype=np.int64)
