"""Balance of forces of the active body: (1.6) with F = Fe Fo, by its stored energy; inertia if it has any."""

from __future__ import annotations

from typing import Any

from myostrain.activation import ActiveDeformation, ActiveTension, Fibre, Yield
from myostrain.engine import fem
from myostrain.errors import ComputationError
from myostrain.geometry import Body
from myostrain.history import History
from myostrain.kinematics import Kinematics
from myostrain.materials import Material
from myostrain.mechanics.active_body import ActiveBody
from myostrain.mechanics.balance import balance_of
from myostrain.mechanics.cavities import Cavities, CavityPressures
from myostrain.mechanics.checks import check_cavities, check_fit, check_stretch, free_motions
from myostrain.mechanics.discretization import displacement_dofs, unknown_space, volume_measure
from myostrain.mechanics.external_forces import ExternalForces
from myostrain.mechanics.handed_over import HandedOver
from myostrain.mechanics.imposed_stretch import ImposedStretch
from myostrain.mechanics.inversion import Orientation
from myostrain.mechanics.keywords import FORMER, InNotebook, check_kinds
from myostrain.mechanics.loads import Loads
from myostrain.mechanics.motion import Inertia, motion_of
from myostrain.mechanics.nodal_fields import NodalFields
from myostrain.mechanics.reactions import Reactions
from myostrain.mechanics.strain_rate import StrainRate
from myostrain.mechanics.supports import Supports, holds
from myostrain.solvers.continuation import follow
from myostrain.solvers.linear import Options, global_dofs, largest, owned_dofs
from myostrain.solvers.newton import ChordNewton
from myostrain.solvers.timing import timed
from myostrain.state import FieldState, State
from myostrain.validation import refuse_former, remembers

import numpy as np
import numpy.typing as npt
import ufl


