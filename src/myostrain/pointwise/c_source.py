"""C of a pointwise formula: nodes are computed several at a time, in vectors of the processor."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from myostrain.pointwise.divisions import with_few_divisions
from myostrain.pointwise.expressions import Expression

#: Vectors and functions of them.
VECTORS = Path(__file__).with_name("vectors.c").read_text(encoding="utf-8")

_INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_CALLS = {"exp": "own_exp", "expm1": "own_expm1", "log": "own_log", "log1p": "own_log1p"}
_CALLS |= {"pow": "own_pow", "tanh": "own_tanh", "sinh": "own_sinh", "cosh": "own_cosh", "sqrt": "root"}
_CALLS |= {"abs": "magnitude", "arcsin": "each_asin", "arccos": "each_acos", "arctan": "each_atan"}
_CALLS |= {name: f"each_{name}" for name in ("sin", "cos", "tan", "floor", "ceil")}

#: Around the formulas: all nodes go through the same code, also the last ones, which fill no vector.
_EVALUATE = """
enum {{ INPUTS = {inputs}, OUTPUTS = {outputs}, FIXED = {fixed} }};

/* What is the same at all nodes. */
static void prepare(const double *numbers, double *fixed)
{{
  {once}
}}

/* The nodes of one vector; where the conditions hold. */
static truth block(const double *const *in, const double *fixed, double *const *out, long at)
{{
  {each}
}}

long evaluate(long n, const double *const *in, const double *numbers, double *const *out)
{{
  double fixed[FIXED + 1], given[INPUTS + 1][LANES], found[OUTPUTS + 1][LANES];
  const double *given_at[INPUTS + 1];
  double *found_at[OUTPUTS + 1];
  long first = -1;
  for (int k = 0; k < INPUTS; ++k) given_at[k] = given[k];
  for (int k = 0; k < OUTPUTS; ++k) found_at[k] = found[k];
  const unsigned modes = without_tiny();
  prepare(numbers, fixed);
  for (long at = 0; at < n; at += LANES) {{
    const long m = n - at < LANES ? n - at : LANES;
    truth good;
    if (m == LANES) good = block(in, fixed, out, at);
    else {{
      for (int k = 0; k < INPUTS; ++k)
        for (int l = 0; l < LANES; ++l) given[k][l] = in[k][at + (l < m ? l : m - 1)];
      good = block(given_at, fixed, found_at, 0);
      for (int k = 0; k < OUTPUTS; ++k) memcpy(out[k] + at, found[k], m*sizeof(double));
    }}
    const long wrong = first_false(good);
    if (first < 0 && wrong >= 0) first = at + wrong;
  }}
  with_modes(modes);
  return first;
}}
"""


def c_source(
    inputs: Sequence[Expression], scalars: Sequence[Expression], outputs: Sequence[Expression]
) -> str:
    """C of ``long evaluate(long n, const double *const *in, const double *numbers, double *const *out)``.

    ``in`` and ``out`` are arrays of n nodal values each, in the order given; they may be the same. It
    returns the first node where an output is a false truth value, or -1: such outputs are conditions, and are
    not stored.

    Args:
        inputs: What is given at the nodes.
        scalars: What is given as numbers.
        outputs: What is computed.
    """
    outputs = with_few_divisions(outputs)
    nodes = outputs[0].graph.needed(outputs)
    varying: set[int] = set()
    for node in nodes:
        if node.op == "input" or any(a.index in varying for a in node.args):
            varying.add(node.index)
    stored = [o for o in outputs if not o.logical]
    conditions = [o for o in outputs if o.logical]
    names = {node.index: _constant(node) if node.op == "const" else f"x{node.index}" for node in nodes}
    places = {e.index: f"load(in[{i}] + at)" for i, e in enumerate(inputs)}
    places |= {e.index: f"all(numbers[{i}])" for i, e in enumerate(scalars)}

    def written(node: Expression) -> str:
        text = places.get(node.index) or _operation(node, [names[a.index] for a in node.args])
        return f"const {'truth' if node.logical else 'vec'} x{node.index} = {text};"

    once = [written(node) for node in nodes if node.index not in varying and node.op != "const"]
    used = {a.index: a for node in nodes if node.index in varying for a in node.args}
    used |= {o.index: o for o in outputs}
    fixed = [a for a in used.values() if a.index not in varying and a.op != "const"]
    for i, a in enumerate(fixed):
        value = f"where(x{a.index}, all(1.0), all(0.0))" if a.logical else f"x{a.index}"
        once.append(f"fixed[{i}] = first({value});")
        names[a.index] = f"lt(all(0.0), all(fixed[{i}]))" if a.logical else f"all(fixed[{i}])"
    each = [written(node) for node in nodes if node.index in varying]
    each += [f"store(out[{i}] + at, {names[o.index]});" for i, o in enumerate(stored)]
    good = "truth_of(1)"
    for o in conditions:
        good = f"and({good}, {names[o.index]})" if o is not conditions[0] else names[o.index]
    each.append(f"return {good};")
    return VECTORS + _EVALUATE.format(
        inputs=len(inputs),
        outputs=len(stored),
        fixed=len(fixed),
        once="\n  ".join(once),
        each="\n  ".join(each),
    )


def _constant(node: Expression) -> str:
    value = node.value
    if isinstance(value, bool):
        return f"truth_of({int(value)})"
    if value != value:
        return "all(NAN)"
    if value in (float("inf"), float("-inf")):
        return "all(INFINITY)" if value > 0 else "all(-INFINITY)"
    return f"all({value!r})"


def _operation(node: Expression, names: list[str]) -> str:
    op = node.op
    if op == "neg":
        return f"-{names[0]}"
    if op in _INFIX:
        return f"{names[0]} {_INFIX[op]} {names[1]}"
    return f"{_CALLS.get(op, op)}({', '.join(names)})"
