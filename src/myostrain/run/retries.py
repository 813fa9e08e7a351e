"""A step that failed is taken again, from the last good state, with more care each time."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from typing import Any

from myostrain.coupling import Electromechanics
from myostrain.electrics.given_potential import GivenPotential
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

#: The only one where time has no part in it: smaller steps are the smaller loads that mechanics has tried.
STATIC_REMEDIES = (("direct solvers with pivoting", 1, True, True),)


class Recovery:
    """Takes steps of a model; one that fails is tried again by the remedies above, in turn.

    Where mechanics is solved every few steps, it goes back to where potential and body were of one time,
    and takes all steps from there with mechanics in each: a smaller step of the potential alone would not
    help the body.

    Args:
        model: The coupled problem.

    Attributes:
        retries: What was tried again: time, reason and remedy, and whether it helped.
    """

    def __init__(self, model: Electromechanics) -> None:
        self.model = model
        self.retries: list[dict[str, Any]] = []
        self._good: State | None = None  # where the last turn of mechanics began

    def start(self) -> None:
        """Find the model's initial configuration, by direct solvers if the chosen ones fail.

        Raises:
            ComputationError: There is none, or a value is not finite.
        """
        self._good = None
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

    def resume(self, retries: list[dict[str, Any]]) -> None:
        """Go on with a model that was restored, after these retries."""
        self.retries, self._good = retries, None

    def step(self, end: float) -> None:
        """Advance the model to the time ``end``.

        Raises:
            ComputationError: No remedy helped. The model is then at its last good state.
        """
        if self._good is None or self.model.in_step:
            self._good = self.model.state()
        good = self._good
        steps = self.model.steps + 1
        try:
            self.model.step(end)
            check_finite(self.model)
        except ComputationError as error:
            first = error
        else:
            return
        for remedy in self._remedies():
            self.model.restore(good)
            check_finite(self.model)  # nothing can be done if it was not before
            record = {"time": good["time"], "reason": first.reason, "remedy": remedy[0], "helped": False}
            self.retries.append(record)
            log.warning("step from t = %.6g failed (%s); trying %s", good["time"], first.reason, remedy[0])
            try:
                self._carefully(good, end, steps, *remedy[1:])
            except ComputationError:
                continue
            record["helped"] = True
            self._good = None
            return
        self.model.restore(good)
        raise first if first.time is not None else first.at(good["time"])

    def _remedies(self) -> tuple[tuple[str, int, bool, bool], ...]:
        """What to try: where time has no part in it, no more than another solver, if it is another one."""
        mechanics = self.model.mechanics
        if mechanics is None or not self._static():
            return REMEDIES
        return () if mechanics.solver.pivots else STATIC_REMEDIES

    def _static(self) -> bool:
        """Whether the body follows loads and activation at once, and both are given over time."""
        potential: Any = self.model.potential
        mechanics, activation = self.model.mechanics, self.model.activation
        if not isinstance(potential, GivenPotential) or mechanics is None or activation is None:
            return False
        law = activation.law
        alone = not getattr(law, "states", ()) and "stretch" not in law.drivers
        return alone and mechanics.jumps and not mechanics.cavities.numbers.size

    def _carefully(self, good: State, end: float, steps: int, pieces: int, fresh: bool, direct: bool) -> None:
        """Take all steps from the good state in pieces, with mechanics in each."""
        model, start = self.model, good["time"]
        count = pieces * (steps - good["steps"])
        if fresh:
            for part in self._parts():
                part.solver.forget()
        with self._direct_solvers() if direct else nullcontext():
            for piece in range(1, count + 1):
                model.step(end if piece == count else start + (end - start) * piece / count, mechanics=True)
                check_finite(model)
        model.steps = steps

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
    space = model.potential.v.function_space
    fields = [(name, space, values) for name, values in model.potential.field_values().items()]
    if model.mechanics is not None and model.activation is not None:
        fields.append(("activation", space, model.activation.values))
        fields.append(("displacement", model.mechanics.u.function_space, model.mechanics.u.x.array))
    comm = lasting(model.potential.body.comm)
    # A sum is finite if all its terms are, but for an overflow, which is a failure too.
    fine = all(np.isfinite(values.sum()) for _, _, values in fields)
    if comm.allreduce(bool(fine), op=MPI.LAND):
        return
    for name, space, values in fields:
        if comm.allreduce(bool(np.isfinite(values.sum())), op=MPI.LAND):
            continue
        where = place_of_largest(space, values)
        raise ComputationError(
            f"the {name} is no longer finite near {where}",
            time=model.time,
            where=where,
            advice="a smaller time step.",
        )
