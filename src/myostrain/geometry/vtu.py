"""Meshes and directions of VTK files (.vtu, .vtk), as meshio, PyVista or ParaView write them."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path

from myostrain.errors import InputError, nearest
from myostrain.geometry.foreign import read_alone, readable
from myostrain.geometry.mesh_arrays import MeshArrays, named
from myostrain.geometry.xdmf_arrays import Simplices

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

ENDINGS = (".vtu", ".vtk")

#: Names under which tags of cells and triangles, fibres and sheets are looked for.
TAGS = ("tags", "tag", "gmsh:physical", "region", "regions", "elemTag", "cell_tags", "medit:ref", "material")
NAMES = {
    "f0": ("f0", "fiber", "fibre", "fibers", "fibres", "Fiber", "Fibers", "fiber_direction"),
    "s0": ("s0", "sheet", "sheets", "Sheet", "Sheets", "sheet_direction"),
}

#: Reads a file in a process of its own: nodes, tetrahedra, triangles, and all arrays on them.
READ = """
import io, sys
import numpy as np
try:
    import pyvista
except ImportError:
    sys.exit("PyVista")
grid = pyvista.read(sys.argv[1])
if not isinstance(grid, pyvista.UnstructuredGrid):
    sys.exit(f"it holds a {type(grid).__name__}, no UnstructuredGrid")
kinds = set(grid.celltypes.tolist()) - {1, 3, 5, 10}
if kinds:
    sys.exit(f"it has cells of the VTK types {sorted(kinds)}; straight tetrahedra (10) are needed")
none = np.zeros((0, 1), dtype=np.int64)
found = {"points": grid.points, "cells": grid.cells_dict.get(10, none), "sides": grid.cells_dict.get(5, none)}
for name in grid.cell_data.keys():
    found["c:" + name] = np.asarray(grid.cell_data[name])[grid.celltypes == 10]
    found["s:" + name] = np.asarray(grid.cell_data[name])[grid.celltypes == 5]
for name in grid.point_data.keys():
    found["p:" + name] = np.asarray(grid.point_data[name])
content = io.BytesIO()
np.savez(content, **{k: v for k, v in found.items() if v.dtype.kind in "fiu"})
sys.stdout.buffer.write(content.getvalue())
"""


def _contents(path: Path, key: str) -> dict[str, Array]:
    """All arrays of a file."""
    readable(path, key)
    status, content, words = read_alone(READ, str(path), path=path, key=key, reader="VTK")
    said = words.strip().rpartition("\n")[2]
    if said == "PyVista":
        raise InputError(f"{path} is read by PyVista, which is not there: install myostrain[render]", key)
    if status or not content:
        raise InputError(f"{path} cannot be read as a VTK file: {said or 'VTK gives nothing'}", key)
    with np.load(io.BytesIO(content), allow_pickle=False) as data:
        found = {name: data[name] for name in data.files}
    if not len(found["cells"]):
        raise InputError(f"{path} has no tetrahedra", key)
    return found


def read_vtu(
    path: Path,
    tags: str | None,
    boundaries: Mapping[str, int | str] | None,
    regions: Mapping[str, int] | None,
    scale: float,
) -> MeshArrays:
    """Nodes, tetrahedra, and triangles on their boundary, with tags.

    Args:
        path: The file.
        tags: Name of the array of whole numbers on the cells; the first known one unless given.
        boundaries: Names of boundaries and their tags.
        regions: Names of regions and their tags.
        scale: Factor on the coordinates.

    Raises:
        InputError: The file is missing or damaged, no mesh of tetrahedra, or has no such tags.
    """
    found = _contents(path, "geometry.path")
    there = [name[2:] for name in found if name.startswith("c:")]
    chosen = tags or next((name for name in TAGS if name in there), None)
    if chosen is not None and chosen not in there:
        raise InputError(f"no data on cells is called '{chosen}'; {nearest(chosen, there)}", "geometry.tags")
    if chosen is None and (boundaries or regions):
        raise InputError(
            f"{path} has no tags to name, only {', '.join(there) or 'no data on cells'}", "geometry.tags"
        )
    tagged: dict[str, Simplices] = {}
    names: dict[str, dict[str, int]] = {}
    if chosen is not None:
        wanted: dict[str, tuple[int, str, Mapping[str, int] | None]] = {
            "cell_tags": (3, "c", regions),
            "facet_tags": (2, "s", _whole(boundaries)),
        }
        for key, (dim, kind, given) in wanted.items():
            values = found[f"{kind}:{chosen}"]
            if values.ndim != 1 or (values != np.floor(values)).any():
                raise InputError(
                    f"'{chosen}' in {path} does not hold tags, which are whole numbers: name another array",
                    "geometry.tags",
                )
            nodes = found["cells" if dim == 3 else "sides"].astype(np.int64)
            if len(nodes):
                tagged[key] = Simplices(dim, nodes, values.astype(np.int64))
            if len(nodes) or given:
                names[key] = named(values.astype(np.int64), given, "regions" if dim == 3 else "boundaries")
    points = np.asarray(found["points"], dtype=float) * scale
    arrays = MeshArrays(3, points, found["cells"].astype(np.int64), tagged, names)
    arrays.check(path)
    return arrays


def read_directions(path: Path) -> tuple[Array, dict[str, Array]]:
    """Points (n, 3) and, by name, f0 and where there are any s0 (n, 3) at them: of cells or of nodes.

    Raises:
        InputError: The file is missing or damaged, or f0 and s0 are on different things.
    """
    found = _contents(path, "fibres.path")
    for kind in "cp":
        given = {
            name: next((found[f"{kind}:{word}"] for word in words if f"{kind}:{word}" in found), None)
            for name, words in NAMES.items()
        }
        if given["f0"] is not None:
            points = np.asarray(found["points"], dtype=float)
            places = points[found["cells"]].mean(axis=1) if kind == "c" else points
            used = np.unique(found["cells"]) if kind == "p" else np.arange(len(places))
            return places[used], {name: v[used].astype(float) for name, v in given.items() if v is not None}
    there = [name[2:] for name in found if name[1] == ":"]
    raise InputError(
        f"{path} has no fibres: name them f0 on cells or nodes; there is {', '.join(there) or 'nothing'}",
        "fibres.path",
    )


def _whole(boundaries: Mapping[str, int | str] | None) -> dict[str, int] | None:
    """Names and tags of boundaries."""
    for name, tag in (boundaries or {}).items():
        if not isinstance(tag, int):
            raise InputError(f"'{tag}' is not a tag: give a number", f"geometry.boundaries.{name}")
    return None if boundaries is None else {name: int(tag) for name, tag in boundaries.items()}


def is_vtk(path: Path) -> bool:
    """Whether a path is that of a VTK file."""
    return path.suffix.lower() in ENDINGS
