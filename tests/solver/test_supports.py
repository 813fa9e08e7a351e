"""Prescribed displacements, dead tractions, reactions, held bodies, balance, and wrong objects."""

import myostrain as ms
from myostrain.activation import Fibre, Orthotropic
from myostrain.engine import compile_form, fem
from myostrain.errors import ComputationError, InputError
from myostrain.kinematics import Line, PlaneStrain, PlaneStress, Solid
from myostrain.materials import NeoHookean, Spring
from myostrain.mechanics.keywords import FORMER
from myostrain.mechanics.normals import smooth_normal
from myostrain.mechanics.quadrature import QuadraturePoints
from myostrain.mechanics.rigid_motions import surface

import numpy as np
import pytest
import ufl

from solid_tools import quick_kernels

MU = 2.0
SIDES = (2.0, 1.0, 1.5)


def made(kinematics, spacing=0.5, fibre=None, material=None, **parts):
    shape = {
        1: lambda: ms.geometry.Line(length=SIDES[0], spacing=spacing),
        2: lambda: ms.geometry.Rectangle(size=SIDES[:2], spacing=spacing),
        3: lambda: ms.geometry.Slab(size=SIDES, spacing=spacing),
    }[kinematics.dim]()
    direction = fibre or (1.0, *[0.0] * (kinematics.dim - 1))
    fibres = None if kinematics.dim == 1 else ms.UniformFibres(direction=direction)
    with quick_kernels():
        return ms.Mechanics(
            ms.build(shape, fibres),
            kinematics=kinematics,
            material=material or (Spring(mu=MU) if kinematics.dim == 1 else NeoHookean(mu=MU)),
            **({"tolerance": 1e-12} | parts),
        )


def close(found, expected, tolerance=1e-7):
    assert found == pytest.approx(expected, abs=tolerance)


PULLED = [
    (Line(), ("left",), MU * 0.25, 1.0),
    (PlaneStress(), ("left", "bottom"), MU * (1.25 - 1.25**-2), SIDES[1]),
    (PlaneStrain(), ("left", "bottom"), MU * (1.25 - 1.25**-3), SIDES[1]),
    (Solid(), ("left", "front", "bottom"), MU * (1.25 - 1.25**-2), SIDES[1] * SIDES[2]),
]


@pytest.mark.parametrize(
    "kinematics, planes, stress, area", PULLED, ids=[type(p[0]).__name__ for p in PULLED]
)
def test_a_prescribed_displacement_is_borne_by_its_reaction(kinematics, planes, stress, area):
    """A bar drawn to λ = 1.25 by its end, as time goes on: the end and the plane opposite bear P₁₁ A."""
    course = ((0.0, 0.0), (1.0, 0.25 * SIDES[0]))
    mechanics = made(
        kinematics, 1.0, supports=ms.Supports(sliding=planes, displacement={"right": {"x": course}})
    )
    mechanics.start(0.0)
    close(mechanics.reactions.values()["reaction_right_x"], 0.0)
    mechanics.solve(1.0)
    mechanics.accept(1.0)
    found = mechanics.reactions.values()
    close(found["reaction_right_x"], stress * area, 1e-6)
    close(found["reaction_left_x"], -stress * area, 1e-6)
    close(np.abs(mechanics.displacement().x.array).max(), 0.25 * SIDES[0], 1e-9)
    others = [value for name, value in found.items() if not name.endswith("_x")]
    np.testing.assert_allclose(others, 0, atol=1e-6)
    sigma = mechanics.stress()
    np.testing.assert_allclose(np.trace(sigma, axis1=1, axis2=2), mechanics.stress_trace(), atol=1e-7)
    np.testing.assert_allclose(sigma[:, 0, 0], stress * 1.25 ** (kinematics.dim > 1), atol=1e-6)


