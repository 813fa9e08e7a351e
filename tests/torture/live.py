"""Runs of the command line that are watched and disturbed from outside, and their results compared.

Nothing here imports myostrain: what is known of a run is its exit status, its messages and its files.
"""

import contextlib
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

COMMAND = (sys.executable, "-c", "from myostrain.cli import main; main()")
MPIEXEC = shutil.which("mpiexec", path=str(Path(sys.executable).parent)) or shutil.which("mpiexec")

#: Largest relative difference of results on the same number of processes, and on another one.
SAME, OTHER = 1e-12, 1e-6

#: What of results.json must not depend on what happened to the run.
COMPARED = ("completed", "time", "steps", "step", "metrics", "probes", "cells", "unknowns", "parameters")

#: When a fault strikes: at any time of start-up, while the folder is set up, while stepping, as output or a
#: checkpoint is being written, when the numbers are there but not yet the pictures, and while they are drawn.
MOMENTS = ("start", "folder", "step", "output", "checkpoint", "end", "drawing")

#: Seconds that a run may take; longer is a hang.
PATIENCE = 180.0


@dataclass(frozen=True)
class Subject:
    """A small case, and on how many processes it runs."""

    name: str
    case: str
    settings: tuple[str, ...]
    processes: int = 1

    def arguments(self, out: Path) -> list[str]:
        """Of a new run."""
        return ["run", self.case, *(f"--set={setting}" for setting in self.settings), "--out", str(out)]

    def again(self, out: Path) -> list[str]:
        """Of the run that goes on; a run that left nothing at all is begun anew."""
        return ["run", "--resume", "--out", str(out)] if (out / "case.toml").exists() else self.arguments(out)


_OFTEN = ("output.every=0.02", "output.checkpoint_every=0.01")
_LINE = ("geometry.length=60.0", "probes={a=[8.0], b=[12.0]}", "time.end=0.4", "output.rigid_twin=false")

SHEET = Subject(
    "sheet",
    "sheet-2d",
    ("geometry.spacing=8.0", "time.end=0.6", "time.step=1e-3", *_OFTEN),
)
LINE = Subject("line", "pulse-1d", (*_LINE, *_OFTEN))
#: Without fields, and so without pictures: half the time.
BARE = Subject("bare line", "pulse-1d", (*LINE.settings, "output.fields=[]"))
SOLID = Subject(
    "solid",
    "slab-3d",
    ("geometry.spacing=5.0", "time.end=0.05", "time.step=1e-3", "output.every=0.01", *_OFTEN[1:]),
)
SUBJECTS = (
    SHEET,
    SOLID,
    Subject("viscous line", "pulse-1d", (*_LINE, *_OFTEN, "mechanics.relaxation_time=0.08")),
    Subject("rigid twin", "pulse-1d", (*_LINE, *_OFTEN, "output.rigid_twin=true")),
    Subject("staggered", "sheet-2d", (*SHEET.settings, "time.scheme=staggered", "mechanics.every=3")),
    Subject("implicit", "pulse-1d", (*_LINE, *_OFTEN, "time.scheme=implicit")),
)


def on(processes: int, subject: Subject) -> Subject:
    """The same case on another number of processes."""
    return Subject(subject.name, subject.case, subject.settings, processes)


@dataclass
class Row:
    """What became of the faults of one kind.

    Args:
        kind: Name of the kind.
        faults: How often it was injected.
        survived: After how many the run ended well or was refused as it should be.
        equal: How many results were compared and found equal.
        compared: How many were compared.
        tracebacks: Tracebacks seen on any standard error.
        worst: Largest relative difference of any number.
        problems: What went wrong, in words.
    """

    kind: str
    faults: int = 0
    survived: int = 0
    equal: int = 0
    compared: int = 0
    tracebacks: int = 0
    worst: float = 0.0
    problems: list[str] = field(default_factory=list)

    @property
    def clean(self) -> bool:
        """Whether every fault was survived and every result equal."""
        whole = self.faults == self.survived and self.compared == self.equal
        return whole and not self.tracebacks and not self.problems

    def look(self, live: "Live", what: str) -> None:
        """Count the tracebacks of a process that has ended."""
        text = live.errors()
        if "Traceback (most recent call last)" in text:
            self.tracebacks += 1
            self.problems.append(f"{what}: traceback: {text[-600:]}")

    def expect(self, live: "Live", statuses: tuple[int, ...], what: str) -> bool:
        """Wait for a process and check its exit status."""
        status = live.wait()
        self.look(live, what)
        if status not in statuses:
            self.problems.append(f"{what}: status {status}, expected {statuses}: {live.errors()[-400:]}")
        return status in statuses

    def compare(self, reference: Path, folder: Path, tolerance: float, what: str) -> None:
        """Compare a result with the undisturbed one."""
        worst, problems = difference(reference, folder)
        self.compared += 1
        self.equal += worst <= tolerance and not problems
        self.worst = max(self.worst, worst)
        if worst > tolerance or problems:
            self.problems.append(f"{what}: off by {worst:.1e} {problems[:5]}")

    def finish(self, subject: Subject, reference: Path, folder: Path, what: str, tolerance=SAME) -> bool:
        """Resume without faults, to the end, and compare."""
        done = self.expect(Live(subject.again(folder), subject.processes), (0,), f"{what}, resumed")
        if done:
            self.compare(reference, folder, tolerance, what)
        return done


