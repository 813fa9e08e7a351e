"""The current between the nodes, in the cells over which a front passes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

from myostrain.electrics.diffusion import Mass
from myostrain.electrics.following import FollowingMass
from myostrain.engine import fem
from myostrain.membranes import Step
from myostrain.membranes.reaction import Reaction
from myostrain.state import CellState, State

import basix
import numpy as np
import numpy.typing as npt
from dolfinx import la

Array = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]

Values = tuple[Array, Array]
"""The potential (nodes,) and the states (states, nodes) of one time."""

Current = Literal["nodal", "interpolated"]
"""Where the membrane is evaluated: at the nodes, or also between those over which a front passes."""

#: Difference of the potential within a cell, in parts of its range, above which a front passes over it.
STEEP = 0.02

#: Height over the rest, in parts of the range, below which the potential is interpolated linearly.
FLOOR = 1e-3


class Front:
    """The membrane at points of their own in the cells over which the potential varies much.

    A front that is but a cell wide is not linear between two nodes: ahead of it v − rest falls
    exponentially, as exp(−c x/D) with the velocity c. So its logarithm is interpolated (the inverse
    hyperbolic sine, which is linear about 0 and has a sign). The states are those of the points themselves,
    as in S. Krishnamoorthi, M. Sarkar and W. S. Klug, Int. J. Numer. Methods Biomed. Eng. 29 (2013)
    1243–1266, doi 10.1002/cnm.2573. They begin interpolated from the nodes; behind the front they are given
    up. With the averaged mass these cells have the mass that follows the front
    (:class:`~myostrain.electrics.following.FollowingMass`).

    Each cell has as many points as corners, those of the quadrature that is exact for quadratic functions.

    Args:
        space: P1 space of the potential.
        reaction: The membrane, another one than that of the nodes.
        rest: The potential at rest, a number or nodal (nodes,).
        span: What the potential may vary by, the length of its range.
        mass: The mass with which the nodal current acts.
        conductivity: D on the reference mesh, a UFL expression.

    Attributes:
        cells: The cells that have points, in rising order.
    """

    def __init__(
        self,
        space: fem.FunctionSpace,
        reaction: Reaction,
        rest: float | Array,
        span: float,
        mass: Mass,
        conductivity: Any,
    ) -> None:
        mesh = space.mesh
        own = mesh.topology.index_map(mesh.topology.dim).size_local
        self._space, self._reaction, self._rest = space, reaction, rest
        self._steep, self._linear = STEEP * span, 2 * FLOOR * span
        self._nodes: Numbers = space.dofmap.list[:own].astype(np.int64)
        corners = self._nodes.shape[1]
        self._X = space.tabulate_dof_coordinates()[:, : corners - 1]
        x = self._X[self._nodes]
        places, weights = basix.make_quadrature(getattr(basix.CellType, mesh.topology.cell_type.name), 2)
        shares = space.element.basix_element.tabulate(0, places)[0, :, :, 0]
        #: Values at the points of linear functions; point k is the one next to corner k.
        self._shares: Array = shares[np.argsort(shares.argmax(axis=1))]
        self._volume: Array = np.abs(np.linalg.det(x[:, 1:] - x[:, :1])) * weights.sum()
        whole = np.eye(corners) / corners
        if mass == "averaged":
            consistent = (np.ones((corners, corners)) + np.eye(corners)) / (corners * (corners + 1))
            whole = (whole + consistent) / 2
        self._mass: Array = whole  # of a cell of unit volume
        follows = mass == "averaged" and corners > 2  # on a line they are the same
        self._following = FollowingMass(space, conductivity, span) if follows else None
        self._work = fem.Function(space)
        self.clear()

    def clear(self) -> None:
        """No cell has points."""
        self.cells: Numbers = np.zeros(0, dtype=np.int64)
        self._levels: list[Array] = []  # states of past times, newest first, (states, cells · points)
        self._found: Array | None = None  # those of the step that has not been accepted
        self._ahead: Array = np.ones(1)

    def shorten(self) -> None:
        """Keep only the newest states."""
        self._levels = self._levels[:1]

    def extrapolate(self, weights: Array) -> None:
        """Let the next step guess the states by these weights of the past ones, newest first."""
        self._ahead = weights

    def accept(self, keep: int) -> None:
        """Take the states of the last solve, and keep ``keep`` past ones."""
        if self._found is not None:
            self._levels = [self._found, *self._levels[: keep - 1]]
        self._found, self._ahead = None, np.ones(1)

    def solve(
        self,
        guess: Array,
        rate: Array,
        nodal: Array,
        ratio: Array,
        varying: Mapping[str, Array],
        past: Sequence[Values],
        times: tuple[float, float],
        weights: Array,
    ) -> Array:
        """Advance the states of the points, and find by how much the current of the nodes is to be corrected.

        Args:
            guess: Potential at the end of the step (nodes,).
            rate: What diffusion adds there to the rate of J v (nodes,).
            nodal: Current at the nodes and its derivative in v, times J (2, nodes).
            ratio: J at the nodes (nodes,).
            varying: Parameters of the membrane that vary over the nodes (nodes,), by name.
            past: The potential and the states at the nodes at past times, newest first.
            times: End and beginning of the step.
            weights: Backward-difference weights of the new value and the past ones.

        Returns:
            What is to be added to the nodal load of the current and to its derivative (2, nodes).

        Raises:
            ComputationError: A state of a point is not what it may be.
        """
        self._follow(past)
        nodes, shape = self._nodes[self.cells], (len(self.cells), len(self._shares))
        before, points = self._levels[0], len(self._shares)
        bad, corrections, found = -1, np.zeros((2, len(guess))), before
        if len(nodes) or self._reaction.written:  # formulas are compiled by all processes together
            history, states = before, before
            if self._reaction.multistep:
                history = _sum(weights[1:], self._levels)
                states = self._found if self._found is not None else _sum(self._ahead, self._levels)
            v = self._between(guess)
            order = len(weights) - 1
            length, start = times[0] - times[1], self._between(past[0][0])
            step = Step(length, float(weights[0]), history, before, start, order)
            self._reaction.vary({n: self._linearly(x[None], self.cells)[0] for n, x in varying.items()})
            found, *currents, bad = self._reaction.solve(v, states, step)
            volume = self._volume[self.cells, None]
            J = ratio[nodes] @ self._shares.T
            inside = [(J * values.reshape(shape)) @ self._shares / points for values in currents]
            outside = nodal[0, nodes] @ self._mass, nodal[1, nodes] / points
            if self._following is not None:  # the mass multiplies rate and current, which add up to that
                inside[0] += self._following.difference(self.cells, guess[nodes], rate[nodes])
            corrections += [
                np.bincount(nodes.reshape(-1), (volume * (a - b)).reshape(-1), len(guess))
                for a, b in zip(inside, outside, strict=True)
            ]
        self._reaction.refuse(bad, found, self._place, times[0])
        self._found = found
        self._add_up(corrections)
        return corrections

    def _add_up(self, rows: Array) -> None:
        """Add to each of these (nodes,) what other processes have of its nodes (collective)."""
        for index in range(len(rows)):
            self._work.x.array[:] = rows[index]
            self._work.x.scatter_reverse(la.InsertMode.add)
            self._work.x.scatter_forward()
            rows[index] = self._work.x.array

    def _follow(self, past: Sequence[Values]) -> None:
        """Give points to the cells over which the potential varies now, and take them from the others."""
        corners = past[0][0][self._nodes]
        cells = np.flatnonzero(np.ptp(corners, axis=1) > self._steep)
        if self._levels and np.array_equal(cells, self.cells):
            return
        known = np.isin(cells, self.cells, assume_unique=True)
        places = np.searchsorted(self.cells, cells[known])
        levels, points = [], len(self._shares)
        for level, (_, states) in enumerate(past):
            if len(states) < len(past[0][1]):  # not kept
                break
            found = np.empty((len(states), len(cells), points))
            new = self._linearly(states, cells[~known])
            found[:, ~known] = new.reshape(len(states), -1, points) if new.size else 0.0
            if known.any():
                old = self._levels[level].reshape(len(states), len(self.cells), points)
                found[:, known] = old[:, places]
            levels.append(found.reshape(len(states), len(cells) * points))
        self.cells, self._levels, self._found = cells, levels, None

    def _linearly(self, values: Array, cells: Numbers) -> Array:
        """Linear functions (n, nodes) at the points of cells, (n, cells · points)."""
        found = values[:, self._nodes[cells]] @ self._shares.T
        return found.reshape(len(values), len(cells) * len(self._shares))

    def _between(self, v: Array) -> Array:
        """The potential (nodes,) at the points."""
        nodes, rest = self._nodes[self.cells], self._rest
        heights = np.arcsinh((v - rest) / self._linear)[nodes] @ self._shares.T
        at: Any = rest[nodes] @ self._shares.T if isinstance(rest, np.ndarray) else rest
        return (at + self._linear * np.sinh(heights)).reshape(-1)

    def _place(self, point: int) -> Array:
        """The middle of a point's cell."""
        return self._X[self._nodes[self.cells[point // len(self._shares)]]].mean(axis=0)

    def state(self) -> State:
        """The states of the points at past times, newest first."""
        shape = (len(self.cells), len(self._shares))
        rows = [level.reshape(len(level), *shape).transpose(1, 2, 0) for level in self._levels]
        return {"levels": [CellState(self._space, self.cells, values) for values in rows]}

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self.clear()
        for level in state["levels"]:
            cells, points, count = level.values.shape
            self.cells = level.cells
            rows = level.values.transpose(2, 0, 1).reshape(count, cells * points)
            self._levels.append(np.ascontiguousarray(rows))


def _sum(weights: Array, arrays: Sequence[Array]) -> Array:
    """A weighted sum, of as many as there are."""
    total = weights[0] * arrays[0]
    for weight, array in zip(weights[1:], arrays[1:], strict=False):
        total += weight * array
    return total