@pytest.mark.parametrize("by", ["traction", "displacement"])
def test_simple_shear(by):
    """F = 1 + k e₁⊗e₃ with p = μ: P = μ k (e₁⊗e₃ + e₃⊗e₁), dead tractions on four sides.

    σ₁₁ = μ k², σ₁₃ = μ k. The top is pulled along X by a traction, or moved.
    """
    k = 0.4
    sides = {"right": (0.0, 0.0, MU * k), "left": (0.0, 0.0, -MU * k)}
    if by == "traction":
        supports, loads = (
            ms.Supports(fixed=["bottom"]),
            ms.Loads(traction={**sides, "top": (MU * k, 0.0, 0.0)}),
        )
    else:
        moved = {"x": k * SIDES[2], "y": 0.0, "z": 0.0}
        supports = ms.Supports(fixed=["bottom"], displacement={"top": moved})
        loads = ms.Loads(traction=sides)
    mechanics = made(Solid(), supports=supports, loads=loads)
    mechanics.start()
    u, X = mechanics.displacement(), mechanics.body.mesh.geometry.x
    moved = u.x.array.reshape(-1, 3)
    Z = u.function_space.tabulate_dof_coordinates()[:, 2]
    np.testing.assert_allclose(moved, np.outer(k * Z, [1, 0, 0]), atol=1e-8)
    wanted = np.zeros((3, 3))
    wanted[0, 0], wanted[0, 2], wanted[2, 0] = MU * k**2, MU * k, MU * k
    np.testing.assert_allclose(mechanics.stress(), np.broadcast_to(wanted, (len(X), 3, 3)), atol=1e-7)
    found = mechanics.reactions.values()
    close(found["reaction_bottom_x"], -MU * k * SIDES[0] * SIDES[1])
    if by == "displacement":
        close(found["reaction_top_x"], MU * k * SIDES[0] * SIDES[1])


def test_springs_report_what_they_bear():
    """A line pulled by a traction T against a spring at its other end: the spring bears −T."""
    mechanics = made(
        Line(), supports=ms.Supports(robin={"left": 3.0}), loads=ms.Loads(traction={"right": [0.6]})
    )
    mechanics.start()
    close(mechanics.reactions.values(), {"reaction_left_x": -0.6})


def test_a_traction_over_time():
    """Between points a traction is linear in time: T(0.5) = 0.3 stretches a line by T/μ."""
    loads = ms.Loads(traction={"right": ((0.0, (0.0,)), (1.0, (0.6,)))})
    mechanics = made(Line(), supports=ms.Supports(fixed=["left"]), loads=loads)
    mechanics.start(0.0)
    mechanics.solve(0.5)
    close(np.abs(mechanics.displacement().x.array).max(), 0.3 / MU * SIDES[0])


BALANCE = [(-0.01, True), (-0.02, False)]


@pytest.mark.parametrize("gamma, balances", BALANCE)
def test_loads_that_balance_only_at_rest(gamma, balances):
    """Pulled on two sides, a free sheet with oblique fibres shears as it contracts, and the pulls turn it.

    The moment is 0.6 and 1.3 % of the forces times the diagonal; 1 % is refused. With fibres along the sides
    it is nothing whatever γ.
    """
    loads = ms.Loads(pressure={"left": -1.0, "right": -1.0})
    mechanics = made(PlaneStress(), fibre=(1.0, 1.0), loads=loads)
    mechanics.activation.x.array[:] = gamma
    if balances:
        mechanics.start()
    else:
        with pytest.raises(ComputationError, match=r"moment \(.*let one slide"):
            mechanics.start()
        assert (mechanics.u.x.array == 0).all()
    straight = made(PlaneStress(), loads=loads)
    straight.activation.x.array[:] = -0.3
    straight.start()


@pytest.mark.parametrize("kinematics", [PlaneStrain(), Solid(), PlaneStrain(constraint="elastic")], ids=str)
def test_a_stretch_that_changes_the_volume(kinematics):
    """J = 1 refuses det F = 1.2 with the number; it takes stretches whose product is one, det Fe = 1 any."""
    ones = [1.0] * (kinematics.dim - 1)
    changing = ms.ImposedStretch(value=(1.2, *ones))
    if kinematics.constraint == "elastic":
        assert made(kinematics, 1.0, imposed_stretch=changing).deformation.J == 1.2
    else:
        with pytest.raises(InputError, match=r"det F = 1\.2,") as caught:
            made(kinematics, 1.0, imposed_stretch=changing)
        assert caught.value.key == "mechanics.imposed_stretch"
        made(kinematics, 1.0, imposed_stretch=ms.ImposedStretch(value=(1.2, 1 / 1.2, *ones[1:])))


def test_stretches_that_any_volume_takes():
    """The thickness of a sheet makes up for its area; a nearly incompressible solid may swell."""
    stretch = ms.ImposedStretch(value=1.2)
    assert made(PlaneStress(), imposed_stretch=stretch).deformation.J == 1.0
    made(Solid(bulk_modulus=10.0), 1.0, imposed_stretch=stretch)
    made(Line(), imposed_stretch=stretch)


