"""The frames of a run as arrays and as grids of PyVista."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, overload

from myostrain.errors import InputError, UnknownName, nearest
from myostrain.output import strains
from myostrain.output.reader import Reader

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: VTK's numbers of linear and quadratic cells by the number of their corners.
VTK_CELLS = {2: 3, 3: 5, 4: 10}
VTK_QUADRATIC = {2: 21, 3: 22, 4: 24}
#: Edges of a quadratic cell in VTK's order, as places among a cell's edges in ours.
VTK_EDGES = {2: (0,), 3: (0, 2, 1), 4: (0, 3, 1, 2, 4, 5)}


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
            raise UnknownName(f"no field '{name}' was written (output.fields); {nearest(str(name), names)}")
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

    def F(self, at: str | npt.ArrayLike = "centres") -> Array:
        """The deformation gradient 1 + ∂u/∂X on the mesh, as the run has it, at places in each cell.

        A quadratic displacement is kept as such, so that this is the gradient of the run at every place; what
        the run writes at nodes are means over the cells around each.

        Args:
            at: "centres" gives (cells, dim, dim); "corners" (cells, dim + 1, dim, dim), in the order of
                ``frames.cells``; barycentric coordinates (k, dim + 1) give (cells, k, dim, dim).

        Raises:
            InputError: No displacement was written, or ``at`` is none of these.
        """
        if "displacement" not in self:
            self["displacement"]  # says so
        reader, corners = self._reader, self._reader.cells.shape[1]
        middles = reader.snapshots.middles(self._number)
        if middles is not None:
            middles = middles[reader.snapshots.edges[1]]
        where = strains.places(at, corners)
        F = strains.deformation_gradient(reader.points, reader.cells, self["displacement"], middles, where)
        return F[:, 0] if isinstance(at, str) and at == "centres" else F

    def J(self, at: str | npt.ArrayLike = "centres") -> Array:
        """The volume ratio in three dimensions, (cells,) or (cells, k); ``at`` as for :meth:`F`.

        One in an incompressible sheet of plane stress, whose thickness makes up for its area.

        Raises:
            InputError: See :meth:`F`; or the displacement does not say J, which was not written.
        """
        return strains.volume_ratio(self.F(at), self._reader.kinematics)

    def E(self, at: str | npt.ArrayLike = "centres") -> Array:
        """The strain (FᵀF − 1)/2 of Green and Lagrange on the mesh, of the shape of :meth:`F`.

        Raises:
            InputError: See :meth:`F`.
        """
        return strains.green_lagrange(self.F(at))

    def fibre_stretch(self, at: str | npt.ArrayLike = "centres") -> Array:
        """The stretch |F f0| of the fibre, (cells,) or (cells, k), with f0 of the cell's centre.

        Raises:
            InputError: See :meth:`F`; or the run did not write its fibres.
        """
        reader = self._reader
        if reader.fibres is None and reader.dim != 1:
            raise InputError(f"no fibres were written in {reader.folder}: run it again with this version")
        F = self.F(at)
        if F.ndim == 3:
            return strains.fibre_stretch(F[:, None], reader.fibres)[:, 0]
        return strains.fibre_stretch(F, reader.fibres)

    def grid(self, *, deformed: bool = False, quadratic: bool = False) -> Any:
        """A ``pyvista.UnstructuredGrid``: fields at its points, fibres of sheets and solids in its cells.

        Args:
            deformed: Whether its points are x; they are X otherwise.
            quadratic: Whether its cells have nodes in the middles of their edges, with the quadratic
                displacement; other fields are linear there.

        Raises:
            InputError: PyVista is not here.
        """
        try:
            import pyvista
        except ImportError as missing:
            raise InputError(f"grids need PyVista ({missing}): pip install 'myostrain[render]'") from missing
        kind, cells, points, fields = self.arrays(deformed=deformed, quadratic=quadratic)
        grid = pyvista.UnstructuredGrid({kind: cells}, points)
        for name, values in fields.items():
            grid.point_data[name] = values
        if self._reader.fibres is not None:
            grid.cell_data["fibres"] = _in_space(self._reader.fibres)
        grid.field_data["time"] = [self.time]
        return grid

    def arrays(
        self, *, deformed: bool = False, quadratic: bool = False, further: Mapping[str, Array] | None = None
    ) -> tuple[int, npt.NDArray[np.int64], Array, dict[str, Array]]:
        """What a grid is made of, as in :meth:`grid`.

        Args:
            deformed: Whether points are x.
            quadratic: Whether cells have nodes in the middles of their edges.
            further: Further fields at the nodes.

        Returns:
            VTK's number of the cells, their nodes (m, nodes), the points (n, 3), fields (n,) or (n, 3).
        """
        reader = self._reader
        corners = reader.cells.shape[1]
        points, given = reader.points, {**self, **(further or {})}
        fields = {name: _in_space(values) for name, values in given.items()}
        kind, cells = VTK_CELLS[corners], reader.cells
        if quadratic:
            ends, of_cells = reader.snapshots.edges
            kind = VTK_QUADRATIC[corners]
            cells = np.column_stack([cells, of_cells[:, VTK_EDGES[corners]] + len(points)])
            points = np.concatenate([points, points[ends].mean(axis=1)])
            middles = reader.snapshots.middles(self._number)
            for name, values in fields.items():
                curved = name == "displacement" and middles is not None
                more = _in_space(middles) if curved and middles is not None else values[ends].mean(axis=1)
                fields[name] = np.concatenate([values, more])
        points = _in_space(points)
        if deformed and "displacement" in fields:
            points = points + fields["displacement"]
        return kind, cells, points, fields


class Frames(Sequence[Frame]):
    """All frames of a run: ``frames[-1]`` is the last, ``frames.at(2.5)`` the nearest to a time.

    Attributes:
        times: Simulated times, (frames,).
        names: Names of the fields that every frame has.
        points: Material coordinates of the nodes, (n, dim).
        cells: Node numbers of the cells, (m, dim + 1).
        fibres: Fibre directions at the centres of the cells, (m, dim); None where they were not written.
        volumes: Length, area or volume of the cells of the reference body, (m,), to take means with.
    """

    def __init__(self, reader: Reader) -> None:
        self._reader = reader
        self.volumes = strains.volumes(reader.points, reader.cells)
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
            InputError: There is no frame, or the time is before or after all of them.
        """
        return self[self._reader.frame_at(time)]

    def history(self, name: str) -> Array:
        """Nodal values of a field at all frames: (frames, n), or (frames, n, dim) of the displacement.

        Raises:
            InputError: It was not written.
        """
        return np.stack([frame[name] for frame in self])


def _in_space(vectors: Array) -> Array:
    """Vectors (n, dim) with three components, the others 0; scalars (n,) as they are."""
    if vectors.ndim == 1:
        return vectors
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))
