"""What the figures are drawn from: a result folder, read back."""

from __future__ import annotations

import csv
import json
import tomllib
from functools import cached_property
from pathlib import Path
from typing import Any

from myostrain.errors import InputError
from myostrain.output.figures.style import at_time, potential_range
from myostrain.output.folder import read_regular
from myostrain.output.metrics import last_durations
from myostrain.output.snapshots import Snapshots

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Recording:
    """A result folder, read back; fields are read frame by frame.

    Args:
        folder: The result folder.

    Attributes:
        points: Material coordinates of the nodes, (n, dim).
        cells: Node numbers of the cells, (m, dim + 1).
        fibres: Fibre directions at the centres of the cells, (m, dim); None where they were not recorded.
        time: Times of the frames, (frames,).
        case: ``case.toml``, empty if there is none.
        results: ``results.json``, empty if there is none, as after a failed run.

    Raises:
        InputError: It holds no snapshots, or a file in it cannot be read.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self._snapshots = folder, Snapshots(folder)
        self.points, self.cells = self._snapshots.points, self._snapshots.cells
        self.fibres = self._snapshots.fibres
        self.time = self._snapshots.times
        self.case: dict[str, Any] = _parsed(folder / "case.toml", tomllib.loads)
        self.results: dict[str, Any] = _parsed(folder / "results.json", json.loads)

    def __repr__(self) -> str:
        """What there is."""
        return f"Recording({self.title}: {self._snapshots!r})"

    @property
    def dim(self) -> int:
        """Dimension of the body: 1 a line, 2 a sheet, 3 a solid."""
        return self.points.shape[1]

    @property
    def title(self) -> str:
        """The case's title, or the folder's name, and whether the run did not reach its end."""
        about = self._snapshots.about
        title = str(self.case.get("title") or about.get("title") or self.folder.resolve().name)
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

    def unit(self, quantity: str) -> str:
        """The unit of a quantity, such as "length"; empty if there is none."""
        units = self._units()
        return str(units.get(quantity, ""))

    def _units(self) -> dict[str, str]:
        """Units of the case, and those that its membrane declares."""
        declared = {k: v for k, v in self._snapshots.about.get("units", {}).items() if v}
        given = self.case.get("units")
        return {**declared, **(given if isinstance(given, dict) else {})}

    def potential_range(self, values: Array) -> tuple[float, float]:
        """Ends of the colour scale of a potential: those of a membrane with a unit, or of the values."""
        declared = self._snapshots.about.get("range")
        if declared and self._snapshots.about.get("units", {}).get("potential"):
            return float(declared[0]), float(declared[1])
        return potential_range(values)

    @property
    def rest(self) -> float:
        """The potential at rest."""
        return float(self._snapshots.about.get("rest", 0.0))

    @property
    def threshold(self) -> float:
        """The potential above which a node counts as activated."""
        return float(self._snapshots.about.get("threshold", 0.5))

    def label(self, symbol: str, quantity: str) -> str:
        """An axis label: the symbol and its unit, "non-dimensional" unless the case has ``[units]``."""
        units = self._units()
        unit = units.get(quantity) if units else "non-dimensional"
        return symbol if unit is None else f"{symbol} ({unit})"

    def rate_label(self, symbol: str, quantity: str, over: str) -> str:
        """An axis label of a quantity over another one, such as a length over a time."""
        units = self._units()
        if not units:
            return f"{symbol} (non-dimensional)"
        one, other = units.get(quantity), units.get(over)
        return symbol if one is None or other is None else f"{symbol} ({one}/{other})"

    def when(self, frame: int) -> str:
        """The line that says when a frame is: "t = 0.35 ms"."""
        return f"{at_time(self.time[frame])} {self.unit('time')}".strip()

    def has(self, *names: str) -> bool:
        """Whether there are frames, with all these fields."""
        return len(self.time) > 0 and self._snapshots.names.issuperset(names)

    def field(self, name: str, frame: int = -1) -> Array:
        """Nodal values (n,) or (n, dim) of a field at one frame, by default the last."""
        return self._snapshots.field(name, frame)

    def history(self, name: str) -> Array:
        """Nodal values (frames, n) or (frames, n, dim) of a field at all frames."""
        return np.stack([self._snapshots.field(name, frame) for frame in range(len(self.time))])

    def deformed(self, frame: int = -1) -> Array:
        """Spatial coordinates x = X + u of the nodes, (n, dim); X itself where nothing deforms."""
        return self.points + self.field("displacement", frame) if self.has("displacement") else self.points

    def activation(self) -> Array | None:
        """First activation times (n,) of the nodes, NaN for never; None if the run did not get that far."""
        return self.maps.get("activation_time")

    @cached_property
    def maps(self) -> dict[str, Array]:
        """What there is of each node at the end of a run, rows (rows, n) by name."""
        return self._snapshots.maps()

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

    def probe_histories(self, quantity: str) -> tuple[Array, dict[str, Array]]:
        """Times (samples,) and, by probe name, values (samples,) of one quantity, from ``probes.csv``."""
        columns = self.table("probes.csv")
        wanted = f".{quantity}"
        found = {name.removesuffix(wanted): c for name, c in columns.items() if name.endswith(wanted)}
        return columns.get("time", np.empty(0)), found


def _parsed(path: Path, parse: Any) -> dict[str, Any]:
    if not path.exists():
        return {}
    try:
        found = parse(read_regular(path).decode())
        parts = (found, found.get("metrics", {}), found.get("probes", {}))
        if not all(isinstance(part, dict) for part in parts):
            raise ValueError("it is no table of metrics and probes")
    except (OSError, ValueError, AttributeError, RecursionError) as error:
        raise InputError(f"{path} cannot be read: {error}; repair it or remove it") from error
    return dict(found)
