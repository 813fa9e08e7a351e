"""Formulas as a file has them, and their values: NumPy's arithmetic on numbers, arrays or symbols."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

#: NumPy's functions, which a type checker knows for arrays only.
_numpy: Any = np

#: Where a quotient by exp(y) − 1 is taken beside its gap: |y| below this, at twice the distance.
GAP = 1e-6


@dataclass(frozen=True, eq=False)
class Formula:
    """An operation on formulas.

    Args:
        op: A key of :data:`OPERATIONS`, or "number" or "name".
        args: What it acts on.
        value: The number, or the name.
    """

    op: str
    args: tuple[Formula, ...] = ()
    value: Any = None


def number(value: float) -> Formula:
    """A number."""
    return Formula("number", value=float(value))


def name(of: str) -> Formula:
    """A variable."""
    return Formula("name", value=of)


def make(op: str, *args: Formula) -> Formula:
    """An operation; exp(x) − 1 becomes the function of that name, which has no cancellation."""
    if op in ("add", "sub", "mul") and all(a.op == "number" for a in args):
        return number(OPERATIONS[op](*(a.value for a in args)))
    if op == "add" and args[0].op == "neg":
        return make("sub", args[1], args[0].args[0])
    if op == "add" and args[0].op == "number" and args[0].value == -1 and args[1].op == "exp":
        return Formula("expm1", args[1].args)
    if op == "sub" and args[0].op == "exp" and args[1].op == "number" and args[1].value == 1:
        return Formula("expm1", args[0].args)
    if op == "sub" and args[0].op == "number" and args[0].value == 1 and args[1].op == "exp":
        return Formula("neg", (Formula("expm1", args[1].args),))
    if op == "neg" and args[0].op == "number":
        return number(-args[0].value)
    return Formula(op, args)


def _logarithm(x: Any, base: Any) -> Any:
    return _numpy.log(x) / _numpy.log(base)


OPERATIONS: dict[str, Callable[..., Any]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "pow": lambda a, b: a**b,
    "mod": lambda a, b: a - b * _numpy.floor(a / b),
    "quotient": lambda a, b: _numpy.floor(a / b),
    "neg": lambda a: -a,
    "min": _numpy.minimum,
    "max": _numpy.maximum,
    "log10": lambda a: _numpy.log(a) / np.log(10.0),
    "logarithm": _logarithm,
    **{
        f: getattr(_numpy, f)
        for f in (
            *("exp", "expm1", "log", "sqrt", "sin", "cos", "tan", "arcsin", "arccos", "arctan"),
            *("floor", "ceil", "abs"),
        )
    },
}
COMPARISONS: dict[str, Callable[..., Any]] = {
    "lt": lambda a, b: a < b,
    "le": lambda a, b: a <= b,
    "gt": lambda a, b: a > b,
    "ge": lambda a, b: a >= b,
    "eq": lambda a, b: a == b,
    "ne": lambda a, b: a != b,
}
LOGIC: dict[str, Callable[..., Any]] = {
    "and": _numpy.logical_and,
    "or": _numpy.logical_or,
    "not": _numpy.logical_not,
}
#: Every operation that a reader may make; those of :func:`make` included.
KNOWN = frozenset((*OPERATIONS, *COMPARISONS, *LOGIC, "where"))


def walk(formula: Formula) -> Iterator[Formula]:
    """A formula and all that it is made of."""
    left = [formula]
    while left:
        at = left.pop()
        yield at
        left += at.args


def names(formula: Formula) -> set[str]:
    """The variables of a formula."""
    return {part.value for part in walk(formula) if part.op == "name"}


def depth(formula: Formula) -> int:
    """How many operations lie in each other at most."""
    deepest, left = 0, [(formula, 1)]
    while left:
        at, level = left.pop()
        deepest = max(deepest, level)
        left += [(part, level + 1) for part in at.args]
    return deepest


def ordered(wanted: Iterable[str], formulas: Mapping[str, Formula]) -> list[str]:
    """The variables that have to be computed for some, each after those that it is made of.

    Raises:
        ValueError: Variables are computed from each other in a circle; its message names them.
    """
    found: dict[str, None] = {}
    path: dict[str, None] = {}
    left = [(variable, False) for variable in reversed(list(wanted))]
    while left:
        variable, done = left.pop()
        if done:
            found[variable] = None
            del path[variable]
        elif variable in path:
            circle = list(path)
            raise ValueError(" → ".join([*circle[circle.index(variable) :], variable]))
        elif variable in formulas and variable not in found:
            path[variable] = None
            left.append((variable, True))
            left += [(other, False) for other in sorted(names(formulas[variable]), reverse=True)]
    return list(found)


class Values:
    """Values of variables, computed in order, each once.

    Args:
        given: Values of what is given.
        formulas: How the others are computed.
        potential: Name of the potential, at whose values quotients may have gaps.
    """

    def __init__(
        self, given: Mapping[str, Any], formulas: Mapping[str, Formula], potential: str | None = None
    ) -> None:
        # NumPy's numbers, which divide by zero without an exception.
        self._known = {n: np.float64(x) if isinstance(x, float) else x for n, x in given.items()}
        self._formulas, self._potential = formulas, potential

    def compute(self, order: Iterable[str]) -> None:
        """Compute variables, in an order in which this can be done."""
        with np.errstate(all="ignore"):
            for variable in order:
                self._known[variable] = self.of(self._formulas[variable])

    def __getitem__(self, variable: str) -> Any:
        """The value of a variable."""
        return self._known[variable]

    def of(self, formula: Formula) -> Any:
        """The value of a formula; a truth value is 1 or 0 where a number is wanted."""
        value = self._any(formula)
        return _numpy.where(value, 1.0, 0.0) if self._logical(formula) else value

    def _any(self, formula: Formula) -> Any:
        op, args = formula.op, formula.args
        if op == "number":
            return np.float64(formula.value)
        if op == "name":
            return self._known[formula.value]
        if op == "where":
            return _numpy.where(self._truth(args[0]), self.of(args[1]), self.of(args[2]))
        if op in LOGIC:
            return LOGIC[op](*(self._truth(a) for a in args))
        if op in COMPARISONS:
            return COMPARISONS[op](*(self.of(a) for a in args))
        if op == "div" and self._potential is not None:
            under = _gap(args[1])
            exponent = _gap(args[0]) if under is None else under
            if exponent is not None:
                return self._beside_the_gap(args[0], args[1], exponent, exact=under is None)
        return OPERATIONS[op](*(self.of(a) for a in args))

    def _truth(self, formula: Formula) -> Any:
        value = self._any(formula)
        return value if self._logical(formula) else value != 0.0

    def _logical(self, formula: Formula) -> bool:
        return formula.op in COMPARISONS or formula.op in LOGIC

    def _beside_the_gap(self, over: Formula, under: Formula, exponent: Formula, *, exact: bool) -> Any:
        """A quotient by or of exp(y) − 1, which is taken at a potential beside that where y vanishes.

        It has a limit there in the models of cells, but no value: 0/0.

        Args:
            over: The numerator.
            under: The denominator.
            exponent: The y.
            exact: Whether only where the denominator is zero, as exp(y) − 1 is not that.
        """
        quotient = Formula("div", (over, under))
        potential = self._potential
        reached = self._within(quotient)
        if potential not in reached or not self._within(exponent):
            return self.of(over) / self.of(under)
        v = self._known[potential]
        y = self._at(under if exact else exponent, v)
        slope = self._at(exponent, np.float64(1.0)) - self._at(exponent, np.float64(0.0))
        near = y == 0.0 if exact else (y < GAP) & (y > -GAP)
        step = 2 * GAP / _numpy.where(slope == 0.0, 1.0, slope)
        beside = v + _numpy.where(near, step, 0.0)
        return self._at(over, beside) / self._at(under, beside)

    def _within(self, formula: Formula) -> set[str]:
        found = names(formula)
        for variable in ordered(found, self._formulas):
            found |= {variable, *names(self._formulas[variable])}
        return found

    def _at(self, formula: Formula, potential: Any) -> Any:
        """A formula at another potential: what depends on this is computed again, of this formula only."""
        assert self._potential is not None
        again = Values(self._known, self._formulas)
        again._known[self._potential] = potential
        for variable in ordered(names(formula), self._formulas):
            if self._potential in self._within(name(variable)):
                again._known[variable] = again.of(self._formulas[variable])
        return again.of(formula)


def _gap(under: Formula) -> Formula | None:
    """The y of a denominator that has the factor exp(y) − 1."""
    if under.op == "expm1":
        return under.args[0]
    if under.op in ("neg", "mul"):
        return next((found for a in under.args if (found := _gap(a)) is not None), None)
    return None


def undefined(formulas: Mapping[str, Formula], known: Collection[str]) -> dict[str, str]:
    """Names that are nowhere defined, each with a variable that needs it."""
    return {
        missing: variable
        for variable, formula in formulas.items()
        for missing in sorted(names(formula))
        if missing not in known and missing not in formulas
    }
