"""What acts on a body from outside: elastic supports, follower pressures, body forces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from myostrain.course import Course, check_course, value_at
from myostrain.engine import fem
from myostrain.errors import InputError
from myostrain.geometry import Body
from myostrain.mechanics.active_body import ActiveBody

import numpy as np
import numpy.typing as npt
import ufl


class Loads:
    """The outside's part of the balance of forces, and its values over time.

    A follower pressure p pushes with −p J F⁻ᵀ N per reference area, N the outward normal: its tangent is not
    symmetric in general. An elastic support pulls with −k u, or, if it resists along the normal only, with
    −k (u·N) N.

    Args:
        body: The reference body.
        active: The equations of the body.
        u: The unknown.
        a: The activation.
        degree: Polynomial degree of the displacement.
        pressure: Pressures over time by named part of the boundary, positive towards the body.
        robin: Stiffness k of the elastic support: on ``robin_boundary``, or by named part; zero or more.
        robin_boundary: Named parts that a single ``robin`` acts on; all of the boundary unless given.
        robin_normal: Stiffness along the normal by named part.
        body_force: Dead load per reference volume, a UFL vector; None for none.

    Attributes:
        residual: UFL form, to be added to that of the body; zero where nothing acts.
        symmetric: Whether its derivative is symmetric.

    Raises:
        InputError: An unknown part, a stiffness that is none, or points that are no function of time.
    """

    def __init__(
        self,
        body: Body,
        active: ActiveBody,
        u: fem.Function,
        a: fem.Function,
        degree: int,
        *,
        pressure: Mapping[str, Course] | None,
        robin: float | Mapping[str, float],
        robin_boundary: Sequence[str] | None,
        robin_normal: Mapping[str, float] | None,
        body_force: Any,
    ) -> None:
        mesh, w = body.mesh, active.displacement(u)
        normal = ufl.FacetNormal(mesh)
        self.residual: Any = 0
        if robin_boundary is not None:
            body.boundary_facets(robin_boundary, "mechanics.robin_boundary")
        #: Elastic supports: the parts, and whether they resist along the normal only.
        self.supports: list[tuple[Sequence[str] | None, bool]] = []
        for parts, stiffness, along, key in _springs(robin, robin_boundary, robin_normal or {}):
            if not 0 <= stiffness < np.inf:
                raise InputError(f"{stiffness} is no stiffness: give zero or a positive number", key)
            if stiffness == 0:
                if parts is not None:
                    body.boundary_facets(parts, key)
                continue
            k = fem.Constant(mesh, float(stiffness))
            ds = body.boundary_measure(parts, 2 * degree, key)
            square = ufl.dot(w, normal) ** 2 if along else ufl.inner(w, w)
            self.residual += ufl.derivative(k / 2 * square * ds, u)
            self.supports.append((parts, along))
        self._courses = dict(pressure or {})
        self._pressures = [fem.Constant(mesh, 0.0) for _ in self._courses]
        for (part, course), p in zip(self._courses.items(), self._pressures, strict=True):
            key = f"mechanics.pressure.{part}"
            check_course(course, key)
            ds = body.boundary_measure([part], 2 * degree, key)
            F = active.lifted(u, a)
            lifted = ufl.as_vector(
                [*(normal[i] for i in range(body.dim)), *([0] * (F.ufl_shape[0] - body.dim))]
            )
            area = ufl.det(F) * ufl.inv(F).T * lifted
            test = ufl.derivative(w, u)
            self.residual += p * sum(area[i] * test[i] for i in range(body.dim)) * ds
        if body_force is not None:
            dx = ufl.dx(metadata={"quadrature_degree": 2 * degree})
            self.residual -= ufl.derivative(ufl.dot(body_force, w) * dx, u)
        self.symmetric = not self._courses

    @property
    def constants(self) -> list[fem.Constant]:
        """What the tangent depends on."""
        return self._pressures

    def at(self, time: float) -> npt.NDArray[np.float64]:
        """The pressures at a time, in the order of the parts given."""
        return np.array([value_at(course, time) for course in self._courses.values()])

    def put(self, values: npt.NDArray[np.float64]) -> None:
        """Let these pressures act."""
        for constant, value in zip(self._pressures, values, strict=True):
            constant.value = value

    def pressures(self) -> dict[str, float]:
        """The pressures that act, by named part."""
        return {part: float(p.value) for part, p in zip(self._courses, self._pressures, strict=True)}


def _springs(
    robin: float | Mapping[str, float],
    robin_boundary: Sequence[str] | None,
    robin_normal: Mapping[str, float],
) -> Iterator[tuple[Sequence[str] | None, float, bool, str]]:
    """Parts, stiffness, whether along the normal only, and key of each elastic support."""
    key = "mechanics.robin_boundary"
    if isinstance(robin, Mapping):
        if robin_boundary is not None:
            raise InputError("robin names its parts itself; leave this key out", key)
        for part, stiffness in robin.items():
            yield [part], stiffness, False, f"mechanics.robin.{part}"
    else:
        if robin_boundary is not None and not (len(robin_boundary) and robin > 0):
            raise InputError(
                f"{list(robin_boundary)} has no effect: name parts and give robin > 0, or leave it out", key
            )
        yield robin_boundary, robin, False, "mechanics.robin" if robin_boundary is None else key
    for part, stiffness in robin_normal.items():
        yield [part], stiffness, True, f"mechanics.robin_normal.{part}"
