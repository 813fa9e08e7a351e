"""The unloaded reference of a body whose geometry is known under load, as images show a heart."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from myostrain.engine import MPI, fem, jit_options, lasting
from myostrain.errors import ComputationError, InputError
from myostrain.geometry import Body, Microstructure
from myostrain.geometry.corners import is_curved
from myostrain.geometry.laplace_fibres import orthonormal
from myostrain.mechanics.equilibrium import Mechanics
from myostrain.mechanics.loads import Loads
from myostrain.mechanics.supports import Supports
from myostrain.solvers.anderson import Anderson
from myostrain.solvers.linear import largest

import basix
import basix.ufl
import numpy as np
import numpy.typing as npt
import ufl

Array = npt.NDArray[np.float64]

#: Past corrections that are combined.
MEMORY = 5
#: The smallest share of a correction that is tried, and how far a cell may shrink.
SMALLEST, THIN = 2.0**-6, 1e-3
#: How often the smooth normals of supports are taken anew.
PASSES = 6


def unloaded(
    body: Body, pressures: Mapping[str, float], *, within: float = 1e-6, most: int = 80, **parts: Any
) -> Body:
    """The body that has the given shape where the pressures act on it.

    With x the given nodes, the fixed point X ← x − u(X) is iterated, where u(X) is the displacement of the
    body of nodes X under the pressures (M. Sellier, J. Fluids Struct. 27 (2011) 1461–1470, doi
    10.1016/j.jfluidstructs.2011.08.002), with Anderson's acceleration. A correction that would invert a cell,
    or whose body is in no equilibrium, is halved.

    Fibres and sheets are given on the loaded body too, and are carried back with it: f₀ is along F⁻¹ f.
    Springs are relaxed in the unloaded body.

    Args:
        body: The loaded body, a solid. Its mesh is moved to the reference; where there is none, it is not.
        pressures: The pressures that act on it, by named part of the boundary.
        within: Largest distance of a node under load from the given one at the end, as a share of the
            body's diagonal.
        most: Corrections at most.
        parts: What :class:`Mechanics` is given: kinematics, material, supports, other loads (at time 0),
            options. What has to do with motion is left out.

    Returns:
        The unloaded body, on the same mesh.

    Raises:
        InputError: The body is not a solid, no pressure acts, or rigid motions are free.
        ComputationError: No reference was found: the wall is too soft for these pressures.
    """
    if body.dim != 3:
        raise InputError("only a solid has cavities: leave it out", "circulation.unload")
    if is_curved(body.mesh):
        raise InputError(
            "this is done for straight cells only: give geometry.order = 1, or leave it out",
            "circulation.unload",
        )
    if not any(pressure > 0 for pressure in pressures.values()):
        raise InputError(
            "no pressure acts at the beginning, so that the geometry is unloaded already: give a preload, or "
            "leave it out",
            "circulation.unload",
        )
    kept = {
        k: v for k, v in parts.items() if k not in ("cavities", "viscosity", "relaxation_time", "density")
    }
    supports: Supports = kept.pop("supports", None) or Supports()
    loads: Loads = kept.pop("loads", None) or Loads()
    springs = {name for names, *_ in supports.springs() for name in names or ()}
    factors = {part: factor for part, factor in supports.support_factor.items() if part in springs}
    kept |= {
        "supports": dataclasses.replace(supports, damping={}, damping_normal={}, support_factor=factors),
        "loads": dataclasses.replace(loads, pressure={**loads.pressure, **pressures}),
    }
    image, carried = body.mesh.geometry.x.copy(), _Carried(body)
    moved, left, diagonal = Body(body.meshed, carried.directions), most, _diagonal(body)
    try:
        for _ in range(PASSES):
            mechanics = Mechanics(moved, **kept)
            if mechanics.pins:
                raise InputError(
                    "nothing says where the unloaded body is, as rigid motions are free: give robin > 0, for "
                    "example at the base",
                    "circulation.unload",
                )
            search = _Search(mechanics, carried, image, diagonal)
            if search.off <= within:
                return moved
            left = search.run(within, left, most)
        raise ComputationError(f"after {PASSES} passes it is still {search.off:.2g} of the diagonal off")
    except ComputationError as error:
        body.mesh.geometry.x[:] = image
        raise ComputationError(
            f"no unloaded reference was found: {error.reason}",
            where=error.where,
            advice="a smaller preload, a stiffer material, more supports; or circulation.unload = false.",
        ) from error


class _Search:
    """The fixed point for one set of smooth normals.

    Args:
        mechanics: The body under the pressures.
        carried: The directions, which follow the mesh.
        image: The given nodes (n, 3).
        diagonal: The body's.

    Attributes:
        off: Distance from the given nodes, as a share of the diagonal.
    """

    def __init__(self, mechanics: Mechanics, carried: _Carried, image: Array, diagonal: float) -> None:
        self._mechanics, self._carried, self._image, self._diagonal = mechanics, carried, image, diagonal
        mesh = mechanics.body.mesh
        self._comm, self._x = lasting(mesh.comm), mesh.geometry.x
        self._owned = slice(0, 3 * mesh.geometry.index_map().size_local)
        self._node = np.empty(len(self._x), dtype=np.int64)
        space = mechanics.displacement().function_space
        self._node[mesh.geometry.dofmaps[0].ravel()] = space.dofmap.list.ravel()
        mechanics.start(0.0)
        self._measure()

    def _measure(self) -> None:
        u = self._mechanics.displacement().x.array.reshape(-1, 3)[self._node]
        self._correction = self._image - u - self._x
        self.off = largest(self._correction.ravel()[self._owned], self._comm) / self._diagonal

    def run(self, within: float, left: int, most: int) -> int:
        """Correct the nodes until they are off by that share at most; how many corrections are left.

        Raises:
            ComputationError: That many were not enough, or there is no equilibrium.
        """
        mixing = Anderson(MEMORY, self._owned, self._comm)
        while self.off > within:
            if not left:
                raise ComputationError(
                    f"after {most} corrections nodes are still {self.off:.2g} of the diagonal off"
                )
            step = mixing.step(self._x.ravel().copy(), self._correction.ravel().copy()).reshape(-1, 3)
            if not self._go(step):
                mixing.clear()
            left -= 1
        return left

    def _go(self, step: Array) -> bool:
        """Move the nodes by a step, or the largest share of it that does; whether it was all of it."""
        nodes, u, share = self._x.copy(), self._mechanics.u.x.array.copy(), 1.0
        while True:
            self._x[:] = nodes + share * step
            thinnest = self._carried.follow()
            try:
                if not thinnest > THIN:
                    raise ComputationError("cells of the unloaded body would be inverted")
                self._mechanics.solve(0.0, predict=False)
            except ComputationError:
                share /= 2
                self._mechanics.u.x.array[:] = u
                if share < SMALLEST:
                    raise
                continue
            self._measure()
            return share == 1.0


class _Carried:
    """Fibres and sheets that are carried along with a mesh whose nodes move.

    Attributes:
        directions: The directions on the mesh as it is.
    """

    def __init__(self, body: Body) -> None:
        self._mesh, self._comm = body.mesh, lasting(body.mesh.comm)
        self._image = self._edges()
        cell = self._mesh.topology.cell_type.name
        inner = basix.LagrangeVariant.gl_centroid  # within the cells: at an apex there may be no direction
        element = basix.ufl.element("Lagrange", cell, 1, inner, shape=(3,), discontinuous=True)
        space, one = fem.functionspace(self._mesh, element), fem.Constant(self._mesh, 1.0)
        self._fields, self._given = [], []
        for direction in (body.fibres.f0, body.fibres.s0):
            if direction is not None:
                field = fem.Function(space)
                field.interpolate(
                    fem.Expression(
                        one * direction, space.element.interpolation_points, jit_options=jit_options()
                    )
                )
                self._fields.append(field)
                self._given.append(field.x.array.reshape(-1, 3)[space.dofmap.list])
        if len(self._fields) == 2:
            self.directions = orthonormal(*self._fields)
        else:
            (f,) = self._fields
            self.directions = Microstructure(f / ufl.sqrt(ufl.dot(f, f)))

    def _edges(self) -> Array:
        """Edges (cells, 3, 3) from the first corner of each cell, as columns."""
        corners = self._mesh.geometry.x[self._mesh.geometry.dofmaps[0]]
        return np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)

    def follow(self) -> float:
        """Carry the directions to the present nodes; the least ratio of a cell's volume (collective)."""
        edges = self._edges()
        ratio = np.linalg.det(edges) / np.linalg.det(self._image)
        least = float(self._comm.allreduce(float(ratio.min(initial=np.inf)), op=MPI.MIN))
        if least > 0:
            back = edges @ np.linalg.inv(self._image)  # F⁻¹
            for field, given in zip(self._fields, self._given, strict=True):
                values = field.x.array.reshape(-1, 3)
                values[field.function_space.dofmap.list] = np.einsum("cij,cpj->cpi", back, given)
        return least


def _diagonal(body: Body) -> float:
    low, high = body.extent()
    return float(np.linalg.norm(high - low))
