"""F, J, strain and stretch derived from a result folder are those of the run, at every place of a cell."""

import myostrain as ms
from myostrain.engine import fem
from myostrain.output.fields import FieldWriter

import numpy as np
import pytest
import ufl

from small_cases import ALONE, LINE, SHEET, SOLID, changed

STRAIN = changed(SHEET, {"mechanics.kinematics": "plane-strain", "material.model": "NeoHookean"})
NESTED = changed(SOLID, {"potential.refinement": 1, "geometry.size": [2.0, 1.0, 1.0]})
CASES = {"line": LINE, "plane-strain": STRAIN, "solid": SOLID, "nested": NESTED}

#: Places in a cell that no quadrature and no symmetry singles out.
ODD = {2: [[0.2, 0.8]], 3: [[0.2, 0.1, 0.7]], 4: [[0.2, 0.1, 0.4, 0.3]]}


def bent(x):
    """A quadratic displacement of points (3, n), with as many components."""
    return 0.01 * np.array([x[0] ** 2 + x[0] * x[1], x[1] ** 2 - x[0] * x[2] + x[1], x[0] * x[1] + x[2] ** 2])


def gradient(X):
    """1 + ∂u/∂X of it at X (..., 3)."""
    x, y, z = np.moveaxis(X, -1, 0)
    o = np.zeros_like(x)
    rows = [[2 * x + y, x, o], [-z, 2 * y + 1, -x], [y, x, 2 * z]]
    return np.eye(3) + 0.01 * np.moveaxis(np.array(rows), (0, 1), (-2, -1))


@pytest.fixture(scope="module", params=CASES)
def written(request, tmp_path_factory):
    """A model with that displacement, and the results it wrote."""
    folder = tmp_path_factory.mktemp(request.param)
    model = ms.Case.from_dict(CASES[request.param]).build(ALONE)
    mechanics = model.mechanics
    dim = model.potential.body.dim
    unknown = mechanics.u.sub(0) if mechanics.kinematics.has_pressure else mechanics.u
    unknown.interpolate(lambda x: bent(x)[:dim])
    names = ["displacement", "J", "velocity"]
    names += ["E", "F", "fibre_stretch"] if dim < 3 else []  # of a solid they take seconds to compile
    writer = FieldWriter(model, folder, names, {}, {"tr": ufl.tr(mechanics.deformation.F) ** 2})
    writer.write(0, 0.0)
    writer.close()
    return model, ms.open(folder, unfinished=True)


def test_the_gradient_is_exact_within_cells(written):
    """At corners, centres and an odd place: a quadratic displacement has a linear gradient."""
    model, run = written
    frame, dim = run.frames[0], model.potential.body.dim
    X = np.pad(run.frames.points, ((0, 0), (0, 3 - dim)))[run.frames.cells]
    for at in ("corners", ODD[dim + 1]):
        where = np.eye(dim + 1) if at == "corners" else np.array(at)
        exact = gradient(np.einsum("kc,mci->mki", where, X))[..., :dim, :dim]
        np.testing.assert_allclose(frame.F(at), exact, atol=1e-12)
        np.testing.assert_allclose(frame.J(at), np.linalg.det(exact), atol=1e-12)
        strain = (np.swapaxes(exact, -1, -2) @ exact - np.eye(dim)) / 2
        np.testing.assert_allclose(frame.E(at), strain, atol=1e-12)
    exact = gradient(X.mean(axis=1))[..., :dim, :dim]
    np.testing.assert_allclose(frame.F(), exact, atol=1e-12)
    f0 = np.array(CASES["solid"]["fibres"]["direction"])[:dim]
    f0 = np.array([1.0, -1.0]) / np.sqrt(2) if dim == 2 else f0
    np.testing.assert_allclose(frame.fibre_stretch(), np.linalg.norm(exact @ f0, axis=-1), atol=1e-12)


