"""Derivatives of formulas, as formulas of the same graph."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from myostrain.pointwise.expressions import Expression

import numpy as np

#: NumPy's functions, which a type checker knows for arrays only.
_numpy: Any = np


def derivative(of: Expression, by: Expression, fixed: Iterable[Expression] = ()) -> Expression:
    """The partial derivative of an expression.

    Args:
        of: The expression.
        by: By what; any expression of the graph.
        fixed: Expressions that are taken as if they did not depend on it.
    """
    graph = of.graph
    zero = graph.constant(0.0)
    ends = [*fixed, by]
    known: dict[int, Expression] = {e.index: zero for e in ends}
    known[by.index] = graph.constant(1.0)
    for node in graph.needed([of], ends):
        if node.index not in known:
            known[node.index] = _chain(node, [known[a.index] for a in node.args])
    return known[of.index]


def _chain(node: Expression, d: list[Expression]) -> Expression:
    """The derivative of a node from those of its arguments."""
    graph, op = node.graph, node.op
    zero = graph.constant(0.0)
    if all(x.is_number(0) for x in (d[1:] if op == "where" else d)):
        return zero
    a = node.args[0]
    b = node.args[1] if len(node.args) > 1 else a
    value: Any
    match op:
        case "add":
            value = d[0] + d[1]
        case "sub":
            value = d[0] - d[1]
        case "mul":
            value = d[0] * b + a * d[1]
        case "div":
            value = (d[0] - node * d[1]) / b
        case "neg":
            value = -d[0]
        case "pow":
            value = zero
            if not d[0].is_number(0):
                value = b * a ** (b - 1.0) * d[0]
            if not d[1].is_number(0):
                value = value + node * _numpy.log(a) * d[1]
        case "min":
            value = _numpy.where(a < b, d[0], d[1])
        case "max":
            value = _numpy.where(a > b, d[0], d[1])
        case "where":
            value = _numpy.where(a, d[1], d[2])
        case "exp":
            value = node * d[0]
        case "expm1":
            value = (node + 1.0) * d[0]
        case "log":
            value = d[0] / a
        case "log1p":
            value = d[0] / (1.0 + a)
        case "sqrt":
            value = 0.5 * d[0] / node
        case "sinh":
            value = _numpy.cosh(a) * d[0]
        case "cosh":
            value = _numpy.sinh(a) * d[0]
        case "tanh":
            value = (1.0 - node * node) * d[0]
        case "sin":
            value = _numpy.cos(a) * d[0]
        case "cos":
            value = -_numpy.sin(a) * d[0]
        case "tan":
            value = (1.0 + node * node) * d[0]
        case "arcsin":
            value = d[0] / _numpy.sqrt(1.0 - a * a)
        case "arccos":
            value = -d[0] / _numpy.sqrt(1.0 - a * a)
        case "arctan":
            value = d[0] / (1.0 + a * a)
        case "abs":
            value = _numpy.where(a < 0.0, -d[0], d[0])
        case _:  # floor, ceil, comparisons: constant but for jumps
            value = zero
    return graph.lift(value)
