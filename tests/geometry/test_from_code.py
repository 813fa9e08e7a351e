"""Fibres by functions of a script, and bodies of a model that gmsh has in memory."""

import myostrain as ms
from myostrain.engine import compile_form, fem
from myostrain.output.fields import cell_fibres

import gmsh
import numpy as np
import pytest
import ufl

from small_cases import ALONE

SQUARE = ms.geometry.Rectangle(size=(2.0, 1.0), spacing=0.5)
CUBE = ms.geometry.Slab(size=(1.0, 1.0, 1.0), spacing=1.0)


def turning(X):
    """Directions that turn faster and faster, twice as long as units."""
    return 2 * np.column_stack([np.cos(X[:, 0] ** 2 / 2), np.sin(X[:, 0] ** 2 / 2)])


def error(body):
    """Root mean square of the sine of the angle to :func:`turning`."""
    angle = ufl.SpatialCoordinate(body.mesh)[0] ** 2 / 2
    sine = body.f0[0] * ufl.sin(angle) - body.f0[1] * ufl.cos(angle)
    return float(
        np.sqrt(fem.assemble_scalar(compile_form(sine**2 * ufl.dx(metadata={"quadrature_degree": 6}))))
    )


def test_directions_are_of_second_order():
    errors = [
        error(ms.build(ms.geometry.Rectangle(size=(2.0, 1.0), spacing=h), ms.FunctionFibres(turning), ALONE))
        for h in (0.25, 0.125)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)
    f0 = cell_fibres(ms.build(SQUARE, ms.FunctionFibres(turning), ALONE))
    np.testing.assert_allclose(np.linalg.norm(f0, axis=1), 1.0)


def test_a_symbolic_function_is_exact():
    def symbolic(X):
        return ufl.as_vector([ufl.cos(X[0] ** 2 / 2), ufl.sin(X[0] ** 2 / 2)])

    assert error(ms.build(SQUARE, ms.FunctionFibres(symbolic, symbolic=True), ALONE)) < 1e-14


def test_opposite_directions_are_one_fibre_and_jumps_stay():
    """A sense that flips within cells changes nothing; a jump between two columns of cells is sharp."""

    def flipping(X):
        return turning(X) * np.sign(np.sin(40 * X[:, :1]) + 1e-9)

    plain, flipped = (ms.build(SQUARE, ms.FunctionFibres(f), ALONE) for f in (turning, flipping))
    assert error(flipped) == pytest.approx(error(plain), rel=1e-9)

    def jumping(X):
        return np.where(X[:, :1] < 1.0, [[1.0, 0.0]], [[0.0, 1.0]])

    body = ms.build(SQUARE, ms.FunctionFibres(jumping), ALONE)
    centres = body.mesh.geometry.x[body.mesh.geometry.dofmaps[0]].mean(axis=1)
    np.testing.assert_allclose(cell_fibres(body), jumping(centres), atol=1e-12)


def test_sheets_are_across():
    """Orthonormal directions in a solid, with the part of the sheet that is across the fibre."""
    fibres = ms.FunctionFibres(
        lambda X: np.tile([1.0, 1.0, 0.0], (len(X), 1)), lambda X: X + np.array([3.0, 0.0, 1.0])
    )
    body = ms.build(CUBE, fibres, ALONE)
    parts = body.fibres
    gram = [[ufl.dot(a, b) for a in (parts.f0, parts.s0, parts.n0)] for b in (parts.f0, parts.s0, parts.n0)]
    cells = np.arange(body.cells, dtype=np.int32)
    values = fem.Expression(ufl.as_matrix(gram), np.full((1, 3), 0.2)).eval(body.mesh, cells)
    np.testing.assert_allclose(
        values[:, 0].reshape(-1, 3, 3), np.tile(np.eye(3), (len(cells), 1, 1)), atol=1e-12
    )


