"""Loads and supports against closed forms: follower pressure, springs, sliding planes, continuation."""

import itertools

import myostrain as ms
from myostrain.course import check_course, value_at
from myostrain.errors import ComputationError, InputError
from myostrain.kinematics import PlaneStrain, PlaneStress, Solid
from myostrain.materials import Guccione1995, NeoHookean
from myostrain.mechanics.rigid_motions import RigidMotions
from myostrain.mechanics.supports import plane_axis
from myostrain.solvers.continuation import SMALLEST, follow

import numpy as np
import pytest
from scipy.optimize import brentq

from mechanics_tools import described

MU = 2.0
SIDES = (2.0, 1.0, 1.5)
PLANES = ("left", "front", "bottom")
ALL = (*PLANES, "right", "back", "top")


def block(spacing=1.0, size=SIDES):
    return ms.build(ms.geometry.Slab(size=size, spacing=spacing), ms.UniformFibres(direction=(1.0, 0.0, 0.0)))


def solid(body=None, *, gamma=0.0, kinematics=None, material=None, **parts):
    """A solid of uniform γ, or with values at the nodes."""
    mechanics = ms.Mechanics(
        body or block(),
        kinematics=kinematics or Solid(),
        material=material or NeoHookean(mu=MU),
        **described(parts),
    )
    mechanics.activation.x.array[:] = gamma
    return mechanics


def displaced(mechanics, corner):
    """Displacement of the node at a point."""
    nodal = mechanics.displacement()
    points = nodal.function_space.tabulate_dof_coordinates()[:, : mechanics.body.dim]
    (node,) = np.flatnonzero(np.linalg.norm(points - corner, axis=1) < 1e-9)
    return nodal.x.array.reshape(len(points), -1)[node]


def test_pressure_all_around_moves_nothing_and_is_the_pressure_inside():
    """σ = −p 1 satisfies P N = −p J F⁻ᵀ N: an incompressible block does not move, its pressure is μ + p."""
    mechanics = solid(pressure=dict.fromkeys(ALL, 0.7))
    mechanics.start()
    assert np.abs(mechanics.displacement().x.array).max() < 1e-12  # measured 2e-16
    pressure = mechanics.u.sub(1).collapse().x.array
    np.testing.assert_allclose(pressure, MU + 0.7, rtol=1e-10)


@pytest.mark.parametrize("pull", [1.5, -1.5])
def test_a_pressure_follows_the_body(pull):
    """A block pulled by −p: σ₁₁ = −p on the deformed area gives λ² − 1/λ = −p/μ; a dead load another λ."""
    mechanics = solid(sliding=PLANES, pressure={"right": -pull})
    mechanics.start()
    stretch = 1 + displaced(mechanics, SIDES)[0] / SIDES[0]
    follower = brentq(lambda x: x**2 - 1 / x - pull / MU, 0.2, 4)
    dead = brentq(lambda x: x - x**-2 - pull / MU, 0.2, 4)
    assert stretch == pytest.approx(follower, abs=1e-9)  # measured 2e-16
    assert abs(dead - follower) > 0.02
    across = displaced(mechanics, SIDES)[1:] / np.array(SIDES[1:])
    np.testing.assert_allclose(1 + across, stretch**-0.5, atol=1e-9)


@pytest.mark.parametrize("kinematic", [PlaneStress(), PlaneStrain()])
def test_the_edge_of_a_sheet_too(kinematic):
    """λ² − λ⁻² = T/μ in plane strain, λ² − 1/λ = T/μ with free faces: the thickness is in the area."""
    body = ms.build(
        ms.geometry.Rectangle(size=(2.0, 1.0), spacing=1.0), ms.UniformFibres(direction=(1.0, 0.0))
    )
    T = 1.2
    mechanics = solid(body, kinematics=kinematic, sliding=("left", "bottom"), pressure={"right": -T})
    mechanics.start()
    stretch = 1 + displaced(mechanics, (2.0, 1.0))[0] / 2.0
    power = 1 if isinstance(kinematic, PlaneStress) else 2
    assert stretch == pytest.approx(brentq(lambda x: x**2 - x**-power - T / MU, 0.5, 3), abs=1e-9)


