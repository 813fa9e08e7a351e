"""A contracting slab as a careful user of DOLFINx would write it: what solids of myostrain are timed against.

An incompressible neo-Hookean solid contracts along x by the active strain of Ambrosi, Arioli, Nobile,
Quarteroni (SIAM J. Appl. Math. 71(2), 2011), J = 1 by a pressure, displacement P2 and pressure P1 (Taylor and
Hood). Nothing here comes from myostrain, and nothing is tuned: default kernel options, SNES with its default
line search, a fresh tangent and a fresh MUMPS LU factorization in each iteration, each load step from the
last state. The body is free; its rigid motions are held at six components of three corners, as each of them
moves along the axes through the first one only.
"""

import contextlib
import time

with contextlib.suppress(ImportError):
    import dolfinx_solver  # noqa: F401  (the PyPI wheel must come first; other installs of DOLFINx have none)
import basix.ufl
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem.petsc import NonlinearProblem


class Textbook:
    """The slab [0, a] × [0, b] × [0, c] on `mesh`; `step(gamma)` finds its equilibrium for an active strain.

    Attributes
    ----------
    u
        Displacement and pressure, a DOLFINx function.
    seconds, newton
        Wall-clock seconds and Newton iterations (as many as factorizations) of each step so far.
    """

    def __init__(self, mesh, size, mu=1.0):
        cell = mesh.basix_cell()
        elements = [
            basix.ufl.element("Lagrange", cell, 2, shape=(3,)),
            basix.ufl.element("Lagrange", cell, 1),
        ]
        W = fem.functionspace(mesh, basix.ufl.mixed_element(elements))
        self.u = fem.Function(W)
        self.gamma = fem.Constant(mesh, 0.0)
        self.seconds, self.newton = [], []

        u, p = ufl.split(self.u)
        F = ufl.Identity(3) + ufl.grad(u)
        n = ufl.as_vector([1.0, 0.0, 0.0])
        Fe = F * ufl.inv(ufl.Identity(3) + self.gamma * ufl.outer(n, n))
        energy = mu / 2 * (1 + self.gamma) * (ufl.inner(Fe, Fe) - 3) - p * (ufl.det(F) - 1)
        # As many points as myostrain takes; UFL's own estimate would take more.
        metadata = {"quadrature_degree": 3, "quadrature_rule": "xiao_gimbutas"}
        residual = ufl.derivative(energy * ufl.dx(metadata=metadata), self.u)
        held = [((0, 0, 0), (0, 1, 2)), ((size[0], 0, 0), (1, 2)), ((0, size[1], 0), (2,))]
        self.problem = NonlinearProblem(
            residual,
            self.u,
            bcs=[_pin(W, corner, i) for corner, components in held for i in components],
            petsc_options_prefix="textbook_solid_",
            petsc_options={
                "snes_type": "newtonls",
                "snes_rtol": 1e-9,
                "snes_atol": 1e-9,
                "snes_error_if_not_converged": True,
                "ksp_type": "preonly",
                "ksp_error_if_not_converged": True,
                "pc_type": "lu",
                "pc_factor_mat_solver_type": "mumps",
            },
        )

    def step(self, gamma):
        """Equilibrium for the active strain `gamma`, from the last state."""
        begin = time.perf_counter()
        self.gamma.value = gamma
        self.problem.solve()
        self.seconds.append(time.perf_counter() - begin)
        self.newton.append(self.problem.solver.getIterationNumber())


def _pin(W, corner, component):
    parent = W.sub(0).sub(component)
    V, _ = parent.collapse()
    corner = np.array(corner, dtype=float)[:, None]
    dofs = fem.locate_dofs_geometrical((parent, V), lambda x: np.linalg.norm(x - corner, axis=0) < 1e-9)
    return fem.dirichletbc(fem.Function(V), dofs, parent)