@pytest.mark.parametrize(
    "fibres, words",
    [
        (lambda: ms.FunctionFibres((1.0, 0.0)), r"FunctionFibres\.fibre: give a function of points X"),
        (lambda: ms.FunctionFibres(lambda X: X.T), r"fibre: gives the shape \(2, \d+\) for points"),
        (lambda: ms.FunctionFibres(lambda X: 0 * X), r"fibre: gives \[.*\] at \[.*finite vector"),
        (lambda: ms.FunctionFibres(lambda X: X[:, 2:]), r"fibre: gives the shape"),
        (lambda: ms.FunctionFibres(lambda X, Y: X), r"fibre: raises TypeError.*points of shape \(n, 2\)"),
        (lambda: ms.FunctionFibres(turning, turning), r"sheet: a sheet direction is for a solid"),
        (lambda: ms.FunctionFibres(turning, symbolic=True), r"fibre: raises .*symbolic=True takes UFL only"),
        (lambda: ms.FunctionFibres(lambda X: X[0], symbolic=True), r"fibre: gives the shape \(\)"),
    ],
)
def test_what_gives_no_directions_is_said(fibres, words):
    with pytest.raises(ms.InputError, match=words):
        ms.build(SQUARE, fibres(), ALONE)


@pytest.fixture
def model():
    """A plate of two regions, meshed, with a named edge; gmsh is closed at the end."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("plate")
    occ = gmsh.model.occ
    halves, _ = occ.fragment([(2, occ.addRectangle(x, 0, 0, 1, 1)) for x in (0, 1)], [])
    occ.synchronize()
    for name, (_, tag) in zip(("inner", "outer"), halves, strict=True):
        gmsh.model.addPhysicalGroup(2, [tag], name=name)
    left = gmsh.model.getEntitiesInBoundingBox(-1e-6, -1e-6, -1e-6, 1e-6, 2, 1e-6, dim=1)
    gmsh.model.addPhysicalGroup(1, [tag for _, tag in left], name="left")
    yield gmsh.model
    gmsh.finalize()


def test_a_model_in_memory_is_a_body(model, tmp_path):
    """The same as its file; the model stays open, and may be taken by its name."""
    model.mesh.generate(2)
    fibres = ms.UniformFibres(direction=(1.0, 0.0), regions={"outer": (0.0, 1.0)})
    body = ms.build(ms.geometry.GmshModel(), fibres, ALONE)
    assert (sorted(body.meshed.regions), sorted(body.meshed.boundaries)) == (["inner", "outer"], ["left"])
    assert fem.assemble_scalar(fem.form(fem.Constant(body.mesh, 1.0) * ufl.dx)) == pytest.approx(2.0)
    model.add("other")
    named = ms.build(ms.geometry.GmshModel(name="plate"), fibres, ALONE)
    np.testing.assert_array_equal(named.mesh.geometry.x, body.mesh.geometry.x)
    assert gmsh.isInitialized()


def test_a_model_that_is_no_body_is_said(model):
    with pytest.raises(ms.InputError, match=r"the model in gmsh is not meshed: call .*generate\(2\)"):
        ms.geometry.GmshModel().mesh(ALONE)
    with pytest.raises(ms.InputError, match="gmsh has no model 'plaet'; did you mean 'plate'"):
        ms.geometry.GmshModel(name="plaet").mesh(ALONE)
    model.add("empty")
    with pytest.raises(ms.InputError, match=r"is empty: make it and mesh it"):
        ms.geometry.GmshModel().mesh(ALONE)


@pytest.mark.mpi
def test_a_model_of_the_first_process_is_spread(on_processes):
    """Two processes, of which one has the model; fibres by a function, and its errors on both."""
    code = """
import myostrain as ms, numpy as np
from mpi4py import MPI
rank = MPI.COMM_WORLD.rank
if rank == 0:
    import gmsh
    gmsh.initialize(); gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.occ.addRectangle(0, 0, 0, 1, 1); gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(2, [1], name="body"); gmsh.model.mesh.generate(2)
body = ms.build(ms.geometry.GmshModel(), ms.FunctionFibres(lambda X: X + 1))
assert body.cells == MPI.COMM_WORLD.allreduce(body.mesh.topology.index_map(2).size_local)
assert body.mesh.topology.index_map(2).size_local < body.cells
try:
    ms.build(ms.geometry.GmshModel(), ms.FunctionFibres(lambda X: X + 1 if rank else 1 / 0))
except ms.InputError as error:
    print("said", error, flush=True)
"""
    assert on_processes(2, code).count("raises ZeroDivisionError") == 2
