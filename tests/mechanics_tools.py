"""Shared by the tests of mechanics: numpy's own 3D algebra, and fields that hold one sample a cell."""

import dataclasses

import myostrain as ms
from myostrain.activation import Fibre
from myostrain.engine import MPI, compile_form, fem, jit_options
from myostrain.solvers.newton import ChordNewton

import numpy as np
import ufl
from dolfinx import mesh as dmesh
from dolfinx.fem import petsc as fem_petsc


class Recorded(ChordNewton):
    """The mechanics' solver, remembering the form that it was given."""

    def __init__(self, residual, unknown, bcs, **others):
        super().__init__(residual, unknown, bcs, **others)
        self.residual, self.unknown = residual, unknown


class GivenStrain:
    """An active deformation of a user's own: γ is what is given in UFL, whatever the nodes have."""

    def __init__(self, gamma, deformation=None):
        self.value, self.deformation = gamma, deformation or Fibre()

    def tensor(self, gamma, fibres):
        return self.deformation.tensor(ufl.as_ufl(self.value), fibres)


def sample_mesh(n):
    """An interval of n cells: a sample is a cell, and one evaluation serves all samples."""
    return dmesh.create_interval(MPI.COMM_SELF, n, [0.0, 1.0])


def field(mesh, shape):
    """A field that is constant in each cell."""
    return fem.Function(fem.functionspace(mesh, ("DG", 0, shape)))


def put(function, samples):
    """Write samples (n, ...), one a cell, into a field of :func:`field`."""
    cells = function.function_space.dofmap.list[:, 0]
    values = function.x.array.reshape(len(cells), -1)
    values[cells] = np.reshape(samples, (len(cells), -1))


def at_midpoints(expression, mesh):
    """Prepare the evaluation of a UFL expression at the midpoint of each cell; call the result for the
    values.
    """
    tdim = mesh.topology.dim
    point = np.full((1, tdim), 1.0 / (tdim + 1))
    cells = np.arange(mesh.topology.index_map(tdim).size_local, dtype=np.int32)
    compiled = fem.Expression(expression, point, jit_options=jit_options())
    return lambda: compiled.eval(mesh, cells)[:, 0]


def gradient(mechanics):
    """F₂ = Grad x in every cell's midpoint, (cells, dim, dim)."""
    u = ufl.split(mechanics.u)[0] if mechanics.kinematics.has_pressure else mechanics.u
    return np.eye(mechanics.body.dim) + at_midpoints(ufl.grad(u), mechanics.body.mesh)()


def rotations(n, dim, rng):
    """Random rotations (n, dim, dim)."""
    Q, R = np.linalg.qr(rng.standard_normal((n, dim, dim)))
    Q *= np.sign(np.einsum("nii->ni", R))[:, None, :]
    Q[:, :, 0] *= np.linalg.det(Q)[:, None]
    return Q


def deformations(n, dim, rng, *, isochoric=False, low=0.6, high=1.6):
    """Random F = R U (n, dim, dim): rotations and principal stretches from low to high."""
    stretches = np.exp(rng.uniform(np.log(low), np.log(high), (n, dim)))
    if isochoric:
        stretches /= np.prod(stretches, axis=1, keepdims=True) ** (1 / dim)
    axes = rotations(n, dim, rng)
    return rotations(n, dim, rng) @ (axes * stretches[:, None, :]) @ axes.transpose(0, 2, 1)


def directions(n, dim, rng):
    """Random unit vectors (n, dim)."""
    d = rng.standard_normal((n, dim))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def moduli(material):
    """μ and μ₂ of a Mooney–Rivlin material, μ₂ = 0 for the neo-Hookean one."""
    return material.mu, getattr(material, "mu_2", 0.0)


def mooney_rivlin_energy(Fe, mu, mu_2):
    """(3.1) for Fe (n, 3, 3); the second invariant of B is |cof Fe|², which (3.2) does not say."""
    cofactor = np.linalg.det(Fe)[:, None, None] * np.linalg.inv(Fe).transpose(0, 2, 1)
    return mu / 2 * ((Fe**2).sum((1, 2)) - 3) + mu_2 / 2 * ((cofactor**2).sum((1, 2)) - 3)


