"""Stress, stretch and displacement at the nodes of linear elements."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations_with_replacement
from typing import Any

from myostrain.engine import compile_form, fem
from myostrain.mechanics.active_body import ActiveBody
from myostrain.mechanics.recovery import Recovery
from myostrain.solvers.linear import assemble_nodal

import numpy as np
import numpy.typing as npt
import ufl
from ufl.algorithms import expand_derivatives, expand_indices
from ufl.constantvalue import Zero

Array = npt.NDArray[np.float64]


class NodalFields:
    """Fields of the present configuration at the nodes of linear elements.

    Stress and stretch are fitted (:class:`~myostrain.mechanics.recovery.Recovery`), of second order at every
    node. What goes back into the equations are means ∫ f φ dX / ∫ φ dX over linear elements φ, which amplify
    nothing. All is compiled when it is first asked for.

    Args:
        active: The equations of the body.
        u: The unknown.
        a: The activation.
        rate: Rate of the viscous strain, None for an elastic body.
        f0: The fibre's direction.
        dx: The volume's measure.

    Attributes:
        cauchy: The Cauchy stress, UFL.
        pressure: The pressure in it that the constraint adds, UFL; zero where there is no constraint.
        F: The deformation gradient in the dimension that materials see, UFL.
    """

    def __init__(
        self, active: ActiveBody, u: fem.Function, a: fem.Function, rate: Any, f0: Any, dx: Any
    ) -> None:
        self._active, self._u, self._a, self._f0, self._dx = active, u, a, f0, dx
        self.cauchy, self.pressure = active.cauchy(u, a, rate), active.pressure(u, a, rate)
        self.F = active.lifted(u, a)
        self._test = ufl.TestFunction(a.function_space)
        self._weight = assemble_nodal(compile_form(self._test * dx))
        self._forms: dict[str, fem.Form | None] = {}
        self._recovery: Recovery | None = None
        self._fits: dict[str, Callable[[], Array]] = {}
        self._displacement: fem.Function | None = None

    def stress(self) -> Array:
        """The Cauchy stress (nodes, n, n), n = 3, or 1 on a line."""
        n = self._active.kinematics.tensor_dim
        pairs = list(combinations_with_replacement(range(n), 2))
        found = self._fitted("stress", ufl.as_vector([self.cauchy[pair] for pair in pairs]))
        sigma = np.empty((len(found), n, n))
        for (i, j), component in zip(pairs, found.T, strict=True):
            sigma[:, i, j] = sigma[:, j, i] = component
        return sigma

    def scalar(self, name: str, expression: Any) -> Array:
        """Nodal means (nodes,) of a UFL scalar of the present configuration, known by a name."""
        return self._mean(name, expression)

    def stress_trace(self) -> Array:
        """Trace of the Cauchy stress (nodes,)."""
        return self._fitted("stress trace", ufl.tr(self.cauchy))[:, 0]

    def mean_stress_without_pressure(self) -> fem.Function:
        """Mean normal stress on the mesh's axes that energy and viscosity give, P1."""
        stress, dim = self._active.cauchy_without_pressure(self._u, self._a), self._active.kinematics.dim
        mean = fem.Function(self._a.function_space)
        mean.x.array[:] = self._mean("mean stress", sum(stress[i, i] for i in range(dim)) / dim)
        return mean

    def fibre_stretch(self) -> Array:
        """Stretch of the fibre, |F f0| (nodes,)."""
        return self._fitted("fibre stretch", self._stretch)[:, 0]

    def mean_fibre_stretch(self) -> Array:
        """Means of the stretch of the fibre (nodes,), which activation laws see."""
        return self._mean("fibre stretch", self._stretch)

    @property
    def _stretch(self) -> Any:
        along = self._active.gradient(self._u) * self._f0
        return ufl.sqrt(ufl.dot(along, along))

    def displacement(self, values: Array | None = None) -> fem.Function:
        """The displacement as a P1 vector function; the unknown itself where that is one.

        Args:
            values: Of the unknown, in place of the present ones: such as a velocity.
        """
        kinematics, unknown = self._active.kinematics, self._u
        if values is not None:
            unknown = fem.Function(unknown.function_space)
            unknown.x.array[:] = values
        if kinematics.degree == 1:
            return unknown
        if self._displacement is None:
            mesh = self._u.function_space.mesh
            space = fem.functionspace(mesh, ("Lagrange", 1, (kinematics.dim,)))
            self._displacement = fem.Function(space, name="displacement")
        self._displacement.interpolate(unknown.sub(0) if kinematics.has_pressure else unknown)
        return self._displacement

    def _fitted(self, name: str, expression: Any) -> Array:
        """Fitted values (nodes, components) of a scalar or vector, owned and ghosts."""
        if self._recovery is None:
            self._recovery = Recovery(self._a.function_space)
        if name not in self._fits:
            self._fits[name] = self._recovery.prepare(expression)
        return self._fits[name]()

    def _mean(self, name: str, expression: Any) -> Array:
        """Nodal means of a scalar, owned and ghosts."""
        if name not in self._forms:
            # Of zero, as E across a sheet in plane strain, there is no form. A solid takes minutes to expand.
            sheet = self._active.kinematics.dim < 3
            zero = sheet and isinstance(expand_indices(expand_derivatives(expression)), Zero)
            self._forms[name] = None if zero else compile_form(expression * self._test * self._dx)
        form = self._forms[name]
        return np.zeros(len(self._weight)) if form is None else assemble_nodal(form) / self._weight
