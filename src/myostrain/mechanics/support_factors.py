"""Supports that vary within a part of the boundary: factors on stiffness and damping by place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any

from myostrain.engine import MPI, fem, lasting
from myostrain.errors import InputError, shown
from myostrain.geometry import Body
from myostrain.validation import Finite, NonNegative, checked, description

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

KEY = "mechanics.support_factor"


@description
class SupportProfile:
    """A factor on the stiffness and damping of a part, by the place along a direction.

    Args:
        axis: The direction, of any length; heights are X · axis over that length, X at rest.
        points: Points (height, factor) with ascending heights, joined by straight lines. Below the first and
            above the last one the factor is theirs.
    """

    axis: tuple[Finite, ...]
    points: tuple[tuple[Finite, NonNegative], ...]

    def __post_init__(self) -> None:
        """Refuse what is no direction, or no function of the height."""
        if not np.linalg.norm(self.axis) > 0:
            raise ValueError("give axis a direction that is not zero")
        if not self.points or any(b <= a for (a, _), (b, _) in pairwise(self.points)):
            raise ValueError("give points [height, factor] with ascending heights")

    def __call__(self, X: Array) -> Array:
        """Factors (n,) at points X (n, dim)."""
        heights, factors = np.array(self.points).T
        return np.interp(X @ np.array(self.axis) / np.linalg.norm(self.axis), heights, factors)


def checked_factors(given: Any, parts: set[str]) -> dict[str, Callable[[Array], Array]]:
    """Factors by part: profiles, checked, and functions of a script.

    Args:
        given: What was given.
        parts: The parts that have springs or dampers of their own.

    Raises:
        InputError: Something is neither, or is on a part without springs and dampers.
    """
    functions = {}
    if isinstance(given, Mapping):
        functions = {
            name: f for name, f in given.items() if callable(f) and not isinstance(f, SupportProfile)
        }
        given = {name: f for name, f in given.items() if name not in functions}
    found = checked(Mapping[str, SupportProfile], given, KEY) | functions
    for part in sorted(found.keys() - parts):
        raise InputError(
            f"this has no effect, as there is no spring or damper of '{part}' by name: give one, such as "
            f"robin_normal = {{ {part} = 0.1 }}",
            f"{KEY}.{part}",
        )
    return found


def factor_on(body: Body, part: str, function: Callable[[Array], Array]) -> fem.Function:
    """The factor at the nodes of a part, linear between them (collective).

    Args:
        body: The reference body.
        part: Name of the part.
        function: Takes points X (n, dim) at rest and gives factors (n,), zero or more.

    Raises:
        InputError: It raises, gives something else, has another dimension, or is zero on all of the part.
    """
    space, comm = fem.functionspace(body.mesh, ("Lagrange", 1)), lasting(body.comm)
    made = fem.Function(space, name="support_factor")
    key = f"{KEY}.{part}"
    if isinstance(function, SupportProfile) and len(function.axis) != body.dim:
        raise InputError(f"give as many numbers as the body has coordinates, {body.dim}", f"{key}.axis")
    dofs = fem.locate_dofs_topological(space, body.dim - 1, body.boundary_facets([part], key))
    X = space.tabulate_dof_coordinates()[dofs, : body.dim]
    problem, values = "", np.zeros(0)
    if len(X):
        try:
            values = np.asarray(function(X.copy()), dtype=float)
        except Exception as error:  # noqa: BLE001 - whatever the script raises
            problem = f"raises {type(error).__name__}: {error}; it is given points of shape (n, {body.dim})"
        if not problem:
            problem = _wrong(values, X)
    # All processes raise the same, or none.
    if found := next(filter(None, comm.allgather(problem)), ""):
        raise InputError(found, key)
    if not comm.allreduce(float(values.max(initial=0.0)), MPI.MAX) > 0:
        raise InputError("it is zero on all of the part; leave the support out", key)
    made.x.array[dofs] = values
    made.x.scatter_forward()
    return made


def _wrong(values: Array, X: Array) -> str:
    if values.shape != X.shape[:1]:
        return f"gives the shape {values.shape} for points {X.shape}; give one number per point"
    bad = np.flatnonzero(~(np.isfinite(values) & (values >= 0)))
    if len(bad):
        where = [float(f"{x:.6g}") for x in X[bad[0]]]
        return f"is {shown(float(values[bad[0]]))} at {where}; give a finite number, zero or more"
    return ""
