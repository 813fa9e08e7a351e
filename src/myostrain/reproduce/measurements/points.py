"""Material points of the active body: its stored energy and the derivatives of it, many points at once."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

from myostrain import activation, materials
from myostrain.activation import FibreTension
from myostrain.engine import MPI, fem, jit_options
from myostrain.errors import ComputationError
from myostrain.geometry import Microstructure
from myostrain.kinematics import Solid
from myostrain.mechanics.active_body import ActiveBody
from myostrain.validation import with_constants

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx.mesh import create_interval
from ufl.algorithms import expand_derivatives, strip_variables

Array = npt.NDArray[np.float64]

#: Steps of Newton's method at most, and how long each is at most, in the logarithm of the stretch.
MOST, LONGEST = 120, 0.1

#: The unit tensor.
ONE = np.eye(3)

#: Fibre, sheet and normal are the axes.
AXES = Microstructure(*(ufl.as_vector([float(i == k) for i in range(3)]) for k in range(3)))


def material(parameters: Mapping[str, Any]) -> Any:
    """A material of the program by ``model``, a name of :mod:`myostrain.materials`, and its parameters."""
    others = dict(parameters)
    return getattr(materials, others.pop("model"))(**others)


def isochoric(stretch: Any) -> Array:
    """F (..., 3, 3) of stretches (...) along the fibre that keep the volume, with equal sides."""
    lam = np.asarray(stretch, dtype=float)
    return np.stack([lam, lam**-0.5, lam**-0.5], axis=-1)[..., None] * ONE


class Points:
    """The energy of the active body Jo W(F Fo⁻¹) + Ta/2 (I₄f − 1) at points, by F.

    It is what the mechanics of a solid stores, with Fo and Ta given at each point, and is differentiated by
    UFL; a point is a cell of an interval.

    Args:
        law: The passive material.
        most: How many points there are at a time, at most.
        bulk_modulus: κ of a nearly incompressible body; None for an incompressible one.
    """

    def __init__(self, law: Any, most: int, bulk_modulus: float | None = None) -> None:
        mesh = self._mesh = create_interval(MPI.COMM_SELF, most, [0.0, 1.0])
        self._cells, self.modulus = np.arange(most, dtype=np.int32), law.modulus
        tensors = fem.functionspace(mesh, ("DG", 0, (3, 3)))
        self._F, self._Fo = fem.Function(tensors), fem.Function(tensors)
        self._tension = fem.Function(fem.functionspace(mesh, ("DG", 0)))
        given = SimpleNamespace(tensor=lambda gamma, fibres: self._Fo)
        body: Any = SimpleNamespace(mesh=mesh, dim=3, fibres=AXES)
        solid = Solid(augmentation=0.0) if bulk_modulus is None else Solid(bulk_modulus=bulk_modulus)
        active = ActiveBody(body, solid, law, given, 0.0)

        def stored(F: Any) -> Any:
            return active.stored(F, 0.0) + FibreTension().energy(F, AXES, self._tension)

        # By two numbers and not by F twice: compiling the 81 components takes a minute and more.
        self._along = [fem.Constant(mesh, np.zeros((3, 3))) for _ in range(2)]
        s, t = (ufl.variable(fem.Constant(mesh, 0.0)) for _ in range(2))
        W = stored(self._F + s * self._along[0] + t * self._along[1])
        F = ufl.variable(self._F)
        self._stress = self._compiled(ufl.diff(stored(F), F))
        self._second = self._compiled(ufl.diff(ufl.diff(W, s), t))

    def _compiled(self, expression: Any) -> fem.Expression:
        # Labels of variables, counted by process, would make each one another kernel.
        plain = strip_variables(expand_derivatives(expression))
        return fem.Expression(plain, np.array([[0.5]]), jit_options=jit_options())

    def put(self, F: Array, Fo: Any = None, tension: Any = 0.0) -> None:
        """Set points: F (n, 3, 3), Fo, the unit tensor unless given, and Ta, each of n or one for all."""
        n = self._n = len(F)
        for function, values, shape in (
            (self._F, F, (3, 3)),
            (self._Fo, ONE if Fo is None else Fo, (3, 3)),
            (self._tension, tension, ()),
        ):
            cells = function.function_space.dofmap.list[:n, 0]
            table = function.x.array.reshape(len(self._cells), -1)
            table[cells] = np.broadcast_to(values, (n, *shape)).reshape(n, -1)

    def stress(self) -> Array:
        """P = ∂W/∂F, without a pressure, (n, 3, 3)."""
        return np.asarray(self._stress.eval(self._mesh, self._cells[: self._n])).reshape(-1, 3, 3)

    def moduli(self) -> Array:
        """A = ∂²W/∂F∂F, (n, 3, 3, 3, 3)."""
        A = np.empty((self._n, 9, 9))
        basis = np.eye(9).reshape(9, 3, 3)
        for i, k in zip(*np.triu_indices(9), strict=True):
            for constant, direction in zip(self._along, (basis[i], basis[k]), strict=True):
                constant.value[:] = direction
            A[:, i, k] = A[:, k, i] = self._second.eval(self._mesh, self._cells[: self._n]).reshape(-1)
        return A.reshape(-1, 3, 3, 3, 3)


def active_tensors(deformation: Mapping[str, Any], gamma: Array) -> Array:
    """Fo (n, 3, 3) of a deformation of the program, "kind" and its parameters, for γ (n,)."""
    others = dict(deformation)
    law = getattr(activation, others.pop("kind"))(**others)
    mesh = create_interval(MPI.COMM_SELF, len(gamma), [0.0, 1.0])
    field = fem.Function(fem.functionspace(mesh, ("DG", 0)))
    cells = field.function_space.dofmap.list[:, 0]
    field.x.array[cells] = gamma
    tensor = with_constants(law, mesh).tensor(field, AXES)
    found = fem.Expression(tensor, np.array([[0.5]]), jit_options=jit_options())
    return np.asarray(found.eval(mesh, np.arange(len(gamma), dtype=np.int32))).reshape(-1, 3, 3)


def free_stretches(
    points: Points, Fo: Array, held: Array | None = None, *, tension: Any = 0.0, pull: Any = 0.0
) -> Array:
    """Stretches (n, 3) along fibre, sheet and normal of free points that keep J = 1, by Newton's method.

    Args:
        points: The points; their F is left at what is found.
        Fo: Fo (n, 3, 3), diagonal.
        held: Stretches (n,) along the fibre where that is held and the sides are free.
        tension: Ta, a number or (n,).
        pull: A dead load along the fibre, per reference area, a number or (n,).

    Raises:
        ComputationError: No equilibrium is found.
    """
    logs = np.zeros((len(Fo), 3))
    # The volume is kept: what the normal does follows from the rest.
    ways = np.array([[1.0, 0.0, -1.0], [0.0, 1.0, -1.0]])
    if held is not None:
        logs[:, 0] = np.log(held)
        logs[:, 1:] = -logs[:, :1] / 2
        ways = ways[1:]
    before, longest = np.zeros((len(Fo), len(ways))), np.full(len(Fo), LONGEST)
    for _ in range(MOST):
        stretches = np.exp(logs)
        points.put(stretches[:, :, None] * ONE, Fo, tension)
        power = np.einsum("nii->ni", points.stress()) * stretches
        power[:, 0] -= pull * stretches[:, 0]
        stiffness = np.einsum("niijj->nij", points.moduli()) * stretches[:, :, None] * stretches[:, None, :]
        stiffness += power[:, :, None] * ONE
        values, vectors = np.linalg.eigh(ways @ stiffness @ ways.T)
        values = np.maximum(np.abs(values), 1e-3 * points.modulus)  # towards less energy
        step = -np.einsum("nij,nj,nkj,nk->ni", vectors, 1 / values, vectors, power @ ways.T)
        # Shorter where it turns back: stiffness may change by much from one step to the next.
        turned = (step * before).sum(axis=1) < 0
        longest = np.minimum(np.where(turned, longest / 2, 1.5 * longest), LONGEST)
        step *= np.minimum(1.0, longest / np.maximum(np.linalg.norm(step, axis=1), 1e-300))[:, None]
        before = step
        if np.abs(step).max() < 1e-10:
            return stretches
        logs += step @ ways
    raise ComputationError("free points find no equilibrium", advice="a smaller active strain.")


def held_force(points: Points, Fo: Array, stretch: Array, tension: Any = 0.0) -> Array:
    """Force (n,) per reference area along the fibre of points held at stretches (n,), sides free."""
    sides = free_stretches(points, Fo, stretch, tension=tension)
    stress = np.einsum("nii->ni", points.stress())
    return np.asarray(stress[:, 0] - stress[:, 2] * sides[:, 2] / sides[:, 0])


def tension_for(points: Points, stretch: Array) -> Array:
    """The tension Ta (n,) that shortens free passive points to the stretches (n,) along the fibre."""
    return -held_force(points, np.broadcast_to(ONE, (len(stretch), 3, 3)), stretch) / stretch
