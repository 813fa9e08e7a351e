"""A case, run without a result folder: its numbers, and what was there at some times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain import cases
from myostrain.case.case import Case
from myostrain.coupling import Electromechanics
from myostrain.reproduce.jobs import Found, Job

import numpy as np


def case_job(
    name: str, overrides: Sequence[str] = (), *, frames: Sequence[float] = (), cost: float = 1.0
) -> Job:
    """The job that runs a named case.

    Args:
        name: The case.
        overrides: "KEY=VALUE", as on the command line.
        frames: Simulated times at which the fields are wanted, beside the end.
        cost: Seconds that it takes, roughly.
    """
    parameters = resolved(name, overrides)
    return Job("cases.run", {"case": parameters, "frames": list(frames)}, cost)


def resolved(name: str, overrides: Sequence[str] = ()) -> dict[str, Any]:
    """The parameters of a named case, everything resolved, without its texts; JSON."""
    case = Case.from_file(cases.path(name), overrides)
    return {key: value for key, value in case.parameters.items() if isinstance(value, Mapping)}


def run(case: Mapping[str, Any], frames: Sequence[float]) -> Found:
    """Run a case.

    Returns:
        Numbers: ``metrics``, ``activation_times`` of the probes, ``cells``, ``steps``. Arrays: ``X`` (n, dim)
        and ``cells`` (m, dim + 1), on a line in ascending order; ``times`` (frames,), ``potential``
        (frames, n) and ``u`` (frames, n, dim), the last frame at the end; ``activation`` (n,), NaN for
        never; on a sheet ``stress_trace`` (n,) at the end.
    """
    simulation = Case.from_dict(case).simulation()
    model = simulation.model
    recorder = _Recorder(model, frames)
    recorder.update(0, 0.0)
    results = simulation.run(recorder)
    recorder.take(model.time)
    space = model.potential.v.function_space
    X = space.tabulate_dof_coordinates()[:, : model.potential.body.dim]
    arrays = {
        "X": X,
        "cells": np.asarray(space.dofmap.list),
        "times": np.array(recorder.times),
        "potential": np.array(recorder.potential),
        "u": np.array(recorder.displacement),
        "activation": np.asarray(simulation.activation_times),
    }
    if model.potential.body.dim == 1:
        order = np.argsort(X[:, 0])
        arrays = {
            "X": X[order],
            "cells": np.stack([np.arange(len(X) - 1), np.arange(1, len(X))], axis=1),
            "times": arrays["times"],
            "potential": arrays["potential"][:, order],
            "u": arrays["u"][:, order],
            "activation": arrays["activation"][order],
        }
    else:
        assert model.mechanics is not None
        arrays["stress_trace"] = model.mechanics.stress_trace()
    numbers = {
        "metrics": results["metrics"],
        "activation_times": {name: probe["activation_time"] for name, probe in results["probes"].items()},
        "cells": results["cells"],
        "steps": results["steps"],
    }
    return Found(numbers, arrays)


class _Recorder:
    """Takes the fields when their times have come."""

    def __init__(self, model: Electromechanics, frames: Sequence[float]) -> None:
        self._model, self._due = model, sorted(frames)
        self.times: list[float] = []
        self.potential: list[Any] = []
        self.displacement: list[Any] = []

    def update(self, step: int, reached: float) -> None:
        if self._due and reached >= self._due[0] * (1 - 1e-9):
            self._due = [time for time in self._due if time * (1 - 1e-9) > reached]
            self.take(reached)

    def take(self, time: float) -> None:
        mechanics = self._model.mechanics
        assert mechanics is not None  # a case has one
        self.times.append(time)
        self.potential.append(self._model.potential.v.x.array.copy())
        self.displacement.append(mechanics.displacement().x.array.reshape(-1, mechanics.body.dim).copy())
