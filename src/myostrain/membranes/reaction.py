"""The membrane at all nodes: states advanced over a step, and the current, in one compiled pass."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from typing import Any

from myostrain.engine import MPI
from myostrain.errors import ComputationError, InputError
from myostrain.membranes.contracts import Array, Integrator, Membrane, Step
from myostrain.membranes.exponential import GeneralizedRushLarsen
from myostrain.membranes.linearly_implicit import LinearlyImplicit, with_slope
from myostrain.membranes.tracing import Traced, replaced, traced
from myostrain.pointwise import Expression, Program, derivative

import numpy as np

log = logging.getLogger("myostrain")

#: By how much a gate may leave [0, 1]: multistep formulas swing over by a little.
GATE_MARGIN = 1e-2
#: Nodes on which a model is tried.
FEW = 3


def default_integrator(membrane: Membrane) -> Any:
    """Exponential for a model that has gates or says so, linearly implicit for others."""
    exponential = getattr(membrane, "exponential", False) or tuple(getattr(membrane, "gates", ()))
    return GeneralizedRushLarsen() if exponential else LinearlyImplicit()


class Reaction:
    """What the balance of the potential asks of a membrane, at the nodes of this process.

    Args:
        membrane: The model.
        integrator: How its states advance; as the model's kind needs it unless given.
        varying: Values of parameters at the nodes (nodes,), by name.
        comm: Processes that share the compiled formulas (collective).

    Raises:
        InputError: The integrator is none, or none for this model.

    Attributes:
        integrator: The integrator.
        multistep: Whether it needs past values and a guess of the states.
        written: Whether the integrator writes its steps down, so that they are compiled.
        varying: Values (nodes,) of the parameters that vary, of the last solve.
    """

    def __init__(
        self,
        membrane: Membrane,
        integrator: Integrator | None = None,
        varying: Mapping[str, Array] | None = None,
        comm: Any = MPI.COMM_SELF,
    ) -> None:
        self.membrane, self._comm = membrane, comm
        self._held: Any = None
        self._model: Traced | None = None
        self._signature: Any = None
        self.integrator: Any = default_integrator(membrane) if integrator is None else integrator
        self.multistep = bool(getattr(self.integrator, "multistep", True))
        self._given = dict(varying or {})
        self.names = tuple(getattr(membrane, "states", ()))
        self._gates = [self.names.index(g) for g in getattr(membrane, "gates", ()) if g in self.names]
        self.written = hasattr(self.integrator, "formula")
        self._programs: dict[Any, Program] = {}
        self._noticed = False
        self._trace(0)
        if not self.written and not callable(getattr(self.integrator, "advance", None)):
            raise InputError(
                f"{type(self.integrator).__name__} is not an integrator: it has no method advance",
                "cell.integrator",
            )
        if not self.multistep and self._model is None:
            raise InputError(
                f"{type(self.integrator).__name__} needs the equations in symbols, and "
                f"{type(membrane).__name__} does with arrays what cannot be written down; take "
                "LinearlyImplicit, or use NumPy's arithmetic, exp, log, sqrt, tanh, where only",
                "cell.integrator",
            )
        if self._given and self._model is None:
            self._try_varying()

    def _try_varying(self) -> None:
        """Refuse what varies where the equations ask for one number.

        Raises:
            InputError: They do.
        """
        few = {name: np.resize(x, FEW) if x.size else np.zeros(FEW) for name, x in self._given.items()}
        varied = replaced(self.membrane, few)
        v = np.full(FEW, float(self.membrane.resting_potential()))
        rest = self.membrane.resting_states() if self.names else ()
        states = np.tile(np.asarray(rest, dtype=float).reshape(-1, 1), FEW)
        try:
            self._advanced(v, states, Step(1.0, 1.0, np.zeros_like(states), states.copy(), v, 1), varied)
        except (TypeError, ValueError) as error:
            raise InputError(
                f"{', '.join(self._given)} vary over the body, and {type(self.membrane).__name__} wants one "
                f"number ({error}): decide by numpy.where, not by Python's if",
                "cell.variation",
            ) from None

    def _trace(self, nodes: int) -> None:
        """Write the equations down, again if the model holds other things than the last time.

        A script's model may be changed between two steps. Arrays with a value for each node may vary from
        step to step, as numbers may.
        """
        held = dict(vars(self.membrane)) if hasattr(self.membrane, "__dict__") else {}
        arrays = {n: x for n, x in held.items() if isinstance(x, np.ndarray) and x.shape == (nodes,)}
        self.varying = {n: np.ascontiguousarray(x, dtype=float) for n, x in (arrays | self._given).items()}
        signature = [
            (name, name in arrays, self._fixed(value) if name not in arrays else None)
            for name, value in held.items()
        ]
        if signature != self._signature:
            self._model, self._programs = traced(self.membrane, tuple(self.varying)), {}
            self._signature = [
                (name, given, None if given else self._fixed(held[name])) for name, given, _ in signature
            ]
            self._held = held  # alive, so that what their places say stays true

    def _fixed(self, value: Any) -> Any:
        """By what something that a model holds is known again; None for a number that is given anew."""
        if isinstance(value, float) and self._model is not None and not self._model.as_numbers:
            return None
        if isinstance(value, np.ndarray):
            return value.tobytes()
        return value if isinstance(value, (bool, int, float, str, type(None))) else id(value)

    def vary(self, values: Mapping[str, Array]) -> None:
        """Take other values (nodes,) of the parameters that vary, of as many nodes as the next solve has."""
        if values.keys() != self._given.keys():
            self._signature = None
        self._given = dict(values)

    @property
    def compiled(self) -> bool:
        """Whether steps run as C, once one has been taken."""
        return bool(self._programs) and all(p.compiled for p in self._programs.values())

    def solve(
        self, v: Array, states: Array, step: Step, out: Array | None = None
    ) -> tuple[Array, Array, Array, int]:
        """Advance the states, and evaluate the current with them.

        Args:
            v: Potential at the end of the step (nodes,), a guess to linearise about.
            states: A guess of the states (states, nodes) for an integrator of several steps.
            step: The step.
            out: Where the states go, nothing that the step holds; a new array unless given.

        Returns:
            The states (states, nodes), the current and its derivative in v (nodes,), and the first node of
            this process where a gate is out of [0, 1] or a state is not a number, -1 for none.
        """
        self._trace(len(v))
        model = self._model
        if model is None or not self.written:
            states, current, slope = self._advanced(v, states, step)
            return states, current, slope, self._first_wrong(states)
        if out is None:
            out = np.empty_like(states)
        current, slope = np.empty_like(v), np.empty_like(v)
        varying = [self.varying[f.value] for f in model.fields]
        numbers = model.numbers(self.membrane)
        if self.multistep:
            program = self._programs.get("multistep") or self._multistep()
            inputs = [v, *states, *step.history, *varying]
            bad = program(inputs, [step.weight, *numbers], [*out, current, slope])
            return out, current, slope, bad
        order = min(step.order, self.integrator.order)
        count = self.integrator.substeps
        length = [step.length / count, *numbers]
        before, start = step.before, step.potential
        for sub in range(1, count):
            part = (1 - sub / count) * step.potential + sub / count * v
            begun = start if order > 1 else part
            program = self._programs.get((order, False)) or self._exponential(order, last=False)
            bad = program([part, begun, *before, *varying], length, [*out])
            if bad >= 0:
                return out, current, slope, bad
            before, start = out, part
        program = self._programs.get((order, True)) or self._exponential(order, last=True)
        begun = start if order > 1 else v
        bad = program([v, begun, *before, *varying], length, [*out, current, slope])
        return out, current, slope, bad

    def _advanced(
        self, v: Array, states: Array, step: Step, membrane: Any = None
    ) -> tuple[Array, Array, Array]:
        """With NumPy alone."""
        if membrane is None:
            membrane = replaced(self.membrane, self._given) if self._given else self.membrane
        if self.names:
            states = self.integrator.advance(membrane, v, states, step)
        current, slope = with_slope(lambda at: membrane.current(at, states), v)
        return states, np.broadcast_to(current, v.shape), np.broadcast_to(slope, v.shape)

    def _alone(self) -> Traced:
        """The equations in a graph of their own.

        Sums are in the order in which their terms came into a graph. Beside formulas of other steps, which a
        resumed run may not need, a program could have other bits.
        """
        model = traced(self.membrane, tuple(self.varying))
        assert model is not None
        return model

    def _multistep(self) -> Program:
        model = self._alone()
        graph, v = model.graph, model.graph.input("v")
        guess = [graph.input(f"guess {name}") for name in self.names]
        history = [graph.input(f"history {name}") for name in self.names]
        weight = graph.input("weight of the new value", varies=False)
        states = self.integrator.formula(lambda s: model.rates(v, s), guess, history, weight)
        return self._program("multistep", model, [v, *guess, *history], weight, states, v)

    def _exponential(self, order: int, *, last: bool) -> Program:
        model = self._alone()
        graph, v = model.graph, model.graph.input("v")
        start = graph.input("v before")
        before = [graph.input(f"before {name}") for name in self.names]
        length = graph.input("length of the step", varies=False)
        during = 0.5 * (start + v) if order > 1 else v
        states = self.integrator.formula(lambda s: model.rates(during, s), before, length, order)
        return self._program((order, last), model, [v, start, *before], length, states, v if last else None)

    def _program(
        self,
        key: Any,
        model: Traced,
        inputs: list[Expression],
        number: Expression,
        states: list[Expression],
        v: Expression | None,
    ) -> Program:
        """Compile: states, the current and its slope at v, and whether the states are what they may be."""
        outputs = list(states)
        if v is not None:
            current = model.current(v, states)
            outputs += [current, derivative(current, v, fixed=states)]
        good = None
        for index, state in enumerate(states):
            low, high = (-GATE_MARGIN, 1 + GATE_MARGIN) if index in self._gates else (-1e100, 1e100)
            within = (state >= low) & (state <= high)  # false for NaN
            good = within if good is None else good & within
        if good is not None:
            outputs.append(good)
        made = Program([*inputs, *model.fields], [number, *model.scalars], outputs, self._comm)
        self._programs[key] = made
        return made

    def refuse(self, bad: int, states: Array, place: Callable[[int], Array], end: float) -> None:
        """Stop where a gate or another state is no longer what it may be (collective).

        Args:
            bad: The first such node of this process, -1 for none.
            states: The states (states, nodes).
            place: Where a node is.
            end: Time at the end of the step.

        Raises:
            ComputationError: It is so on some process.
        """
        if self._comm.allreduce(bad, op=MPI.MAX) < 0:
            return
        found = None
        if bad >= 0:
            found = self.wrong(states, bad), [round(float(x), 6) for x in place(bad)]
        what, where = next(f for f in self._comm.allgather(found) if f is not None)
        raise ComputationError(f"{what} near {where}", time=end, where=where, advice="a smaller time step.")

    def notice_long_step(self, slope: Array, step: Step, place: Callable[[int], Array]) -> None:
        """Warn, once, of a step in which the current grows by more than itself (collective).

        Where the slope of the current in v outweighs the time derivative, a step turns an upstroke around:
        a wave may not start, a value overshoots, and the matrix may be indefinite.

        Args:
            slope: Derivative of the current in v (nodes,), a rate; negative where v feeds itself.
            step: The step.
            place: Where a node is.
        """
        if self._noticed:
            return
        node = int(np.argmin(slope)) if len(slope) else -1
        mine = float(slope[node]) if node >= 0 else 0.0
        least = self._comm.allreduce(mine, op=MPI.MIN) if self._comm.size > 1 else mine
        if not least < -step.weight:
            return
        self._noticed = True
        # Only now, not in each step: places of all nodes take longer than a step of the membrane.
        here = [round(float(x), 6) for x in place(node)] if node >= 0 else []
        where = min(self._comm.allgather((mine, here)))[1]
        longest = step.length * step.weight / -least
        size = 10.0 ** np.floor(np.log10(longest))
        log.warning(
            "a time step of %.3g is too long for %s: near %s its v grows by itself at a rate of %.3g. An "
            "upstroke may not start, or overshoot. Take time.step = %.3g or less",
            *(step.length, type(self.membrane).__name__, where, -least),
            size * np.floor(longest / size),
        )

    def refuse_no_numbers(self, v: Array, current: Array, place: Callable[[int], Array], end: float) -> None:
        """Stop where the current is not a number (collective).

        Args:
            v: Potential at which it was evaluated (nodes,).
            current: The current (nodes,).
            place: Where a node is.
            end: Time at the end of the step.

        Raises:
            ComputationError: It is so on some process.
        """
        bad, found = np.flatnonzero(~np.isfinite(current)), None
        if len(bad):
            node = int(bad[0])
            what = f"the current of {type(self.membrane).__name__} is {current[node]} at v = {v[node]:.6g}"
            found = what, [round(float(x), 6) for x in place(node)]
        told = [f for f in self._comm.allgather(found) if f is not None]
        if told:
            what, where = told[0]
            raise ComputationError(
                f"{what} near {where}",
                time=end,
                where=where,
                advice="a smaller time step, or a formula that has a value there.",
            )

    def _first_wrong(self, states: Array) -> int:
        """The first node where a gate is out of [0, 1] or a state is not a number, -1 for none."""
        good = np.isfinite(states)
        gates = states[self._gates]
        good[self._gates] &= (gates >= -GATE_MARGIN) & (gates <= 1 + GATE_MARGIN)
        bad = np.flatnonzero(~good.all(axis=0))
        return int(bad[0]) if len(bad) else -1

    def wrong(self, states: Array, node: int) -> str:
        """What is wrong with the states of a node, in words."""
        for index, name in enumerate(self.names):
            value = float(states[index, node])
            if not np.isfinite(value) or abs(value) > 1e100:
                return f"the state {name} is {value}"
            if index in self._gates and not -GATE_MARGIN <= value <= 1 + GATE_MARGIN:
                return f"the gate {name} has left [0, 1]: {value:.6g}"
        return "a state is out of bounds"
