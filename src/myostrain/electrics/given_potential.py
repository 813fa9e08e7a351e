"""A potential that is given rather than solved for: what drives a quasi-static case."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

from myostrain.course import Course, value_at
from myostrain.engine import MPI, fem
from myostrain.errors import InputError
from myostrain.geometry import Body, readable
from myostrain.state import State
from myostrain.validation import description, remembers

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@description
class Drive:
    """The potential over time, and over space where a file gives its pattern.

    Args:
        potential: v: a number, or points (time, v) joined by straight lines; the same in the whole body
            without a file.
        path: A .npz file of NumPy with ``points`` (n, dim) and ``pattern`` (n,): a factor on v at these
            points, one of which at least is at each node of the mesh or nearer to it than half a cell. With
            γ = −β v it is a pattern of the active strain too. In a case file, relative to its folder.
    """

    potential: Course = 0.0
    path: Path | None = None


class GivenPotential:
    """Stands where a :class:`Potential` does, with nothing to solve: for loads and activation given in time.

    Args:
        body: The reference body.
        drive: The potential over time; zero unless given.
        pattern: Factor on it at the nodes of P1, (nodes,), in place of the drive's file; one unless given.

    Raises:
        InputError: The file cannot be read, or has no point near some node.

    Attributes:
        v: The potential, P1.
    """

    balance = "advective"
    isochoric = True
    solver = None
    calcium = None
    state_names: tuple[str, ...] = ()
    threshold = 0.5
    rest, scale = 0.0, 1.0  # v is the excitation itself

    @remembers
    def __init__(self, body: Body, drive: Drive | None = None, pattern: Array | None = None) -> None:
        self.body, self.drive = body, drive or Drive()
        self.v = fem.Function(fem.functionspace(body.mesh, ("Lagrange", 1)), name="potential")
        self.states: Array = np.zeros((0, len(self.v.x.array)))
        self.seconds = 0.0
        self._pattern: Any = 1.0 if pattern is None else pattern
        if pattern is None and self.drive.path is not None:
            self._pattern = _pattern(self.drive.path, body, self.v.function_space)
        self._put(0.0)

    @property
    def excitation(self) -> Array:
        """The potential itself (nodes,)."""
        return np.asarray(self.v.x.array)

    def __repr__(self) -> str:
        """The course."""
        return f"GivenPotential({self.drive!r})"

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest potential that comes, at least from 0 to 1."""
        course = self.drive.potential
        values = [v for _, v in course] if isinstance(course, tuple) else [float(course)]
        return min(0.0, *values), max(1.0, *values)

    def _put(self, time: float) -> None:
        self._value = value_at(self.drive.potential, time)
        self.v.x.array[:] = self._value * self._pattern

    def field_values(self) -> dict[str, Array]:
        """The potential at the nodes, by name."""
        return {"potential": self.v.x.array}

    def begin(self) -> None:
        """Begin at time 0."""
        self._put(0.0)

    def start(self, time: float = 0.0) -> None:
        """Begin at a time."""
        self._put(time)

    def solve(self, end: float, guess: Any = None, weights: Any = None) -> None:
        """Take the potential at the time ``end``."""
        self._put(end)

    def extrapolate(self, weights: Any) -> Array:
        """The present potential (nodal, local)."""
        return self.v.x.array

    def accept(self, time: float, keep: int) -> None:
        """Nothing: the past is given too."""

    def update_deformation(self) -> None:
        """Nothing: the potential does not see the body."""

    def forget(self) -> None:
        """Nothing."""

    def conserve(self) -> float:
        """Nothing is conserved; zero change."""
        return 0.0

    def amount(self) -> None:
        """There is no amount that a balance would keep."""

    def state(self) -> State:
        """The potential."""
        return {"value": self._value}

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self._value = state["value"]
        self.v.x.array[:] = self._value * self._pattern


def _pattern(path: Path, body: Body, space: fem.FunctionSpace) -> Array:
    """Values (nodes,) of a file at the nodes of a P1 space, each of the nearest point."""
    from scipy.spatial import KDTree  # takes a tenth of a second, which others need not wait for

    key, problem, points, values = "drive.path", "", np.zeros((0, 3)), np.zeros(0)
    if body.comm.rank == 0:
        try:
            readable(path, key)
            with np.load(path, allow_pickle=False) as data:
                if missing := {"points", "pattern"} - set(data.files):
                    raise InputError(f"{path} has no array '{missing.pop()}'; give points and pattern")
                points, values = data["points"], data["pattern"]
            good = points.ndim == 2 and points.shape[1] >= body.dim and values.shape == points.shape[:1]
            if not good or points.dtype.kind not in "fiu" or values.dtype.kind not in "fiu":
                problem = f"{path} needs real numbers: points (n, {body.dim}) and pattern (n,)"
            elif not (np.isfinite(points).all() and np.isfinite(values).all()):
                problem = f"{path} holds numbers that are not finite"
        except InputError as error:
            problem = str(error).removeprefix(f"{key}: ")
        except (OSError, ValueError, AttributeError, EOFError, zipfile.BadZipFile) as error:
            problem = f"{path} cannot be read as .npz: {error}"
    problem, points, values = body.comm.bcast((problem, points, values), root=0)
    if problem:
        raise InputError(problem, key)
    X = space.tabulate_dof_coordinates()[:, : body.dim]
    cells = np.asarray(space.dofmap.list)
    size = np.linalg.norm(X[cells] - X[np.roll(cells, 1, axis=1)], axis=2).max(initial=0.0)
    size = body.comm.allreduce(float(size), op=MPI.MAX)
    distances, nearest = KDTree(points[:, : body.dim]).query(X)
    worst = body.comm.allreduce(float(distances.max(initial=0.0)), op=MPI.MAX)
    if worst > size / 2:
        raise InputError(
            f"{path} has no point nearer than {worst:.4g} to some node of the mesh, whose cells are up to "
            f"{size:.4g} long; give its pattern at the nodes",
            key,
        )
    return np.asarray(values[nearest], dtype=float)
