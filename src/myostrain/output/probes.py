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
    """First time at which the potential rises through 0.5, at nodes and probes, linear in time between steps.

    Args:
        potential: The potential, P1.
        probes: The probes.
    """

    def __init__(self, potential: fem.Function, probes: Probes) -> None:
        self._v, self._probes = potential, probes
        self._before = potential.x.array.copy()
        self.nodes = np.full(self._before.shape, np.nan)
        self._at_probes = np.full(len(probes._mine), np.nan)

    def start(self) -> None:
        """Begin with the present potential."""
        self._before[:] = self._v.x.array

    def state(self) -> State:
        """The times found so far."""
        return {
            "nodes": FieldState(self._v.function_space, self.nodes.copy()),
            "probes": self._probes.gather(self._at_probes).tolist(),
        }

    def restore(self, state: State) -> None:
        """Go on from a state, with the present potential as that before the next step."""
        self.start()
        self.nodes[:] = state["nodes"].values
        self._at_probes[:] = np.asarray(state["probes"], dtype=float)[self._probes._mine]

    def observe(self, start: float, end: float) -> None:
        """Look at the potential after a step from ``start`` to ``end``."""
        now = self._v.x.array
        _first(self.nodes, crossing_time(self._before, now, start, end))
        before, after = self._probes.local(self._before), self._probes.local(now)
        _first(self._at_probes, crossing_time(before, after, start, end))
        self._before[:] = now

    def at_probes(self) -> dict[str, float | None]:
        """Time by probe name; None where it never happened."""
        times = self._probes.gather(self._at_probes)
        return {
            name: None if np.isnan(t) else float(t) for name, t in zip(self._probes.names, times, strict=True)
        }


def _first(kept: Array, new: Array) -> None:
    missing = np.isnan(kept)
    kept[missing] = new[missing]
