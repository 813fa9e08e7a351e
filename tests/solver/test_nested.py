"""The potential on a mesh that is nested in that of the mechanics."""

import myostrain as ms
from myostrain.engine import fem
from myostrain.geometry import refined
from myostrain.transfer import SameMesh

import numpy as np
import pytest
import ufl

from coupled import TIGHT, advance, coordinates, gaussian

STRIP = ms.geometry.Line(length=40.0, spacing=2.0)
SHEET = ms.geometry.Rectangle(size=(30.0, 20.0), spacing=2.5)
SLAB = ms.geometry.Slab(size=(3.0, 2.0, 2.0), spacing=1.0)


def mechanics_on(geometry, kinematics, *, stretch=None, levels=0):
    """A body of the paper's materials, fixed at the left, or a sheet on the elastic support."""
    line, sheet = (isinstance(geometry, g) for g in (ms.geometry.Line, ms.geometry.Rectangle))
    fibres = None if line else ms.UniformFibres(direction=(1.0, -1.0, 0.0)[: kinematics.dim])
    return ms.Mechanics(
        refined(ms.build(geometry, fibres), levels),
        kinematics=kinematics,
        material=ms.materials.Spring() if line else ms.materials.NeoHookean(),
        supports=ms.Supports(robin=1.0) if sheet else ms.Supports(fixed=["left"]),
        imposed_stretch=None if stretch is None else ms.ImposedStretch(value=stretch, until=np.inf),
        tolerance=1e-11,
    )


def nested(mechanics, levels, scheme=None, **parts):
    """The coupled problem with the potential on a finer mesh, a bump at the origin."""
    fine = refined(mechanics.body, levels)
    transfer = ms.NestedMesh(mechanics, fine) if levels else SameMesh(mechanics)
    potential = ms.Potential(
        fine,
        membrane=ms.membranes.FitzHughNagumo(),
        diffusivity=(100.0, 40.0) if fine.dim > 1 else 100.0,
        deformation=transfer.deformation,
        options=TIGHT,
        **parts,
    )
    model = ms.Electromechanics(potential, mechanics, scheme=scheme, transfer=transfer)
    potential.v.x.array[:] = gaussian(np.linalg.norm(coordinates(potential), axis=1))
    return model


def by_place(model):
    """The potential in the order of the nodes' places."""
    X = np.round(coordinates(model.potential), 9)
    return model.potential.v.x.array[np.lexsort(X.T)].copy()


KINDS = {
    "line": (STRIP, ms.kinematics.Line()),
    "plane-stress": (SHEET, ms.kinematics.PlaneStress()),
    "elastic": (SHEET, ms.kinematics.PlaneStress(constraint="elastic")),
    "plane-strain": (SHEET, ms.kinematics.PlaneStrain(constraint="elastic")),
    "solid": (SLAB, ms.kinematics.Solid(bulk_modulus=50.0)),
}


@pytest.fixture(scope="module", params=KINDS)
def kind(request):
    """A transfer to two levels of refinement, of every kind of F and J."""
    mechanics = mechanics_on(*KINDS[request.param])
    return mechanics, ms.NestedMesh(mechanics, refined(mechanics.body, 2))


def points(space):
    """Coordinates of a space's nodes, (nodes, dim)."""
    return space.tabulate_dof_coordinates()[:, : space.mesh.geometry.dim]


def test_linear_activation_is_handed_back_as_it_is(kind):
    """The projection keeps linear functions, and interpolation takes them forth."""
    mechanics, transfer = kind
    coarse = points(mechanics.activation.function_space)
    fine = points(fem.functionspace(transfer.mesh, ("Lagrange", 1)))
    slope = np.arange(1.0, 1.0 + coarse.shape[1])
    np.testing.assert_allclose(transfer.to_mechanics(fine @ slope - 3), coarse @ slope - 3, atol=1e-9)
    several = np.stack([coarse @ slope, 1 - coarse @ slope], axis=1)
    wanted = np.stack([fine @ slope, 1 - fine @ slope], axis=1)
    np.testing.assert_allclose(transfer.to_potential(several), wanted, atol=1e-12)


def test_the_integral_is_kept(kind):
    """Of whatever there is at the potential's nodes, against every linear function on the other mesh."""
    mechanics, transfer = kind
    space = fem.functionspace(transfer.mesh, ("Lagrange", 1))
    gamma = fem.Function(space)
    gamma.x.array[:] = np.random.default_rng(0).normal(size=len(gamma.x.array))
    back = fem.Function(mechanics.activation.function_space)
    back.x.array[:] = transfer.to_mechanics(gamma.x.array)
    for number in range(1 + mechanics.body.dim):
        moments = []
        for f in (gamma, back):
            X = ufl.SpatialCoordinate(f.function_space.mesh)
            by = 1 if number == 0 else X[number - 1]
            moments.append(fem.assemble_scalar(fem.form(f * by * ufl.dx)))
        assert moments[1] == pytest.approx(moments[0], rel=1e-9, abs=1e-9)


