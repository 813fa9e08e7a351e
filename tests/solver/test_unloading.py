"""The unloaded reference: loaded it is the given geometry again, a sphere's is that of the closed form."""

import myostrain as ms
from myostrain.circulation import Isovolumetric
from myostrain.engine import fem
from myostrain.geometry import EllipsoidalFibres, Ventricle
from myostrain.kinematics import Solid
from myostrain.materials import NeoHookean
from myostrain.mechanics import unloading

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from small_cases import ALONE

MU, INNER, OUTER, PRESSURE = 2.0, 10.0, 14.0, 0.6


def image(spacing=8.0, fibres=None):
    """Half a thick sphere, with fibres; as it is given, it is under pressure."""
    shape = Ventricle(
        endocardium=(INNER, INNER), epicardium=(OUTER, OUTER), base=0.0, spacing=spacing, layers=1
    )
    usual = EllipsoidalFibres(endocardium=shape.endocardium, epicardium=shape.epicardium)
    return ms.build(shape, fibres or usual, ALONE)


def parts(**more):
    return {
        "kinematics": Solid(),
        "material": NeoHookean(mu=MU),
        "supports": ms.Supports(
            sliding=["base"], robin={"base": 0.5}, robin_normal={"epicardium": 0.01}, **more
        ),
        "tolerance": 1e-9,
    }


def volume_at_rest(volume):
    """Of the cavity of a neo-Hookean sphere of this wall that has this volume under the pressure."""
    wall = OUTER**3 - INNER**3

    def pressure(ratio):
        A3 = INNER**3 / ratio

        def density(R):
            r3 = R**3 + INNER**3 - A3
            stretch = np.cbrt(r3) / R
            return 2 * MU * (stretch**2 - stretch**-4) * R**2 / r3

        return quad(density, np.cbrt(A3), np.cbrt(A3 + wall))[0]

    return volume / brentq(lambda ratio: pressure(ratio) - PRESSURE, 1.01, 1.8)


def test_unloaded_then_loaded():
    """The nodes are where they were to the tolerance, the cavity was smaller; a damper changes nothing."""
    body = image()
    given = body.mesh.geometry.x.copy()
    more = parts(damping={"epicardium": 0.3})
    reference = ms.unloaded(body, {"endocardium": PRESSURE}, within=1e-7, **more)
    moved = np.linalg.norm(given - reference.mesh.geometry.x, axis=1)
    assert moved.max() > 0.5
    mechanics = ms.Mechanics(
        reference, cavities=ms.Cavities(("endocardium",), Isovolumetric(), PRESSURE), **more
    )
    before = mechanics.cavities.volumes()[0]
    mechanics.start(0.0)
    u = mechanics.displacement().x.array.reshape(-1, 3)
    x = mechanics.displacement().function_space.tabulate_dof_coordinates() + u
    nearest = np.linalg.norm(x[:, None] - given, axis=2).min(axis=1)
    assert nearest.max() < 5e-7 * np.linalg.norm(np.ptp(given, axis=0))
    held = mechanics.cavities.values()["volume_endocardium"]
    assert held > 1.15 * before


def test_reference_of_a_sphere():
    """The cavity at rest has the volume of the closed form, to the error of so coarse a mesh."""
    body = image(spacing=5.0)
    free = {**parts(), "supports": ms.Supports(sliding=["base"], robin={"base": 1e-5})}
    given = ms.Mechanics(body, cavities=ms.Cavities(("endocardium",), Isovolumetric()), **free)
    full = given.cavities.volumes()[0]
    reference = ms.unloaded(body, {"endocardium": PRESSURE}, **free)
    rest = ms.Mechanics(reference, cavities=ms.Cavities(("endocardium",), Isovolumetric()), **free)
    assert full / rest.cavities.volumes()[0] == pytest.approx(
        full / volume_at_rest(full), rel=0.035
    )  # O(h²): facets


def test_fibres_are_carried_back():
    """F f0 is along the fibre of the image, in every cell."""
    body = image(fibres=ms.UniformFibres(direction=(1.0, 0.3, 0.5), sheet=(0.0, 0.0, 1.0)))
    points = np.array([[0.2, 0.3, 0.1]])
    cells = np.arange(body.cells, dtype=np.int32)

    def directions(fibres):
        expression = fem.Expression(fem.Constant(body.mesh, 1.0) * fibres.f0, points)
        return expression.eval(body.mesh, cells).reshape(-1, 3)

    def edges():
        corners = body.mesh.geometry.x[body.mesh.geometry.dofmaps[0]]
        return np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)

    given, shape = directions(body.fibres), edges()
    reference = ms.unloaded(body, {"endocardium": PRESSURE}, **parts())
    F = shape @ np.linalg.inv(edges())
    pushed = np.einsum("cij,cj->ci", F, directions(reference.fibres))
    along = np.abs(np.einsum("ci,ci->c", pushed, given)) / np.linalg.norm(pushed, axis=1)
    turned = np.abs(np.einsum("ci,ci->c", directions(reference.fibres), given))
    assert along.min() > 1 - 1e-12
    assert turned.min() < 0.999


def test_no_cell_is_inverted():
    """A correction that would turn a cell over is shortened, however well the body finds an equilibrium."""
    body = image()
    carried = unloading._Carried(body)
    nodes = body.mesh.geometry.x
    moved, loads = ms.geometry.Body(body.meshed, carried.directions), ms.Loads(pressure={"endocardium": 0.1})
    mechanics = ms.Mechanics(moved, loads=loads, **parts())
    search = unloading._Search(mechanics, carried, nodes.copy(), 1.0)
    corners = nodes[body.mesh.geometry.dofmaps[0][0]]
    step = np.zeros_like(nodes)  # one corner goes through the opposite face of its cell
    step[body.mesh.geometry.dofmaps[0][0][0]] = 1.5 * (corners[1:].mean(axis=0) - corners[0])
    assert not search._go(step)
    assert carried.follow() > unloading.THIN


def test_no_reference():
    """Too great a pressure ends with a message, and the mesh as it was; what makes no sense is refused."""
    body = image()
    given = body.mesh.geometry.x.copy()
    with pytest.raises(
        ms.ComputationError, match=r"no unloaded reference was found: .*Try: a smaller preload"
    ):
        ms.unloaded(body, {"endocardium": 8.0}, **parts())
    np.testing.assert_array_equal(body.mesh.geometry.x, given)
    with pytest.raises(ms.InputError, match=r"circulation\.unload: no pressure acts"):
        ms.unloaded(body, {"endocardium": 0.0}, **parts())
    with pytest.raises(ms.InputError, match=r"circulation\.unload: .*rigid motions are free: give robin > 0"):
        ms.unloaded(body, {"endocardium": 0.1}, **{**parts(), "supports": ms.Supports(sliding=["base"])})
