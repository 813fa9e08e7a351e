"""The product in one triangle that factorizations use."""

import ctypes
import itertools
import subprocess
import sys

from myostrain import blas
from myostrain.kernel_cache import cache_folder

import numpy as np
import pytest

KINDS = {"d": (np.float64, ctypes.c_double, 1e-13), "s": (np.float32, ctypes.c_float, 1e-4)}


@pytest.fixture(scope="module")
def path():
    if blas.wheel() is None or (found := blas.compiled(cache_folder())) is None:
        pytest.skip("no compiler, or a DOLFINx that is not from the wheel")
    return found


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", [1, 5, 64, 150])
def test_the_product_in_a_triangle(kind, size, path):
    """What BLAS says of it: one triangle of alpha op(A) op(B) + beta C; the other one stays as it was."""
    dtype, number, error = KINDS[kind]
    product, random = getattr(blas.based_on(path, blas.wheel()), f"{kind}gemmt_"), np.random.default_rng(1)
    depth = 7
    for triangle, a_as, b_as in itertools.product("UL", "NT", "NT"):
        a, b, c = (
            random.random(shape).astype(dtype) for shape in [(size, depth), (depth, size), (size + 3, size)]
        )
        wanted = 2.0 * (a @ b) + 0.5 * c[:size]
        inside = (np.triu if triangle == "U" else np.tril)(np.ones((size, size), dtype=bool))
        # By columns, as Fortran has them, with leading dimensions of their own.
        found = np.asfortranarray(c)
        left, right = (np.asfortranarray(m if way == "N" else m.T) for m, way in ((a, a_as), (b, b_as)))
        integers = [ctypes.c_int(n) for n in (size, depth, len(left), len(right), size + 3)]
        n, k, lda, ldb, ldc = (ctypes.byref(integer) for integer in integers)
        alpha, beta = ctypes.byref(number(2.0)), ctypes.byref(number(0.5))
        pointers = [m.ctypes.data_as(ctypes.c_void_p) for m in (left, right, found)]
        words = [word.encode() for word in (triangle, a_as, b_as)]
        product(*words, n, k, alpha, pointers[0], lda, pointers[1], ldb, beta, pointers[2], ldc)
        assert np.abs(found[:size] - wanted)[inside].max() < error * np.abs(wanted).max()
        assert (found[:size][~inside] == c[:size][~inside]).all()
        assert (found[size:] == c[size:]).all()


def test_petsc_finds_it_first(path):
    """The linker's global names, searched before PETSc's own libraries, have it when PETSc is loaded."""
    program = (
        "import ctypes, sys, myostrain.blas as blas; from myostrain.kernel_cache import cache_folder\n"
        "assert 'petsc4py.PETSc' not in sys.modules; import myostrain.engine\n"
        "ours = ctypes.CDLL(sys.argv[1])\n"
        "for name in ('dgemmt_', 'sgemmt_'):\n"
        "    first, wanted = (ctypes.cast(l[name], ctypes.c_void_p) for l in (ctypes.CDLL(None), ours))\n"
        "    assert first.value == wanted.value\n"
        "assert not blas.hasten(cache_folder())  # too late now\n"
    )
    subprocess.run([sys.executable, "-c", program, str(path)], check=True)


def test_without_a_compiler(tmp_path, monkeypatch):
    """Then nothing is there, and nothing fails."""
    monkeypatch.setenv("CC", "no-such-compiler")
    assert blas.compiled(tmp_path) is None
    monkeypatch.setenv("MYOSTRAIN_NO_COMPILER", "1")
    assert blas.compiled(tmp_path) is None
