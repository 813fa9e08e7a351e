"""`myostrain doctor`: all is well here, and everything that it looks at can fail."""

import subprocess
import sys

from myostrain import doctor
from myostrain.activation import Proportional
from myostrain.engine import PETSc, versions

import numpy as np
import pytest

SELF_CHECKS = ("compile a kernel", "front-1d", "active sheet", "write and read")


def only(monkeypatch, *names):
    """Leave out the other checks."""
    monkeypatch.setattr(doctor, "LOOKS", {name: doctor.LOOKS[name] for name in names})


def told():
    """Exit status and lines of a report."""
    lines = []
    return doctor.report(lines.append), lines


def test_all_is_well_and_every_part_is_named():
    """The issue: versions, platform, compiler, cache, MPI, libraries, and a self-check; 0 if all is well."""
    status, lines = told()
    assert status == 0, lines
    assert lines[-1] == "all is well"
    assert all(line.endswith("  ok") for line in lines[:-1])
    names = [line[:18].rstrip() for line in lines[:-1]]
    assert names == [*versions(), "platform", "OMP_NUM_THREADS", *doctor.LOOKS]
    assert set(SELF_CHECKS) < set(names)
    text = "\n".join(lines)
    for word in (versions()["petsc"], "usable cores", "GiB available", "GiB free", "mpiexec", "MUMPS"):
        assert word in text


@pytest.mark.parametrize("factor", [1 - 2e-4, 1 + 2e-4])
def test_a_wrong_speed_of_fronts_fails(monkeypatch, factor):
    """The front is compared with (4.11), within 1e-4: off by 2e-4 either way is a failure."""
    only(monkeypatch, "front-1d")
    right = doctor.speed
    monkeypatch.setattr(doctor, "speed", lambda *a, **k: factor * right(*a, **k))
    status, lines = told()
    assert status == 1
    assert "front-1d" in lines[-2]
    assert doctor.WRONG in lines[-2]
    assert lines[-1] == "1 of the checks failed"


def test_a_wrong_activation_fails_sheet_and_front(monkeypatch):
    """Planted: γ = −1.01 β v. The front of another β has another speed, the sheet another stretch."""
    only(monkeypatch, "front-1d", "active sheet")
    wrong = lambda self, states, drivers: -1.01 * self.beta * drivers["excitation"]  # noqa: E731
    monkeypatch.setattr(Proportional, "activation", wrong)
    status, lines = told()
    assert status == 1
    assert sum("FAILED" in line for line in lines) == 2


def test_the_band_of_the_front_is_that_of_its_error():
    """The speed extrapolated from two spacings is far nearer to (4.11) than the band, each alone is not.

    Measured: −6.8e-3 at h = 1, −1.70e-3 at h = 1/2 (a ratio of 3.99: second order), extrapolated −7e-6.
    """
    c = float(doctor.speed(0.1, 0.3, diffusivity=100.0, A=100.0))
    coarse, fine = (doctor._front_speed(spacing, c) / c - 1 for spacing in (1.0, 0.5))
    extrapolated = fine + (fine - coarse) / 3
    assert abs(extrapolated) < doctor.FRONT / 5
    assert min(abs(coarse), abs(fine)) > 10 * doctor.FRONT
    assert 3.9 < coarse / fine < 4.1


def no_compiler(monkeypatch, tmp_path):
    monkeypatch.setenv("CC", "no-such-compiler -O2")


def broken_compiler(monkeypatch, tmp_path):
    monkeypatch.setenv("CC", "false")


def cache_below_a_file(monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setattr(doctor, "cache_folder", lambda: tmp_path / "file" / "kernels")


def full_disk(monkeypatch, tmp_path):
    monkeypatch.setattr(doctor, "ROOM", 1e9)


def no_memory(monkeypatch, tmp_path):
    monkeypatch.setattr(doctor, "MEMORY", 1e9)


def no_mumps(monkeypatch, tmp_path):
    monkeypatch.setattr(PETSc.Sys, "hasExternalPackage", lambda name: False)


def no_gmsh(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "gmsh", None)


def strange_disk(monkeypatch, tmp_path):
    monkeypatch.setattr(doctor, "write_atomically", lambda path, text: path.write_text(text[1:]))


def wrong_sum(monkeypatch, tmp_path):
    monkeypatch.setattr(doctor.fem, "assemble_scalar", lambda form: np.float64(0.51))


@pytest.mark.parametrize(
    "plant, name, words",
    [
        (no_compiler, "C compiler", "apt install gcc"),
        (broken_compiler, "compile a kernel", "Error"),
        (cache_below_a_file, "kernel cache", "XDG_CACHE_HOME"),
        (full_disk, "kernel cache", "make room"),
        (no_memory, "memory", "end other programs"),
        (no_mumps, "libraries", "a PETSc with MUMPS"),
        (no_gmsh, "gmsh", "libglu1-mesa"),
        (strange_disk, "write and read", "check the disk"),
        (wrong_sum, "compile a kernel", "expected 0.5"),
    ],
)
def test_each_check_can_fail_and_says_what_to_do(monkeypatch, tmp_path, plant, name, words):
    only(monkeypatch, name)
    plant(monkeypatch, tmp_path)
    status, lines = told()
    assert status == 1
    assert lines[-2].startswith(name)
    assert "FAILED" in lines[-2]
    assert words in lines[-2]


def test_what_is_missing_on_other_systems_is_no_failure(monkeypatch):
    """Without mpiexec and ADIOS2 everything but several processes and `fields.bp` works."""
    only(monkeypatch, "mpiexec", "libraries")
    monkeypatch.setattr(doctor.shutil, "which", lambda *a, **k: None)
    monkeypatch.setattr(doctor.dolfinx.io, "has_adios2", False)
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    status, lines = told()
    assert status == 0
    text = "\n".join(lines)
    assert "none found" in text
    assert "no ADIOS2" in text
    assert "not set" in text


def test_it_prints_by_default():
    """For scripts: `python -c "from myostrain.doctor import report; report()"` prints."""
    short = "from myostrain import doctor; doctor.LOOKS = {}; raise SystemExit(doctor.report())"
    done = subprocess.run([sys.executable, "-c", short], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "all is well"
