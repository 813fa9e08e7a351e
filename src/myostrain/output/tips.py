"""Tips of spiral waves on a sheet: where two isolines cross."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any

from myostrain.engine import lasting
from myostrain.errors import InputError, nearest
from myostrain.output.rotation import Rotation, rotation
from myostrain.output.table import Table
from myostrain.state import State
from myostrain.validation import Finite, Positive, description

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from myostrain.coupling import Electromechanics

Array = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]

#: Tips nearer than this share of their cell's size are one: it lies on a side of two cells.
SAME = 1e-6


@description
class Tip:
    """Where the potential has one value and its rate is zero, or a state of the membrane another value.

    With the rate, it is the point of a front that neither advances nor retreats (Fenton and Karma 1998).

    Args:
        potential: Value of the potential; the membrane's threshold unless given.
        state: Name of a state of the membrane; the rate of the potential unless given.
        value: Value of the state, or of the rate.
        every: Simulated time between two samples; a thousandth of the run unless given.
    """

    potential: Finite | None = None
    state: str | None = None
    value: Finite = 0.0
    every: Positive | None = None


def crossings(cells: Numbers, a: Array, b: Array) -> tuple[Numbers, Array, Array]:
    """Points in triangles where two linear functions are zero.

    Args:
        cells: Node numbers (cells, 3).
        a: Values at the nodes (n,).
        b: Values at the nodes (n,).

    Returns:
        Numbers of the cells, (k,); barycentric coordinates in them, (k, 3); and the sign of ∇a × ∇b for
        corners that are numbered anticlockwise, (k,). A point on a side is in both of its cells.
    """
    high, low = a[cells].max(axis=1), a[cells].min(axis=1)
    some = np.flatnonzero((high >= 0) & (low <= 0))
    second = b[cells[some]]
    some = some[(second.max(axis=1) >= 0) & (second.min(axis=1) <= 0)]
    # Orthogonal to the values of both functions at the corners.
    weights = np.cross(a[cells[some]], b[cells[some]])
    total = weights.sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        weights = weights / total[:, None]
        inside = (weights >= 0).all(axis=1)  # not where both are zero on a line
    return some[inside], weights[inside], np.sign(total[inside])


class TipTable:
    """``tip.csv``: one row per tip and time, with its place at rest, X, Y, and deformed, x, y.

    The column ``sense`` is the sign of ∇v × ∇(rate): 1 where the spiral turns anticlockwise, −1 clockwise.
    With a state in place of the rate it is the other way round if that state rises in an excited cell.

    One tip is followed, for its rotation: from a time at which there is one only, among several the nearest
    to where it was, until there is none.

    Args:
        model: The coupled problem, on a sheet.
        tip: What a tip is.
        folder: The result folder; None writes nothing.
        saved: State of an earlier run to go on from; None begins anew.

    Raises:
        InputError: The body is not a sheet, the membrane lacks the state, or the earlier table is shorter
            than it was.
    """

    def __init__(
        self, model: Electromechanics, tip: Tip, folder: Path | None, saved: State | None = None
    ) -> None:
        potential = model.potential
        if potential.body.dim != 2:
            raise InputError("tips are found on sheets; leave it out", "output.tip")
        self._row = None
        if tip.state is not None:
            if tip.state not in potential.state_names:
                raise InputError(
                    f"the membrane has no such state; {nearest(tip.state, potential.state_names)}",
                    "output.tip.state",
                )
            self._row = potential.state_names.index(tip.state)
        self._model, self._tip = model, tip
        self._level = potential.threshold if tip.potential is None else tip.potential
        space = potential.v.function_space
        mesh, self._comm = space.mesh, lasting(space.mesh.comm)
        own = mesh.topology.index_map(2).size_local
        self._cells: Numbers = space.dofmap.list[:own].astype(np.int64)
        self._X = space.tabulate_dof_coordinates()[:, :2]
        edges = self._X[self._cells[:, 1:]] - self._X[self._cells[:, :1]]
        self._turn = np.sign(np.linalg.det(edges))  # −1 where corners are numbered clockwise
        self._size = np.linalg.norm(edges, axis=2).max(axis=1)
        self._found: int = saved["found"] if saved else 0
        self._most: int = saved["most"] if saved else 0
        self._path: list[list[float]] = list(saved["path"]) if saved else []
        self._table: Table | None = None
        if folder is not None:
            size = saved["size"] if saved else None
            columns = ["time", "X", "Y", "x", "y", "sense"]
            self._table = Table(folder / "tip.csv", columns, lasting(mesh.comm), size)

    def add(self, before: Array, length: float) -> None:
        """Look for tips now (collective).

        Args:
            before: The potential a step ago (nodes,).
            length: The length of that step.

        Raises:
            ComputationError: The table cannot be written.
        """
        potential = self._model.potential
        v = potential.v.x.array
        second = (v - before) / length if self._row is None else potential.states[self._row]
        cell, weights, sign = crossings(self._cells, v - self._level, second - self._tip.value)
        corners = self._cells[cell]
        X = np.einsum("ki,kij->kj", weights, self._X[corners])
        x = X
        if (u := self._model.displacement()) is not None:
            x = X + np.einsum("ki,kij->kj", weights, u[corners])
        rows = np.column_stack([X, x, sign * self._turn[cell], self._size[cell]])
        distinct = _distinct(np.concatenate(self._comm.allgather(rows)))
        self._found = len(distinct)
        self._most = max(self._most, self._found)
        self._follow(distinct[:, :2])
        if self._table is not None:
            self._table.add_rows(self._model.time, distinct[:, :5].tolist())

    def _follow(self, places: Array) -> None:
        """Go on with the trajectory of the tip that is followed."""
        if not len(places):
            self._path = []
        elif self._path or len(places) == 1:
            last = self._path[-1][1:] if self._path else places[0]
            near = np.hypot(*(places - last).T).argmin()
            self._path.append([self._model.time, *places[near].tolist()])

    def metrics(self) -> dict[str, float | None]:
        """Number of tips at the last look, the largest number at any, and how the followed tip turns.

        ``tip_period``, ``tip_radius``, ``tip_drift`` and ``tip_deviation`` are those of
        :class:`~myostrain.output.rotation.Rotation`, in the reference body; None of too few turns.
        """
        found = rotation(*np.reshape(self._path, (-1, 3)).T)
        return {"tips": self._found, "tips_max": self._most} | {
            f"tip_{field.name}": None if found is None else getattr(found, field.name)
            for field in dataclasses.fields(Rotation)
        }

    def notes(self) -> dict[str, str]:
        """Why a metric is None."""
        if self.metrics()["tip_period"] is not None:
            return {}
        if not self._found:
            return {"tip_period": "no tip is left"}
        return {"tip_period": "too few turns, or no circle, in the later half of the way of the tip followed"}

    def state(self) -> State:
        """What goes on in a resumed run (collective)."""
        size = None if self._table is None else self._table.size()
        return {"size": size, "found": self._found, "most": self._most, "path": list(self._path)}

    def close(self) -> None:
        """Close the file."""
        if self._table is not None:
            self._table.close()


def _distinct(rows: Any) -> Array:
    """Rows (X, Y, x, y, sense, size) in order of X and Y, each place once."""
    if not len(rows):
        return np.empty((0, 6))
    _, first = np.unique(np.round(rows[:, :2] / (SAME * rows[:, 5].max())), axis=0, return_index=True)
    return np.asarray(rows[first])
