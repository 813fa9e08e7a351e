"""Computations that the page rests on: run side by side, and kept under their resolved parameters."""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import json
import multiprocessing
import os
import re
import signal
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from myostrain.engine import versions
from myostrain.errors import ComputationError

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Found:
    """What a computation found.

    Args:
        numbers: Numbers by name, None where one does not exist; JSON.
        arrays: Arrays by name, for figures.
    """

    numbers: dict[str, Any]
    arrays: dict[str, Array] = field(default_factory=dict)


@dataclass(frozen=True)
class Job:
    """One computation.

    Args:
        function: Name of a function of :mod:`myostrain.reproduce.measurements`, "module.function", that takes
            ``parameters`` as keywords and returns a :class:`Found`.
        parameters: Everything the outcome depends on, resolved; JSON.
        cost: Seconds that it takes, roughly, for the order and the progress.
    """

    function: str
    parameters: Mapping[str, Any]
    cost: float = 1.0

    def run(self) -> Found:
        """Compute it, here and now."""
        module, name = self.function.split(".")
        functions = importlib.import_module(f"myostrain.reproduce.measurements.{module}")
        found: Found = getattr(functions, name)(**self.parameters)
        return found

    @property
    def key(self) -> str:
        """What the outcome is kept under: parameters, the code that computes, and what it computes with."""
        code = _code(self.function.split(".")[0])
        content = json.dumps([self.function, self.parameters, code, versions()], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()[:32]


#: How one measurement imports another.
IMPORTED = r"^from myostrain\.reproduce\.measurements(?:\.(\w+)| import (\w+))"


@cache
def _code(measurement: str) -> str:
    """A fingerprint of the code that computes: the package without page and figures, and one measurement."""
    root = Path(__file__).parents[1]
    shown = {*root.glob("cli/*.py"), root / "run" / "progress.py", *root.glob("output/figures/*.py")}
    page = root / "reproduce"
    paths = {path for path in root.rglob("*.py") if path not in shown and not path.is_relative_to(page)}
    digest = hashlib.sha256()
    for path in sorted(paths | _measured_by(page / "measurements", measurement, set())):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _measured_by(folder: Path, name: str, known: set[Path]) -> set[Path]:
    """The file of a measurement, and of those that it imports from."""
    path = folder / f"{name}.py"
    if path not in known and path.is_file():
        known.add(path)
        text = path.read_text(encoding="utf-8")
        for names in re.findall(IMPORTED, text, re.MULTILINE):
            _measured_by(folder, "".join(names), known)
    return known


class Store:
    """Outcomes on disk, one file each.

    A file that cannot be read or written is no error: its outcome is computed again.

    Args:
        folder: Where; the user's cache folder unless given.
    """

    def __init__(self, folder: Path | None = None) -> None:
        root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        self.folder = folder or root / "myostrain" / "reproduce"

    def get(self, job: Job) -> Found | None:
        """The kept outcome of a job, None if there is none."""
        with (
            contextlib.suppress(OSError, ValueError, KeyError, zipfile.BadZipFile),
            np.load(self._path(job)) as kept,
        ):
            arrays = {name: kept[name] for name in kept.files if name != "numbers"}
            return Found(json.loads(str(kept["numbers"])), arrays)
        return None

    def put(self, job: Job, found: Found) -> None:
        """Keep the outcome of a job."""
        with contextlib.suppress(OSError):
            self.folder.mkdir(parents=True, exist_ok=True)
            handle, part = tempfile.mkstemp(dir=self.folder, suffix=".part")
            try:
                with os.fdopen(handle, "wb") as stream:
                    np.savez_compressed(
                        stream, allow_pickle=False, numbers=json.dumps(found.numbers), **found.arrays
                    )
                Path(part).replace(self._path(job))
            finally:
                Path(part).unlink(missing_ok=True)

    def _path(self, job: Job) -> Path:
        return self.folder / f"{job.key}.npz"


def run_jobs(
    jobs: Mapping[str, Job],
    store: Store,
    *,
    workers: int | None = None,
    fresh: bool = False,
    tell: Callable[[str, float, float], None] = lambda name, done, total: None,
) -> dict[str, Found]:
    """Run jobs, the dear ones first, side by side; equal jobs once.

    Args:
        jobs: Jobs by name.
        store: Where outcomes are kept.
        workers: Processes; as many as there are cores unless given. One works in this process.
        fresh: Whether to compute what is kept, too.
        tell: Is told the name of a job that is done, and the cost done and in total.

    Returns:
        Outcomes by name.

    Raises:
        ComputationError: A computation failed; it names the job. Outcomes so far are kept.
    """
    by_key = {job.key: (name, job) for name, job in jobs.items()}
    outcomes: dict[str, Found] = {}
    total = sum(job.cost for _, job in by_key.values())
    done = 0.0
    for key, (name, job) in by_key.items():
        kept = None if fresh else store.get(job)
        if kept is not None:
            outcomes[key] = kept
            done += job.cost
            tell(name, done, total)
    missing = {key: by_key[key] for key in by_key.keys() - outcomes.keys()}
    for key, found in _computed(missing, _workers(workers, len(missing))):
        name, job = missing[key]
        store.put(job, found)
        outcomes[key] = found
        done += job.cost
        tell(name, done, total)
    return {name: outcomes[job.key] for name, job in jobs.items()}


def _workers(asked: int | None, jobs: int) -> int:
    # Processes that mpiexec did not start must not take part in what it started.
    if any(name.startswith(("PMI_", "OMPI_COMM")) for name in os.environ):
        return 1
    return max(1, min(asked or len(os.sched_getaffinity(0)), jobs))


def _computed(jobs: Mapping[str, tuple[str, Job]], workers: int) -> Iterator[tuple[str, Found]]:
    ordered = sorted(jobs.items(), key=lambda item: -item[1][1].cost)
    if workers == 1:
        for key, (name, job) in ordered:
            with _named(name):
                yield key, job.run()
        return
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # the workers inherit it before they load any library
    context = multiprocessing.get_context("spawn")
    # An interrupt is this process's to handle: it ends the workers.
    with ProcessPoolExecutor(workers, context, signal.signal, (signal.SIGINT, signal.SIG_IGN)) as pool:
        running: dict[Future[Found], tuple[str, str]] = {
            pool.submit(job.run): (key, name) for key, (name, job) in ordered
        }
        try:
            while running:
                ready, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in ready:
                    key, name = running.pop(future)
                    with _named(name):
                        yield key, future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for worker in multiprocessing.active_children():
                worker.terminate()
            raise


@contextlib.contextmanager
def _named(name: str) -> Iterator[None]:
    """Say which job it was that failed."""
    try:
        yield
    except ComputationError as error:
        raise ComputationError(f"{name}: {error.reason}", time=error.time, advice=error.advice) from error