@pytest.mark.parametrize(
    "kinematics", [PlaneStress("elastic"), PlaneStrain("elastic"), Solid("elastic")], ids=str
)
def test_a_held_body_is_rigid_for_the_potential(kinematics):
    """det Fe = 1 makes J = 1 + γ of a free body; a held one has J = 1 whatever γ, until it is let go."""
    for_ever = made(kinematics, 1.0, imposed_stretch=ms.ImposedStretch())
    assert for_ever.deformation.isochoric
    mechanics = made(kinematics, 1.0, imposed_stretch=ms.ImposedStretch(until=1.0))
    J = mechanics.deformation.J
    values = QuadraturePoints(mechanics.body.mesh, 1).values(J)
    mechanics.activation.x.array[:] = -0.3
    mechanics.start(0.0)
    np.testing.assert_allclose(values(), 1.0, atol=1e-12)
    other = made(kinematics, 1.0, imposed_stretch=ms.ImposedStretch(until=1.0))
    mechanics.release()
    mechanics.solve(1.0, predict=False)
    mechanics.hand_over_present()
    np.testing.assert_allclose(values(), 0.7, atol=1e-12)
    mechanics.accept(1.0)
    restored = QuadraturePoints(other.body.mesh, 1).values(other.deformation.J)
    other.start(0.0)
    other.restore(mechanics.state())
    np.testing.assert_allclose(restored(), 0.7, atol=1e-12)


@pytest.mark.parametrize(
    "supports, words",
    [
        (ms.Supports(fixed=["right"]), r"1\.2 .* moves 'right' by 0\.4 along x"),
        (ms.Supports(sliding=["top"]), r"1\.2 .* moves 'top' by 0\.2 along y"),
        (ms.Supports(displacement={"right": {"x": 0.1}}), "prescribed displacement"),
    ],
)
def test_a_stretch_that_moves_what_is_held(supports, words):
    """The homogeneous stretch starts at the lowest corner: parts elsewhere move, and cannot be held."""
    with pytest.raises(InputError, match=words) as caught:
        made(PlaneStress(), supports=supports, imposed_stretch=ms.ImposedStretch(value=1.2))
    assert caught.value.key == "mechanics.imposed_stretch"
    made(
        PlaneStress(),
        supports=ms.Supports(sliding=["left", "bottom"]),
        imposed_stretch=ms.ImposedStretch(value=1.2),
    )


def test_a_singular_active_deformation_says_so():
    """Orthotropic with K = 4 is none for γ ≤ −1/4: the place and the activation, not Newton's trouble."""
    fibres = ms.UniformFibres(direction=(1.0, 0.0, 0.0), sheet=(0.0, 1.0, 0.0))
    body = ms.build(ms.geometry.Slab(size=SIDES, spacing=1.0), fibres)
    with quick_kernels():
        mechanics = ms.Mechanics(
            body,
            kinematics=Solid(),
            material=NeoHookean(mu=MU),
            active=Orthotropic(kappa=0.0, ratio=4.0),
        )
    x = mechanics.activation.function_space.tabulate_dof_coordinates()
    mechanics.activation.x.array[:] = np.where(x[:, 0] > 1.5, -0.3, -0.1)
    with pytest.raises(
        ComputationError, match=r"near \[1\.\d.*det Fo is not a number for an activation of -0\.[23]"
    ) as caught:
        mechanics.start()
    assert caught.value.where[0] > 1
    assert "−1/K" in caught.value.advice
    assert "time step" not in str(caught.value)


def test_stress_is_integrated_with_the_measure_of_the_solver():
    """``ufl.dx`` alone would ask for points without end; ``dx`` has a degree, and the integral is exact."""
    mechanics = made(
        PlaneStress(), supports=ms.Supports(sliding=["left", "bottom"], displacement={"right": {"x": 0.5}})
    )
    mechanics.start()
    with quick_kernels():
        found = fem.assemble_scalar(compile_form(mechanics.cauchy()[0, 0] * mechanics.dx))
    close(found, MU * (1.25**2 - 1.25**-1) * SIDES[0] * SIDES[1])


def test_advice_where_no_equilibrium_is_found():
    """The message names what helps a slender free body, too: supports and the tolerance."""
    mechanics = made(Solid(bulk_modulus=10.0), 1.0)
    mechanics.solver._max = 1
    mechanics.activation.x.array[:] = -0.3
    with pytest.raises(ComputationError) as caught:
        mechanics.start()
    assert "supports" in caught.value.advice
    assert "mechanics.tolerance" in caught.value.advice


