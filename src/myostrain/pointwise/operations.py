"""The operations that a graph of formulas is made of, by name, and what they do to numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

#: Functions of one argument by the names of NumPy's.
FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    name: getattr(np, name)
    for name in (
        *("exp", "expm1", "log", "log1p", "sqrt", "sinh", "cosh", "tanh", "sin", "cos", "tan"),
        *("arcsin", "arccos", "arctan", "floor", "ceil", "abs"),
    )
}
COMPARISONS = ("lt", "le", "eq", "ne")
LOGIC = ("and", "or", "not")

#: NumPy's names of operations, as those of the graph.
UFUNCS = {
    "add": "add",
    "subtract": "sub",
    "multiply": "mul",
    "divide": "div",
    "power": "pow",
    "float_power": "pow",
    "negative": "neg",
    "minimum": "min",
    "maximum": "max",
    "fmin": "min",
    "fmax": "max",
    "less": "lt",
    "less_equal": "le",
    "greater": "gt",
    "greater_equal": "ge",
    "equal": "eq",
    "not_equal": "ne",
    "logical_and": "and",
    "bitwise_and": "and",
    "logical_or": "or",
    "bitwise_or": "or",
    "logical_not": "not",
    "invert": "not",
    "absolute": "abs",
    "square": "square",
    "reciprocal": "reciprocal",
    "positive": "positive",
    "heaviside": "heaviside",
    "mod": "mod",
    "remainder": "mod",
    **{name: name for name in FUNCTIONS},
}

#: What operations do to numbers.
COMPUTE: dict[str, Callable[..., Any]] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "neg": np.negative,
    "pow": np.power,
    "min": np.minimum,
    "max": np.maximum,
    "lt": np.less,
    "le": np.less_equal,
    "eq": np.equal,
    "ne": np.not_equal,
    "and": np.logical_and,
    "or": np.logical_or,
    "not": np.logical_not,
    "where": np.where,
    **FUNCTIONS,
}
