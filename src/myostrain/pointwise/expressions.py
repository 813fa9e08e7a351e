"""Pointwise formulas as graphs: what NumPy does to a symbol is written down instead of computed.

A function of nodal arrays, called with symbols, gives the graph of what it computes. Each formula is in it
once, however often it was written, and can be differentiated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from myostrain.pointwise.operations import COMPARISONS, COMPUTE, LOGIC, UFUNCS

import numpy as np
import numpy.typing as npt

#: NumPy's functions, which a type checker knows for arrays only.
_numpy: Any = np


class Untraceable(TypeError):
    """A function does with a symbol what no graph can hold."""


class Graph:
    """Expressions, each one once, in an order in which they can be computed."""

    def __init__(self) -> None:
        self.nodes: list[Expression] = []
        self._known: dict[Any, Expression] = {}

    def constant(self, value: Any) -> Expression:
        """A number, or a truth value."""
        if isinstance(value, (bool, np.bool_)):
            return self._node("const", (), bool(value))
        return self._node("const", (), float(value))

    def input(self, name: str, *, varies: bool = True) -> Expression:
        """Something that is given: an array of nodal values, or one number if it does not vary."""
        return self._node("input" if varies else "scalar", (), name)

    def lift(self, value: Any) -> Expression:
        """An expression as it is, a number as a constant.

        Raises:
            Untraceable: It is neither.
        """
        if isinstance(value, Expression):
            if value.graph is not self:
                raise Untraceable("an expression of another graph")
            return value
        if isinstance(value, (bool, np.bool_, int, float, np.number)) or (
            isinstance(value, np.ndarray) and value.shape == ()
        ):
            if isinstance(value, (complex, np.complexfloating)):
                raise Untraceable("a complex number")
            return self.constant(value if not isinstance(value, np.ndarray) else value.item())
        raise Untraceable(f"a {type(value).__name__} among nodal values")

    def _node(self, op: str, args: tuple[Expression, ...], value: Any = None) -> Expression:
        # 0.0 and -0.0 are equal, and so are 1.0 and True.
        exact = (type(value), repr(value)) if op == "const" else value
        key = (op, tuple(a.index for a in args), exact)
        found = self._known.get(key)
        if found is None:
            found = Expression(self, op, args, value, len(self.nodes))
            self._known[key] = found
            self.nodes.append(found)
        return found

    def make(self, op: str, *given: Any) -> Expression:
        """An operation on expressions or numbers, simplified."""
        args = tuple(self.lift(a) for a in given)
        short = self._shortcut(op, args)
        if short is not None:
            return short
        if all(a.op == "const" for a in args):
            with np.errstate(all="ignore"):
                return self.constant(COMPUTE[op](*(a.value for a in args)))
        if op in ("add", "mul", "and", "or", "min", "max", "eq", "ne") and args[0].index > args[1].index:
            args = (args[1], args[0])
        return self._node(op, args)

    def _shortcut(self, op: str, args: tuple[Expression, ...]) -> Expression | None:
        """What an operation is without being carried out, None if it has to be."""
        a, *rest = args
        b = rest[0] if rest else a
        match op:
            case "gt":
                return self.make("lt", b, a)
            case "ge":
                return self.make("le", b, a)
            case "square":
                return self.make("mul", a, a)
            case "reciprocal":
                return self.make("div", 1.0, a)
            case "positive":
                return a
            case "heaviside":
                return self.make(
                    "where", self.make("eq", a, 0), b, self.make("where", self.make("lt", a, 0), 0.0, 1.0)
                )
            case "mod":
                return a - b * self.make("floor", a / b)
            case "add" if a.is_number(0):
                return b
            case "add" | "sub" if b.is_number(0):
                return a
            case "sub" if a is b:
                return self.constant(0.0)
            case "sub" if a.is_number(0):
                return self.make("neg", b)
            case "add" if b.op == "neg":
                return self.make("sub", a, b.args[0])
            case "add" if a.op == "neg":
                return self.make("sub", b, a.args[0])
            case "sub" if b.op == "neg":
                return self.make("add", a, b.args[0])
            case "mul" if a.is_number(0) or b.is_number(0):
                return self.constant(0.0)
            case "mul" if a.is_number(1):
                return b
            case "mul" | "div" if b.is_number(1):
                return a
            case "mul" if a.is_number(-1):
                return self.make("neg", b)
            case "mul" if b.is_number(-1):
                return self.make("neg", a)
            case "div" if a.is_number(0):
                return a
            case "div" if b.op == "const" and b.value != 0:
                return self.make("mul", a, 1.0 / b.value)
            case "mul" | "div" if a.op == "neg" and b.op != "const":
                return self.make("neg", self.make(op, a.args[0], b))
            case "mul" if b.op == "neg" and a.op != "const":
                return self.make("neg", self.make(op, a, b.args[0]))
            case "neg" if a.op == "neg":
                return a.args[0]
            case "pow" if b.op == "const":
                return self._power(a, b.value)
            case "where" if a.op == "const":
                return rest[0] if a.value else rest[1]
            case "where" if rest[0] is rest[1]:
                return rest[0]
            case "and" if a.op == "const":
                return b if a.value else a
            case "or" if a.op == "const":
                return a if a.value else b
        return None

    def _power(self, base: Expression, exponent: float) -> Expression | None:
        """Powers that are products and roots."""
        if exponent == 0.5:
            return self.make("sqrt", base)
        if exponent != int(exponent) or abs(exponent) > 16:
            return None
        result, factor, left = None, base, abs(int(exponent))
        while left:
            if left & 1:
                result = factor if result is None else self.make("mul", result, factor)
            left >>= 1
            factor = self.make("mul", factor, factor) if left else factor
        if result is None:
            return self.constant(1.0)
        return result if exponent > 0 else self.make("div", 1.0, result)

    def needed(self, outputs: Iterable[Expression], given: Iterable[Expression] = ()) -> list[Expression]:
        """What has to be computed for some outputs, in order; not what only ``given`` ones need."""
        wanted, found = [o.index for o in outputs], set()
        stops = {g.index for g in given}
        while wanted:
            index = wanted.pop()
            if index not in found:
                found.add(index)
                if index not in stops:
                    wanted += [a.index for a in self.nodes[index].args]
        return [self.nodes[i] for i in sorted(found)]


class Expression:
    """A value at each node, as a formula; behaves in arithmetic as a NumPy array does.

    Attributes:
        op: The operation, "const", "input" (nodal values, given) or "scalar" (a number, given).
        args: Expressions that it acts on.
        value: The number of a constant, the name of what is given.
        index: Its place in the graph.
    """

    __slots__ = ("args", "graph", "index", "op", "value")
    shape = ()
    ndim = 0

    def __init__(self, graph: Graph, op: str, args: tuple[Expression, ...], value: Any, index: int) -> None:
        self.graph, self.op, self.args, self.value, self.index = graph, op, args, value, index

    def __repr__(self) -> str:
        """Operation and place."""
        return f"<{self.op} {self.value if self.value is not None else self.index}>"

    def is_number(self, number: float) -> bool:
        """Whether it is this constant."""
        return self.op == "const" and not isinstance(self.value, bool) and self.value == number

    @property
    def logical(self) -> bool:
        """Whether it is a truth value."""
        return self.op in COMPARISONS or self.op in LOGIC or isinstance(self.value, bool)

    def __bool__(self) -> bool:
        """Refused: there is no number yet.

        Raises:
            Untraceable: Always.
        """
        raise Untraceable("a Python `if` on nodal values; use numpy.where")

    def __float__(self) -> float:
        """Refused, but for constants.

        Raises:
            Untraceable: It is not a constant.
        """
        if self.op == "const":
            return float(self.value)
        raise Untraceable("nodal values taken for one number")

    def __hash__(self) -> int:
        """Its place."""
        return self.index

    def __array_ufunc__(self, ufunc: Any, method: str, *given: Any, **options: Any) -> Any:
        """What NumPy's functions do to it."""
        name = UFUNCS.get(ufunc.__name__)
        if name is None or method != "__call__" or options:
            raise Untraceable(f"numpy.{ufunc.__name__}" + (f".{method}" if method != "__call__" else ""))
        arrays = [a for a in given if isinstance(a, np.ndarray) and a.shape]
        if arrays:  # such as a constant vector of rates: element by element
            return _elementwise(lambda *parts: self.graph.make(name, *parts), given)
        return self.graph.make(name, *given)

    def __array_function__(self, function: Any, types: Any, given: Any, options: Any) -> Any:
        """What numpy.where, clip and the like do to it."""
        make = self.graph.make
        if function is np.where and len(given) == 3:
            return make("where", *given)
        if function is np.clip and len(given) == 3 and not options:
            return make("min", make("max", given[0], given[1]), given[2])
        if function in (np.zeros_like, np.ones_like):
            return self.graph.constant(float(function is np.ones_like))
        if function in (np.stack, np.array, np.vstack) and len(given) == 1 and not options:
            return list(given[0])
        if function in (np.real,):
            return given[0]
        raise Untraceable(f"numpy.{function.__name__}")

    def __add__(self, other: Any) -> Any:
        """Sum."""
        return _numpy.add(self, other)

    def __radd__(self, other: Any) -> Any:
        """Sum."""
        return _numpy.add(other, self)

    def __sub__(self, other: Any) -> Any:
        """Difference."""
        return _numpy.subtract(self, other)

    def __rsub__(self, other: Any) -> Any:
        """Difference."""
        return _numpy.subtract(other, self)

    def __mul__(self, other: Any) -> Any:
        """Product."""
        return _numpy.multiply(self, other)

    def __rmul__(self, other: Any) -> Any:
        """Product."""
        return _numpy.multiply(other, self)

    def __truediv__(self, other: Any) -> Any:
        """Quotient."""
        return _numpy.divide(self, other)

    def __rtruediv__(self, other: Any) -> Any:
        """Quotient."""
        return _numpy.divide(other, self)

    def __pow__(self, other: Any) -> Any:
        """Power."""
        return _numpy.power(self, other)

    def __rpow__(self, other: Any) -> Any:
        """Power."""
        return _numpy.power(other, self)

    def __mod__(self, other: Any) -> Any:
        """Remainder."""
        return _numpy.remainder(self, other)

    def __neg__(self) -> Any:
        """Negative."""
        return _numpy.negative(self)

    def __pos__(self) -> Any:
        """Itself."""
        return self

    def __abs__(self) -> Any:
        """Magnitude."""
        return _numpy.absolute(self)

    def __lt__(self, other: Any) -> Any:
        """Comparison."""
        return _numpy.less(self, other)

    def __le__(self, other: Any) -> Any:
        """Comparison."""
        return _numpy.less_equal(self, other)

    def __gt__(self, other: Any) -> Any:
        """Comparison."""
        return _numpy.greater(self, other)

    def __ge__(self, other: Any) -> Any:
        """Comparison."""
        return _numpy.greater_equal(self, other)

    def __eq__(self, other: object) -> Any:
        """Comparison of values."""
        return _numpy.equal(self, other)

    def __ne__(self, other: object) -> Any:
        """Comparison of values."""
        return _numpy.not_equal(self, other)

    def __and__(self, other: Any) -> Any:
        """Both."""
        return _numpy.logical_and(self, other)

    __rand__ = __and__

    def __or__(self, other: Any) -> Any:
        """One of both."""
        return _numpy.logical_or(self, other)

    __ror__ = __or__

    def __invert__(self) -> Any:
        """Not."""
        return _numpy.logical_not(self)


def _elementwise(function: Callable[..., Any], given: Sequence[Any]) -> npt.NDArray[np.object_]:
    """A function of the elements of arrays, single values taken for each element."""
    shape = np.broadcast_shapes(*(a.shape for a in given if isinstance(a, np.ndarray)))
    parts = []
    for value in given:
        array = np.empty((), dtype=object)
        array[()] = value
        parts.append(np.broadcast_to(value.astype(object) if isinstance(value, np.ndarray) else array, shape))
    found = np.empty(shape, dtype=object)
    for place in np.ndindex(shape):
        found[place] = function(*(part[place] for part in parts))
    return found
