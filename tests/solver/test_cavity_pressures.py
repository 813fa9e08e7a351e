"""Pressures of cavities as unknowns: a thick sphere in closed form, Newton's order, work, bad input."""

import dataclasses
import itertools

import myostrain as ms
from myostrain.circulation import Isovolumetric, PrescribedPressure, PrescribedVolume
from myostrain.engine import compile_form
from myostrain.geometry import EllipsoidalFibres, Ventricle
from myostrain.kinematics import Solid
from myostrain.materials import NeoHookean
from myostrain.mechanics.quadrature import integral

import numpy as np
import pytest
from dolfinx import mesh as dmesh
from scipy.integrate import quad

from small_cases import ALONE

MU = 2.0
INNER, OUTER = 10.0, 14.0
HALF = 2 / 3 * np.pi * INNER**3


def half_sphere(circulation, spacing=4.0, preload=None, **parts):
    """Half a thick sphere whose cut slides in its plane: it deforms as the whole one."""
    shape = Ventricle(
        endocardium=(INNER, INNER), epicardium=(OUTER, OUTER), base=0.0, spacing=spacing, layers=1
    )
    body = ms.build(
        shape, EllipsoidalFibres(endocardium=shape.endocardium, epicardium=shape.epicardium), ALONE
    )
    if circulation is not None:
        parts["cavities"] = ms.Cavities(("endocardium",), circulation, preload)
    return ms.Mechanics(
        body,
        kinematics=Solid(),
        material=NeoHookean(mu=MU),
        **{"supports": ms.Supports(sliding=["base"]), **parts},
    )


def pressure(volume_ratio):
    """That of an incompressible neo-Hookean sphere whose cavity has this volume: ∫ 2 μ (λ² − λ⁻⁴) dr/r."""

    def density(R):
        r = np.cbrt(R**3 + (volume_ratio - 1) * INNER**3)
        return 2 * MU * ((r / R) ** 2 - (r / R) ** -4) * R**2 / r**3

    return quad(density, INNER, OUTER)[0]


def course(mechanics, times):
    """Volume, pressure and stored energy (times, 3) of a run."""
    found = []
    for time in times:
        if time == times[0]:
            mechanics.start(time)
        else:
            mechanics.solve(time)
            mechanics.accept(time)
        found.append([*mechanics.cavities.values().values(), energy(mechanics)])
    return np.array(found)


def energy(mechanics):
    """The energy stored in the body."""
    active = mechanics._active
    density = active.stored(active.lifted(mechanics.u, mechanics.activation), mechanics.activation)
    return integral(compile_form(density * mechanics.dx), ALONE)


@pytest.fixture(scope="module")
def inflated():
    """Inflated to four times its volume in eight steps, beyond the highest pressure that it bears."""
    mechanics = half_sphere(PrescribedVolume(volume=((0.0, HALF), (8.0, 4 * HALF))))
    rest = mechanics.cavities.volumes()[0]
    return mechanics, rest, course(mechanics, np.arange(9.0))


def test_thick_sphere(inflated):
    """The volume is the prescribed one; the pressure that of the closed form, its fall included, to O(h²).

    A pressure that is prescribed finds no way beyond its greatest value.
    """
    _, rest, found = inflated
    wanted = HALF * (1 + 3 * np.arange(9) / 8)
    np.testing.assert_allclose(found[:, 0], wanted, rtol=1e-12)
    exact = np.array([pressure(volume / rest) for volume in wanted])
    assert exact.argmax() < 8
    assert found[:, 1].argmax() == exact.argmax()
    coarse = found[1:, 1] / exact[1:] - 1
    assert np.abs(coarse).max() < 0.03
    fine = half_sphere(PrescribedVolume(volume=((0.0, HALF), (8.0, 4 * HALF))), spacing=2.5)
    rest = fine.cavities.volumes()[0]
    volume, p, _ = course(fine, [0.0, 1.0, 2.0])[-1]
    error = p / pressure(volume / rest) - 1
    assert 2.0 < coarse[1] / error < 3.5  # 1.6² = 2.56


def test_work_is_energy(inflated):
    """What the pressure does on the volume is what the body stores: p = dW/dV, and their integrals."""
    mechanics, _, found = inflated
    volume, p, stored = found.T
    work = ((volume[2::2] - volume[:-2:2]) / 6 * (p[:-2:2] + 4 * p[1:-1:2] + p[2::2])).sum()
    assert work == pytest.approx(stored[-1] - stored[0], rel=2e-3)  # Simpson's rule
    near = []
    for time in (3.99, 4.0, 4.01):
        mechanics.solve(time, predict=False)
        mechanics.accept(time)
        near.append([*mechanics.cavities.values().values(), energy(mechanics)])
    volume, p, stored = np.transpose(near)
    assert p[1] == pytest.approx((stored[2] - stored[0]) / (volume[2] - volume[0]), rel=1e-5)