class Live:
    """A running command line, on one process or several.

    Args:
        arguments: Of the command line.
        processes: Number of processes.
        cache: Folder of compiled kernels, in place of the user's.
    """

    def __init__(self, arguments: list[str], processes: int = 1, cache: Path | None = None) -> None:
        launcher = [] if processes == 1 else [str(MPIEXEC), "-n", str(processes)]
        self.processes = processes
        self._out = Path(arguments[arguments.index("--out") + 1])
        self._seen = {name: _state(self._out / name) for name in ("snapshots", "checkpoint")}
        self._told, self._errors = tempfile.TemporaryFile(), tempfile.TemporaryFile()  # noqa: SIM115
        self.process = subprocess.Popen(
            [*launcher, *COMMAND, *arguments, "--quiet"],
            stdin=subprocess.DEVNULL,
            stdout=self._told,
            stderr=self._errors,
            start_new_session=True,
            env={**os.environ, "OMP_NUM_THREADS": "1"} | ({"XDG_CACHE_HOME": str(cache)} if cache else {}),
        )

    def errors(self) -> str:
        """What it wrote to standard error so far."""
        return os.pread(self._errors.fileno(), 1_000_000, 0).decode(errors="replace")

    def told(self) -> str:
        """What it wrote to standard output so far."""
        return os.pread(self._told.fileno(), 1_000_000, 0).decode(errors="replace")

    def running(self) -> bool:
        """Whether it has not ended."""
        return self.process.poll() is None

    def wait(self) -> int:
        """Its exit status; -1000 for a hang, which is ended."""
        try:
            return self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.kill()
            return -1000

    def until(self, moment: str, rng: random.Random, startup: float) -> bool:
        """Wait for one of :data:`MOMENTS`, or "begin", when there is a case.toml; whether it runs then."""
        if moment == "start":
            time.sleep(rng.uniform(0, startup))
            return self.running()
        signs = {"folder": ".lock", "begin": "case.toml", "end": "results.json", "drawing": ".drawing"}
        sign = signs.get(moment)

        def reached() -> bool:
            if sign is not None:
                return (self._out / sign).exists()
            frames = moment == "output" and (self._out / "snapshots").exists()
            where = "snapshots" if frames else "checkpoint"
            return _state(self._out / where) != self._seen[where]

        begin = time.monotonic()
        while self.running() and not reached() and time.monotonic() - begin < PATIENCE:
            time.sleep(0.0005)
        pauses = {"folder": 0.05, "step": 0.3, "end": 0.5, "drawing": 2.0}
        pause = pauses.get(moment, 0.01 if rng.random() < 0.5 else 0.0)
        time.sleep(rng.uniform(0, pause))
        return self.running()

    def ranks(self) -> list[int]:
        """Process ids of everything that it started, itself last."""
        return [*_descendants(self.process.pid), self.process.pid]

    def kill(self, *, one: bool = False) -> None:
        """SIGKILL all of it at once, or one rank (the launcher then has to end the others)."""
        everything = self.ranks()
        chosen = [pid for pid in everything if _is_rank(pid)][-1:] if one else everything
        for pid in chosen or everything:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        self.wait()
        while any(map(_alive, everything)):
            time.sleep(0.01)

    def send(self, number: signal.Signals) -> None:
        """Send a signal as a batch system or a terminal does, to the launcher."""
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.process.pid, number)

    def pause(self, *, on: bool) -> None:
        """Stop it for a while, or let it go on."""
        for pid in self.ranks():
            os.kill(pid, signal.SIGSTOP if on else signal.SIGCONT)

    def limit_files(self, size: int) -> None:
        """From now on no file grows beyond a size, as on a full disk."""
        for pid in self.ranks():
            with contextlib.suppress(ProcessLookupError):
                resource.prlimit(pid, resource.RLIMIT_FSIZE, (size, size))


