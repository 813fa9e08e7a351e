"""Displacements of a run's probes over time beside those that teams have published."""

from __future__ import annotations

import csv
import logging
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from myostrain.output.folder import on_first, read_regular

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
log = logging.getLogger("myostrain")

AXES = "xyz"


@dataclass(frozen=True)
class Curves:
    """Displacements by published teams.

    Args:
        times: Times (n,).
        teams: Their names.
        points: By point displacements (teams, n, 3).
    """

    times: Array
    teams: tuple[str, ...]
    points: dict[str, Array]


def known(name: str) -> bool:
    """Whether teams have published displacements of the case of this name."""
    return (resources.files("myostrain.cases.arostica") / f"{name}.csv").is_file()


def published(name: str) -> Curves:
    """What teams have published, at common times."""
    file = resources.files("myostrain.cases.arostica") / f"{name}.csv"
    rows: dict[tuple[str, str], list[list[float]]] = {}
    for team, time, point, *u in list(csv.reader(file.read_text(encoding="utf-8").splitlines()))[1:]:
        rows.setdefault((point, team), []).append([float(time), *map(float, u)])
    tables = {key: np.array(table) for key, table in rows.items()}
    times = np.linspace(0.0, 1.0, 101)
    names = tuple(dict.fromkeys(team for _, team in tables))
    points = {
        point: np.array([_at(times, tables[point, team][:, 0], tables[point, team][:, 1:]) for team in names])
        for point in dict.fromkeys(point for point, _ in tables)
    }
    return Curves(times, names, points)


def _at(times: Array, own: Array, values: Array) -> Array:
    """Values (n, 3) at other times, by straight lines."""
    return np.column_stack([np.interp(times, own, column) for column in values.T])


def displacements(folder: Path) -> tuple[Array, dict[str, Array]]:
    """Times (n,) and by probe displacements (n, 3), from ``probes.csv``.

    Raises:
        OSError: It cannot be read.
    """
    header, *rows = list(csv.reader(read_regular(folder / "probes.csv").decode().splitlines()))
    columns = dict(zip(header, np.array(rows, dtype=float).T, strict=True))
    ends = [f"_displacement_{axis}" for axis in AXES]
    names = [name.removesuffix(ends[0]) for name in header if name.endswith(ends[0])]
    return columns["time"], {name: np.column_stack([columns[name + end] for end in ends]) for name in names}


def compare(name: str, folder: Path, comm: Any) -> dict[str, Any]:
    """What ``results.json`` holds under ``curves``: a run's displacements beside the published ones.

    Args:
        name: Name of a case with published displacements.
        folder: The result folder.
        comm: MPI communicator; the first process reads and compares (collective).

    Returns:
        By point and component ("p0_x") ``rms``, the root of the mean over time of the square of the distance
        to the median of the teams, and that of each team, least and largest, ``rms_of_teams``; the run's
        largest excursion ``peak``, that of the median ``median_peak``, and of the teams, least and largest,
        ``peaks_of_teams``; and of the samples the share within the range of the teams, ``within``, and how
        far the others are outside at most, ``outside``. All in the case's unit of length.
    """
    found: dict[str, Any] = {}
    on_first(comm, lambda: found.update(_compared(name, folder)), folder / "probes.csv")
    found = comm.bcast(found, root=0)
    for key, entry in found.items():
        log.info(
            "%s: peak %.4g, published %.4g to %.4g; rms distance to the median %.3g, of teams up to %.3g",
            *(key, entry["peak"], *entry["peaks_of_teams"], entry["rms"], entry["rms_of_teams"][1]),
        )
    return found


def _compared(name: str, folder: Path) -> dict[str, Any]:
    curves, (times, own) = published(name), displacements(folder)
    until = curves.times <= times[-1] * (1 + 1e-9)
    found: dict[str, Any] = {}
    for point, teams in curves.points.items():
        if point not in own:
            continue
        mine, theirs = _at(curves.times[until], times, own[point]), teams[:, until]
        median, low, high = np.median(theirs, axis=0), theirs.min(axis=0), theirs.max(axis=0)
        outside = np.maximum(0.0, np.maximum(mine - high, low - mine))
        for i, axis in enumerate(AXES):
            at = int(np.abs(median[:, i]).argmax())
            sign = np.sign(median[at, i]) or 1.0
            rms = np.sqrt(((theirs[:, :, i] - median[:, i]) ** 2).mean(axis=1))
            peaks = sign * (sign * theirs[:, :, i]).max(axis=1)
            found[f"{point}_{axis}"] = {
                "rms": float(np.sqrt(((mine[:, i] - median[:, i]) ** 2).mean())),
                "rms_of_teams": [float(rms.min()), float(rms.max())],
                "peak": float(sign * (sign * mine[:, i]).max()),
                "median_peak": float(median[at, i]),
                "peaks_of_teams": [float(peaks.min()), float(peaks.max())],
                "within": float((outside[:, i] <= 1e-9).mean()),
                "outside": float(outside[:, i].max()),
            }
    return found
