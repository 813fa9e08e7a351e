"""A run beside published numbers: positions of material points, and strains of a wall."""

from __future__ import annotations

import csv
import io
import logging
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from myostrain.output.folder import on_first, write_atomically

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from myostrain.engine import fem
    from myostrain.mechanics.equilibrium import Mechanics

Array = npt.NDArray[np.float64]
log = logging.getLogger("myostrain")

#: The strains of a wall, in the order of :func:`wall_strains`.
STRAINS = ("longitudinal", "circumferential", "radial")


@dataclass(frozen=True)
class Quantity:
    """A published number.

    Args:
        what: What it is, with its unit.
        point: A material point.
        axis: The coordinate of its deformed position: "x", "y" or "z".
        published: Least and largest value published.
        source: By whom, and how that was read.
        converged: The value that finer meshes tend to.
    """

    what: str
    point: tuple[float, float, float]
    axis: str
    published: tuple[float, float]
    source: str
    converged: float


@dataclass(frozen=True)
class Line:
    """Material points (n, 3), and their deformed positions (n, 3) on a fine mesh."""

    points: Array
    converged: Array


@dataclass(frozen=True)
class Benchmark:
    """What is known of a case, from ``cases/land``.

    Args:
        quantities: Numbers by name.
        lines: Lines by name.
        strains: Whether the lines are those of a wall, from the inside to the outside.
    """

    quantities: Mapping[str, Quantity]
    lines: Mapping[str, Line]
    strains: bool

    def measure(self, mechanics: Mechanics) -> tuple[dict[str, Any], dict[str, Array]]:
        """Compare a configuration with what is known (collective).

        Returns:
            By name of the quantity ``value``, the whole deformed ``position``, ``published``, ``within`` (of
            the published band), ``converged`` and ``error`` (relative to it); and the deformed positions of
            the lines by name.
        """
        points = [np.array([q.point for q in self.quantities.values()])]
        points += [line.points for line in self.lines.values()]
        parts = np.split(
            positions(mechanics, np.concatenate(points)), np.cumsum([len(part) for part in points])[:-1]
        )
        found = {}
        for (name, q), position in zip(self.quantities.items(), parts[0], strict=True):
            value, (low, high) = float(position["xyz".index(q.axis)]), q.published
            found[name] = {
                "value": value,
                "position": position.tolist(),
                "published": [low, high],
                "within": low <= value <= high,
                "converged": q.converged,
                "error": value / q.converged - 1,
            }
        return found, dict(zip(self.lines, parts[1:], strict=True))


def find(name: str) -> Benchmark | None:
    """What is known of the case of this name; None where nothing is."""
    file = resources.files("myostrain.cases.land") / f"{name}.toml"
    if not file.is_file():
        return None
    data = tomllib.loads(file.read_text(encoding="utf-8"))
    quantities = {
        key: Quantity(**{**entry, "point": tuple(entry["point"]), "published": tuple(entry["published"])})
        for key, entry in data["quantities"].items()
    }
    lines = {
        key: Line(np.array(entry["points"], dtype=float), np.array(entry["converged"], dtype=float))
        for key, entry in data["lines"].items()
    }
    return Benchmark(quantities, lines, data["strains"])