def test_springs_along_the_normal_only():
    """A block pulled against springs across X on "left": their force k u₁ per area is P₁₁ = μ (λ − λ⁻²).

    Its sides slide freely along these springs: were they springs in all directions, the block would not be
    uniform.
    """
    k, T = 3.0, 1.5
    mechanics = solid(
        sliding=("front", "bottom"), robin_normal={"left": k}, pressure={"right": -T}, tolerance=1e-12
    )
    mechanics.start()
    stretch = brentq(lambda x: x**2 - 1 / x - T / MU, 0.5, 3)
    left = displaced(mechanics, (0.0, *SIDES[1:]))
    assert left[0] == pytest.approx(MU * (stretch - stretch**-2) / k, abs=1e-9)
    np.testing.assert_allclose(left[1:] / np.array(SIDES[1:]), stretch**-0.5 - 1, atol=1e-9)


def test_springs_by_part():
    """robin = { left = k, right = k } is robin = k on these parts; another k on one of them is not."""
    found = [
        solid(gamma=-0.2, **parts)
        for parts in (
            dict(robin=0.5, robin_boundary=("left", "right")),
            dict(robin={"left": 0.5, "right": 0.5}),
            dict(robin={"left": 0.5, "right": 0.1}),
        )
    ]
    for mechanics in found:
        mechanics.start()
    one, same, other = (mechanics.displacement().x.array for mechanics in found)
    np.testing.assert_allclose(same, one, atol=1e-12)
    assert np.abs(other - one).max() > 1e-3


FREE = [
    ([], 6),
    ([(["left"], range(3))], 0),
    ([(["left"], [0])], 3),
    ([(["left"], [0]), (["bottom"], [2])], 1),
    ([([name], [axis]) for axis, name in enumerate(PLANES)], 0),
    ([(None, range(3))], 0),
    ([(["left"], None)], 3),
    ([(None, None)], 0),
]


@pytest.mark.parametrize("holds, count", FREE)
def test_rigid_motions_that_are_left(holds, count):
    """A plane leaves two translations and a rotation, two planes a translation, a fixed side none."""
    motions = RigidMotions(block(), holds)
    assert motions.free.shape == (6, count)


@pytest.mark.parametrize("holds", [dict(), dict(sliding=["left"]), dict(sliding=["left", "bottom"])])
def test_motions_that_are_left_are_pinned_without_force(holds):
    """A free active block has uniform stretches (1 + γ)^⅔ and (1 + γ)^(−⅓) whatever stops its drift."""
    mechanics = solid(gamma=-0.3, **holds)
    mechanics.start()
    sides = [displaced(mechanics, corner) for corner in ((0.0, 0.0, 0.0), SIDES)]
    stretched = np.linalg.norm(np.array(SIDES) + sides[1] - sides[0])
    expected = np.linalg.norm(np.array(SIDES) * np.array([0.7 ** (2 / 3), *[0.7 ** (-1 / 3)] * 2]))
    assert stretched == pytest.approx(expected, abs=1e-9)


def test_a_load_that_nothing_bears_is_refused():
    """mechanics.pressure: a message with the part, where the body would fly off; all around it may act."""
    for holds in (dict(), dict(sliding=["front"]), dict(robin_normal={"front": 1.0})):
        with pytest.raises(InputError, match=r"mechanics\.pressure\.right: .* nothing holds"):
            solid(pressure={"right": 1.0}, **holds)
    solid(pressure={"right": 1.0, "left": 1.0})


WRONG = [
    (dict(sliding=["lft"]), "mechanics.sliding", "did you mean 'left'"),
    (dict(pressure={"rihgt": 1.0}, fixed=["left"]), "mechanics.pressure.rihgt", "right"),
    (dict(robin={"left": -1.0}), "mechanics.robin.left", "greater than or equal to 0"),
    (dict(robin_normal={"left": np.nan}), "mechanics.robin_normal.left", "finite"),
    (dict(robin={"left": 1.0}, robin_boundary=["left"]), "mechanics.robin_boundary", "leave"),
    (
        dict(pressure={"right": ((1.0, 0.0), (0.0, 1.0))}, fixed=["left"]),
        "mechanics.pressure.right",
        "ascend",
    ),
]


@pytest.mark.parametrize("parts, key, words", WRONG)
def test_wrong_loads(parts, key, words):
    """InputError names key, value and what is allowed (the interface)."""
    with pytest.raises(InputError) as caught:
        solid(**parts)
    assert caught.value.key == key
    assert words in str(caught.value)


