"""Electromechanics: what potential, activation and mechanics hand each other.

The order of the sub-steps is in :mod:`myostrain.schemes`; nothing else knows both sides.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from myostrain import membranes
from myostrain.activation import ActivationLaw, NodalActivation, Proportional
from myostrain.activation.feedback import check_well_posed, over_a_step
from myostrain.electrics.potential import Potential
from myostrain.errors import ComputationError, InputError
from myostrain.history import backward_difference, extrapolation_weights
from myostrain.mechanics.equilibrium import Mechanics
from myostrain.mechanics.seen_stretch import SeenStretch
from myostrain.schemes import SETTLED, STRONG, Scheme, SecondOrder
from myostrain.solvers.linear import largest
from myostrain.solvers.timing import charged
from myostrain.state import State
from myostrain.transfer import SameMesh, Transfer
from myostrain.validation import expect, remembers

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Electromechanics:
    """The coupled problem.

    Args:
        potential: The potential on the deforming body, or one that is given
            (:class:`GivenPotential`).
        mechanics: The deforming body; None for a rigid one.
        law: How the activation follows potential, membrane, stretch and time; the paper's γ = −0.3 v unless
            given. It yields γ or a tension, as the mechanics takes it.
        scheme: How to advance; second order, mechanics every step, unless given.
        activity: Factor on γ or the tension, a number or one at each node (nodes,), such as
            :func:`myostrain.geometry.transmural` gives.
        transfer: What the two meshes hand each other, such as :class:`NestedMesh`; they are the same mesh
            unless given.

    Attributes:
        time: Simulated time of the present state.
        transfer: What the two meshes hand each other; a rigid body has none.
        activation: The law's states, and γ or the tension at the nodes; None for a rigid body.
        coupling_iterations: Fixed-point iterations done so far (the implicit scheme).
        switches: Nodes whose side of a switch was held within a step so far, over all steps.
        feedback: By how much J v answers to v through J, at once or within a step: measured on the law.
        displacement_lag: Largest difference so far between the body that the potential was solved on and the
            one that mechanics then found for the same time (the schemes of one pass).
        stretch_lag: The same of the stretch that the law saw; zero for a law that sees none.

    Raises:
        InputError: The law is none, or does not fit the mechanics; it makes Fo singular, or the conservative
            balance ill-posed; mechanics is to be solved every few steps where each must be iterated; or
            potential and mechanics are on two meshes that the transfer is not of.
    """

    @remembers
    def __init__(
        self,
        potential: Potential,
        mechanics: Mechanics | None = None,
        *,
        law: ActivationLaw | None = None,
        scheme: Scheme | None = None,
        activity: float | Array = 1.0,
        transfer: Transfer | None = None,
    ) -> None:
        expect(potential, "begin", "potential", "ms.Potential(body, ...), before the mechanics")
        self.potential, self.mechanics = potential, mechanics
        self.scheme: Scheme = scheme or SecondOrder()
        expect(self.scheme, "advance", "time.scheme", "ms.SecondOrder(every=4)")
        self.activation: NodalActivation | None = None
        self.feedback = 0.0
        self.time, self._end = 0.0, 0.0
        self._measured_step = 0.0  # the longest step for which the feedback is known
        if mechanics is not None:
            expect(mechanics, "yields", "mechanics", "ms.Mechanics(body, ...)")
            self.transfer = transfer or SameMesh(mechanics)
            if potential.v.function_space.mesh is not self.transfer.mesh:
                raise InputError(
                    "potential and mechanics are on different meshes: give both the same body, or "
                    "transfer=NestedMesh(mechanics, fine), fine being the potential's body, "
                    "geometry.refined(mechanics.body, levels)",
                    "potential.refinement",
                )
            chosen: Any = Proportional() if law is None else law
            space = potential.v.function_space
            self._check_calcium(chosen)
            self.activation = NodalActivation(
                chosen, space, self._drivers(), mechanics.yields, activity, self._units()
            )
            self._uses_stretch = "stretch" in chosen.drivers
            self._uses_states = bool({"calcium", *potential.state_names} & {*chosen.drivers})
            self._seen = SeenStretch(space)
            if not getattr(chosen, "states", ()):
                self._take_feedback(check_well_posed(self.activation, potential, mechanics.volume_follows))
        self.steps = 0
        self.coupling_iterations, self.switches = 0, 0
        self.displacement_lag, self.stretch_lag = 0.0, 0.0
        self._times: list[float] = []

    def __repr__(self) -> str:
        """What is coupled, and how."""
        law = None if self.activation is None else self.activation.law
        return (
            f"Electromechanics({self.potential!r}, {self.mechanics!r}, law={law!r}, scheme={self.scheme!r}, "
            f"time={self.time:.6g})"
        )

    @property
    def every(self) -> int:
        """Steps between solves of mechanics; 1 where there is none."""
        return 1 if self.mechanics is None else int(getattr(self.scheme, "every", 1))

    @property
    def in_step(self) -> bool:
        """Whether potential and body are of the same time: mechanics was solved in the last step."""
        return self.steps % self.every == 0

    def start(self) -> None:
        """Begin at time 0 from the initial values, with the configuration that they have."""
        self.time, self.steps, self._times = 0.0, 0, [0.0]
        self._end, self._measured_step = 0.0, 0.0
        self.coupling_iterations, self.switches = 0, 0
        self.displacement_lag, self.stretch_lag = 0.0, 0.0
        self.potential.begin()
        if self.mechanics is not None and self.activation is not None:
            self._seen.clear()
            self.activation.start()
            follows = self.mechanics.volume_follows
            self._take_feedback(check_well_posed(self.activation, self.potential, follows))
            self._give_activation()
            self.mechanics.start(0.0)
            self.transfer.hand_over()
            self._keep_stretch(0.0)
            self.activation.accept()
        self.potential.start(0.0)

    def step(self, end: float, *, mechanics: bool | None = None) -> None:
        """Advance to the time ``end``.

        Args:
            end: Simulated time at the end of the step.
            mechanics: Whether to solve mechanics in it; as the scheme says unless given.

        Raises:
            ComputationError: A solver failed.
        """
        was_held = self.mechanics is not None and self.mechanics.held(self.time)
        if end - self.time > self._measured_step * (1 + 1e-6):
            self._measure_feedback(end - self.time)
        self._end = end
        self.solves_mechanics = (self.steps + 1) % self.every == 0 if mechanics is None else mechanics
        self.scheme.advance(self, self.time, end)
        self.time = end
        self.steps += 1
        self._times = [end, *self._times[: self.scheme.order - 1]]
        if was_held and self.mechanics is not None and not self.mechanics.held(end):
            self._release()

    def displacement(self) -> Array | None:
        """The displacement at the potential's nodes, (local nodes, dim); None for a rigid body."""
        if self.mechanics is None:
            return None
        return self.transfer.displacement().x.array.reshape(-1, self.potential.body.dim)

    def state(self) -> State:
        """What the next step needs, without copies of what no step changes in place."""
        return {
            "time": self.time,
            "steps": self.steps,
            "times": self._times,
            "feedback": self.feedback,
            "measured_step": self._measured_step,
            "coupling_iterations": self.coupling_iterations,
            "switches": self.switches,
            "displacement_lag": self.displacement_lag,
            "stretch_lag": self.stretch_lag,
            "stretch": None if self.mechanics is None else self._seen.state(),
            "activation": None if self.activation is None else self.activation.state(),
            "mechanics": None if self.mechanics is None else self.mechanics.state(),
            "potential": self.potential.state(),
        }

    def restore(self, state: State) -> None:
        """Go on from a state, in place of :meth:`start` or after a failed step."""
        self.time, self.steps, self._times = state["time"], state["steps"], list(state["times"])
        self._end = self.time
        self.feedback, self._measured_step = state["feedback"], state["measured_step"]
        self.coupling_iterations, self.switches = state["coupling_iterations"], state["switches"]
        self.displacement_lag, self.stretch_lag = state["displacement_lag"], state["stretch_lag"]
        if self.mechanics is not None and self.activation is not None:
            self._seen.restore(state["stretch"])
            self.mechanics.restore(state["mechanics"])
            self.activation.restore(state["activation"])
            self.transfer.hand_over()
        self.potential.restore(state["potential"])

    # What schemes are made of.

    def weights(self, end: float, order: int) -> Array:
        """Backward-difference weights of the value at ``end`` and the past ones, newest first."""
        return backward_difference([end, *self._times[:order]])

    def extrapolated_potential(self, end: float, order: int) -> Array:
        """The potential at ``end`` by a polynomial through its last ``order`` values (nodal, local)."""
        return self.potential.extrapolate(extrapolation_weights(self._times[:order], end))

    def advance_activation(self, start: float, end: float, order: int) -> None:
        """The activation at ``end``, for the present potential, membrane and stretch."""
        if self.activation is not None:
            self.activation.advance(end - start, order)

    def solve_mechanics(self, end: float, order: int, handed_over: int) -> None:
        """Solve mechanics for the present activation and accept it.

        Args:
            end: Time of the present activation.
            order: Order of viscous rates in time.
            handed_over: Order of the extrapolation by which the potential saw the body until now.
        """
        assert self.mechanics is not None
        self._give_activation()
        held = self.mechanics.held(self.time)  # a stretch that ends now has held the body until now
        self.mechanics.solve(end, order=order, held=held)
        if not held:
            self.displacement_lag = max(self.displacement_lag, self.mechanics.lag(end, handed_over))
        self.mechanics.accept(end)
        if self._uses_stretch:
            found = self._stretch()
            self.stretch_lag = max(self.stretch_lag, self._seen.lag(end, self.scheme.order, found))
            self._seen.keep(end, found)

    def iterate_mechanics(self, start: float, end: float, order: int, first: bool) -> float:
        """Solve mechanics for an iterate of the activation, and hand it over, without accepting it.

        Returns:
            The largest change of the stretch that the law has seen, and of γ or the tension (of its largest)
            by what else drives it than the potential; zero where nothing does.
        """
        assert self.mechanics is not None
        assert self.activation is not None
        before, moved = self.activation.values, 0.0
        self.advance_activation(start, end, order)
        if self._uses_states:
            values = self.activation.values
            comm = self.potential.body.comm
            moved = np.inf if first else largest(values - before, comm) / max(1.0, largest(values, comm))
        self._give_activation()
        self.mechanics.solve(end, predict=first, order=order, held=self.mechanics.held(start))
        self.mechanics.hand_over_present()
        self.update_deformation()
        if self._uses_stretch:
            order, found = self.scheme.order, self._stretch()
            moved = max(moved, self._seen.settle(end, order, found, first=first, enough=SETTLED))
        return moved

    def hand_over(self, time: float, order: int = 0) -> None:
        """Hand the potential the body at ``time``, extrapolated with an order from the accepted ones."""
        assert self.mechanics is not None
        self.mechanics.hand_over(time, order)
        self.update_deformation()

    def update_deformation(self) -> None:
        """Make the potential see the body that mechanics hands over now."""
        with charged(self.potential):
            self.transfer.hand_over()
            self.potential.update_deformation()

    def accept(self, end: float, order: int) -> None:
        """Take potential and activation as those at ``end``, keeping ``order`` past ones."""
        self.potential.accept(end, keep=order)
        if self.activation is not None:
            self.activation.accept()

    def accept_mechanics(self, end: float) -> None:
        """Take the present body as that at ``end``, after iterations."""
        assert self.mechanics is not None
        self.mechanics.accept(end)

    def _give_activation(self) -> None:
        assert self.mechanics is not None
        assert self.activation is not None
        self.mechanics.activation.x.array[:] = self.transfer.to_mechanics(self.activation.values)

    def _drivers(self) -> dict[str, Callable[[], Any]]:
        """Present values of all that may drive a law, by name."""
        potential = self.potential
        found: dict[str, Callable[[], Any]] = {
            "potential": lambda: potential.v.x.array,
            "excitation": lambda: potential.excitation,
            "stretch": lambda: self._seen.at(self._end, self.scheme.order),
            "time": lambda: self._end,
        }
        for name in potential.state_names:
            # The array of the states is another one after each step.
            found[name] = partial(lambda state: potential.field_values()[state], name)
        if (calcium := potential.calcium) is not None:
            found["calcium"] = found[calcium]
        return found

    def _measure_feedback(self, step: float) -> None:
        """Measure how strongly J answers to v within a step of a law with states."""
        self._measured_step = step
        if self.activation is None or self.mechanics is None or not len(self.activation.states):
            return
        order, follows = self.scheme.order, self.mechanics.volume_follows
        within = over_a_step(self.activation, self.potential, follows, step, order)
        self._take_feedback(max(self.feedback, within))

    def _take_feedback(self, strength: float) -> None:
        self.feedback = strength
        if isinstance(self.scheme, SecondOrder) and self.scheme.every > 1 and strength > STRONG:
            raise InputError(
                f"{self.scheme.every}: J follows the potential so strongly here (−v γ′/(1 + γ) up to "
                f"{strength:.2f}, over {STRONG}) that mechanics is iterated in every step; give 1",
                "mechanics.every",
            )

    def _units(self) -> dict[str, str | None]:
        """Units of what may drive a law, by name."""
        membrane = getattr(self.potential, "membrane", None)
        named = {"calcium": "calcium_unit", "potential": "potential_unit", "time": "time_unit"}
        return {driver: getattr(membrane, unit, None) for driver, unit in named.items()}

    def _check_calcium(self, law: Any) -> None:
        """Say which membranes have the calcium that a law asks for in vain."""
        if "calcium" not in (getattr(law, "drivers", None) or ()) or self.potential.calcium is not None:
            return
        known = [
            n for n in membranes.__all__ if isinstance(getattr(getattr(membranes, n), "calcium", 0), str)
        ]
        membrane = getattr(self.potential, "membrane", None)
        has = "a given potential" if membrane is None else type(membrane).__name__
        raise InputError(
            f"'calcium' drives {type(law).__name__}, and {has} has none; membranes with calcium: "
            f"{', '.join(sorted(known))}",
            "activation.law",
        )

    def _stretch(self) -> Array:
        """The stretch of the present body at the potential's nodes."""
        assert self.mechanics is not None
        return self.transfer.to_potential(self.mechanics.nodal.mean_fibre_stretch())

    def _keep_stretch(self, time: float) -> None:
        """Keep the stretch of the present body, where a law asks for it."""
        if self._uses_stretch:
            self._seen.keep(time, self._stretch())

    def _release(self, tolerance: float = 1e-10, most: int = 200) -> None:
        """The imposed stretch ends now: the body springs to equilibrium, J v and J w are conserved."""
        assert self.mechanics is not None
        assert self.activation is not None
        mechanics, potential = self.mechanics, self.potential
        mechanics.release()
        self._times = self._times[:1]
        self._seen.clear()
        potential.forget()
        if not mechanics.jumps:
            mechanics.accept(self.time)
            self._keep_stretch(self.time)
            return
        for _ in range(most):
            self.activation.update()
            self._give_activation()
            try:
                mechanics.solve(self.time, predict=False)
            except ComputationError as error:
                raise self._no_release() from error
            mechanics.hand_over_present()
            self.update_deformation()
            if potential.conserve() <= tolerance:
                break
        else:
            raise self._no_release()
        mechanics.accept(self.time)
        self._keep_stretch(self.time)
        self.activation.accept()

    def _no_release(self) -> ComputationError:
        return ComputationError(
            "no equilibrium conserves J v when the imposed stretch ends (on a line: for 4 β v x′ > 1)",
            time=self.time,
            advice="a smaller stretch or potential.",
        )
