"""Pointwise formulas: what is traced, differentiated and compiled is what NumPy computes."""

import platform

import myostrain as ms
from myostrain.membranes import reaction, tracing
from myostrain.pointwise import Graph, Program, Untraceable, compiler, derivative, quotient_of_factors
from myostrain.pointwise.divisions import with_few_divisions

import numpy as np
import pytest

N = 203  # no multiple of what is computed together
RNG = np.random.default_rng(1)
WIDE = np.concatenate([RNG.uniform(-700, 700, N), RNG.normal(size=N), 1e-7 * RNG.normal(size=N)])
POSITIVE = np.concatenate([np.exp(RNG.uniform(-600, 600, N)), 1 + 1e-3 * RNG.normal(size=N)])
UNIT = np.tanh(RNG.normal(size=N))

#: Functions and samples on which they are compared.
FUNCTIONS = {
    "exp": (np.exp, WIDE),
    "expm1": (np.expm1, WIDE),
    "sinh": (np.sinh, WIDE),
    "cosh": (np.cosh, WIDE),
    "tanh": (np.tanh, WIDE),
    "log": (np.log, POSITIVE),
    "log1p": (np.log1p, np.abs(WIDE)),
    "sqrt": (np.sqrt, POSITIVE),
    "sin": (np.sin, WIDE),
    "cos": (np.cos, WIDE),
    "tan": (np.tan, UNIT),
    "arcsin": (np.arcsin, UNIT),
    "arccos": (np.arccos, UNIT),
    "arctan": (np.arctan, WIDE),
    "floor": (np.floor, WIDE),
    "ceil": (np.ceil, WIDE),
    "abs": (np.abs, WIDE),
    "power": (lambda x: x**2.7, POSITIVE[N:]),
    "inverse cube": (lambda x: x**-3, UNIT),
    "remainder": (lambda x: x % 3.0, WIDE[:N]),
    "clip": (lambda x: np.clip(x, -0.3, 0.6), UNIT),
    "minimum": (lambda x: np.minimum(x, x * x), UNIT),
    "where": (lambda x: np.where((x > 0.2) & ~(x >= 0.7) | (x < -0.8), 1 - x, x / 3), UNIT),
    "heaviside": (lambda x: np.heaviside(x, 0.5), UNIT),
    "of numbers": (lambda x: 2 - (3 / (x - 5) - x) * -1 + np.exp(1.5), UNIT),
}
COMPILERS = pytest.mark.parametrize("compiled", [True, False], ids=["C", "NumPy"])


@pytest.fixture
def without_compiler(monkeypatch):
    monkeypatch.setenv(compiler.SWITCH, "1")
    compiler.compiler.cache_clear()
    yield
    monkeypatch.undo()
    compiler.compiler.cache_clear()


@pytest.fixture
def runs(compiled, request):
    """Whether formulas run as C, which they do where there is a compiler and nobody forbids it."""
    if not compiled:
        request.getfixturevalue("without_compiler")
    return compiled


def evaluated(function, *arrays):
    graph = Graph()
    inputs = [graph.input(name) for name in "xyz"[: len(arrays)]]
    program = Program(inputs, [], [graph.lift(function(*inputs))])
    out = np.empty(len(arrays[0]))
    assert program(list(arrays), [], [out]) == -1
    return out, program


@COMPILERS
@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_are_those_of_numpy(name, runs):
    """Ours are exact to some units in the last place, from 1e-300 to 1e300."""
    function, x = FUNCTIONS[name]
    found, program = evaluated(function, x)
    assert program.compiled == runs
    np.testing.assert_allclose(found, function(x), rtol=2e-15, atol=1e-300 if name != "tan" else 1e-15)


