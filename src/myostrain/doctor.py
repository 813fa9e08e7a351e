"""Whether this installation works: what it consists of, and a self-check of about ten seconds."""

from __future__ import annotations

import contextlib
import os
import platform
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from myostrain import activation, cases, geometry, kinematics, materials
from myostrain.case.case import Case
from myostrain.engine import MPI, PETSc, cache_folder, fem, jit_options, versions
from myostrain.mechanics.equilibrium import Mechanics
from myostrain.output.folder import write_atomically
from myostrain.theory import profile, speed

import dolfinx.io
import numpy as np
import ufl
from dolfinx import mesh as dmesh

#: What a run needs at least, in GiB: memory, and room for kernels and results.
MEMORY, ROOM = 0.5, 0.1

#: Largest accepted errors (measured: 7e-6, 9e-12): of the front's speed, relative; of the sheet's stretch.
FRONT, STRETCH = 1e-4, 1e-8

WRONG = "wrong numbers: install again; if that does not help, report it with this output"


@dataclass(frozen=True)
class Check:
    """One line of the report: what was looked at, what was found, what to do; nothing where all is well."""

    name: str
    value: str
    todo: str = ""

    def __str__(self) -> str:
        """The line."""
        verdict = f"FAILED: {self.todo}" if self.todo else "ok"
        return f"{self.name:18}  {self.value}  {verdict}"


def report(echo: Callable[[str], object] = print) -> int:
    """Print every check by ``echo``; 0 if all is well, 1 if something is not."""
    failed = 0
    for check in checks():
        echo(str(check))
        failed += bool(check.todo)
    echo(f"{failed} of the checks failed" if failed else "all is well")
    return int(failed > 0)


def checks() -> Iterator[Check]:
    """All checks in turn; one that cannot be made has failed."""
    for name, version in versions().items():
        yield Check(name, version)
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    yield Check("platform", f"{platform.platform()}, {usable} usable cores")
    yield Check("OMP_NUM_THREADS", os.environ.get("OMP_NUM_THREADS", "not set (1 is fastest here)"))
    for name, look in LOOKS.items():
        try:
            value, todo = look()
        except Exception as error:  # noqa: BLE001 - whatever is broken, the other checks go on
            lines = str(error).strip().splitlines() or ["no message"]
            value, todo = "", f"{type(error).__name__}: {lines[-1]}"
        yield Check(name, value, todo)


Finding = tuple[str, str]  # what was found, and what to do about it


def _memory() -> Finding:
    with contextlib.suppress(OSError, IndexError):
        text = Path("/proc/meminfo").read_text()
        available = int(text.partition("MemAvailable:")[2].split()[0]) / 2**20
        return f"{available:.1f} GiB available", "" if available > MEMORY else "end other programs"
    return "unknown on this system", ""


def _compiler() -> Finding:
    command = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")[0]
    found = shutil.which(command)
    if found is None:
        return f"no {command}", "install a C compiler (`apt install gcc`), or set CC to yours"
    told = subprocess.run([found, "--version"], capture_output=True, text=True, timeout=20, check=False)
    return f"{found}, {(told.stdout or told.stderr).partition(chr(10))[0]}", ""


def _cache() -> Finding:
    folder = cache_folder()
    there = next(path for path in (folder, *folder.parents) if path.exists())
    free = shutil.disk_usage(there).free / 2**30
    value = f"{folder}, {'there' if there == folder else 'not made yet'}, {free:.1f} GiB free"
    try:
        tempfile.TemporaryFile(dir=there).close()
    except OSError as error:
        return value, f"{error.strerror}: make it writable, or set XDG_CACHE_HOME to a folder of yours"
    return value, "" if free > ROOM else "make room, or set XDG_CACHE_HOME to a folder on another disk"


def _mpiexec() -> Finding:
    found = shutil.which("mpiexec", path=str(Path(sys.executable).parent)) or shutil.which("mpiexec")
    return found or "none found: runs on one process only", ""


def _libraries() -> Finding:
    adios = "ADIOS2" if dolfinx.io.has_adios2 else "no ADIOS2 (so no fields.bp for ParaView)"
    if PETSc.Sys.hasExternalPackage("mumps"):
        return f"MUMPS, {adios}", ""
    return f"no MUMPS, {adios}", "use a PETSc with MUMPS, which large bodies and several processes need"


