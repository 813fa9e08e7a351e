"""A beating ventricle as a careful user of DOLFINx would write it: what `heartbeat-3d` is timed against.

The same heart: a human membrane (Bueno-Orovio, Cherry, Fenton 2008, EPI), the active strain of Rossi and
others 2014 with sliding sheets, a Holzapfel–Ogden wall with J = 1 (Taylor and Hood), springs at base and
epicardium, a cavity that a Windkessel with two valves fills and empties. Mesh, directions of fibres, depth
in the wall and a state near the preload come from outside; the equations and solvers here are its own.
Nothing is tuned and nothing kept: in each solve of mechanics Newton's method with a fresh tangent and a
fresh MUMPS LU factorization in each iteration, bordered by the cavity's pressure; the membrane by NumPy,
explicitly, with exponential steps of its gates; diffusion by an implicit step and conjugate gradients,
reassembled when the body has moved.
"""

import contextlib
import time

with contextlib.suppress(ImportError):
    import dolfinx_solver  # noqa: F401  (the PyPI wheel must come first; other installs of DOLFINx have none)
import basix.ufl
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fp
from mpi4py import MPI
from petsc4py import PETSc

#: kPa, mm, ms, as in the case.
A, B, A_F, B_F, A_S, B_S, A_FS, B_FS = 0.059, 2.0, 18.472, 16.026, 2.481, 11.12, 0.216, 11.436
ALPHA, C0, MU, SARCOMERE, RATIO = -9.5, 0.2155, 3000.0, 2.1, 3.0
BASE, EPICARDIUM = 0.5, 0.02
R, C, Z, R_IN, P_IN, P_V = 0.12, 9000.0, 0.0067, 0.004, 1.07, 0.5
ALONG, ACROSS = 0.3, 0.1
#: Lowest and highest z of each stimulus, and its start.
STIMULI = [(-62, -42, 0), (-42, -26, 8), (-26, -10, 16), (-10, 4, 24), (4, 18, 32)]


class Membrane:
    """The three gates at n nodes; `step(v, dt)` gives the rate of the potential, in mV/ms."""

    def __init__(self, n):
        self.v, self.w = np.ones(n), np.ones(n)
        self.s = np.full(n, 0.5 * (1 + np.tanh(2.0994 * -0.9087)))

    def step(self, potential, dt):
        u = (potential + 84) / 85.7
        fast, slow, lowest = u > 0.3, u > 0.13, u > 0.006
        jfi = np.where(fast, -self.v * (u - 0.3) * (1.55 - u) / 0.11, 0.0)
        tau_so = 30.0181 + (0.9957 - 30.0181) * 0.5 * (1 + np.tanh(2.0458 * (u - 0.65)))
        jso = np.where(slow, 1 / tau_so, u / np.where(lowest, 6.0, 400.0))
        jsi = np.where(slow, -self.w * self.s / 1.8875, 0.0)
        tau_v = np.where(fast, 1.4506, np.where(lowest, 1150.0, 60.0))
        tau_w = np.where(slow, 200.0, 60 + (15 - 60) * 0.5 * (1 + np.tanh(65 * (u - 0.03))))
        v_limit = np.where(fast | lowest, 0.0, 1.0)
        w_limit = np.where(slow, 0.0, np.where(lowest, 0.94, 1 - u / 0.07))
        s_limit, tau_s = 0.5 * (1 + np.tanh(2.0994 * (u - 0.9087))), np.where(slow, 16.0, 2.7342)
        self.v = v_limit + (self.v - v_limit) * np.exp(-dt / tau_v)
        self.w = w_limit + (self.w - w_limit) * np.exp(-dt / tau_w)
        self.s = s_limit + (self.s - s_limit) * np.exp(-dt / tau_s)
        return -85.7 * (jfi + jso + jsi)


def force_length(stretch):
    """Share of the greatest force at a stretch."""
    length = SARCOMERE * stretch
    found = -4333.618335582119 / 2 + sum(
        s * np.sin(k * length) + c * np.cos(k * length)
        for k, s, c in (
            (1, 2570.395355352195, -2051.827278991976),
            (2, 1329.53611689133, 302.216784558222),
            (3, 104.943770305116, 218.375174229422),
        )
    )
    return np.where((length > 1.7) & (length < 2.6), np.maximum(found, 0), 0.0)


