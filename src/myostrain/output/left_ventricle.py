"""The left ventricle, with the septum, of a body with two: what is of it, its axis, apex and depth."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from myostrain.engine import fem
from myostrain.geometry.harmonic import harmonic
from myostrain.output.wall import LowestNode, normal_of

import numpy as np
import numpy.typing as npt
import ufl

if TYPE_CHECKING:
    from myostrain.mechanics.equilibrium import Mechanics

Array = npt.NDArray[np.float64]

#: Boundaries of two ventricles.
LEFT, RIGHT, OUTER, BASE = "endocardium_left", "endocardium_right", "epicardium", "base"


class LeftVentricle:
    """The wall around the left cavity of two, told from the free wall of the right one.

    Two harmonic functions are 1 on the left endocardium; one is 0 on the right endocardium, the other one on
    the epicardium, and nothing holds it elsewhere. In the free wall of the left ventricle the first is nearly
    1, in the septum the second, in the free wall of the right one neither: what has both below a half is left
    out. So the septum is of the left ventricle, up to the right endocardium.

    The long axis is the mean outward normal of the base at rest; radial directions are along the gradient of
    the depth, which is 0 at the left endocardium and 1 at the right one and the epicardium.

    Args:
        mechanics: The mechanics of two ventricles.

    Attributes:
        axis: Unit vector (3,) of the long axis, from the apex to the base.
        apex_at_rest: The node (3,) of the left endocardium that is the lowest at rest.
        depth: The depth, P2.
        inside: One in the left ventricle and the septum, zero in the free wall of the right one, UFL.
    """

    def __init__(self, mechanics: Mechanics) -> None:
        body = mechanics.body
        self.axis: Array = normal_of(body, BASE)
        nodal = mechanics.displacement().function_space
        self.apex_at_rest: Array = LowestNode(body, nodal, LEFT, self.axis).rest
        space = fem.functionspace(body.mesh, ("Lagrange", 2))
        held = {
            part: fem.locate_dofs_topological(space, 2, body.boundary_facets([part]))
            for part in (LEFT, RIGHT, OUTER)
        }
        self.depth = harmonic(space, [(float(part != LEFT), dofs) for part, dofs in held.items()])
        near = [harmonic(space, [(1.0, held[LEFT]), (0.0, held[other])]) for other in (RIGHT, OUTER)]
        self.inside: Any = ufl.conditional(ufl.ge(ufl.max_value(*near), 0.5), 1.0, 0.0)
