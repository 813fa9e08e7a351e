"""Run control: clock, schedules, writers, stopping. It knows no physics."""

from __future__ import annotations

import contextlib
import json
import logging
import math
import signal
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from myostrain.coupling import Electromechanics
from myostrain.engine import MPI, lasting, versions
from myostrain.errors import ComputationError, InputError, Interrupted
from myostrain.output import results as summary
from myostrain.output.citations import citations
from myostrain.output.folder import on_first, prepare, write_json
from myostrain.output.nodal_values import FieldName, check_fields
from myostrain.output.probes import Probes
from myostrain.output.tips import Tip
from myostrain.output.units import about
from myostrain.run.checkpoint import Checkpoints, file_digests, spaces_of
from myostrain.run.interrupts import Interrupts
from myostrain.run.notebook import InNotebook, notebook_progress
from myostrain.run.record import Record, Wanted, percentages, plain_points
from myostrain.run.resume import accept, built, restoring
from myostrain.run.retries import Recovery, check_finite
from myostrain.run.schedule import Callback, CheckpointClock, Progress, Schedule, callbacks, check_times
from myostrain.state import State

log = logging.getLogger("myostrain")

#: Seconds of wall clock between checkpoints, unless given.
CHECKPOINT_SECONDS = 10.0


class Simulation(InNotebook):
    """Steps a model from time 0 to ``end``, observes it and writes a result folder.

    With a result folder a run survives: it writes checkpoints, ends between two steps when SIGINT or SIGTERM
    comes, and a later one goes on from there (``resume``).

    Args:
        model: The coupled problem; its potential holds the initial values.
        step: Time step; made a little smaller where it does not divide ``end``.
        end: Simulated time at which to stop.
        out: Result folder; None writes nothing.
        probes: Material points by name, at which activation times are taken and values recorded.
        every: Simulated time between written fields; None for a sixtieth of the run.
        fields: Which fields to write.
        expressions: UFL expressions to write by name, as means over the cells around each node.
        on_step: What is called while the run goes on, one or several: functions of this simulation, called
            at the start and after every step, or a :class:`Callback` with an interval. Like what is written,
            it sees potential and body of one time.
        title: What the pictures are called; the folder's name unless given.
        units: In which units the numbers are, by "length", "time", "stress" and "potential", for the labels
            of pictures: such as {"length": "mm"}. Those that the membrane declares need not be said.
        repolarization: Percentages of repolarisation at which the end of each beat is taken: 90 for APD90.
        tip: What a spiral's tip is, to write its trajectory on a sheet; None for none.
        electrodes: Places in space by name, outside of the body, at which ``ecg.csv`` has the potential.
        septum: Direction from the long axis of a left ventricle to the middle of its septum: strains, stretch
            and stress are measured in its 17 segments; None for no segments.
        ellipticity: "warn" looks for a loss of ellipticity of a solid where it is measured.
        checkpoint_every: Simulated time between checkpoints; None for none by simulated time.
        checkpoint_seconds: Seconds of wall clock between checkpoints, longer where one takes over a fiftieth
            of that; infinity for none by the clock.
        force: Whether results of an earlier run in ``out`` may be removed.
        resume: Whether to go on from the last checkpoint in ``out``; from time 0 if there is none.
        case: What ran, for the record: name and parameters, and the files it is from, by key.
        setup_seconds: Seconds that building the model took, for the record.

    Raises:
        InputError: A step, an end or an interval that is not positive, a probe outside the body, or a
            folder that holds something already, or is in use.
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
        expressions: Mapping[str, Any] | None = None,
        on_step: Callable[[Simulation], None]
        | Callback
        | Sequence[Callback | Callable[[Simulation], None]] = (),
        title: str = "",
        units: Mapping[str, str] | None = None,
        repolarization: float | Sequence[float] = (90.0,),
        tip: Tip | None = None,
        electrodes: Mapping[str, Sequence[float]] | None = None,
        septum: Sequence[float] | None = None,
        ellipticity: Literal["off", "warn"] = "off",
        checkpoint_every: float | None = None,
        checkpoint_seconds: float = CHECKPOINT_SECONDS,
        force: bool = False,
        resume: bool = False,
        case: Mapping[str, Any] | None = None,
        setup_seconds: float = 0.0,
    ) -> None:
        check_times(step, end, every, checkpoint_every, checkpoint_seconds)
        check_fields(fields)
        self.model, self.end = model, end
        # Whole turns of mechanics: the run ends with potential and body of one time.
        turn = model.every
        self.steps = turn * max(1, math.ceil(end / (step * turn) - 1e-9))
        self.step = end / self.steps
        self._case = dict(case or {"name": "script", "parameters": {}})
        self._setup = setup_seconds
        self._comm = lasting(model.potential.body.comm)
        self._files = file_digests(self._case.pop("files", {}), self._comm)
        self._points = probes or {}
        self.probes = Probes(model.potential.v.function_space, self._points)
        self.out = None if out is None else Path(out)
        self._lock = None
        if self.out is not None:
            self._lock = prepare(self.out, force=force, resume=resume, comm=self._comm)
        self._resume = resume and out is not None
        looks = end / 1000 if tip is None or tip.every is None else tip.every
        self._wanted = Wanted(
            probes=self.probes,
            fields=tuple(fields),
            expressions=dict(expressions or {}),
            about=about(model.potential, title, units or {}),
            fields_due=Schedule(end / 60 if every is None else every, self.step, self.steps, turn),
            probes_due=Schedule(end / 1000, self.step, self.steps, turn),
            tips_due=Schedule(looks, self.step, self.steps, turn),
            ellipticity=ellipticity == "warn",
            repolarization=percentages(repolarization),
            tip=tip,
            electrodes=dict(electrodes or {}),
            septum=septum,
        )
        self._checkpoints_due = Schedule(checkpoint_every, self.step, self.steps)
        for key, asked, schedule in (
            ("output.every", every, self._wanted.fields_due),
            ("output.tip.every", None if tip is None else tip.every, self._wanted.tips_due),
        ):
            if self.out is not None and asked is not None and schedule.rounded:
                log.warning(
                    "%s = %g is not a whole number of the steps that solve mechanics (%g); it is %g",
                    *(key, asked, self.step * turn, schedule.interval),
                )
        for number, stimulus in enumerate(getattr(model.potential, "stimuli", ()), 1):
            if (begin := getattr(stimulus, "start", 0.0)) >= end:
                log.warning("stimulus %d begins at %g: the run ends at %g, before it", number, begin, end)
        self._callbacks = [
            (each.call, Schedule(each.every or self.step * turn, self.step, self.steps, turn))
            for each in callbacks(on_step)
        ]
        for _, schedule in self._callbacks:
            if schedule.rounded:
                log.warning(
                    "a callback's interval is not a whole number of steps; it is %g", schedule.interval
                )
        self._ran = False
        self._clock = CheckpointClock(checkpoint_seconds)

    def close(self) -> None:
        """Give the result folder back; :meth:`run` does so at its end."""
        if self._lock is not None:
            self._lock.release()

    def run(
        self, progress: Progress | None = None, finish: Callable[[dict[str, Any]], None] | None = None
    ) -> dict[str, Any]:
        """Run to the end; returns what ``results.json`` holds.

        Args:
            progress: Is told how far the run is; unless given, a notebook shows a bar.
            finish: Is given the results before they are written, to add to them.

        Raises:
            ComputationError: A solver failed whatever was tried, a value became NaN, or a file cannot be
                written. What was computed stays in the folder, with ``failure.json`` in place of
                ``results.json``, and a checkpoint of the last good state.
            Interrupted: SIGINT or SIGTERM came; a checkpoint was written, as before what ``progress`` or a
                callback raises goes on to the caller.
            InputError: There are checkpoints to resume from, but none can be used.
        """
        try:
            with Interrupts(active=self.out is not None) as interrupts:
                return self._run(progress or notebook_progress(self), finish, interrupts)
        finally:
            self.close()

    def _run(self, progress: Progress | None, finish: Any, interrupts: Interrupts) -> dict[str, Any]:
        begin = time.perf_counter()
        model, out = self.model, self.out
        if self._ran and out is not None:
            raise InputError(
                f"this simulation has written {out}; make another one, with another folder", "out"
            )
        self._ran = True
        self._checkpoint_seconds = 0.0
        recovery = Recovery(model)
        checkpoints = None if out is None else Checkpoints(out, spaces_of(model))
        saved = self._saved(checkpoints)
        if saved is None:
            try:
                recovery.start()
            except ComputationError as error:
                raise self._failed(error, None, {}) from error
        else:
            with restoring():
                model.restore(saved["model"])
                recovery.resume(saved["retries"])
        setup = time.perf_counter() - begin + self._setup
        before = 0.0 if saved is None else saved["seconds"]  # spent before this process began
        first = model.steps

        def state() -> State:
            return {
                **self._what,
                "files": self._files,
                "changes": self._changes,
                "versions": versions(),
                "step": self.step,
                "model": model.state(),
                "retries": recovery.retries,
                "seconds": before + time.perf_counter() - begin + self._setup,
                **record.state(),
            }

        record = Record(model, self._wanted, out, saved)
        try:
            record.begin()
            if saved is None and (stopped := self._call(0)):
                raise stopped
            for number in range(first + 1, self.steps + 1):
                start = model.time
                recovery.step(number * self.step)
                record.observe(start, number)
                stopped = self._call(number, progress)
                self._pause(number, checkpoints, state, interrupts, stopped)
            record.finish()
        except ComputationError as error:
            failure = self._failed(error, checkpoints, state)
            record.stop()
            raise failure from error
        except Interrupted:
            record.stop()
            raise
        finally:
            record.close()
        self.activation_times = record.activation_times
        total = before + time.perf_counter() - begin + self._setup
        results = self._results(record, setup, total, recovery.retries)
        if finish is not None:
            finish(results)
        if out is not None:
            try:
                on_first(self._comm, lambda: summary.write(out, results), out / "results.json")
            except ComputationError as error:
                raise self._failed(error, None, state) from error
        return results

    def _saved(self, checkpoints: Checkpoints | None) -> State | None:
        """The state to go on from, None to begin at time 0."""
        self._what, self._changes = {}, []
        if checkpoints is None:
            return None
        self._what = {
            "case": json.loads(json.dumps(self._case["parameters"])),
            "built": built(self.model, log.info),
            "probes": plain_points(self._points),
            "electrodes": plain_points(self._wanted.electrodes),
        }
        if not self._resume:
            return None
        saved, damages = checkpoints.latest()
        for damage in damages:
            log.warning("%s; taking the one before it", damage)
        if saved is None:
            log.warning("no checkpoint in %s: beginning at time 0", self.out)
            return None
        self._changes = accept(saved, self._what, self.step, self.steps)
        for change in self._changes:
            log.warning("changed at t = %(time).6g: %(key)s is %(to)s, it was %(from)s", change)
        with restoring():
            before = dict(saved.get("files", {}))
        for key, digest in before.items():
            if self._files.get(key) != digest:
                raise InputError(
                    "the file was changed since the checkpoint; put it back, or start in another folder",
                    key,
                )
        log.info("resumed at t = %.6g, step %d", saved["model"]["time"], saved["model"]["steps"])
        return saved

    def _pause(
        self,
        number: int,
        checkpoints: Checkpoints | None,
        state: Any,
        interrupts: Interrupts,
        stopped: BaseException | None,
    ) -> None:
        """After a step: write a checkpoint where one is due, stop where a signal or the script says so."""
        noted, clock, ends = interrupts.noted, self._clock.due(), stopped is not None
        if self._comm.size > 1:
            clock = self._comm.bcast(clock, root=0)
            noted = self._comm.allreduce(noted, op=MPI.MAX)
            ends = self._comm.allreduce(ends, op=MPI.LOR)
        if checkpoints is not None and (noted or ends or clock or self._checkpoints_due.due(number)):
            begin = time.perf_counter()
            checkpoints.write(number, state())
            self._checkpoint_seconds += (spent := time.perf_counter() - begin)
            self._clock.written(spent)
        if ends:
            log.warning("the script stopped the run at t = %.6g", self.model.time)
            raise stopped or Interrupted(signal.SIGTERM, self.model.time)  # or on another process
        if checkpoints is not None and noted and number < self.steps:
            log.warning("signal %d: stopped at t = %.6g after a checkpoint", noted, self.model.time)
            raise Interrupted(noted, self.model.time)

    def _failed(
        self, error: ComputationError, checkpoints: Checkpoints | None, state: Any
    ) -> ComputationError:
        """Leave what helps to go on: a checkpoint of the last good state, and ``failure.json``."""
        failure = error if error.time is not None else error.at(self.model.time)
        log.error("%s", failure)
        if self.out is None:
            return failure
        with contextlib.suppress(ComputationError):
            if checkpoints is not None:
                check_finite(self.model)
                checkpoints.write(self.model.steps, state())
        if self._comm.rank == 0:
            record = {key: getattr(failure, key) for key in ("time", "reason", "where", "advice")}
            with contextlib.suppress(OSError):
                write_json(self.out / "failure.json", record)
        return failure

    def _call(self, number: int, progress: Progress | None = None) -> BaseException | None:
        """Tell the script of a step; what it stops the run with, None if it goes on."""
        try:
            for call, schedule in self._callbacks:
                if schedule.due(number):
                    call(self)
            if progress is not None:
                progress.update(number, self.model.time)
        except ComputationError:
            raise
        except BaseException as error:  # noqa: BLE001 - whatever the script raises
            return error
        return None

    def _results(
        self,
        record: Record,
        setup: float,
        total: float,
        retries: list[dict[str, Any]],
    ) -> dict[str, Any]:
        model = self.model
        positions = dict(zip(self.probes.names, self.probes.positions.tolist(), strict=True))
        at_probes = record.at_probes()
        beats = {name: found["activation_times"] for name, found in at_probes.items()}
        metrics, notes = summary.metrics(model, self.probes, beats)
        found = {
            "case": self._case["name"],
            "completed": True,
            "time": model.time,
            "steps": model.steps,
            "step": self.step,
            "processes": model.potential.body.comm.size,
            **summary.about_solution(model),
            "metrics": {**metrics, **record.metrics},
            "notes": {**notes, **record.notes},
            "units": {**self._wanted.about["units"], **record.units},
            "probes": {name: {"position": positions[name], **at_probes[name]} for name in self.probes.names},
            "output": self._wanted.intervals,
            "seconds": {
                "total": total,
                "setup": setup,
                "potential": model.potential.seconds,
                "mechanics": getattr(model.mechanics, "seconds", 0.0),
                "output": record.seconds,
                "checkpoints": self._checkpoint_seconds,
            },
            "retries": retries,
            "changes": self._changes,
            "parameters": self._case["parameters"],
            "citations": citations(model, self._case, electrodes=bool(self._wanted.electrodes)),
            "versions": versions(),
        }
        return summary.Outcome(found)
