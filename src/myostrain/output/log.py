"""``run.log``: what a bug report needs of a run: versions, options, warnings, retries and timings."""

from __future__ import annotations

import contextlib
import logging
import os
import platform
import textwrap
import time
import warnings
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from myostrain.engine import PETSc, jit_options, versions
from myostrain.errors import MyostrainError
from myostrain.output.manifest import claim
from myostrain.output.results import unknowns

if TYPE_CHECKING:
    from myostrain.coupling import Electromechanics

#: What is to be in ``run.log`` goes here; without an open log it goes nowhere.
logger = logging.getLogger("myostrain")
logger.addHandler(logging.NullHandler())

_format = logging.Formatter("%(asctime)s.%(msecs)03dZ %(levelname)s %(message)s", "%Y-%m-%dT%H:%M:%S")
_format.converter = time.gmtime

_open: list[logging.Handler] = []  # of the runs that go on, the innermost last


class RunLog:
    """Keeps ``run.log`` of one run while it is open; the lines of a run within it go to that run's log alone.

    Python's warnings are logged and shown as ever. An exception that passes is logged, with its traceback
    where nobody raised it on purpose. A log that cannot be written stops no run.

    Args:
        folder: The result folder.
        comm: MPI communicator; its first process writes.
        append: Whether to keep what is there, as a resumed run does.
    """

    def __init__(self, folder: Path, comm: Any, append: bool = False) -> None:
        self._path, self._mode = folder / "run.log", "a" if append else "w"
        self._active = comm.rank == 0

    def __enter__(self) -> RunLog:
        """Open the file."""
        if self._active:
            self._level, self._show = logger.level, warnings.showwarning
            logger.setLevel(logging.INFO)
            if _open:
                logger.removeHandler(_open[-1])
            else:  # logging.captureWarnings would take the warnings from the screen
                warnings.showwarning = self._warn  # type: ignore[assignment]
            _open.append(logging.NullHandler())
            with contextlib.suppress(OSError):
                claim(self._path)
                _open[-1] = _LogFile(self._path, self._mode, encoding="utf-8")
            _open[-1].setFormatter(_format)
            logger.addHandler(_open[-1])
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Log the exception that passes, if one does, and close the file."""
        if not self._active:
            return
        unexpected = not isinstance(error, (MyostrainError, KeyboardInterrupt, SystemExit))
        if error is not None:
            text = " ".join(f"{type(error).__name__}: {error}".split())
            logger.error(text.removesuffix(":"), exc_info=error if unexpected else None)
        logger.setLevel(self._level)
        warnings.showwarning = self._show
        logger.removeHandler(_open[-1])
        with contextlib.suppress(OSError):  # what a full disk did not take
            _open.pop().close()
        if _open:
            logger.addHandler(_open[-1])

    def _warn(self, message: Any, kind: Any, file: str, line: int, *more: Any, **named: Any) -> None:
        text = f"{kind.__name__}: {message} ({Path(file).name}:{line})"
        _open[-1].handle(logger.makeRecord(logger.name, logging.WARNING, file, line, text, (), None))
        self._show(message, kind, file, line, *more, **named)


class _LogFile(logging.FileHandler):
    def handleError(self, record: logging.LogRecord) -> None:
        """A full disk or a vanished folder does not concern the run."""


def log_start(parameters: Mapping[str, Any], model: Electromechanics, processes: int) -> None:
    """Log what runs, and on what."""
    logger.info("versions: %s", _line(versions()))
    where = {"processes": processes, "cores": os.cpu_count(), "threads": os.environ.get("OMP_NUM_THREADS")}
    logger.info("platform: %s, %s", platform.platform(), _line(where))
    logger.info("kernel flags: %s", " ".join(jit_options()["cffi_extra_compile_args"]))
    logger.info("cells: %d, unknowns: %s", model.potential.body.cells, _line(unknowns(model)))
    for name, part in (("potential", model.potential), ("mechanics", model.mechanics)):
        solver: Any = None if part is None else part.solver
        options: Any = None if solver is None else PETSc.Options(solver.ksp.getOptionsPrefix())
        logger.info("solver.%s: %s", name, _line({} if options is None else options.getAll()))
    import tomlkit

    logger.info("case:\n%s", textwrap.indent(tomlkit.dumps(dict(parameters)).rstrip(), "    "))


def log_end(results: Mapping[str, Any]) -> None:
    """Log how long it took, and what the solvers did."""
    seconds = {phase: f"{value:.2f}" for phase, value in results["seconds"].items()}
    logger.info("done: %d steps to t = %g; seconds: %s", results["steps"], results["time"], _line(seconds))
    for name, counts in results["solver"].items():
        logger.info("solver.%s: %s", name, _line(counts))


def _line(items: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} {value}" for key, value in items.items())
