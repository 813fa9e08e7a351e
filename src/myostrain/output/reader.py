"""A result folder, read back: the one reader, for figures, comparisons and :func:`myostrain.open`."""

from __future__ import annotations

import csv
import json
import tomllib
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from myostrain.errors import InputError
from myostrain.output.folder import read_regular
from myostrain.output.metrics import last_durations
from myostrain.output.snapshots import Snapshots
from myostrain.output.units import QUANTITIES

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: Dimensions by the kinematics of a case.
DIMENSIONS = {"line": 1, "plane-stress": 2, "plane-strain": 2, "solid": 3}

#: Share of the modulus times the width below which a force is a sum that vanishes.
ROUNDING = 1e-5


class Reader:
    """A result folder, read back; fields are read frame by frame, and nothing is read before it is needed.

    Args:
        folder: The result folder.

    Attributes:
        case: ``case.toml``, empty if there is none.
        results: ``results.json``, empty if there is none, as after a failed run.

    Raises:
        InputError: A file in it cannot be read.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.case: dict[str, Any] = _parsed(folder / "case.toml", tomllib.loads)
        self.results: dict[str, Any] = _parsed(folder / "results.json", json.loads)

    @cached_property
    def failure(self) -> dict[str, Any] | None:
        """What ``failure.json`` of a failed run says; None if there is none."""
        return _parsed(self.folder / "failure.json", json.loads) or None

    @property
    def recorded(self) -> bool:
        """Whether there are snapshots; without them there are no frames and no maps."""
        return (self.folder / "snapshots" / "mesh.npz").is_file()

    @cached_property
    def snapshots(self) -> Snapshots:
        """The frames.

        Raises:
            InputError: There are none.
        """
        return Snapshots(self.folder)

    @property
    def points(self) -> Array:
        """Material coordinates of the nodes, (n, dim)."""
        return self.snapshots.points

    @property
    def cells(self) -> npt.NDArray[np.int64]:
        """Node numbers of the cells, (m, dim + 1)."""
        return self.snapshots.cells

    @property
    def fibres(self) -> Array | None:
        """Fibre directions at the centres of the cells, (m, dim); None where they were not recorded."""
        return self.snapshots.fibres

    @property
    def time(self) -> Array:
        """Times of the frames, (frames,)."""
        return self.snapshots.times

    @cached_property
    def dim(self) -> int | None:
        """Dimension of the body: 1 a line, 2 a sheet, 3 a solid; None if nothing says it."""
        if self.recorded:
            return self.points.shape[1]
        mechanics = self.case.get("mechanics", {})
        return DIMENSIONS.get(str(mechanics.get("kinematics")) if isinstance(mechanics, dict) else "")

    @property
    def _about(self) -> dict[str, Any]:
        return self.snapshots.about if self.recorded else {}

    @property
    def title(self) -> str:
        """The case's title, or the folder's name, and whether the run did not reach its end."""
        title = str(self.case.get("title") or self._about.get("title") or self.folder.resolve().name)
        return title if self.results else f"{title} (run not finished)"

    @property
    def metrics(self) -> dict[str, float | None]:
        """Metrics by name; empty if the run did not end well."""
        return self.results.get("metrics", {})

    @property
    def probes(self) -> dict[str, Array]:
        """Material coordinates (dim,) of the probes by name."""
        given = {name: probe["position"] for name, probe in self.results.get("probes", {}).items()}
        given = given or self.case.get("probes", {})
        return {name: np.asarray(place, dtype=float)[: self.dim] for name, place in given.items()}

    @property
    def units(self) -> dict[str, str]:
        """Units by quantity: those of the case, and those that its membrane declares."""
        declared = {**self._about.get("units", {}), **self.results.get("units", {})}
        given = self.case.get("units")
        units = {**declared, **(given if isinstance(given, dict) else {})}
        return {quantity: str(units[quantity]) for quantity in QUANTITIES if units.get(quantity)}

    def unit(self, quantity: str) -> str:
        """The unit of a quantity, such as "length"; empty if there is none."""
        return self.units.get(quantity, "")

    @property
    def kinematics(self) -> dict[str, Any]:
        """Name and constraint of the kinematics; empty where the run did not write them."""
        return dict(self._about.get("kinematics", {}))

    @property
    def rest(self) -> float:
        """The potential at rest."""
        return float(self._about.get("rest", 0.0))

    @property
    def threshold(self) -> float:
        """The potential above which a node counts as activated."""
        return float(self._about.get("threshold", 0.5))

    @property
    def least_force(self) -> float:
        """Forces up to this are sums that vanish, as those of springs all round; 0 if it is not known."""
        if not self.recorded:
            return 0.0
        width = np.ptp(self.points, axis=0).max() ** (self.points.shape[1] - 1)
        return float(ROUNDING * width * self._about.get("modulus", 0.0))

    def frame_at(self, time: float, key: str | None = None) -> int:
        """The number of the frame nearest to a time.

        Args:
            time: The simulated time; beyond the ends by half the longest interval of frames at most.
            key: What the time was given as, for the message.

        Raises:
            InputError: There is no frame, or the time is before or after all of them.
        """
        if not len(self.time):
            raise InputError(f"{self.folder} holds no frame yet")
        first, last = self.time[0], self.time[-1]
        slack = 1e-6 * max(1.0, abs(last)) + np.diff(self.time).max(initial=0.0) / 2
        if not first - slack <= time <= last + slack:
            raise InputError(
                f"{time:g} is not between the first and the last frame, {first:g} and {last:g}", key
            )
        return int(np.abs(self.time - time).argmin())

    def has(self, *names: str) -> bool:
        """Whether there are frames, with all these fields."""
        return self.recorded and len(self.time) > 0 and self.snapshots.names.issuperset(names)

    def field(self, name: str, frame: int = -1) -> Array:
        """Nodal values (n,) or (n, dim) of a field at one frame, by default the last."""
        return self.snapshots.field(name, frame)

    def history(self, name: str) -> Array:
        """Nodal values (frames, n) or (frames, n, dim) of a field at all frames."""
        return np.stack([self.snapshots.field(name, frame) for frame in range(len(self.time))])

    def deformed(self, frame: int = -1) -> Array:
        """Spatial coordinates x = X + u of the nodes, (n, dim); X itself where nothing deforms."""
        return self.points + self.field("displacement", frame) if self.has("displacement") else self.points

    def activation(self) -> Array | None:
        """First activation times (n,) of the nodes, NaN for never; None if the run did not get that far."""
        return self.maps.get("activation_time")

    @cached_property
    def maps(self) -> dict[str, Array]:
        """What there is of each node at the end of a run, rows (rows, n) by name."""
        return self.snapshots.maps()

    def durations(self) -> dict[str, Array]:
        """By percentage of repolarisation, as text, the duration (n,) of each node's last ended beat."""
        prefix = "repolarization_times_"
        return {
            name.removeprefix(prefix): last_durations(self.maps["activation_times"], ends)
            for name, ends in self.maps.items()
            if name.startswith(prefix)
        }

    def table(self, name: str) -> dict[str, Array]:
        """Columns (rows,) by name of a table such as ``probes.csv``; nothing if there is none."""
        path = self.folder / name
        if not path.exists():
            return {}
        try:
            lines = read_regular(path).decode().splitlines()
            header, *rows = list(csv.reader(lines)) or [["time"]]
            whole = [row for row in rows if len(row) == len(header)]
            columns = np.array(whole, dtype=float).reshape(len(whole), len(header)).T
            found = dict(zip(header, columns, strict=True))
            found["time"]
        except (OSError, ValueError, KeyError, csv.Error) as error:
            raise InputError(
                f"{path} cannot be read as a table of numbers: {error}; remove it or repair it"
            ) from error
        return found

    def probe_table(self) -> tuple[Array, dict[str, dict[str, Array]]]:
        """Times (samples,) and, by probe and quantity, values (samples,), from ``probes.csv``."""
        columns = self.table("probes.csv")
        times = columns.pop("time", np.empty(0))
        found: dict[str, dict[str, Array]] = {}
        split = _split(list(columns), list(self.probes))
        if columns and not split:
            raise InputError(
                f"the columns of {self.folder / 'probes.csv'} are not PROBE_QUANTITY, the same quantities of "
                "each probe; put back what the run wrote"
            )
        for probe, quantity, column in split:
            found.setdefault(probe, {})[quantity] = columns[column]
        return times, found

    def probe_histories(self, quantity: str) -> tuple[Array, dict[str, Array]]:
        """Times (samples,) and, by probe name, values (samples,) of one quantity, from ``probes.csv``."""
        times, found = self.probe_table()
        return times, {probe: values[quantity] for probe, values in found.items() if quantity in values}


