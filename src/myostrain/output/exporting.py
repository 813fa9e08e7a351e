"""The frames of a run as files for ParaView, PyVista and meshio."""

from __future__ import annotations

import base64
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, get_args
from xml.sax.saxutils import quoteattr

from myostrain.errors import InputError, nearest
from myostrain.output.folder import check_path, part_of, write_atomically, writing
from myostrain.output.frames import Frame, Frames
from myostrain.output.manifest import claim, make_folder
from myostrain.output.reader import Reader

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

Format = Literal["vtkhdf", "vtu", "xdmf"]

#: Names of cells in XDMF by VTK's numbers.
XDMF_CELLS = {3: "Polyline", 5: "Triangle", 10: "Tetrahedron", 21: "Edge_3", 22: "Tri_6", 24: "Tet_10"}


@dataclass(frozen=True)
class Series:
    """Frames to be written: cells and what does not change once, points and fields a frame.

    Args:
        frames: The frames.
        deformed: Whether points are x; they are X otherwise.
        quadratic: Whether cells have nodes in the middles of their edges.
        names: Fields that are written; all if empty.
        maps: What there is of each node at the end of the run, by name.
        fibres: Directions in the cells; None for none.
    """

    frames: Sequence[Frame]
    deformed: bool
    quadratic: bool
    names: Sequence[str]
    maps: Mapping[str, Array]
    fibres: Array | None

    @cached_property
    def times(self) -> Array:
        """Times of the frames."""
        return np.array([frame.time for frame in self.frames])

    @cached_property
    def first(self) -> tuple[int, Array, Array, dict[str, Array]]:
        """VTK's number of the cells, the cells, points and fields of the first frame."""
        return self.at(0)

    def at(self, number: int) -> tuple[int, Array, Array, dict[str, Array]]:
        """The same of any frame."""
        kind, cells, points, fields = self.frames[number].arrays(
            deformed=self.deformed, quadratic=self.quadratic, further=self.maps
        )
        kept = {name: fields[name] for name in fields if not self.names or name in self.names}
        return kind, cells, points, kept

    def all(self) -> Iterator[tuple[Array, dict[str, Array]]]:
        """Points and fields, frame by frame."""
        for number in range(len(self.frames)):
            yield self.at(number)[2:]


def export(
    folder: str | Path,
    format: Format = "vtkhdf",  # noqa: A002
    out: str | Path | None = None,
    *,
    fields: Sequence[str] = (),
    times: Sequence[float] = (),
    deformed: bool = False,
    linear: bool = False,
) -> Path:
    """Write the frames of a run for ParaView, PyVista or meshio; no solver is needed.

    Fields are at the points, activation times and other maps of the run's end among them; fibres are in the
    cells. Where the displacement is quadratic, so are the cells; other fields are linear in them.

    Args:
        folder: The result folder of a run.
        format: "vtkhdf" (one file), "vtu" (one per frame, and ``fields.pvd``), "xdmf" (with an HDF5 file).
        out: Where to write; ``folder/export`` unless given. Files of earlier calls are replaced.
        fields: Which fields to write; all unless given.
        times: The frames nearest to these times; all unless given.
        deformed: Whether the mesh is the deformed one; in the undeformed one, warp by ``displacement``.
        linear: Whether cells have no nodes in the middles of their edges.

    Returns:
        The file to open.

    Raises:
        InputError: There are no frames, a field or a format is not known, or nothing can be written.
    """
    if format not in get_args(Format):
        raise InputError(f"no such format; {nearest(str(format), get_args(Format))}", "--format")
    check_path(Path(folder), "DIR")
    reader = Reader(Path(folder))
    series = _series(reader, fields, times, deformed, linear)
    out = reader.folder / "export" if out is None else Path(out)
    check_path(out, "--out")
    write: Callable[[Series, Path], Path] = {"vtkhdf": _vtkhdf, "vtu": _vtu, "xdmf": _xdmf}[format]
    with writing(out):
        if out.parent == reader.folder:
            make_folder(out)
        out.mkdir(parents=True, exist_ok=True)
        return write(series, out)


