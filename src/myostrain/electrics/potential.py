"""The potential on a deforming body: the balance (2.8) with a membrane model at every node."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

from myostrain.engine import PETSc, compile_form, fem
from myostrain.errors import InputError
from myostrain.geometry import Body
from myostrain.kinematics import Deformation
from myostrain.membranes import CellModel
from myostrain.solvers.linear import (
    LinearSolver,
    Options,
    assemble_nodal,
    global_dofs,
    incomplete_factorization,
    largest,
    owned_dofs,
)
from myostrain.solvers.timing import timed
from myostrain.state import FieldState, State

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx.fem import petsc as fem_petsc
from ufl.algorithms import extract_coefficients

Balance = Literal["conservative", "advective"]
"""What is balanced: v per spatial volume, ∂(Jv)/∂t (2.5), or J ∂v/∂t."""

Mass = Literal["lumped", "averaged"]
"""Mass matrix: lumped at the nodes, or the mean of the lumped and the consistent one."""

Array = npt.NDArray[np.float64]

Stimulus = Callable[[Array, float], Array]
"""Applied rate of v at points (n, dim) and a time."""

#: Increment of the complex step: its square vanishes beside one, so that derivatives are exact to round-off.
COMPLEX_STEP = 1e-100


class Potential:
    """The potential v and the membrane's states on a deforming body.

    Continuous linear elements: v and the states live at the nodes, and so does the reaction; diffusion is
    J F⁻¹ D F⁻ᵀ of the deformation that ``deformation`` describes when :meth:`update_deformation` is called.
    Between calls the matrix is kept.

    With the lumped mass a front is too slow, with the consistent one too fast, both by O(h²) with nearly the
    same constant; their mean, applied to the time derivative and the reaction alike, cancels it (on a rigid
    uniform line it is Numerov's scheme, of fourth order).

    Args:
        body: The reference body.
        cell: Membrane model.
        diffusivity: D of an isotropic body, or (along, across) the fibre; the anisotropic D turns with the
            deformed fibre F n.
        balance: "conservative" for (2.8), or "advective" for J ∂v/∂t = ...
        mass: "lumped" (the paper's finite differences on a line), or "averaged" for smaller errors in space.
        deformation: F and J of the body, UFL expressions that somebody else updates; None for a rigid body.
        stimulus: Applied rate of v, a function of points (n, dim) and time that gives (n,); None for none.
        options: PETSc options of the linear solver.

    Raises:
        InputError: A diffusivity that is not positive, or an unknown balance.

    Attributes:
        v: The potential, P1.
        states: The membrane's states by name, P1.
        isochoric: Whether J = 1 by construction, so that nothing is balanced but v itself.
        seconds: Wall-clock seconds spent in solving.
    """

    def __init__(
        self,
        body: Body,
        *,
        cell: CellModel,
        diffusivity: float | tuple[float, float] = 1.0,
        balance: Balance = "conservative",
        mass: Mass = "lumped",
        deformation: Deformation | None = None,
        stimulus: Stimulus | None = None,
        options: Options | None = None,
    ) -> None:
        if balance not in ("conservative", "advective"):
            raise InputError(
                f"'{balance}' is no balance; allowed: conservative, advective", "potential.balance"
            )
        if mass not in ("lumped", "averaged"):
            raise InputError(f"'{mass}' is no mass matrix; allowed: lumped, averaged", "potential.mass")
        along, across = np.broadcast_to(np.asarray(diffusivity, dtype=float), (2,))
        if not (along > 0 and across > 0):
            raise InputError(
                f"{diffusivity}: give positive numbers, D or [along, across]", "potential.diffusivity"
            )
        self.body, self.cell, self.balance = body, cell, balance
        self._stimulus = stimulus
        mesh = body.mesh
        space = fem.functionspace(mesh, ("Lagrange", 1))
        self.v = fem.Function(space, name="potential")
        self.states = {name: fem.Function(space, name=name) for name in cell.states}
        self._owned = owned_dofs(space)
        self._points = space.tabulate_dof_coordinates()[:, : body.dim]
        self.seconds = 0.0

        deformation = deformation or Deformation(ufl.Identity(body.dim))
        self.isochoric = deformation.isochoric
        trial, test = ufl.TrialFunction(space), ufl.TestFunction(space)
        # The order of linear elements needs F at the centre only; vertices lump the mass.
        degree = max(
            ufl.algorithms.estimate_total_polynomial_degree(deformation.F), 0 if self.isochoric else 1
        )
        dx = ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": degree})
        lumped = ufl.Measure(
            "dx", domain=mesh, metadata={"quadrature_rule": "vertex", "quadrature_degree": 1}
        )
        conductivity = pulled_back_conductivity(deformation, body.f0, float(along), float(across), mesh)
        self._stiffness = compile_form(ufl.inner(conductivity * ufl.grad(trial), ufl.grad(test)) * dx)
        self._matrix = fem_petsc.create_matrix(self._stiffness)
        self._mass = _averaged_mass(trial, test, mesh, lumped) if mass == "averaged" else None
        # That of the deformed body, made once: on several processes PETSc frees nothing that Python drops.
        self._scaled_mass = None if self._mass is None or self.isochoric else self._mass.copy()
        self._added = 0.0  # the multiple of the mass matrix in the matrix
        self._volume = None if self.isochoric else compile_form(deformation.J * test * lumped)
        self.weight: Array = assemble_nodal(compile_form(test * lumped))
        self.ratio: Array = np.ones_like(self.weight)
        self._b, self._work = fem.Function(space), fem.Function(space)
        self._diagonal = self._matrix.createVecLeft()
        self._kept_diagonal: Array = np.zeros(self._owned)
        # The averaged mass on a body whose volume changes is not symmetric.
        symmetric = self._mass is None or self.isochoric
        chosen = options or {}
        defaults: dict[str, str | int | float | bool | None] = {
            "ksp_type": "cg" if symmetric else "bcgs",
            "ksp_rtol": 1e-10,
            "ksp_initial_guess_nonzero": chosen.get("ksp_type") != "preonly",
        }
        if "pc_type" not in chosen:
            defaults |= incomplete_factorization(symmetric, body.comm.size, global_dofs(space))
        # A user's choice may be a direct solver, which must follow the matrix.
        keep = not {"ksp_type", "pc_type"} & chosen.keys()
        self.solver = LinearSolver(self._matrix, "potential", defaults, options, keep=keep)
        self._weight = 0.0  # the time derivative's factor of which the kept preconditioner was made
        # Functions that the matrix depends on, and their values and diagonal in the kept preconditioner.
        self._body_fields: list[fem.Function] = [
            function
            for expression in (deformation.F, ufl.as_ufl(deformation.J))
            for function in extract_coefficients(expression)
            if isinstance(function, fem.Function)
        ]
        self._origin: State = {}
        # Past amounts, newest first: J v and J s (conservative), or v and s (advective).
        self.past: list[list[Array]] = []
        # The potential and the states themselves, newest first.
        self.values: list[list[Array]] = []

    @property
    def fields(self) -> list[fem.Function]:
        """The potential, then the states."""
        return [self.v, *self.states.values()]

    def start(self) -> None:
        """Begin at the present v with resting states, on the present deformation."""
        for function, value in zip(self.states.values(), self.cell.initial_states(), strict=True):
            function.x.array[:] = value
        self.update_deformation()
        self.past, self.values = [], []
        self.accept(keep=1)

    @timed
    def update_deformation(self) -> None:
        """Assemble diffusion and volume ratio on the present deformation."""
        self._assemble_diffusion()
        if self._volume is not None:
            self.ratio = assemble_nodal(self._volume) / self.weight

    def _assemble_diffusion(self) -> None:
        self._matrix.zeroEntries()
        fem_petsc.assemble_matrix(self._matrix, self._stiffness)
        self._matrix.assemble()
        self.solver.counters.assemblies += 1
        self._added = 0.0
        self._keep_diagonal()

    def _keep_diagonal(self) -> None:
        self._matrix.getDiagonal(self._diagonal)
        self._kept_diagonal[:] = self._diagonal.array_r

    def _add_mass(self, multiple: float) -> None:
        """Make the matrix hold this multiple of the averaged mass, beside the diffusion."""
        if self._mass is None or multiple == self._added:
            return
        if self._added:  # rather than a difference: a resumed run is to have the same bits
            self._assemble_diffusion()
        mass = self._mass
        if self._scaled_mass is not None:
            same: Any = PETSc.Mat.Structure.SAME_NONZERO_PATTERN
            mass = self._mass.copy(self._scaled_mass, same)
            self._diagonal.array[:] = self.ratio[: self._owned]
            mass.diagonalScale(None, self._diagonal)
        self._matrix.setDiagonal(self._restored_diagonal())
        self._matrix.axpy(multiple, mass, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        self._added = multiple
        self._keep_diagonal()

    def _restored_diagonal(self) -> PETSc.Vec:
        self._diagonal.array[:] = self._kept_diagonal
        return self._diagonal

    @timed
    def solve(self, end: float, guess: Array, weights: Array) -> None:
        """Solve one step, linearised about a guess, on the present deformation.

        The states are solved at the guess, each by itself, then v with the current linearised in v.

        Args:
            end: Time at the end of the step.
            guess: Potential (local nodes) to linearise about.
            weights: Backward-difference weights of the new value and the past ones, newest first.

        Raises:
            ComputationError: The linear solver failed.
        """
        history = self._history(weights)
        # Times are sums, so that equal steps give weights that differ in the last bits.
        if abs(weights[0] - self._weight) > 1e-9 * abs(weights[0]):
            self._weight = float(weights[0])
            self.solver.forget()
        states = [function.x.array for function in self.states.values()]
        for index, state in enumerate(states):
            _solve_state(self.cell, guess, states, index, weights[0], history[index + 1], state)
        current, slope = _with_slope(lambda v: self.cell.current(v, states), guess)
        if self._stimulus is not None:
            current = current - self._stimulus(self._points, end)
        implicit = self.ratio * self.weight * slope
        explicit = self.ratio * (current + history[0])
        if self._mass is None:
            diagonal = self.ratio * self.weight * self._weight + implicit
            load = self.weight * explicit
        else:
            diagonal = implicit
            self._add_mass(self._weight)
            load = self._times_mass(explicit)
        self._diagonal.array[:] = self._kept_diagonal + diagonal[: self._owned]
        self._matrix.setDiagonal(self._diagonal)
        self._b.x.array[:] = implicit * guess - load
        if self.solver.renews:
            body = [FieldState.of(function) for function in self._body_fields]
            self._origin = {"body": body, "diagonal": FieldState(self.v.function_space, diagonal)}
        self.v.x.array[:] = guess
        self.solver.solve(self._b.x.petsc_vec, self.v.x.petsc_vec)
        self.v.x.scatter_forward()

    def _times_mass(self, values: Array) -> Array:
        assert self._mass is not None
        self._work.x.array[:] = values
        self._mass.mult(self._work.x.petsc_vec, self._b.x.petsc_vec)
        return self._b.x.array

    def _history(self, weights: Array) -> list[Array]:
        """Weighted sums of past values for v and each state, as they enter the present step."""
        sums = [
            sum(w * value for w, value in zip(weights[1:], values, strict=False))
            for values in zip(*self.past, strict=True)
        ]
        return [total / self.ratio for total in sums] if self.balance == "conservative" else sums

    def accept(self, keep: int) -> None:
        """Take the present fields as those of a finished step and keep ``keep`` past ones."""
        amounts = [
            function.x.array * self.ratio if self.balance == "conservative" else function.x.array.copy()
            for function in self.fields
        ]
        self.past = [amounts, *self.past[: keep - 1]]
        self.values = [[function.x.array.copy() for function in self.fields], *self.values[: keep - 1]]

    def state(self) -> State:
        """Fields, history, and what the kept preconditioner was made of."""
        space = self.v.function_space
        return {
            "fields": [FieldState.of(function) for function in self.fields],
            "past": [[FieldState(space, value) for value in values] for values in self.past],
            "values": [[FieldState(space, value) for value in values] for values in self.values],
            "weight": self._weight,
            "origin": self._origin,
            "solver": self.solver.state(),
            "seconds": self.seconds,
        }

    def restore(self, state: State) -> None:
        """Go on from a state, on the deformation that has been restored before."""
        self.solver.restore(state["solver"])
        self._weight = state["weight"]
        if state["origin"] and state["origin"] is not self._origin:
            self._origin = state["origin"]
            self._precondition()
        for function, field in zip(self.fields, state["fields"], strict=True):
            field.put(function)
        self.past, self.values = (
            [[field.values for field in fields] for fields in state[name]] for name in ("past", "values")
        )
        self.update_deformation()
        self.seconds = state["seconds"]
        self.solver.restore(state["solver"])

    def _precondition(self) -> None:
        """Make the kept preconditioner again."""
        present = [FieldState.of(function) for function in self._body_fields]
        for function, field in zip(self._body_fields, self._origin["body"], strict=True):
            field.put(function)
        self.update_deformation()
        self._add_mass(self._weight)
        self._diagonal.array[:] = self._kept_diagonal + self._origin["diagonal"].values[: self._owned]
        self._matrix.setDiagonal(self._diagonal)
        self.solver.precondition()
        for function, field in zip(self._body_fields, present, strict=True):
            field.put(function)

    def forget(self) -> None:
        """Keep only the newest values: the next step starts anew, as after a jump in time."""
        self.past, self.values = self.past[:1], self.values[:1]

    def extrapolate(self, weights: Array) -> Array:
        """Weighted sum of the potential's present and past values, newest first (nodal, local).

        The states are set to theirs, to be what the next solve starts from.
        """
        guess, *states = [
            np.asarray(sum(w * value for w, value in zip(weights, values, strict=False)))
            for values in zip(*self.values, strict=True)
        ]
        for function, state in zip(self.states.values(), states, strict=True):
            function.x.array[:] = state
        return guess

    def conserve(self) -> float:
        """After a sudden change of the body, set v and states so that J v and J s are what they were.

        The advective balance keeps the values themselves. Returns the largest change of v.
        """
        if self.balance == "advective" or self.isochoric:
            return 0.0
        before = self.v.x.array.copy()
        for function, amount in zip(self.fields, self.past[0], strict=True):
            function.x.array[:] = amount / self.ratio
        self.values[0] = [function.x.array.copy() for function in self.fields]
        return largest(self.v.x.array - before, self.body.comm)

    def amount(self) -> float:
        """∫ J v dX over the body, what the conservative balance conserves without reaction.

        J is that of the step in which v was found: a scheme may have moved the body since.
        """
        if self.balance == "conservative" and self.past:
            amounts = self.weight * self.past[0][0]
        else:
            amounts = self.weight * self.ratio * self.v.x.array
        return float(self.body.comm.allreduce(float(np.sum(amounts[: self._owned]))))


def _averaged_mass(trial: Any, test: Any, mesh: Any, lumped: ufl.Measure) -> PETSc.Mat:
    """The mean of the lumped and the consistent mass matrix."""
    exact = ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": 2})
    matrix = fem_petsc.assemble_matrix(compile_form(trial * test / 2 * lumped + trial * test / 2 * exact))
    matrix.assemble()
    return matrix


def pulled_back_conductivity(
    deformation: Deformation, f0: Any, along: float, across: float, mesh: Any
) -> Any:
    """J F⁻¹ D F⁻ᵀ with D = across · 1 + (along − across) f⊗f and f the unit vector along F f0 (2.8)."""
    F = deformation.F
    C = F.T * F
    across_ = fem.Constant(mesh, across)
    conductivity = across_ * ufl.inv(C)
    if along != across:
        conductivity += (fem.Constant(mesh, along) - across_) / ufl.dot(f0, C * f0) * ufl.outer(f0, f0)
    return deformation.J * conductivity


def _with_slope(function: Any, at: Array) -> tuple[Array, Array]:
    """A pointwise function and its derivative, by one complex step."""
    value = function(at + 1j * COMPLEX_STEP)
    return np.real(value), np.imag(value) / COMPLEX_STEP


def _solve_state(
    cell: CellModel, v: Array, states: list[Array], index: int, weight: float, history: Array, out: Array
) -> None:
    """Solve weight · s + history = rate(v, s) for one state, linearised about its present value."""

    def rate(value: Any) -> Any:
        return cell.rates(v, [value if i == index else s for i, s in enumerate(states)])[index]

    value, slope = _with_slope(rate, out)
    out -= (weight * out + history - value) / (weight - slope)
