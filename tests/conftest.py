"""Fixtures that tests of several folders use."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from xdist.scheduler import LoadScopeScheduling

# There may be fewer cores than processes: who waits lets others work.
os.environ.setdefault("MPIR_CVAR_ENABLE_HEAVY_YIELD", "1")

MPIEXEC = shutil.which("mpiexec", path=str(Path(sys.executable).parent)) or shutil.which("mpiexec")


def folder(nodeid):
    """The folder of tests/ in which a test is."""
    return nodeid.split("/")[1]


class Together(LoadScopeScheduling):
    """Which tests one of pytest's workers runs after each other, and nobody else at the same time.

    All that start several processes: two such tests at a time would wait for cores. Chapters of the paper are
    long and go one by one, other tests file by file, for what they share.
    """

    def _split_scope(self, nodeid):
        groups = {"mpi": "mpi", "paper": nodeid}
        return groups.get(folder(nodeid), nodeid.split("::")[0])


def pytest_xdist_make_scheduler(config, log):
    """In the order of the collection."""
    config.option.loadscopereorder = False
    return Together(config, log)


def pytest_collection_modifyitems(items):
    """Long tests first, so that no worker is left alone at the end."""
    long = ["mpi", "paper", "torture", "docs"]
    items.sort(key=lambda item: [*long, folder(item.nodeid)].index(folder(item.nodeid)))


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