def _state(folder: Path) -> frozenset[tuple[str, int]]:
    """Names and sizes of what a folder holds."""
    try:
        with os.scandir(folder) as entries:
            return frozenset((entry.name, entry.stat(follow_symlinks=False).st_mtime_ns) for entry in entries)
    except OSError:
        return frozenset()


def _descendants(pid: int) -> Iterator[int]:
    with contextlib.suppress(OSError):
        for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
            yield from _descendants(int(child))
            yield int(child)


def _is_rank(pid: int) -> bool:
    with contextlib.suppress(OSError):
        words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
        return len(words) > 2 and words[1] == b"-c" and b"myostrain" in words[2]
    return False


def _alive(pid: int) -> bool:
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def difference(reference: Path, folder: Path) -> tuple[float, list[str]]:
    """Largest relative difference between two result folders, and what differs in kind."""
    worst, problems = 0.0, []

    def look(where: str, a, b) -> None:
        nonlocal worst
        if np.asarray(a).dtype.kind == "U":
            if str(a) != str(b):
                problems.append(f"{where}: {a} and {b}")
            return
        a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
        if a.shape != b.shape or (np.isnan(a) != np.isnan(b)).any():
            problems.append(f"{where}: {a.shape} and {b.shape}, or NaN elsewhere")
        elif a.size:
            # A free line has no stress: what is left of it is measured by its modulus, one.
            least = 1.0 if "stress" in where else 1e-3
            size = max(least, float(np.nanmax(np.abs(a), initial=0.0)))
            worst = max(worst, float(np.nanmax(np.abs(a - b), initial=0.0)) / size)

    try:
        for path in sorted(reference.rglob("results.json")):
            there = folder / path.relative_to(reference)
            one, two = (json.loads(file.read_text()) for file in (path, there))
            _compare_json({k: one[k] for k in COMPARED}, {k: two[k] for k in COMPARED}, "", look, problems)
        for path in sorted(reference.rglob("probes.csv")):
            there = folder / path.relative_to(reference)
            texts = [file.read_text().splitlines() for file in (path, there)]
            tables = [np.array([line.split(",") for line in text[1:]], dtype=float) for text in texts]
            if texts[0][0] != texts[1][0] or tables[0].shape != tables[1].shape:
                problems.append(f"{path.name}: other columns, or {tables[0].shape} and {tables[1].shape}")
                continue
            for name, *columns in zip(texts[0][0].split(","), *(t.T for t in tables), strict=True):
                look(f"{path.name}: {name}", *columns)
        both = (reference, folder)
        names = [{str(p.relative_to(f)) for p in f.rglob("snapshots/*")} for f in both]
        drawn = [{str(p.relative_to(f)) for p in f.glob("figures/*")} for f in both]
        for one, other in (names, drawn):
            if one != other:
                problems.append(f"files: {sorted(one ^ other)[:5]} in one only")
        left = [p.name for p in folder.rglob(".*") if p.name != ".manifest"]
        if left:
            problems.append(f"unfinished: {left[:5]}")
        for name in sorted(n for n in names[0] & names[1] if n.endswith(".npz")):
            with np.load(reference / name) as one, np.load(folder / name) as two:
                if set(one) != set(two):
                    problems.append(f"{name}: {set(one)} and {set(two)}")
                for key in set(one) & set(two):
                    look(f"{name}: {key}", one[key], two[key])
    except (OSError, ValueError, KeyError) as error:
        problems.append(f"{type(error).__name__}: {error}")
    return worst, problems


def _compare_json(a, b, where, look, problems) -> None:
    if isinstance(a, dict) and isinstance(b, dict) and a.keys() == b.keys():
        for key in a:
            _compare_json(a[key], b[key], f"{where}.{key}", look, problems)
    elif isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        for one, other in zip(a, b, strict=True):
            _compare_json(one, other, where, look, problems)
    elif isinstance(a, float) and isinstance(b, float):
        look(where, a, b)
    elif a != b:
        problems.append(f"{where}: {a} and {b}")
