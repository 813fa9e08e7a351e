"""Elements of the mechanics, and the quadrature that fits them."""

from __future__ import annotations

from typing import Any

from myostrain.engine import fem
from myostrain.kinematics import Kinematics
from myostrain.solvers.linear import owned_dofs

import basix.ufl
import numpy as np
import numpy.typing as npt
import ufl

#: Degree of the quadrature by that of the displacement, as low as keeps the order of the elements: one point
#: for P1 (the gradient is constant, γ is taken at the centre), degree 3 for P2.
QUADRATURE_DEGREE = {1: 1, 2: 3}

#: The rule by the cell. On tetrahedra basix's own of degree 3 has a negative weight, −4/5 of the volume at
#: the centre: the integral of a convex energy is not convex, and Newton's method fails where the stiffness
#: changes from point to point. That of Xiao and Gimbutas (2010) has one point more, six, of positive weights.
QUADRATURE_RULE = {"tetrahedron": "xiao_gimbutas"}


def unknown_space(mesh: Any, kinematics: Kinematics) -> fem.FunctionSpace:
    """Displacement, and where there is one pressure (P1)."""
    cell = mesh.basix_cell()
    displacement = basix.ufl.element("Lagrange", cell, kinematics.degree, shape=(kinematics.dim,))
    if not kinematics.has_pressure:
        return fem.functionspace(mesh, displacement)
    return fem.functionspace(
        mesh, basix.ufl.mixed_element([displacement, basix.ufl.element("Lagrange", cell, 1)])
    )


def displacement_dofs(space: fem.FunctionSpace) -> npt.NDArray[np.int32]:
    """Degrees of freedom of the displacement in a mixed space that this process owns."""
    dofs = np.asarray(space.sub(0).collapse()[1], dtype=np.int32)
    return dofs[dofs < owned_dofs(space)]


def volume_measure(mesh: Any, kinematics: Kinematics, degree: int | None) -> ufl.Measure:
    """Measure of the reference body with a quadrature that fits the elements, or of a given degree."""
    metadata = {
        "quadrature_degree": QUADRATURE_DEGREE[kinematics.degree] if degree is None else degree,
        "quadrature_rule": QUADRATURE_RULE.get(mesh.topology.cell_type.name, "default"),
    }
    return ufl.Measure("dx", domain=mesh, metadata=metadata)
