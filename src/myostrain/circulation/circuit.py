"""A 0D model along a run: its past, and what it asks of volumes and pressures at the end of a step."""

from __future__ import annotations

from typing import Any

from myostrain.circulation.contracts import Array, Circulation, Prescribed
from myostrain.errors import InputError, shown
from myostrain.history import backward_difference, extrapolation_weights
from myostrain.state import State

import numpy as np

#: Corrections of Newton's method for the states at most.
MOST = 60
#: Relative step of difference quotients, and relative correction after which one more is enough.
SMALL, SETTLED = 1e-7, 1e-9


class Circuit:
    """Advances a 0D model by backward differences, together with the walls of the cavities.

    At the end of a step the states Y and the volumes V satisfy Σ wⱼ Yⱼ = f(t, Y, p) and Σ wⱼ Vⱼ = q(t, Y, p)
    with the weights w of the backward difference of first or second order, for any sizes of steps. Given
    the pressures p, Newton's method finds Y; what is left is an equation a cavity between V and p, which is
    solved with the wall. Both formulas damp what is stiff, so that a valve that shuts does not chatter; and
    what is a linear invariant of the equations, as the volume of all the blood, stays the same.

    Args:
        model: The 0D model, or what is prescribed.
        preload: Pressure in each cavity at the beginning; that of the model unless given, or zero.

    Raises:
        InputError: It is not such a model, or there is a preload where pressure or volume are prescribed.

    Attributes:
        pressures: Pressures (cavities,) at the last accepted time; zero before.
        volumes: The volumes (cavities,) that the model has then; None before.
        states: The states (states,) then.
        lost: Pressures (cavities,) without states in the present step; None if there are none.
    """

    def __init__(self, model: Circulation | Prescribed, preload: float | Array | None = None) -> None:
        self.model: Any = model
        self._prescribed = hasattr(model, "tied")
        if isinstance(model, type) or not (self._prescribed or hasattr(model, "rates")):
            raise InputError(
                f"{shown(model)}: give a circulation, such as Windkessel(), or one of your own with rates()",
                "circulation.kind",
            )
        if self._prescribed and preload is not None:
            raise InputError(
                "this has no effect where the cavity's pressure or volume is given: leave it out",
                "circulation.preload",
            )
        self.cavities = int(model.cavities)
        self.names: tuple[str, ...] = tuple(getattr(model, "states", ()))
        begun = np.asarray(getattr(model, "preload", 0.0) if preload is None else preload, dtype=float)
        if begun.ndim and begun.shape != (self.cavities,):
            raise InputError(f"{begun.tolist()}: give one number, or {self.cavities}", "circulation.preload")
        #: Pressure (cavities,) at the beginning.
        self.preload: Array = np.broadcast_to(begun, (self.cavities,)).copy()
        self.clear()

    def clear(self) -> None:
        """Begin anew: the next step finds the configuration at the preload."""
        self._times: list[float] = []
        self._past: list[Array] = []  # by time, states and volumes, newest first
        self._past_pressures: list[Array] = []
        self._weights, self._end = np.zeros(0), 0.0
        self.lost: Array | None = None
        self._found = self.states = np.zeros(len(self.names))

    @property
    def pressures(self) -> Array:
        """Pressures (cavities,) at the last accepted time; zero before."""
        return self._past_pressures[0] if self._times else np.zeros(self.cavities)

    @property
    def volumes(self) -> Array | None:
        """Volumes (cavities,) that the model has at the last accepted time; None before."""
        return self._past[0][len(self.names) :] if self._times else None

    def prepare(self, end: float, order: int) -> Array:
        """Get ready for a step to the time ``end``; a first guess of the pressures (cavities,) there.

        Args:
            end: Simulated time.
            order: Order of the backward difference, 1 or 2.
        """
        self._end, self.lost = end, None
        if not self._times or not self.cavities:
            return np.zeros(self.cavities) if self._prescribed else self.preload.copy()
        self._weights = backward_difference([end, *self._times[:order]])
        weights = extrapolation_weights(self._times[:2], end)
        return np.asarray(weights @ np.array(self._past_pressures[: len(weights)]))

    def tied(self, volumes: Array, pressures: Array) -> tuple[Array, Array, Array]:
        """What is zero where volumes and pressures obey the model at the end of the step, and derivatives.

        Args:
            volumes: Volumes (cavities,).
            pressures: Pressures (cavities,).

        Returns:
            Values (cavities,), and their derivatives by the volumes and by the pressures.
            They are not numbers where the model has no states for these pressures.
        """
        if self._prescribed:
            return tuple(np.asarray(part) for part in self.model.tied(self._end, volumes, pressures))  # type: ignore[return-value]
        count = self.cavities
        if not self._times:
            return pressures - self.preload, np.zeros((count, count)), np.eye(count)
        weights, size = self._weights, len(self.names)
        past = weights[1:] @ np.array(self._past[: len(weights) - 1])
        states = self._solve(past[:size], pressures)
        if not np.isfinite(states).all():
            self.lost = pressures.copy()
            return np.full(count, np.nan), np.eye(count), np.zeros((count, count))
        _, flow, slopes = self._differentiated(states, pressures)
        by_states, by_pressures = slopes[:, :size], slopes[:, size:]
        stiff = weights[0] * np.eye(size) - by_states[:size]
        total = by_pressures[size:] + by_states[size:] @ np.linalg.solve(stiff, by_pressures[:size])
        self._found = states
        values = volumes + (past[size:] - flow) / weights[0]
        return values, np.eye(count), -total / weights[0]

    def _solve(self, past: Array, pressures: Array) -> Array:
        """The states for these pressures; NaN if there are none."""
        size, weight = len(self.names), self._weights[0]
        states, last = self._found.copy(), False  # those of the last pressures that were tried
        for _ in range(MOST):
            rates, _, slopes = self._differentiated(states, pressures)
            residual = weight * states + past - rates
            try:
                correction = np.linalg.solve(weight * np.eye(size) - slopes[:size, :size], residual)
            except np.linalg.LinAlgError:
                break
            states = states - correction
            if last or size == 0:
                return states
            last = bool(np.all(np.abs(correction) <= SETTLED * (1 + np.abs(states))))
        return np.full(size, np.nan)

    def _differentiated(self, states: Array, pressures: Array) -> tuple[Array, Array, Array]:
        """Rates, flows, and the derivatives of both by states and pressures."""
        size, point = len(self.names), np.append(states, pressures)

        def values(at: Array) -> Array:
            return np.append(*self._rates(self._end, at[:size], at[size:]))

        middle = values(point)
        slopes = np.empty((len(middle), len(point)))
        for i, step in enumerate(SMALL * (1 + np.abs(point))):
            moved = point.copy()
            moved[i] += step
            slopes[:, i] = (values(moved) - middle) / step
        return middle[:size], middle[size:], slopes

    def _rates(self, time: float, states: Array, pressures: Array) -> tuple[Array, Array]:
        """Rates and flows of the model, whatever a user's own one does."""
        try:
            rates, flows = self.model.rates(time, states, pressures)
            return np.asarray(rates, dtype=float), np.asarray(flows, dtype=float)
        except (TypeError, ValueError, ArithmeticError, IndexError, KeyError, AttributeError) as error:
            name, kind = type(self.model).__name__, type(error).__name__
            raise InputError(
                f"{name}.rates failed at t = {time:.6g}: {kind}: {error}", "circulation.kind"
            ) from error

    def accept(self, time: float, volumes: Array, pressures: Array) -> None:
        """Take these volumes and pressures (cavities,) as those at ``time``.

        What is kept are the volumes that the model has for these pressures: those of the walls differ from
        them by the tolerance to which they were found, which so does not add up over the steps. A time
        that has been accepted keeps what it has.
        """
        if self._times[:1] == [time]:
            return
        if self._prescribed:
            self._found = np.zeros(0)
        elif not self._times:
            self._found = self._begun(pressures, volumes, time)
        elif self.cavities:
            volumes = volumes - self.tied(volumes, pressures)[0]
        self.states = self._found
        self._times = [time, *self._times[:1]]
        self._past = [np.append(self.states, volumes), *self._past[:1]]
        self._past_pressures = [np.array(pressures), *self._past_pressures[:1]]

    def _begun(self, pressures: Array, volumes: Array, time: float) -> Array:
        """The first states, and whether the model gives what the contract wants."""
        name = type(self.model).__name__
        states = np.asarray(self.model.initial_states(pressures, volumes), dtype=float)
        if states.shape != (len(self.names),):
            raise InputError(
                f"{name}.initial_states() gives values of shape {states.shape} for the {len(self.names)} "
                f"states {list(self.names)}",
                "circulation.kind",
            )
        rates, flows = self._rates(time, states, pressures)
        if rates.shape != states.shape or flows.shape != (self.cavities,):
            raise InputError(
                f"{name}.rates() gives shapes {rates.shape} and {flows.shape}; give the rates of "
                f"{len(self.names)} states, and the flows into {self.cavities} cavities",
                "circulation.kind",
            )
        return states

    def state(self) -> State:
        """Times, states, volumes and pressures."""
        return {
            "times": list(self._times),
            "past": [past.tolist() for past in self._past],
            "pressures": [pressures.tolist() for pressures in self._past_pressures],
        }

    def restore(self, state: State) -> None:
        """Go on from a state."""
        self._times = list(state["times"])
        self._past = [np.array(past) for past in state["past"]]
        self._past_pressures = [np.array(pressures) for pressures in state["pressures"]]
        if self._past:
            self._found = self.states = self._past[0][: len(self.names)]
