"""Progress on the terminal: a bar, or a line every few seconds."""

from __future__ import annotations

import time
from types import TracebackType
from typing import Any

from rich.console import Console

#: What is told to the user beside results.
errors = Console(stderr=True, soft_wrap=True, highlight=False, markup=False)

#: Seconds between two lines of progress where there is no terminal.
QUIET_INTERVAL = 5.0


class ProgressDisplay:
    """A progress bar on a terminal; elsewhere, or without a bar, a line every few seconds.

    Args:
        active: Whether to show anything (the first process does).
        bar: Whether a bar is wanted.
    """

    def __init__(self, active: bool, *, bar: bool) -> None:
        self._active = active
        self._shown = -QUIET_INTERVAL
        self._bar = None
        if active and bar and errors.is_terminal:
            from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

            self._bar = Progress(
                TextColumn("{task.description}"),
                BarColumn(),
                TextColumn("{task.fields[detail]}"),
                TimeRemainingColumn(),
                console=errors,
            )

    def __enter__(self) -> ProgressDisplay:
        """Show the bar."""
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, value: object, trace: TracebackType | None) -> None:
        """Leave the terminal as it was."""
        if self._bar is not None:
            self._bar.stop()

    def start(self, name: str, steps: int, end: float, coordinate: str = "t") -> _Track:
        """Begin to show a run of ``steps`` steps to the time ``end``, or to that place of a coordinate."""
        task = None if self._bar is None else self._bar.add_task(name, total=steps, detail="")
        lines = self._active and self._bar is None
        return _Track(self._bar, task, name, steps, end, coordinate, lines=lines)

    def computations(self, name: str, done: float, total: float, whole: str = "reproduce") -> None:
        """Show that the computation ``name`` is done, and how much of the whole that makes."""
        now = time.monotonic()
        if self._bar is not None:
            if not self._bar.tasks:
                self._bar.add_task(whole, total=total, detail="")
            self._bar.update(self._bar.task_ids[0], total=total, completed=done, detail=name)
        elif self._active and (now - self._shown >= QUIET_INTERVAL or done == total):
            errors.print(f"{100 * done / total:.0f} % done: {name}")
            self._shown = now


class _Track:
    def __init__(
        self, bar: Any, task: Any, name: str, steps: int, end: float, coordinate: str, *, lines: bool
    ) -> None:
        self._bar, self._task, self._name, self._steps, self._end = bar, task, name, steps, end
        self._coordinate, self._lines = coordinate, lines
        self._begin = self._shown = time.monotonic()

    def update(self, step: int, reached: float) -> None:
        """Show that ``step`` steps are done, to the simulated time ``reached``."""
        now = time.monotonic()
        place = f"{self._coordinate} = {reached:.4g} of {self._end:g}, step {step} of {self._steps}"
        if self._bar is not None and (now - self._shown > 0.1 or step == self._steps):
            self._bar.update(self._task, completed=step, detail=place)
            self._shown = now
        elif self._lines and now - self._shown > QUIET_INTERVAL:
            left = (now - self._begin) * (self._steps - step) / step
            errors.print(f"{self._name}: {place}, {left:.0f} s left")
            self._shown = now