class WithoutEnergy:
    """Nothing that a material needs."""


class NoNumber:
    """An energy that is a tensor."""

    tensor_dim = 3

    def energy(self, Fe, fibres):
        return Fe.T * Fe


WRONG = [
    (dict(kinematics="plane-stress"), "mechanics.kinematics", "PlaneStress()"),
    (dict(kinematics=PlaneStress), "mechanics.kinematics", "PlaneStress()"),
    (dict(material="NeoHookean"), "mechanics.material", "NeoHookean()"),
    (dict(material=WithoutEnergy()), "mechanics.material", "WithoutEnergy has no method 'energy'"),
    (dict(material=NoNumber()), "mechanics.material", "scalar"),
    (dict(active="fibre"), "mechanics.active", "Fibre()"),
    (dict(supports={"fixed": ["left"]}), "mechanics.supports", "Supports("),
    (dict(loads={"pressure": {"left": 1.0}}), "mechanics.loads", "Loads("),
    (dict(imposed_stretch=1.2), "mechanics.imposed_stretch", "ImposedStretch("),
    (dict(tolerance="small"), "mechanics.tolerance", "a number"),
    (dict(relaxation_time="long"), "mechanics.relaxation_time", "a number"),
    (dict(body="sheet.msh"), "mechanics.body", "build"),
]


@pytest.mark.parametrize("parts, key, words", WRONG)
def test_wrong_objects_are_one_message(parts, key, words):
    """An object of the wrong kind is refused when it is given, with the key and what to give."""
    body = ms.build(
        ms.geometry.Rectangle(size=(1.0, 1.0), spacing=1.0), ms.UniformFibres(direction=(1.0, 0.0))
    )
    with pytest.raises(InputError) as caught:
        ms.Mechanics(**(dict(body=body, kinematics=PlaneStress(), material=NeoHookean()) | parts))
    assert caught.value.key == key
    assert words in str(caught.value)


TYPES = [
    (ms.Supports, dict(fixed="left"), "mechanics.fixed", '["left"]'),
    (ms.Supports, dict(sliding=[1]), "mechanics.sliding.0", "a text"),
    (ms.Supports, dict(robin="stiff"), "mechanics.robin", "a number"),
    (ms.Supports, dict(robin={"left": -1.0}), "mechanics.robin.left", "greater than or equal to 0"),
    (
        ms.Supports,
        dict(displacement={"left": {"w": 1.0}}),
        "mechanics.displacement.left.w",
        "'x', 'y' or 'z'",
    ),
    (ms.Loads, dict(pressure={"left": "high"}), "mechanics.pressure.left", "a number"),
    (ms.Loads, dict(traction={"left": 1.0}), "mechanics.traction.left", "a list of numbers"),
    (ms.Loads, dict(traction={"left": ((1.0, (0.0,)), (0.0, (1.0,)))}), "mechanics.traction.left", "ascend"),
]


@pytest.mark.parametrize("cls, given, key, words", TYPES)
def test_wrong_values_are_one_message(cls, given, key, words):
    """Descriptions check their values: the key, what is allowed, what was given."""
    with pytest.raises(InputError) as caught:
        cls(**given)
    assert caught.value.key == key
    assert words in str(caught.value)


ON_THE_BODY = [
    (dict(supports=ms.Supports(displacement={"left": {"z": 0.1}})), "mechanics.displacement.left.z", "x, y"),
    (dict(supports=ms.Supports(displacement={"lft": {"x": 0.1}})), "mechanics.displacement.lft", "'left'"),
    (
        dict(supports=ms.Supports(fixed=["left"], displacement={"top": {"x": 0.1}})),
        "mechanics.displacement.top.x",
        "'left' already",
    ),
    (dict(loads=ms.Loads(traction={"left": [1.0]})), "mechanics.traction.left", "give 2 numbers"),
    (dict(loads=ms.Loads(traction={"left": [1.0, 0.0]})), "mechanics.traction.left", "nothing holds"),
]


@pytest.mark.parametrize("parts, key, words", ON_THE_BODY)
def test_what_does_not_fit_the_body(parts, key, words):
    """A component, part or dimension that the body has not; nodes held twice; a pull that nothing bears."""
    with pytest.raises(InputError) as caught:
        made(PlaneStress(), **parts)
    assert caught.value.key == key
    assert words in str(caught.value)


