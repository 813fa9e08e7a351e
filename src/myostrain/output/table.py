"""Tables that grow with a run: ``probes.csv`` and ``measures.csv``, one row per sampled time."""

from __future__ import annotations

import csv
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from myostrain.engine import lasting
from myostrain.errors import InputError
from myostrain.mechanics.cavities import CavityPressures
from myostrain.mechanics.ellipticity import EllipticityMonitor
from myostrain.mechanics.reactions import Reactions
from myostrain.output.folder import on_first
from myostrain.output.manifest import claim
from myostrain.output.measures import Measures
from myostrain.output.peaks import Peaks
from myostrain.output.probes import Probes
from myostrain.state import State

import numpy as np

if TYPE_CHECKING:
    from myostrain.coupling import Electromechanics


class Table:
    """A CSV file to which rows are added; the first process writes, all methods are collective.

    Args:
        path: The file.
        columns: Names of its columns.
        comm: MPI communicator, one that lasts.
        size: Bytes of an earlier run's file to keep and go on from; None begins anew.

    Raises:
        InputError: The earlier file is shorter than that.
    """

    def __init__(self, path: Path, columns: Sequence[str], comm: Any, size: int | None = None) -> None:
        self._path, self._comm = path, comm
        self._stream: Any = None
        if size is not None:
            found = comm.bcast(path.stat().st_size if comm.rank == 0 and path.exists() else 0, root=0)
            if found < size:
                raise InputError(
                    f"{path} is shorter than when the checkpoint was written; put it back, or run it again",
                    "--resume",
                )

        def begin() -> None:
            claim(path)
            self._stream = path.open("a" if size is not None else "w", newline="", encoding="utf-8")
            if size is not None:
                self._stream.truncate(size)
                return
            csv.writer(self._stream).writerow(columns)
            self._stream.flush()

        on_first(comm, begin, path)

    def add(self, time: float, values: Sequence[float]) -> None:
        """Add a row.

        Raises:
            ComputationError: It cannot be written.
        """
        self.add_rows(time, [values])

    def add_rows(self, time: float, rows: Sequence[Sequence[float]]) -> None:
        """Add any number of rows of one time; those of the first process count.

        Raises:
            ComputationError: They cannot be written.
        """

        def write() -> None:
            writer = csv.writer(self._stream)
            writer.writerows([repr(time), *(f"{value:.9g}" for value in row)] for row in rows)
            self._stream.flush()

        on_first(self._comm, write, self._path)

    def size(self) -> int:
        """Bytes written so far, safely on the disk."""
        found = [0]

        def sync() -> None:
            os.fsync(self._stream.fileno())
            found[0] = os.fstat(self._stream.fileno()).st_size

        on_first(self._comm, sync, self._path)
        return int(self._comm.bcast(found[0], root=0))

    def close(self) -> None:
        """Close the file."""
        if self._stream is not None:
            try:
                self._stream.close()
            except OSError:  # what a full disk kept in the buffer
                self._stream = None


