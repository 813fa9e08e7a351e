"""The arrays that an XDMF file names, in the XML or in an HDF5 file beside it."""

from __future__ import annotations

import io
import json
import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from myostrain.errors import InputError, nearest
from myostrain.geometry.body import MAX_CELLS
from myostrain.geometry.foreign import read_alone, readable

import numpy as np
import numpy.typing as npt

KEY = "geometry.path"
Indices = npt.NDArray[np.int64]

#: What XDMF calls simplices of straight sides, by their dimension.
SIMPLICES = {"polyvertex": 0, "polyline": 1, "triangle": 2, "tetrahedron": 3}
SHAPES = ("points", "lines", "triangles", "tetrahedra")


@dataclass(frozen=True)
class Simplices:
    """Simplices of a file.

    Args:
        dim: Their dimension.
        nodes: Numbers of their corners (n, dim + 1).
        values: A number for each (n,), or none of a mesh.
    """

    dim: int
    nodes: Indices
    values: Indices


def grids(path: Path) -> dict[str, list[ET.Element]]:
    """The grids of a file by name.

    Raises:
        InputError: The file is not an XDMF file.
    """
    readable(path, KEY)
    try:
        root = ET.parse(path).getroot()
    except (ET.ParseError, OSError, ValueError, LookupError) as error:
        raise InputError(f"{path} is not an XDMF file: {error}", KEY) from error
    if root.tag != "Xdmf":
        raise InputError(f"{path} is not an XDMF file: it begins with <{root.tag[:30]}>", KEY)
    found: dict[str, list[ET.Element]] = {}
    for grid in root.iterfind("Domain/Grid"):
        found.setdefault(grid.get("Name", ""), []).append(grid)
    return found


def read(
    path: Path, grid: str, tags: Mapping[str, str]
) -> tuple[npt.NDArray[np.float64], Simplices, dict[str, Simplices]]:
    """Read a mesh and tags; HDF5 by a process of its own, which a damaged file may kill.

    Args:
        path: The ``.xdmf`` file.
        grid: Name of the grid of the mesh.
        tags: Names of grids with tags, by the key of a case file that names them.

    Returns:
        Coordinates of the nodes (n, 1 to 3), cells, and what is tagged by key. All numbers of nodes are among
        the nodes.

    Raises:
        InputError: The message says what is missing, damaged, or not supported.
    """
    known = grids(path)
    chosen = {key: _grid(path, known, name, key) for key, name in {"grid": grid, **tags}.items()}
    items: dict[tuple[str, str], ET.Element] = {}
    for key, element in chosen.items():
        items[key, "nodes"] = _one(path, element, "Topology/DataItem")
        if key == "grid" or element.find("Geometry") is not None:
            items[key, "points"] = _one(path, element, "Geometry/DataItem")
        if key != "grid":
            items[key, "values"] = _one(path, element, "Attribute[1]/DataItem")
    arrays = _arrays(path, items)
    points = _real(path, arrays["grid", "points"])
    blocks = {}
    for key, element in chosen.items():
        about = f"geometry.{key}"
        own = arrays.get((key, "points"), points)
        if not np.array_equal(_real(path, own), points, equal_nan=True):
            raise InputError(f"{path} has nodes for these tags that are not the mesh's", about)
        dim = _dim(path, element)
        nodes, values = (
            _whole(path, arrays.get((key, what), np.zeros(0, dtype=np.int64))) for what in ("nodes", "values")
        )
        if nodes.ndim == 1:
            nodes = nodes[:, None]
        if nodes.shape[1] != dim + 1:
            raise InputError(f"{path} has {SHAPES[dim]} of {nodes.shape[1]} nodes", KEY)
        wrong = (nodes < 0) | (nodes >= len(points))
        if wrong.any():
            raise InputError(
                f"{path} has a cell with node {nodes[wrong][0]}; there are nodes 0 to {len(points) - 1}", KEY
            )
        values = values.reshape(-1)
        if key != "grid" and len(values) != len(nodes):
            raise InputError(f"{path} has {len(values)} tags for {len(nodes)} {SHAPES[dim]}", about)
        if (np.abs(values) > np.iinfo(np.int32).max).any():
            worst = values[np.abs(values).argmax()]
            raise InputError(f"{path} has the tag {worst}; 32 bits are allowed", about)
        blocks[key] = Simplices(dim, nodes, values)
    return points, blocks.pop("grid"), blocks


def _grid(path: Path, known: Mapping[str, list[ET.Element]], name: str, key: str) -> ET.Element:
    """The one grid of a name."""
    if name not in known:
        raise InputError(f"{path} has no grid called '{name}'; {nearest(name, known)}", f"geometry.{key}")
    if len(known[name]) > 1:
        raise InputError(
            f"{path} has {len(known[name])} grids called '{name}'; name them apart", f"geometry.{key}"
        )
    return known[name][0]


def _one(path: Path, grid: ET.Element, what: str) -> ET.Element:
    """The one element of a grid at a path."""
    found = grid.findall(what)
    if len(found) != 1:
        raise InputError(
            f"the grid '{grid.get('Name')}' in {path} has {len(found) or 'no'} {what}, and one is needed: "
            "write it as a plain grid, not as a series in time",
            KEY,
        )
    return found[0]


