"""The table of a sweep: one row per run, with the swept keys, how it ended, and every metric."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from myostrain.output.datasets import dataset
from myostrain.output.folder import load_results, write_atomically
from myostrain.output.quantities import attributes
from myostrain.output.reader import Reader
from myostrain.sweeping.members import Plan, as_text

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

#: How a run stands.
DONE, FAILED, WAITING = "done", "failed", "not run"


class Rows:
    """What the runs of a sweep found, read from their folders.

    Args:
        plan: The sweep.
        folder: Its folder.

    Attributes:
        status: "done", "failed" or "not run" by run.
        metrics: Metrics by run, of those that are done.
        names: Names of all metrics.
    """

    def __init__(self, plan: Plan, folder: Path) -> None:
        self.plan, self._folder = plan, folder
        self.status = {member.name: WAITING for member in plan.members}
        self.metrics: dict[str, Mapping[str, float | None]] = {}

    def done(self, name: str) -> None:
        """Take in a run that has ended well.

        Raises:
            InputError: Its results cannot be read.
        """
        self.metrics[name] = load_results(self._folder / name)["metrics"]
        self.status[name] = DONE

    @property
    def names(self) -> list[str]:
        """Names of all metrics, in the order of the runs that have them."""
        return list(dict.fromkeys(name for found in self.metrics.values() for name in found))

    def values(self, metric: str) -> list[float]:
        """A metric of every run, NaN where it has none."""
        found = [self.metrics.get(member.name, {}).get(metric) for member in self.plan.members]
        return [np.nan if value is None else float(value) for value in found]

    def vanishes(self, metric: str) -> bool:
        """Whether a metric is a force that is zero but for rounding in every run."""
        if not metric.startswith("reaction_"):
            return False
        return all(
            abs(found.get(metric) or 0.0) <= Reader(self._folder / name).least_force
            for name, found in self.metrics.items()
        )

    def write_csv(self) -> None:
        """Write ``table.csv``."""
        text = io.StringIO()
        writer, names = csv.writer(text, lineterminator="\n"), self.names
        writer.writerow(["run", *self.plan.axes, "status", *names])
        for member in self.plan.members:
            metrics = self.metrics.get(member.name, {})
            numbers = [metrics.get(name) for name in names]
            keys = [as_text(member.values[key]) for key in self.plan.axes]
            cells = ["" if number is None else f"{float(number):.9g}" for number in numbers]
            writer.writerow([member.name, *keys, self.status[member.name], *cells])
        write_atomically(self._folder / "table.csv", text.getvalue())

    def to_xarray(self) -> xr.Dataset:
        """Every metric over the swept keys; of keys that go side by side, over "run"."""
        plan, names = self.plan, self.names
        runs, states = [m.name for m in plan.members], [self.status[m.name] for m in plan.members]
        about: dict[str, dict[str, str]] = {name: {} for name in names}
        if self.metrics:
            first = Reader(self._folder / next(iter(self.metrics)))
            about = {name: attributes(name, first.units, first.dim) for name in names}
        axes = {key: coordinate(values) for key, values in plan.axes.items()}
        if plan.grid:
            along, shape = tuple(axes), tuple(map(len, axes.values()))
            coordinates: dict[str, Any] = dict(axes)
        else:
            along, shape = ("run",), (len(runs),)
            coordinates = {key: ("run", values) for key, values in axes.items()}
        variables: dict[str, Any] = {
            name: (along, np.reshape(self.values(name), shape), about[name]) for name in names
        }
        variables["status"] = (along, np.reshape(states, shape))
        if plan.grid:
            variables["run"] = (along, np.reshape(runs, shape))
        else:
            coordinates["run"] = runs
        return dataset(variables, coordinates)

    def write_netcdf(self) -> xr.Dataset:
        """Write ``table.nc``, which ``xarray.open_dataset`` reads; returns what it holds."""
        table = self.to_xarray()
        # By SciPy: the HDF5 of the DOLFINx wheel and that of h5py do not go together in one process.
        write_atomically(self._folder / "table.nc", bytes(table.to_netcdf(engine="scipy")))
        return table


def coordinate(values: Sequence[Any]) -> np.ndarray[Any, Any]:
    """Values of a key along an axis: numbers, or texts."""
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return np.array(values, dtype=float)
    return np.array([as_text(value) for value in values])
