"""Probes at material points, and times of activation at probes and nodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.engine import MPI, fem, lasting
from myostrain.errors import InputError, shown
from myostrain.geometry.body import extent
from myostrain.geometry.points import cells_at
from myostrain.output.beats import Activations, Beats, Repolarization
from myostrain.state import FieldState, State

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.integer[Any]]


class Probes:
    """Interpolation of P1 fields at material points.

    Args:
        space: A scalar P1 space on the body's mesh.
        points: Material coordinates by name, at least as many as the body has dimensions.

    Raises:
        InputError: A point has the wrong number of components or lies outside the body.

    Attributes:
        mine: Numbers of this process's points.
        cells: Local numbers of the cells that hold them.
        corners: Local nodes of these cells, (points, dim + 1).
    """

    def __init__(self, space: fem.FunctionSpace, points: Mapping[str, Sequence[float]]) -> None:
        if not isinstance(points, Mapping):
            raise InputError(f"{shown(points)}: give points by name, such as {{'a': (1.0, 2.0)}}", "probes")
        self.names = list(points)
        self._comm = lasting(space.mesh.comm)
        dim = space.mesh.geometry.dim
        self.positions = np.zeros((len(points), 3))
        for row, (name, point) in enumerate(points.items()):
            given = np.asarray(point, dtype=float)
            if given.ndim != 1 or not dim <= given.size <= 3 or not np.isfinite(given).all():
                count = "a finite coordinate, such as [1.0]" if dim == 1 else f"{dim} finite coordinates"
                raise InputError(f"{given.tolist()}: give {count}", f"probes.{name}")
            self.positions[row, : given.size] = given
        self.mine, self.cells, self._weights = self._locate(space, dim)
        self.corners: Indices = space.dofmap.list[self.cells]

    def _locate(self, space: fem.FunctionSpace, dim: int) -> tuple[Indices, Indices, Array]:
        mesh = space.mesh
        points, cells, weights = cells_at(mesh, self.positions)
        held, first = np.unique(points, return_index=True)
        found = np.full(len(self.names), self._comm.size, dtype=np.int64)
        found[held] = self._comm.rank
        owner = np.empty_like(found)
        self._comm.Allreduce(found, owner, op=MPI.MIN)
        for name, rank, position in zip(self.names, owner, self.positions.tolist(), strict=True):
            if rank == self._comm.size:
                low, high = (corner.tolist() for corner in extent(mesh))
                given = position if any(position[dim:]) else position[:dim]
                raise InputError(
                    f"{given} lies outside the body, which extends from {low} to {high}",
                    f"probes.{name}",
                )
        kept = owner[held] == self._comm.rank
        first = first[kept]
        return held[kept], cells[first], weights[first]

    def local(self, values: Array) -> Array:
        """Values at this process's probes, from nodal values (n,) or (n, components)."""
        return np.einsum("ij,ij...->i...", self._weights, values[self.corners])

    def evaluated(self, function: fem.Function) -> Array:
        """Values (points, components) at this process's probes of a function of any degree on the mesh."""
        at = self.positions[self.mine]
        if not len(at):
            return np.zeros((0, self.positions.shape[1]))[:, : function.function_space.mesh.geometry.dim]
        return np.asarray(function.eval(at, self.cells)).reshape(len(at), -1)

    def gather(self, local: Array) -> Array:
        """Values at all probes, in their order, on every process."""
        whole = np.zeros((len(self.names), *local.shape[1:]))
        if self._comm.size == 1:
            whole[self.mine] = local
            return whole
        for mine, values in self._comm.allgather((self.mine, local)):
            whole[mine] = values
        return whole


