"""Stress and stretch at the nodes: means over the cells around each, lumped."""

from __future__ import annotations

from typing import Any

from myostrain.engine import compile_form, fem
from myostrain.solvers.linear import assemble_nodal

import numpy as np
import numpy.typing as npt
import ufl

Array = npt.NDArray[np.float64]


class NodalFields:
    """Means ∫ f φ dX / ∫ φ dX of expressions f at the nodes of linear elements φ.

    Forms are compiled when they are first asked for.

    Args:
        space: Linear scalar elements.
        dx: The volume's measure.
    """

    def __init__(self, space: fem.FunctionSpace, dx: Any) -> None:
        self._test, self._dx = ufl.TestFunction(space), dx
        self._forms: dict[Any, fem.Form] = {}
        self._weight = assemble_nodal(compile_form(self._test * dx))

    def mean(self, name: Any, expression: Any) -> Array:
        """Nodal means of a scalar (nodes,), owned and ghosts; the name stands for the expression later on."""
        if name not in self._forms:
            self._forms[name] = compile_form(expression() * self._test * self._dx)
        return assemble_nodal(self._forms[name]) / self._weight
