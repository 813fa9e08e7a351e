"""The 17 segments of a left ventricle: strains, stretch and stress of the fibre in each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from myostrain.engine import compile_form, lasting
from myostrain.errors import InputError
from myostrain.mechanics.quadrature import QuadraturePoints, integral
from myostrain.output.left_ventricle import LeftVentricle
from myostrain.output.segment_names import COUNT, NAMES
from myostrain.output.wall import Wall

import numpy as np
import numpy.typing as npt
import ufl

if TYPE_CHECKING:
    from myostrain.mechanics.equilibrium import Mechanics

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

#: Degree of the quadrature in segments, whose ends cut through cells.
DEGREE = 4

#: What is measured in each segment.
KINDS = ("longitudinal_strain", "circumferential_strain", "radial_strain", "fibre_stretch", "fibre_stress")


def segment_numbers(X: Array, rim: Array, apex: Array, axis: Array, septum: Sequence[float]) -> Indices:
    """Numbers (n,), 1 to 17, of the segments in which points are, see :class:`Segments`.

    Args:
        X: Points at rest (n, 3).
        rim: A point (3,) of the long axis at the base: the mean of the endocardium's rim.
        apex: The endocardial apex (3,), whose height counts.
        axis: Unit vector (3,) along the long axis, from the apex to the base.
        septum: Direction (3,) from the long axis to the middle of the septum.

    Raises:
        InputError: That direction is zero or along the axis.
    """
    along = np.asarray(septum, dtype=float)
    across = along - (along @ axis) * axis
    if not np.linalg.norm(across) > 1e-6 * np.linalg.norm(along):
        raise InputError(
            f"{along.tolist()} is not a direction across the long axis, {np.round(axis, 6).tolist()}",
            "output.septum",
        )
    lateral = -across / np.linalg.norm(across)
    anterior = np.cross(lateral, axis)  # up, where one looks from the apex and has the septum at the left
    arm = X - rim
    angle = np.degrees(np.arctan2(arm @ anterior, arm @ lateral))
    share = (arm @ axis) / ((apex - rim) @ axis)
    wide = np.floor((angle - 60) / 60).astype(np.int64) % 6
    narrow = np.floor((angle - 45) / 90).astype(np.int64) % 4
    return np.select(
        [share < 1 / 3, share < 2 / 3, share < 1], [1 + wide, 7 + wide, 13 + narrow], default=COUNT
    )


class Segments:
    """Means over the 17 segments of M. D. Cerqueira et al., Circulation 105 (2002) 539–542.

    Of two ventricles they are those of the left one with the septum, see
    :class:`~myostrain.output.left_ventricle.LeftVentricle`.

    The long axis goes through the mean of the endocardium's rim, along the mean normal of the base. From
    there to the endocardial apex (the lowest node of the endocardium at rest) three equal heights are the
    basal ring (segments 1–6), the middle ring (7–12) and the apical ring (13–16); what is lower is 17. Seen
    from the apex, with the septum at the left and the anterior wall above, numbers go anticlockwise from the
    anterior wall; 1|2 and 3|4 meet 60 degrees from the middle of the septum, where the right ventricle is
    attached.

    Means over the reference volume of a segment, by its number N:

    - ``longitudinal_strain_N``, ``circumferential_strain_N``, ``radial_strain_N``: |F d| − 1, the change of
      length relative to the body at rest, along unit vectors d at rest: radial along the gradient of the
      wall's harmonic depth, longitudinal along what of the long axis is across that, circumferential across
      both;
    - ``fibre_stretch_N``: |F f0|; ``fibre_stress_N``: f·σf with the Cauchy stress and f along F f0.

    ``longitudinal_strain``, ``circumferential_strain``, ``radial_strain`` and ``fibre_stress_mean`` are
    means over the whole wall. ``torsion`` of a single ventricle, degrees, is the shear angle
    twist (ρ_a + ρ_b) / (2 D) of Young and Cowan 2012 (see :class:`~myostrain.output.wall.Wall`), with the
    mean radii ρ of the epicardium at rest in the two regions whose rotations make the twist, and the distance
    D of their middles along the axis.

    Args:
        mechanics: The mechanics of the ventricle.
        deformation: F, UFL.
        wall: Its wall, or the left ventricle of two.
        rim: The mean (3,) of its endocardium's rim at rest.
        septum: Direction (3,) from the long axis to the middle of the septum.

    Raises:
        InputError: That direction is none, or there is a segment without a point.

    Attributes:
        numbers: Segment of each quadrature point (cells, points), 1 to 17.
        volumes: Reference volumes (17,) of the segments.
    """

    def __init__(
        self,
        mechanics: Mechanics,
        deformation: Any,
        wall: Wall | LeftVentricle,
        rim: Array,
        septum: Sequence[float],
    ) -> None:
        body = mechanics.body
        self._comm = lasting(body.mesh.comm)
        self._points = QuadraturePoints(body.mesh, DEGREE)
        if isinstance(wall, LeftVentricle):
            self._points.weights *= self._points.values(wall.inside)()
        X = self._points.values(ufl.SpatialCoordinate(body.mesh))()
        self.numbers = segment_numbers(X.reshape(-1, 3), rim, wall.apex_at_rest, wall.axis, septum).reshape(
            X.shape[:2]
        )
        self.volumes = self._sums(np.ones(X.shape[:2]))
        if not (self.volumes > 0).all():
            lost = [f"{n + 1} ({NAMES[n]})" for n in np.flatnonzero(self.volumes == 0)]
            raise InputError(
                f"no part of the wall is in segment {', '.join(lost)}: is this a left ventricle with the "
                "boundaries endocardium, epicardium and base?",
                "output.septum",
            )
        self._directions = _directions(self._points.values(ufl.grad(wall.depth))(), wall.axis)
        f = deformation * body.f0
        stress = ufl.dot(f, mechanics.nodal.cauchy * f) / ufl.dot(f, f)
        fibre = ufl.as_vector([ufl.sqrt(ufl.dot(f, f)), stress])
        self._deformation = self._points.values(deformation)
        self._fibre = self._points.values(fibre)
        self._arm = _arm(mechanics, wall, rim) if isinstance(wall, Wall) else None
        self.names = [f"{kind}_{n}" for kind in KINDS for n in range(1, COUNT + 1)]
        self.names += [*KINDS[:3], "fibre_stress_mean", *(["torsion"] if self._arm else [])]

    def values(self, twist: float = 0.0) -> list[float]:
        """All of :attr:`names` (collective).

        Args:
            twist: The present twist of a single ventricle, degrees.
        """
        F = self._deformation()
        F = F.reshape(*F.shape[:2], 3, 3)
        strains = np.linalg.norm(np.einsum("cqij,cqjk->cqik", F, self._directions), axis=2) - 1
        fibre = self._fibre()
        fields = [*np.moveaxis(strains, -1, 0), *np.moveaxis(fibre, -1, 0)]
        sums = np.array([self._sums(field) for field in fields])
        whole = sums.sum(axis=1) / self.volumes.sum()
        found = [*(sums / self.volumes).reshape(-1).tolist(), *whole[[0, 1, 2, 4]].tolist()]
        return [*found, twist * self._arm] if self._arm else found

    def _sums(self, values: Array) -> Array:
        """Integrals (17,) over the segments of values (cells, points) (collective)."""
        weighted = (self._points.weights * values).reshape(-1)
        return np.asarray(
            self._comm.allreduce(np.bincount(self.numbers.reshape(-1), weighted, COUNT + 1)[1:])
        )


def _directions(gradient: Array, axis: Array) -> Array:
    """Longitudinal, circumferential, radial unit vectors, in the columns of (cells, points, 3, 3).

    Where the depth goes along the axis, any two directions across it are taken.
    """
    radial = gradient / np.maximum(np.linalg.norm(gradient, axis=-1, keepdims=True), 1e-300)
    along = axis - (radial @ axis)[..., None] * radial
    size = np.linalg.norm(along, axis=-1, keepdims=True)
    other = np.eye(3)[np.argmin(np.abs(axis))]
    along = np.where(size > 1e-6, along, other - (radial @ other)[..., None] * radial)
    along /= np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-300)
    return np.stack([along, np.cross(radial, along), radial], axis=-1)


def _arm(mechanics: Mechanics, wall: Wall, rim: Array) -> float:
    """(ρ_a + ρ_b) / (2 D), by the two ends of the wall."""
    mesh = mechanics.body.mesh
    arm = ufl.SpatialCoordinate(mesh) - ufl.as_vector(rim.tolist())
    axis = ufl.as_vector(wall.axis.tolist())
    height = ufl.dot(ufl.SpatialCoordinate(mesh), axis)
    across = arm - ufl.dot(arm, axis) * axis
    ds = mechanics.body.boundary_measure(["epicardium"], DEGREE)
    comm, radii = lasting(mesh.comm), []
    for low, high in wall.ends:
        inside = ufl.conditional(ufl.And(ufl.ge(height, low), ufl.le(height, high)), 1.0, 0.0)
        area, moment = (
            integral(compile_form(inside * value * ds), comm)
            for value in (1.0, ufl.sqrt(ufl.dot(across, across)))
        )
        radii.append(moment / area if area else 0.0)
    middles = np.mean(wall.ends, axis=1)
    return float(sum(radii) / (2 * (middles[1] - middles[0])))
