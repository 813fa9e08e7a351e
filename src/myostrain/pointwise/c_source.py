"""C of a pointwise formula: one loop over nodes that the compiler turns into vector instructions."""

from __future__ import annotations

from collections.abc import Sequence

from myostrain.pointwise.expressions import Expression
from myostrain.pointwise.operations import COMPARISONS

#: Nodes that are computed together. All nodes go through the same code, also the last ones, so that what
#: comes out does not depend on where a node lies among the others.
WIDTH = 64

#: Functions of our own: without branches, so that any compiler makes vector instructions of them.
MATHS = """\
#include <math.h>
#include <stdint.h>
#include <string.h>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

/* Small functions go into the loop; the others exist once, and compute several nodes a call. */
#define INLINE static inline __attribute__((always_inline))
#define LANES _Pragma("omp declare simd notinbranch") static __attribute__((noinline))

INLINE double bits_to_double(uint64_t b) { double x; memcpy(&x, &b, 8); return x; }
INLINE uint64_t double_to_bits(double x) { uint64_t b; memcpy(&b, &x, 8); return b; }

/* Truth values are masks of 64 bits, and choices are made by them: of a ?: a compiler would make a branch,
   and no vector instructions. */
typedef uint64_t truth;
INLINE truth mask(int c) { return c ? ~(truth)0 : (truth)0; }
INLINE double pick(truth m, double a, double b)
{
  return bits_to_double((double_to_bits(a) & m) | (double_to_bits(b) & ~m));
}

/* e^x = 2^n e^r with |r| <= ln(2)/2; e^r - 1 by its series, whose rest is below the rounding. */
INLINE double series_expm1(double r)
{
  double p = 1.0/6227020800.0;
  p = p*r + 1.0/479001600.0;
  p = p*r + 1.0/39916800.0;
  p = p*r + 1.0/3628800.0;
  p = p*r + 1.0/362880.0;
  p = p*r + 1.0/40320.0;
  p = p*r + 1.0/5040.0;
  p = p*r + 1.0/720.0;
  p = p*r + 1.0/120.0;
  p = p*r + 1.0/24.0;
  p = p*r + 1.0/6.0;
  p = p*r + 0.5;
  return p*r*r + r;
}
INLINE double reduce(double x, double *scale)
{
  x = x < -708.0 ? -708.0 : x;
  x = x > 709.0 ? 709.0 : x;
  const double shift = 6755399441055744.0; /* 1.5 * 2^52: its last bits count the unit */
  const double t = x*1.4426950408889634074 + shift, n = t - shift;
  *scale = bits_to_double((double_to_bits(t) << 52) + 0x3ff0000000000000ULL);
  return (x - n*6.93147180369123816490e-01) - n*1.90821492927058770002e-10;
}
LANES double own_exp(double x)
{
  double scale;
  const double r = reduce(x, &scale);
  return scale*series_expm1(r) + scale;
}
LANES double own_expm1(double x)
{
  double scale;
  const double r = reduce(x, &scale);
  return scale*series_expm1(r) + (scale - 1.0);
}
/* log x = n log 2 + 2 artanh((m - 1)/(m + 1)) with m between 1/sqrt(2) and sqrt(2). */
LANES double own_log(double x)
{
  const uint64_t b = double_to_bits(x) - 0x3fe6a09e667f3bcdULL;
  const double m = bits_to_double((b & 0xfffffffffffffULL) + 0x3fe6a09e667f3bcdULL);
  const double n = bits_to_double(((b + 0x4000000000000000ULL) >> 52) + 0x4330000000000000ULL)
                   - 4503599627371520.0;
  const double s = (m - 1.0)/(m + 1.0), q = s*s;
  double p = 2.0/23.0;
  p = p*q + 2.0/21.0;
  p = p*q + 2.0/19.0;
  p = p*q + 2.0/17.0;
  p = p*q + 2.0/15.0;
  p = p*q + 2.0/13.0;
  p = p*q + 2.0/11.0;
  p = p*q + 2.0/9.0;
  p = p*q + 2.0/7.0;
  p = p*q + 2.0/5.0;
  p = p*q + 2.0/3.0;
  const double y = n*6.93147180369123816490e-01 + ((2.0*s + s*q*p) + n*1.90821492927058770002e-10);
  return pick(mask(x > 0.0), y, pick(mask(x == 0.0), -INFINITY, NAN));
}
INLINE double own_pow(double x, double y) { return own_exp(y*own_log(x)); }
LANES double own_tanh(double x) { const double e = own_expm1(2.0*x); return e/(e + 2.0); }
LANES double own_sinh(double x)
{
  const double e = own_expm1(fabs(x));
  return copysign(0.5*(e + e/(e + 1.0)), x);
}
LANES double own_cosh(double x) { const double e = own_exp(x); return 0.5*(e + 1.0/e); }
LANES double own_log1p(double x)
{
  const double u = 1.0 + x;
  return own_log(u) - ((u - 1.0) - x)/u;
}
"""

_INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/", "lt": "<", "le": "<=", "eq": "==", "ne": "!="}
_INFIX |= {"and": "&", "or": "|"}
_CALLS = {"exp": "own_exp", "expm1": "own_expm1", "log": "own_log", "log1p": "own_log1p", "pow": "own_pow"}
_CALLS |= {"tanh": "own_tanh", "sinh": "own_sinh", "cosh": "own_cosh", "sqrt": "sqrt", "abs": "fabs"}
_CALLS |= {"arcsin": "asin", "arccos": "acos", "arctan": "atan"}