class ProbeTable:
    """``probes.csv``: one column per probe and field.

    Args:
        model: The coupled problem.
        probes: The probes.
        folder: The result folder; None writes nothing.
        size: Bytes of an earlier run's table to keep and go on from; None begins anew.

    Raises:
        InputError: The earlier table is shorter than that.
    """

    def __init__(
        self, model: Electromechanics, probes: Probes, folder: Path | None, size: int | None = None
    ) -> None:
        self._model, self._probes = model, probes
        self._table: Table | None = None
        if folder is not None and probes.names:
            names = list(self._values(headers=True))
            columns = [f"{probe}_{name}" for probe in probes.names for name in names]
            comm = lasting(model.potential.body.comm)
            self._table = Table(folder / "probes.csv", ["time", *columns], comm, size)

    def _values(self, *, headers: bool = False) -> dict[str, Any]:
        """Values at this process's probes by column name."""
        model, local = self._model, self._probes.local
        values: dict[str, Any] = dict(model.potential.field_values())
        if model.activation is not None:
            values["activation"] = model.activation.values
        values = {name: None if headers else local(nodal) for name, nodal in values.items()}
        if model.mechanics is not None:
            u = None if headers else self._displacement()
            for i, axis in enumerate("xyz"[: model.potential.body.dim]):
                values[f"displacement_{axis}"] = None if u is None else u[:, i]
        return values

    def _displacement(self) -> Any:
        """The displacement at this process's probes, (points, dim), quadratic where mechanics' is."""
        model, mechanics = self._model, self._model.mechanics
        assert mechanics is not None
        if mechanics.kinematics.degree > 1 and mechanics.body is model.potential.body:
            return self._probes.evaluated(
                mechanics.u.sub(0) if mechanics.kinematics.has_pressure else mechanics.u
            )
        return self._probes.local(model.transfer.displacement().x.array.reshape(-1, mechanics.body.dim))

    def add(self) -> None:
        """Add a row with the present values (collective).

        Raises:
            ComputationError: It cannot be written.
        """
        if self._table is None:
            return
        local = np.column_stack(list(self._values().values()))
        self._table.add(self._model.time, self._probes.gather(local).reshape(-1).tolist())

    def size(self) -> int | None:
        """Bytes written so far, safely on the disk (collective); None where there is no table."""
        return None if self._table is None else self._table.size()

    def close(self) -> None:
        """Close the file."""
        if self._table is not None:
            self._table.close()


class MeasureTable:
    """``measures.csv``: one column per measured quantity or reaction, and what metrics say of them.

    Args:
        model: The coupled problem; of what is not a solid only reactions of supports are measured.
        folder: The result folder; None writes nothing.
        ellipticity: Whether to look for a loss of ellipticity too.
        septum: Where the septum of a left ventricle is, see :class:`~myostrain.output.measures.Measures`.
        saved: State of an earlier run to go on from; None begins anew.

    Raises:
        InputError: The earlier table is shorter than it was, or ellipticity is asked for and the body is no
                solid.
    """

    def __init__(
        self,
        model: Electromechanics,
        folder: Path | None,
        *,
        ellipticity: bool = False,
        septum: Sequence[float] | None = None,
        saved: State | None = None,
    ) -> None:
        self._model = model
        mechanics, comm = model.mechanics, lasting(model.potential.body.comm)
        self._sources: list[Measures | EllipticityMonitor | Reactions | CavityPressures] = []
        if mechanics is not None and ellipticity:
            self._sources.append(EllipticityMonitor(mechanics))
        if mechanics is not None and mechanics.body.dim == 3:
            self._sources.insert(0, Measures(mechanics, septum))
        elif septum is not None:
            raise InputError("segments are those of a solid that deforms; leave it out", "output.septum")
        if mechanics is not None and mechanics.reactions.names and not mechanics.held(np.inf):
            self._sources.append(mechanics.reactions)
        if mechanics is not None and mechanics.cavities.names:
            self._sources.append(mechanics.cavities)
        self._last: dict[str, float] = saved["last"] if saved else {}
        self._peaks = Peaks(saved["peaks"] if saved else {})
        self._table: Table | None = None
        if folder is not None and self._sources:
            columns = [name for source in self._sources for name in source.names]
            size = saved["size"] if saved else None
            self._table = Table(folder / "measures.csv", ["time", *columns], comm, size)

    def add(self) -> None:
        """Measure the present configuration and add a row (collective).

        Raises:
            ComputationError: It cannot be written.
        """
        if not self._sources:
            return
        self._last = {k: value for source in self._sources for k, value in source.values().items()}
        self._peaks.observe(self._last)
        if self._table is not None:
            self._table.add(self._model.time, list(self._last.values()))

    def metrics(self) -> dict[str, float]:
        """The values of the last row, and :class:`~myostrain.output.peaks.Peaks`, which win."""
        return {**self._last, **self._peaks.found}

    def state(self) -> State:
        """What goes on in a resumed run (collective)."""
        size = None if self._table is None else self._table.size()
        return {"size": size, "last": self._last, "peaks": self._peaks.found}

    def close(self) -> None:
        """Close the file."""
        if self._table is not None:
            self._table.close()