def test_newton_is_quadratic(inflated):
    """With a fresh tangent each correction is the square of the one before."""
    mechanics, *_ = inflated
    solver = mechanics.solver
    mechanics.solve(4.0, predict=False)
    mechanics.cavities.circuit.prepare(4.5, 1)
    sizes = []
    for _ in range(5):
        solver._assemble()
        solver._renew()
        sizes.append(solver._correction())
        solver._put(solver._get() - solver._step())
    solver.forget()
    ratios = [after / before**2 for before, after in itertools.pairwise(sizes[:4])]
    assert sizes[0] > 0.1
    assert sizes[3] < 1e-9
    assert max(ratios) < 5


def test_pressure_is_a_load():
    """A cavity whose pressure is given is the body under that follower pressure."""
    one = half_sphere(PrescribedPressure(pressure=((0.0, 0.0), (1.0, 0.4))))
    pressed = ms.Loads(pressure={"endocardium": ((0.0, 0.0), (1.0, 0.4))})
    other = half_sphere(None, loads=pressed)
    for mechanics in (one, other):
        mechanics.start(0.0)
        mechanics.solve(1.0)
    np.testing.assert_allclose(one.u.x.array, other.u.x.array, atol=1e-8)
    assert one.cavities.numbers == pytest.approx([0.4], rel=1e-14)


def test_isovolumetric_contraction():
    """A preload, then contraction at a closed volume: the pressure rises, the volume stays to round-off."""
    mechanics = half_sphere(Isovolumetric(), preload=0.2)
    mechanics.start(0.0)
    begun = mechanics.cavities.values()
    assert begun["pressure_endocardium"] == pytest.approx(0.2, rel=1e-14)
    for time, gamma in ((0.3, -0.05), (1.0, -0.1), (1.2, -0.15)):
        mechanics.activation.x.array[:] = gamma
        mechanics.solve(time, order=2)
        mechanics.accept(time)
        ended = mechanics.cavities.values()
        assert ended["volume_endocardium"] == pytest.approx(begun["volume_endocardium"], rel=1e-10)
    assert ended["pressure_endocardium"] > 0.3


@pytest.mark.parametrize(
    "parts, key",
    [
        ({"names": ("epicardium",)}, "circulation.cavity"),
        ({"names": ("base",)}, "circulation.cavity"),
        ({"names": ("endocardum",)}, "circulation.cavity"),
        ({"names": ("endocardium", "epicardium")}, "circulation.cavity"),
        ({"names": ()}, "circulation.cavity"),
        ({"preload": 0.3, "circulation": PrescribedPressure(pressure=1.0)}, "circulation.preload"),
        ({"preload": (0.3, 0.4)}, "circulation.preload"),
        ({"preload": -1.0}, "circulation.preload"),
        ({"circulation": Isovolumetric}, "circulation.kind"),
        ({"circulation": "windkessel"}, "circulation.kind"),
    ],
)
def test_what_is_no_cavity(parts, key):
    """The message names the key."""
    with pytest.raises(ms.InputError) as error:
        half_sphere(
            None, cavities=ms.Cavities(**{"names": ("endocardium",), "circulation": Isovolumetric()} | parts)
        )
    assert error.value.key == key


def test_what_does_not_go_together():
    """Volumes that are none, and pressures that are given twice."""
    with pytest.raises(ms.InputError, match="-3 is not a volume"):
        PrescribedVolume(volume=((0.0, 1.0), (1.0, -3.0)))
    with pytest.raises(ms.InputError, match=r"mechanics\.pressure\.endocardium: the circulation finds"):
        half_sphere(Isovolumetric(), loads=ms.Loads(pressure={"endocardium": 1.0}))
    with pytest.raises(ms.InputError, match="begins in equilibrium with it, and rigid motions are free"):
        half_sphere(Isovolumetric(), preload=1.0, density=1.0, supports=ms.Supports())
    with pytest.raises(ms.InputError, match="imposed stretch"):
        half_sphere(Isovolumetric(), imposed_stretch=ms.ImposedStretch())


def test_more_than_the_wall_bears():
    """A pressure above the greatest that the wall bears ends with a message, and leaves the last state."""
    mechanics = half_sphere(PrescribedPressure(pressure=((0.0, 0.1), (1.0, 2.0))), spacing=8.0)
    mechanics.start(0.0)
    before, pressures = mechanics.u.x.array.copy(), mechanics.cavities.numbers
    with pytest.raises(
        ms.ComputationError,
        match=r"of the change .* reached.*wall of 'endocardium' held [\d.]+ at a pressure of [01]\.\d+, "
        r"PrescribedPressure asked for a pressure of 2.*that the wall bears",
    ):
        mechanics.solve(1.0)
    np.testing.assert_array_equal(mechanics.u.x.array, before)
    np.testing.assert_array_equal(mechanics.cavities.numbers, pressures)


