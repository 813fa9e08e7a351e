"""The potential on a body that moves as prescribed: manufactured solutions of (2.8), (2.2) and the advective form.

The deformation is handed to `Potential` as `Deformation(F, J)` of a displacement that the test writes, without
any mechanics. The source that makes v and w exact is taken from the equations by the complex step: fluxes and
amounts are differentiated numerically, to round-off, so that no formula of the program is repeated here.
"""

import myostrain as ms
from myostrain.history import backward_difference, extrapolation_weights
from myostrain.kinematics import Deformation

import basix.ufl
import numpy as np
import pytest
import ufl
from coupled import BANDS, TIGHT, coordinates, observed_orders
from dolfinx import fem

TINY = 1e-100
TAU = 0.4


def derivative(f, *at, by):
    """∂f/∂(argument ``by``) by one complex step; exact to round-off for analytic f."""
    return np.imag(f(*[a + 1j * TINY * (i == by) for i, a in enumerate(at)])) / TINY


class Line1D:
    """x(X, t) with J = x′ between 0.6 and 1.4; D turns with nothing here. v has no slope at the ends."""

    degree, diffusivity = 2, 0.1
    fibre = None

    def body(self, n):
        return ms.build(ms.geometry.Line(length=1.0, spacing=1.0 / n))

    def displacement(self, t, X):
        return [0.4 * np.sin(3 * t + 0.5) * np.sin(np.pi * X) / np.pi]

    def F(self, t, X):
        return np.reshape(1 + 0.4 * np.sin(3 * t + 0.5) * np.cos(np.pi * X), (*X.shape, 1, 1))

    def v(self, t, X):
        return 0.4 + 0.3 * np.cos(2 * t) * np.cos(2 * np.pi * X)

    def slope(self, t, X):
        return np.reshape(-0.6 * np.pi * np.cos(2 * t) * np.sin(2 * np.pi * X), (*X.shape, 1))

    def w(self, t, X):
        return 0.2 + 0.1 * np.sin(3 * t) * np.cos(np.pi * X)


class Sheet2D:
    """A sheet sheared and stretched unevenly, det F = 1 or not; D four times larger along the turning fibre.

    The gradient of v vanishes on the boundary, and so does the flux, whatever the fibres.
    """

    degree, diffusivity = 1, (0.2, 0.05)
    fibre = np.array([1.0, -0.5]) / np.sqrt(1.25)

    def __init__(self, isochoric):
        self.isochoric = isochoric

    def body(self, n):
        geometry = ms.geometry.Rectangle(size=(1.0, 1.0), spacing=1.0 / n)
        return ms.build(geometry, ms.UniformFibres(direction=tuple(self.fibre)))

    def stretches(self, t):
        along = 1 + 0.3 * np.sin(3 * t + 0.5)
        return along, 1 / along if self.isochoric else 1 + 0.2 * np.sin(2 * t)

    def displacement(self, t, X, Y):
        a, b = self.stretches(t)
        return [(a - 1) * X + 0.5 * np.cos(t) * Y**2, (b - 1) * Y]

    def F(self, t, X, Y):
        a, b = self.stretches(t)
        F = np.zeros((*np.shape(X), 2, 2), dtype=complex)
        F[..., 0, 0], F[..., 0, 1], F[..., 1, 1] = a, np.cos(t) * Y, b
        return F

    def v(self, t, X, Y):
        return 0.2 + 0.6 * np.cos(2 * t) * (np.sin(np.pi * X) * np.sin(np.pi * Y)) ** 2

    def slope(self, t, X, Y):
        amplitude = 0.6 * np.pi * np.cos(2 * t)
        dX = amplitude * np.sin(2 * np.pi * X) * np.sin(np.pi * Y) ** 2
        dY = amplitude * np.sin(2 * np.pi * Y) * np.sin(np.pi * X) ** 2
        return np.stack([dX, dY], axis=-1)

    def w(self, t, X, Y):
        return 0.2 + 0.1 * np.sin(3 * t) * X * (1 + Y)