class Heart:
    """The heart on `mesh`; `fill(near)` finds the state at the preload, `beat(end)` goes on.

    Attributes
    ----------
    history
        Time, volume and pressure of the cavity, pressure in the arteries after each solve of mechanics.
    newton
        Iterations (as many as factorizations) of each solve so far.
    """

    def __init__(self, mesh, facets, names, f0, s0, n0, depth, step=0.1, every=20):
        self.mesh, self.step, self.every = mesh, step, every
        cell = mesh.basix_cell()
        W = fem.functionspace(
            mesh,
            basix.ufl.mixed_element(
                [
                    basix.ufl.element("Lagrange", cell, 2, shape=(3,)),
                    basix.ufl.element("Lagrange", cell, 1),
                ]
            ),
        )
        V = fem.functionspace(mesh, ("Lagrange", 1))
        self.state, self.gamma, self.potential = fem.Function(W), fem.Function(V), fem.Function(V)
        self.pressure = fem.Constant(mesh, 0.0)
        self.arteries, self.history, self.newton, self.time = 8.8, [], [], 0.0

        # Mechanics.
        u, p = ufl.split(self.state)
        F = ufl.Identity(3) + ufl.grad(u)
        gamma = (1.3 - 0.6 * depth) * self.gamma
        normal = RATIO * gamma
        sheet = 1 / ((1 + gamma) * (1 + normal)) - 1
        Fo = (
            ufl.Identity(3)
            + gamma * ufl.outer(f0, f0)
            + sheet * ufl.outer(s0, s0)
            + normal * ufl.outer(n0, n0)
        )
        Fe = F * ufl.inv(Fo)
        Ce = Fe.T * Fe
        I4f, I4s, I8 = ufl.dot(f0, Ce * f0), ufl.dot(s0, Ce * s0), ufl.dot(f0, Ce * s0)

        def squared(x):  # of what is stretched, with a switch that is smooth over 0.1, as the case has it
            tension = ufl.max_value(x, 0.0)
            return tension**2 * (1 - (1 - ufl.min_value(tension / 0.1, 1.0)) ** 3)

        energy = (
            A / (2 * B) * (ufl.exp(B * (ufl.tr(Ce) - 3)) - 1)
            + A_F / (2 * B_F) * (ufl.exp(B_F * squared(I4f - 1)) - 1)
            + A_S / (2 * B_S) * (ufl.exp(B_S * squared(I4s - 1)) - 1)
            + A_FS / (2 * B_FS) * (ufl.exp(B_FS * I8**2) - 1)
        )
        J, N = ufl.det(F), ufl.FacetNormal(mesh)
        augmented = (A + A_FS) / 2 * (J - 1) ** 2  # zero where J = 1
        # As many points as myostrain takes; UFL's own estimate would take more.
        dx = ufl.dx(metadata={"quadrature_degree": 3, "quadrature_rule": "xiao_gimbutas"})
        ds = ufl.Measure("ds", mesh, subdomain_data=facets, metadata={"quadrature_degree": 4})
        springs = BASE / 2 * ufl.inner(u, u) * ds(names["base"])
        springs += EPICARDIUM / 2 * ufl.dot(u, N) ** 2 * ds(names["epicardium"])
        inside = ds(names["endocardium"])
        height = float(mesh.comm.allreduce(mesh.geometry.x[:, 2].max(), MPI.MAX))
        area = J * ufl.inv(F).T * N
        x = ufl.SpatialCoordinate(mesh) + u
        # The base slides in its plane, so that a cap from a point of it encloses nothing.
        volume = -ufl.dot(x - ufl.as_vector([0.0, 0.0, height]), area) / 3 * inside
        w, _ = ufl.TestFunctions(W)
        residual = ufl.derivative((energy + augmented - p * (J - 1)) * dx + springs, self.state)
        push = ufl.dot(area, w) * inside
        residual += self.pressure * push
        self.residual, self.tangent = (
            fem.form(residual),
            fem.form(ufl.derivative(residual, self.state)),
        )
        self.push, self.volume = fem.form(push), fem.form(volume)
        self.gradient = fem.form(ufl.derivative(volume, self.state))
        parent = W.sub(0).sub(2)
        dofs = fem.locate_dofs_topological(parent, 2, facets.find(names["base"]))
        self.held = [fem.dirichletbc(PETSc.ScalarType(0), dofs, parent)]

        # Potential, and what its nodes see of the stretch.
        a, t = ufl.TrialFunction(V), ufl.TestFunction(V)
        D = ACROSS * ufl.Identity(3) + (ALONG - ACROSS) * ufl.outer(F * f0, F * f0) / ufl.dot(F * f0, F * f0)
        pulled = J * ufl.inv(F) * D * ufl.inv(F).T
        few = ufl.dx(metadata={"quadrature_degree": 2})
        lumped = ufl.dx(metadata={"quadrature_rule": "vertex", "quadrature_degree": 1})
        self.diffusion = fem.form(
            J * a * t * lumped + step * ufl.inner(pulled * ufl.grad(a), ufl.grad(t)) * few
        )
        self.mass = fem.form(J * t * lumped)
        self.weights, self.stretch = (
            fem.form(t * few),
            fem.form(ufl.sqrt(ufl.dot(F * f0, F * f0)) * t * few),
        )
        self.potential.x.array[:] = -84.0
        n = len(self.potential.x.array)
        self.membrane, self.z = Membrane(n), V.tabulate_dof_coordinates()[:, 2]
        self.krylov = PETSc.KSP().create(mesh.comm)
        self.krylov.setType("cg")
        self.krylov.getPC().setType("jacobi")
        self.krylov.setTolerances(rtol=1e-8)
        self.moved()

    def moved(self):
        """Reassemble what depends on the displacement."""
        self.matrix = fp.assemble_matrix(self.diffusion)
        self.matrix.assemble()
        self.krylov.setOperators(self.matrix)
        self.at_nodes = fp.assemble_vector(self.mass).array.copy()
        with (
            fp.assemble_vector(self.stretch).localForm() as seen,
            fp.assemble_vector(self.weights).localForm() as weights,
        ):
            self.seen = seen.array / weights.array

    def fill(self, near):
        """The state in equilibrium with the pressure of the atrium, from one `near` it."""
        for part in range(2):
            self.state.sub(part).interpolate(near.sub(part))
        self.solve(None, P_IN)
        self.moved()
        self.history = [(0.0, self.cavity(), self.pressure.value.item(), self.arteries)]

    def cavity(self):
        """Volume of the cavity."""
        return self.mesh.comm.allreduce(fem.assemble_scalar(self.volume), MPI.SUM)

    def circulation(self, p, dt):
        """Change of volume, arterial pressure, and the former's derivative by p, after an implicit step."""
        flow_in = max(P_IN - p, 0) / R_IN
        if p > self.arteries:  # try the open valve
            arteries = (self.arteries * C + dt * (p / Z + P_V / R)) / (C + dt / Z + dt / R)
        else:
            arteries = (self.arteries * C + dt * P_V / R) / (C + dt / R)
        flow_out = max(p - arteries, 0) / Z
        open_valve = 1 / Z * (1 - dt / Z / (C + dt / Z + dt / R))
        slope = -(1 / R_IN if p < P_IN else 0) - (open_valve if flow_out > 0 else 0)
        return dt * (flow_in - flow_out), arteries, dt * slope

    def solve(self, dt, pressure=None):
        """Equilibrium, with a given pressure or after a step of the circulation of `dt`."""
        before, count = self.history[-1][1] if self.history else 0.0, 0
        for _ in range(50):
            count += 1
            if pressure is not None:
                self.pressure.value, left, by_p = pressure, 0.0, 1.0
            else:
                change, _, slope = self.circulation(self.pressure.value.item(), dt)
                left, by_p = self.cavity() - before - change, -slope
            b = fp.assemble_vector(self.residual)
            fp.set_bc(b, self.held, alpha=0.0)
            K = fp.assemble_matrix(self.tangent, bcs=self.held)
            K.assemble()
            solver = PETSc.KSP().create(self.mesh.comm)
            solver.setOperators(K)
            solver.setType("preonly")
            solver.getPC().setType("lu")
            solver.getPC().setFactorSolverType("mumps")
            first, second = b.duplicate(), b.duplicate()
            solver.solve(b, first)
            moved = 0.0
            if pressure is None:
                column = fp.assemble_vector(self.push)
                fp.set_bc(column, self.held, alpha=0.0)
                solver.solve(column, second)
                gradient = fp.assemble_vector(self.gradient)
                moved = (left - gradient.dot(first)) / (by_p - gradient.dot(second))
                first.axpy(-moved, second)
                self.pressure.value -= moved
            self.state.x.petsc_vec.axpy(-1.0, first)
            size = first.norm()
            solver.destroy()
            K.destroy()
            if size <= 1e-5 * max(1.0, self.state.x.petsc_vec.norm()) and abs(moved) <= 1e-6:
                break
        else:
            raise RuntimeError(f"Newton's method does not converge at t = {self.time}")
        self.newton.append(count)

    def beat(self, end):
        """Go on to the time `end`."""
        for number in range(round(self.time / self.step), round(end / self.step)):
            t = self.time = (number + 1) * self.step
            v = self.potential.x.array
            rate = self.membrane.step(v, self.step)
            for low, high, start in STIMULI:
                if start <= t - self.step / 2 < start + 2.0:
                    rate = rate + 40.0 * ((self.z >= low) & (self.z <= high))
            b = self.potential.x.petsc_vec.duplicate()
            b.array[:] = self.at_nodes * (v + self.step * rate)
            self.krylov.solve(b, self.potential.x.petsc_vec)
            b.destroy()
            calcium, now = self.membrane.s, self.gamma.x.array
            force = ALPHA * np.maximum(calcium - C0, 0) ** 2 * force_length(self.seen)
            speed = (force + 2 * self.seen**2 * ((1 + now) ** -3 - 1)) / (MU * calcium**2)
            self.gamma.x.array[:] = now + self.step * speed
            if (number + 1) % self.every == 0:
                began = time.perf_counter()
                self.solve(self.every * self.step)
                self.arteries = self.circulation(self.pressure.value.item(), self.every * self.step)[1]
                self.moved()
                self.history.append((t, self.cavity(), self.pressure.value.item(), self.arteries))
                self.seconds = getattr(self, "seconds", 0.0) + time.perf_counter() - began
