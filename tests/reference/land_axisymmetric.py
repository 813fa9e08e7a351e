"""Problems 2 and 3 of Land et al. 2015 as what they are: axisymmetric, with a twist.

Unknown are r, the angle φ by which a point turns about the axis, and z, as functions of the depth t in the
wall (0 endocardium, 1 epicardium) and of s from apex (0) to base (1). With the reference position

    R = a sin u, Z = c cos u, a = 7 + 3 t, c = 17 + 3 t, u = π − s (π − arccos(5/c)),

the geometry is exact, and F in the local frames (radial, circumferential, axial) is

    [[∂r/∂R, 0, ∂r/∂Z], [r ∂φ/∂R, r/R, r ∂φ/∂Z], [∂z/∂R, 0, ∂z/∂Z]].

What is made stationary is ∫ (W + Ta E_ff − p (J − 1) + κ/2 (J − 1)²) R dR dZ − P/2 ∫ r² dz: passive energy,
active stress, constraint (with an augmentation κ that is zero where it holds), pressure times cavity volume.
Newton's method, loads in steps, quadrilaterals Q_k–Q_(k−1).

Nothing of myostrain is used but its import of the engine in the right order.
"""

import sys
from dataclasses import dataclass

from myostrain.engine import MPI, PETSc, fem

import basix.ufl
import numpy as np
import ufl
from dolfinx import geometry, mesh
from dolfinx.fem import petsc

BASE = 5.0
CELL = "quadrilateral"


@dataclass(frozen=True)
class Problem:
    """C, bf, bt, bfs and pressure and tension, kPa."""

    C: float
    bf: float
    bt: float
    bfs: float
    pressure: float
    tension: float


PROBLEMS = {2: Problem(10.0, 1.0, 1.0, 1.0, 10.0, 0.0), 3: Problem(2.0, 8.0, 2.0, 4.0, 15.0, 60.0)}


def at_rest(t, s):
    """(R, Z) of the parameters."""
    u = np.pi - s * (np.pi - np.arccos(BASE / (17 + 3 * t)))
    return (7 + 3 * t) * np.sin(u), (17 + 3 * t) * np.cos(u)