def test_fields_by_name_are_means_of_the_same(written):
    """Their integral over the body is that of what is derived: ∫ f dX by nodal masses and by cells."""
    model, run = written
    frame, dim = run.frames[0], model.potential.body.dim
    assert set(frame) >= {"J", "tr", "velocity"}
    if dim < 3:
        assert set(frame) >= {"E_xx", "F_xx", "fibre_stretch"}
        assert ("F_yx" in frame) == ("E_zz" in frame) == (dim > 1)
        assert dim == 1 or not frame["E_zz"].any()
        assert "F_xz" not in frame
    assert not frame["velocity"].any()
    if model.potential.body is not model.mechanics.body:
        return  # a finer mesh has what linear interpolation leaves
    masses = np.zeros(len(run.frames.points))
    share = np.repeat(run.frames.volumes / (dim + 1), dim + 1)
    np.add.at(masses, run.frames.cells.ravel(), share)
    # Three of Gauss' points a direction are exact for cubics; J of a solid is one.
    at, weights = cubic(dim)
    derived = {"J": frame.J(at), "E_xx": frame.E(at)[..., 0, 0], "F_xx": frame.F(at)[..., 0, 0]}
    for name in derived.keys() & set(frame):
        whole = np.einsum("mk,k,m->", derived[name], weights, run.frames.volumes)
        np.testing.assert_allclose(masses @ frame[name], whole, rtol=1e-12)


def cubic(dim):
    """Barycentric places and weights that integrate cubics: Grundmann and Möller's rule of degree 3."""
    n = dim
    inner = np.full((n + 1, n + 1), 1 / (n + 3)) + 2 / (n + 3) * np.eye(n + 1)
    high, low = (n + 3) ** 2 / (4 * (n + 1) * (n + 2)), -((n + 1) ** 2) / (4 * (n + 2))
    return np.vstack([inner, np.full((1, n + 1), 1 / (n + 1))]), np.array([high] * (n + 1) + [low])


#: Edges whose middles follow the corners in VTK's quadratic cells.
EDGES = {1: [(0, 1)], 2: [(0, 1), (1, 2), (2, 0)], 3: [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]}


def test_quadratic_grids_bend(written):
    """Middles of edges are where VTK has them, with the displacement there itself."""
    model, run = written
    frame, dim = run.frames[0], model.potential.body.dim
    grid = frame.grid(quadratic=True)
    cells = grid.cells.reshape(len(run.frames.cells), -1)[:, 1:]
    for number, ends in enumerate(EDGES[dim]):
        middle = grid.points[cells[:, ends]].mean(axis=1)
        np.testing.assert_allclose(grid.points[cells[:, dim + 1 + number]], middle, atol=1e-6)
    bending = grid.point_data["displacement"][:, :dim] - bent(grid.points.T)[:dim].T
    np.testing.assert_allclose(bending, 0.0, atol=1e-12)
    moved = frame.grid(deformed=True, quadratic=True).points - grid.points
    np.testing.assert_allclose(moved, grid.point_data["displacement"], atol=1e-6)


def test_velocity_is_of_second_order():
    """Of what moves with t² it is exact from the third configuration on."""
    from myostrain.history import History
    from myostrain.mechanics.motion import velocity_of

    body = ms.build(ms.geometry.Line(length=2.0, spacing=1.0), comm=ALONE)
    u = fem.Function(fem.functionspace(body.mesh, ("Lagrange", 1)))
    history = History(u, depth=3)
    for time, exact in ((0.0, 0.0), (0.5, 0.5), (0.8, 1.6)):
        u.x.array[:] = time**2
        history.push(time)
        np.testing.assert_allclose(velocity_of(None, history, u), exact, atol=1e-14)


def test_what_a_model_does_not_have_is_said(tmp_path):
    model = ms.Case.from_dict(LINE).build(ALONE)
    for name, words in {
        "tension": "yields a strain",
        "calcium": "has none",
        "pressure": "constraint",
    }.items():
        with pytest.raises(ms.InputError, match=rf"output.fields: .*'{name}'.*{words}"):
            FieldWriter(model, tmp_path, [name])
    other = ms.build(ms.geometry.Line(length=2.0, spacing=1.0), comm=ALONE)
    for name, expression, words in (
        ("J", model.potential.v, "cannot be the name"),
        ("a b", model.potential.v, "cannot be the name"),
        ("own", "text", "give a UFL expression"),
        ("own", other.f0, "another mesh"),
        ("own", ufl.TestFunction(model.potential.v.function_space), "test or trial"),
    ):
        with pytest.raises(ms.InputError, match=words):
            FieldWriter(model, tmp_path, [], {}, {name: expression})