def c_source(
    inputs: Sequence[Expression],
    scalars: Sequence[Expression],
    outputs: Sequence[Expression],
    width: int = WIDTH,
) -> str:
    """C of ``long evaluate(long n, const double *const *in, const double *numbers, double *const *out)``.

    ``in`` and ``out`` are arrays of n nodal values each, in the order given; they may be the same. It
    returns the first node where an output is a false truth value, or -1: such outputs are conditions, and are
    not stored.

    Args:
        inputs: What is given at the nodes.
        scalars: What is given as numbers.
        outputs: What is computed.
        width: Nodes that are computed together.
    """
    graph = outputs[0].graph
    nodes = graph.needed(outputs)
    varying: set[int] = set()
    for node in nodes:
        if node.op == "input" or any(a.index in varying for a in node.args):
            varying.add(node.index)
    places = {e.index: f"in{i}[l]" for i, e in enumerate(inputs)}
    places |= {e.index: f"numbers[{i}]" for i, e in enumerate(scalars)}
    before = [f"const double *const in{i} = in[{i}];" for i in range(len(inputs))]
    before += [f"double *const out{i} = out[{i}];" for i, o in enumerate(outputs) if not o.logical]
    loop: list[str] = []
    for node in nodes:
        if node.op == "const":
            continue
        text = places[node.index] if node.op in ("input", "scalar") else _operation(node)
        line = f"const {'truth' if node.logical else 'double'} {_name(node)} = {text};"
        (loop if node.index in varying else before).append(line)
    stored = [o for o in outputs if not o.logical]
    conditions = [o for o in outputs if o.logical]
    loop += [f"out{i}[l] = {_name(o)};" for i, o in enumerate(stored)]
    loop.append(f"bad[l] = pick({' & '.join(map(_name, conditions))}, 0.0, 1.0);" if conditions else "")
    some = max(len(stored), 1)
    given = max(len(inputs), 1)
    body = "\n    ".join(loop)
    return f"""{MATHS}
enum {{ WIDTH = {width} }};

static long block(const double *const *in, const double *numbers, double *const *out)
{{
  double bad[WIDTH];
  {chr(10).join("  " + line for line in before).strip()}
  #pragma omp simd
  for (int l = 0; l < WIDTH; ++l) {{
    {body}
  }}
  {_search(bool(conditions))}
  return -1;
}}

long evaluate(long n, const double *const *in, const double *numbers, double *const *out)
{{
  double given[{given}][WIDTH], found[{some}][WIDTH];
  const double *from[{given}];
  double *to[{some}];
  long first = -1, here;
#ifdef __SSE2__
  /* Numbers below 1e-308 are taken for zero: processors are a hundred times slower with them. */
  const unsigned saved = _mm_getcsr();
  _mm_setcsr(saved | 0x8040);
#endif
  for (long b = 0; b < n; b += WIDTH) {{
    const long m = n - b < WIDTH ? n - b : WIDTH;
    for (int k = 0; k < {len(inputs)}; ++k) {{
      from[k] = in[k] + b;
      if (m < WIDTH) {{
        for (int l = 0; l < WIDTH; ++l) given[k][l] = in[k][b + (l < m ? l : m - 1)];
        from[k] = given[k];
      }}
    }}
    for (int k = 0; k < {len(stored)}; ++k) to[k] = m < WIDTH ? found[k] : out[k] + b;
    here = block(from, numbers, to);
    if (first < 0 && here >= 0) first = b + (here < m ? here : m - 1);
    if (m < WIDTH)
      for (int k = 0; k < {len(stored)}; ++k) memcpy(out[k] + b, found[k], m*sizeof(double));
  }}
#ifdef __SSE2__
  _mm_setcsr(saved);
#endif
  return first;
}}
"""


def _search(there: bool) -> str:
    if not there:
        return "(void)bad;"
    return """double any = 0.0;
  for (int l = 0; l < WIDTH; ++l) any = bad[l] > any ? bad[l] : any;
  if (any > 0.0)
    for (int l = 0; l < WIDTH; ++l)
      if (bad[l] > 0.0) return l;"""


def _name(node: Expression) -> str:
    if node.op == "const":
        if isinstance(node.value, bool):
            return f"mask({int(node.value)})"
        if node.value != node.value:
            return "NAN"
        if node.value in (float("inf"), float("-inf")):
            return "INFINITY" if node.value > 0 else "(-INFINITY)"
        return f"({node.value!r})" if node.value < 0 else repr(node.value)
    return f"x{node.index}"


def _operation(node: Expression) -> str:
    names = [_name(a) for a in node.args]
    op = node.op
    if op in COMPARISONS:
        return f"mask({names[0]} {_INFIX[op]} {names[1]})"
    if op in _INFIX:
        return f"{names[0]} {_INFIX[op]} {names[1]}"
    if op == "neg":
        return f"-{names[0]}"
    if op == "not":
        return f"~{names[0]}"
    if op == "where":
        return f"pick({', '.join(names)})"
    if op in ("min", "max"):
        return f"pick(mask({names[0]} {'<' if op == 'min' else '>'} {names[1]}), {names[0]}, {names[1]})"
    return f"{_CALLS.get(op, op)}({', '.join(names)})"
