"""The preconditioner of large solids: multigrid for the displacement, a weighted mass for the pressure.

The tangent of an incompressible body is K = [[A, Bᵀ], [B, 0]]. It is preconditioned by the upper triangle of

    P = [[A + ∫ μ c′(u) c′(w), Bᵀ], [B, −∫ p q / (2μ)]],

where c is the constraint and μ a shear modulus of the present state. The term with c′ acts on changes of
volume only, and gives back to the first block the definiteness that the pressure takes from A; the mass
stands for the Schur complement, to which it is spectrally equivalent. An application is one cycle of
multigrid (smoothed aggregation with the rigid motions as near-null space) and one sweep with the mass. See
M. Benzi, G. H. Golub, J. Liesen, Acta Numerica 14 (2005) 1–137, sections 8 and 10,
doi 10.1017/S0962492904000212.
"""

from __future__ import annotations

from typing import Any

from myostrain.engine import PETSc, fem, lasting
from myostrain.solvers.linear import Options, owned_dofs

import numpy as np
import numpy.typing as npt

#: Unknowns of a solid from which this preconditioner is taken in place of a kept factorization, which was
#: several times as fast wherever both were measured, but whose memory grows faster than the unknowns.
LARGE = 500_000


def wanted(space: fem.FunctionSpace, unknowns: int, options: Options | None) -> bool:
    """Whether this preconditioner is taken: by size, or as the user says."""
    chosen = (options or {}).get("pc_type")
    if chosen is None:
        return space.mesh.geometry.dim == 3 and unknowns >= LARGE
    return chosen == ("fieldsplit" if space.num_sub_spaces and space.dofmap.index_map_bs == 1 else "gamg")


def defaults(space: fem.FunctionSpace) -> Options:
    """Options of the solver; a correction by it is a thousandth off."""
    multigrid: Options = {
        "pc_type": "gamg",
        "pc_gamg_threshold": -1.0,
        "mg_levels_ksp_type": "richardson",
        "mg_levels_ksp_max_it": 1,
        "mg_levels_pc_type": "sor",
    }
    krylov: Options = {
        "ksp_type": "gmres",
        "ksp_pc_side": "right",
        "ksp_rtol": 1e-3,
        "ksp_max_it": 200,
        "ksp_gmres_restart": 100,
    }
    if space.dofmap.index_map_bs > 1:
        return {**krylov, **multigrid}
    return {
        **krylov,
        "pc_type": "fieldsplit",
        "pc_fieldsplit_type": "schur",
        "pc_fieldsplit_schur_fact_type": "upper",
        "pc_fieldsplit_schur_precondition": "a11",
        "fieldsplit_u_ksp_type": "preonly",
        **{f"fieldsplit_u_{key}": value for key, value in multigrid.items()},
        "fieldsplit_p_ksp_type": "preonly",
        "fieldsplit_p_pc_type": "sor",
    }


def fields(space: fem.FunctionSpace, matrix: PETSc.Mat) -> list[tuple[str, PETSc.IS]]:
    """Global numbers of displacement and pressure that this process owns, the first with its rigid motions.

    Without a pressure there are none, and the matrix has the rigid motions.
    """
    block = space.dofmap.index_map_bs
    if block > 1:
        x = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local]
        matrix.setNearNullSpace(rigid_motions(x, block, lasting(space.mesh.comm)))
        return []
    found = []
    for number, name in enumerate("up"):
        part, dofs = space.sub(number).collapse()
        # Sorted, as PETSc wants them; the components of a node are neighbours in the mixed space.
        dofs = np.asarray(dofs).ravel()
        order = np.argsort(dofs)
        order = order[dofs[order] < owned_dofs(space)]
        first = space.dofmap.index_map.local_range[0]
        index = PETSc.IS().createGeneral((dofs[order] + first).astype(PETSc.IntType), comm=space.mesh.comm)
        block = part.dofmap.index_map_bs
        if block > 1:
            index.setBlockSize(block)
            x = part.tabulate_dof_coordinates()[order[::block] // block]
            index.compose("nearnullspace", rigid_motions(x, block, lasting(space.mesh.comm)))
        found.append((name, index))
    return found


def rigid_motions(x: npt.NDArray[np.float64], dim: int, comm: Any) -> PETSc.NullSpace:
    """Orthonormal translations and rotations of nodes.

    Args:
        x: Coordinates of the nodes that this process owns, (n, 3).
        dim: Components of the displacement.
        comm: The communicator.
    """
    modes = [np.tile(axis, (len(x), 1)) for axis in np.eye(dim)]
    for i in range(dim):
        for j in range(i):
            turn = np.zeros((len(x), dim))
            turn[:, i], turn[:, j] = x[:, j], -x[:, i]
            modes.append(turn)
    vectors: list[PETSc.Vec] = []
    for mode in modes:
        vector = PETSc.Vec().createMPI((mode.size, PETSc.DETERMINE), bsize=dim, comm=comm)
        vector.array[:] = mode.ravel()
        for _ in range(2):  # twice is enough, however far the body is from the origin
            for other in vectors:
                vector.axpy(-vector.dot(other), other)
            vector.normalize()
        vectors.append(vector)
    return PETSc.NullSpace().create(vectors=vectors, comm=comm)
