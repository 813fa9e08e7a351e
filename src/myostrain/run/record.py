"""What a run observes and writes while it goes on, beside its checkpoints."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from myostrain.coupling import Electromechanics
from myostrain.errors import InputError, shown
from myostrain.output.conduction import conduction_velocity
from myostrain.output.electrodes import ElectrodeTable
from myostrain.output.fields import FieldWriter
from myostrain.output.loops import LoopTable, units_of_loops
from myostrain.output.nodal_values import FieldName
from myostrain.output.probes import ActivationTimes, Probes
from myostrain.output.results import wave_metrics
from myostrain.output.table import MeasureTable, ProbeTable
from myostrain.output.tips import Tip, TipTable
from myostrain.output.units import resting_potential
from myostrain.run.resume import restoring
from myostrain.run.schedule import Schedule
from myostrain.state import State


@dataclass(frozen=True)
class Wanted:
    """What is to be observed and written, and when.

    Args:
        probes: The probes.
        fields: Fields to write.
        expressions: UFL expressions to write, by name.
        about: What pictures have to know of the run.
        fields_due: When fields are written and measures taken.
        probes_due: When probes and electrodes are sampled.
        tips_due: When tips are looked for.
        ellipticity: Whether to look for a loss of ellipticity.
        repolarization: Percentages at which beats end.
        tip: What a tip is; None for none.
        electrodes: Places of electrodes by name.
        septum: Direction from the long axis of a left ventricle to its septum; None for no segments.
    """

    probes: Probes
    fields: tuple[FieldName, ...]
    expressions: Mapping[str, Any]
    about: Mapping[str, Any]
    fields_due: Schedule
    probes_due: Schedule
    tips_due: Schedule
    ellipticity: bool
    repolarization: Sequence[float]
    tip: Tip | None
    electrodes: Mapping[str, Sequence[float]]
    septum: Sequence[float] | None

    @property
    def intervals(self) -> dict[str, float]:
        """Simulated time between written fields, and between samples of the probes."""
        return {"every": self.fields_due.interval, "probes_every": self.probes_due.interval}


class Record:
    """Observes a model step by step, and writes frames and tables; all methods are collective.

    Args:
        model: The coupled problem, at its start or restored.
        wanted: What to observe and to write.
        out: The result folder; None writes nothing.
        saved: State of an earlier run's record to go on from; None begins at the present time.

    Raises:
        InputError: An earlier table is shorter than it was, or what is wanted does not fit the model.

    Attributes:
        seconds: Wall-clock seconds spent in writing.
    """

    def __init__(
        self, model: Electromechanics, wanted: Wanted, out: Path | None, saved: State | None = None
    ) -> None:
        self._model, self._wanted, self._out = model, wanted, out
        potential, before = model.potential, saved or {}
        rest = resting_potential(potential)
        self._activation = ActivationTimes(
            potential.v, wanted.probes, potential.threshold, wanted.repolarization, rest
        )
        if saved is None:
            self._activation.start()
        else:
            with restoring():
                self._activation.restore(saved["activation"])
        self._writer: FieldWriter | None = None
        self._rows = ProbeTable(model, wanted.probes, out, before.get("table"))
        self._measures = MeasureTable(
            model,
            out,
            ellipticity=wanted.ellipticity,
            septum=wanted.septum,
            saved=before.get("measures"),
        )
        self._tips = None if wanted.tip is None else TipTable(model, wanted.tip, out, before.get("tips"))
        self._ecg: ElectrodeTable | None = None
        if wanted.electrodes:
            self._ecg = ElectrodeTable(model, wanted.electrodes, out, before.get("ecg"))
        self._loops: LoopTable | None = None
        if model.mechanics is not None and model.mechanics.cavities.names:
            self._loops = LoopTable(model, out, before.get("loops"))
        self._resumed, self.seconds = saved is not None, 0.0

    def begin(self) -> None:
        """Begin the frames, and write what is due at the start.

        Raises:
            ComputationError: Something cannot be written.
        """
        wanted = self._wanted
        if self._out is not None and (wanted.fields or wanted.expressions):
            self._writer = FieldWriter(
                self._model,
                self._out,
                wanted.fields,
                wanted.about,
                wanted.expressions,
                lambda: self._activation.nodes,
            )
            self._writer.truncate(self._model.steps if self._resumed else -1)
        if not self._resumed:
            self._write(0)

    def observe(self, start: float, number: int) -> None:
        """Look at the model after its step of this number, which began at ``start``, and write what is due.

        Raises:
            ComputationError: Something cannot be written.
        """
        model = self._model
        if self._tips is not None and self._wanted.tips_due.due(number):
            self._tips.add(self._activation.before, model.time - start)
        self._activation.observe(start, model.time)
        self._write(number)

    def _write(self, number: int) -> None:
        begin = time.perf_counter()
        if self._loops is not None and self._model.in_step:
            self._loops.add()
        if self._wanted.fields_due.due(number):
            if self._writer is not None:
                self._writer.write(number, self._model.time)
            self._measures.add()
        if self._wanted.probes_due.due(number):
            self._rows.add()
            if self._ecg is not None:
                self._ecg.add()
        self.seconds += time.perf_counter() - begin

    def state(self) -> State:
        """What goes on in a resumed run."""
        return {
            "activation": self._activation.state(),
            "table": self._rows.size(),
            "measures": self._measures.state(),
            "tips": None if self._tips is None else self._tips.state(),
            "ecg": None if self._ecg is None else self._ecg.size(),
            "loops": None if self._loops is None else self._loops.state(),
        }

    def finish(self) -> None:
        """The run has reached its end: write maps of the nodes, and the frames for ParaView.

        Raises:
            ComputationError: They cannot be written.
        """
        activation = self._activation
        beats, self.activation_times = activation.beats(), activation.nodes
        ends = activation.repolarizations()
        velocity = conduction_velocity(self._model.potential.v.function_space, beats[0])
        self.metrics = {
            **wave_metrics(self._model.potential, beats, ends, velocity),
            **({} if self._tips is None else self._tips.metrics()),
            **self._measures.metrics(),
            **(loops := {} if self._loops is None else self._loops.metrics()),
        }
        self.units = units_of_loops(list(loops), self._wanted.about["units"])
        self.notes = {} if self._tips is None else self._tips.notes()
        if self._writer is not None:
            maps = {"activation_times": beats, "conduction_velocity": velocity[None]}
            maps |= {f"repolarization_times_{p:g}": times for p, times in ends.items()}
            writer, self._writer = self._writer, None
            writer.close(maps)

    def at_probes(self) -> dict[str, dict[str, Any]]:
        """By probe its beats: times of activation and durations."""
        times = self._activation.at_probes()
        found: dict[str, dict[str, Any]] = {
            name: {"activation_time": next(iter(beats), None), "activation_times": beats}
            for name, beats in times.items()
        }
        for percent, durations in self._activation.durations_at_probes().items():
            for name, beats in durations.items():
                found[name][f"apd{percent:g}"] = beats
        return found

    def stop(self) -> None:
        """The run ends before its time: make the frames that there are fit for ParaView."""
        if self._writer is not None:
            self._writer.close(None)

    def close(self) -> None:
        """Close the tables."""
        for table in (self._rows, self._measures, self._tips, self._ecg, self._loops):
            if table is not None:
                table.close()


def percentages(given: float | Sequence[float]) -> tuple[float, ...]:
    """Percentages of repolarisation, each once.

    Raises:
        InputError: One is none.
    """
    percents: list[Any] = [given] if isinstance(given, int | float) else list(given)
    for percent in percents:
        if not (isinstance(percent, int | float) and 0 < percent < 100):
            raise InputError(
                f"give percentages between 0 and 100, such as 90, not {shown(percent)}",
                "output.repolarization",
            )
    return tuple(dict.fromkeys(float(percent) for percent in percents))


def plain_points(points: Mapping[str, Sequence[float]]) -> dict[str, list[float]]:
    """Points by name, as JSON can hold them."""
    return {name: list(map(float, point)) for name, point in points.items()}
