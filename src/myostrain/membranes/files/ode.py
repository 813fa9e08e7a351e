"""Gotran's ``.ode`` files, by the grammar of gotranx; the trees are walked here, no text is evaluated."""

from __future__ import annotations

import functools
import re
from typing import Any

from myostrain.membranes.files.contents import Contents, Unreadable, spelt
from myostrain.membranes.files.formulas import Formula, Values, make, name, number

import numpy as np

FUNCTIONS = {
    **{f: f for f in ("cos", "sin", "tan", "exp", "sqrt", "floor", "abs")},
    "acos": "arccos",
    "asin": "arcsin",
    "atan": "arctan",
    "log": "log",
    "ln": "log",
    "Abs": "abs",
    "Mod": "mod",
    "Min": "min",
    "Max": "max",
    "Lt": "lt",
    "Gt": "gt",
    "Le": "le",
    "Ge": "ge",
    "Eq": "eq",
    "And": "and",
    "Or": "or",
    "Not": "not",
    "Conditional": "where",
}
#: How many arguments a function takes; one where it is not said.
ARGUMENTS = {
    **dict.fromkeys(("mod", "lt", "gt", "le", "ge", "eq"), 2),
    "where": 3,
}
#: These take two or more.
FOLDED = ("and", "or", "min", "max")
OPERATORS = {"+": "add", "-": "sub", "*": "mul", "/": "div"}
TIMES = ("time", "t")


def read_ode(text: str) -> Contents:
    """What an ``.ode`` file says.

    Raises:
        ImportError: gotranx is not there.
        Unreadable: It is not such a file.
    """
    from lark.exceptions import UnexpectedInput

    parser = _parser()
    try:
        tree = parser.parse(text)
    except UnexpectedInput as error:
        line = text.splitlines()[error.line - 1].strip() if 0 < error.line <= text.count("\n") + 1 else ""
        where = f"line {error.line}: {line[:80]!r}" if line else "its end"
        raise Unreadable(f"it is not an .ode file: it cannot be understood from {where} on") from None
    return _Reader().read(tree)


@functools.cache
def _parser() -> Any:
    """The parser, which takes a while to make."""
    from gotranx.parser import Parser

    return Parser(parser="lalr", propagate_positions=True)


class _Reader:
    def __init__(self) -> None:
        self.numbers: dict[str, dict[str, float]] = {"parameters": {}, "states": {}}
        self.formulas: dict[str, Formula] = {}
        self.units: dict[str, str] = {}

    def read(self, tree: Any) -> Contents:
        """Walk through the blocks."""
        blocks = tree.children if tree.data == "ode" else [tree]
        for block in blocks:
            kind = getattr(block, "data", None)
            for item in getattr(block, "children", ()):
                if kind in self.numbers and getattr(item, "data", "") in ("param", "scalarparam"):
                    self._number(item, self.numbers[kind])
                elif kind == "expressions" and getattr(item, "data", "") == "assignment":
                    self._assignment(item)
        states, parameters = self.numbers["states"], self.numbers["parameters"]
        for twice in sorted(states.keys() & parameters.keys()):
            raise Unreadable(f"{twice} is both a state and a parameter")
        rates = {}
        for state in states:
            rate = f"d{state}_dt"
            if rate not in self.formulas:
                raise Unreadable(f"the state {state} has no rate: there is no {rate} = ...")
            rates[state] = name(rate)
        known = {*self.formulas, *states, *parameters}
        units = {n: u for n, u in self.units.items() if n in states or n in parameters}
        times = tuple(t for t in TIMES if t not in known)
        return Contents(parameters, states, rates, self.formulas, times, units, self._time_unit(states))

    def _time_unit(self, states: dict[str, float]) -> str | None:
        """The unit of time: that of rates, else the only one among the parameters."""
        rates = {f"d{state}_dt" for state in states}
        found = {
            spelt(match.group(1))
            for n, u in self.units.items()
            if n in rates and (match := re.search(r"(?:/\s*|\*\s*)(m?s)(?:\s*\*\*\s*-1)?$", u))
        }
        found = found or {u for n, u in self.units.items() if n not in rates and u in ("ms", "s")}
        return found.pop() if len(found) == 1 else None

    def _new(self, of: str) -> None:
        if of in self.formulas or any(of in numbers for numbers in self.numbers.values()):
            raise Unreadable(f"{of} is defined twice")

    def _number(self, item: Any, numbers: dict[str, float]) -> None:
        of, value, *more = item.children
        self._new(str(of))
        try:
            numbers[str(of)] = float(Values({}, {}).of(self._formula(value)))
        except KeyError as error:
            raise Unreadable(f"the value of {of} is not a number: it needs {error.args[0]}") from None
        if not np.isfinite(numbers[str(of)]):
            raise Unreadable(f"the value of {of} is {numbers[str(of)]}")
        if more and more[0] is not None and (unit := spelt(str(more[0]).strip("\"'"))):
            self.units[str(of)] = unit

    def _assignment(self, item: Any) -> None:
        of, value, *more = item.children
        self._new(str(of))
        self.formulas[str(of)] = self._formula(value)
        for comment in more:
            if getattr(comment, "data", "") == "comment":
                self.units[str(of)] = " ".join(map(str, comment.children)).lstrip("# ").strip()

    def _formula(self, tree: Any) -> Formula:
        children = tree.children
        if tree.data in ("expression", "term"):
            found = self._formula(children[0])
            for sign, other in zip(children[1::2], children[2::2], strict=True):
                found = make(OPERATORS[str(getattr(sign, "value", sign))], found, self._formula(other))
            return found
        if tree.data in ("factor", "signedatom"):
            if str(children[0]) == "~":
                raise Unreadable("the operator ~ is not known: write Not(...)")
            inner = self._formula(children[1])
            return make("neg", inner) if str(children[0]) == "-" else inner
        if tree.data == "power":
            return make("pow", self._formula(children[0]), self._formula(children[1]))
        if tree.data == "variable":
            return name(str(children[0]))
        if tree.data == "scientific":
            try:
                return number(float(children[0]))
            except ValueError:
                raise Unreadable(f"{children[0]} is not a number") from None
        if tree.data == "constant":
            return number(np.pi)
        return self._function(str(children[0]), children[1:])

    def _function(self, called: str, trees: list[Any]) -> Formula:
        if called == "ContinuousConditional":
            return self._continuous(trees)
        op, args = FUNCTIONS[called], [self._formula(t) for t in trees]
        if op in FOLDED and len(args) > 1:
            found = args[0]
            for other in args[1:]:
                found = make(op, found, other)
            return found
        wanted = 2 if op in FOLDED else ARGUMENTS.get(op, 1)
        if len(args) != wanted:
            raise Unreadable(f"{called} takes {wanted} arguments, not {len(args)}")
        return make(op, *args)

    def _continuous(self, trees: list[Any]) -> Formula:
        """A conditional that is smooth: both values, weighted with a sigmoid of a width."""
        condition = self._formula(trees[0])
        if condition.op not in ("lt", "le", "gt", "ge") or len(trees) != 4:
            raise Unreadable("ContinuousConditional takes a comparison, two values and a width")
        first, second, width = (self._formula(t) for t in trees[1:])
        shift = make("div", make("sub", *condition.args), width)
        below = make("div", number(1), Formula("add", (number(1), make("exp", shift))))
        above = make("sub", number(1), below)
        if condition.op in ("gt", "ge"):
            below, above = above, below
        return make("add", make("mul", first, below), make("mul", second, above))
