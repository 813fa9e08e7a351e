"""Probes at material points, and times of activation at probes and nodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.engine import MPI, fem, lasting
from myostrain.errors import InputError
from myostrain.geometry.body import extent
from myostrain.geometry.points import cells_at
from myostrain.output.metrics import crossing_time
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
        corners: Local nodes of the cells that hold this process's points, (points, dim + 1).
    """

    def __init__(self, space: fem.FunctionSpace, points: Mapping[str, Sequence[float]]) -> None:
        self.names = list(points)
        self._comm = lasting(space.mesh.comm)
        dim = space.mesh.geometry.dim
        self.positions = np.zeros((len(points), 3))
        for row, (name, point) in enumerate(points.items()):
            given = np.asarray(tuple(point), dtype=float)
            if not dim <= given.size <= 3 or not np.isfinite(given).all():
                raise InputError(f"{list(point)}: give {dim} finite coordinates", f"probes.{name}")
            self.positions[row, : given.size] = given
        self._mine, self.corners, self._weights = self._locate(space, dim)

    def _locate(self, space: fem.FunctionSpace, dim: int) -> tuple[Indices, Indices, Array]:
        mesh = space.mesh
        points, cells, weights = cells_at(mesh, self.positions)
        held, first = np.unique(points, return_index=True)
        found = np.full(len(self.names), self._comm.size, dtype=np.int64)
        found[held] = self._comm.rank
        owner = np.empty_like(found)
        self._comm.Allreduce(found, owner, op=MPI.MIN)
        for name, rank, position in zip(self.names, owner, self.positions, strict=True):
            if rank == self._comm.size:
                low, high = (corner.tolist() for corner in extent(mesh))
                raise InputError(
                    f"{position[:dim].tolist()} lies outside the body, which extends from {low} to {high}",
                    f"probes.{name}",
                )
        kept = owner[held] == self._comm.rank
        first = first[kept]
        return held[kept], space.dofmap.list[cells[first]], weights[first]

    def local(self, values: Array) -> Array:
        """Values at this process's probes, from nodal values (n,) or (n, components)."""
        return np.einsum("ij,ij...->i...", self._weights, values[self.corners])

    def gather(self, local: Array) -> Array:
        """Values at all probes, in their order, on every process."""
        whole = np.zeros((len(self.names), *local.shape[1:]))
        if self._comm.size == 1:
            whole[self._mine] = local
            return whole
        for mine, values in self._comm.allgather((self._mine, local)):
            whole[mine] = values
        return whole


class ActivationTimes:
    """Times at which the potential rises through a threshold, at nodes and probes.

    They are linear in time between steps. Every rise counts, a beat each. What is above the threshold at
    the start is activated at time 0; it counts again once it has been below.

    Args:
        potential: The potential, P1.
        probes: The probes.
        threshold: The membrane's threshold.
    """

    def __init__(self, potential: fem.Function, probes: Probes, threshold: float) -> None:
        self._v, self._probes, self._threshold = potential, probes, threshold
        self._before = potential.x.array.copy()
        self._nodes, self._points = _Beats(len(self._before)), _Beats(len(probes._mine))

    def start(self, time: float = 0.0) -> None:
        """Begin with the present potential."""
        self._before[:] = self._v.x.array
        for beats, values in ((self._nodes, self._before), (self._points, self._probes.local(self._before))):
            beats.clear()
            beats.add(np.where(values >= self._threshold, time, np.nan))

    def observe(self, start: float, end: float) -> None:
        """Look at the potential after a step from ``start`` to ``end``."""
        now, level = self._v.x.array, self._threshold
        self._nodes.add(crossing_time(self._before, now, start, end, level))
        before, after = self._probes.local(self._before), self._probes.local(now)
        self._points.add(crossing_time(before, after, start, end, level))
        self._before[:] = now

    @property
    def nodes(self) -> Array:
        """First time at each node (nodes,), NaN for never."""
        return self._nodes.times[0]

    def beats(self) -> Array:
        """Time of each beat at each node, (beats, nodes), NaN for none (collective)."""
        return self._nodes.together(self._probes._comm)

    def at_probes(self) -> dict[str, list[float]]:
        """Times by probe name, in their order; none where it never happened (collective)."""
        beats = self._points.together(self._probes._comm)
        times = self._probes.gather(beats.T.copy())
        return {
            name: [float(t) for t in row if not np.isnan(t)]
            for name, row in zip(self._probes.names, times, strict=True)
        }

    def state(self) -> State:
        """The times found so far (collective)."""
        space = self._v.function_space
        points = self._probes.gather(self._points.together(self._probes._comm).T.copy())
        return {
            "nodes": [FieldState(space, times) for times in self.beats()],
            "probes": points.T.tolist(),
        }

    def restore(self, state: State) -> None:
        """Go on from a state, with the present potential as that before the next step."""
        self._before[:] = self._v.x.array
        self._nodes.put(np.array([field.values for field in state["nodes"]]))
        self._points.put(np.array(state["probes"], dtype=float)[:, self._probes._mine])


class _Beats:
    """Times of the beats of n points: row k has each one's beat k, NaN where there is none yet."""

    def __init__(self, n: int) -> None:
        self._count = np.zeros(n, dtype=np.int64)
        self.times: list[Array] = [np.full(n, np.nan)]

    def clear(self) -> None:
        self.put(np.full((1, len(self._count)), np.nan))

    def put(self, times: Array) -> None:
        self.times = [row.copy() for row in times]
        self._count = (~np.isnan(times)).sum(axis=0)

    def add(self, new: Array) -> None:
        """Add the times (n,) that are numbers as the next beats of their points."""
        rises = np.flatnonzero(~np.isnan(new))
        for beat in np.unique(self._count[rises]).tolist():
            while len(self.times) <= beat:
                self.times.append(np.full(len(self._count), np.nan))
            these = rises[self._count[rises] == beat]
            self.times[beat][these] = new[these]
        self._count[rises] += 1

    def together(self, comm: Any) -> Array:
        """The times (beats, n), as many rows on every process."""
        rows = comm.allreduce(len(self.times), op=MPI.MAX)
        missing = np.full((rows - len(self.times), len(self._count)), np.nan)
        return np.vstack([*self.times, missing])
