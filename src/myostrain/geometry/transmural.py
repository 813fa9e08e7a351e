"""What varies through the wall of a body."""

from __future__ import annotations

from myostrain.engine import fem, jit_options
from myostrain.errors import InputError
from myostrain.geometry.body import Body

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx.fem import petsc as fem_petsc

Array = npt.NDArray[np.float64]


def transmural(body: Body, ends: tuple[float, float], between: tuple[str, str] | None = None) -> Array:
    """A factor that is linear in the depth of the wall, at the nodes of P1 (nodes,).

    Args:
        body: The body.
        ends: The factor at the endocardium and at the epicardium.
        between: Parts of the boundary to take for them; see :func:`depth`.

    Raises:
        InputError: The body has not these parts, or they meet.
    """
    nodal = fem.Function(fem.functionspace(body.mesh, ("Lagrange", 1)))
    nodal.interpolate(depth(body, between))
    return ends[0] + (ends[1] - ends[0]) * nodal.x.array


def depth(body: Body, between: tuple[str, str] | None = None) -> fem.Function:
    """The depth in the wall, P2: harmonic, 0 at the endocardium and 1 at the epicardium.

    Args:
        body: The body.
        between: Parts of the boundary to take for them; all whose names begin with "endocardium" and
            "epicardium" unless given.

    Raises:
        InputError: The body has not these parts, or they meet.
    """
    key, known = "activation.transmural_between", body.meshed.boundaries
    names = [[name] for name in between or ()]
    if not names:
        names = [[n for n in known if n.startswith(start)] for start in ("endocardium", "epicardium")]
        if not all(names):
            raise InputError(
                f"name the two sides of the wall: this body has the boundaries {', '.join(known) or 'none'}",
                key,
            )
    space = fem.functionspace(body.mesh, ("Lagrange", 2))
    dofs = [
        fem.locate_dofs_topological(space, body.dim - 1, body.boundary_facets(side, key)) for side in names
    ]
    if body.comm.allreduce(len(np.intersect1d(*dofs))):
        raise InputError(f"the parts {names[0]} and {names[1]} of the boundary meet: there is no wall", key)
    u, w = ufl.TrialFunction(space), ufl.TestFunction(space)
    found = fem.Function(space, name="depth")
    fem_petsc.LinearProblem(
        ufl.inner(ufl.grad(u), ufl.grad(w)) * ufl.dx,
        fem.Constant(body.mesh, 0.0) * w * ufl.dx,
        bcs=[fem.dirichletbc(value, d, space) for value, d in zip((0.0, 1.0), dofs, strict=True)],
        u=found,
        petsc_options_prefix="myostrain_depth_",
        petsc_options={
            "ksp_type": "cg",
            "pc_type": "gamg",
            "ksp_rtol": 1e-12,
            "ksp_error_if_not_converged": True,
        },
        jit_options=jit_options(),
    ).solve()
    return found
