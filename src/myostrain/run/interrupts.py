"""Signals that end a run between two steps rather than anywhere."""

from __future__ import annotations

import os
import signal
import threading
from types import FrameType, TracebackType

#: What a user at a keyboard and a batch scheduler send.
SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Interrupts:
    """While open, the first SIGINT or SIGTERM is noted; a second one ends the process, with its exit status.

    Outside the main thread, which alone may handle signals, nothing is noted.

    Args:
        active: Whether to handle signals at all.

    Attributes:
        noted: Number of the noted signal, 0 for none.
    """

    def __init__(self, *, active: bool = True) -> None:
        self.noted = 0
        self._active = active and threading.current_thread() is threading.main_thread()
        self._before: dict[signal.Signals, object] = {}

    def __enter__(self) -> Interrupts:
        """Begin to note signals."""
        if self._active:
            self._before = {number: signal.signal(number, self._note) for number in SIGNALS}
        return self

    def __exit__(self, kind: type[BaseException] | None, value: object, trace: TracebackType | None) -> None:
        """Handle signals as before."""
        for number, handler in self._before.items():
            signal.signal(number, handler)  # type: ignore[arg-type]

    def _note(self, number: int, frame: FrameType | None) -> None:
        if self.noted:  # a process that a signal kills would be a success to mpiexec
            os._exit(128 + number)
        self.noted = number
