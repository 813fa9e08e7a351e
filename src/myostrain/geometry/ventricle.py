"""A left ventricle: the wall between two half ellipsoids."""

from __future__ import annotations

import logging
from itertools import pairwise
from typing import Any, ClassVar

from myostrain.errors import InputError
from myostrain.geometry.body import cells_along, check_size
from myostrain.geometry.ellipsoids import Axis, Ellipsoid, Order, Points, below, counts, mesh_walls, roll
from myostrain.geometry.meshed import Meshed
from myostrain.validation import Count, Finite, Positive, description

import numpy as np

#: How far the thickness of a layer may be from the spacing, as a share of it, without a warning.
UNEVEN = 0.2

log = logging.getLogger("myostrain")


@description
class Ventricle:
    """A truncated ellipsoidal left ventricle: between two ellipsoids, below a plane; apex at the bottom.

    The axis is Z, unless said otherwise, the centre of both ellipsoids the origin. Boundaries: "endocardium",
    "epicardium", "base".
    The defaults are those of problems 2 and 3 of Land et al. 2015 (Proc. R. Soc. A 471: 20150641,
    doi 10.1098/rspa.2015.0641), in mm. Any unit of length will do if the other units are consistent with it.

    The mesh is gmsh's. That of straight tetrahedra has a volume that tends to :attr:`volume` like spacing².
    Its cells lie in layers through the wall; at least two are needed for fibres that turn within the wall.

    Args:
        endocardium: Semi-axes (short, long) of the inner ellipsoid, across and along Z.
        epicardium: Semi-axes (short, long) of the outer ellipsoid, larger than the inner ones.
        base: Height Z of the plane, within the inner ellipsoid; or heights of the rims of endocardium and
            epicardium, which straight lines join, so that the base is part of a cone.
        spacing: Desired edge length.
        layers: Layers of cells through the wall; unless given, wall / spacing, rounded, with a warning if a
            layer's thickness differs from the spacing by a fifth or more.
        axis: The axis of the mesh along which the long axis lies, the base towards its positive end; the
            other two follow in their order.
        order: Degree of the cells' geometry: 1 straight, 2 curved. Straight cells, as wide as a quarter of
            the inner radius, took 7 per cent of the twist of a contracting ventricle; curved ones cost no
            unknowns.
        apex_ratio: Edge length at the apex, as a share of the spacing, to which it grows linearly.
        apex_reach: Height above the outer apex over which it grows; up to the rims unless given.
    """

    endocardium: tuple[Positive, Positive] = (7.0, 17.0)
    epicardium: tuple[Positive, Positive] = (10.0, 20.0)
    base: Finite | tuple[Finite, Finite] = 5.0
    spacing: Positive = 1.5
    layers: Count | None = None
    axis: Axis = "z"
    order: Order = 1
    apex_ratio: Positive = 1.0
    apex_reach: Positive | None = None
    dim: ClassVar[int] = 3

    def _check(self) -> None:
        """Refuse numbers that do not make such a body together."""
        inner, outer = self.endocardium, self.epicardium
        if outer[0] <= inner[0] or outer[1] <= inner[1]:
            raise InputError(
                f"{list(outer)} is not larger than the endocardium's {list(inner)}, short and long semi-axis",
                "geometry.epicardium",
            )
        for height, name, semi_axes in zip(self.rims, ("endo", "epi"), (inner, outer), strict=True):
            if abs(height) >= semi_axes[1]:
                raise InputError(
                    f"the plane Z = {height:g} does not cut the {name}cardium: give a height between "
                    f"{-semi_axes[1]:g} and {semi_axes[1]:g}",
                    "geometry.base",
                )

    @property
    def rims(self) -> tuple[float, float]:
        """Heights Z of the rims of endocardium and epicardium."""
        return self.base if isinstance(self.base, tuple) else (self.base, self.base)

    @property
    def _radii(self) -> tuple[float, float]:
        """Radii of the rims."""
        ends = zip((self.endocardium, self.epicardium), self.rims, strict=True)
        inner, outer = (short * float(np.sqrt(1 - (z / long) ** 2)) for (short, long), z in ends)
        return inner, outer

    def at_depth(self, t: float) -> Ellipsoid:
        """The ellipsoid at the depth t in the wall: 0 endocardium, 1 epicardium."""
        short, long = (1 - t) * np.array(self.endocardium) + t * np.array(self.epicardium)
        return Ellipsoid((float(short), float(short), float(long)))

    @property
    def cells_through(self) -> int:
        """Number of layers of cells through the wall."""
        return self.layers or cells_along(self._thickness, self.spacing)

    @property
    def _thickness(self) -> float:
        return float(np.subtract(self.epicardium, self.endocardium).mean())

    @property
    def _reach(self) -> float:
        whole = max(self.rims) + self.epicardium[1]
        return whole if self.apex_reach is None else min(self.apex_reach, whole)

    @property
    def cavity_volume(self) -> float:
        """Volume inside the endocardium below its rim."""
        return self.at_depth(0).volume_below(self.rims[0])

    @property
    def volume(self) -> float:
        """Volume of the wall."""
        (low, high), (r, R) = self.rims, self._radii
        between = np.pi / 3 * (low - high) * (r**2 + r * R + R**2)  # of the cone between the rims
        return float(self.at_depth(1).volume_below(high) + between) - self.cavity_volume

    def counts(self) -> tuple[float, float]:
        """About how many nodes and cells the mesh has, before it is made."""
        self._check()
        narrow = self._reach / (max(self.rims) + self.epicardium[1])
        # As many cells as with a length that is linear in the height.
        wide = self.spacing / np.sqrt(max(1 + narrow * (1 / self.apex_ratio - 1), 0.0))
        spacing = np.cbrt(wide**2 * self._thickness / self.cells_through)
        return counts(self.volume, 2.2 * self.volume / self._thickness, float(spacing))

    def _size(self, x: float, y: float, z: float) -> float:
        """The edge length at a point."""
        share = min(max((z + self.epicardium[1]) / self._reach, 0.0), 1.0)
        return self.spacing * (self.apex_ratio + (1 - self.apex_ratio) * share)

    def _place(self, points: Points) -> str:
        (low, high), (r, R) = self.rims, self._radii
        on_cone = low + (high - low) * (np.hypot(points[:, 0], points[:, 1]) - r) / (R - r)
        if np.abs(points[:, 2] - on_cone).max() < 1e-6 * self.epicardium[1]:
            return "base"
        off = [np.abs(surface.level(points) - 1).max() for surface in (self.at_depth(0), self.at_depth(1))]
        return "endocardium" if off[0] < off[1] else "epicardium"

    def mesh(self, comm: Any) -> Meshed:
        """Mesh the wall over the processes of ``comm``.

        Raises:
            InputError: The ellipsoids are not one within the other, the plane misses the inner one, there
                would be too many cells, or gmsh is not there or fails.
        """
        check_size(self.counts()[1])
        layers, thickness = self.cells_through, self._thickness / self.cells_through
        if self.layers is None and abs(thickness / self.spacing - 1) > UNEVEN and comm.rank == 0:
            log.warning(
                "the wall, %.4g thick, has %d layers of cells, %.3g thick each, where the spacing is %.4g: "
                "geometry.layers sets their number",
                *(self._thickness, layers, thickness, self.spacing),
            )

        def add(gmsh: Any) -> None:
            occ, walls = gmsh.model.occ, []
            surfaces = [self.at_depth(t) for t in np.linspace(0, 1, layers + 1)]
            for inner, outer in pairwise(surfaces):
                layer, _ = occ.cut(outer.add(gmsh), inner.add(gmsh))
                walls += below(gmsh, layer, self.rims, self._radii, max(self.epicardium))
            if layers > 1:
                occ.fragment(walls[:1], walls[1:])

        names = ("endocardium", "epicardium", "base")
        sizes = None if self.apex_ratio == 1 else self._size
        meshed = mesh_walls(comm, add, self.spacing, thickness, self._place, names, self.order, sizes)
        x = meshed.mesh.geometry.x
        x[:] = np.roll(x, roll(self.axis), axis=1)
        return meshed
