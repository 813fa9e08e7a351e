"""Fewer divisions: they take longer than all other arithmetic."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from myostrain.pointwise.expressions import Expression


def with_few_divisions(outputs: Sequence[Expression]) -> list[Expression]:
    """The same formulas, where quotients of one divisor are products with its reciprocal.

    So are quotients of divisors that are the same at all nodes. What is divided once stays, since a product
    with a reciprocal is rounded twice.

    Args:
        outputs: Formulas of one graph.
    """
    graph = outputs[0].graph
    nodes = graph.needed(outputs)
    divided = Counter(node.args[1].index for node in nodes if node.op == "div")
    varying: set[int] = set()
    made: dict[int, Expression] = {}
    for node in nodes:
        if node.op == "input" or any(a.index in varying for a in node.args):
            varying.add(node.index)
        args = [made[a.index] for a in node.args]
        if node.op == "div" and (divided[node.args[1].index] > 1 or node.args[1].index not in varying):
            made[node.index] = graph.make("mul", args[0], graph.make("div", 1.0, args[1]))
        else:
            made[node.index] = graph.make(node.op, *args) if args else node
    return [made[o.index] for o in outputs]


def quotient_of_factors(of: Expression, by: Expression) -> Expression | None:
    """``of`` over ``by`` without dividing, where the factors of ``by`` are among its own; else None.

    Args:
        of: A formula such as (s₀ − s) a b.
        by: A formula such as −a b.
    """
    graph = of.graph
    above, below, sign = _factors(of)
    others_above, others_below, other_sign = _factors(by)
    if others_above - above or others_below - below:
        return None
    found, under = graph.constant(sign * other_sign), graph.constant(1.0)
    for index in sorted((above - others_above).elements()):
        found = graph.make("mul", found, graph.nodes[index])
    for index in sorted((below - others_below).elements()):
        under = graph.make("mul", under, graph.nodes[index])
    return graph.make("div", found, under)


def _factors(product: Expression) -> tuple[Counter[int], Counter[int], int]:
    """Places of the factors above and below the line, and the sign."""
    above: Counter[int] = Counter()
    below: Counter[int] = Counter()
    sign, left = 1, [(product, True)]
    while left:
        node, up = left.pop()
        if node.op == "neg":
            sign, left = -sign, [*left, (node.args[0], up)]
        elif node.op in ("mul", "div"):
            left += [(node.args[0], up), (node.args[1], up if node.op == "mul" else not up)]
        elif node.is_number(1):
            continue
        else:
            (above if up else below)[node.index] += 1
    return above, below, sign
