"""Fibres of an ellipsoidal ventricle in closed form."""

from __future__ import annotations

from typing import Any, Literal

from myostrain.engine import MPI, fem, lasting
from myostrain.errors import InputError
from myostrain.geometry.ellipsoids import Axis, roll
from myostrain.geometry.fibres import Microstructure
from myostrain.geometry.harmonic import harmonic
from myostrain.geometry.meshed import Meshed
from myostrain.validation import Finite, Positive, description

import numpy as np
import numpy.typing as npt
import ufl

#: How far off the two ellipsoids a mesh's nodes may end, as a share of the wall.
OFF = 0.1


@description
class EllipsoidalFibres:
    """Fibres that turn linearly with the depth in the wall between two ellipsoids about the axis Z.

    A point at the depth t (0 endocardium, 1 epicardium) is on the ellipsoid whose semi-axes are interpolated,
    X = (rs sin u cos v, rs sin u sin v, rl cos u), rs(t) and rl(t) linear, and its fibre
    f0 = n(dX/du) sin α + n(dX/dv) cos α, n(a) = a/|a|, with α linear in t. So α = 0 is circumferential
    (anticlockwise seen from the base), 90 degrees points to the base. The defaults are those of problem 3 of
    Land et al. 2015 (Proc. R. Soc. A 471: 20150641): α from 90 at the endocardium to −90 at the epicardium.

    The sheet direction s0 is across the fibre, at the angle β from the outward normal of these ellipsoids
    towards n(dX/du) cos α − n(dX/dv) sin α; n0 = f0 × s0. With β = 0 sheets are radial. On the axis, where
    there is no circumference, Y takes its place.

    The depth is exact at nodes and edge midpoints and quadratic between them; f0, s0 and n0 follow from it
    in every point, so that they are orthonormal to round-off wherever they are used.

    Args:
        endocardium: Semi-axes (short, long) at t = 0, as those of the geometry.
        epicardium: Semi-axes (short, long) at t = 1.
        helix: α at endocardium and epicardium, degrees.
        sheet: β at endocardium and epicardium, degrees.
        axis: The long axis, as that of the geometry.
        depth_by: What the depth t is: that of the ellipsoid through the point, or the harmonic function that
            is 0 at "endocardium" and 1 at "epicardium", as in R. Aróstica and others, Comput. Methods Appl.
            Mech. Eng. 435 (2025) 117485, doi 10.1016/j.cma.2024.117485, by their public toolkit.
    """

    endocardium: tuple[Positive, Positive] = (7.0, 17.0)
    epicardium: tuple[Positive, Positive] = (10.0, 20.0)
    helix: tuple[Finite, Finite] = (90.0, -90.0)
    sheet: tuple[Finite, Finite] = (0.0, 0.0)
    axis: Axis = "z"
    depth_by: Literal["ellipsoids", "laplace"] = "ellipsoids"

    def depth(self, points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """The depth t of points (3, n), by Newton's method; not finite where there is none."""
        inner, outer = np.array(self.endocardium), np.array(self.epicardium)
        x, y, z = np.roll(points, -roll(self.axis), axis=0)
        squares = np.stack([x**2 + y**2, z**2])
        growth = (outer - inner)[:, None]
        t = np.zeros(points.shape[1])
        with np.errstate(all="ignore"):
            for _ in range(60):
                axes = inner[:, None] + t * growth
                level = (squares / axes**2).sum(axis=0) - 1
                change = level / (-2 * squares * growth / axes**3).sum(axis=0)
                t = t - change
                if np.abs(change).max(initial=0.0) < 1e-14:
                    break
        return t

    def directions_on(self, meshed: Meshed) -> Microstructure:
        """Unit directions as UFL vectors.

        Raises:
            InputError: The body is not a solid between these two ellipsoids.
        """
        mesh = meshed.mesh
        if mesh.geometry.dim != 3:
            raise InputError("these fibres are those of a solid", "fibres.kind")
        if min(np.subtract(self.epicardium, self.endocardium)) <= 0:
            raise InputError(
                f"{list(self.epicardium)} is not larger than the endocardium's {list(self.endocardium)}",
                "fibres.epicardium",
            )
        self._check(mesh)
        space = fem.functionspace(mesh, ("Lagrange", 2))
        if self.depth_by == "laplace":
            sides = [meshed.facets([name], "fibres.depth_by") for name in ("endocardium", "epicardium")]
            nodes = [fem.locate_dofs_topological(space, 2, side) for side in sides]
            depth = harmonic(space, [(0.0, nodes[0]), (1.0, nodes[1])])
        else:
            depth = fem.Function(space, name="depth")
            depth.interpolate(self.depth)
        # Flat facets reach into the cavity a little; the fibre does not turn on there.
        inside = ufl.max_value(0.0, ufl.min_value(depth, 1.0))
        a, c = (
            inner + depth * (outer - inner)
            for inner, outer in zip(self.endocardium, self.epicardium, strict=True)
        )
        at = ufl.SpatialCoordinate(mesh)
        back = roll(self.axis)
        x, y, z = (at[(i + back) % 3] for i in range(3))
        on_axis = ufl.lt(x**2 + y**2, (1e-9 * self.endocardium[0]) ** 2)
        x = ufl.conditional(on_axis, 1e-9 * self.endocardium[0], x)
        y = ufl.conditional(on_axis, 0.0, y)
        r = ufl.sqrt(x**2 + y**2)
        around = ufl.as_vector([-y / r, x / r, 0.0])
        upwards = ufl.as_vector([-a / c * z * x / r, -a / c * z * y / r, c / a * r])
        upwards /= ufl.sqrt(ufl.dot(upwards, upwards))
        around, upwards = (ufl.as_vector([v[(i - back) % 3] for i in range(3)]) for v in (around, upwards))
        return turned(around, upwards, _between(self.helix, inside), _between(self.sheet, inside))

    def _check(self, mesh: Any) -> None:
        """Refuse a mesh that is not between the ellipsoids: its fibres would be others than were meant."""
        t = self.depth(mesh.geometry.x.T)
        t = np.where(np.isfinite(t), t, 1e9)
        comm = lasting(mesh.comm)
        low = comm.allreduce(t.min(initial=np.inf), MPI.MIN)
        high = comm.allreduce(t.max(initial=-np.inf), MPI.MAX)
        if not (abs(low) < OFF and abs(high - 1) < OFF):
            raise InputError(
                f"the body is not between the ellipsoids {list(self.endocardium)} and "
                f"{list(self.epicardium)}: its depth goes from {low:.3g} to {high:.3g}, not from 0 to 1; "
                "give the semi-axes of the geometry",
                "fibres.endocardium",
            )


def _between(ends: tuple[float, float], depth: Any) -> Any:
    """An angle in radians, linear in the depth."""
    first, last = np.radians(ends)
    return float(first) + float(last - first) * depth


def turned(around: Any, upwards: Any, helix: Any, sheet: Any) -> Microstructure:
    """Fibres at an angle from the circumference, sheets at an angle from the outward normal.

    Args:
        around: Unit vector along the circumference, UFL.
        upwards: Unit vector within the wall towards the base, orthogonal to ``around``.
        helix: Angle α of the fibre from ``around`` to ``upwards``, in radians.
        sheet: Angle β of the sheet from the outward normal, across the fibre, in radians.
    """
    f0 = ufl.cos(helix) * around + ufl.sin(helix) * upwards
    within = ufl.cos(helix) * upwards - ufl.sin(helix) * around
    s0 = ufl.cos(sheet) * ufl.cross(around, upwards) + ufl.sin(sheet) * within
    return Microstructure(f0, s0, ufl.cross(f0, s0))