def solve(number, layers, along, degree=3, augmentation=50.0, step=0.05, helix=(90.0, -90.0)):
    """Solve a problem; returns a function of t and s (n,) that gives r, φ and z (n, 3)."""
    given = PROBLEMS[number]
    square = mesh.create_unit_square(MPI.COMM_SELF, layers, along, mesh.CellType.quadrilateral)
    t, s = ufl.SpatialCoordinate(square)
    a, c = 7 + 3 * t, 17 + 3 * t
    u = ufl.pi - s * (ufl.pi - ufl.acos(BASE / c))
    R, Z = a * ufl.sin(u), c * ufl.cos(u)
    jacobian = ufl.as_matrix([[ufl.grad(x)[i] for i in range(2)] for x in (R, Z)])

    def element(k):
        return basix.ufl.element("Q", CELL, k)

    space = fem.functionspace(square, basix.ufl.mixed_element([element(degree)] * 3 + [element(degree - 1)]))
    w = fem.Function(space)
    ur, turn, uz, p = ufl.split(w)
    r, z = R + ur, Z + uz
    (rR, rZ), (pR, pZ), (zR, zZ) = (ufl.dot(ufl.grad(x), ufl.inv(jacobian)) for x in (r, turn, z))
    F = ufl.as_matrix([[rR, 0, rZ], [r * pR, r / R, r * pZ], [zR, 0, zZ]])
    J = ufl.det(F)

    upwards = ufl.as_vector([-a * ufl.cos(u), 0, c * ufl.sin(u)])  # towards the base along the ellipse
    upwards /= ufl.sqrt(ufl.dot(upwards, upwards))
    angle = np.radians(helix[0]) + np.radians(helix[1] - helix[0]) * t
    fibre = ufl.sin(angle) * upwards + ufl.cos(angle) * ufl.as_vector([0, 1, 0])
    E = (F.T * F - ufl.Identity(3)) / 2
    stretch = ufl.dot(fibre, E * fibre)
    shear = 2 * (ufl.dot(E * fibre, E * fibre) - stretch**2)
    Q = given.bf * stretch**2 + given.bfs * shear + given.bt * (ufl.inner(E, E) - stretch**2 - shear)
    load = fem.Constant(square, 0.0)
    density = given.C / 2 * (ufl.exp(Q) - 1) + load * given.tension * stretch
    density += -p * (J - 1) + augmentation / 2 * (J - 1) ** 2
    facets = mesh.locate_entities_boundary(square, 1, lambda x: np.isclose(x[0], 0))
    inside = mesh.meshtags(square, 1, np.sort(facets), np.ones(len(facets), np.int32))
    ds = ufl.Measure("ds", square, subdomain_data=inside, metadata={"quadrature_degree": 4 * degree})(1)
    dx = ufl.dx(metadata={"quadrature_degree": 2 * degree + 4})
    potential = density * R * abs(ufl.det(jacobian)) * dx
    potential -= load * given.pressure / 2 * r**2 * ufl.grad(z)[1] * ds

    held = [(i, lambda x: np.isclose(x[1], 1)) for i in range(3)] + [(0, lambda x: np.isclose(x[1], 0))]
    conditions = []
    for i, where in held:
        part, _ = space.sub(i).collapse()
        dofs = fem.locate_dofs_geometrical((space.sub(i), part), where)
        conditions.append(fem.dirichletbc(fem.Function(part), dofs, space.sub(i)))
    _ramp(potential, w, conditions, load, step)

    parts = [w.sub(i).collapse() for i in range(3)]
    tree = geometry.bb_tree(square, 2)

    def at(t, s):
        t, s = np.broadcast_arrays(np.asarray(t, dtype=float), np.asarray(s, dtype=float))
        points = np.stack([t, s, np.zeros_like(t)], axis=1)
        found = geometry.compute_colliding_cells(
            square, geometry.compute_collisions_points(tree, points), points
        )
        cells = np.array([found.links(i)[0] for i in range(len(points))])
        ur, turn, uz = (part.eval(points, cells).reshape(-1) for part in parts)
        R, Z = at_rest(t, s)
        return np.stack([R + ur, turn, Z + uz], axis=1)

    return at


def _ramp(potential, w, conditions, load, step):
    """Raise the load from 0 to 1, a failed step halved; each step begins on the secant of the last two."""
    residual = fem.form(ufl.derivative(potential, w))
    tangent = fem.form(ufl.derivative(ufl.derivative(potential, w), w))
    A, b, dw = petsc.create_matrix(tangent), fem.Function(w.function_space), fem.Function(w.function_space)
    fixed = np.unique(np.concatenate([condition.dof_indices()[0] for condition in conditions]))
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
            if not size < 50 or size < 1e-9:
                break
        if size < 1e-9:
            before, last, done = start, done, target
            continue
        w.x.array[:], step = start, step / 2
        if step < 1e-3:
            raise RuntimeError(f"no equilibrium beyond {done:.1%} of the load")


if __name__ == "__main__":  # NUMBER LAYERS ALONG [DEGREE]: the lines of cases/land, on this mesh
    found = solve(*map(int, sys.argv[1:]))
    for name, t in (("endocardium", 0.0), ("midwall", 0.5), ("epicardium", 1.0)):
        s = np.linspace(0, 1, 11)
        (R, Z), (r, turn, z) = at_rest(t, s), found(np.full(11, t), s).T
        print(f"\n[lines.{name}]")
        for key, (x, y, height) in (
            ("points", (R, 0 * R, Z)),
            ("converged", (r * np.cos(turn), r * np.sin(turn), z)),
        ):
            print(f"{key} = [")
            for row in np.round(np.stack([x, y, height], axis=1), 4) + 0.0:
                print(f"    {row.tolist()},")
            print("]")
