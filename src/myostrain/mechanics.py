"""Quasi-static equilibrium of the active body: (1.6) with F = Fe Fo, by its stored energy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from myostrain.activation import ActivationLaw, ActiveDeformation, ActiveStress
from myostrain.active_body import ActiveBody
from myostrain.engine import MPI, compile_form, fem, jit_options
from myostrain.errors import ComputationError, InputError
from myostrain.fit import check_fit, check_room
from myostrain.geometry import Body
from myostrain.history import History, backward_difference
from myostrain.kinematics import Deformation, Kinematics
from myostrain.materials import Material
from myostrain.newton import ChordNewton
from myostrain.solvers import Options, assemble_nodal, largest, owned_dofs
from myostrain.state import FieldState, State
from myostrain.supports import fixed_conditions, rigid_body_pins
from myostrain.timing import timed
from myostrain.validation import Positive, description

import basix
import basix.ufl
import numpy as np
import numpy.typing as npt
import ufl
from pydantic import Field

#: Degree of the quadrature by that of the displacement, as low as keeps the order of the elements: one point
#: for P1 (the gradient is constant, γ is taken at the centre), degree 3 for P2.
QUADRATURE_DEGREE = {1: 1, 2: 3}


@description
class ImposedStretch:
    """A homogeneous stretch that holds the body for an initial time, the experiment of figure 2.

    Args:
        value: The stretch, one number or one for each direction; 1 holds the reference configuration.
        until: The simulated time at which the body is let go; ``inf`` holds it for ever (a rigid body).
    """

    value: Positive | tuple[Positive, ...] = 1.0
    until: Annotated[float, Field(strict=True)] = float("inf")

    def __post_init__(self) -> None:
        """Refuse an ``until`` that is no time."""
        if not self.until > 0:
            raise ValueError(
                f"until = {self.until} is no time after the start; give a positive number or inf"
            )


class Mechanics:
    """The deforming body: finds the displacement for a given potential.

    The energy of the body is ∫ Jo W(F Fo⁻¹) dX + k/2 ∫ |u|² dS, under J = 1 or det Fe = 1 as ``kinematics``
    says; stress (3.3) and tangent follow by differentiation. A free body (no support, nothing fixed) is held
    at as many points as it has rigid motions; the reactions there are zero.

    Args:
        body: The reference body.
        kinematics: What the mesh's dimension means in three dimensions.
        material: Passive material W(Fe).
        law: Activation law γ(v).
        deformation: Active deformation Fo(γ).
        active_stress: A tension along the fibre beside the active strain (β = 0 for alone); None for none.
        robin: Stiffness k of the elastic support P N = −k u (7.8), zero or more.
        robin_boundary: Named parts of the boundary that it acts on; all of it unless given.
        fixed: Named parts of the boundary where u = 0.
        body_force: Dead load per reference volume, a UFL vector of the mesh's dimension; None for none.
        relaxation_time: λ of the Kelvin–Voigt body, (4.14) on a line; zero for an elastic one.
        imposed_stretch: A stretch that holds the body for an initial time.
        options: PETSc options of the linear solver.
        tolerance: Largest error of the displacement from iterating, relative to the body's extent.
        quadrature_degree: Degree of the quadrature; chosen by the elements unless given.

    Raises:
        InputError: The parts do not fit together; the message says which.

    Attributes:
        u: Displacement (with the pressure, where there is one), a DOLFINx function.
        v: Potential that drives the activation, P1; whoever couples writes it.
        deformation: F and J of the configuration handed over to the potential.
        handed: The displacement in ``deformation``; :meth:`hand_over` writes it.
        seconds: Wall-clock seconds spent in solving.
    """

    def __init__(
        self,
        body: Body,
        *,
        kinematics: Kinematics,
        material: Material,
        law: ActivationLaw,
        deformation: ActiveDeformation | None = None,
        active_stress: ActiveStress | None = None,
        robin: float = 0.0,
        robin_boundary: Sequence[str] | None = None,
        fixed: Sequence[str] = (),
        body_force: Any = None,
        relaxation_time: float = 0.0,
        imposed_stretch: ImposedStretch | None = None,
        options: Options | None = None,
        tolerance: float = 1e-10,
        quadrature_degree: int | None = None,
    ) -> None:
        check_fit(body, kinematics, material, robin, relaxation_time, imposed_stretch)
        self.body, self.kinematics, self.law = body, kinematics, law
        self.imposed_stretch = imposed_stretch
        self.relaxation_time = relaxation_time
        self.seconds = 0.0
        mesh = body.mesh
        mixed = kinematics.has_pressure
        self._active = active = ActiveBody(
            body, kinematics, material, law, deformation, relaxation_time, active_stress
        )
        degree = QUADRATURE_DEGREE[kinematics.degree] if quadrature_degree is None else quadrature_degree
        self._dx = ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": degree})

        space = _space(mesh, body.dim, kinematics.degree, mixed)
        self.u, self.handed = fem.Function(space, name="displacement"), fem.Function(space)
        self.v = fem.Function(fem.functionspace(mesh, ("Lagrange", 1)), name="potential")
        self.history, self._past_v = History(self.u, depth=3), History(self.v, depth=2)

        F = active.gradient(self.handed)
        self._handed_v = fem.Function(self.v.function_space)
        Jo = ufl.det(active.active(self._handed_v))
        self.deformation = Deformation(F, kinematics.volume_ratio(F, Jo))

        residual = ufl.derivative(active.energy(self.u, self.v) * self._dx, self.u)
        if robin_boundary is not None and not (len(robin_boundary) and robin > 0):
            body.boundary_facets(robin_boundary, "mechanics.robin_boundary")
            raise InputError(
                f"{list(robin_boundary)} has no effect: name parts and give robin > 0, or leave it out",
                "mechanics.robin_boundary",
            )
        if robin > 0:
            ds = body.boundary_measure(robin_boundary, 2 * kinematics.degree, "mechanics.robin_boundary")
            k, w = fem.Constant(mesh, float(robin)), active.displacement(self.u)
            residual += ufl.derivative(k / 2 * ufl.inner(w, w) * ds, self.u)
        if body_force is not None:
            load = ufl.dot(body_force, active.displacement(self.u))
            residual -= ufl.derivative(
                load * ufl.dx(metadata={"quadrature_degree": 2 * kinematics.degree}), self.u
            )
        self._rates: list[Any] = []
        self._past: list[tuple[fem.Function, fem.Function]] = []
        self._rate: Any = None
        if relaxation_time > 0:
            self._past = [(fem.Function(space), fem.Function(self.v.function_space)) for _ in range(2)]
            self._rates = [fem.Constant(mesh, 0.0) for _ in range(3)]
            self._rate = active.strain_rate(self._rates, [(self.u, self.v), *self._past])
            residual += active.viscous_power(self._rate, self.u, self.v, ufl.TestFunction(space)) * self._dx
        conditions = fixed_conditions(body, space, fixed, mixed)
        if mixed and not robin > 0:
            check_room(body, fixed)
        if not fixed and not robin > 0:
            if body_force is not None:
                raise InputError(
                    "a loaded body must be held: fix a part of it, or give robin > 0", "mechanics.fixed"
                )
            conditions += rigid_body_pins(body, space, mixed)
        low, high = body.extent()
        self.size = float(np.linalg.norm(high - low))
        self._measured = None
        if mixed:
            dofs = np.asarray(space.sub(0).collapse()[1], dtype=np.int32)
            self._measured = dofs[dofs < owned_dofs(space)]
        self._work = np.zeros_like(self.u.x.array)
        self.solver = ChordNewton(
            residual,
            self.u,
            conditions,
            measured=self._measured,
            tolerance=tolerance * self.size,
            options=options,
            saddle_point=mixed,
            depends_on=[self.v, *(f for pair in self._past for f in pair), *self._rates],
        )
        points = basix.make_quadrature(getattr(basix.CellType, mesh.topology.cell_type.name), 2)[0]
        orientation = ufl.as_vector([ufl.det(active.gradient(self.u)), ufl.det(active.active(self.v))])
        self._orientation = fem.Expression(orientation, points, jit_options=jit_options())
        self._cells = np.arange(mesh.topology.index_map(mesh.topology.dim).size_local, dtype=np.int32)
        self._nodal_u: fem.Function | None = None
        test = ufl.TestFunction(self.v.function_space)
        self._nodal_weight = assemble_nodal(compile_form(test * self._dx))
        if mixed:
            stress = active.cauchy_without_pressure(self.u, self.v)
            mean = sum(stress[i, i] for i in range(body.dim)) / body.dim
            self._mean_stress = compile_form(mean * test * self._dx)
        self._stress_trace = compile_form(ufl.tr(self.cauchy()) * test * self._dx)

    def cauchy(self) -> Any:
        """Cauchy stress σ = J⁻¹ P Fᵀ in three dimensions (1 × 1 on a line), viscous part included, UFL."""
        return self._active.cauchy(self.u, self.v, self._rate)

    def stress_trace(self) -> npt.NDArray[np.float64]:
        """Trace of the Cauchy stress at the nodes of ``v`` (mean over the cells around each, lumped)."""
        return assemble_nodal(self._stress_trace) / self._nodal_weight

    # Solving.

    def held(self, time: float) -> bool:
        """Whether the imposed stretch holds the body at ``time``."""
        if self.imposed_stretch is None:
            return False
        return np.isinf(self.imposed_stretch.until) or time < self.imposed_stretch.until * (1 - 1e-9)

    @timed
    def start(self, time: float = 0.0) -> None:
        """Find the initial configuration for the potential in ``v``.

        An elastic body begins in equilibrium with it (contracted where it is activated), a viscous one
        relaxed (u = 0), a held one in its imposed stretch.
        """
        self.history.clear()
        self._past_v.clear()
        self.u.x.array[:] = 0.0
        if self.held(time):
            self._impose()
        elif self.relaxation_time > 0:
            self._set_pressure()
        else:
            self._equilibrate()
        self.accept(time)
        self.hand_over(time)

    @timed
    def solve(self, time: float, *, predict: bool = True, order: int = 1, held: bool | None = None) -> None:
        """Find the configuration at ``time`` for the potential in ``v``.

        Args:
            time: Simulated time.
            predict: Whether to begin with the extrapolation of the accepted configurations.
            order: Order of the viscous rate in time, 1 or 2.
            held: Whether the imposed stretch holds the body; that of ``time`` unless given.

        Raises:
            ComputationError: No equilibrium was found, or the body is inverted somewhere.
        """
        if self.held(time) if held is None else held:
            self._impose()
            return
        if predict and self.history.times:
            self.history.extrapolate(time, 2, self.u.x.array)
        if self._past:
            self._set_rates(time, order)
        self._equilibrate()

    def _equilibrate(self) -> None:
        """Solve; where one jump is too far, go from the last potential to the present one in pieces."""
        begin = self.history.values[0] if self.history.values else np.zeros_like(self.u.x.array)
        before = self._past_v.values[0] if self._past_v.values else np.zeros_like(self.v.x.array)
        target = self.v.x.array.copy()
        for pieces in (1, 4, 16):
            try:
                for piece in range(1, pieces + 1):
                    self.v.x.array[:] = before + (target - before) * (piece / pieces)
                    self.solver.solve()
                break
            except ComputationError:
                self.v.x.array[:] = target
                self.u.x.array[:] = begin
                self.solver.forget()
                if pieces == 16:
                    raise
        self._check_orientation()

    def _check_orientation(self) -> None:
        """Refuse a body that is inverted, or an active deformation that is (γ ≤ −1).

        Raises:
            ComputationError: It is, with the place.
        """
        values = self._orientation.eval(self.body.mesh, self._cells)
        worst = float(values.min(initial=np.inf))
        # NaN must not pass, hence "not >".
        if self.body.comm.allreduce(not worst > 0, op=MPI.LOR):
            where = ""
            if not worst > 0:
                cell = int(np.argmin(values.reshape(len(self._cells), -1).min(axis=1)))
                corners = self.body.mesh.geometry.x[self.body.mesh.geometry.dofmaps[0][cell]]
                where = f" near {np.round(corners.mean(axis=0)[: self.body.dim], 4).tolist()}"
            raise ComputationError(
                f"the body is inverted{where}: det F or det Fo is {worst:.3g}",
                advice="a smaller time step, or a smaller activation or load.",
            )

    def _set_rates(self, time: float, order: int) -> None:
        points = min(order, len(self.history.times))
        weights = backward_difference([time, *self.history.times[:points]])
        for constant, weight in zip(self._rates, [*weights, 0.0], strict=False):
            constant.value = weight
        for (u, v), u_past, v_past in zip(self._past, self.history.values, self._past_v.values, strict=False):
            u.x.array[:], v.x.array[:] = u_past, v_past

    def _impose(self) -> None:
        assert self.imposed_stretch is not None
        stretch = np.broadcast_to(np.asarray(self.imposed_stretch.value, dtype=float), (self.body.dim,))
        low, _ = self.body.extent()

        def homogeneous(x: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
            return (stretch[:, None] - 1) * (x[: self.body.dim] - low[:, None])

        (self.u.sub(0) if self.kinematics.has_pressure else self.u).interpolate(homogeneous)
        self._set_pressure()

    def _set_pressure(self) -> None:
        """At rest nothing determines the pressure: take the one without mean stress in the body."""
        for constant in self._rates:
            constant.value = 0.0
        if self.kinematics.has_pressure:
            pressure = fem.Function(self.v.function_space)
            pressure.x.array[:] = assemble_nodal(self._mean_stress) / self._nodal_weight
            self.u.sub(1).interpolate(pressure)

    def state(self) -> State:
        """The configuration, its history, the one handed over, and the kept tangent."""
        return {
            "fields": [FieldState.of(function) for function in self._stateful()],
            "history": self.history.state(),
            "past_v": self._past_v.state(),
            "solver": self.solver.state(),
            "rates": [float(constant.value) for constant in self._rates],
            "seconds": self.seconds,
        }

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self.solver.restore(state["solver"])
        for function, field in zip(self._stateful(), state["fields"], strict=True):
            field.put(function)
        for constant, value in zip(self._rates, state["rates"], strict=True):
            constant.value = value
        self.history.restore(state["history"])
        self._past_v.restore(state["past_v"])
        self.seconds = state["seconds"]

    def _stateful(self) -> list[fem.Function]:
        past = [function for pair in self._past for function in pair]
        return [self.u, self.v, self.handed, self._handed_v, *past]

    def accept(self, time: float) -> None:
        """Take the present configuration as the one at ``time``."""
        self.history.push(time)
        self._past_v.push(time)

    def release(self) -> None:
        """Forget the past configurations: the body was just let go, and they say nothing of what comes."""
        self.history.clear()
        self._past_v.clear()
        self.solver.forget()

    def hand_over(self, time: float, order: int = 0) -> None:
        """Write the configuration at ``time`` into ``handed``, extrapolated from the accepted ones.

        Args:
            time: Simulated time.
            order: Order of the polynomial; 0 hands over the last accepted configuration.
        """
        self.history.extrapolate(time, order, self.handed.x.array)
        self._past_v.extrapolate(time, order, self._handed_v.x.array)

    def lag(self, time: float, order: int) -> float:
        """Largest difference between the displacement found for ``time`` and the one handed over for it.

        The error that the potential sees because the body is extrapolated, in units of length; call it
        between :meth:`solve` and :meth:`accept`.

        Args:
            time: Simulated time of the present configuration.
            order: Order of the extrapolation, as in :meth:`hand_over`.
        """
        self.history.extrapolate(time, order, self._work)
        difference = self.u.x.array - self._work
        dofs = slice(0, owned_dofs(self.u.function_space)) if self._measured is None else self._measured
        return largest(difference[dofs], self.body.comm)

    def hand_over_present(self) -> None:
        """Write the present configuration, accepted or not, into ``handed``."""
        self.handed.x.array[:] = self.u.x.array
        self._handed_v.x.array[:] = self.v.x.array

    def displacement(self) -> fem.Function:
        """The displacement at the mesh's nodes, a P1 vector function."""
        if self.kinematics.degree == 1:
            return self.u
        if self._nodal_u is None:
            space = fem.functionspace(self.body.mesh, ("Lagrange", 1, (self.body.dim,)))
            self._nodal_u = fem.Function(space, name="displacement")
        self._nodal_u.interpolate(self.u.sub(0) if self.kinematics.has_pressure else self.u)
        return self._nodal_u


def _space(mesh: Any, dim: int, degree: int, mixed: bool) -> fem.FunctionSpace:
    cell = mesh.basix_cell()
    displacement = basix.ufl.element("Lagrange", cell, degree, shape=(dim,))
    if not mixed:
        return fem.functionspace(mesh, displacement)
    return fem.functionspace(
        mesh, basix.ufl.mixed_element([displacement, basix.ufl.element("Lagrange", cell, 1)])
    )
