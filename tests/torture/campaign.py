"""Campaigns of faults, each a row of a table: killed, interrupted, damaged, crowded out, run twice."""

import contextlib
import os
import random
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from torture.live import MOMENTS, OTHER, PATIENCE, SAME, Live, Row, Subject, on


@dataclass(frozen=True)
class Undisturbed:
    """The result of a run that nothing happened to.

    Args:
        folder: Its result folder.
        startup: Seconds until its first step, about.
    """

    folder: Path
    startup: float


class Campaign:
    """Faults for small cases.

    Args:
        folder: Where everything is written.
        seed: Of the moments and places of the faults.
        say: Is told what happens, for somebody who waits.
    """

    def __init__(self, folder: Path, seed: int = 0, say: Callable[[str], object] = lambda text: None) -> None:
        self.folder, self.rng, self.say = folder, random.Random(seed), say
        self._references: dict[Subject, Undisturbed] = {}
        self._count = 0

    def reference(self, subject: Subject) -> Undisturbed:
        """Run a case undisturbed, once."""
        if subject not in self._references:
            out = self._new(f"reference {subject.name} {subject.processes}")
            begin = time.monotonic()
            live = Live(subject.arguments(out), subject.processes)
            live.until("step", random.Random(0), 0.0)
            startup = time.monotonic() - begin
            if live.wait() != 0:
                raise RuntimeError(f"{subject}: {live.errors()}")
            self._references[subject] = Undisturbed(out, startup)
        return self._references[subject]

    def _new(self, name: str) -> Path:
        self._count += 1
        return self.folder / f"{self._count:03}-{name.replace(' ', '-')}"

    def _row(self, kind: str, subject: Subject | None = None) -> Row:
        where = "" if subject is None else f" ({subject.name}, {subject.processes} proc.)"
        self.say(f"{kind}{where}")
        return Row(f"{kind}{where}")

    # (i) killed

    def kills(
        self, subject: Subject, number: int, *, a_chain: int = 7, moments: Sequence[str] = MOMENTS
    ) -> Row:
        """SIGKILL at random moments, some before the run is done; then resumed until it is, and compared."""
        row, reference = self._row("SIGKILL", subject), self.reference(subject)
        tries = 0
        while row.faults < number:
            out, chain, done = self._new("killed"), 0, False
            while row.faults < number and chain < a_chain and not done:
                moment = moments[tries % len(moments)]
                tries += 1
                live = Live(subject.again(out), subject.processes)
                if live.until(moment, self.rng, reference.startup):
                    one = subject.processes > 1 and self.rng.random() < 0.5
                    live.kill(one=one)
                    row.faults, chain = row.faults + 1, chain + 1
                    row.look(live, f"killed ({moment})")
                else:
                    done = row.expect(live, (0,), "resumed until done")
                    if not done:
                        return row
            if row.finish(subject, reference.folder, out, f"killed {chain} times"):
                row.survived += chain
        return row

    def cold_kills(self, subject: Subject, number: int) -> Row:
        """SIGKILL while kernels are compiled; the next run compiles them, and does not wait for the dead."""
        row, reference = self._row("SIGKILL while compiling", subject), self.reference(subject)
        cache, out = self._new("cache"), self._new("killed")
        for _ in range(number):
            live = Live(subject.again(out), subject.processes, cache)
            begin = time.monotonic()
            while live.running() and not unfinished(cache) and time.monotonic() - begin < PATIENCE:
                time.sleep(0.001)
            time.sleep(self.rng.uniform(0, 0.3))
            live.kill()
            row.faults += 1
            row.look(live, "killed")
        done = row.expect(Live(subject.again(out), subject.processes, cache), (0,), "resumed")
        if done:
            row.survived += number
            row.compare(reference.folder, out, SAME, "compiled anew")
        return row

    # (ii) interrupted

    def signals(self, subject: Subject, number: int, *, twice: bool = False) -> Row:
        """SIGINT and SIGTERM in turn at random moments, once or twice in a row."""
        row = self._row("signal twice" if twice else "signal", subject)
        reference = self.reference(subject)
        for i in range(number):
            out = self._new("interrupted")
            signum = (signal.SIGINT, signal.SIGTERM)[i % 2]
            moment = ("step", "output", "checkpoint", "step", "end", "drawing")[i % 6]
            live = Live(subject.arguments(out), subject.processes)
            if live.until(moment, self.rng, reference.startup):
                live.send(signum)
                if twice:
                    time.sleep(self.rng.uniform(0, 0.05))
                    live.send(signum)
            row.faults += 1
            # When all is written a signal finds the run done; the second one need not be waited for.
            allowed = [128 + signum]
            allowed += [0] if moment in ("end", "drawing") or (out / "results.json").exists() else []
            # A second SIGINT ends mpiexec by its own hand, at once.
            allowed += [255] if twice and subject.processes > 1 and signum == signal.SIGINT else []
            what = f"{signum.name} ({moment})"
            if not row.expect(live, tuple(allowed), what):
                continue
            if not list((out / "checkpoint").glob("*.ckpt")) and not (out / "results.json").exists():
                row.problems.append(f"{what}: there is no checkpoint")
            row.survived += row.finish(subject, reference.folder, out, what)
        return row

    # (iii) resumed on another number of processes

    def other_processes(self, subject: Subject, before: int, after: int) -> Row:
        """Interrupted on some processes, resumed on others, compared with a run that changed nothing."""
        row = self._row(f"resumed on {after} of {before}", subject)
        reference = self.reference(subject)
        out, row.faults = self._new("moved"), 1
        if self._interrupt(row, on(before, subject), out):
            row.survived += row.finish(on(after, subject), reference.folder, out, "moved", OTHER)
        return row

    def _interrupt(self, row: Row, subject: Subject, out: Path, checkpoints: int = 1) -> bool:
        """Run until there are so many checkpoints, then stop by SIGTERM."""
        live = Live(subject.arguments(out), subject.processes)
        while live.running() and len(newest_first(out)) < checkpoints:
            time.sleep(0.001)
        live.send(signal.SIGTERM)
        return row.expect(live, (143,), "SIGTERM")

    # (iv) damaged checkpoints

    def damage(self, subject: Subject, *, flips: int, kinds: Sequence[str] = ("",)) -> Row:
        """Bytes flipped in the newest checkpoint, cut, emptied, replaced; some of it in both checkpoints.

        Args:
            subject: The case.
            flips: Number of bits flipped at the beginning, in the middle and at the end.
            kinds: Words of which one must be in the name of a damage.
        """
        row, reference = self._row("damaged checkpoint", subject), self.reference(subject)
        base = self._new("base")
        if not self._interrupt(row, subject, base, checkpoints=2):
            return row
        for name, hurt in self._damages(newest_first(base)[0].stat().st_size, flips):
            if any(kind in name for kind in kinds):
                self._damaged(row, subject, reference, base, name, hurt, both=False)
                if name in ("empty", "flip in the middle"):
                    self._damaged(row, subject, reference, base, name, hurt, both=True)
        return row

    def _damages(self, size: int, flips: int) -> Iterator[tuple[str, Callable[[bytes], bytes]]]:
        def flip(offset: int) -> Callable[[bytes], bytes]:
            bit = 1 << self.rng.randrange(8)

            def hurt(data: bytes) -> bytes:
                at = min(offset, len(data) - 1)  # the one before it may be shorter
                return data[:at] + bytes([data[at] ^ bit]) + data[at + 1 :]

            return hurt

        regions = {"header": (0, 64), "middle": (64, size - 64), "end": (size - 64, size)}
        for region, (low, high) in regions.items():
            for _ in range(flips):
                yield f"flip in the {region}", flip(self.rng.randrange(low, high))
        for share in (0.1, 0.5, 1 - 1 / size):
            yield f"cut to {share:.3f}", lambda data, share=share: data[: int(len(data) * share)]
        yield "empty", lambda data: b""
        yield "garbage", lambda data: self.rng.randbytes(len(data))
        yield "longer", lambda data: data + b"\0"

    def _damaged(self, row, subject, reference, base, name, hurt, *, both) -> None:
        out = self._new("damaged")
        shutil.copytree(base, out)
        for path in newest_first(out)[: 2 if both else 1]:
            path.write_bytes(hurt(path.read_bytes()))
        row.faults += 1
        what = f"{name}{' of both' if both else ''}"
        live = Live(subject.again(out), subject.processes)
        if not row.expect(live, (2,) if both else (0,), what):
            return
        if newest_first(base)[0].name not in live.errors():
            row.problems.append(f"{what}: no message names the file: {live.errors()!r}")
            return
        row.survived += 1
        if not both:
            row.compare(reference.folder, out, SAME, what)
        shutil.rmtree(out)

    # (v) full disk

    def file_limit(self, subject: Subject, shares: Sequence[float]) -> Row:
        """No file may grow beyond a share of a checkpoint (EFBIG), from the beginning or after a while."""
        row, reference = self._row("file too large", subject), self.reference(subject)
        size = newest_first(reference.folder)[0].stat().st_size
        for share in shares:
            out = self._new("full")
            live = Live(subject.arguments(out), subject.processes)
            live.until("begin" if share < 0.5 else "step", self.rng, 0.0)
            live.limit_files(int(share * size))
            row.faults += 1
            row.survived += self._full(row, live, subject, reference, out, f"limit {share:g}")
        return row

    def small_disk(self, subject: Subject, shares: Sequence[float]) -> Row:
        """A file system of memory that holds a share of what the run writes (ENOSPC)."""
        row, reference = self._row("full disk", subject), self.reference(subject)
        whole = sum(p.stat().st_size for p in reference.folder.rglob("*") if p.is_file())
        for share in shares:
            with small_disk(self._new("disk"), int(share * whole)) as disk:
                if disk is None:
                    row.kind += ": skipped, mounting is not allowed"
                    return row
                out = disk / "run"
                live = Live(subject.arguments(out), subject.processes)
                row.faults += 1
                mount(disk, f"remount,size={4 * whole}", after=live)
                row.survived += self._full(row, live, subject, reference, out, f"disk {share:g}")
        return row

    def _full(self, row, live, subject, reference, out, what) -> bool:
        if not row.expect(live, (3,), what):
            return False
        message = live.errors()
        if "myostrain: " not in message or not any(w in message for w in ("space", "large", "written")):
            row.problems.append(f"{what}: no clear message: {message!r}")
        return row.finish(subject, reference.folder, out, what)

    # (vi) folders that cannot be had

    def unwritable(self, subject: Subject) -> Row:
        """A result folder below a file, and without permission where that means something."""
        row = self._row("unwritable folder", subject)
        file = self._new("file")
        file.touch()
        places = [file, file / "run"]
        if os.geteuid() != 0:
            closed = self._new("closed")
            closed.mkdir(mode=0o500)
            places.append(closed / "run")
        for out in places:
            row.faults += 1
            row.survived += row.expect(Live(subject.arguments(out), subject.processes), (2,), str(out))
            if out != file:
                continue
            row.faults += 1
            resumed = Live(["run", "--resume", "--out", str(out)], subject.processes)
            row.survived += row.expect(resumed, (2,), f"resume in {out}")
        return row

    def in_use(self, subject: Subject) -> Row:
        """A folder that a run is using."""
        row, reference = self._row("folder in use", subject), self.reference(subject)
        out = self._new("used")
        owner = Live(subject.arguments(out), subject.processes)
        owner.until("step", random.Random(0), 0.0)
        owner.pause(on=True)
        late = [Live(arguments) for arguments in (subject.again(out), [*subject.arguments(out), "--force"])]
        for live in late:
            row.faults += 1
            row.survived += row.expect(live, (2,), "a second run in the folder")
        owner.pause(on=False)
        row.expect(owner, (0,), "the first run in the folder")
        row.compare(reference.folder, out, SAME, "the first run in the folder")
        return row

    def at_once(self, subject: Subject) -> Row:
        """Two runs that go on in a folder at once, and one when all is done."""
        row, reference = self._row("two at once", subject), self.reference(subject)
        out = self._new("both")
        if self._interrupt(row, subject, out):
            both = [Live(subject.again(out), subject.processes) for _ in range(2)]
            fine = [row.expect(live, (0, 2), "two at once") for live in both]
            row.faults += 1
            row.survived += all(fine) and 0 in [live.wait() for live in both]
            row.compare(reference.folder, out, SAME, "two at once")

        row.faults += 1
        row.survived += row.finish(subject, reference.folder, out, "all done")
        return row


