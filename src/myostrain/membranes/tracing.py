"""A membrane's equations as graphs, with its parameters as given numbers or given nodal values."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from myostrain.membranes.contracts import Array, Membrane
from myostrain.pointwise import Expression, Graph, Untraceable


class Traced:
    """The equations of a membrane on symbols.

    A number that the membrane holds as an attribute is a parameter: it is given when the formulas run, so
    that another value compiles nothing again.

    Args:
        membrane: The model.
        varying: Names of parameters of which each node has its own value.
        as_numbers: Whether parameters are written into the formulas, for a model that does more with them
            than arithmetic.

    Raises:
        Untraceable: The model does with symbols what no graph can hold.

    Attributes:
        graph: The graph.
        scalars: The parameters that are numbers.
        fields: The parameters that vary over the nodes.
        as_numbers: Whether the parameters are written into the formulas.
    """

    def __init__(self, membrane: Membrane, varying: Sequence[str] = (), *, as_numbers: bool = False) -> None:
        self.graph, self.as_numbers = Graph(), as_numbers
        self._names = () if as_numbers else tuple(n for n in parameters(membrane) if n not in varying)
        self.scalars = [self.graph.input(name, varies=False) for name in self._names]
        self.fields = [self.graph.input(name) for name in varying]
        symbols = dict(zip((*self._names, *varying), (*self.scalars, *self.fields), strict=True))
        self._membrane = replaced(membrane, symbols)
        self._count = len(tuple(getattr(membrane, "states", ())))

    def numbers(self, membrane: Membrane) -> list[float]:
        """Values of the scalars."""
        return [float(getattr(membrane, name)) for name in self._names]

    def current(self, v: Expression, states: Sequence[Expression]) -> Expression:
        """The current's formula."""
        return self._lifted(_called(self._membrane.current, v, list(states)))

    def rates(self, v: Expression, states: Sequence[Expression]) -> list[Expression]:
        """The formula of each state's rate."""
        if not self._count:
            return []
        found = _called(self._membrane.rates, v, list(states))
        if not hasattr(found, "__len__") or len(found) != self._count:
            raise Untraceable("not one rate for each state")
        return [self._lifted(rate) for rate in found]

    def _lifted(self, found: Any) -> Expression:
        return self.graph.lift(found)


def traced(membrane: Membrane, varying: Sequence[str] = ()) -> Traced | None:
    """The equations on symbols; None if the model does with them what no graph can hold."""
    for as_numbers in (False, True):
        try:
            found = Traced(membrane, varying, as_numbers=as_numbers)
            graph = found.graph
            states = [graph.input(f"s{i}") for i in range(found._count)]
            found.current(graph.input("v"), states)
            found.rates(graph.input("v"), states)
        except Untraceable:
            continue
        return found
    return None


def parameters(membrane: Membrane) -> dict[str, float]:
    """The numbers that a model holds as attributes, by name."""
    held = vars(membrane) if hasattr(membrane, "__dict__") else {}
    return {name: float(x) for name, x in held.items() if isinstance(x, float) and not name.startswith("__")}


def replaced(membrane: Membrane, values: Mapping[str, Array | Expression]) -> Any:
    """A copy of a model in which attributes are something else than numbers."""
    made = copy.copy(membrane)
    for name, value in values.items():
        object.__setattr__(made, name, value)
    return made


def _called(function: Callable[..., Any], *arguments: Any) -> Any:
    try:
        return function(*arguments)
    except Untraceable:
        raise
    except (ArithmeticError, AttributeError, LookupError, NameError, TypeError, ValueError) as error:
        raise Untraceable(str(error)) from error