class Mechanics(InNotebook):
    """The deforming body: finds the displacement for a given activation.

    The energy of the body is ∫ Jo W(F Fo⁻¹) dX + k/2 ∫ |u|² dS, under J = 1 or det Fe = 1 as ``kinematics``
    says; stress (3.3) and tangent follow by differentiation. Rigid motions that supports leave free are
    stopped at as many components of nodes, which bear no load: loads that do not balance are refused.

    Args:
        body: The reference body.
        kinematics: What the mesh's dimension means in three dimensions.
        material: Passive material W(Fe).
        active: What the activation does: an active deformation Fo(γ), along the fibre unless given, or an
            :class:`~myostrain.activation.ActiveTension`.
        supports: What holds the body; nothing unless given.
        loads: What pushes and pulls it; nothing unless given.
        cavities: Cavities whose pressures are unknowns, and what they are connected to; none unless given.
        relaxation_time: λ of the Kelvin–Voigt body, (4.14) on a line; zero for an elastic one.
        viscosity: η in place of 2 λ μ, for the stress η Ė; a stress times a time.
        density: Mass per reference volume, for a body with inertia; zero for a quasi-static one.
        spectral_radius: Share of a fast vibration that is left after a step, see
            :class:`~myostrain.mechanics.motion.Inertia`.
        imposed_stretch: A stretch that holds the body for an initial time, from its lowest corner.
        options: PETSc options of the linear solver.
        tolerance: Largest error that iterating leaves in the displacement, relative to the body's extent.
        quadrature_degree: Degree of the quadrature; chosen by the elements unless given.

    Raises:
        InputError: The parts do not fit together; the message says which.

    Attributes:
        dx: Measure of the reference body with the quadrature of the solver. Integrate stress with it: for the
            rational functions of :meth:`cauchy`, ``ufl.dx`` alone asks for points without end.
        u: Displacement (with the pressure, where there is one), a DOLFINx function.
        activation: γ, or the tension, at the nodes, P1; whoever couples writes it.
        deformation: F and J of the configuration handed over to the potential.
        handed: The configuration in ``deformation``; :meth:`hand_over` writes it.
        motion: Velocity and acceleration of a body that has inertia or dampers; None of another one.
        cavities: Pressures and volumes of the cavities.
        reactions: Forces by which supports hold the body.
        nodal: Stress, stretch and displacement at the mesh's nodes.
        seconds: Wall-clock seconds spent in solving.
    """

    @remembers
    def __init__(
        self,
        body: Body,
        *,
        kinematics: Kinematics,
        material: Material,
        active: ActiveDeformation | ActiveTension | None = None,
        supports: Supports | None = None,
        loads: Loads | None = None,
        cavities: Cavities | None = None,
        relaxation_time: float = 0.0,
        viscosity: float = 0.0,
        density: float = 0.0,
        spectral_radius: float = 2 / 3,
        imposed_stretch: ImposedStretch | None = None,
        options: Options | None = None,
        tolerance: float = 1e-10,
        quadrature_degree: int | None = None,
        **former: Any,
    ) -> None:
        refuse_former(former, FORMER, Mechanics)
        supports, loads, active = supports or Supports(), loads or Loads(), active or Fibre()
        check_kinds(locals())
        check_fit(body, kinematics, material, relaxation_time, viscosity)
        self.body, self.kinematics, self.material = body, kinematics, material
        self.supports, self.loads, self.active = supports, loads, active
        self.imposed_stretch, stretch, self.seconds = imposed_stretch, imposed_stretch, 0.0
        viscous, mesh, mixed = relaxation_time > 0 or viscosity > 0, body.mesh, kinematics.has_pressure
        self._active = equations = ActiveBody(body, kinematics, material, active, relaxation_time, viscosity)
        self.dx = volume_measure(mesh, kinematics, quadrature_degree)
        space = unknown_space(mesh, kinematics)
        self.u = fem.Function(space, name="displacement")
        self.activation = fem.Function(fem.functionspace(mesh, ("Lagrange", 1)), name="activation")
        self.history, self._past_activation = History(self.u, depth=5), History(self.activation, depth=2)
        ratio = None if stretch is None else check_stretch(body, kinematics, stretch, supports)
        for_ever = stretch is not None and bool(np.isinf(stretch.until))
        self.handed = HandedOver(equations, self.u, self.activation, ratio, for_ever)
        self.deformation = self.handed.deformation
        self._imposed = 0.0  # one while the configuration is an imposed stretch
        residual = ufl.derivative(equations.energy(self.u, self.activation) * self.dx, self.u)
        held, test = holds(body, space, supports, mixed), ufl.TestFunction(space)
        self.motion = motion_of(self.u, equations.displacement, supports, density, spectral_radius)
        residual += self.motion.inertia(equations.displacement(test)) if self.motion is not None else 0
        check_cavities(cavities, kinematics, loads, imposed_stretch)
        inner = () if cavities is None else cavities.names
        self.external = ExternalForces(
            body, equations, self.u, self.activation, supports, loads, held, viscous, self.motion, inner
        )
        self.cavities = CavityPressures(body, cavities, equations, self.u, self.external)
        residual += self.external.residual
        self._past_loads = np.zeros_like(self.external.at(0.0))
        self._rate = StrainRate(equations, self.u, self.activation) if viscous else None
        if self._rate is not None:
            residual += equations.viscous_power(self._rate.rate, self.u, self.activation, test) * self.dx
        self._rates = [rate for rate in (self._rate, self.motion) if rate is not None]
        past = [needed for rate in self._rates for needed in rate.depends_on]
        motions = free_motions(body, held, self.external, supports, loads, mixed, self.motion, self.cavities)
        pins = [] if isinstance(self.motion, Inertia) else motions.pins(space, mixed)
        self.size, self.pins = motions.size, len(pins)
        self._measured, self._work = displacement_dofs(space) if mixed else None, self.u.x.array.copy()
        self.solver = ChordNewton(
            residual,
            self.u,
            [*(hold.condition for hold in held if hold.course is None), *pins],
            moving=[hold.condition for hold in held if hold.course is not None],
            measured=self._measured,
            tolerance=tolerance * self.size,
            options=options,
            saddle_point=mixed,
            symmetric=self.external.symmetric,
            stabilization=equations.stabilization(self.u, self.activation, self.dx) if mixed else None,
            depends_on=[self.activation, *past, *self.external.constants],
            numbers=self.cavities if inner else None,
            advice="a smaller time step, activation or load; more supports, where a slender body is free; "
            "volumes and pressures of cavities that the wall bears; a smaller mechanics.tolerance.",
        )
        self._balance = balance_of(self.u, self.external, motions, mixed) if pins else None
        w = equations.displacement(self.u)
        self.reactions = Reactions(body, self.u, w, held, self.external, self.solver)
        self._orientation = Orientation(body, equations, self.u, self.activation)
        rate = self._rate and self._rate.rate
        self.nodal = NodalFields(equations, self.u, self.activation, rate, body.f0, self.dx)

    def __repr__(self) -> str:
        """What is solved, and how it is held."""
        names = [type(self.kinematics).__name__, type(self.material).__name__, self._active.name]
        size = global_dofs(self.u.function_space)
        held = f"{self.pins} rigid motions free" if self.pins else "held"
        return f"Mechanics({', '.join(names)}; {self.body.cells} cells, {size} unknowns, {held})"

    def cauchy(self) -> Any:
        """Cauchy stress J⁻¹ P Fᵀ in 3D (1 × 1 on a line), viscous part too, UFL; integrate it with ``dx``."""
        return self.nodal.cauchy

    def stress(self) -> npt.NDArray[np.float64]:
        """The Cauchy stress at the nodes of ``activation`` (nodes, n, n), n = 3, or 1 on a line, fitted."""
        return self.nodal.stress()

    def stress_trace(self) -> npt.NDArray[np.float64]:
        """Trace of the Cauchy stress at the nodes of ``activation``, fitted in the cells around each."""
        return self.nodal.stress_trace()

    def fibre_stretch(self) -> npt.NDArray[np.float64]:
        """Stretch of the fibre, |F f0|, at the nodes of ``activation``, fitted in the cells around each."""
        return self.nodal.fibre_stretch()

    @property
    def yields(self) -> Yield:
        """What ``activation`` is taken for: "strain" (γ) or "tension"."""
        return self._active.yields

    @property
    def volume_follows(self) -> bool:
        """Whether J follows γ at once, so that the balance of J v may lose its type."""
        # A viscous line lags behind; where det Fe = 1, J is det Fo whatever the viscosity.
        late = self._rate is not None or isinstance(self.motion, Inertia)
        lags = late and self.kinematics.tensor_dim == 1
        return self.kinematics.follows_activation and not lags and not self.held(np.inf)

    @property
    def jumps(self) -> bool:
        """Whether the body follows activation and loads at once: an elastic one without motion to keep."""
        return not self._rates

    def held(self, time: float) -> bool:
        """Whether the imposed stretch holds the body at ``time``."""
        return self.imposed_stretch is not None and self.imposed_stretch.holds(time)

    @timed
    def start(self, time: float = 0.0) -> None:
        """Find the initial configuration for the present activation.

        An elastic body, and any whose cavities have a preload, begins in equilibrium with it; another one
        that is viscous, damped or has inertia undeformed and at rest, a held one in its imposed stretch.

        Raises:
            ComputationError: No equilibrium was found; the displacement is what it was.
        """
        self.history.clear()
        self._past_activation.clear()
        self._imposed, self._past_loads = 0.0, np.zeros_like(self._past_loads)
        self.solver.forget()  # a second run has the bits of the first one
        former = self.u.x.array.copy()
        self.u.x.array[:] = 0.0
        self.cavities.begin(time)
        if self.held(time):
            self._impose()
        elif not self.jumps and not self.cavities.loaded:
            self._set_pressure()
        else:
            activation = self.activation.x.array.copy()
            self.activation.x.array[:] = 0.0
            self._set_pressure()  # that of rest: Newton's method goes astray from none, or from another one
            self.activation.x.array[:] = activation
            try:
                self._equilibrate(time)
            except ComputationError:
                self.u.x.array[:] = former
                raise
        self.accept(time)
        self.hand_over(time)

    @timed
    def solve(self, time: float, *, predict: bool = True, order: int = 1, held: bool | None = None) -> None:
        """Find the configuration at ``time`` for the present activation.

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
        if predict:
            self.history.predict(time, self._size, self.u.x.array)
        for rate in self._rates:
            rate.set(time, order, self.history, self._past_activation)
        self.cavities.prepare(time, order)
        self._equilibrate(time)

    def _equilibrate(self, time: float) -> None:
        """Solve for the activation and the loads at ``time``, in smaller jumps where one is too far."""
        begin = self.history.values[0] if self.history.values else self.u.x.array.copy()
        before = next(iter(self._past_activation.values), np.zeros_like(self.activation.x.array))
        target, loads_before, loads = self.activation.x.array.copy(), self._past_loads, self.external.at(time)

        def jump(share: float) -> None:
            self.activation.x.array[:] = before + (target - before) * share if share < 1 else target
            self.external.put(loads_before + (loads - loads_before) * share)
            self.cavities.go(share)
            self.solver.solve()
            self._orientation.check()
            self.cavities.check()

        try:
            jump(1.0)
        except ComputationError:
            self._orientation.check_active()
            self.solver.forget()
            self.u.x.array[:] = begin
            self.cavities.go_back()
            try:
                follow(jump, self.u.x.array)
            except ComputationError as error:
                told = error.adding(self.cavities.said())
                self.activation.x.array[:] = target
                self.external.put(loads_before)
                self.cavities.go_back()
                raise told from error
        self._imposed = 0.0
        if self._balance is not None:
            self._balance.check()

    def _impose(self) -> None:
        assert self.imposed_stretch is not None
        displacement = self.imposed_stretch.displacement(self.body)
        (self.u.sub(0) if self.kinematics.has_pressure else self.u).interpolate(displacement)
        self._imposed = 1.0
        self._set_pressure()

    def _set_pressure(self) -> None:
        """At rest nothing determines the pressure: take the one without mean stress in the body."""
        for rate in self._rates:
            rate.clear()
        if self.kinematics.has_pressure:
            self.u.sub(1).interpolate(self.nodal.mean_stress_without_pressure())

    def state(self) -> State:
        """The configuration, its history, the one handed over, and the kept tangent."""
        return {
            "fields": [FieldState.of(function) for function in self._stateful()],
            "history": self.history.state(),
            "past_activation": self._past_activation.state(),
            "solver": self.solver.state(),
            "loads": self.external.named(self._past_loads),
            "cavities": self.cavities.state(),
            "imposed": [self._imposed, float(self.handed.imposed.value)],
            "rates": [rate.state() for rate in self._rates],
            "seconds": self.seconds,
        }

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self.solver.restore(state["solver"])
        for function, field in zip(self._stateful(), state["fields"], strict=True):
            field.put(function)
        for rate, saved in zip(self._rates, state["rates"], strict=True):
            rate.restore(saved)
        self._imposed, self.handed.imposed.value = state["imposed"]
        self._past_loads = self.external.ordered(state["loads"])
        self.external.put(self._past_loads)
        self.cavities.restore(state["cavities"])
        self.history.restore(state["history"])
        self._past_activation.restore(state["past_activation"])
        self.seconds = state["seconds"]

    def _stateful(self) -> list[fem.Function]:
        return [self.u, self.activation, self.handed.u, self.handed.a]

    def accept(self, time: float) -> None:
        """Take the present configuration as the one at ``time``."""
        self._past_loads = self.external.at(time)
        if self.motion is not None:
            self.motion.accept()
        self.cavities.accept(time)
        self.history.push(time)
        self._past_activation.push(time)

    def release(self) -> None:
        """Forget the past configurations: the body was just let go, and they say nothing of what comes."""
        self.history.clear()
        self._past_activation.clear()
        self.solver.forget()
        for rate in self._rates:
            rate.clear()

    @timed
    def hand_over(self, time: float, order: int = 0) -> None:
        """Write the configuration at ``time`` into ``handed``, extrapolated from the accepted ones.

        Args:
            time: Simulated time.
            order: Order of the polynomial; 0 hands over the last accepted configuration.
        """
        self.handed.extrapolate(self.history, self._past_activation, time, order, self._imposed)

    def lag(self, time: float, order: int) -> float:
        """Largest difference between the displacement found for ``time`` and the one handed over for it.

        The error that the potential sees because the body is extrapolated, in units of length; call it
        between :meth:`solve` and :meth:`accept`.

        Args:
            time: Simulated time of the present configuration.
            order: Order of the extrapolation, as in :meth:`hand_over`.
        """
        self.history.extrapolate(time, order, self._work)
        return self._size(self.u.x.array - self._work)

    def _size(self, values: npt.NDArray[np.float64]) -> float:
        dofs = slice(0, owned_dofs(self.u.function_space)) if self._measured is None else self._measured
        return largest(values[dofs], self.body.comm)

    def hand_over_present(self) -> None:
        """Write the present configuration, accepted or not, into ``handed``."""
        self.handed.take(self.u, self.activation, self._imposed)

    def displacement(self, values: npt.NDArray[np.float64] | None = None) -> fem.Function:
        """The displacement at the mesh's nodes, a P1 vector function; of other values of ``u``, if given."""
        return self.nodal.displacement(values)
