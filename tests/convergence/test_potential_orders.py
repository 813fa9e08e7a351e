"""The potential on a body that moves as prescribed: manufactured solutions of (2.8) and (2.2), both balances.

The deformation is handed to `Potential` as `Deformation(F, J)` of a displacement that the test writes, and no
mechanics is there. The source that makes v and w exact is taken from the equations by the complex step:
fluxes and amounts are differentiated numerically, to round-off, and no formula of the program is repeated.
"""

import itertools

import myostrain as ms
from myostrain.history import backward_difference, extrapolation_weights
from myostrain.kinematics import Deformation

import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem

from coupled import TIGHT, coordinates, observed_orders, rms

TINY = 1e-100
TAU = 0.4


def derivative(f, *at, by):
    """∂f/∂(argument ``by``) by one complex step; exact to round-off for analytic f."""
    return np.imag(f(*[a + 1j * TINY * (i == by) for i, a in enumerate(at)])) / TINY


class Line1D:
    """x(X, t) with J = x′ between 0.6 and 1.4, v without a slope at the ends."""

    degree, diffusivity = 2, 0.1
    fibre, isochoric = None, False

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
    """v (v − 0.1)(v − 1) + w and v − w/τ, with sources that the test sets: a user's own membrane."""

    states = ("recovery",)
    conserved = states
    source = 0.0

    def resting_potential(self):
        return 0.0

    def resting_states(self):
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


def sources(problem, balance, t, *X):
    """What has to be added to the rates of v and w for the manufactured ones to solve the balance."""
    J = np.linalg.det(problem.F(t, *X)).real
    divergence = sum(
        derivative(lambda *y, i=i: flux(problem, *y)[..., i], t, *X, by=i + 1) for i in range(len(X))
    )

    def rate(field):
        if balance == "advective":
            return derivative(field, t, *X, by=0)
        return derivative(lambda *y: np.linalg.det(problem.F(*y)) * field(*y), t, *X, by=0) / J

    v, w = problem.v(t, *X), problem.w(t, *X)
    membrane = Membrane()
    return (
        rate(problem.v) - divergence / J + membrane.current(v, [w]),
        rate(problem.w) - membrane.rates(v, [w])[0],
    )


class Run:
    """One manufactured problem on n cells a side, by steps of order 1 or 2 (backward differences)."""

    def __init__(self, problem, balance, mass, n):
        self.problem, self.balance = problem, balance
        self.body, self.cell = problem.body(n), Membrane()
        mesh, dim = self.body.mesh, self.body.dim
        element = basix.ufl.element("Lagrange", mesh.basix_cell(), problem.degree, shape=(dim,))
        self.u = fem.Function(fem.functionspace(mesh, element))
        F = ufl.Identity(dim) + ufl.grad(self.u)
        self.potential = ms.Potential(
            self.body,
            membrane=self.cell,
            diffusivity=problem.diffusivity,
            balance=balance,
            mass=mass,
            deformation=Deformation(F, 1.0 if problem.isochoric else ufl.det(F)),
            source=lambda points, t: sources(problem, balance, t, *points.T)[0],
            options=TIGHT,
        )
        self.X = coordinates(self.potential).T

    def move(self, t):
        self.u.interpolate(lambda x: np.stack(self.problem.displacement(t, *x[: self.body.dim])))
        self.potential.update_deformation()

    def advance(self, step, end, order):
        """Run to ``end``; returns the nodal values."""
        potential, times = self.potential, [0.0]
        potential.reset()
        potential.v.x.array[:] = self.problem.v(0.0, *self.X)
        self.move(0.0)
        potential.start()
        for number in range(1, round(end / step) + 1):
            t = number * step
            self.move(t)
            self.cell.source = sources(self.problem, self.balance, t, *self.X)[1]
            guess = potential.extrapolate(extrapolation_weights(times[:order], t))
            potential.solve(t, guess, backward_difference([t, *times[:order]]))
            potential.accept(t, keep=order)
            times = [t, *times[: order - 1]]
        return [values.copy() for values in potential.field_values().values()]

    def errors(self, t):
        """L2 errors of v and w, by quadrature that is exact far beyond their order."""
        space = fem.functionspace(self.body.mesh, ("Lagrange", 4))
        found = []
        fields = self.potential.v.copy(), self.potential.v.copy()
        fields[1].x.array[:] = self.potential.states[0]
        for field, exact in zip(fields, (self.problem.v, self.problem.w), strict=True):
            target = fem.Function(space)
            target.interpolate(lambda x, exact=exact: exact(t, *x[: self.body.dim]))
            found.append(fem.assemble_scalar(fem.form((field - target) ** 2 * ufl.dx)) ** 0.5)
        return found


PROBLEMS = {
    "line": Line1D(),
    "sheet, J = 1": Sheet2D(isochoric=True),
    "sheet, J free": Sheet2D(isochoric=False),
}
CASES = [(name, "conservative", mass) for name in PROBLEMS for mass in ("lumped", "averaged")]
# With J = 1 both balances are the same.
CASES += [("line", "advective", "averaged"), ("sheet, J free", "advective", "lumped")]


each_case = pytest.mark.parametrize("name, balance, mass", CASES)


@each_case
def test_second_order_in_space(name, balance, mass):
    """(2.8), (2.2): linear elements on a moving body converge with h² in L2, for v and for w.

    Measured: 1.95..2.01; the error in time is at most 2 % of that in space.
    """
    errors = []
    for n in (16, 32):
        run = Run(PROBLEMS[name], balance, mass, n)
        run.advance(step=0.0025, end=0.2, order=2)
        errors.append(run.errors(0.2))
    for observed in observed_orders(errors)[-1]:
        assert 1.92 < observed < 2.08


@pytest.mark.parametrize("order", [1, 2])
@each_case
def test_order_in_time(name, balance, mass, order):
    """On a moving body the backward differences keep their order, for v and for w.

    From differences between runs at halved steps on one mesh, coarse so that its stiffest mode is resolved.
    Measured: 0.97..1.02 and 1.96..2.03.
    """
    run = Run(PROBLEMS[name], balance, mass, 4)
    results = [run.advance(step, 0.4, order) for step in (0.02, 0.01, 0.005)]
    for values in zip(*results, strict=True):
        observed = observed_orders([rms(a - b) for a, b in itertools.pairwise(values)])[0]
        assert order - 0.08 < observed < order + 0.08
