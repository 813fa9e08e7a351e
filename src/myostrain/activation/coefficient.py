"""Numbers of an activation that a script may give as fields."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import PlainValidator
from ufl.core.expr import Expr


def _finite(value: Any) -> float | Expr:
    if isinstance(value, Expr):
        if value.ufl_shape != ():
            raise ValueError(f"a field given here is a scalar, not of shape {value.ufl_shape}")
        return value
    if isinstance(value, bool) or not isinstance(value, float | int | np.floating):
        raise ValueError("give a number")
    if not np.isfinite(value):
        raise ValueError("this should be a finite number")
    return float(value)


#: A number, or a UFL scalar on the body's mesh.
Coefficient = Annotated[float | Expr, PlainValidator(_finite)]
