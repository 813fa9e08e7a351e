"""Fixtures that tests of several folders use."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

# There may be fewer cores than processes: who waits lets others work.
os.environ.setdefault("MPIR_CVAR_ENABLE_HEAVY_YIELD", "1")

MPIEXEC = shutil.which("mpiexec", path=str(Path(sys.executable).parent)) or shutil.which("mpiexec")


@pytest.fixture(scope="session")
def mpiexec():
    """What starts programs on several processes."""
    if MPIEXEC is None:
        pytest.skip("there is no mpiexec beside this Python or on the path")
    return MPIEXEC


@pytest.fixture(scope="session")
def on_processes(mpiexec):
    """Run a Python program on so many processes; what it printed. One that hangs is an error."""

    def run(number, program, *arguments, timeout=600):
        done = subprocess.run(
            [mpiexec, "-n", str(number), sys.executable, "-c", program, *map(str, arguments)],
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run
