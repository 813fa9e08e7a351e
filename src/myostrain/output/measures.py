"""What is measured of a deforming solid: volumes, stretch of fibres, and what a ventricle does."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from myostrain.engine import MPI, lasting
from myostrain.errors import InputError
from myostrain.mechanics.cavity import Cavity
from myostrain.mechanics.quadrature import QuadraturePoints
from myostrain.output.left_ventricle import BASE, LEFT, OUTER, RIGHT, LeftVentricle
from myostrain.output.segments import Segments
from myostrain.output.wall import Wall

import numpy as np
import ufl

if TYPE_CHECKING:
    from myostrain.mechanics.equilibrium import Mechanics

#: Degree of the quadrature: that of det F for quadratic displacements, whose integral so is exact.
DEGREE = 3


class Measures:
    """Numbers that describe the present configuration of a solid, the same on any number of processes.

    Of every solid:

    - ``volume_ratio``: ∫ det F dX / V, from the displacement itself, whatever the constraint;
    - ``fibre_stretch_mean``, ``fibre_stretch_min``: |F f0|, its mean over the reference body and its least
      value at quadrature points (degree 3);
    - ``cavity_volume`` of the boundary "endocardium", ``cavity_volume_NAME`` of every "endocardium_NAME":
      see :class:`~myostrain.mechanics.cavity.Cavity`.

    Of one with the boundaries "endocardium", "epicardium" and "base" also what
    :class:`~myostrain.output.wall.Wall` says. Where the septum of it, or of two ventricles, is known, also
    what :class:`~myostrain.output.segments.Segments` says.

    A sample evaluates these once in a few points a cell: 6 ms for 1,144 cells, 40 ms for 4,673.

    Args:
        mechanics: The mechanics of the solid.
        septum: Direction (3,) from the long axis of a left ventricle to the middle of its septum, for what is
            measured in segments; None for nothing.

    Raises:
        InputError: A boundary of a ventricle is empty, or there are no segments.

    Attributes:
        names: The names, in the order of the values.
    """

    def __init__(self, mechanics: Mechanics, septum: Sequence[float] | None = None) -> None:
        body = mechanics.body
        self._comm = lasting(body.mesh.comm)
        u = ufl.split(mechanics.u)[0] if mechanics.kinematics.has_pressure else mechanics.u
        F = ufl.Identity(3) + ufl.grad(u)
        along = F * body.f0
        sampled = [ufl.det(F), ufl.sqrt(ufl.dot(along, along))]
        names = body.meshed.boundaries
        self._cavities = {
            name.replace("endocardium", "cavity_volume", 1): Cavity(
                body, name, u, mechanics.kinematics.degree
            )
            for name in sorted(names)
            if name == "endocardium" or name.startswith("endocardium_")
        }
        self._wall = None
        if {"endocardium", "epicardium", "base"} <= set(names):
            self._wall = Wall(mechanics, u, self._cavities["cavity_volume"])
            sampled.append(self._wall.transmural_stretch(F))
        self._segments: Segments | None = None
        if septum is not None:
            two = {LEFT, RIGHT, OUTER, BASE} <= set(names)
            if self._wall is None and not two:
                raise InputError(
                    "segments are those of a left ventricle with the boundaries endocardium, epicardium and "
                    "base, or endocardium_left and endocardium_right for two ventricles; this body has "
                    f"{', '.join(names) or 'none'}",
                    "output.septum",
                )
            wall = self._wall or LeftVentricle(mechanics)
            rim = self._cavities["cavity_volume_left" if self._wall is None else "cavity_volume"].rim_at_rest
            self._segments = Segments(mechanics, F, wall, rim, septum)
        self._points = QuadraturePoints(body.mesh, DEGREE)
        self._values = self._points.values(ufl.as_vector(sampled))
        self.names = ["volume_ratio", "fibre_stretch_mean", "fibre_stretch_min", *self._cavities]
        if self._wall is not None:
            self.names += ["wall_thickening", *self._wall.names]
        if self._segments is not None:
            self.names += self._segments.names
        self._volume = float(self._points.integral(np.ones_like(self._points.weights)))

    def values(self) -> dict[str, float]:
        """The numbers by name (collective)."""
        values = self._values()
        means = self._points.integral(values) / self._volume
        least = self._comm.allreduce(float(values[:, :, 1].min(initial=np.inf)), op=MPI.MIN)
        found = [means[0], means[1], least, *(cavity.volume() for cavity in self._cavities.values())]
        if self._wall is not None:
            found += [means[2] - 1, *self._wall.values()]
        if self._segments is not None:
            twist = found[self.names.index("twist")] if self._wall is not None else 0.0
            found += self._segments.values(twist)
        # Not −0, which reads as if there was something.
        return {name: float(value) + 0.0 for name, value in zip(self.names, found, strict=True)}