class ActivationTimes:
    """Times at which the potential rises through a threshold, and is repolarised, at nodes and probes.

    They are linear in time between steps. Every rise counts, a beat each. What is above the threshold at
    the start is activated at time 0; it counts again once it has been below.

    Args:
        potential: The potential, P1.
        probes: The probes.
        threshold: The membrane's threshold.
        percents: Percentages of repolarisation, see :class:`~myostrain.output.beats.Repolarization`.
        rest: The membrane's resting potential.
    """

    def __init__(
        self,
        potential: fem.Function,
        probes: Probes,
        threshold: float,
        percents: Sequence[float] = (),
        rest: float = 0.0,
    ) -> None:
        self._v, self._probes = potential, probes
        self.before = potential.x.array.copy()
        nodes, points = len(self.before), len(probes.mine)
        self._nodes, self._points = Activations(nodes, threshold), Activations(points, threshold)
        self._ends_nodes = Repolarization(nodes, percents, rest)
        self._ends_points = Repolarization(points, percents, rest)
        self._comm = lasting(potential.function_space.mesh.comm)

    def start(self, time: float = 0.0) -> None:
        """Begin with the present potential."""
        self.before[:] = self._v.x.array
        for values, beats, ends in (
            (self.before, self._nodes, self._ends_nodes),
            (self._probes.local(self.before), self._points, self._ends_points),
        ):
            ends.start(values, beats.start(values, time))

    def observe(self, start: float, end: float) -> None:
        """Look at the potential after a step from ``start`` to ``end``."""
        local = self._probes.local
        now = self._v.x.array
        for before, after, beats, ends in (
            (self.before, now, self._nodes, self._ends_nodes),
            (local(self.before), local(now), self._points, self._ends_points),
        ):
            new = beats.observe(before, after, start, end)
            ends.observe(before, after, start, end, beats, new)
        self.before[:] = now

    @property
    def nodes(self) -> Array:
        """First time at each node (nodes,), NaN for never."""
        return self._nodes.times[0]

    def beats(self) -> Array:
        """Time of each beat at each node, (beats, nodes), NaN for none (collective)."""
        return self._nodes.together(self._comm)

    def repolarizations(self) -> dict[float, Array]:
        """By percentage the end of each beat at each node, (beats, nodes), NaN for none (collective)."""
        return {percent: beats.together(self._comm) for percent, beats in self._ends_nodes.beats.items()}

    def at_probes(self) -> dict[str, list[float]]:
        """Times by probe name, in their order; none where it never happened (collective)."""
        times = self._gathered(self._points)
        return {
            name: [float(t) for t in row if not np.isnan(t)]
            for name, row in zip(self._probes.names, times, strict=True)
        }

    def durations_at_probes(self) -> dict[float, dict[str, list[float | None]]]:
        """By percentage and probe the duration of each beat, None of one without an end (collective)."""
        begun = self.at_probes()
        found: dict[float, dict[str, list[float | None]]] = {}
        for percent, beats in self._ends_points.beats.items():
            ends = self._gathered(beats)
            found[percent] = {
                name: [
                    float(row[k] - t) if k < len(row) and np.isfinite(row[k]) else None
                    for k, t in enumerate(begun[name])
                ]
                for name, row in zip(self._probes.names, ends, strict=True)
            }
        return found

    def _gathered(self, beats: Beats) -> Array:
        """Times at all probes, (probes, beats)."""
        return self._probes.gather(beats.together(self._comm).T.copy())

    def state(self) -> State:
        """The times found so far (collective)."""
        space = self._v.function_space

        def field(values: Array) -> FieldState:
            return FieldState(space, values)

        def points(values: Array) -> list[float]:
            return [float(value) for value in self._probes.gather(values)]

        return {
            "nodes": [field(times) for times in self.beats()],
            "probes": self._gathered(self._points).T.tolist(),
            "ends_nodes": self._ends_nodes.state(field, self._comm),
            "ends_probes": self._ends_points.state(points, self._comm),
        }

    def restore(self, state: State) -> None:
        """Go on from a state, with the present potential as that before the next step."""
        self.before[:] = self._v.x.array
        mine = self._probes.mine
        self._nodes.put(np.array([field.values for field in state["nodes"]]))
        self._points.put(np.array(state["probes"], dtype=float)[:, mine])
        self._ends_nodes.restore(state["ends_nodes"], lambda field: field.values)
        self._ends_points.restore(state["ends_probes"], lambda row: np.array(row, dtype=float)[mine])
