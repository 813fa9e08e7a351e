"""Tables and maps of a result folder as xarray, with units and long names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from myostrain.errors import InputError
from myostrain.output.quantities import attributes
from myostrain.output.reader import Reader

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import xarray as xr

Array = npt.NDArray[np.float64]


def dataset(variables: Mapping[str, Any], coordinates: Mapping[str, Any], **about: Any) -> xr.Dataset:
    """An ``xarray.Dataset``; xarray takes a moment to load, and only what is asked for needs it.

    Args:
        variables: By name (dimensions, values, attributes).
        coordinates: Likewise.
        about: Attributes of the whole.
    """
    import xarray as xr

    return xr.Dataset(dict(variables), coords=dict(coordinates), attrs=about)


def scalars(values: Mapping[str, Any], about: Mapping[str, dict[str, str]]) -> xr.Dataset:
    """Numbers as variables without a dimension, NaN for None."""
    numbers = {name: np.nan if value is None else float(value) for name, value in values.items()}
    return dataset({name: ((), number, about[name]) for name, number in numbers.items()}, {})


def of_probes(reader: Reader) -> xr.Dataset:
    """See :attr:`myostrain.output.opening.Results.probes`."""
    times, table = reader.probe_table()
    places, results = reader.probes, reader.results.get("probes", {})
    names = list(table) or list(places)
    quantities = list(next(iter(table.values()), {}))
    variables: dict[str, Any] = {
        quantity: (
            ("probe", "time"),
            np.stack([table[name][quantity] for name in names]),
            _attributes(reader, quantity),
        )
        for quantity in quantities
    }
    found = [results.get(name, {}) for name in names]
    for key in dict.fromkeys(key for probe in found for key, value in probe.items() if _beats(key, value)):
        beats = _padded([probe.get(key) or [] for probe in found])
        variables[key] = (("probe", "beat"), beats, _attributes(reader, key))
    coordinates: dict[str, Any] = {"probe": names}
    if quantities:
        coordinates["time"] = ("time", times, _attributes(reader, "time"))
    if all(name in places for name in names):
        positions = np.array([places[name] for name in names]).reshape(len(names), -1)
        coordinates |= _coordinates(reader, positions, "probe")
    return dataset(variables, coordinates, title=reader.title)


def _beats(key: str, value: Any) -> bool:
    return isinstance(value, list) and key != "position"


def _padded(rows: Sequence[Sequence[float | None]]) -> Array:
    """Rows of different length, (rows, longest), NaN for none."""
    whole = np.full((len(rows), max(map(len, rows), default=0)), np.nan)
    for row, values in zip(whole, rows, strict=True):
        row[: len(values)] = [np.nan if value is None else value for value in values]
    return whole


def of_table(reader: Reader, name: str, like: str | None = None) -> xr.Dataset:
    """Columns of a CSV file over time.

    Args:
        reader: The result folder.
        name: Name of the file.
        like: The quantity that all columns are; None if each says it by its name.
    """
    columns = reader.table(name)
    times = columns.pop("time", np.empty(0))
    variables = {}
    for column, values in columns.items():
        about = _attributes(reader, like or column)
        variables[column] = ("time", values, about | ({"long_name": f"{like} at {column}"} if like else {}))
    time = {"time": ("time", times, _attributes(reader, "time"))} if columns else {}
    return dataset(variables, time, title=reader.title)


def of_rows(reader: Reader, name: str) -> xr.Dataset:
    """Columns of a CSV file of which a time may have several rows, or none."""
    columns = reader.table(name)
    variables = {column: ("row", values, _attributes(reader, column)) for column, values in columns.items()}
    return dataset(variables, {}, title=reader.title)


def of_nodes(reader: Reader) -> xr.Dataset:
    """See :attr:`myostrain.output.opening.Results.maps`."""
    maps = dict(reader.maps)
    if not maps:
        raise InputError(f"the run in {reader.folder} did not reach its end, at which these maps are written")
    maps.pop("activation_time", None)  # the first row of the activation times once more
    count = len(maps["activation_times"])
    variables: dict[str, Any] = {}
    for name, values in maps.items():
        if "_times" in name:  # of the last beats there may be no end
            ended = np.pad(values, ((0, count - len(values)), (0, 0)), constant_values=np.nan)
            variables[name] = (("beat", "node"), ended, _attributes(reader, name))
        else:
            variables[name] = ("node", values.reshape(-1), _attributes(reader, name))
    for percent, values in reader.durations().items():
        name = f"apd{percent}"
        variables[name] = ("node", values, _attributes(reader, name))
    return dataset(variables, _coordinates(reader, reader.points, "node"), title=reader.title)


def _coordinates(reader: Reader, points: Array, along: str) -> dict[str, Any]:
    """Material coordinates X, Y, Z of points (n, dim)."""
    return {
        axis: (along, points[:, i], {**_attributes(reader, axis), "long_name": f"material coordinate {axis}"})
        for i, axis in enumerate("XYZ"[: points.shape[1]])
    }


def _attributes(reader: Reader, name: str) -> dict[str, str]:
    return attributes(name, reader.units, reader.dim)
