"""Pressure–volume loops of cavities: ``cavities.csv``, one row per solve, and what a beat gives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from myostrain.engine import lasting
from myostrain.output.quantities import attributes
from myostrain.output.table import Table
from myostrain.state import State

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from myostrain.coupling import Electromechanics

Array = npt.NDArray[np.float64]


class LoopTable:
    """``cavities.csv``: volume and pressure of each cavity, then the states of the circulation.

    Args:
        model: The coupled problem, whose mechanics has cavities.
        folder: The result folder; None writes nothing.
        saved: State of an earlier run to go on from; None begins anew.

    Raises:
        InputError: The earlier table is shorter than it was.
    """

    def __init__(self, model: Electromechanics, folder: Path | None, saved: State | None = None) -> None:
        assert model.mechanics is not None
        self._model, self._cavities = model, model.mechanics.cavities
        self._rows: list[list[float]] = [] if saved is None else [list(row) for row in saved["rows"]]
        self._table: Table | None = None
        if folder is not None:
            columns, comm = ["time", *self._cavities.names], lasting(model.potential.body.comm)
            self._table = Table(folder / "cavities.csv", columns, comm, saved["size"] if saved else None)

    def add(self) -> None:
        """Add a row with the present values (collective).

        Raises:
            ComputationError: It cannot be written.
        """
        values = list(self._cavities.values().values())
        self._rows.append([self._model.time, *values])
        if self._table is not None:
            self._table.add(self._model.time, values)

    def metrics(self) -> dict[str, float]:
        """What the last beat gives, see :func:`loop_numbers`; of several cavities each with its name."""
        rows, names = np.array(self._rows), self._cavities.cavities
        found: dict[str, float] = {}
        for number, name in enumerate(names):
            volume, pressure = rows[:, 1 + 2 * number], rows[:, 2 + 2 * number]
            numbers = loop_numbers(rows[:, 0], volume, pressure, self._cavities.beats)
            found |= {key if len(names) == 1 else f"{key}_{name}": value for key, value in numbers.items()}
        return found

    def state(self) -> State:
        """What goes on in a resumed run (collective)."""
        return {"size": None if self._table is None else self._table.size(), "rows": list(self._rows)}

    def close(self) -> None:
        """Close the file."""
        if self._table is not None:
            self._table.close()


def loop_numbers(time: Array, volume: Array, pressure: Array, beats: int) -> dict[str, float]:
    """What the last beat of a cavity gives, and how far it is from the one before.

    - ``volume_max``, ``volume_min``: of the beat; ``stroke_volume`` their difference, ``ejection_fraction``
      that over the former;
    - ``stroke_work``: −∮ p dV, what the wall does on the blood, by the trapezoidal rule;
    - ``pressure_max``, and ``dpdt_max``, the greatest rise between two rows over their time;
    - ``stroke_volume_change``: relative change of the stroke volume since the beat before, if there is one.

    Args:
        time: Times (n,), ascending.
        volume: Volumes (n,).
        pressure: Pressures (n,).
        beats: Number of beats of equal length in the run.
    """
    begins = np.linspace(time[0], time[-1], beats + 1)[:-1]
    nearly = 1e-9 * (time[-1] - time[0])
    last = time >= begins[-1] - nearly
    V, p, t = volume[last], pressure[last], time[last]
    stroke = float(np.ptp(V))
    found = {
        "volume_max": float(V.max()),
        "volume_min": float(V.min()),
        "stroke_volume": stroke,
        "ejection_fraction": stroke / float(V.max()),
        "stroke_work": float(-((p[1:] + p[:-1]) / 2 * np.diff(V)).sum()),
        "pressure_max": float(p.max()),
        "dpdt_max": float((np.diff(p) / np.diff(t)).max(initial=0.0)),
    }
    if beats > 1:
        former = (time >= begins[-2] - nearly) & (time <= begins[-1] + nearly)
        before = float(np.ptp(volume[former]))
        found["stroke_volume_change"] = abs(stroke / before - 1) if before else 0.0
    return found


def units_of_loops(names: Sequence[str], units: Mapping[str, str]) -> dict[str, str]:
    """Units of what :meth:`LoopTable.metrics` gives, where those of the run are known."""
    found = {name: attributes(name, units, 3).get("units") for name in names}
    return {name: unit for name, unit in found.items() if unit is not None}
