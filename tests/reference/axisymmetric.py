"""An axisymmetric ventricle that turns about its axis, on its exact geometry.

Unknown are r, the angle φ by which a point turns about the axis, and z, as functions of the depth t in the
wall (0 endocardium, 1 epicardium) and of s from apex (0) to base (1). With the reference position

    R = a sin u, Z = c cos u, a and c linear in t, u = π − s (π − arccos(b/c)), b the height of the rim,

the geometry is exact, and F in the local frames (radial, circumferential, axial) is

    [[∂r/∂R, 0, ∂r/∂Z], [r ∂φ/∂R, r/R, r ∂φ/∂Z], [∂z/∂R, 0, ∂z/∂Z]].

Newton's method on the virtual power of energy, springs and follower pressure, loads in steps;
quadrilaterals Q_k, with a pressure Q_(k−1) where the body is incompressible (J = 1).

Nothing of myostrain is used but its import of the engine in the right order.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from myostrain.engine import MPI, PETSc, fem

import basix.ufl
import numpy as np
import ufl
from dolfinx import geometry, mesh
from dolfinx.fem import petsc

CELL = "quadrilateral"


@dataclass(frozen=True)
class Ventricle:
    """The wall and its fibres.

    Args:
        endocardium: Semi-axes (short, long).
        epicardium: Semi-axes (short, long).
        rims: Heights of the rims of endocardium and epicardium.
        helix: Angle of the fibre from the circumference towards the base, at t = 0 and t = 1, degrees.
    """

    endocardium: tuple[float, float] = (7.0, 17.0)
    epicardium: tuple[float, float] = (10.0, 20.0)
    rims: tuple[float, float] = (5.0, 5.0)
    helix: tuple[float, float] = (60.0, -60.0)

    def axes(self, t):
        """Semi-axes at a depth."""
        return tuple(i + t * (o - i) for i, o in zip(self.endocardium, self.epicardium, strict=True))

    def at_rest(self, t, s, cos=np.cos, sin=np.sin, acos=np.arccos):
        """R, Z and u of the parameters."""
        a, c = self.axes(t)
        u = np.pi - s * (np.pi - acos((self.rims[0] + t * (self.rims[1] - self.rims[0])) / c))
        return a * sin(u), c * cos(u), u


@dataclass(frozen=True)
class Problem:
    """What holds and loads a ventricle.

    Args:
        density: Energy per reference volume of F (3 × 3), fibre, direction in the wall across it, outward
            normal, and the load from 0 to 1; UFL.
        incompressible: Whether J = 1.
        augmentation: κ in κ/2 (J − 1)² of an incompressible body.
        pressure: Follower pressure on the endocardium at full load.
        base: Springs on the base: stiffness.
        epicardium: Springs along the normal of the epicardium: stiffness.
        fixed: Components held at the base: "r", "turn", "z".
    """

    density: Callable[..., Any]
    incompressible: bool = True
    augmentation: float = 50.0
    pressure: float = 0.0
    base: float = 0.0
    epicardium: float = 0.0
    fixed: tuple[str, ...] = ("r", "turn", "z")


class Solution:
    """The deformed ventricle; see :func:`solve`."""

    def __init__(self, body, square, parts, volume):
        self._body, self._square, self._parts, self._volume = body, square, parts, volume
        self._tree = geometry.bb_tree(square, 2)

    def __call__(self, t, s):
        """r, φ and z (n, 3) at depths and places (n,)."""
        t, s = np.broadcast_arrays(np.asarray(t, dtype=float), np.asarray(s, dtype=float))
        points = np.stack([t, s, np.zeros_like(t)], axis=1)
        found = geometry.compute_collisions_points(self._tree, points)
        found = geometry.compute_colliding_cells(self._square, found, points)
        cells = np.array([found.links(i)[0] for i in range(len(points))])
        ur, turn, uz = (part.eval(points, cells).reshape(-1) for part in self._parts)
        R, Z, _ = self._body.at_rest(t, s)
        return np.stack([R + ur, turn, Z + uz], axis=1)

    def twist(self, region=0.2):
        """Turn of the lowest fifth of the height, from below, less that of the highest, degrees."""
        t, s = ufl.SpatialCoordinate(self._square)
        R, Z, _ = self._body.at_rest(t, s, ufl.cos, ufl.sin, ufl.acos)
        low, high = -self._body.epicardium[1], max(self._body.rims)
        ends = [ufl.lt(Z, low + region * (high - low)), ufl.gt(Z, high - region * (high - low))]
        ur, turn, _ = self._parts
        turns, (weight, dx) = [], self._volume
        for end in ends:
            arm = ufl.conditional(end, R * (R + ur), 0.0) * weight
            sine, cosine = (fem.assemble_scalar(fem.form(f(turn) * arm * dx)) for f in (ufl.sin, ufl.cos))
            turns.append(np.degrees(np.arctan2(sine, cosine)))
        return turns[1] - turns[0]


def solve(body, given, layers, along, degree=3, step=0.25, quadrature=None):
    """Solve a problem on so many cells through the wall and along it."""
    square = mesh.create_unit_square(MPI.COMM_SELF, layers, along, mesh.CellType.quadrilateral)
    t, s = ufl.SpatialCoordinate(square)
    (a, c), (R, Z, u) = body.axes(t), body.at_rest(t, s, ufl.cos, ufl.sin, ufl.acos)
    jacobian = ufl.as_matrix([[ufl.grad(x)[i] for i in range(2)] for x in (R, Z)])
    degrees = [degree] * 3 + ([degree - 1] if given.incompressible else [])
    space = fem.functionspace(
        square, basix.ufl.mixed_element([basix.ufl.element("Q", CELL, k) for k in degrees])
    )
    w, test = fem.Function(space), ufl.TestFunction(space)
    ur, turn, uz, *rest = ufl.split(w)
    r, z = R + ur, Z + uz
    (rR, rZ), (pR, pZ), (zR, zZ) = (ufl.dot(ufl.grad(x), ufl.inv(jacobian)) for x in (r, turn, z))
    F = ufl.as_matrix([[rR, 0, rZ], [r * pR, r / R, r * pZ], [zR, 0, zZ]])
    J = ufl.det(F)
    upwards = ufl.as_vector([-a * ufl.cos(u), 0, c * ufl.sin(u)])  # towards the base along the ellipse
    upwards /= ufl.sqrt(ufl.dot(upwards, upwards))
    around = ufl.as_vector([0, 1, 0])
    first, last = np.radians(body.helix)
    angle = float(first) + float(last - first) * t
    fibre = ufl.sin(angle) * upwards + ufl.cos(angle) * around
    across = ufl.cos(angle) * upwards - ufl.sin(angle) * around
    outwards = ufl.cross(around, upwards)
    load = fem.Constant(square, 0.0)
    density = given.density(F, fibre, across, outwards, load)
    if given.incompressible:
        density += -rest[0] * (J - 1) + given.augmentation / 2 * (J - 1) ** 2

    facets = [
        mesh.locate_entities_boundary(square, 1, where)
        for where in (
            lambda x: np.isclose(x[0], 0),
            lambda x: np.isclose(x[0], 1),
            lambda x: np.isclose(x[1], 1),
        )
    ]
    order = np.argsort(np.concatenate(facets))
    tags = np.concatenate([np.full(len(f), i + 1, np.int32) for i, f in enumerate(facets)])[order]
    marked = mesh.meshtags(square, 1, np.concatenate(facets)[order], tags)
    ds = ufl.Measure("ds", square, subdomain_data=marked, metadata={"quadrature_degree": 4 * degree})
    dx = ufl.dx(metadata={"quadrature_degree": quadrature or 2 * degree + 4})
    area = abs(ufl.det(jacobian))
    potential = density * R * area * dx
    if given.base:
        length = ufl.sqrt(R.dx(0) ** 2 + Z.dx(0) ** 2)
        apart = r**2 + R**2 - 2 * r * R * ufl.cos(turn) + uz**2
        potential += given.base / 2 * apart * R * length * ds(3)
    if given.epicardium:
        length = ufl.sqrt(R.dx(1) ** 2 + Z.dx(1) ** 2)
        normal = ((r * ufl.cos(turn) - R) * Z.dx(1) - uz * R.dx(1)) / length
        potential += given.epicardium / 2 * normal**2 * R * length * ds(2)
    residual = ufl.derivative(potential, w, test)
    if given.pressure:
        vr, _, vz, *_ = ufl.split(test)
        residual -= load * given.pressure * r * (vr * z.dx(1) - vz * r.dx(1)) * ds(1)

    held = [(("r", "turn", "z").index(name), lambda x: np.isclose(x[1], 1)) for name in given.fixed]
    conditions = []
    for i, where in [*held, (0, lambda x: np.isclose(x[1], 0))]:
        part, _ = space.sub(i).collapse()
        dofs = fem.locate_dofs_geometrical((space.sub(i), part), where)
        conditions.append(fem.dirichletbc(fem.Function(part), dofs, space.sub(i)))
    ramp(residual, w, conditions, load, step)
    return Solution(body, square, [w.sub(i).collapse() for i in range(3)], (R * area, dx))


def ramp(residual, w, conditions, load, step):
    """Raise the load from 0 to 1, steps halved where one fails; each begins on the secant of the last two."""
    tangent = fem.form(ufl.derivative(residual, w))
    residual = fem.form(residual)
    A, b, dw = petsc.create_matrix(tangent), fem.Function(w.function_space), fem.Function(w.function_space)
    fixed = np.unique(np.concatenate([condition.dof_indices()[0] for condition in conditions]))
    extent = 50.0
    largest = max(step, 0.1)
    done, before, last = 0.0, w.x.array.copy(), 0.0
    while done < 1:
        target, start = min(1.0, done + step), w.x.array.copy()
        if done > 0:
            w.x.array[:] = start + (target - done) / (done - last) * (start - before)
        load.value = target
        for _ in range(15):
            b.x.array[:] = 0.0
            fem.assemble_vector(b.x.array, residual)
            b.x.array[fixed] = 0.0
            A.zeroEntries()
            petsc.assemble_matrix(A, tangent, bcs=conditions)
            A.assemble()
            solver = PETSc.KSP().create(MPI.COMM_SELF)  # anew: a factorization that met NaN stays broken
            solver.setOperators(A)
            solver.setType("preonly")
            solver.getPC().setType("lu")
            solver.getPC().setFactorSolverType("mumps")
            solver.solve(b.x.petsc_vec, dw.x.petsc_vec)
            solver.destroy()
            w.x.array[:] -= dw.x.array
            size = np.abs(dw.x.array).max()
            if not size < extent or size < 1e-7:
                break
        if size < 1e-7:
            before, last, done, step = start, done, target, min(1.5 * step, largest)
            continue
        w.x.array[:], step = start, step / 2
        if step < 1e-4:
            raise RuntimeError(f"no equilibrium beyond {done:.1%} of the load")
