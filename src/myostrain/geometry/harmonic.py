"""Solutions of Laplace's and Poisson's equation on a body, of which depths and directions are made."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from myostrain.engine import fem, jit_options
from myostrain.geometry.corners import corners

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx.fem import petsc as fem_petsc


def harmonic(
    space: fem.FunctionSpace,
    held: Sequence[tuple[float, npt.NDArray[np.int32]]],
    source: float = 0.0,
) -> fem.Function:
    """The function with −Δu = source that has given values at some nodes, and no flux elsewhere.

    By conjugate gradients with the diagonal, to a residual of 1e-12. That is not the fastest way, but few or
    bad cells do not break it, as they break an algebraic multigrid.

    Args:
        space: A scalar Lagrange space.
        held: Values, and the local nodes that have them; of a node that has several, the last.
        source: The source.
    """
    mesh = space.mesh
    u, w = ufl.TrialFunction(space), ufl.TestFunction(space)
    found = fem.Function(space)
    fem_petsc.LinearProblem(
        ufl.inner(ufl.grad(u), ufl.grad(w)) * ufl.dx,
        fem.Constant(mesh, source) * w * ufl.dx,
        bcs=[fem.dirichletbc(value, nodes, space) for value, nodes in held],
        u=found,
        petsc_options_prefix="myostrain_harmonic_",
        petsc_options={
            "ksp_type": "cg",
            "pc_type": "jacobi",
            "ksp_rtol": 1e-12,
            "ksp_max_it": 100_000,
            "ksp_error_if_not_converged": True,
        },
        jit_options=jit_options(),
    ).solve()
    return found


def gradients(u: fem.Function) -> tuple[Any, Any]:
    """Values (cells, dim + 1) of a P1 function at the corners of each cell, and its gradient (cells, dim).

    The gradient is that in the straight cell between the corners.
    """
    mesh = u.function_space.mesh
    x = corners(mesh)
    values = u.x.array[u.function_space.dofmap.list]
    return values, np.linalg.solve(x[:, 1:] - x[:, :1], (values[:, 1:] - values[:, :1])[..., None])[..., 0]