def positions(mechanics: Mechanics, points: Array) -> Array:
    """Deformed positions (n, 3) of material points (n, 3), on every process (collective).

    The displacement is evaluated as it is, quadratic; of a point that is a little outside of the mesh, as
    points of a curved surface are, by that of the closest cell.
    """
    # Here, as who only draws what was found needs no engine.
    from myostrain.engine import MPI, lasting

    from dolfinx import geometry as dgeometry

    mesh = mechanics.body.mesh
    comm, tdim = lasting(mesh.comm), mesh.topology.dim
    owned = np.arange(mesh.topology.index_map(tdim).size_local, dtype=np.int32)
    distance, cells = np.full(len(points), np.inf), np.zeros(len(points), dtype=np.int32)
    if len(owned):
        tree = dgeometry.bb_tree(mesh, tdim, entities=owned)
        cells = dgeometry.compute_closest_entity(
            tree, dgeometry.create_midpoint_tree(mesh, tdim, owned), mesh, points
        )
        # Rounded: of equally close cells on several processes the one of the first is taken.
        distance = np.round(dgeometry.squared_distance(mesh, tdim, cells, points), 12)
    least = np.empty_like(distance)
    comm.Allreduce(distance, least, op=MPI.MIN)
    rank = np.where(distance == least, comm.rank, comm.size)
    owner = np.empty_like(rank)
    comm.Allreduce(rank, owner, op=MPI.MIN)
    mine = np.flatnonzero(owner == comm.rank)
    u: fem.Function = mechanics.u.sub(0) if mechanics.kinematics.has_pressure else mechanics.u
    found = np.zeros_like(points)
    if len(mine):
        found[mine] = points[mine] + u.eval(points[mine], cells[mine]).reshape(-1, 3)
    return np.asarray(comm.allreduce(found))


def wall_strains(rest: Array, deformed: Array) -> Array:
    """Strains of a wall about the axis Z from positions of its points, at rest and deformed.

    Each is the relative change of a length, ℓ/L − 1: longitudinal, of the way from a point to its neighbours
    towards apex and base; circumferential, of the circle about Z through it; radial, of the distance between
    its neighbours towards the inside and the outside. The neighbour of a point on a surface is the next one
    inside; of an end, the next one.

    Args:
        rest: Positions (lines, n, 3), lines from the inside to the outside, points from apex to base.
        deformed: As ``rest``.

    Returns:
        Strains (3, lines, n) in the order of :data:`STRAINS`; NaN around a point on the axis.
    """
    lengths = []
    for x in (rest, deformed):
        steps = np.linalg.norm(np.diff(x, axis=1), axis=2)
        along = np.pad(steps, ((0, 0), (0, 1))) + np.pad(steps, ((0, 0), (1, 0)))
        inner, outer = np.maximum(np.arange(len(x)) - 1, 0), np.minimum(np.arange(len(x)) + 1, len(x) - 1)
        lengths.append([along, np.hypot(x[..., 0], x[..., 1]), np.linalg.norm(x[outer] - x[inner], axis=2)])
    start, end = np.array(lengths)
    start = np.where(start < 1e-9 * np.abs(rest).max(), np.nan, start)
    return np.asarray(end / start - 1)


def write(found: Mapping[str, Any], lines: Mapping[str, Array], benchmark: Benchmark, out: Path) -> None:
    """Say what was found, and write ``lines.csv``: one row per point, at rest and deformed (one process)."""
    for name, entry in found.items():
        low, high = entry["published"]
        verdict = "within" if entry["within"] else "outside of"
        log.info(
            "%s: %.4f, %s what is published, %g to %g; %+.2f %% from converged",
            *(name, entry["value"], verdict, low, high, 100 * entry["error"]),
        )
    text = io.StringIO(newline="")
    table = csv.writer(text)
    table.writerow(["line", "X", "Y", "Z", "x", "y", "z"])
    for name, deformed in lines.items():
        for X, x in zip(benchmark.lines[name].points, deformed, strict=True):
            table.writerow([name, *(f"{value:.9g}" for value in (*X, *x))])
    write_atomically(out / "lines.csv", text.getvalue())


def compare(name: str, mechanics: Mechanics | None, out: Path, comm: Any) -> dict[str, Any]:
    """What ``results.json`` holds of a comparison, empty where there is nothing to compare (collective).

    Args:
        name: Name of the case.
        mechanics: The mechanics at the end of the run.
        out: Result folder; ``lines.csv`` is written into it.
        comm: MPI communicator.
    """
    benchmark = find(name)
    if benchmark is None or mechanics is None or mechanics.body.dim != 3:
        return {}
    found, lines = benchmark.measure(mechanics)
    on_first(comm, lambda: write(found, lines, benchmark, out), out / "lines.csv")
    return found