class Membrane:
    """v (v − 0.1)(v − 1) + w and v − w/τ, with sources that the test sets: a user's own cell object."""

    states = ("recovery",)
    source = 0.0

    def resting_potential(self):
        return 0.0

    def initial_states(self):
        return (0.2,)

    def current(self, v, states):
        return 5 * (v * (v - 0.1) * (v - 1) + states[0])

    def rates(self, v, states):
        return (v - states[0] / TAU + self.source,)


def flux(problem, t, *X):
    """J F⁻¹ D F⁻ᵀ Grad v with D about the deformed fibre, (2.8)."""
    F = problem.F(t, *X)
    J, inverse = np.linalg.det(F), np.linalg.inv(F)
    D = np.broadcast_to(np.asarray(problem.diffusivity), (2,))
    spatial = D[1] * np.eye(F.shape[-1]) + 0j * F
    if problem.fibre is not None:
        deformed = F @ problem.fibre
        deformed = deformed / np.sqrt((deformed**2).sum(axis=-1))[..., None]
        spatial = spatial + (D[0] - D[1]) * deformed[..., :, None] * deformed[..., None, :]
    pulled_back = J[..., None, None] * inverse @ spatial @ np.swapaxes(inverse, -1, -2)
    return np.einsum("...ij,...j->...i", pulled_back, problem.slope(t, *X))


def sources(problem, balance, cell, t, *X):
    """What has to be added to the rates of v and w for the manufactured ones to solve the balance."""
    J = np.linalg.det(problem.F(t, *X)).real
    divergence = sum(derivative(lambda *y, i=i: flux(problem, *y)[..., i], t, *X, by=i + 1) for i in range(len(X)))
    v, w = problem.v(t, *X), problem.w(t, *X)
    change = {}
    for name, field in (("v", problem.v), ("w", problem.w)):
        if balance == "conservative":
            amount = derivative(lambda *y, f=field: np.linalg.det(problem.F(*y)) * f(*y), t, *X, by=0)
            change[name] = amount / J
        else:
            change[name] = derivative(field, t, *X, by=0)
    cell.source = 0.0
    return (
        change["v"] - divergence / J + cell.current(v, [w]),
        change["w"] - cell.rates(v, [w])[0],
    )


def error(problem, balance, mass, order, n, step, end):
    """L2 errors of v and w at the end, on n cells a side."""
    body, cell = problem.body(n), Membrane()
    element = basix.ufl.element("Lagrange", body.mesh.basix_cell(), problem.degree, shape=(body.dim,))
    u = fem.Function(fem.functionspace(body.mesh, element))
    F = ufl.Identity(body.dim) + ufl.grad(u)
    isochoric = getattr(problem, "isochoric", False)

    def stimulus(points, t):
        return sources(problem, balance, cell, t, *points.T)[0]

    potential = ms.Potential(
        body,
        cell=cell,
        diffusivity=problem.diffusivity,
        balance=balance,
        mass=mass,
        deformation=Deformation(F, 1.0 if isochoric else ufl.det(F)),
        stimulus=stimulus,
        options=TIGHT,
    )
    X = coordinates(potential).T

    def move(t):
        u.interpolate(lambda x: np.stack(problem.displacement(t, *x[: body.dim])))
        potential.update_deformation()

    move(0.0)
    potential.v.x.array[:] = problem.v(0.0, *X)
    assert np.all(problem.w(0.0, *X) == cell.initial_states()[0])
    potential.start()
    times = [0.0]
    for number in range(1, round(end / step) + 1):
        t = number * step
        move(t)
        source = sources(problem, balance, cell, t, *X)[1]
        cell.source = source
        guess = potential.extrapolate(extrapolation_weights(times[:order], t))
        potential._stimulus = lambda points, t, cell=cell, source=source: _kept(stimulus, cell, source, points, t)
        potential.solve(t, guess, backward_difference([t, *times[:order]]))
        potential.accept(keep=order)
        times = [t, *times[: order - 1]]
    return [_l2(body, field, exact, times[0]) for field, exact in zip(potential.fields, (problem.v, problem.w))]