def mooney_rivlin_stress(Fe, mu, mu_2):
    """∂W/∂Fe = μ Fe + μ₂ (I Fe − B Fe) for Fe (n, 3, 3), by hand."""
    B = Fe @ Fe.transpose(0, 2, 1)
    first = np.trace(B, axis1=1, axis2=2)[:, None, None]
    return mu * Fe + mu_2 * (first * Fe - B @ Fe)


def lifted(F2, stretch):
    """F (n, 3, 3) of in-plane gradients (n, 2, 2) and out-of-plane stretches (n,)."""
    F = np.zeros((len(F2), 3, 3))
    F[:, :2, :2], F[:, 2, 2] = F2, stretch
    return F


def active(gamma, n):
    """Fo = 1 + γ n⊗n (k, dim, dim) for strains (k,) and unit fibres (k, dim)."""
    return np.eye(n.shape[1]) + gamma[:, None, None] * n[:, :, None] * n[:, None, :]


def plane_stress_cauchy(F2, Fo, mu, mu_2, constraint):
    """Cauchy stress (n, 3, 3) of an incompressible sheet with free faces, (1.6) and (3.3) in 3D algebra."""
    Jo = np.linalg.det(Fo)
    J = np.ones_like(Jo) if constraint == "total" else Jo
    F = lifted(F2, J / np.linalg.det(F2))
    Fi = np.linalg.inv(Fo)
    P = Jo[:, None, None] * mooney_rivlin_stress(F @ Fi, mu, mu_2) @ Fi.transpose(0, 2, 1)
    sigma = P @ F.transpose(0, 2, 1) / J[:, None, None]
    return sigma - sigma[:, 2:, 2:] * np.eye(3)


def sheet(size=(2.0, 1.0), spacing=0.25, fibre=(2.0, 1.0)):
    """A rectangle with oblique fibres."""
    return ms.build(ms.geometry.Rectangle(size=size, spacing=spacing), ms.UniformFibres(direction=fibre))


def random_activation(mechanics, beta=0.3, seed=1):
    """γ = −β v of a potential v between 0 and 1 that changes from node to node."""
    gamma = mechanics.activation.x.array
    gamma[:] = -beta * np.random.default_rng(seed).uniform(0.0, 1.0, len(gamma))


def described(parts):
    """What ``Mechanics`` takes, with the values of supports and loads put into their descriptions."""
    parts, into = dict(parts), {}
    for name, cls in (("supports", ms.Supports), ("loads", ms.Loads)):
        given = {f.name: parts.pop(f.name) for f in dataclasses.fields(cls) if f.name in parts}
        if given:
            into[name] = cls(**given)
    return parts | into


def check_tangent(mechanics):
    """The tangent that the solver factorizes against fourth-order differences of the residual."""
    form, unknown = mechanics.solver.residual, mechanics.solver.unknown
    residual = compile_form(form)
    state = unknown.x.array.copy()
    direction = np.random.default_rng(3).uniform(-1, 1, len(state))
    tangent = fem_petsc.assemble_matrix(compile_form(ufl.derivative(form, unknown)))
    tangent.assemble()
    product, d = tangent.createVecLeft(), tangent.createVecRight()
    d.array[:] = direction
    tangent.mult(d, product)

    def at(h):
        unknown.x.array[:] = state + h * direction
        return fem.assemble_vector(residual).array

    h = 1e-4
    rate = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)
    unknown.x.array[:] = state
    # Measured 8e-12 at most of the largest entry: round-off / h, and h⁴ of the plane-stress 1/(det F₂)².
    np.testing.assert_allclose(rate, product.array, rtol=0, atol=2e-10 * np.abs(product.array).max())
    assert tangent.isSymmetric(1e-12 * np.abs(product.array).max())