def unfinished(cache: Path) -> list[Path]:
    """Kernels that are being compiled, or were when the compiler was killed."""
    return [p for p in cache.rglob("libffcx_*.c") if not p.with_suffix(".c.cached").exists()]


def newest_first(folder: Path) -> list[Path]:
    """The checkpoints of a result folder."""
    found = (folder / "checkpoint").glob("*.ckpt")
    return sorted(found, key=lambda path: (path.stat().st_mtime_ns, path.name), reverse=True)


@contextlib.contextmanager
def small_disk(folder: Path, size: int) -> Iterator[Path | None]:
    """A file system of memory of so many bytes; None where mounting is not allowed."""
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
    try:
        made = subprocess.run(command, capture_output=True, check=False).returncode == 0
    except OSError:
        made = False
    try:
        yield folder if made else None
    finally:
        if made:
            subprocess.run(["umount", str(folder)], check=False)


def mount(folder: Path, options: str, *, after: Live) -> None:
    """Mount anew with other options, when a process has ended."""
    after.wait()
    subprocess.run(["mount", "-o", options, str(folder)], check=True)


def table(rows: Sequence[Row]) -> str:
    """The rows as text, and below them what went wrong."""
    width = max(len(row.kind) for row in rows)
    lines = [f"{'fault':{width}}  faults  survived  compared  equal  tracebacks  worst difference"]
    for r in rows:
        counts = f"{r.faults:6}  {r.survived:8}  {r.compared:8}  {r.equal:5}  {r.tracebacks:10}"
        lines.append(f"{r.kind:{width}}  {counts}  {r.worst:.1e}")
    lines += [f"{row.kind}: {problem}" for row in rows for problem in row.problems]
    return "\n".join(lines)
