"""One run of a sweep, in a process of its own: it is told on its input what to run, and tells how far it is.

It ends with the sweep, however that ends, and what it has written so far stays. A line on its output is a
JSON object: {"share": 0.3} while it runs, {"status": "done"} or "failed" with a reason at its end.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from myostrain.errors import Interrupted, MyostrainError


def main() -> None:
    """Read what to run, run it, say how it ended."""
    answer = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what is printed meanwhile is no answer
    task = json.loads(sys.stdin.readline())
    threading.Thread(target=_end_with_the_sweep, daemon=True).start()

    def tell(**words: Any) -> None:
        print(json.dumps(words), file=answer, flush=True)

    try:
        _run(task, tell)
        tell(status="done")
    except Interrupted:
        tell(status="interrupted")
    except MyostrainError as error:
        tell(status="failed", reason=str(error))


def _end_with_the_sweep() -> None:
    """The pipe of the input is closed when the sweep ends, killed or not."""
    sys.stdin.read()
    os._exit(1)


def _run(task: dict[str, Any], tell: Callable[..., None]) -> None:
    from myostrain.case.case import Case
    from myostrain.case.running import run_case
    from myostrain.engine import MPI

    case = Case.from_dict(tomllib.loads(task["case"]), name=task["name"])
    runs, begun = 1 + case.output.rigid_twin, 0

    class Share:
        """How far the run is, its rigid twin counted."""

        def __init__(self, name: str, steps: int, end: float) -> None:
            nonlocal begun
            self._steps, self._before = steps, begun
            begun += 1

        def update(self, step: int, reached: float) -> None:
            """After a step; told a hundred times."""
            if step % max(1, self._steps // 100) == 0:
                tell(share=min(0.99, (self._before + step / self._steps) / runs))

    out = Path(task["out"])
    resume = (out / "case.toml").exists()
    run_case(case, out, resume=resume, comm=MPI.COMM_SELF, progress=Share, figures=task["figures"])


if __name__ == "__main__":
    main()
