"""The case `sheet-2d` as a careful user of DOLFINx would write it: what myostrain is timed against.

An incompressible neo-Hookean sheet in plane stress contracts along its fibres by the active strain of
Ambrosi, Arioli, Nobile, Quarteroni (SIAM J. Appl. Math. 71(2), 2011, "the paper") while a FitzHugh-Nagumo
pulse runs over it.  Non-dimensional.  Nothing here comes from myostrain, and nothing is tuned:

- displacement and potential are P1 on the same mesh; default JIT options; every form is assembled again at
  every step;
- mechanics: the energy is written once, UFL derives the residual and the tangent, SNES does Newton's method
  with the default line search and a fresh MUMPS LU factorisation at each iteration; one solve a step;
- potential (7.2): first-order semi-implicit, the diffusion implicit and pulled back with the current F, the
  reaction explicit (the most usual IMEX step; A dt = 0.1 is far inside its limit); CG with Jacobi, from zero;
- recovery (7.3): backward Euler, node by node.

The one choice a beginner might miss is `quadrature_degree`: UFL's own estimate for this energy's tangent is
5, seven points a triangle in place of three, for no accuracy: the fields are linear.

    python benchmarks/textbook.py [steps] [element size]
"""

import contextlib
import time

with contextlib.suppress(ImportError):
    import dolfinx_solver  # noqa: F401  (the PyPI wheel must come first; other installs of DOLFINx have none)
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem.petsc import LinearProblem, NonlinearProblem