@pytest.mark.skipif(platform.machine() != "x86_64", reason="the flags are those of x86")
@pytest.mark.parametrize("flag", ["-mno-avx512f", "-mno-avx"])
def test_functions_on_processors_with_narrower_vectors(flag, monkeypatch):
    """Vectors of eight, four and two numbers have code of their own."""
    monkeypatch.setenv("CC", f"gcc {flag}")
    compiler.compiler.cache_clear()
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    names = [name for name, (_, sample) in FUNCTIONS.items() if sample is UNIT]
    formulas = [FUNCTIONS[name][0] for name in names] + [np.exp, np.expm1, np.tanh, np.cosh, np.log, np.sqrt]
    given = [x] * len(names) + [y] * 6
    outputs = [graph.lift(formula(z)) for formula, z in zip(formulas, given, strict=True)]
    program = Program([x, y], [], [*outputs, (x < 0.5) | (y > 0.0)])
    monkeypatch.undo()
    compiler.compiler.cache_clear()
    assert program.compiled
    values = [UNIT, np.exp(RNG.uniform(-6, 6, N))]
    found = [np.empty(N) for _ in outputs]
    assert program(values, [], found) == -1
    for formula, z, out in zip(formulas, given, found, strict=True):
        np.testing.assert_allclose(out, formula(values[z is y]), rtol=2e-15, atol=1e-15)
    values[0][N - 2], values[1][N - 2] = 0.7, np.nan
    assert program(values, [], found) == N - 2


@COMPILERS
@pytest.mark.parametrize("function", [np.exp, np.expm1, np.log, np.tanh, np.sqrt])
def test_what_is_no_number_stays_none(function, runs):
    """A diverging run must show, whatever the compiler makes faster."""
    found, _ = evaluated(function, np.array([np.nan, 1.0]))
    assert np.isnan(found[0])
    assert np.isfinite(found[1])


def test_what_comes_out_does_not_depend_on_the_place_of_a_node():
    """On other numbers of processes nodes lie elsewhere among the others; the bits are the same."""

    def formula(x, y):
        return np.exp(x * y) / (1 + np.log(1 + y * y)) - np.tanh(x) ** 3

    x, y = RNG.normal(size=(2, N))
    whole, _ = evaluated(formula, x, y)
    for some in (slice(0, 1), slice(7, 71), slice(64, 129), slice(150, N)):
        part, _ = evaluated(formula, x[some].copy(), y[some].copy())
        np.testing.assert_array_equal(part, whole[some])


@COMPILERS
def test_the_first_node_where_a_condition_fails_is_told(runs):
    """The first node where a condition does not hold, -1 if they hold everywhere; NaN fails too."""
    graph = Graph()
    x = graph.input("x")
    program = Program([x], [], [2 * x, (x > 0) & (x < 5)])
    values, out = np.full(N, 1.0), np.empty(N)
    assert program([values], [], [out]) == -1
    np.testing.assert_array_equal(out, 2.0)
    for node in (N - 1, 130, 5):
        values[node] = np.nan if node == 130 else -1.0
        assert program([values], [], [out]) == node


@pytest.mark.parametrize("name", [n for n in FUNCTIONS if n not in ("heaviside", "floor", "ceil")])
def test_derivatives_are_those_of_differences(name):
    """In symbols, against central differences away from kinks and jumps."""
    function, _ = FUNCTIONS[name]
    graph = Graph()
    x = graph.input("x")
    slope = derivative(graph.lift(function(x)), x)
    at = np.array([0.31, 0.4567, 0.55])
    out = np.empty(len(at))
    Program([x], [], [slope])([at], [], [out])
    h = 1e-6
    np.testing.assert_allclose(out, (function(at + h) - function(at - h)) / (2 * h), rtol=1e-8, atol=1e-9)


def test_a_derivative_may_hold_what_it_does_not_see():
    """derivative: "Expressions that are taken as if they did not depend on it"."""
    graph = Graph()
    x = graph.input("x")
    inner = np.sin(x)
    out = [np.empty(1) for _ in range(2)]
    Program([x], [], [derivative(x * inner, x), derivative(x * inner, x, fixed=[inner])])(
        [np.array([0.7])], [], out
    )
    assert out[0][0] == pytest.approx(np.sin(0.7) + 0.7 * np.cos(0.7), rel=1e-14)
    assert out[1][0] == pytest.approx(np.sin(0.7), rel=1e-14)


def test_what_cannot_be_written_down_says_so():
    """A Python `if` on nodal values would take one way for all nodes."""
    x = Graph().input("x")
    with pytest.raises(Untraceable, match="use numpy"):
        bool(x > 0)
    with pytest.raises(Untraceable, match="interp"):
        np.interp(x, [0, 1], [0, 1])
    with pytest.raises(Untraceable, match="complex"):
        x.graph.lift(1j)


