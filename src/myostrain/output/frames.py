"""The frames of a run as arrays and as grids of PyVista."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, overload

from myostrain.errors import InputError, nearest
from myostrain.output.reader import Reader

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: VTK's numbers of the cells by the number of their corners.
VTK_CELLS = {2: 3, 3: 5, 4: 10}


class Frame(Mapping[str, Array]):
    """The fields of a run at one time, read when they are asked for: ``frame["potential"]`` is (n,).

    A displacement is (n, dim), all other fields are (n,).

    Attributes:
        time: The simulated time.
    """

    def __init__(self, reader: Reader, number: int) -> None:
        self._reader, self._number = reader, number
        self.time = float(reader.time[number])

    def __getitem__(self, name: str) -> Array:
        """Nodal values of a field."""
        names = self._reader.snapshots.names
        if name not in names:
            raise InputError(f"no field '{name}' was written (output.fields); {nearest(name, names)}")
        return self._reader.field(name, self._number)

    def __iter__(self) -> Iterator[str]:
        """Names of the fields."""
        return iter(sorted(self._reader.snapshots.names))

    def __len__(self) -> int:
        """Number of the fields."""
        return len(self._reader.snapshots.names)

    def __contains__(self, name: object) -> bool:
        """Whether a field was written."""
        return name in self._reader.snapshots.names

    def __repr__(self) -> str:
        """When it is, and what it has."""
        return f"Frame(t = {self.time:.6g}: {', '.join(self)})"

    @property
    def deformed(self) -> Array:
        """Spatial coordinates x = X + u of the nodes, (n, dim); X itself where no displacement is."""
        return self._reader.deformed(self._number)

    def grid(self, *, deformed: bool = False) -> Any:
        """A ``pyvista.UnstructuredGrid`` with all fields at its points and, of a solid, fibres in its cells.

        Args:
            deformed: Whether its points are x; they are X otherwise.

        Raises:
            InputError: PyVista is not here.
        """
        try:
            import pyvista
        except ImportError as missing:
            raise InputError(f"grids need PyVista ({missing}): pip install 'myostrain[render]'") from missing
        reader = self._reader
        points = self.deformed if deformed else reader.points
        grid = pyvista.UnstructuredGrid({VTK_CELLS[reader.cells.shape[1]]: reader.cells}, _in_space(points))
        for name, values in self.items():
            grid.point_data[name] = values if values.ndim == 1 else _in_space(values)
        if reader.fibres is not None:
            grid.cell_data["fibres"] = _in_space(reader.fibres)
        grid.field_data["time"] = [self.time]
        return grid


class Frames(Sequence[Frame]):
    """All frames of a run: ``frames[-1]`` is the last, ``frames.at(2.5)`` the nearest to a time.

    Attributes:
        times: Simulated times, (frames,).
        names: Names of the fields that every frame has.
        points: Material coordinates of the nodes, (n, dim).
        cells: Node numbers of the cells, (m, dim + 1).
        fibres: Fibre directions at the centres of the cells, (m, dim); None where they were not written.
    """

    def __init__(self, reader: Reader) -> None:
        self._reader = reader
        self.times, self.names = reader.time, sorted(reader.snapshots.names)
        self.points, self.cells, self.fibres = reader.points, reader.cells, reader.fibres

    @overload
    def __getitem__(self, number: int) -> Frame: ...
    @overload
    def __getitem__(self, number: slice) -> list[Frame]: ...
    def __getitem__(self, number: int | slice) -> Frame | list[Frame]:
        """One frame, or several."""
        if isinstance(number, slice):
            return [Frame(self._reader, i) for i in range(len(self))[number]]
        return Frame(self._reader, range(len(self))[number])

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.times)

    def __repr__(self) -> str:
        """What there is."""
        if not len(self):
            return "Frames(none)"
        ends = f"t = {self.times[0]:g} to {self.times[-1]:g}"
        return f"Frames({len(self)}, {ends}, {len(self.points)} nodes: {', '.join(self.names)})"

    def at(self, time: float) -> Frame:
        """The frame nearest to a time.

        Raises:
            InputError: There is no frame.
        """
        if not len(self):
            raise InputError("no frame was written yet")
        return self[int(np.abs(self.times - time).argmin())]

    def history(self, name: str) -> Array:
        """Nodal values of a field at all frames: (frames, n), or (frames, n, dim) of the displacement.

        Raises:
            InputError: It was not written.
        """
        return np.stack([frame[name] for frame in self])


def _in_space(vectors: Array) -> Array:
    """Vectors (n, dim) with three components, the others 0."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))
