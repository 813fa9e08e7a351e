"""Products and substitutions that factorizations use."""

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


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("columns", [1, 3])
def test_products_and_substitutions_of_a_column(kind, columns, path):
    """What BLAS says of alpha op(A) op(B) + beta C and of op(A)⁻¹ B: one column takes another way."""
    dtype, number, error = KINDS[kind]
    library, random = blas.based_on(path, blas.wheel()), np.random.default_rng(2)
    rows, depth = 9, 7
    for a_as, b_as in itertools.product("NT", "NT"):
        a, b, c = (
            random.random(s).astype(dtype) for s in [(rows, depth), (depth, columns), (rows + 3, columns)]
        )
        wanted = -1.5 * (a @ b) + 0.5 * c[:rows]
        found = np.asfortranarray(c)
        left, right = (np.asfortranarray(m if way == "N" else m.T) for m, way in ((a, a_as), (b, b_as)))
        integers = [ctypes.c_int(n) for n in (rows, columns, depth, len(left), len(right), rows + 3)]
        m, n, k, lda, ldb, ldc = (ctypes.byref(integer) for integer in integers)
        alpha, beta = ctypes.byref(number(-1.5)), ctypes.byref(number(0.5))
        pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in (left, right, found)]
        getattr(library, f"{kind}gemm_")(
            a_as.encode(),
            b_as.encode(),
            m,
            n,
            k,
            alpha,
            pointers[0],
            lda,
            pointers[1],
            ldb,
            beta,
            pointers[2],
            ldc,
        )
        assert np.abs(found[:rows] - wanted).max() < error * np.abs(wanted).max()
        assert (found[rows:] == c[rows:]).all()
    a = random.random((rows, rows)).astype(dtype) + rows * np.eye(rows, dtype=dtype)
    for side, triangle, a_as, diagonal, factor in itertools.product("LR", "UL", "NT", "NU", (1.0, 2.0)):
        shape = (rows, columns) if side == "L" else (columns, rows)
        b = random.random(shape).astype(dtype)
        matrix = (np.triu if triangle == "U" else np.tril)(a).astype(float)
        if diagonal == "U":
            np.fill_diagonal(matrix, 1.0)
        matrix = matrix if a_as == "N" else matrix.T
        given = factor * b.astype(float)
        wanted = np.linalg.solve(matrix, given) if side == "L" else np.linalg.solve(matrix.T, given.T).T
        left, found = np.asfortranarray(a), np.asfortranarray(b)
        integers = [ctypes.c_int(n) for n in (*shape, rows, shape[0])]
        m, n, lda, ldb = (ctypes.byref(integer) for integer in integers)
        words = [word.encode() for word in (side, triangle, a_as, diagonal)]
        pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in (left, found)]
        getattr(library, f"{kind}trsm_")(
            *words, m, n, ctypes.byref(number(factor)), pointers[0], lda, pointers[1], ldb
        )
        assert np.abs(found - wanted).max() < error * np.abs(wanted).max()


def test_petsc_finds_it_first(path):
    """The linker's global names, searched before PETSc's own libraries, have them when PETSc is loaded."""
    program = (
        "import ctypes, sys, myostrain.blas as blas; from myostrain.kernel_cache import cache_folder\n"
        "assert 'petsc4py.PETSc' not in sys.modules; import myostrain.engine\n"
        "ours = ctypes.CDLL(sys.argv[1])\n"
        "for name in ('dgemmt_', 'sgemmt_', 'sgemm_', 'dtrsm_'):\n"
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
