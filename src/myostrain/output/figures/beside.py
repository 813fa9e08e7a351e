"""Drawing in a process beside the run: what it takes to draw is loaded while the run steps."""

from __future__ import annotations

import json
import logging
import os
import queue
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from types import TracebackType

log = logging.getLogger("myostrain")


class Artist:
    """Draws the figures of a result folder, in a process of its own where that is faster.

    That process loads Matplotlib, and PyVista for a solid, at once, and draws when it is told to. It ends
    with this one, however this one ends. Where it fails the figures are drawn here, and what is wrong shows.

    Args:
        beside: Whether to start the process.
        solid: Whether a solid will be drawn.
    """

    def __init__(self, *, beside: bool = True, solid: bool = False) -> None:
        self._process: subprocess.Popen[str] | None = None
        if beside:
            command = [sys.executable, "-P", "-m", "myostrain.output.figures.beside", *["solid"] * solid]
            with suppress(OSError):
                self._process = subprocess.Popen(
                    command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8"
                )

    def __enter__(self) -> Artist:
        """Nothing more."""
        return self

    def __exit__(self, kind: type[BaseException] | None, value: object, trace: TracebackType | None) -> None:
        """End the process."""
        self.close()

    def close(self) -> None:
        """End the process, whatever it does."""
        if self._process is not None:
            self._process.kill()
            with suppress(OSError):  # what it was told and did not read
                self._process.communicate()
            self._process = None

    def draw(self, folder: Path) -> None:
        """Draw all that a result folder is about.

        Args:
            folder: The result folder.

        Raises:
            InputError: See :func:`~myostrain.output.figures.draw.draw`.
        """
        warnings = self._told(folder)
        self.close()
        if warnings is None:
            from myostrain.output.figures.draw import draw

            draw(folder)
            return
        for warning in warnings:
            log.warning("%s", warning)

    def _told(self, folder: Path) -> list[str] | None:
        """The warnings of the process that has drawn; None if it has not."""
        if self._process is None or self._process.stdin is None or self._process.stdout is None:
            return None
        try:
            print(json.dumps(str(folder.absolute())), file=self._process.stdin, flush=True)
            return list(json.loads(self._process.stdout.readline()))
        except (OSError, ValueError):  # it ended before its time
            return None


def main() -> None:
    """The other process: load, wait for a folder, draw, say what there was to warn of."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of a keyboard it concerns the run, which ends this process
    answer = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    folders: queue.Queue[str] = queue.Queue()
    threading.Thread(target=_listen, args=(folders,), daemon=True).start()
    try:
        from myostrain.output.figures.draw import draw

        if "solid" in sys.argv[1:]:
            from myostrain.output.figures.scene import why_not

            why_not()
        warnings = _Warnings()
        log.addHandler(warnings)
        draw(Path(folders.get()))
        print(json.dumps(warnings.messages), file=answer, flush=True)
    finally:
        os._exit(0)  # without a word: the run draws itself if this one has not, and says what is wrong


def _listen(folders: queue.Queue[str]) -> None:
    """Pass on what the run says; end when it has ended."""
    for line in sys.stdin:
        folders.put(json.loads(line))
    os._exit(0)


class _Warnings(logging.Handler):
    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.messages: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep one."""
        self.messages.append(record.getMessage())


def worth_it(processes: int) -> bool:
    """Whether a process beside so many of a run saves time: a core is idle, and much is to be loaded."""
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return usable > processes and "matplotlib" not in sys.modules


if __name__ == "__main__":
    main()
