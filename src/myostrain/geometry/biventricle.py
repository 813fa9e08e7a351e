"""Two ventricles: ellipsoids fused and cut off by a plane."""

from __future__ import annotations

from typing import Any, ClassVar

from myostrain.errors import InputError
from myostrain.geometry.body import check_size
from myostrain.geometry.ellipsoids import Ellipsoid, Order, Points, below, counts, mesh_walls
from myostrain.geometry.meshed import Meshed
from myostrain.validation import Finite, Positive, description

import numpy as np


@description
class Biventricle:
    """A left and a right ventricle that share the septum; apex at the bottom, cut off at Z = base.

    The left one is the wall between two ellipsoids centred at the origin. The right cavity is what an
    ellipsoid centred at X = ``right_centre`` has outside the left ventricle; its free wall lies around it.
    Fused ellipsoids are in use as idealized hearts (for example in cardiac-geometries, Finsberg 2022); these
    numbers, in mm, have about the size of a human heart, and are not data of anyone.

    Boundaries: "endocardium_left", "endocardium_right" (with the right side of the septum), "epicardium",
    "base".

    Args:
        left: Semi-axes (x, y, z) of the left endocardium.
        left_wall: Thickness of the left wall: the epicardium's semi-axes are longer by it.
        right: Semi-axes (x, y, z) of the right endocardium.
        right_wall: Thickness of the right free wall.
        right_centre: X of the right ellipsoids' centre, positive.
        base: Height Z of the plane.
        spacing: Desired edge length.
        order: Degree of the cells' geometry: 1 straight, 2 curved.
    """

    left: tuple[Positive, Positive, Positive] = (20.0, 20.0, 50.0)
    left_wall: Positive = 10.0
    right: tuple[Positive, Positive, Positive] = (35.0, 29.0, 45.0)
    right_wall: Positive = 5.0
    right_centre: Positive = 16.0
    base: Finite = 12.0
    spacing: Positive = 5.0
    order: Order = 1
    dim: ClassVar[int] = 3

    def _check(self) -> None:
        """Refuse numbers that do not make such a body together."""
        lowest = min(self.left[2], self.right[2])
        if abs(self.base) >= lowest:
            raise InputError(
                f"the plane Z = {self.base:g} has to cut both cavities: give a height between {-lowest:g} "
                f"and {lowest:g}",
                "geometry.base",
            )
        outside = self.left[0] + self.left_wall
        if self.right_centre + self.right[0] <= outside:
            raise InputError(
                f"the right cavity is inside the left ventricle: its end at X = "
                f"{self.right_centre + self.right[0]:g} has to be beyond {outside:g}",
                "geometry.right_centre",
            )
        if self.right_centre - self.right[0] >= outside:
            raise InputError(
                f"the right ventricle is apart from the left one, which ends at X = {outside:g}",
                "geometry.right_centre",
            )

    @property
    def surfaces(self) -> dict[str, Ellipsoid]:
        """The four ellipsoids: left and right, inner and outer."""
        return {
            "left_inner": Ellipsoid(self.left),
            "left_outer": Ellipsoid(_thicker(self.left, self.left_wall)),
            "right_inner": Ellipsoid(self.right, self.right_centre),
            "right_outer": Ellipsoid(_thicker(self.right, self.right_wall), self.right_centre),
        }

    def contains(self, points: Points) -> Any:
        """Whether points (n, 3) are in the wall."""
        level = {name: surface.level(points) for name, surface in self.surfaces.items()}
        left = (level["left_outer"] <= 1) & (level["left_inner"] >= 1)
        right = (level["right_outer"] <= 1) & (level["right_inner"] >= 1) & (level["left_outer"] >= 1)
        return (left | right) & (points[:, 2] <= self.base)

    def _volume(self) -> float:
        """About the volume of the walls: points of a grid."""
        reach = np.array([s.semi_axes for s in self.surfaces.values()]).max(axis=0)
        low, high = -reach, reach + np.array([self.right_centre, 0.0, 0.0])
        grid = np.stack(np.meshgrid(*np.linspace(low, high, 60).T), axis=-1).reshape(-1, 3)
        return float(self.contains(grid).mean() * np.prod((high - low) * 60 / 59))

    def counts(self) -> tuple[float, float]:
        """About how many nodes and cells the mesh has, before it is made."""
        self._check()
        volume = self._volume()
        return counts(volume, 2.2 * volume / min(self.left_wall, self.right_wall), self.spacing)

    def _place(self, points: Points) -> str:
        if np.ptp(points[:, 2]) < 1e-6 * self.left[2]:
            return "base"
        surfaces = self.surfaces
        near = {name: np.abs(surface.level(points) - 1).max() for name, surface in surfaces.items()}
        nearest = min(near, key=lambda name: near[name])
        if nearest == "left_outer" and np.median(surfaces["right_inner"].level(points)) < 1:
            return "endocardium_right"  # the septum
        return {"left_inner": "endocardium_left", "right_inner": "endocardium_right"}.get(
            nearest, "epicardium"
        )

    def mesh(self, comm: Any) -> Meshed:
        """Mesh the walls over the processes of ``comm``.

        Raises:
            InputError: The parts do not make two ventricles: the plane misses one, or the right ventricle is
                inside the left one or apart from it; there would be too many cells; or gmsh is not there or
                fails.
        """
        check_size(self.counts()[1])

        def add(gmsh: Any) -> None:
            occ, surfaces = gmsh.model.occ, self.surfaces
            left, right = surfaces["left_outer"], surfaces["right_outer"]
            septum_and_left, _ = occ.cut(left.add(gmsh), surfaces["left_inner"].add(gmsh))
            free_wall, _ = occ.cut(right.add(gmsh), surfaces["right_inner"].add(gmsh) + left.add(gmsh))
            walls, _ = occ.fuse(septum_and_left, free_wall)
            reach = self.right_centre + max(*self.left, *self.right) + self.left_wall
            below(gmsh, walls, (self.base, self.base), (0.0, 1.0), reach)

        names = ("endocardium_left", "endocardium_right", "epicardium", "base")
        thickness = min(self.left_wall, self.right_wall)
        return mesh_walls(comm, add, self.spacing, thickness, self._place, names, self.order)


def _thicker(semi_axes: tuple[float, float, float], wall: float) -> tuple[float, float, float]:
    a, b, c = semi_axes
    return a + wall, b + wall, c + wall
