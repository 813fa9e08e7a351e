"""Loads, springs and dampers in the balance of forces, and values over time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from myostrain.course import FunctionOfTime, value_at
from myostrain.engine import fem
from myostrain.geometry import Body
from myostrain.mechanics.active_body import ActiveBody
from myostrain.mechanics.edge import thickness_factor
from myostrain.mechanics.loads import Loads, vector_at
from myostrain.mechanics.motion import Drift
from myostrain.mechanics.normals import smooth_normal
from myostrain.mechanics.support_factors import factor_on
from myostrain.mechanics.supports import AXES, Hold, Supports

import numpy as np
import numpy.typing as npt
import ufl

Array = npt.NDArray[np.float64]


class ExternalForces:
    """The outside's part of the balance of forces, and its values over time.

    A follower pressure p pushes with −p J F⁻ᵀ N per reference area, N the outward normal: its tangent is not
    symmetric in general. An elastic support pulls with −k u, or, if it resists along the normal only, with
    −k (u·N) N; a damper with −c v, or −c (v·N) N. Prescribed displacements go over time as the loads do.

    Args:
        body: The reference body.
        active: The equations of the body.
        u: The unknown.
        a: The activation.
        supports: What holds the body; its springs act here.
        loads: What pushes and pulls it.
        holds: Components of the displacement that are held.
        viscous: Whether the body is.
        motion: Has the velocity, where there are dampers.
        cavities: Parts of the boundary on which a pressure acts that is an unknown too.

    Attributes:
        residual: UFL form, to be added to that of the body; zero where nothing acts.
        symmetric: Whether its derivative is symmetric.
        pressures: The pressures that act, by part.
        unit_pressures: What a pressure of one adds to the residual, by part.
        springs: Stiffness, UFL, the parts (None for all), and the normal that they act along (None for all
            components), of elastic supports.
        stiffness: The sum of their stiffness, the largest in each part, at the beginning.

    Raises:
        InputError: An unknown part, or a vector of another dimension.
    """

    def __init__(
        self,
        body: Body,
        active: ActiveBody,
        u: fem.Function,
        a: fem.Function,
        supports: Supports,
        loads: Loads,
        holds: Sequence[Hold],
        viscous: bool,
        motion: Drift | None = None,
        cavities: Sequence[str] = (),
    ) -> None:
        kinematics, degree = active.kinematics, active.kinematics.degree
        mesh, w = body.mesh, active.displacement(u)
        normal, test = ufl.FacetNormal(mesh), ufl.derivative(w, u)
        loads.check_dimension(body.dim)
        along_normal = smooth_normal if supports.normals == "smooth" else lambda *_: normal
        self.residual: Any = 0
        if supports.robin_boundary is not None:
            body.boundary_facets(supports.robin_boundary, "mechanics.robin_boundary")
        self.springs: list[tuple[Any, Sequence[str] | None, Any]] = []
        self.stiffness = 0.0
        factors = {part: factor_on(body, part, f) for part, f in supports.support_factor.items()}
        #: What changes over time by its key: a constant of a form or condition, and its value at a time.
        self._courses: dict[str, tuple[fem.Constant, Callable[[float], Any]]] = {}
        self._timed_springs: list[fem.Constant] = []
        for parts, stiffness, along, key in supports.springs():
            factor = factors.get(parts[0]) if parts and len(parts) == 1 else None
            ds = body.boundary_measure(parts, 2 * degree + (factor is not None), key)
            if stiffness == 0:
                continue
            k: Any = fem.Constant(mesh, value_at(stiffness, 0.0))
            if isinstance(stiffness, FunctionOfTime):
                self._courses[key.removeprefix("mechanics.")] = k, stiffness.at
                self._timed_springs.append(k)
            self.stiffness += float(k.value)
            if factor is not None:
                k = k * factor
            outward = along_normal(body, parts) if along else None
            square = ufl.inner(w, w) if outward is None else ufl.dot(w, outward) ** 2
            self.residual += ufl.derivative(k / 2 * square * ds, u)
            self.springs.append((k, parts, outward))
        #: Coefficient, the velocity that it resists, and parts of dampers.
        self.dampers: list[tuple[Any, Any, Sequence[str]]] = []
        for part, coefficient, along, key in supports.dampers():
            assert motion is not None
            factor = factors.get(part)
            ds = body.boundary_measure([part], 2 * degree + (factor is not None), key)
            c: Any = fem.Constant(mesh, float(coefficient))
            if factor is not None:
                c = c * factor
            outward = along_normal(body, [part]) if along else normal
            v = ufl.dot(motion.velocity, outward) * outward if along else motion.velocity
            self.residual += c * ufl.inner(v, test) * ds
            self.dampers.append((c, v, [part]))
        tractions = {}
        for part, vector in loads.traction.items():
            ds = body.boundary_measure([part], 2 * degree, f"mechanics.traction.{part}")
            t = tractions[part] = fem.Constant(mesh, np.zeros(body.dim))
            self._courses[f"traction.{part}"] = t, partial(vector_at, vector)
            self.residual -= ufl.dot(t, test) * ds
        self.pressures: dict[str, fem.Constant] = {}
        self.unit_pressures: dict[str, Any] = {}
        for part, course in {**loads.pressure, **dict.fromkeys(cavities)}.items():
            key = "circulation.cavity" if course is None else f"mechanics.pressure.{part}"
            ds = body.boundary_measure([part], 2 * degree, key)
            p = self.pressures[part] = fem.Constant(mesh, 0.0)
            if course is not None:
                self._courses[f"pressure.{part}"] = p, partial(value_at, course)
            F = active.lifted(u, a)
            lifted = ufl.as_vector(
                [*(normal[i] for i in range(body.dim)), *([0] * (F.ufl_shape[0] - body.dim))]
            )
            area = ufl.det(F) * ufl.inv(F).T * lifted
            if kinematics.free_thickness and not viscous and part not in {hold.part for hold in holds}:
                others = tractions.get(part, ufl.as_vector([0.0] * body.dim))
                for k, parts, outward in self.springs:
                    if parts is None or part in parts:
                        others -= k * (w if outward is None else ufl.dot(w, outward) * outward)
                area *= thickness_factor(active, u, a, normal, p, others)
            self.unit_pressures[part] = sum(area[i] * test[i] for i in range(body.dim)) * ds
            self.residual += p * self.unit_pressures[part]
        if loads.body_force is not None:
            dx = ufl.dx(metadata={"quadrature_degree": 2 * degree})
            self.residual -= ufl.dot(loads.body_force, test) * dx
        for hold in holds:
            if hold.course is not None:
                key = f"displacement.{hold.part}.{AXES[hold.axis]}"
                self._courses[key] = hold.value, partial(value_at, hold.course)
        self.symmetric = not self.pressures

    @property
    def constants(self) -> list[fem.Constant]:
        """What the tangent depends on."""
        return [*self.pressures.values(), *self._timed_springs]

    def at(self, time: float) -> Array:
        """Loads and prescribed displacements at a time, one after the other."""
        values = (np.atleast_1d(value(time)) for _, value in self._courses.values())
        return np.concatenate([np.zeros(0), *values])

    def put(self, values: Array) -> None:
        """Let these act."""
        for (constant, _), part in zip(self._courses.values(), self._split(values), strict=True):
            constant.value = part.reshape(constant.value.shape)

    def _split(self, values: Array) -> list[Array]:
        sizes = [constant.value.size for constant, _ in self._courses.values()]
        return np.split(values, np.cumsum(sizes)[:-1]) if sizes else []

    def named(self, values: Array) -> dict[str, list[float]]:
        """Values in the order of :meth:`at` by their keys, for a state that other loads may go on from."""
        return {key: part.tolist() for key, part in zip(self._courses, self._split(values), strict=True)}

    def ordered(self, values: Mapping[str, list[float]]) -> Array:
        """The reverse; what the state does not know was zero."""
        parts = [values.get(key, [0.0] * constant.value.size) for key, (constant, _) in self._courses.items()]
        return np.array([value for part in parts for value in part])
