"""``probes.csv``: a row a sampled time, a column a probe and field."""

from __future__ import annotations

import csv
import os
from pathlib import Path
from typing import Any

from myostrain.coupling import Electromechanics
from myostrain.engine import lasting
from myostrain.errors import InputError
from myostrain.output.folder import on_first
from myostrain.output.probes import Probes

import numpy as np


class ProbeTable:
    """Writes the table; the first process does.

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
        self._comm = lasting(model.potential.body.comm)
        self._active = folder is not None and bool(probes.names)
        self._stream: Any = None
        if folder is None or not probes.names:
            return
        path = folder / "probes.csv"
        self._path = path
        if size is not None:
            found = self._comm.bcast(path.stat().st_size if self._first and path.exists() else 0, root=0)
            if found < size:
                raise InputError(
                    f"{path} is shorter than when the checkpoint was written; put it back, or run anew",
                    "--resume",
                )

        def begin() -> None:
            self._stream = path.open("a" if size is not None else "w", newline="", encoding="utf-8")
            if size is not None:
                self._stream.truncate(size)
                return
            names = list(self._values(headers=True))
            columns = (f"{probe}.{name}" for probe in probes.names for name in names)
            csv.writer(self._stream).writerow(["time", *columns])
            self._stream.flush()

        on_first(self._comm, begin, path)

    @property
    def _first(self) -> bool:
        return bool(self._comm.rank == 0)

    def _values(self, *, headers: bool = False) -> dict[str, Any]:
        """Nodal values by column name."""
        model = self._model
        values: dict[str, Any] = {f.name: f.x.array for f in model.potential.fields}
        if model.mechanics is not None:
            dim = model.potential.body.dim
            u = None if headers else model.mechanics.displacement().x.array.reshape(-1, dim)
            for i, axis in enumerate("xyz"[:dim]):
                values[f"displacement_{axis}"] = None if u is None else u[:, i]
        return values

    def add(self) -> None:
        """Add a row with the present values (collective).

        Raises:
            ComputationError: It cannot be written.
        """
        if not self._active:
            return
        local = np.column_stack([self._probes.local(values) for values in self._values().values()])
        table = self._probes.gather(local)

        def write() -> None:
            row = [repr(self._model.time), *(f"{value:.9g}" for value in table.reshape(-1))]
            csv.writer(self._stream).writerow(row)
            self._stream.flush()

        on_first(self._comm, write, self._path)

    def size(self) -> int | None:
        """Bytes written so far, safely on the disk (collective); None where there is no table."""
        if not self._active:
            return None
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
