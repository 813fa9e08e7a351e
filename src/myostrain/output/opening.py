"""A result folder as data: :func:`open`, for which no solver is loaded."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from myostrain.errors import InputError, UnknownName, nearest
from myostrain.output import datasets
from myostrain.output.exporting import Format, export
from myostrain.output.folder import check_path, load_results
from myostrain.output.frames import Frames
from myostrain.output.page import table
from myostrain.output.quantities import attributes
from myostrain.output.reader import Reader

if TYPE_CHECKING:
    import xarray as xr


def open(folder: str | Path, *, unfinished: bool = False) -> Results:  # noqa: A001 - ms.open
    """Read a result folder; neither DOLFINx nor MPI is needed, and nothing is read before it is asked for.

    Args:
        folder: The result folder of a run.
        unfinished: Whether to read one whose run has not reached its end, too, as far as it came.

    Raises:
        InputError: It is none, it is damaged, or its run failed, was stopped or goes on still.
    """
    path = Path(folder)
    check_path(path, "DIR")
    if not path.is_dir():
        raise InputError(f"{path} is {'a file' if path.exists() else 'not there'}; name a result folder")
    finished = (path / "results.json").exists()
    if not finished and (path / "sweep.json").exists():
        raise InputError(
            f"{path} is a sweep: open one of its runs, such as {path / '001'}, or its table, "
            f"xarray.open_dataset('{path / 'table.nc'}')"
        )
    if finished and not (path / "case.toml").exists() and (path / "trace.csv").exists():
        raise InputError(f"{path} was written by `myostrain cell`; read {path / 'trace.csv'}")
    if finished:
        load_results(path)  # which says what is wrong with it
    elif not any((path / name).exists() for name in ("case.toml", "snapshots", "failure.json", "probes.csv")):
        raise InputError(f"{path} holds no results of a run; name the folder of one (--out)")
    reader = Reader(path)
    if not finished and not unfinished:
        raise InputError(f"{_why_unfinished(reader)}; ms.open(..., unfinished=True) reads what there is")
    return Results(reader)


def _why_unfinished(reader: Reader) -> str:
    failure = reader.failure
    if failure is not None:
        when = failure.get("time")
        at = "" if when is None else f" at t = {float(when):.6g}"
        return f"the run in {reader.folder} failed{at}: {failure.get('reason')}"
    return (
        f"the run in {reader.folder} has not reached its end: it goes on still, or go on with "
        f"`myostrain run --resume --out {reader.folder}`"
    )


class Metrics(Mapping[str, float | None]):
    """The metrics of a run: ``metrics["celerity"]`` is a number, or None where it does not exist.

    Attributes:
        units: Units by name, "1" for a number; a name without a known unit is left out.
        notes: Why some do not exist, by name.
    """

    def __init__(self, reader: Reader) -> None:
        self._values = reader.metrics
        self._about = {name: attributes(name, reader.units, reader.dim) for name in self._values}
        self.units = {name: about["units"] for name, about in self._about.items() if "units" in about}
        self.notes: dict[str, str] = dict(reader.results.get("notes", {}))

    def __getitem__(self, name: str) -> float | None:
        """One metric.

        Raises:
            UnknownName: There is none of the name, which is an ``InputError`` and a ``KeyError``.
        """
        if name not in self._values:
            if not self._values:
                raise UnknownName(f"no metric '{name}': the run has not reached its end and has none yet")
            raise UnknownName(f"no metric is called '{name}'; {nearest(str(name), self._values)}")
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        """Their names."""
        return iter(self._values)

    def __len__(self) -> int:
        """How many."""
        return len(self._values)

    def rows(self) -> list[tuple[str, str, str, str]]:
        """Name, value, unit and meaning of each, as text."""
        return [
            (
                name,
                "–" if value is None else f"{float(value):.5g}",
                "" if (unit := self.units.get(name, "")) == "1" else unit,
                self._about[name]["long_name"],
            )
            for name, value in self.items()
        ]

    def to_xarray(self) -> xr.Dataset:
        """The metrics as variables without a dimension, with "units" and "long_name"; NaN for none."""
        return datasets.scalars(self._values, self._about)

    def __repr__(self) -> str:
        """A table."""
        return "\n".join(f"{name:28} {value:>12} {unit}".rstrip() for name, value, unit, _ in self.rows())

    def _repr_html_(self) -> str:
        return table(("metric", "value", "unit", "meaning"), self.rows())


class Results:
    """A run, read back: see :func:`open`.

    Attributes:
        folder: The result folder.
        title: Title of the case.
        case: The case as it ran, nested dictionaries with the keys of a case file; the file itself is
            ``case.toml`` in the folder. Empty where a script ran no case.
        results: All that ``results.json`` holds; empty if the run is not finished.
        units: By quantity ("length", "time", "potential", "stress"); empty where all is non-dimensional.
        finished: Whether the run reached its end.
        failure: What ``failure.json`` of a failed run says; None if there is none.
    """

    def __init__(self, reader: Reader) -> None:
        self._reader = reader
        self.folder, self.title = reader.folder, reader.title
        self.case, self.results, self.units = reader.case, reader.results, reader.units
        self.finished, self.failure = bool(reader.results), reader.failure

    @cached_property
    def metrics(self) -> Metrics:
        """The metrics, with units."""
        return Metrics(self._reader)

    @property
    def least_force(self) -> float:
        """Forces of supports up to this are sums that vanish, but for what the solvers leave."""
        return self._reader.least_force

    @cached_property
    def probes(self) -> xr.Dataset:
        """What was sampled at probes: potential, states, activation, displacement, ... over (probe, time).

        The coordinates of the probes are X, Y, Z. Activation times and durations of each of their beats, as
        ``activation_times`` and ``apd90``, are over (probe, beat), NaN for none.
        """
        return datasets.of_probes(self._reader)

    @cached_property
    def measures(self) -> xr.Dataset:
        """The columns of ``measures.csv`` over time; no variable where nothing was measured."""
        return datasets.of_table(self._reader, "measures.csv")

    @cached_property
    def cavities(self) -> xr.Dataset:
        """Volumes and pressures of cavities, and states of the circulation, at every solve of mechanics."""
        return datasets.of_table(self._reader, "cavities.csv")

    @cached_property
    def electrodes(self) -> xr.Dataset:
        """The columns of ``ecg.csv`` over time; no variable without electrodes."""
        return datasets.of_table(self._reader, "ecg.csv", "potential")

    @cached_property
    def tips(self) -> xr.Dataset:
        """The rows of ``tip.csv``: time, X, Y, x, y, sense of each; no variable where none was found."""
        return datasets.of_rows(self._reader, "tip.csv")

    @cached_property
    def frames(self) -> Frames:
        """The fields over time, as arrays and grids of PyVista.

        Raises:
            InputError: No fields were written.
        """
        return Frames(self._reader)

    @cached_property
    def maps(self) -> xr.Dataset:
        """What there is of each node at the end: activation times, repolarisation, conduction velocity.

        Over (beat, node) or (node,), with the material coordinates X, Y, Z of the nodes; NaN for none.

        Raises:
            InputError: No fields were written, or the run did not reach its end.
        """
        return datasets.of_nodes(self._reader)

    @property
    def activation_times(self) -> xr.DataArray:
        """When the potential rose through the threshold, (beat, node), NaN for never.

        Raises:
            InputError: See :attr:`maps`.
        """
        return self.maps["activation_times"]

    def export(
        self,
        format: Format = "vtkhdf",  # noqa: A002
        out: str | Path | None = None,
        **wanted: Any,
    ) -> Path:
        """Write the frames for ParaView, PyVista or meshio, see :func:`myostrain.output.exporting.export`.

        Args:
            format: "vtkhdf", "vtu" or "xdmf".
            out: Where to write; ``folder/export`` unless given.
            wanted: ``fields``, ``times``, ``deformed``, ``linear``.

        Returns:
            The file to open.

        Raises:
            InputError: There are no frames, a field or a format is not known, or nothing can be written.
        """
        return export(self.folder, format, out, **wanted)

    @property
    def rigid(self) -> Results | None:
        """The rigid twin, where the case has one (``output.rigid_twin``)."""
        twin = self.folder / "rigid"
        return open(twin, unfinished=True) if (twin / "case.toml").exists() else None

    def _lines(self) -> list[tuple[str, str]]:
        reader, results = self._reader, self.results
        state = "finished" if self.finished else "not finished"
        lines = [("folder", f"{self.folder} ({state})")]
        if results:
            took = f"{float(results['seconds']['total']):.1f} s"
            end = f"{results['time']:g} {reader.unit('time')}".strip()
            lines.append(("run", f"{results['steps']} steps to t = {end} in {took}"))
        if self.units:
            lines.append(("units", ", ".join(f"{k} {v}" for k, v in self.units.items())))
        lines.append(("probes", ", ".join(reader.probes) or "none"))
        lines.append(("frames", repr(self.frames) if reader.recorded else "none (output.fields)"))
        return lines

    def __repr__(self) -> str:
        """What ran, how far, and its metrics."""
        lines = [f"  {name:8} {text}".rstrip() for name, text in self._lines()]
        numbers = [f"  {line}" for line in repr(self.metrics).splitlines()]
        return "\n".join([f"Results: {self.title}", *lines, *numbers])

    def _repr_html_(self) -> str:
        about = table([], self._lines())
        return f"<b>{html.escape(self.title)}</b>{about}{self.metrics._repr_html_()}"
