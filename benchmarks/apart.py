"""A measurement in processes of its own, so that none profits from another."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any


def apart(
    script: str | Path, *arguments: Any, python: str = sys.executable, processes: int = 1, **settings: str
) -> dict:
    """What a script says in its last line, as JSON.

    Args:
        script: The script.
        arguments: Its arguments.
        python: The Python that runs it.
        processes: How many processes.
        settings: Variables of the environment.
    """
    command = [python, str(script), *map(str, arguments)]
    if processes > 1:
        command = [str(Path(python).with_name("mpiexec")), "-n", str(processes), *command]
    environment = {**os.environ, "OMP_NUM_THREADS": "1", **settings}
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, env=environment, check=True)
    return json.loads(done.stdout.splitlines()[-1])