def _gmsh() -> Finding:
    from myostrain.geometry.gmsh_model import session

    with session() as gmsh:
        return str(gmsh.option.getString("General.Version")), ""


def _kernel() -> Finding:
    """The integral of X over the unit interval, by a kernel in a folder of its own, so that none is found."""
    mesh = dmesh.create_unit_interval(MPI.COMM_SELF, 4)
    with tempfile.TemporaryDirectory() as folder:
        form = ufl.SpatialCoordinate(mesh)[0] * ufl.dx(domain=mesh)
        options = {**jit_options(), "cache_dir": folder}
        integral = float(fem.assemble_scalar(fem.form(form, jit_options=options)))
    right = abs(integral - 0.5) < 1e-12
    return f"∫ X dX = {integral:.12g}", "" if right else "expected 0.5: the compiler is broken"


def _front() -> Finding:
    """Speed of the front of ``front-1d`` against (4.11), from the exact profile, extrapolated to h = 0."""
    c = float(speed(0.1, 0.3, diffusivity=100.0, A=100.0))
    coarse, fine = (_front_speed(spacing, c) / c for spacing in (1.0, 0.5))
    error = fine + (fine - coarse) / 3 - 1
    value = f"speed of a front {error:+.1e} from theory (accepted: {FRONT:.0e})"
    return value, "" if abs(error) <= FRONT else WRONG


def _front_speed(spacing: float, c: float) -> float:
    short = ["geometry.length=95.0", "probes={a=[40.0], b=[65.0]}", f"time.end={45 / c}"]
    case = Case.from_file(cases.path("front-1d"), [f"geometry.spacing={spacing}", *short])
    simulation = case.simulation(MPI.COMM_SELF)
    v = simulation.model.potential.v
    X = v.function_space.tabulate_dof_coordinates()[:, 0]
    v.x.array[:] = profile(25 - X, 0.1, 0.3, diffusivity=100.0, A=100.0)
    return float(simulation.run()["metrics"]["celerity"] or 0.0)


def _sheet() -> Finding:
    """Stretch along the fibre of a free sheet in plane stress, v = 1 everywhere: (1 − β)^(2/3)."""
    beta, fibre = 0.3, (2.0, 1.0)
    rectangle, fibres = geometry.Rectangle(size=(2.0, 1.0), spacing=0.25), geometry.UniformFibres(fibre)
    mechanics = Mechanics(
        geometry.build(rectangle, fibres, MPI.COMM_SELF),
        kinematics=kinematics.PlaneStress(),
        material=materials.NeoHookean(),
    )
    mechanics.activation.x.array[:] = activation.Proportional(beta=beta).activation((), {"excitation": 1.0})
    mechanics.start()
    u = mechanics.displacement()
    X = u.function_space.tabulate_dof_coordinates()[:, :2]
    affine, *_ = np.linalg.lstsq(np.column_stack([X, np.ones(len(X))]), u.x.array.reshape(-1, 2))
    error = np.linalg.norm(fibre @ (np.eye(2) + affine[:2])) / np.linalg.norm(fibre) - (1 - beta) ** (2 / 3)
    value = f"stretch of an active sheet {error:+.1e} from theory (accepted: {STRETCH:.0e})"
    return value, "" if abs(error) <= STRETCH else WRONG


def _files() -> Finding:
    with tempfile.TemporaryDirectory() as folder:
        write_atomically(path := Path(folder) / "check", text := "µ" * 100_000)
        same = path.read_text(encoding="utf-8") == text
    return tempfile.gettempdir(), "" if same else "a file is not what was written: check the disk"


#: The checks that can fail, by name.
LOOKS: dict[str, Callable[[], Finding]] = {
    "memory": _memory,
    "C compiler": _compiler,
    "kernel cache": _cache,
    "mpiexec": _mpiexec,
    "libraries": _libraries,
    "gmsh": _gmsh,
    "compile a kernel": _kernel,
    "front-1d": _front,
    "active sheet": _sheet,
    "write and read": _files,
}