def test_a_curved_part_does_not_slide():
    """mechanics.sliding is for planes across an axis; the message says what to take in its place."""
    body = ms.build(ms.geometry.Ellipse(size=(2.0, 1.0), spacing=0.3), ms.UniformFibres(direction=(1.0, 0.0)))
    with pytest.raises(InputError, match="robin_normal"):
        solid(body, kinematics=PlaneStress(), sliding=["boundary"])


@pytest.mark.parametrize("off, slides", [(4e-7, True), (4e-6, False)])
def test_a_plane_of_single_precision_slides(off, slides):
    """Nodes of a plane part may be off it by 1e-6 of the diagonal; the message says how far they are."""
    body = block()
    x = body.mesh.geometry.x
    left = np.flatnonzero(x[:, 0] == 0.0)
    x[left, 0] += off * np.linalg.norm(SIDES) * np.linspace(0, 1, len(left))
    if slides:
        assert plane_axis(body, "left") == 0
    else:
        with pytest.raises(InputError, match=r"over 1\.08e-05, 1, 1\.5 along these axes"):
            plane_axis(body, "left")


def test_values_over_time():
    """Points are joined by straight lines and held before the first and after the last one."""
    course = ((0.0, 1.0), (2.0, 5.0), (3.0, 0.0))
    found = [value_at(course, t) for t in (-1.0, 0.0, 0.5, 2.0, 2.5, 9.0)]
    assert found == [1.0, 1.0, 2.0, 5.0, 2.5, 0.0]
    assert value_at(3.5, 7.0) == 3.5
    for wrong in ((), ((0.0, 1.0), (0.0, 2.0)), ((1.0, 1.0), (0.0, 2.0))):
        with pytest.raises(InputError, match="ascending"):
            check_course(wrong, "some.key")


def test_a_ramp_is_followed_in_time():
    """The stretch at each time is that of the pressure then; the state goes on from where it was taken."""
    ramp = {"right": ((0.0, 0.0), (1.0, -1.0))}
    mechanics, other = solid(sliding=PLANES, pressure=ramp), solid(sliding=PLANES, pressure=ramp)
    mechanics.start(0.0)
    for time in (0.4, 0.7):
        mechanics.solve(time)
        mechanics.accept(time)
        stretch = 1 + displaced(mechanics, SIDES)[0] / SIDES[0]
        assert stretch == pytest.approx(brentq(lambda x, t=time: x**2 - 1 / x - t / MU, 0.5, 3), abs=1e-9)
    other.start(0.0)
    other.restore(mechanics.state())
    for one in (mechanics, other):
        one.solve(0.9)
    np.testing.assert_array_equal(other.u.x.array, mechanics.u.x.array)
    assert mechanics.external.pressures["right"].value == pytest.approx(-0.9)


def fails_beyond(longest, u, log):
    """A jump that succeeds if it is no longer than ``longest``; u follows the share."""

    def jump(share):
        log.append(share)
        if share - u[1] > longest:
            u[:] = np.nan
            raise ComputationError("too far", where=[1.0], advice="less.")
        u[:] = share

    return jump


@pytest.mark.parametrize("longest", [1.0, 0.3, 0.06, 3 * SMALLEST])
def test_continuation_finds_the_way_in_smaller_jumps(longest):
    """Jumps are halved until they succeed and grow again; the end is all of the change, exactly."""
    u, log, done = np.zeros(2), [], [0.0]
    inner = fails_beyond(longest, u, log)

    def jump(share):
        u[1] = done[-1]
        inner(share)
        done.append(share)

    follow(jump, u)
    assert done[-1] == pytest.approx(1.0, abs=1e-12)
    assert max(np.diff(done)) <= longest
    assert len(log) < 6 / longest + 20


def test_continuation_ends_honestly():
    """Where no jump succeeds the state is what it was, and the message says how far it came."""
    u, start = np.full(2, 3.0), []

    def jump(share):
        start.append(share)
        if share > 0.5:
            raise ComputationError("wall", where=[1.0, 2.0], advice="less.")

    with pytest.raises(ComputationError, match=r"wall; (49|50)\.\d% of the change") as caught:
        follow(jump, u)
    np.testing.assert_array_equal(u, 3.0)
    assert caught.value.where == [1.0, 2.0]
    assert caught.value.advice == "less."


