"""Stress at nodes: exact for what is linear, of second order for a thick sphere's closed form."""

from myostrain.activation import Fibre
from myostrain.engine import fem
from myostrain.geometry import Slab, UniformFibres, build
from myostrain.kinematics import Solid
from myostrain.materials import NeoHookean
from myostrain.mechanics.active_body import ActiveBody
from myostrain.mechanics.discretization import unknown_space, volume_measure
from myostrain.mechanics.nodal_fields import NodalFields
from myostrain.mechanics.recovery import Recovery

import numpy as np
import pytest
import ufl

from small_cases import ALONE

MU, GROWTH, CENTRE = 2.0, 4.0, np.array([-1.2, -1.0, -0.8])


def block(cells):
    return build(
        Slab(size=(1.0, 1.0, 1.0), spacing=1 / cells), UniformFibres(direction=(1.0, 0.0, 0.0)), ALONE
    )


def test_linear_fields_are_met():
    """Recovery: exact for a linear field at every node, corners too; and for a constant in each component."""
    body = block(2)
    space = fem.functionspace(body.mesh, ("Lagrange", 1))
    X = ufl.SpatialCoordinate(body.mesh)
    found = Recovery(space).prepare(ufl.as_vector([1 + 2 * X[0] - 3 * X[1] + X[2], X[2], 0 * X[0] + 4]))()
    x, y, z = space.tabulate_dof_coordinates().T
    np.testing.assert_allclose(found, np.stack([1 + 2 * x - 3 * y + z, z, 4 + 0 * x], axis=1), atol=1e-12)


def errors(cells):
    """Largest errors of the trace of the stress, relative to its range, by fits and by means, in part of a
    thick sphere whose displacement and pressure are the exact ones at their nodes.

    r³ = R³ + A; λ = r/R; J = 1; σ = μ F Fᵀ − p with p = μ (λ⁻⁴/2 − 2/λ), which balances.
    """
    body, solid = block(cells), Solid()
    unknown = fem.Function(unknown_space(body.mesh, solid))
    a = fem.Function(fem.functionspace(body.mesh, ("Lagrange", 1)))

    def stretch(X):
        R = np.linalg.norm(X[:3].T - CENTRE, axis=1)
        return np.cbrt(1 + GROWTH / R**3)

    unknown.sub(0).interpolate(lambda X: (stretch(X) - 1) * (X[:3] - CENTRE[:, None]))
    unknown.sub(1).interpolate(lambda X: MU * (stretch(X) ** -4 / 2 - 2 / stretch(X)))
    unknown.x.scatter_forward()
    active = ActiveBody(body, solid, NeoHookean(mu=MU), Fibre(), 0.0)
    nodal = NodalFields(active, unknown, a, None, body.f0, volume_measure(body.mesh, solid, None))
    s = stretch(a.function_space.tabulate_dof_coordinates().T)
    exact = MU * (2 * s**2 + s**-4 - 3 * (s**-4 / 2 - 2 / s))
    means = nodal._mean("trace", ufl.tr(nodal.cauchy))
    return [float(np.abs(values - exact).max() / np.ptp(exact)) for values in (nodal.stress_trace(), means)]


def test_the_stress_of_a_thick_sphere():
    """NodalFields.stress_trace: second order in the largest error; means have the first.

    Measured: 0.50, 0.17, 0.051 of the range (orders 1.55, 1.76), and 0.75, 0.44, 0.24 (0.77, 0.88).
    """
    found = np.array([errors(cells) for cells in (2, 4, 8)])
    orders = np.log2(found[:-1] / found[1:])
    assert orders[-1, 0] > 1.7
    assert orders[-1, 1] < 1.3
    assert found[-1, 0] == pytest.approx(0.051, rel=0.1)
