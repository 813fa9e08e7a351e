"""Diffusion and mass of the potential on a deforming body, in one matrix."""

from __future__ import annotations

from typing import Any, Literal

from myostrain.engine import PETSc, compile_form, fem
from myostrain.errors import InputError
from myostrain.geometry import Body
from myostrain.kinematics import Deformation
from myostrain.solvers.linear import assemble_nodal, owned_dofs
from myostrain.state import FieldState

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx.fem import petsc as fem_petsc
from ufl.algorithms import extract_coefficients

Mass = Literal["lumped", "averaged"]
"""Mass matrix: lumped at the nodes, or the mean of the lumped and the consistent one."""

Array = npt.NDArray[np.float64]


class Diffusion:
    """The matrix of diffusion, time derivative and linearised reaction.

    It is K + w M J + D: K the diffusion J F⁻¹ D F⁻ᵀ of the deformation at the last :meth:`update`, M the
    mass, J the volume ratio at the nodes, w the weight of the new value in the backward difference, and D
    the diagonal of the reaction.

    Args:
        body: The reference body.
        space: P1 space of the potential.
        deformation: F and J of the body, UFL expressions that somebody else updates.
        diffusivity: D along and across the fibre.
        mass: "lumped" or "averaged".

    Attributes:
        matrix: The matrix.
        conductivity: J F⁻¹ D F⁻ᵀ, a UFL expression.
        isochoric: Whether J = 1 by construction.
        symmetric: Whether the matrix is; the averaged mass on a body whose volume changes is not.
        weight: Lumped mass at the nodes (nodes,): what a node stands for of the reference body.
        ratio: J at the nodes (nodes,).
        assemblies: How often the diffusion was assembled since somebody counted.

    Raises:
        InputError: The deformation is of another mesh.
    """

    def __init__(
        self,
        body: Body,
        space: fem.FunctionSpace,
        deformation: Deformation,
        diffusivity: tuple[float, float],
        mass: Mass,
    ) -> None:
        mesh = body.mesh
        functions = [
            function
            for expression in (deformation.F, ufl.as_ufl(deformation.J))
            for function in extract_coefficients(expression)
            if isinstance(function, fem.Function)
        ]
        if any(function.function_space.mesh is not mesh for function in functions):
            raise InputError(
                "the deformation is of another mesh than the potential's: give that of "
                "NestedMesh(mechanics, refined(mechanics.body, levels))",
                "potential.refinement",
            )
        self.isochoric = deformation.isochoric
        self._space, self._owned = space, owned_dofs(space)
        trial, test = ufl.TrialFunction(space), ufl.TestFunction(space)
        # The order of linear elements needs F at the centre only; vertices lump the mass.
        degree = max(
            ufl.algorithms.estimate_total_polynomial_degree(deformation.F), 0 if self.isochoric else 1
        )
        dx = ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": degree})
        lumped = ufl.Measure(
            "dx", domain=mesh, metadata={"quadrature_rule": "vertex", "quadrature_degree": 1}
        )
        self.conductivity = pulled_back_conductivity(deformation, body.f0, *diffusivity, mesh)
        self._stiffness = compile_form(ufl.inner(self.conductivity * ufl.grad(trial), ufl.grad(test)) * dx)
        self.matrix = fem_petsc.create_matrix(self._stiffness)
        self._mass = _averaged_mass(trial, test, mesh, lumped) if mass == "averaged" else None
        # That of the deformed body, made once: on several processes PETSc frees nothing that Python drops.
        self._scaled_mass = None if self._mass is None or self.isochoric else self._mass.copy()
        self.symmetric = self._scaled_mass is None
        self._added = 0.0  # the multiple of the averaged mass in the matrix
        self._volume = None if self.isochoric else compile_form(deformation.J * test * lumped)
        self.weight: Array = assemble_nodal(compile_form(test * lumped))
        self.ratio: Array = np.ones_like(self.weight)
        self.assemblies = 0
        self._work, self._product = fem.Function(space), fem.Function(space)
        self._vector = self.matrix.createVecLeft()
        self._kept: Array = np.zeros(self._owned)  # the diagonal without the reaction
        self._refresh = deformation.refresh
        # Functions that the matrix depends on.
        self._body_fields = list(functions if deformation.follows is None else deformation.follows)

    def update(self) -> None:
        """Assemble diffusion and volume ratio on the present deformation."""
        self._assemble()
        if self._volume is not None:
            self.ratio = assemble_nodal(self._volume) / self.weight

    def _assemble(self) -> None:
        self.matrix.zeroEntries()
        fem_petsc.assemble_matrix(self.matrix, self._stiffness)
        self.matrix.assemble()
        self.assemblies += 1
        self._added = 0.0
        self._keep_diagonal()

    def _keep_diagonal(self) -> None:
        self.matrix.getDiagonal(self._vector)
        self._kept[:] = self._vector.array_r

    def put(self, weight: float, reaction: Array) -> Array:
        """Make the matrix that of a step.

        Args:
            weight: Weight of the new value in the backward difference.
            reaction: Derivative of the reaction in v at the nodes, times J and lumped mass (nodes,).

        Returns:
            What was added to the diagonal, reaction and lumped mass (nodes,).
        """
        diagonal = reaction
        if self._mass is None:
            diagonal = self.ratio * self.weight * weight + reaction
        else:
            self._add_mass(weight)
        self.put_diagonal(diagonal)
        return diagonal

    def put_diagonal(self, added: Array) -> None:
        """Set the diagonal to that without the reaction and what is added to it (nodes,)."""
        self._vector.array[:] = self._kept + added[: self._owned]
        self.matrix.setDiagonal(self._vector)

    def _add_mass(self, multiple: float) -> None:
        """Make the matrix hold this multiple of the averaged mass, beside the diffusion."""
        if self._mass is None or multiple == self._added:
            return
        if self._added:  # rather than a difference: a resumed run is to have the same bits
            self._assemble()
        mass = self._mass
        if self._scaled_mass is not None:
            same: Any = PETSc.Mat.Structure.SAME_NONZERO_PATTERN
            mass = self._mass.copy(self._scaled_mass, same)
            self._vector.array[:] = self.ratio[: self._owned]
            mass.diagonalScale(None, self._vector)
        self._vector.array[:] = self._kept
        self.matrix.setDiagonal(self._vector)
        self.matrix.axpy(multiple, mass, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        self._added = multiple
        self._keep_diagonal()

    def load(self, rate: Array) -> Array:
        """The mass times a rate (nodes,); a view of a work array where it is averaged."""
        if self._mass is None:
            return self.weight * rate
        self._work.x.array[:] = rate
        self._mass.mult(self._work.x.petsc_vec, self._product.x.petsc_vec)
        return self._product.x.array

    def rate(self, weight: float, v: Array) -> Array:
        """What diffusion adds to the rate of J v, −K v over the lumped mass (nodes,).

        Args:
            weight: Weight of the new value in the backward difference, as the matrix will have it.
            v: The potential (nodes,).
        """
        self.put(weight, np.zeros_like(v))
        rate = self.load(weight * self.ratio * v).copy()
        self._work.x.array[:] = v
        self.matrix.mult(self._work.x.petsc_vec, self._product.x.petsc_vec)
        self._product.x.array[:] = (rate - self._product.x.array) / self.weight
        self._product.x.scatter_forward()
        return self._product.x.array.copy()

    # What a kept preconditioner was made of, to make it again.

    def body(self) -> list[FieldState]:
        """The fields that the deformation depends on."""
        return [FieldState.of(function) for function in self._body_fields]

    def put_body(self, fields: list[FieldState]) -> None:
        """Give the deformation's fields these values."""
        for function, field in zip(self._body_fields, fields, strict=True):
            field.put(function)
        if self._refresh is not None:
            self._refresh()

    def put_again(self, weight: float, diagonal: Array) -> None:
        """Make the matrix again of what was added to the diagonal in :meth:`put`."""
        self.update()
        self._add_mass(weight)
        self.put_diagonal(diagonal)


def _averaged_mass(trial: Any, test: Any, mesh: Any, lumped: ufl.Measure) -> PETSc.Mat:
    """The mean of the lumped and the consistent mass matrix."""
    exact = ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": 2})
    matrix = fem_petsc.assemble_matrix(compile_form(trial * test / 2 * lumped + trial * test / 2 * exact))
    matrix.assemble()
    return matrix


def pulled_back_conductivity(
    deformation: Deformation, f0: Any, along: float, across: float, mesh: Any
) -> Any:
    """J F⁻¹ D F⁻ᵀ with D = across · 1 + (along − across) f⊗f and f the unit vector along F f0 (2.8)."""
    F = deformation.F
    C = F.T * F
    across_ = fem.Constant(mesh, across)
    conductivity = across_ * ufl.inv(C)
    if along != across:
        conductivity += (fem.Constant(mesh, along) - across_) / ufl.dot(f0, C * f0) * ufl.outer(f0, f0)
    return deformation.J * conductivity
