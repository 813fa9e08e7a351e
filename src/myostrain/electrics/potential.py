"""The potential on a deforming body: the balance (2.8) with a membrane model at every node."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, get_args

from myostrain.electrics.diffusion import Diffusion, Mass
from myostrain.electrics.front import Current, Front
from myostrain.electrics.initial_values import InitialValues
from myostrain.electrics.kept import KeptPreconditioner
from myostrain.electrics.past import Past, check_amounts, fields, values_of
from myostrain.electrics.stimulus import Applied, AppliedRates, Source
from myostrain.electrics.stretch_current import StretchCurrent, StretchCurrents
from myostrain.electrics.variation import LocalMembranes, Variation
from myostrain.engine import fem, lasting
from myostrain.errors import ComputationError, InputError
from myostrain.geometry import Body
from myostrain.kinematics import Deformation
from myostrain.membranes import Integrator, Membrane, Step, check_membrane
from myostrain.membranes.reaction import Reaction
from myostrain.solvers.linear import LinearSolver, Options, global_dofs, largest, owned_dofs, solver_options
from myostrain.solvers.timing import timed
from myostrain.state import State
from myostrain.validation import check_listed, refuse_former, remembers

import numpy as np
import numpy.typing as npt
import ufl

Balance = Literal["conservative", "advective"]
"""What is balanced: v per spatial volume, ∂(Jv)/∂t (2.5), or J ∂v/∂t."""

Array = npt.NDArray[np.float64]


#: Keywords of earlier versions, and what became of them.
FORMER = {
    "cell": "it is called membrane",
    "stimulus": "a function of points and time is called source; pulses are stimuli=[Stimulus(...)]",
}


class Potential:
    """The potential v and the membrane's states on a deforming body.

    Continuous linear elements: v and the states live at the nodes, and so does the reaction; diffusion is
    J F⁻¹ D F⁻ᵀ of the deformation that ``deformation`` describes when :meth:`update_deformation` is called.
    Between calls the matrix is kept.

    With the lumped mass a front is too slow, with the consistent one too fast, both by O(h²) with nearly the
    same constant; their mean, applied to the time derivative and the reaction alike, cancels it (on a rigid
    uniform line it is Numerov's scheme, of fourth order). In a plane or a solid it does so along the edges
    of boxes, not between them; "interpolated" cells have a mass that follows the front
    (:class:`~myostrain.electrics.following.FollowingMass`).

    It begins at the membrane's rest, with ``initial`` written over it. A script may change ``v`` and
    ``states`` before a run; what it leaves alone begins the next run as it began the last one.

    Args:
        body: The reference body.
        membrane: Membrane model.
        diffusivity: D of an isotropic body, or (along, across) the fibre; the anisotropic D turns with the
            deformed fibre F n.
        balance: "conservative" for (2.8), of J (v − rest) and of the states that the membrane calls
            conserved; or "advective" for J ∂v/∂t = ...
        mass: "lumped" (the paper's finite differences on a line), or "averaged" for smaller errors in space.
        reaction: "nodal": the membrane is evaluated at the nodes; "interpolated": also between those over
            which a front passes (:class:`~myostrain.electrics.front.Front`), for one as narrow as a cell.
        deformation: F and J of the body, UFL expressions that somebody else updates; None for a rigid body.
        integrator: How the membrane's states advance; unless given, exponentially for a membrane with gates,
            linearly implicit for one without.
        variations: Places where parameters of the membrane are others; later ones win.
        initial: Initial values in places; later ones win.
        stimuli: Rates that are applied in places over times.
        stretch_currents: Currents that the stretch of the body opens; they add up.
        source: Applied rate of v, a function of points (n, dim) and time that gives (n,); None for none.
        options: PETSc options of the linear solver.

    Raises:
        InputError: A diffusivity that is not positive, an unknown balance, a membrane that is none,
            parameters that it does not have, or a place where no node is.

    Attributes:
        v: The potential, P1.
        rest: The potential at rest, but for variations.
        local_rest: The same with them: nodal values (nodes,) if it is not the same everywhere.
        varying: Nodal values (nodes,) of the parameters that vary over the body, by name.
        state_names: Names of the membrane's states.
        states: The membrane's states at the nodes, (states, nodes).
        seconds: Wall-clock seconds spent in solving.
    """

    @remembers
    def __init__(
        self,
        body: Body,
        *,
        membrane: Membrane | None = None,
        diffusivity: float | tuple[float, float] = 1.0,
        balance: Balance = "conservative",
        mass: Mass = "lumped",
        reaction: Current = "nodal",
        deformation: Deformation | None = None,
        integrator: Integrator | None = None,
        variations: Sequence[Variation] = (),
        initial: Sequence[InitialValues] = (),
        stimuli: Sequence[Applied] = (),
        stretch_currents: Sequence[StretchCurrent] = (),
        source: Source | None = None,
        options: Options | None = None,
        **former: Any,
    ) -> None:
        refuse_former(former, FORMER, Potential)
        if membrane is None:
            raise InputError("give a membrane, such as membrane=ms.membranes.FitzHughNagumo()", "cell.model")
        for value, what, key, allowed in (
            (balance, "balance", "balance", get_args(Balance)),
            (mass, "mass matrix", "mass", get_args(Mass)),
            (reaction, "reaction", "reaction", get_args(Current)),
        ):
            if value not in allowed:
                raise InputError(
                    f"'{value}' is not a {what}; allowed: {', '.join(allowed)}", f"potential.{key}"
                )
        along, across = np.broadcast_to(np.asarray(diffusivity, dtype=float), (2,))
        if not (along > 0 and across > 0):
            raise InputError(
                f"{diffusivity}: give positive numbers, D or [along, across]", "potential.diffusivity"
            )
        check_membrane(membrane)
        check_listed(stimuli, "stimuli", "Stimulus", ("share", "amount"))
        check_listed(initial, "initial", "InitialValues", ("where", "apply"))
        check_listed(variations, "variations", "Variation", ("where", "parameters"))
        check_listed(stretch_currents, "stretch_currents", "StretchCurrent", ("conductance", "fitting"))
        self.body, self.membrane, self.balance = body, membrane, balance
        self.diffusivity = float(along), float(across)
        self.mass = mass
        mesh = body.mesh
        space = fem.functionspace(mesh, ("Lagrange", 1))
        self.v = fem.Function(space, name="potential")
        self.state_names = tuple(getattr(membrane, "states", ()))
        self._states: Array = np.zeros((len(self.state_names), len(self.v.x.array)))
        self.initial, self.stimuli = tuple(initial), tuple(stimuli)
        self._applied = AppliedRates(self.stimuli, source, body, space)
        self.seconds = 0.0
        seen = deformation or Deformation(ufl.Identity(body.dim))
        self._diffusion = Diffusion(body, space, seen, self.diffusivity, mass)
        self._stretch = StretchCurrents(stretch_currents, body, space, deformation, membrane)
        self._b = fem.Function(space)
        self._local = LocalMembranes(body, space, membrane, variations)
        self.varying = self._local.values
        self._reaction = Reaction(membrane, integrator, self.varying, lasting(body.comm))
        self.rest = float(membrane.resting_potential())
        self.local_rest = self._local.rest(len(self.v.x.array))
        conserved = tuple(getattr(membrane, "conserved", ()))
        indices = [self.state_names.index(name) for name in conserved if name in self.state_names]
        self.past = Past(
            self.local_rest,
            # Whether amounts are balanced: elsewhere J = 1, or values themselves are.
            per_volume=balance == "conservative" and not self._diffusion.isochoric,
            conserved=indices,
            multistep=self._reaction.multistep,
        )
        if self.past.per_volume and self.past.conserved:
            check_amounts(membrane, self._reaction.integrator, self.past.multistep, reaction)
        if reaction == "interpolated":
            points = Reaction(membrane, integrator, self.varying, lasting(body.comm))
            span, conductivity = self.range[1] - self.range[0], self._diffusion.conductivity
            self.past.front = Front(space, points, self.local_rest, span, mass, conductivity)
        defaults, keep = solver_options(
            self._diffusion.symmetric, body.comm.size, global_dofs(space), body.dim, options or {}
        )
        self.solver = LinearSolver(self._diffusion.matrix, "potential", defaults, options, keep=keep)
        self._kept = KeptPreconditioner(self._diffusion, self.solver, space)
        self.reset()

    def __repr__(self) -> str:
        """Membrane, conductivity and size."""
        nodes = global_dofs(self.v.function_space)
        return (
            f"Potential({nodes} nodes, membrane={self.membrane!r}, diffusivity={self.diffusivity}, "
            f"balance='{self.balance}', mass='{self.mass}')"
        )

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest potential to expect, as the membrane declares them."""
        low, high = getattr(self.membrane, "range", (0.0, 1.0))
        return float(low), float(high)

    @property
    def scale(self) -> float:
        """By how much the potential exceeds its rest at full excitation, the upper end of the range."""
        return self.range[1] - self.rest

    @property
    def excitation(self) -> Array:
        """The potential as 0 at each node's rest and 1 at the upper end of the range (nodes,)."""
        return np.asarray((self.v.x.array - self.local_rest) / (self.range[1] - self.local_rest))

    @property
    def threshold(self) -> float:
        """The potential above which a node counts as activated."""
        return float(getattr(self.membrane, "threshold", 0.5))

    @property
    def calcium(self) -> str | None:
        """Name of the state that is the calcium, None without."""
        return getattr(self.membrane, "calcium", None)

    @property
    def states(self) -> Array:
        """The membrane's states at the nodes, (states, nodes)."""
        # Who gets them may change them: what the last step left is kept apart.
        self.past.set_apart(self._states)
        return self._states

    @states.setter
    def states(self, values: Array) -> None:
        self._states = values

    def field_values(self) -> dict[str, Array]:
        """Nodal values of the potential and each state by name; views, (nodes,)."""
        return {"potential": self.v.x.array, **dict(zip(self.state_names, self._states, strict=True))}

    def reset(self) -> None:
        """Set v and the states to rest and the initial values, whatever they are."""
        self._local.put_rest(self.v.x.array, self._states)
        for values in self.initial:
            values.apply(self.body, self.v.function_space, self.v.x.array, self._states, self.state_names)
        self.past.reset()

    def begin(self) -> None:
        """Take what the run begins with: what was set since the last one; the rest begins as that one.

        Each of v and the states that is as the last step left it begins as before.
        """
        self.v.x.array[:], self._states = self.past.begin(
            self.v.x.array.copy(), self._states.copy(), self.body.comm
        )

    def start(self, time: float = 0.0) -> None:
        """Begin at the present values, on the present deformation, as if nothing had been solved before."""
        self._kept.forget()
        self.update_deformation()
        self.past.clear()
        self.accept(time, keep=1)

    @property
    def stretch_slope(self) -> Array:
        """g (√C − 1)₊/span of all stretch currents, on the body that is seen now (nodes,), a rate."""
        return self._stretch.slope

    @property
    def isochoric(self) -> bool:
        """Whether J = 1 by construction, so that nothing is balanced but v itself."""
        return self._diffusion.isochoric

    @property
    def weight(self) -> Array:
        """What each node stands for of the reference body (nodes,)."""
        return self._diffusion.weight

    @property
    def ratio(self) -> Array:
        """J at the nodes (nodes,)."""
        return self._diffusion.ratio

    @timed
    def update_deformation(self) -> None:
        """Assemble diffusion, volume ratio and stretch on the present deformation."""
        self._diffusion.update()
        self._stretch.update()
        self._count()

    def _count(self) -> None:
        self.solver.counters.assemblies += self._diffusion.assemblies
        self._diffusion.assemblies = 0

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
        before_v, before = self.past.values[0]
        order = len(weights) - 1
        self._kept.follow(weights[0])
        past = self.past.sums(weights, self.ratio) if self.past.multistep else before
        step = Step(end - self.past.times[0], float(weights[0]), past, before, before_v, order)
        room = self.past.room(self._states)
        self._states, current, slope, bad = self._reaction.solve(guess, self._states, step, room)
        self._reaction.refuse(bad, self._states, self._place, end)
        self._reaction.notice_long_step(slope, step, self._place)
        between = np.zeros((2, 1))  # what the current between the nodes adds to the load and its derivative
        if (front := self.past.front) is not None:
            nodal, varying = self.ratio * np.array([current, slope]), self._reaction.varying
            times = end, self.past.times[0]
            rate = self._diffusion.rate(self._kept.weight, guess)
            between = front.solve(guess, rate, nodal, self.ratio, varying, self.past.values, times, weights)
        current, slope = self._stretch.added(guess, current, slope)
        if (applied := self._applied.rate([end, *self.past.times], weights)) is not None:
            current = current - applied
        load = self._diffusion.load(self.ratio * (current + self.past.rate(weights, self.ratio))) + between[0]
        implicit = self.ratio * self.weight * slope + between[1]
        diagonal = self._diffusion.put(self._kept.weight, implicit)
        self._count()
        self._b.x.array[:] = implicit * guess - load
        self._kept.take(diagonal)
        self.v.x.array[:] = guess
        try:
            self.solver.solve(self._b.x.petsc_vec, self.v.x.petsc_vec)
        except ComputationError:
            self._reaction.refuse_no_numbers(guess, current, self._place, end)
            raise
        self.v.x.scatter_forward()

    def _place(self, node: int) -> Array:
        """Where a node is."""
        return self.v.function_space.tabulate_dof_coordinates()[node, : self.body.dim]

    def accept(self, time: float, keep: int) -> None:
        """Take the present fields as those of a step that ended at ``time`` and keep ``keep`` past ones."""
        self.past.push(time, self.v.x.array.copy(), self._states, self.ratio, keep)

    def state(self) -> State:
        """Fields, history, and what the kept preconditioner was made of."""
        space = self.v.function_space
        return {
            "fields": fields(space, (self.v.x.array.copy(), self._states)),
            **self.past.state(space),
            **self._kept.state(),
            "solver": self.solver.state(),
            "seconds": self.seconds,
        }

    def restore(self, state: State) -> None:
        """Go on from a state, on the deformation that has been restored before."""
        self.solver.restore(state["solver"])
        self._kept.restore(state)
        self.v.x.array[:], self._states = values_of(state["fields"])
        self.past.restore(state)
        self.update_deformation()
        self.seconds = state["seconds"]
        self.solver.restore(state["solver"])

    def forget(self) -> None:
        """Keep only the newest values: the next step starts anew, as after a jump in time."""
        self.past.shorten()

    def extrapolate(self, weights: Array) -> Array:
        """Weighted sum of the potential's present and past values, newest first (nodal, local).

        The states are set to theirs, where the next solve starts from a guess of them.
        """
        total, states = self.past.extrapolate(weights)
        if states is not None:
            self._states = states
        return total

    def conserve(self) -> float:
        """After a sudden change of the body, set v and states so that their amounts are what they were.

        The advective balance keeps the values themselves. Returns the largest change of v.
        """
        if not self.past.per_volume:
            return 0.0
        before = self.v.x.array.copy()
        self.v.x.array[:], self._states = self.past.conserve(self.ratio)
        return largest(self.v.x.array - before, self.body.comm)

    def amount(self) -> float:
        """∫ J (v − rest) dX over the body, what the conservative balance conserves without reaction.

        J is that of the step in which v was found: a scheme may have moved the body since.
        """
        if self.past.per_volume and self.past.amounts:
            amounts = self.weight * self.past.amounts[0][0]
        else:
            amounts = self.weight * self.ratio * (self.v.x.array - self.local_rest)
        return float(self.body.comm.allreduce(float(np.sum(amounts[: owned_dofs(self.v.function_space)]))))