def test_stress_and_pressure_of_a_pulled_sheet(tmp_path):
    """Plane strain, σ = μ B − p 1 with det F = 1: pulled at by the traction σ, free above.

    So σ_yy = 0, σ_xx = μ (λ² − λ⁻²), p = μ λ⁻², and σ_zz = μ − p.
    """
    body = ms.build(ms.geometry.Rectangle(size=(2.0, 1.0), spacing=1.0), ms.UniformFibres(direction=(1, 0)))
    mu, stretch = 1.5, 1.1
    pull = mu * (stretch**2 - stretch**-2)
    mechanics = ms.Mechanics(
        body,
        kinematics=ms.kinematics.PlaneStrain(),
        material=ms.materials.NeoHookean(mu=mu),
        supports=ms.Supports(sliding=["left", "bottom"]),
        loads=ms.Loads(pressure={"right": ((0.0, 0.0), (1.0, -pull))}),
    )
    model = ms.Electromechanics(
        ms.GivenPotential(body, drive=ms.Drive(potential=0.0)),
        mechanics,
        law=ms.activation.Proportional(beta=0.1),
    )
    fields = ["cauchy_stress", "pressure", "gamma", "displacement"]
    ms.Simulation(model, step=0.25, end=1.0, every=1.0, out=tmp_path / "out", fields=fields).run()
    last = ms.open(tmp_path / "out").frames[-1]
    expected = {
        "cauchy_stress_xx": pull,
        "cauchy_stress_yy": 0.0,
        "cauchy_stress_zz": mu - mu / stretch**2,
        "cauchy_stress_xy": 0.0,
        "pressure": mu / stretch**2,
        "gamma": 0.0,
    }
    for name, value in expected.items():
        np.testing.assert_allclose(last[name], value, atol=1e-7, err_msg=name)
    np.testing.assert_allclose(last.fibre_stretch(), stretch, atol=1e-8)


def test_calcium_and_activation_times_are_those_of_the_run(tmp_path):
    """The state that the membrane calls its calcium; times so far, NaN before, and at the end the run's."""
    body = ms.build(ms.geometry.Line(length=4.0, spacing=0.5))
    pacer = ms.Stimulus(
        where=ms.Place(boundary=["left"], depth=1.0), strength=0.3, duration=5.0, period=400.0, count=1
    )
    potential = ms.Potential(
        body, membrane=ms.membranes.MitchellSchaeffer2003(), diffusivity=0.1, mass="averaged", stimuli=[pacer]
    )
    fields = ["activation_times", "potential"]
    simulation = ms.Simulation(
        ms.Electromechanics(potential), step=0.5, end=40.0, every=4.0, out=tmp_path / "out", fields=fields
    )
    simulation.run()
    run = ms.open(tmp_path / "out")
    times = run.activation_times.values[0]
    assert np.isfinite(times).all()
    assert np.ptp(times) > 4.0
    for frame in run.frames:
        assert (np.isnan(frame["activation_times"]) == (times > frame.time)).all()
    np.testing.assert_array_equal(run.frames[-1]["activation_times"], times)
    membrane = ms.membranes.BuenoOrovio2008()
    rigid = ms.Electromechanics(ms.Potential(body, membrane=membrane, diffusivity=0.1))
    fields = ["calcium", "states"]
    ms.Simulation(rigid, step=0.1, end=0.2, every=0.1, out=tmp_path / "other", fields=fields).run()
    last = ms.open(tmp_path / "other").frames[-1]
    np.testing.assert_array_equal(last["calcium"], last[membrane.calcium])
