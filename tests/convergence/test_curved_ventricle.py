"""A contracting ventricle of straight and of curved cells beside an independent axisymmetric solution."""

from myostrain import Case, cases
from myostrain.activation import TransverselyIsotropic
from myostrain.engine import MPI
from myostrain.geometry import Ventricle, build
from myostrain.geometry.ellipsoidal_fibres import EllipsoidalFibres
from myostrain.kinematics import Solid
from myostrain.materials import Guccione1995
from myostrain.mechanics.equilibrium import Mechanics
from myostrain.mechanics.supports import Supports
from myostrain.output.wall import _Region

import numpy as np
import pytest
import ufl

from reference import axisymmetric, land_axisymmetric

#: Active strain, and the twist in degrees on 4 × 24 cubic cells; 10.737 on 3 × 16 quadratic ones.
STRAIN, TWIST = -0.15, 10.727


def test_the_axisymmetric_twist():
    """The reference on a coarse mesh, within 1 % of that on a fine one (measured: 0.5 %)."""
    given = axisymmetric.Problem(land_axisymmetric.Guccione(2.0, 8.0, 2.0, 4.0, strain=STRAIN))
    found = axisymmetric.solve(axisymmetric.Ventricle(), given, 2, 10, degree=2, step=0.5)
    assert found.twist() == pytest.approx(TWIST, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("order, expected, within", [(1, 9.985, 0.01), (2, TWIST, 0.01)])
def test_twist_at_the_shipped_resolution(order, expected, within):
    """Ventricle, order: 2 has the twist to 0.2 % (measured: 10.748), 1 to 7 %, on the same cells."""
    fibres = EllipsoidalFibres(helix=(60.0, -60.0))
    body = build(Ventricle(spacing=2.0, layers=2, order=order), fibres, MPI.COMM_SELF)
    mechanics = Mechanics(
        body,
        kinematics=Solid(),
        material=Guccione1995(),
        active=TransverselyIsotropic(),
        supports=Supports(fixed=("base",)),
        tolerance=1e-7,
    )
    mechanics.start(0.0)
    for i in (1, 2, 3):
        mechanics.activation.x.array[:] = STRAIN * i / 3
        mechanics.solve(float(i))
        mechanics.accept(float(i))
    assert twist(mechanics) == pytest.approx(expected, rel=within)


def twist(mechanics):
    """Turn of the lowest fifth of a ventricle of Land et al. against the highest, from below, degrees."""
    body = mechanics.body
    x = ufl.SpatialCoordinate(body.mesh) + ufl.split(mechanics.u)[0]
    axis = np.array([0.0, 0.0, 1.0])
    apical, basal = (_Region(body, x, axis, *ends).rotation() for ends in ((-20.0, -15.0), (0.0, 5.0)))
    turn = basal.T @ apical
    return np.degrees(np.arctan2(-turn[1, 0], turn[0, 0]))


@pytest.mark.slow
def test_twist_of_the_shipped_ventricle():
    """ventricle-3d at its shipped mesh, supports and pressure, but with fibres in closed form and a uniform
    γ = -0.2, beside the axisymmetric 13.759 (3 × 20 cubic cells); straight cells have 12.82."""
    fibres = 'fibres={kind="ellipsoidal", helix=[60.0, -60.0]}'
    mechanics = Case.from_file(cases.path("ventricle-3d"), [fibres]).simulation(MPI.COMM_SELF).model.mechanics
    mechanics.start(0.0)
    for i in (1, 2, 3, 4):
        mechanics.activation.x.array[:] = -0.05 * i
        mechanics.solve(0.075 * i)
        mechanics.accept(0.075 * i)
    assert twist(mechanics) == pytest.approx(13.759, rel=5e-3)  # measured: 13.785
