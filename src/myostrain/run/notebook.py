"""A simulation in a notebook: what it is as a table, and how far it is as a bar."""

from __future__ import annotations

import html
import sys
import time
from typing import Any

from myostrain.validation import shown_in_notebook

#: Seconds between two looks of the bar.
INTERVAL = 0.2


class InNotebook:
    """How a simulation is shown."""

    def __repr__(self) -> str:
        """What runs, how far, and where to."""
        me: Any = self
        return (
            f"Simulation({me.model!r}, step={me.step:.6g}, end={me.end:.6g}, steps={me.steps}, "
            f"out={None if me.out is None else str(me.out)!r})"
        )

    def _repr_html_(self) -> str:
        me: Any = self
        rows = {
            "model": repr(me.model),
            "time": f"{me.steps} steps of {me.step:.6g} to {me.end:.6g}",
            "probes": ", ".join(me.probes.names),
            "fields": ", ".join(me._wanted.fields),
            "result folder": "none" if me.out is None else str(me.out),
        }
        return shown_in_notebook("Simulation", rows)


class Bar:
    """A bar of HTML, which needs no widgets: one output of a cell that is written anew.

    Args:
        display: ``IPython.display.display``.
        steps: How many steps there are.
        end: Simulated time at the end.
    """

    def __init__(self, display: Any, steps: int, end: float) -> None:
        self._steps, self._end = steps, end
        self._begin = self._shown = time.monotonic()
        self._handle = display(_Shown(self._look(0, 0.0)), display_id=True)

    def update(self, step: int, reached: float) -> None:
        """Show that ``step`` steps are done, to the simulated time ``reached``."""
        now = time.monotonic()
        if now - self._shown > INTERVAL or step == self._steps:
            self._handle.update(_Shown(self._look(step, reached)))
            self._shown = now

    def _look(self, step: int, reached: float) -> str:
        spent = time.monotonic() - self._begin
        left = f", {spent * (self._steps - step) / step:.0f} s left" if 0 < step < self._steps else ""
        words = f"t = {reached:.4g} of {self._end:g}, step {step} of {self._steps}{left}"
        return f'<progress value="{step}" max="{self._steps}"></progress> {html.escape(words)}'


class _Shown:
    """HTML, and as plain text what it says."""

    def __init__(self, content: str) -> None:
        self._content = content

    def _repr_html_(self) -> str:
        return self._content

    def __repr__(self) -> str:
        return self._content.partition("</progress> ")[2]


def notebook_progress(simulation: Any) -> Bar | None:
    """A bar, where a notebook runs this; None elsewhere.

    Args:
        simulation: The simulation.
    """
    ipython: Any = sys.modules.get("IPython")  # a notebook has loaded it
    shell = None if ipython is None else ipython.get_ipython()
    if shell is None or not hasattr(shell, "kernel") or simulation.model.potential.body.comm.rank > 0:
        return None
    from importlib import import_module

    return Bar(import_module("IPython.display").display, simulation.steps, simulation.end)