def test_one_jump_too_far_ends_where_small_steps_do():
    """A beam bent by a pressure for which Newton's method fails from rest is found by continuation."""
    beam = block(1.0, (10.0, 1.0, 1.0))
    parts = dict(material=Guccione1995(), fixed=["left"], tolerance=1e-11)
    jump = solid(beam, pressure={"bottom": ((0.0, 0.0), (1.0, 0.05))}, **parts)
    walk = solid(beam, pressure={"bottom": ((0.0, 0.0), (1.0, 0.05))}, **parts)
    jump.start()
    walk.start()
    solved = jump.solver.counters.solves
    jump.solve(1.0)
    assert jump.solver.counters.solves - solved > 2  # it was too far
    for time in np.linspace(0, 1, 9)[1:]:
        walk.solve(time)
        walk.accept(time)
    assert np.abs(walk.displacement().x.array).max() > 5
    np.testing.assert_allclose(jump.displacement().x.array, walk.displacement().x.array, atol=1e-8)


def test_a_stiff_bulk_tends_to_incompressible():
    """The nearly incompressible solid differs by O(1/κ): ten times κ, a tenth of the difference."""
    parts = dict(gamma=-0.3, sliding=PLANES, pressure={"right": 0.5})
    exact, *found = (
        solid(kinematics=Solid(bulk_modulus=kappa), **parts) for kappa in (None, 1e2 * MU, 1e3 * MU)
    )
    for mechanics in (exact, *found):
        mechanics.start()
    off = [np.abs(m.displacement().x.array - exact.displacement().x.array).max() for m in found]
    assert 8 < off[0] / off[1] < 12  # measured 10.0
    assert found[0].u.function_space.num_sub_spaces == 3  # no pressure unknown


def test_a_bulk_modulus_is_that_of_the_volume():
    """A block under pressure all around: σ = κ/2 (J − 1/J) 1, since κ/4 (J² − 1 − 2 ln J) is the energy."""
    kappa, p = 10.0, 2.0
    mechanics = solid(
        kinematics=Solid(bulk_modulus=kappa),
        sliding=PLANES,
        pressure=dict.fromkeys(("right", "back", "top"), p),
    )
    mechanics.start()
    J = np.prod(1 + displaced(mechanics, SIDES) / np.array(SIDES))
    assert kappa / 2 * (J - 1 / J) == pytest.approx(-p, abs=1e-8)


def contracting(body, beta, activity):
    """A solid in equilibrium with γ = −β times an activity."""
    mechanics = solid(body)
    law = ms.activation.Proportional(beta=beta)
    given = ms.GivenPotential(body, ms.Drive(potential=1.0))
    ms.Electromechanics(given, mechanics, law=law, activity=activity).start()
    return mechanics


def test_depth_of_a_wall_and_activity_through_it():
    """Between two planes the harmonic depth is linear; a factor of one half halves γ."""
    body = block(0.5)
    z = body.mesh.geometry.x[:, 2]
    depth = ms.geometry.depth(body, ("bottom", "top"))
    X = depth.function_space.tabulate_dof_coordinates()
    np.testing.assert_allclose(depth.x.array, X[:, 2] / z.max(), atol=1e-9)
    whole = ms.geometry.transmural(body, (0.5, 0.5), ("bottom", "top"))
    half, other = contracting(body, 0.4, whole), contracting(body, 0.2, 1.0)
    bent = contracting(body, 0.2, ms.geometry.transmural(body, (0.0, 2.0), ("bottom", "top")))
    np.testing.assert_allclose(half.displacement().x.array, other.displacement().x.array, atol=1e-8)
    top, bottom = (displaced(bent, (2.0, 0.0, z)) - displaced(bent, (0.0, 0.0, z)) for z in (SIDES[2], 0.0))
    assert top[0] < bottom[0] - 0.1  # the top contracts, the bottom does not
    for between, words in ((("bottom", "tip"), "top"), (("bottom", "left"), "meet"), (None, "bottom")):
        with pytest.raises(InputError, match=words):
            ms.geometry.depth(body, between)


def test_parts_combine():
    """Springs, planes and pressures act together as one sum: the order of the parts does not matter."""
    pressures = {"right": -0.4, "top": 0.2}
    found = []
    for order in itertools.permutations(pressures):
        mechanics = solid(sliding=PLANES, robin=0.1, pressure={name: pressures[name] for name in order})
        mechanics.start()
        found.append(mechanics.displacement().x.array.copy())
    np.testing.assert_allclose(found[0], found[1], atol=1e-12)
