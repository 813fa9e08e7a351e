"""A step that failed is taken again, from the last good state, with more care each time."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from typing import Any

from myostrain.coupling import Electromechanics
from myostrain.engine import MPI, lasting
from myostrain.errors import ComputationError
from myostrain.solvers.linear import place_of_largest
from myostrain.state import State

import numpy as np

log = logging.getLogger("myostrain")

#: Remedies in their order: what is said of it, into how many steps, fresh factorizations, direct solvers.
REMEDIES = (
    ("2 steps of half the size", 2, False, False),
    ("4 steps of a quarter of the size", 4, False, False),
    ("4 steps, fresh factorizations", 4, True, False),
    ("16 steps, direct solvers with pivoting", 16, True, True),
)


class Recovery:
    """Takes steps of a model; one that fails is tried again by the remedies above, in turn.

    Args:
        model: The coupled problem.

    Attributes:
        retries: What was tried again: time, reason and remedy, and whether it helped.
    """

    def __init__(self, model: Electromechanics) -> None:
        self.model = model
        self.retries: list[dict[str, Any]] = []

    def start(self) -> None:
        """Find the model's initial configuration, by direct solvers if the chosen ones fail.

        Raises:
            ComputationError: There is none, or a value is not finite.
        """
        try:
            self.model.start()
        except ComputationError as error:
            remedy = "direct solvers with pivoting"
            record = {"time": 0.0, "reason": error.reason, "remedy": remedy, "helped": False}
            self.retries.append(record)
            log.warning("the start failed (%s); trying %s", error.reason, remedy)
            with self._direct_solvers():
                try:
                    self.model.start()
                except ComputationError:
                    raise error from None
            record["helped"] = True
        check_finite(self.model)

    def step(self, end: float) -> None:
        """Advance the model to the time ``end``.

        Raises:
            ComputationError: No remedy helped. The model is then at its last good state.
        """
        good = self.model.state()
        try:
            self.model.step(end)
            check_finite(self.model)
        except ComputationError as error:
            first = error
        else:
            return
        for remedy in REMEDIES:
            self.model.restore(good)
            check_finite(self.model)  # nothing can be done if it was not before
            record = {"time": good["time"], "reason": first.reason, "remedy": remedy[0], "helped": False}
            self.retries.append(record)
            log.warning("step from t = %.6g failed (%s); trying %s", good["time"], first.reason, remedy[0])
            try:
                self._carefully(good, end, *remedy[1:])
            except ComputationError:
                continue
            record["helped"] = True
            return
        self.model.restore(good)
        raise first if first.time is not None else first.at(good["time"])

    def _carefully(self, good: State, end: float, pieces: int, fresh: bool, direct: bool) -> None:
        model, start = self.model, good["time"]
        if fresh:
            for part in self._parts():
                part.solver.forget()
        with self._direct_solvers() if direct else nullcontext():
            for piece in range(1, pieces + 1):
                model.step(end if piece == pieces else start + (end - start) * piece / pieces)
                check_finite(model)
        model.steps = good["steps"] + 1

    def _parts(self) -> list[Any]:
        parts: tuple[Any, ...] = (self.model.potential, self.model.mechanics)
        return [part for part in parts if part is not None and part.solver is not None]

    @contextmanager
    def _direct_solvers(self) -> Iterator[None]:
        with ExitStack() as stack:
            for part in self._parts():
                stack.enter_context(part.solver.direct_solver())
            yield


def check_finite(model: Electromechanics) -> None:
    """Refuse NaN and Inf in the potential, the states and the displacement, on all processes alike.

    Raises:
        ComputationError: There is one, with the place.
    """
    functions = list(model.potential.fields)
    if model.mechanics is not None:
        functions.append(model.mechanics.u)
    comm = lasting(model.potential.body.comm)
    # A sum is finite if all its terms are, but for an overflow, which is a failure too.
    fine = all(np.isfinite(function.x.array.sum()) for function in functions)
    if comm.allreduce(bool(fine), op=MPI.LAND):
        return
    for function in functions:
        if comm.allreduce(bool(np.isfinite(function.x.array.sum())), op=MPI.LAND):
            continue
        where = place_of_largest(function.function_space, function.x.array)
        raise ComputationError(
            f"the {function.name} is no longer finite near {where}",
            time=model.time,
            where=where,
            advice="a smaller time step.",
        )