def _series(
    reader: Reader, fields: Sequence[str], times: Sequence[float], deformed: bool, linear: bool
) -> Series:
    frames = Frames(reader)
    if not len(frames):
        raise InputError(f"{reader.folder} holds no frame yet")
    maps = {
        name: values[0] if values.ndim > 1 else values
        for name, values in reader.maps.items()
        if name != "activation_times" and len(values)
    }
    maps = {name: values for name, values in maps.items() if name not in frames.names}
    known = {*frames.names, *maps}
    for name in fields:
        if name not in known:
            raise InputError(f"no field '{name}' was written; {nearest(name, known)}", "--fields")
    chosen = sorted({reader.frame_at(time, "--times") for time in times}) or range(len(frames))
    quadratic = not linear and reader.snapshots.middles(0) is not None
    return Series(
        [frames[number] for number in chosen], deformed, quadratic, tuple(fields), maps, reader.fibres
    )


def _claimed(path: Path) -> Path:
    claim(path)
    return path


# VTU: one file per frame.


def _vtu(series: Series, out: Path) -> Path:
    """``fields.pvd``, and ``fields-0000.vtu``, ..."""
    kind, cells, _, _ = series.first
    rows = []
    for number, (time, (points, fields)) in enumerate(zip(series.times, series.all(), strict=True)):
        name = f"fields-{number:04d}.vtu"
        write_atomically(_claimed(out / name), _vtu_file(kind, cells, points, fields, series.fibres, time))
        rows.append(f'    <DataSet timestep="{float(time)!r}" part="0" file={quoteattr(name)}/>')
    collection = [
        '<?xml version="1.0"?>',
        '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">',
        *("  <Collection>", *rows, "  </Collection>", "</VTKFile>", ""),
    ]
    path = out / "fields.pvd"
    write_atomically(_claimed(path), "\n".join(collection))
    return path


def _vtu_file(
    kind: int, cells: Array, points: Array, fields: Mapping[str, Array], fibres: Array | None, time: float
) -> str:
    count = len(cells)
    offsets = np.arange(1, count + 1) * cells.shape[1]
    parts = [
        '<?xml version="1.0"?>',
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        "<UnstructuredGrid>",
        f"<FieldData>{_array('TimeValue', np.array([time]), 'NumberOfTuples')}</FieldData>",
        f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{count}">',
        f"<Points>{_array('Points', points)}</Points>",
        f"<Cells>{_array('connectivity', cells.reshape(-1))}{_array('offsets', offsets)}",
        f"{_array('types', np.full(count, kind, dtype=np.uint8))}</Cells>",
        f"<PointData>{''.join(_array(name, values) for name, values in fields.items())}</PointData>",
        f"<CellData>{'' if fibres is None else _array('fibres', _three(fibres))}</CellData>",
        "</Piece></UnstructuredGrid></VTKFile>\n",
    ]
    return "\n".join(parts)


def _array(name: str, values: Array, tuples: str = "") -> str:
    """An array in an XML file of VTK: its length in bytes and its bytes, in letters."""
    kinds = {"f": ("Float64", "<f8"), "i": ("Int64", "<i8"), "u": ("UInt8", "u1")}
    kind, dtype = kinds[values.dtype.kind]
    data = np.ascontiguousarray(values, dtype=dtype).tobytes()
    letters = base64.b64encode(np.uint64(len(data)).tobytes() + data).decode()
    width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""
    count = f' {tuples}="{len(values)}"' if tuples else ""
    about = f'type="{kind}" Name={quoteattr(name)}{width}{count} format="binary"'
    return f"<DataArray {about}>{letters}</DataArray>\n"


# XDMF: an HDF5 file, and a description of it.


