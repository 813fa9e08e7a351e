"""What imports load, and that their order does not matter."""

import os
import subprocess
import sys

import myostrain as ms

import pytest

#: Names of what takes long to load, or starts MPI.
HEAVY = ("dolfinx", "mpi4py", "petsc4py", "ufl", "pydantic", "scipy", "gmsh", "matplotlib", "numba", "vtk")


def run(code, **more):
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | more
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, env=environment
    )


def loaded(code):
    """Which of the heavy packages are there after some code."""
    done = run(f"{code}\nimport sys; print('|', *[n for n in {HEAVY} if n in sys.modules])", **os.environ)
    assert done.returncode == 0, done.stderr
    return done.stdout.rpartition("|")[2].split()


@pytest.mark.parametrize(
    "imports",
    [
        "import dolfinx; import myostrain as ms",
        "import myostrain as ms; import dolfinx",
        "from petsc4py import PETSc; import myostrain as ms",
        "import dolfinx.fem.petsc; import myostrain as ms",
    ],
)
def test_the_order_of_imports_does_not_matter(imports):
    """`import dolfinx` first, as every FEniCSx user and isort write it, found no libmpi.so.12.

    The environment's own installation is what is tested: `uv sync` puts the .pth file into it.
    """
    done = run(f"{imports}; print(ms.Simulation.__name__)")
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "Simulation"


def test_the_start_of_python_loads_nothing_of_it():
    """The module that the .pth file names needs no other one."""
    done = run("import sys; print('myostrain_engine_first' in sys.modules, 'myostrain' in sys.modules)")
    assert done.stdout.split() == ["True", "False"]


def test_without_the_wheel_nothing_stands_in_the_way(tmp_path):
    """A DOLFINx of another origin, or none at all, is imported or missed as ever."""
    (tmp_path / "dolfinx.py").write_text("origin = 'elsewhere'\n")
    code = f"import sys; sys.modules['dolfinx_solver'] = None; sys.path.insert(0, {str(tmp_path)!r})\n"
    done = run(
        code + "import dolfinx; print(dolfinx.origin)\ntry:\n import slepc4py\nexcept ImportError: pass"
    )
    assert done.stdout.split() == ["elsewhere"], done.stderr


def test_importing_myostrain_loads_neither_mpi_nor_dolfinx():
    assert loaded("import myostrain") == []
    assert loaded("import myostrain; myostrain.__version__; dir(myostrain); myostrain.InputError") == []


@pytest.mark.parametrize("arguments", [["--help"], ["list"], ["show", "sheet-2d"], ["run", "--help"]])
def test_commands_that_compute_nothing_load_nothing(arguments):
    found = loaded(f"from myostrain.cli import app; app({arguments}, standalone_mode=False)")
    assert set(found) <= {"pydantic"}  # Typer's own


def test_every_public_name_is_there():
    assert sorted(ms.__all__) == ms.__all__
    for name in ms.__all__:
        assert getattr(ms, name) is not None, name
    assert set(ms.__all__) <= set(dir(ms))


def test_old_names_say_what_they_are_now():
    for name, message in ms._OLD.items():
        with pytest.raises(AttributeError) as error:
            getattr(ms, name)
        assert str(error.value) == message
    assert not hasattr(ms, "cells")
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        ms.nothing  # noqa: B018


def test_the_command_line_goes_without_numba_and_leaves_it_usable():
    """FFCx imports Numba where it is installed, which takes longer than all else together."""
    pytest.importorskip("numba")
    code = "from myostrain import cli; cli._load_engine()"
    assert "numba" not in loaded(code)
    assert "numba" in loaded(f"{code}; import numba; numba.njit")
