"""Folders of cardiac-geometriesx: mesh.xdmf with tags, and markers.json with their names."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from myostrain.errors import InputError
from myostrain.geometry.foreign import readable
from myostrain.geometry.mesh_arrays import MeshArrays
from myostrain.geometry.xdmf import XdmfFile
from myostrain.geometry.xdmf_arrays import grids, hdf5_files

import numpy as np

KEY = "geometry.path"

#: What its parts of the boundary are called here.
NAMES = {
    "ENDO": "endocardium",
    "EPI": "epicardium",
    "BASE": "base",
    "ENDO_LV": "endocardium_left",
    "LV_ENDO": "endocardium_left",
    "ENDO_RV": "endocardium_right",
    "RV_ENDO": "endocardium_right",
}


def files_of(folder: Path) -> tuple[Path, ...]:
    """What is read of a folder."""
    mesh = folder / "mesh.xdmf"
    return (mesh, *hdf5_files(mesh), folder / "markers.json")


def read_folder(folder: Path, scale: float) -> MeshArrays:
    """Nodes, tetrahedra, and the parts that markers.json names.

    ENDO, EPI, BASE, ENDO_LV and ENDO_RV are endocardium, epicardium, base, endocardium_left and
    endocardium_right; other names stay.

    Args:
        folder: The folder.
        scale: Factor on the coordinates.

    Raises:
        InputError: A file is missing or damaged, or they do not fit each other.
    """
    mesh, markers = folder / "mesh.xdmf", _markers(folder / "markers.json")
    known = grids(mesh)
    grid = next((name for name in ("Mesh", "mesh") if name in known), None)
    if grid is None:
        raise InputError(f"{mesh} has no grid called Mesh, only {', '.join(known) or 'nothing'}", KEY)
    tags = {name: name if name in known else None for name in ("Facet tags", "Cell tags")}
    file = XdmfFile(
        path=mesh,
        grid=grid,
        facet_tags=tags["Facet tags"],
        cell_tags=tags["Cell tags"],
        boundaries=None if tags["Facet tags"] is None else markers[2],
        regions=None if tags["Cell tags"] is None else markers[3],
    )
    found = file.arrays()
    return MeshArrays(found.dim, np.asarray(found.points * scale), found.cells, found.tagged, found.names)


def _markers(path: Path) -> dict[int, Mapping[str, int]]:
    """Tags by name, of triangles (2) and of tetrahedra (3)."""
    readable(path, KEY)
    try:
        given = json.loads(path.read_text(encoding="utf-8"))
        pairs = [(str(name), int(tag), int(dim)) for name, (tag, dim) in given.items()]
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise InputError(f"{path} is damaged: {error}; it has names with [tag, dimension]", KEY) from error
    found: dict[int, dict[str, int]] = {2: {}, 3: {}}
    for name, tag, dim in pairs:
        if dim in found:
            found[dim][NAMES.get(name, name)] = tag
    return dict(found)