def _xdmf(series: Series, out: Path) -> Path:
    """``fields.xdmf`` and ``fields.h5``."""
    import h5py

    kind, cells = series.first[:2]
    data, path = out / "fields.h5", out / "fields.xdmf"
    claim(data)
    grids = []
    with h5py.File(part_of(data), "w") as file:

        def item(name: str, values: Array) -> str:
            if name not in file:
                file.create_dataset(name, data=values)
            whole = values.dtype.kind == "i"
            return (
                f'<DataItem Format="HDF" NumberType="{"Int" if whole else "Float"}" Precision="8" '
                f'Dimensions="{" ".join(map(str, values.shape))}">fields.h5:/{name}</DataItem>'
            )

        for number, (time, (moved, fields)) in enumerate(zip(series.times, series.all(), strict=True)):
            place = f"points-{number}" if series.deformed else "points"
            attributes = [
                _attribute(
                    name, item(f"{name}-{number}" if name not in series.maps else name, values), values
                )
                for name, values in fields.items()
            ]
            if series.fibres is not None:
                directions = _three(series.fibres)
                attributes.append(_attribute("fibres", item("fibres", directions), directions, "Cell"))
            about = f'TopologyType="{XDMF_CELLS[kind]}" NumberOfElements="{len(cells)}"'
            grids += [
                f'<Grid Name="fields-{number}"><Time Value="{float(time)!r}"/>',
                f'<Topology {about} NodesPerElement="{cells.shape[1]}">{item("cells", cells)}</Topology>',
                f'<Geometry GeometryType="XYZ">{item(place, moved)}</Geometry>',
                *(*attributes, "</Grid>"),
            ]
    part_of(data).replace(data)
    head = '<?xml version="1.0"?>\n<Xdmf Version="3.0"><Domain>'
    temporal = '<Grid Name="fields" GridType="Collection" CollectionType="Temporal">'
    text = "\n".join([head, temporal, *grids, "</Grid></Domain></Xdmf>", ""])
    write_atomically(_claimed(path), text)
    return path


def _attribute(name: str, item: str, values: Array, centre: str = "Node") -> str:
    kind = "Vector" if values.ndim > 1 else "Scalar"
    return f'<Attribute Name={quoteattr(name)} AttributeType="{kind}" Center="{centre}">{item}</Attribute>'


# VTKHDF: one file.


def _vtkhdf(series: Series, out: Path) -> Path:
    """``fields.vtkhdf``: an unstructured grid over time, version 2.0 of the format."""
    import h5py

    kind, cells, points, fields = series.first
    path, steps, count = out / "fields.vtkhdf", len(series.times), len(cells)
    claim(path)
    every = np.arange(steps)
    with h5py.File(part_of(path), "w") as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = (2, 0)
        root.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", 16))
        for name, number in (("Points", len(points)), ("Cells", count), ("ConnectivityIds", cells.size)):
            root[f"NumberOf{name}"] = np.full(1, number)
        root["Connectivity"], root["Types"] = cells.reshape(-1), np.full(count, kind, dtype=np.uint8)
        root["Offsets"] = np.arange(count + 1) * cells.shape[1]
        shapes = {f"PointData/{name}": values.shape for name, values in fields.items()}
        moving = {"Points": points.shape} if series.deformed else {}
        for name, shape in {**moving, **shapes}.items():
            still = name.removeprefix("PointData/") in series.maps
            root.create_dataset(name, ((1 if still else steps) * shape[0], *shape[1:]), dtype=float)
        if not moving:
            root["Points"] = points
        for number, (moved, values) in enumerate(series.all()):
            rows = slice(number * len(points), (number + 1) * len(points))
            if moving:
                root["Points"][rows] = moved
            for name, each in values.items():
                if name not in series.maps or number == 0:
                    root[f"PointData/{name}"][rows] = each
        over = root.create_group("Steps")
        over.attrs["NSteps"] = steps
        over["Values"] = series.times
        over["NumberOfParts"], over["PartOffsets"] = np.ones(steps, dtype=int), np.zeros(steps, dtype=int)
        over["PointOffsets"] = every * len(points) if moving else 0 * every
        over["CellOffsets"], over["ConnectivityIdOffsets"] = np.zeros((2, steps, 1), dtype=int)
        for name in fields:
            over[f"PointDataOffsets/{name}"] = 0 * every if name in series.maps else every * len(points)
        if series.fibres is not None:
            root["CellData/fibres"] = _three(series.fibres)
            over["CellDataOffsets/fibres"] = 0 * every
    part_of(path).replace(path)
    return path


def _three(vectors: Array) -> Array:
    """Vectors (m, dim) with three components."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))
