"""Run control: clock, schedules, writers, stopping. It knows no physics."""

from __future__ import annotations

import csv
import math
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol, get_args

from myostrain.coupling import Electromechanics
from myostrain.engine import MPI, versions
from myostrain.errors import ComputationError, InputError, nearest
from myostrain.output import results as summary
from myostrain.output.fields import FieldName, FieldWriter
from myostrain.output.folder import prepare, write_json
from myostrain.output.probes import ActivationTimes, Probes

import numpy as np


class Progress(Protocol):
    """What is told how far a run is."""

    def update(self, step: int, time: float) -> None:
        """``step`` steps are done, the simulated time is ``time``."""
        ...


class Schedule:
    """Every so many steps, and at the last one.

    Args:
        interval: Simulated time between two; None for never but at the last step.
        step: Time step.
        last: Number of the last step.
    """

    def __init__(self, interval: float | None, step: float, last: int) -> None:
        self.every = last if interval is None else max(1, round(interval / step))
        self._last = last

    def due(self, step: int) -> bool:
        """Whether it is time after so many steps."""
        return step % self.every == 0 or step == self._last


class Simulation:
    """Steps a model from time 0 to ``end``, observes it and writes a result folder.

    Args:
        model: The coupled problem; its potential holds the initial values.
        step: Time step; made a little smaller where it does not divide ``end``.
        end: Simulated time at which to stop.
        out: Result folder; None writes nothing.
        probes: Material points by name, at which activation times are taken and values recorded.
        every: Simulated time between written fields; None for a sixtieth of the run.
        fields: Which fields to write.
        force: Whether results of an earlier run in ``out`` may be removed.
        case: What ran, for the record: name and parameters.
        setup_seconds: Seconds that building the model took, for the record.

    Raises:
        InputError: A step, an end or an interval that is not positive, a probe outside the body, or a
            folder that holds something already.
    """

    def __init__(
        self,
        model: Electromechanics,
        *,
        step: float,
        end: float,
        out: str | Path | None = None,
        probes: Mapping[str, Sequence[float]] | None = None,
        every: float | None = None,
        fields: Sequence[FieldName] = ("potential", "states", "displacement", "stress_trace"),
        force: bool = False,
        case: Mapping[str, Any] | None = None,
        setup_seconds: float = 0.0,
    ) -> None:
        for key, value in (
            ("time.step", step),
            ("time.end", end),
            ("output.every", 1.0 if every is None else every),
        ):
            if not (value > 0 and math.isfinite(value)):
                raise InputError(f"{value} is no time: give a positive number", key)
        for name in fields:
            if name not in (known := get_args(FieldName)):
                raise InputError(f"no such field; {nearest(name, known)}", "output.fields")
        if step > end:
            raise InputError(f"{step} is longer than the whole run, time.end = {end}", "time.step")
        self.model, self.end = model, end
        self.steps = max(1, math.ceil(end / step - 1e-9))
        self.step = end / self.steps
        self._case = dict(case or {"name": "script", "parameters": {}})
        self._setup = setup_seconds
        comm = model.potential.body.comm
        self.probes = Probes(model.potential.v.function_space, probes or {})
        self.out = None if out is None else prepare(Path(out), force=force, comm=comm)
        self._fields = tuple(fields)
        self._fields_due = Schedule(end / 60 if every is None else every, self.step, self.steps)
        self._probes_due = Schedule(end / 1000, self.step, self.steps)

    def run(
        self, progress: Progress | None = None, finish: Callable[[dict[str, Any]], None] | None = None
    ) -> dict[str, Any]:
        """Run to the end; returns what ``results.json`` holds.

        Args:
            progress: Is told how far the run is.
            finish: Is given the results before they are written, to add to them.

        Raises:
            ComputationError: A solver failed or a value became NaN; what was computed stays in the folder,
                with ``failure.json`` in place of ``results.json``.
        """
        begin = time.perf_counter()
        model, out = self.model, self.out
        comm = model.potential.body.comm
        writer = None
        rows = _ProbeTable(self)
        self._output_seconds = 0.0
        try:
            model.start()
            self._check()
            activation = ActivationTimes(model.potential.v, self.probes)
            setup = time.perf_counter() - begin + self._setup
            writer = FieldWriter(model, out, self._fields) if out is not None and self._fields else None
            self._write(writer, rows, 0)
            for number in range(1, self.steps + 1):
                start = model.time
                model.step(number * self.step)
                self._check()
                activation.observe(start, model.time)
                self._write(writer, rows, number)
                if progress is not None:
                    progress.update(number, model.time)
        except ComputationError as error:
            failure = error if error.time is not None else error.at(model.time)
            if out is not None and comm.rank == 0:
                write_json(
                    out / "failure.json",
                    {"time": failure.time, "reason": failure.reason, "advice": failure.advice},
                )
            raise failure from error
        finally:
            rows.close()
            if writer is not None:
                writer.close(activation.nodes if model.time >= self.end else None)
        self.activation_times = activation.nodes
        results = self._results(activation.at_probes(), setup, time.perf_counter() - begin + self._setup)
        if finish is not None:
            finish(results)
        if out is not None and comm.rank == 0:
            write_json(out / "results.json", results)
        return results

    def _check(self) -> None:
        """Stop at NaN or Inf, on all processes alike."""
        v = self.model.potential.v.x.array
        comm = self.model.potential.body.comm
        if not comm.allreduce(bool(np.isfinite(v).all()), op=MPI.LAND):
            raise ComputationError(
                "the potential is no longer finite", time=self.model.time, advice="a smaller time step."
            )

    def _write(self, writer: FieldWriter | None, rows: _ProbeTable, number: int) -> None:
        begin = time.perf_counter()
        if writer is not None and self._fields_due.due(number):
            writer.write(self.model.time)
        if self._probes_due.due(number):
            rows.add()
        self._output_seconds += time.perf_counter() - begin

    def _results(self, activation: dict[str, float | None], setup: float, total: float) -> dict[str, Any]:
        model = self.model
        mechanics = model.mechanics.seconds if model.mechanics is not None else 0.0
        positions = dict(zip(self.probes.names, self.probes.positions.tolist(), strict=True))
        return {
            "case": self._case["name"],
            "completed": True,
            "time": model.time,
            "steps": model.steps,
            "step": self.step,
            "processes": model.potential.body.comm.size,
            "scheme": {
                "name": type(model.scheme).__name__,
                **vars(model.scheme),
                "order": model.scheme.order,
            },
            "metrics": summary.metrics(model, self.probes, activation),
            "probes": {
                name: {"position": positions[name], "activation_time": activation[name]}
                for name in self.probes.names
            },
            "solver": summary.solver_counts(model),
            "seconds": {
                "total": total,
                "setup": setup,
                "potential": model.potential.seconds,
                "mechanics": mechanics,
                "output": self._output_seconds,
            },
            "cells": model.potential.body.cells,
            "unknowns": summary.unknowns(model),
            "parameters": self._case["parameters"],
            "versions": versions(),
        }


class _ProbeTable:
    """``probes.csv``: a row a sampled time, a column a probe and field; written by the first process."""

    def __init__(self, simulation: Simulation) -> None:
        self._model, self._probes = simulation.model, simulation.probes
        self._stream = None
        if simulation.out is None or not self._probes.names:
            self._active = False
            return
        self._active = True
        if self._model.potential.body.comm.rank == 0:
            self._stream = (simulation.out / "probes.csv").open("w", newline="", encoding="utf-8")
            self._csv = csv.writer(self._stream)
            names = list(self._values(headers=True))
            self._csv.writerow(
                ["time", *(f"{probe}.{name}" for probe in self._probes.names for name in names)]
            )

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
        """Add a row with the present values."""
        if not self._active:
            return
        local = np.column_stack([self._probes.local(values) for values in self._values().values()])
        table = self._probes.gather(local)
        if self._stream is not None:
            self._csv.writerow([repr(self._model.time), *(f"{value:.9g}" for value in table.reshape(-1))])
            self._stream.flush()

    def close(self) -> None:
        if self._stream is not None:
            self._stream.close()