def _dim(path: Path, grid: ET.Element) -> int:
    """Dimension of a grid's simplices."""
    topology = grid.find("Topology")
    assert topology is not None  # it has a DataItem
    kind = topology.get("TopologyType") or topology.get("Type") or "nothing"
    if kind.lower() not in SIMPLICES:
        raise InputError(
            f"{path} has cells of kind {kind.lower()[:30]}; use straight lines, triangles or tetrahedra", KEY
        )
    return SIMPLICES[kind.lower()]


def hdf5_files(path: Path) -> list[Path]:
    """The HDF5 files that the grids of an XDMF file are in, each once, in their order.

    Raises:
        InputError: It is not an XDMF file.
    """
    elements = [element for named in grids(path).values() for element in named]
    items = [item for element in elements for item in element.iter("DataItem")]
    texts = [(item.text or "").strip() for item in items if item.get("Format", "XML").upper() == "HDF"]
    return [path.parent / name for name in dict.fromkeys(text.rpartition(":")[0] for text in texts)]


def _arrays(
    path: Path, items: Mapping[tuple[str, str], ET.Element]
) -> dict[tuple[str, str], npt.NDArray[Any]]:
    """The arrays of data items; those in HDF5 files are read together."""
    arrays, wanted = {}, {}
    for key, item in items.items():
        shape, text = _shape(path, item), (item.text or "").strip()
        kind = item.get("Format", "XML").upper()
        if kind == "HDF":
            name, _, place = text.rpartition(":")
            data = path.parent / name
            readable(data, KEY)
            with data.open("rb") as stream:
                if not stream.read(8).startswith(b"\x89HDF"):
                    raise InputError(f"{data} is not an HDF5 file", KEY)
            wanted[key] = (data, place, shape)
        elif kind == "XML":
            try:
                arrays[key] = np.array(text.split(), dtype=float).reshape(shape)
            except ValueError as error:
                raise InputError(f"{path} has a DataItem that cannot be read: {error}", KEY) from error
        else:
            raise InputError(f"{path} has data of format {kind[:30]}; HDF and XML are read", KEY)
    return arrays | _from_hdf5(wanted)


def _shape(path: Path, item: ET.Element) -> tuple[int, ...]:
    """The shape that a data item declares: one or two sizes, and no more numbers than a mesh may have."""
    text = item.get("Dimensions", "")
    try:
        shape = tuple(int(size) for size in text.split())
    except ValueError:
        shape = ()
    if not 1 <= len(shape) <= 2 or min(shape) < 0 or math.prod(shape) > 4 * MAX_CELLS:
        raise InputError(
            f'{path} has a DataItem of Dimensions "{text[:40]}"; one or two numbers are needed, whose '
            f"product is {4 * MAX_CELLS:.1g} at most",
            KEY,
        )
    return shape


#: Reads arrays of HDF5 files in a process of its own, and writes them in the format .npy one after the other.
READ = """
import io, json, sys
def squeezed(shape):
    return [int(n) for n in shape if n != 1]
try:
    import h5py, numpy
    for name, place, shape in json.load(sys.stdin):
        with h5py.File(name, "r", locking=False) as file:
            data = file[place]
            if squeezed(data.shape) != squeezed(shape):
                sys.exit(f"{place} has the shape {data.shape}, not {tuple(shape)} as the XDMF file says")
            buffer = io.BytesIO()
            numpy.save(buffer, data[()].reshape(shape), allow_pickle=False)
        sys.stdout.buffer.write(buffer.getbuffer())
except Exception as error:
    sys.exit(str(error.args[0] if error.args else type(error).__name__))
"""


def _from_hdf5(
    wanted: Mapping[tuple[str, str], tuple[Path, str, tuple[int, ...]]],
) -> dict[tuple[str, str], npt.NDArray[Any]]:
    """Arrays of HDF5 files, each from a file, at a place in it, and of a shape."""
    if not wanted:
        return {}
    largest = max((data for data, _, _ in wanted.values()), key=lambda data: data.stat().st_size)
    given = json.dumps([(str(data), place, shape) for data, place, shape in wanted.values()])
    try:
        status, out, words = read_alone(READ, given=given.encode(), path=largest, key=KEY, reader="HDF5")
    except OSError as error:
        raise InputError(
            f"{largest} cannot be read: no process can be started ({error.strerror})", KEY
        ) from error
    if status:
        words = " ".join(words.split())
        raise InputError(f"{largest} cannot be read: {words[-300:] or 'HDF5 gives no reason'}", KEY)
    stream = io.BytesIO(out)
    return {key: np.load(stream, allow_pickle=False) for key in wanted}


def _real(path: Path, values: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """Coordinates as real numbers, in rows."""
    if values.dtype.kind not in "fiu":
        raise InputError(f"{path} has coordinates of type {values.dtype}; real numbers are needed", KEY)
    points = values.astype(float)
    points = points[:, None] if points.ndim == 1 else points
    if points.shape[1] > 3:
        raise InputError(f"{path} has nodes of {points.shape[1]} coordinates; one to three are needed", KEY)
    return points


def _whole(path: Path, values: npt.NDArray[Any]) -> Indices:
    """Values as whole numbers."""
    whole = values.dtype.kind in "iu" or (values.dtype.kind == "f" and (np.abs(values) < 2**53).all())
    if not whole or (values.astype(np.int64) != values).any():
        raise InputError(f"{path} has numbers of nodes or tags that are not whole numbers of 64 bits", KEY)
    return values.astype(np.int64)