@pytest.mark.parametrize("late", [{"viscosity": 0.5}, {"density": 1.0}, {"damping": {"epicardium": 0.1}}])
def test_preload_is_static(late):
    """What resists motion begins with a preload as an elastic body does, at rest, and stays there."""
    springs = {"sliding": ["base"], "robin": {"epicardium": 1e-3}}
    damped = ms.Supports(**springs, damping=late.pop("damping", {}))
    elastic = half_sphere(Isovolumetric(), 8.0, preload=0.2, supports=ms.Supports(**springs))
    other = half_sphere(Isovolumetric(), 8.0, preload=0.2, supports=damped, **late)
    for mechanics in (elastic, other):
        mechanics.start(0.0)
    np.testing.assert_allclose(other.u.x.array, elastic.u.x.array, atol=1e-8)
    begun = other.cavities.values()
    for time in (0.1, 0.3):
        other.solve(time, order=2)
        other.accept(time)
    np.testing.assert_allclose(other.u.x.array, elastic.u.x.array, atol=1e-7)
    assert other.cavities.values() == pytest.approx(begun, rel=1e-7)


class Lost:
    """A 0D model that has no states once a pressure is above a limit."""

    cavities, states = 1, ("level",)

    def __init__(self, beyond):
        self.beyond = beyond

    def initial_states(self, pressures, volumes):
        return [0.0]

    def rates(self, time, states, pressures):
        return [self.beyond(pressures[0], states[0])], [3.0]


def test_a_circulation_without_states_is_named():
    """Where the 0D model is what fails, the message says so, and nothing is left changed."""
    mechanics = half_sphere(Lost(lambda p, level: np.nan if p > 0.21 else 0.0), spacing=8.0, preload=0.2)
    mechanics.start(0.0)
    before = mechanics.u.x.array.copy()
    with pytest.raises(ms.ComputationError, match="the circulation, Lost, has no states for the pressures"):
        mechanics.solve(100.0)
    np.testing.assert_array_equal(mechanics.u.x.array, before)
    broken = half_sphere(Lost(lambda p, level: p / "a"), spacing=8.0, preload=0.2)
    with pytest.raises(ms.InputError, match=r"Lost\.rates failed at t = 0: TypeError: "):
        broken.start(0.0)


@pytest.mark.parametrize("given", [PrescribedPressure(pressure=0.3), PrescribedVolume(volume=HALF)])
def test_derivatives_of_a_share(given):
    """Where a step is followed in smaller jumps, the derivatives are those of a jump's own equations."""
    mechanics, step = half_sphere(given, spacing=8.0), 1e-5
    cavities, u = mechanics.cavities, mechanics.u.x.array
    cavities.begin(0.0)
    cavities.go(0.3)
    before, by_u, by_pressure = cavities.equations()
    moved = np.random.default_rng(1).standard_normal(len(u))
    u += step * moved
    np.testing.assert_allclose((cavities.equations()[0] - before) / step, by_u @ moved, rtol=1e-4, atol=1e-9)
    u -= step * moved
    cavities.put(cavities.numbers + step)
    np.testing.assert_allclose((cavities.equations()[0] - before) / step, by_pressure[0], atol=1e-9)
    assert np.abs(by_u).max() + np.abs(by_pressure).max() > 0.9


def test_more_than_the_ventricle_holds():
    """A volume that the wall cannot hold ends with what it held and what was asked, in words."""
    mechanics = half_sphere(PrescribedVolume(volume=((0.0, HALF), (1.0, 1e9))), spacing=8.0)
    mechanics.start(0.0)
    before = mechanics.u.x.array.copy()
    said = r"the wall of .endocardium. held [\d.e+]+ at .*, PrescribedVolume asked for a volume of 1e\+09"
    with pytest.raises(ms.ComputationError, match=said):
        mechanics.solve(1.0)
    np.testing.assert_array_equal(mechanics.u.x.array, before)


def test_a_hole_in_the_wall():
    """Facets that were left out of the surface are no opening: it is not closed by a cone, but refused."""
    shape = Ventricle(endocardium=(INNER, INNER), epicardium=(OUTER, OUTER), base=0.0, spacing=8.0, layers=1)
    body = ms.build(
        shape, EllipsoidalFibres(endocardium=shape.endocardium, epicardium=shape.epicardium), ALONE
    )
    tags, tag = body.meshed.facet_tags, body.meshed.boundaries["endocardium"]
    inner = tags.find(tag)
    low = inner[np.argmin(dmesh.compute_midpoints(body.mesh, 2, inner)[:, 2])]
    values = np.where(tags.indices == low, 99, tags.values).astype(np.int32)
    meshed = dataclasses.replace(body.meshed, facet_tags=dmesh.meshtags(body.mesh, 2, tags.indices, values))
    body = dataclasses.replace(body, meshed=meshed)
    with pytest.raises(
        ms.InputError,
        match=r"not closed: over a length of .* around \[.*, -\d.*\] it ends \(loop [12] of 2\)",
    ):
        ms.Mechanics(
            body,
            kinematics=Solid(),
            material=NeoHookean(mu=MU),
            supports=ms.Supports(sliding=["base"]),
            cavities=ms.Cavities(("endocardium",), Isovolumetric()),
        )
