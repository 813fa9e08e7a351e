"""A law's states and its γ or tension at the nodes, over time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from myostrain.activation.checks import KEY, called, check_law, initial, plain, unit_scales
from myostrain.activation.contracts import ActivationLaw, Array, Drivers, Yield
from myostrain.engine import MPI, fem, lasting
from myostrain.errors import ComputationError, InputError
from myostrain.state import FieldState, State

import numpy as np


class NodalActivation:
    """Owns the states of an :class:`ActivationLaw` at the nodes, and advances them.

    Args:
        law: The law; checked here, so that a script's own fails at once and with a reason.
        space: P1 space on whose nodes it lives.
        drivers: What it may be driven by: functions without arguments that give present values, by name.
        wanted: What the mechanics takes, "strain" or "tension".
        factor: Factor on what the law yields, a number or (nodes,).
        units: Units in which the drivers are given, and "time", by name; a law that declares its own gets
            them in these.

    Raises:
        InputError: Something is missing in the law, or of a wrong kind or shape, or its units are others; the
            message says what.

    Attributes:
        states: Present states, (states, nodes).
        values: Present γ or tension, (nodes,).
    """

    def __init__(
        self,
        law: ActivationLaw,
        space: fem.FunctionSpace,
        drivers: Mapping[str, Callable[[], Any]],
        wanted: Yield = "strain",
        factor: float | Array = 1.0,
        units: Mapping[str, str | None] | None = None,
    ) -> None:
        check_law(law, drivers, wanted)
        self.law, self._space, self._factor = law, space, factor
        self._sources = {name: drivers[name] for name in law.drivers}
        self._scales = unit_scales(law, units or {})
        self._size = len(fem.Function(space).x.array)
        self._own = tuple(getattr(law, "states", ()))
        self.states: Array = np.zeros((len(self._own), self._size))
        self._accepted, self._accepted_drivers = self.states, {}  # type: tuple[Array, dict[str, Any]]
        self.values: Array = np.zeros(self._size)

    def drivers(self) -> dict[str, Any]:
        """Copies of the present values of what drives the law, in its units."""
        scales = self._scales
        return {
            n: np.array(source(), dtype=float) * scales.get(n, 1.0) for n, source in self._sources.items()
        }

    def start(self) -> None:
        """Take the initial states for the present drivers.

        Raises:
            InputError: What the law gives is not what it should be, or not finite.
        """
        drivers = self.drivers()
        if self._own:
            found = initial(self.law, self._own, drivers)
            for state, value in zip(self.states, found, strict=True):
                state[:] = self._array(value, (self._size,), "initial_states", single=True)
        self.values = self._yielded(self.states, drivers)
        if said := self._not_finite():
            raise InputError(said, KEY)
        self._check_memory(drivers)
        self.accept()

    def advance(self, step: float, order: int) -> None:
        """Advance the accepted states by a step that ends at the present drivers, and evaluate.

        Args:
            step: Length of the step.
            order: 1: the drivers are frozen at the end of the step; 2: at its middle.

        Raises:
            ComputationError: What the law gives is not finite.
        """
        after = self.drivers()
        self.states = self._advanced(after, step, order)
        self.values = self._yielded(self.states, after)
        if said := self._not_finite():
            raise ComputationError(said, advice="a smaller time step, or other parameters of the law.")

    def update(self) -> None:
        """Evaluate for the present drivers, without a step of time."""
        self.values = self._yielded(self.states, self.drivers())

    @property
    def answers(self) -> bool:
        """Whether it yields γ and the potential is among what drives it."""
        return self.yields == "strain" and bool({"potential", "excitation"} & set(self.law.drivers))

    def at_potential(self, potential: float, excitation: float, step: float = 0.0, order: int = 1) -> Array:
        """γ (nodes,) if the whole body had this potential, and all else that drives the law as it is.

        Args:
            potential: The potential.
            excitation: The same as excitation.
            step: Length of a step that ends with it; 0: the states are the present ones.
            order: Of that step, as in :meth:`advance`.
        """
        given = {"potential": potential * self._scales.get("potential", 1.0), "excitation": excitation}
        drivers = self.drivers()
        drivers |= {name: np.full(self._size, given[name]) for name in given.keys() & drivers.keys()}
        states = self._advanced(drivers, step, order) if step else self.states
        return self._yielded(states, drivers)

    @property
    def yields(self) -> str:
        """What the law yields, "strain" or "tension"."""
        return str(getattr(self.law, "yields", "strain"))

    def _advanced(self, after: Drivers, step: float, order: int) -> Array:
        """The states (states, nodes) a step after the accepted ones, for the drivers at its end."""
        if not self._own:
            return self.states
        during = after
        if order == 2:
            during = {name: (value + self._accepted_drivers[name]) / 2 for name, value in after.items()}
        length = step * self._scales.get("time", 1.0)
        found = called(self.law, "advance", self._accepted, during, length)
        return self._array(found, self.states.shape, "advance")

    def _yielded(self, states: Array, drivers: Drivers) -> Array:
        """γ or the tension (nodes,)."""
        found = called(self.law, "activation", states, drivers)
        return self._array(found, (self._size,), "activation", single=True) * self._factor

    def _not_finite(self) -> str:
        """Where states or values are not finite numbers, in words; empty if all are (collective)."""
        comm, found = lasting(self._space.mesh.comm), ""
        finite = np.isfinite(self.values) & np.isfinite(self.states).all(axis=0)
        if not finite.all():
            node = int(np.argmin(finite))
            X = self._space.tabulate_dof_coordinates()[node, : self._space.mesh.geometry.dim]
            values = {
                self.yields: self.values[node],
                **dict(zip(self._own, self.states[:, node], strict=True)),
            }
            given = ", ".join(f"{name} = {float(value):g}" for name, value in values.items())
            place = [round(float(x), 6) for x in X]
            found = f"{type(self.law).__name__} gives what is not finite near {place}: {given}"
        return next((said for said in comm.allgather(found) if said), "")

    def _check_memory(self, drivers: Drivers) -> None:
        """Refuse a law that gives something else when it is asked again (collective)."""
        differs = not np.array_equal(self._yielded(self.states, drivers), self.values)
        if lasting(self._space.mesh.comm).allreduce(differs, op=MPI.LOR):
            raise InputError(
                f"{type(self.law).__name__}.activation gives something else when it is called again with the "
                "same values: what it remembers belongs in states, with initial_states and advance",
                KEY,
            )

    def accept(self) -> None:
        """Take the present states as those of a finished step."""
        self._accepted, self._accepted_drivers = self.states.copy(), self.drivers()

    def _array(self, found: Any, shape: tuple[int, ...], method: str, single: bool = False) -> Array:
        """What a method gives, as an array of a shape; a number is taken for all nodes where one may be."""
        who = f"{type(self.law).__name__}.{method}"
        array = plain(found, who)
        if array.shape != shape and not (single and array.shape == ()):
            raise InputError(
                f"{who} gives values of shape {array.shape}; wanted is {shape}, (states, nodes) or (nodes,)",
                KEY,
            )
        return np.broadcast_to(array, shape).copy()

    def state(self) -> State:
        """States, γ or tension, and the drivers that the next step begins with."""

        def kept(array: Array) -> FieldState:
            return FieldState(self._space, array)

        return {
            "states": [kept(s) for s in self._accepted],
            "values": kept(self.values),
            "drivers": {
                name: kept(value) if np.ndim(value) else float(value)
                for name, value in self._accepted_drivers.items()
            },
        }

    def restore(self, state: State) -> None:
        """Go on from a state."""
        if self._own:
            self.states = np.array([field.values for field in state["states"]])
        self._accepted = self.states.copy()
        self.values = state["values"].values.copy()
        self._accepted_drivers = {
            name: value.values if isinstance(value, FieldState) else np.asarray(value)
            for name, value in state["drivers"].items()
        }