def test_formulas_are_written_once():
    """The current and the rates of a membrane share what they have in common."""
    x = Graph().input("x")
    assert np.exp(x / 3) is np.exp(x / 3)
    assert x * 2.0 + 1 is 1 + 2 * x
    assert (x - x).is_number(0)
    assert x**2 is x * x


def test_quotients_of_one_divisor_share_its_reciprocal():
    """Divisions of what is the same at all nodes are none at the nodes; one that is alone stays exact."""
    graph = Graph()
    x, y, c = graph.input("x"), graph.input("y"), graph.input("c", varies=False)
    alone, *shared = with_few_divisions([x / (1 + y), x / y, 2 / y, x / c])
    assert alone is x / (1 + y)
    for found, (above, below) in zip(shared, ((x, y), (2.0, y), (x, c)), strict=True):
        assert found is above * (1 / below)


def test_a_quotient_of_products_is_found_without_division():
    """The rate of a gate over its derivative is its distance from the steady state."""
    graph = Graph()
    s, v, c = (graph.input(name) for name in "svc")
    for speed in (np.exp(v), c / (1 + v), 0.3 * np.exp(v) / c, 1 / (c * v)):
        rate = (v - s) * speed
        assert quotient_of_factors(rate, derivative(rate, s)) is -(v - s)
    assert quotient_of_factors(rate, 2.0 * speed) is None
    assert quotient_of_factors((1 - s * v) * c, -v * c) is None


def test_a_compiler_that_fails_is_said_and_done_without(monkeypatch, tmp_path, caplog):
    """It runs, slower, with a warning that names the compiler."""
    broken = tmp_path / "broken-cc"
    broken.write_text("#!/bin/sh\necho no licence >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("CC", str(broken))
    compiler.compiler.cache_clear()
    try:
        found, program = evaluated(lambda x: np.exp(x) * 1.2345, np.array([1.0]))
    finally:
        monkeypatch.undo()
        compiler.compiler.cache_clear()
    assert not program.compiled
    assert found[0] == 1.2345 * np.e
    assert "broken-cc" in caplog.text
    assert "no licence" in caplog.text


MEMBRANES = [
    getattr(ms.membranes, name)()
    for name in ms.membranes.__all__
    if hasattr(getattr(ms.membranes, name), "current") and name not in ("Membrane", "FileMembrane")
]


@pytest.mark.parametrize("membrane", MEMBRANES, ids=lambda m: type(m).__name__)
def test_every_membrane_is_traced_with_its_parameters_as_numbers(membrane):
    """Another value of a parameter compiles nothing again: it is in the formulas by name."""
    found = tracing.traced(membrane)
    assert found is not None
    assert not found.as_numbers
    assert len(found.scalars) == len(tracing.parameters(membrane)) > 0


@pytest.mark.parametrize("membrane", MEMBRANES, ids=lambda m: type(m).__name__)
def test_the_slope_of_the_current_is_that_of_differences(membrane):
    """∂I/∂v for the states after the step, what the potential is linearised with."""
    low, high = membrane.range
    v = np.linspace(low, high, 9)[1:-1] + 0.0137 * (high - low)
    rest = np.array(membrane.resting_states(), dtype=float).reshape(-1, 1)
    states = np.tile(rest, len(v)) if len(rest) else np.zeros((0, len(v)))
    step = ms.membranes.Step(1e-9, 1e9, -1e9 * states, states, v, 1)
    new, current, slope, bad = reaction.Reaction(membrane).solve(v, states.copy(), step)
    assert bad == -1
    np.testing.assert_allclose(
        current, membrane.current(v, new), rtol=1e-9, atol=1e-9 * np.abs(current).max()
    )
    h = 1e-5 * (high - low)
    differences = (membrane.current(v + h, new) - membrane.current(v - h, new)) / (2 * h)
    np.testing.assert_allclose(slope, differences, rtol=1e-4, atol=1e-6 * np.abs(slope).max())


def test_other_flags_are_another_library(monkeypatch):
    """What the cache keeps was compiled with the flags that hold now."""
    source = "double evaluate(void) { return 1.0; }"
    before = compiler._compiled(source)
    assert before is not None
    assert compiler._compiled(source) == before
    monkeypatch.setattr(compiler, "FLAGS", (*compiler.FLAGS, "-DOTHER"))
    assert compiler._compiled(source) != before
