"""The runs of a sweep side by side, each in a process of its own, so that none takes the others along."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import subprocess
import sys
import tempfile
import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from myostrain.sweeping.members import Member

#: Seconds that interrupted runs have to write their checkpoints.
PATIENCE = 60.0


@dataclass
class _Process:
    """A run that goes on."""

    member: Member
    process: subprocess.Popen[str]
    errors: Any
    said: dict[str, Any] = field(default_factory=dict)


def run_all(
    members: Sequence[Member],
    folder: Path,
    *,
    jobs: int,
    figures: bool,
    ended: Callable[[Member, dict[str, Any]], None],
    tell: Callable[[dict[str, float]], None],
) -> None:
    """Run members, some at a time.

    Args:
        members: What to run, in this order.
        folder: Of the sweep; each run has its folder in it.
        jobs: How many run at a time.
        figures: Whether they draw.
        ended: Is told a member that has ended and how: its "status", and a "reason" unless it is "done".
        tell: Is told the shares, from 0 to 1, of the members that run, by name.
    """
    waiting, running = deque(members), dict[str, _Process]()
    events: queue.Queue[tuple[str, dict[str, Any] | None]] = queue.Queue()
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                member = waiting.popleft()
                running[member.name] = _start(member, folder, figures, events)
            name, said = events.get()
            if said is not None:
                running[name].said |= said
            else:
                done = running.pop(name)
                ended(done.member, _outcome(done))
            tell({name: float(each.said.get("share", 0.0)) for name, each in running.items()})
    finally:
        _stop(list(running.values()))


def _start(member: Member, folder: Path, figures: bool, events: queue.Queue[Any]) -> _Process:
    errors = tempfile.TemporaryFile(mode="w+", encoding="utf-8", errors="replace")  # noqa: SIM115
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "myostrain.sweeping.member"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=errors,
        encoding="utf-8",
        env={"OMP_NUM_THREADS": "1", **os.environ},
        start_new_session=True,  # an interrupt of the keyboard is the sweep's to pass on
    )
    assert process.stdin is not None
    out = str((folder / member.name).absolute())
    task = {"case": member.case.to_toml(), "name": member.case.name, "out": out, "figures": figures}
    with contextlib.suppress(OSError):  # it has ended already, and will be seen to
        print(json.dumps(task), file=process.stdin, flush=True)
    threading.Thread(target=_listen, args=(member.name, process, events), daemon=True).start()
    return _Process(member, process, errors)


def _listen(name: str, process: subprocess.Popen[str], events: queue.Queue[Any]) -> None:
    """Pass on what a run says, and that it has ended."""
    assert process.stdout is not None
    for line in process.stdout:
        with contextlib.suppress(ValueError):
            events.put((name, json.loads(line)))
    process.wait()
    events.put((name, None))


def _outcome(ended: _Process) -> dict[str, Any]:
    """How a run ended; of a process that ended without a word, its last lines."""
    with ended.errors as errors:
        if "status" in ended.said:
            return ended.said
        errors.seek(0)
        last = " ".join(errors.read()[-2000:].split())[-300:]
    status = ended.process.returncode
    how = f"was ended by signal {-status}" if status < 0 else f"ended with exit status {status}"
    return {"status": "failed", "reason": f"its process {how}{': ' if last else ''}{last}"}


def _stop(running: Sequence[_Process]) -> None:
    """End what still runs, each after a checkpoint."""
    for each in running:
        each.process.terminate()
    for each in running:
        try:
            each.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            each.process.kill()
        each.errors.close()