class Textbook:
    """The sheet on `mesh`; `step()` advances it by `dt`.

    Attributes
    ----------
    v, w, u
        Potential, recovery, displacement: DOLFINx functions at `time`.
    time, dt
        Non-dimensional.
    seconds
        Wall-clock seconds spent in the steps so far: {"potential": ..., "mechanics": ...}.
    newton
        Newton iterations so far, as many as factorisations; the solve that makes the initial state in
        equilibrium counts neither here nor in `seconds`.
    """

    def __init__(
        self,
        mesh,
        *,
        fibre=(1, -1),
        alpha=0.1,
        tau=0.2,
        A=100.0,
        D=100.0,
        beta=0.3,
        mu=1.0,
        robin=1.0,
        dt=1e-3,
        initial=None,
    ):
        self.dt, self.tau, self.time = dt, tau, 0.0
        self.seconds = {"potential": 0.0, "mechanics": 0.0}
        self.newton = 0

        V = fem.functionspace(mesh, ("Lagrange", 1))
        U = fem.functionspace(mesh, ("Lagrange", 1, (2,)))
        v = self.v = fem.Function(V, name="potential")
        w = self.w = fem.Function(V, name="recovery")
        u = self.u = fem.Function(U, name="displacement")
        if initial is not None:  # initial(x), x of shape (3, points), gives the potential at the points
            v.interpolate(initial)
            v.x.scatter_forward()

        # Kinematics, active strain, energy.
        dx = ufl.dx(metadata={"quadrature_degree": 2})
        identity = ufl.Identity(2)
        F = identity + ufl.grad(u)
        n = ufl.as_vector(np.asarray(fibre, dtype=float) / np.linalg.norm(fibre))
        gamma = -beta * v
        Fo_inverse = identity - gamma / (1 + gamma) * ufl.outer(n, n)
        Fe = F * Fo_inverse
        energy = mu / 2 * (1 + gamma) * (ufl.inner(Fe, Fe) + 1 / ufl.det(F) ** 2 - 3) * dx
        energy += robin / 2 * ufl.inner(u, u) * ufl.ds

        residual = ufl.derivative(energy, u, ufl.TestFunction(U))
        self.mechanics = NonlinearProblem(
            residual,
            u,
            J=ufl.derivative(residual, u, ufl.TrialFunction(U)),
            petsc_options_prefix="textbook_mechanics_",
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

        # Potential: (v - v_old) / dt - Div(F^-1 D F^-T Grad v) = -A v_old (v_old - alpha)(v_old - 1) - A w.
        trial, test = ufl.TrialFunction(V), ufl.TestFunction(V)
        pulled_back = D * ufl.inv(F.T * F)
        a = trial * test * ufl.dx + dt * ufl.inner(pulled_back * ufl.grad(trial), ufl.grad(test)) * ufl.dx
        L = (v - dt * A * (v * (v - alpha) * (v - 1) + w)) * test * ufl.dx
        self.v_new = fem.Function(V)
        self.potential = LinearProblem(
            a,
            L,
            u=self.v_new,
            petsc_options_prefix="textbook_potential_",
            petsc_options={
                "ksp_type": "cg",
                "ksp_rtol": 1e-8,
                "ksp_error_if_not_converged": True,
                "pc_type": "jacobi",
            },
        )

        self.mechanics.solve()  # activation is instantaneous: the sheet starts contracted where v > 0

    def step(self):
        """Potential on the body as it is, recovery, then equilibrium with the new potential."""
        start = time.perf_counter()
        self.potential.solve()
        self.v.x.array[:] = self.v_new.x.array
        self.w.x.array[:] = (self.w.x.array + self.dt * self.v.x.array) / (1 + self.dt / self.tau)
        middle = time.perf_counter()
        self.mechanics.solve()
        self.newton += self.mechanics.solver.getIterationNumber()
        self.seconds["potential"] += middle - start
        self.seconds["mechanics"] += time.perf_counter() - middle
        self.time += self.dt


def ellipse(comm, size=1.35, width=130.0, height=180.0):
    """The paper's body, nearly: an ellipse in [0, width] x [0, height], about 12,000 nodes at this size."""
    import gmsh
    from dolfinx.io import gmsh as gmsh_io

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    if comm.rank == 0:
        # OpenCASCADE wants the longer half-axis first: draw it lying down and turn it up.
        body = gmsh.model.occ.addDisk(width / 2, height / 2, 0, height / 2, width / 2)
        gmsh.model.occ.rotate([(2, body)], width / 2, height / 2, 0, 0, 0, 1, np.pi / 2)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(2, [body], 1)
        gmsh.option.setNumber("Mesh.MeshSizeMin", size)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.model.mesh.generate(2)
    mesh = gmsh_io.model_to_mesh(gmsh.model, comm, 0, gdim=2).mesh
    gmsh.finalize()
    return mesh


def bump(x, value=0.9, center=(104.0, 36.0), radius=8.0):
    """The initial potential: `value` within `radius` of `center`, at the bottom right of the body."""
    return np.where((x[0] - center[0]) ** 2 + (x[1] - center[1]) ** 2 <= radius**2, value, 0.0)


def main(steps=50, size=1.35):
    from mpi4py import MPI

    mesh = ellipse(MPI.COMM_WORLD, size)
    start = time.perf_counter()
    sheet = Textbook(mesh, initial=bump)
    setup = time.perf_counter() - start
    for _ in range(steps):
        sheet.step()
    nodes, cells = mesh.geometry.index_map().size_global, mesh.topology.index_map(2).size_global
    v_max = mesh.comm.allreduce(sheet.v.x.array.max(), op=MPI.MAX)
    u_max = mesh.comm.allreduce(np.abs(sheet.u.x.array).max(), op=MPI.MAX)
    if mesh.comm.rank == 0:
        each = {name: f"{1e3 * value / steps:.1f} ms" for name, value in sheet.seconds.items()}
        print(f"{nodes} nodes, {cells} triangles, {mesh.comm.size} process(es), set up in {setup:.1f} s")
        print(f"a step: {each}, total {1e3 * sum(sheet.seconds.values()) / steps:.1f} ms")
        print(f"{sheet.newton / steps:.2f} Newton iterations a step; t = {sheet.time:.3f}")
        print(f"largest v {v_max:.6f}, largest |u_i| {u_max:.6f}")


if __name__ == "__main__":
    import sys

    main(*(kind(argument) for kind, argument in zip((int, float), sys.argv[1:], strict=False)))