def _split(columns: Sequence[str], probes: Sequence[str]) -> list[tuple[str, str, str]]:
    """Probe, quantity and name of each column "PROBE_QUANTITY"; every probe has the same quantities.

    Names may hold underscores, so that no column alone says where the probe ends; all together do. Probes
    that nothing names, as after a failed script, are taken from the columns of the potential. Earlier
    versions wrote "PROBE.QUANTITY".
    """
    count = len(columns)
    mark = "." if columns and columns[0].endswith(".potential") else "_"
    tries = [(count // len(probes), list(probes))] if probes else []
    tries += [(k, [c.removesuffix(f"{mark}potential") for c in columns[::k]]) for k in range(1, count + 1)]
    for each, names in tries:
        quantities = [column.removeprefix(f"{names[0]}{mark}") for column in columns[:each]]
        found = [(name, quantity, f"{name}{mark}{quantity}") for name in names for quantity in quantities]
        if [column for _, _, column in found] == list(columns):
            return found
    return []


def _parsed(path: Path, parse: Any) -> dict[str, Any]:
    if not path.exists():
        return {}
    try:
        found = parse(read_regular(path).decode())
        parts = (found, found.get("metrics", {}), found.get("probes", {}))
        if not all(isinstance(part, dict) for part in parts):
            raise ValueError("it is not a table of metrics and probes")
    except (OSError, ValueError, AttributeError, RecursionError) as error:
        raise InputError(f"{path} cannot be read: {error}; repair it or remove it") from error
    return dict(found)
