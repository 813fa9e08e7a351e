"""When something is due: every so much simulated time, in whole numbers of steps."""

from __future__ import annotations

import inspect
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from myostrain.errors import InputError, shown


class Progress(Protocol):
    """What is told how far a run is."""

    def update(self, step: int, time: float) -> None:
        """``step`` steps are done, the simulated time is ``time``."""
        ...


class Schedule:
    """Every so many steps, and at the last one.

    Where mechanics is solved every few steps, only those steps count: what is written is of one time.

    Args:
        interval: Simulated time between two; None for never but at the last step.
        step: Time step.
        last: Number of the last step.
        unit: Steps between two at which something can be due.

    Attributes:
        every: Steps between two.
        interval: Simulated time between two as it is, a whole number of steps; what was asked for is rounded.
    """

    def __init__(self, interval: float | None, step: float, last: int, unit: int = 1) -> None:
        self._asked = interval
        self.every = last if interval is None else unit * max(1, round(interval / (step * unit)))
        self.interval = self.every * step
        self._last = last

    @property
    def rounded(self) -> bool:
        """Whether the interval is another one than was asked for."""
        return self._asked is not None and abs(self.interval - self._asked) > 1e-6 * self._asked

    def due(self, step: int) -> bool:
        """Whether it is time after so many steps."""
        return step % self.every == 0 or step == self._last


class CheckpointClock:
    """Says when a checkpoint is due by the wall clock.

    Args:
        seconds: Between two; longer where a checkpoint takes over a fiftieth of that.
    """

    def __init__(self, seconds: float) -> None:
        self._seconds = self._interval = seconds
        self._last = time.monotonic()

    def due(self) -> bool:
        """Whether it is time."""
        return time.monotonic() - self._last >= self._interval

    def written(self, cost: float) -> None:
        """A checkpoint was written, in so many seconds."""
        self._interval = max(self._seconds, 50 * cost)
        self._last = time.monotonic()


@dataclass(frozen=True)
class Callback:
    """Something to be called while a run goes on.

    Args:
        call: Is given the simulation, at the start and after steps; its model has the present state.
        every: Simulated time between two calls; None for every step.
    """

    call: Callable[[Any], None]
    every: float | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot be called, and an interval that is none."""
        if not callable(self.call):
            raise InputError(f"Callback.call: give a function of the simulation, not {shown(self.call)}")
        if self.every is not None and not 0 < self.every < math.inf:
            raise InputError(
                f"Callback.every: give a positive time, or None for every step, not {self.every}"
            )


def callbacks(given: Any) -> list[Callback]:
    """What a script gives, a function or callback or several, as callbacks.

    Raises:
        InputError: One cannot be called with a simulation alone.
    """
    each = list(given) if isinstance(given, Sequence) and not isinstance(given, str) else [given]
    made = [one if isinstance(one, Callback) else Callback(one) for one in each]
    for callback in made:
        try:
            inspect.signature(callback.call).bind(None)
        except TypeError as error:
            raise InputError(
                f"{_name(callback.call)} is called with the simulation and nothing else ({error}); write it "
                "as def watch(simulation): ...",
                "on_step",
            ) from None
        except ValueError:
            continue  # built in, without a signature
    return made


def _name(function: Any) -> str:
    return str(getattr(function, "__qualname__", type(function).__qualname__))


def check_times(
    step: float, end: float, every: float | None, checkpoint_every: float | None, checkpoint_seconds: float
) -> None:
    """Refuse a step, an end or intervals that are none.

    Raises:
        InputError: One is not positive, or the step is longer than the run.
    """
    for key, value in (
        ("time.step", step),
        ("time.end", end),
        ("output.every", 1.0 if every is None else every),
        ("output.checkpoint_every", 1.0 if checkpoint_every is None else checkpoint_every),
    ):
        if not (value > 0 and math.isfinite(value)):
            raise InputError(f"{value} is not a time: give a positive number", key)
    if not checkpoint_seconds > 0:
        raise InputError(f"{checkpoint_seconds}: give a positive number", "output.checkpoint_seconds")
    if step > end:
        raise InputError(f"{step} is longer than the whole run, time.end = {end}", "time.step")