def test_a_steep_front_overshoots_in_the_projection():
    """Documentation: by a tenth where it is as wide as a coarse cell, by under 1 % where as wide as two."""
    mechanics = mechanics_on(
        ms.geometry.Rectangle(size=(40.0, 20.0), spacing=1.0), ms.kinematics.PlaneStress()
    )
    transfer = ms.NestedMesh(mechanics, refined(mechanics.body, 1))
    X = points(fem.functionspace(transfer.mesh, ("Lagrange", 1)))
    depth = X @ (1.0, 0.3) - 20
    beyond = {}
    for width in (0.01, 1.0, 2.0):  # from 10 to 90 % of the jump
        gamma = 0.5 * (1 - np.tanh(2.2 * depth / width))
        found = transfer.to_mechanics(gamma)
        beyond[width] = max(found.max() - 1, -found.min())
    assert 0.15 < beyond[0.01] < 0.26
    assert 0.05 < beyond[1.0] < 0.12
    assert beyond[2.0] < 0.01


def test_what_is_not_finite_is_said():
    """Not a displacement of NaN."""
    mechanics = mechanics_on(*KINDS["line"])
    transfer = ms.NestedMesh(mechanics, refined(mechanics.body, 1))
    values = np.full(41, np.nan)
    with pytest.raises(ms.ComputationError, match="handed to the mechanics"):
        transfer.to_mechanics(values)


def test_deformation_and_displacement_are_exact(kind):
    """Of a displacement that the mechanics' elements hold: F at the centres, J and u at the nodes."""
    mechanics, transfer = kind
    dim, degree = mechanics.body.dim, mechanics.kinematics.degree
    A = 0.01 * (np.arange(dim * dim).reshape(dim, dim) - 1.0)

    def u(x):
        return (A @ x[:dim]) + (degree == 2) * 0.002 * x[:dim] ** 2

    mixed = mechanics.kinematics.has_pressure
    (mechanics.u.sub(0) if mixed else mechanics.u).interpolate(u)
    mechanics.activation.x.array[:] = gamma = -0.2
    mechanics.hand_over_present()
    transfer.hand_over()
    F, J = transfer.deformation.F, transfer.deformation.J
    centres = points(F.function_space)
    exact = np.eye(dim) + A + (degree == 2) * 0.004 * np.einsum("nd,de->nde", centres, np.eye(dim))
    np.testing.assert_allclose(F.x.array.reshape(-1, dim, dim), exact, atol=1e-12)
    nodes = points(transfer.displacement().function_space)
    np.testing.assert_allclose(transfer.displacement().x.array.reshape(-1, dim), u(nodes.T).T, atol=1e-12)
    name = type(mechanics.kinematics).__name__
    if transfer.deformation.isochoric:
        assert J == 1.0
        return
    corners = points(J.function_space)
    ratio = {
        "Line": 1 + A[0, 0] + 0.004 * corners[:, 0],
        "Solid": np.linalg.det(np.eye(dim) + A + 0.004 * np.einsum("nd,de->nde", corners, np.eye(dim))),
    }
    np.testing.assert_allclose(J.x.array, ratio.get(name, 1 + gamma), atol=1e-12 if dim < 3 else 1e-7)


@pytest.mark.parametrize("name, stretch", [("line", 0.8), ("plane-stress", (0.8, 1.1))])
def test_on_a_held_body_it_is_one_mesh_of_that_fineness(name, stretch):
    """The same nodes, the same homogeneous F and J: the same numbers as with mechanics on the fine mesh."""
    coarse = mechanics_on(*KINDS[name], stretch=stretch)
    fine = mechanics_on(*KINDS[name], stretch=stretch, levels=1)
    models = nested(fine, 0), nested(coarse, 1)
    for model in models:
        advance(model, 2e-3, 0.02)
    one, two = (model.potential for model in models)
    assert one.v.x.array.max() > 0.85
    np.testing.assert_allclose(two.v.x.array, one.v.x.array, atol=1e-10)
    assert two.amount() == pytest.approx(one.amount(), rel=1e-10)


def test_another_mesh_is_refused():
    """A transfer that is not of these meshes, and a deformation that is not of the potential's."""
    mechanics, other = (mechanics_on(*KINDS["line"]) for _ in range(2))
    fine = refined(mechanics.body, 1)
    membrane = ms.membranes.FitzHughNagumo()
    for wrong in (mechanics.body, refined(other.body, 1)):
        with pytest.raises(ms.InputError, match="not nested"):
            ms.NestedMesh(mechanics, wrong)
    with pytest.raises(ms.InputError, match="of another mesh"):
        ms.Potential(fine, membrane=membrane, deformation=mechanics.deformation)
    transfer = ms.NestedMesh(mechanics, fine)
    potential = ms.Potential(fine, membrane=membrane, deformation=transfer.deformation)
    for given in (None, ms.NestedMesh(mechanics, refined(mechanics.body, 1))):
        with pytest.raises(ms.InputError, match="different meshes") as refused:
            ms.Electromechanics(potential, mechanics, transfer=given)
        assert refused.value.key == "potential.refinement"