@pytest.mark.parametrize("name", FORMER)
def test_keywords_of_earlier_versions(name):
    """They are refused with what took their place; an unknown keyword is a TypeError."""
    body = ms.build(
        ms.geometry.Rectangle(size=(1.0, 1.0), spacing=1.0), ms.UniformFibres(direction=(1.0, 0.0))
    )
    parts = dict(kinematics=PlaneStress(), material=NeoHookean())
    with pytest.raises(InputError, match=f"'{name}' any more: .*(Supports|Loads|active|Electromechanics)"):
        ms.Mechanics(body, **parts, **{name: 1})
    with pytest.raises(TypeError, match="frixed"):
        ms.Mechanics(body, **parts, frixed=["left"])


def test_what_a_mechanics_is():
    """Its repr says what is solved, and how it is held."""
    free = made(PlaneStress(), active=Fibre())
    assert (
        repr(free) == "Mechanics(PlaneStress, NeoHookean, Fibre; 16 cells, 30 unknowns, 3 rigid motions free)"
    )


def test_the_normal_of_a_smooth_part():
    """That of a circle exactly, of a sphere nearly, at its rim too, where facets are on one side only: by
    their own normals a body would be stuck where they meet. A part with edges keeps them."""
    disc = ms.build(ms.geometry.Ellipse(size=(20.0, 20.0), spacing=4.0), ms.UniformFibres((1.0, 0.0)))
    shape = ms.geometry.Ventricle(endocardium=(7.0, 7.0), epicardium=(10.0, 10.0), base=1.0, spacing=3.0)
    ball = ms.build(shape, ms.UniformFibres((1.0, 0.0, 0.0)))
    for body, part, centre in ((disc, "boundary", [10.0, 10.0]), (ball, "epicardium", [0.0, 0.0, 0.0])):
        x, own = ufl.SpatialCoordinate(body.mesh), ufl.FacetNormal(body.mesh)
        away = x - ufl.as_vector(centre)
        exact = away / ufl.sqrt(ufl.inner(away, away))
        ds = body.boundary_measure([part], 4)
        off = [
            fem.assemble_scalar(fem.form(ufl.inner(n - exact, n - exact) * ds)) ** 0.5
            for n in (smooth_normal(body, [part]), own)
        ]
        assert off[0] < (1e-12 if body is disc else 0.1) * off[1]  # measured 0.04
    box = ms.build(ms.geometry.Rectangle(size=(2.0, 1.0), spacing=0.5), ms.UniformFibres((1.0, 0.0)))
    assert isinstance(smooth_normal(box, None), ufl.FacetNormal)
    slope, ds = smooth_normal(box, ["top"]), box.boundary_measure(["top"], 4)
    assert fem.assemble_scalar(fem.form(abs(slope[1] - 1) * ds)) < 1e-12


@pytest.mark.parametrize("normals", ["smooth", "facets"])
def test_a_disc_turns_in_a_support_along_its_normal(normals):
    """A disc that turns by ω moves along its smooth boundary only. By the normals of facets of length ℓ the
    support keeps k ω² ℓ³/24 for each: u·N = −ω s at a distance s from its middle; so do dampers."""
    omega, k = 0.1, 3.0
    body = ms.build(ms.geometry.Ellipse(size=(2.0, 2.0), spacing=0.5), ms.UniformFibres((1.0, 0.0)))
    springs = {"boundary": k}
    supports = ms.Supports(robin_normal=springs, damping_normal=springs, normals=normals)
    mechanics = ms.Mechanics(body, kinematics=PlaneStress(), material=NeoHookean(mu=MU), supports=supports)
    mechanics.u.interpolate(lambda x: omega * np.stack([1.0 - x[1], x[0] - 1.0]))
    ((stiffness, parts, outward),) = mechanics.external.springs
    along, ds = ufl.dot(mechanics.u, outward), body.boundary_measure(parts, 4)
    energy = fem.assemble_scalar(fem.form(stiffness / 2 * along**2 * ds))
    corners, _ = surface(body, parts)
    lengths = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)
    kept = k * omega**2 / 24 * (lengths**3).sum()
    assert energy == pytest.approx(kept if normals == "facets" else 0.0, rel=1e-10, abs=1e-12 * kept)
    mechanics.motion.weights[0].value = 1.0  # the velocity is now ω times the same
    ((damping, v, parts),) = mechanics.external.dampers
    power = fem.assemble_scalar(fem.form(damping / 2 * ufl.inner(v, v) * ds))
    assert power == pytest.approx(kept if normals == "facets" else 0.0, rel=1e-10, abs=1e-12 * kept)
