"""What the wall of a ventricle does: it twists, thickens and shortens."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from myostrain.engine import MPI, compile_form, fem, lasting
from myostrain.errors import InputError
from myostrain.geometry import Body, depth
from myostrain.mechanics.cavity import Cavity
from myostrain.mechanics.quadrature import QuadraturePoints, integral

import numpy as np
import numpy.typing as npt
import ufl

if TYPE_CHECKING:
    from myostrain.mechanics.equilibrium import Mechanics

Array = npt.NDArray[np.float64]

#: Share of the height of the wall that the apical and the basal region have each.
REGION = 0.2

#: Degree of the quadrature in the regions, whose ends cut through cells.
DEGREE = 4


class Wall:
    """Twist, thickening and shortening of a left ventricle from rest.

    The long axis is the mean outward normal of the base at rest; heights are along it.

    - ``twist``, degrees: the rotation about the long axis of the apical region, the lowest fifth of the
      wall's height, less that of the basal region, the highest fifth; positive where the apex turns
      anticlockwise seen from the apex, as a healthy ventricle's does in systole. That is the sign and the
      difference of A. A. Young, B. R. Cowan, J. Cardiovasc. Magn. Reson. 14 (2012) 49,
      doi 10.1186/1532-429X-14-49. A region's rotation R is the one that fits its deformation best, by least
      squares over the reference volume (the orthogonal Procrustes problem), and twist the turn about the long
      axis within R(base)ᵀ R(apex) (its swing–twist decomposition), which no rigid motion of the body changes.
    - ``wall_thickening``: the mean over the reference wall of the transmural stretch, less one. That stretch
      is |F⁻ᵀ M|⁻¹, the ratio of the distances, deformed and at rest, of two surfaces of equal depth that are
      close to each other. M is normal to them, the direction of the gradient of the depth, which is harmonic,
      0 at the endocardium and 1 at the epicardium.
    - ``apex_endocardium``, ``apex_epicardium``: height of the deformed position of the mesh node of that
      boundary that is the lowest at rest; for a ventricle along Z its z, as in Land et al. 2015 (Proc. R.
      Soc. A 471: 20150641, doi 10.1098/rspa.2015.0641).
    - ``longitudinal_shortening``: of the distance from that endocardial apex to the mean of the rim of the
      endocardium, relative to the one at rest.

    Args:
        mechanics: The mechanics of the ventricle.
        displacement: Its displacement, UFL.
        cavity: Its cavity.

    Raises:
        InputError: A boundary is empty.

    Attributes:
        axis: Unit vector (3,) of the long axis, from the apex to the base.
        ends: Least and greatest height of the apical and of the basal region.
        depth: The harmonic depth.
    """

    names = ("twist", "longitudinal_shortening", "apex_endocardium", "apex_epicardium")

    def __init__(self, mechanics: Mechanics, displacement: Any, cavity: Cavity) -> None:
        self._mechanics, self._cavity = mechanics, cavity
        body = mechanics.body
        self.axis = normal_of(body, "base")
        low, high = _heights(body, self.axis)
        x = ufl.SpatialCoordinate(body.mesh) + displacement
        self.ends = [(low, low + REGION * (high - low)), (high - REGION * (high - low), high)]
        self._apical, self._basal = (_Region(body, x, self.axis, *end) for end in self.ends)
        space = mechanics.displacement().function_space
        self._apex = {
            name: LowestNode(body, space, name, self.axis) for name in ("endocardium", "epicardium")
        }
        self.depth = depth(body)
        self._length = float(np.linalg.norm(self._apex["endocardium"].rest - cavity.rim_at_rest))

    @property
    def apex_at_rest(self) -> Array:
        """The endocardial apex (3,) at rest."""
        return self._apex["endocardium"].rest

    def transmural_stretch(self, F: Any) -> Any:
        """|F⁻ᵀ M|⁻¹, UFL."""
        gradient = ufl.grad(self.depth)
        deformed = ufl.inv(F).T * gradient
        none = (1e-10 / self._length) ** 2  # where the depth has no direction, there is no stretch
        return ufl.sqrt((ufl.dot(gradient, gradient) + none) / (ufl.dot(deformed, deformed) + none))

    def values(self) -> list[float]:
        """All of :attr:`names` (collective)."""
        turn = self._basal.rotation().T @ self._apical.rotation()
        sine = [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
        # The quaternion of the turn is (1 + tr, sine) but for a factor. Seen from the apex: about −axis.
        twist = 2 * np.arctan2(-self.axis @ sine, 1 + np.trace(turn))
        u = self._mechanics.displacement().x.array.reshape(-1, 3)
        apex = {name: node.position(u) for name, node in self._apex.items()}
        length = np.linalg.norm(apex["endocardium"] - self._cavity.rim())
        heights = [float(self.axis @ position) for position in apex.values()]
        return [float(np.degrees(twist)), float(1 - length / self._length), *heights]


class _Region:
    """What of the wall has a height between two, and how it turns.

    Args:
        body: The reference body.
        x: Its deformed position, UFL.
        axis: Unit vector of the height.
        low: Least height.
        high: Greatest height.
    """

    def __init__(self, body: Body, x: Any, axis: Array, low: float, high: float) -> None:
        X = ufl.SpatialCoordinate(body.mesh)
        every = QuadraturePoints(body.mesh, DEGREE)
        places = every.values(X)()
        within = (places @ axis >= low) & (places @ axis <= high)
        some = within.any(axis=1)
        self._points = QuadraturePoints(body.mesh, DEGREE, every.cells[some])
        self._points.weights *= within[some]
        places = places[some]
        volume = self._points.integral(np.ones_like(self._points.weights))
        self._arms = places - self._points.integral(places) / volume
        self._x = self._points.values(x)

    def rotation(self) -> Array:
        """The rotation (3, 3) that fits x best, by least squares."""
        moment = self._points.integral(self._arms[..., :, None] * self._x()[..., None, :])
        left, _, right = np.linalg.svd(moment)
        proper = np.diag([1.0, 1.0, np.linalg.det(left @ right)])
        return np.asarray(right.T @ proper @ left.T)


class LowestNode:
    """The node of a boundary that is the lowest at rest, of equal ones that with the least X, then Y.

    Args:
        body: The reference body.
        space: Space of the nodal displacement.
        name: The boundary.
        axis: Unit vector of the height.

    Attributes:
        rest: Its position (3,) at rest.
    """

    def __init__(self, body: Body, space: fem.FunctionSpace, name: str, axis: Array) -> None:
        self._comm = lasting(body.mesh.comm)
        dofs = fem.locate_dofs_topological(space, 2, body.boundary_facets([name]))
        dofs = dofs[dofs < space.dofmap.index_map.size_local]
        places = space.tabulate_dof_coordinates()[dofs]
        low, high = body.extent()
        # Rounded: equal heights are to be told apart by the coordinates, whatever the numbering is.
        heights = np.round(places @ axis / np.linalg.norm(high - low), 9)
        order = np.lexsort((*places.T[::-1], heights))[:1]
        candidates = [(heights[i], *places[i].tolist(), self._comm.rank) for i in order]
        found = [entry for part in self._comm.allgather(candidates) for entry in part]
        if not found:
            raise InputError(f"the boundary '{name}' of this mesh is empty; rename it", "geometry")
        _, *rest, self._owner = min(found)
        self.rest = np.array(rest)
        self._dof = int(dofs[order[0]]) if self._owner == self._comm.rank else None

    def position(self, u: Array) -> Array:
        """Its position (3,) for nodal displacements (n, 3) (collective)."""
        mine = None if self._dof is None else u[self._dof]
        return np.asarray(self.rest + self._comm.bcast(mine, root=self._owner))


def normal_of(body: Body, name: str) -> Array:
    """Unit mean of a boundary's outward normal.

    Raises:
        InputError: It has none: there are no facets, or they are closed.
    """
    direction = fem.Constant(body.mesh, np.zeros(3))
    form = compile_form(ufl.dot(direction, ufl.FacetNormal(body.mesh)) * body.boundary_measure([name], 1))
    normal = np.zeros(3)
    for i in range(3):
        direction.value[:] = np.eye(3)[i]
        normal[i] = integral(form, lasting(body.mesh.comm))
    size = np.linalg.norm(normal)
    if not size > 0:
        raise InputError(
            f"the boundary '{name}' of this mesh is empty; rename it or name its facets", "geometry"
        )
    return normal / size


def _heights(body: Body, axis: Array) -> tuple[float, float]:
    """Least and greatest height of the body's nodes."""
    heights = body.mesh.geometry.x @ axis
    comm = lasting(body.mesh.comm)
    low = comm.allreduce(float(heights.min(initial=np.inf)), op=MPI.MIN)
    return low, comm.allreduce(float(heights.max(initial=-np.inf)), op=MPI.MAX)
