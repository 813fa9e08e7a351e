"""Ellipsoids cut off by a plane, as gmsh shapes and as formulas, for ventricles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from myostrain.errors import InputError
from myostrain.geometry.gmsh_model import to_meshed
from myostrain.geometry.meshed import Meshed

import numpy as np
import numpy.typing as npt

Points = npt.NDArray[np.float64]

#: Cells and nodes that gmsh makes for each spacing³ of a body and spacing² of its surface.
CELLS, NODES_INSIDE, NODES_ON_SURFACE = 8.2, 1.38, 0.58


@dataclass(frozen=True)
class Ellipsoid:
    """An ellipsoid with axes along X, Y, Z.

    Args:
        semi_axes: Its semi-axes (a, b, c).
        centre: X of its centre; Y = Z = 0 there.
    """

    semi_axes: tuple[float, float, float]
    centre: float = 0.0

    def level(self, points: Points) -> Points:
        """(X/a)² + (Y/b)² + (Z/c)² of points (n, 3), one on the surface."""
        return (((points - [self.centre, 0.0, 0.0]) / self.semi_axes) ** 2).sum(axis=1)

    def volume_below(self, z: float) -> float:
        """Its volume below the height ``z``, |z| ≤ c: πab ∫ (1 − Z²/c²) dZ from −c to z."""
        a, b, c = self.semi_axes
        return float(np.pi * a * b * (z + c - (z**3 + c**3) / (3 * c**2)))

    def add(self, gmsh: Any) -> list[tuple[int, int]]:
        """Add it to gmsh's model, its poles along Z."""
        occ = gmsh.model.occ
        ball = [(3, occ.addSphere(0.0, 0.0, 0.0, 1.0))]
        occ.dilate(ball, 0, 0, 0, *self.semi_axes)
        occ.translate(ball, self.centre, 0, 0)
        return ball


Axis = Literal["x", "y", "z"]
"""An axis of the mesh."""

Order = Literal[1, 2]
"""Degree of the cells' geometry: 1 straight, 2 curved, with nodes of their edges on the curved surfaces."""


def roll(axis: Axis) -> int:
    """By how many places coordinates about Z are to be rolled for an axis in place of Z."""
    return "zxy".index(axis)


def below(
    gmsh: Any,
    shape: list[tuple[int, int]],
    z: tuple[float, float],
    r: tuple[float, float],
    reach: float,
) -> list[tuple[int, int]]:
    """What of a shape is below the cone through two circles about Z, or the plane that they lie in.

    Args:
        gmsh: The module.
        shape: The shape, within ``reach`` of the origin.
        z: Heights of the circles.
        r: Their radii.
        reach: A length.
    """
    occ, slope = gmsh.model.occ, (z[1] - z[0]) / (r[1] - r[0])
    if not slope:
        box = occ.addBox(-2 * reach, -2 * reach, -2 * reach, 4 * reach, 4 * reach, 2 * reach + z[0])
        return list(occ.intersect(shape, [(3, box)])[0])
    tip = z[0] - slope * r[0]
    # Of the two nappes of the cone the one that is a solid: of what is below, or of what is above.
    height = -2 * reach if slope < 0 else 2 * reach
    cone = [(3, occ.addCone(0, 0, tip, 0, 0, height, 0, abs(height / slope)))]
    return list((occ.intersect if slope < 0 else occ.cut)(shape, cone)[0])


def mesh_walls(
    comm: Any,
    add: Callable[[Any], None],
    spacing: float,
    thickness: float,
    place: Callable[[Points], str],
    boundaries: Sequence[str],
    order: Order = 1,
    sizes: Callable[[float, float, float], float] | None = None,
) -> Meshed:
    """Mesh volumes with gmsh, and name what bounds them together by where its nodes are.

    Args:
        comm: MPI communicator over which the mesh is spread.
        add: Adds the volumes to the model of the gmsh that it is given.
        spacing: Desired edge length.
        thickness: Least thickness of the walls, for advice.
        place: Gives the name of a surface that has these nodes (n, 3).
        boundaries: The names, numbered from 1 in this order.
        order: Degree of the cells' geometry.
        sizes: The edge length at X, Y, Z where it is not the same everywhere.

    Raises:
        InputError: Gmsh is not there or fails, or a curved cell would be inverted.
    """

    def make(gmsh: Any) -> int:
        model = gmsh.model
        model.add("walls")
        gmsh.option.setNumber("Mesh.OptimizeNetgen", 1)
        if sizes is None:
            for option in ("MeshSizeMin", "MeshSizeMax"):
                gmsh.option.setNumber(f"Mesh.{option}", spacing)
        else:
            for option in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
                gmsh.option.setNumber(f"Mesh.MeshSize{option}", 0)
            model.mesh.setSizeCallback(lambda dim, tag, x, y, z, size: sizes(x, y, z))
        try:
            add(gmsh)
            model.occ.synchronize()
            model.mesh.generate(3)
            if order == 2:
                model.mesh.setOrder(2)
        except Exception as error:  # gmsh raises plain Exception
            says = " ".join(str(error).split())
            raise InputError(
                f"gmsh cannot mesh such a wall at this spacing: the wall is {thickness:.3g} thick, choose at "
                f"most {2 * thickness:.3g} (it says: {says})",
                "geometry.spacing",
            ) from error
        if order == 2:
            _check_curved(model, spacing)
        named: dict[str, list[int]] = {name: [] for name in boundaries}
        for _, surface in model.getBoundary(model.getEntities(3), oriented=False):
            _, coordinates, _ = model.mesh.getNodes(2, surface, includeBoundary=True)
            named[place(np.asarray(coordinates).reshape(-1, 3))].append(surface)
        for number, (name, surfaces) in enumerate(named.items(), start=1):
            model.addPhysicalGroup(2, surfaces, number, name)
        model.addPhysicalGroup(3, [volume for _, volume in model.getEntities(3)], 1, "wall")
        return 3

    return to_meshed(comm, make, "the wall")


def _check_curved(model: Any, spacing: float) -> None:
    """Refuse curved cells whose volume is negative somewhere, after gmsh has tried to mend them.

    Raises:
        InputError: There are some.
    """
    for _ in range(2):
        _, tags, _ = model.mesh.getElements(3)
        inverted = int((model.mesh.getElementQualities(np.concatenate(tags), "minDetJac") <= 0).sum())
        if not inverted:
            return
        model.mesh.optimize("HighOrder")
    raise InputError(
        f"{inverted} curved cells are inverted: choose a smaller spacing than {spacing:g}, or order = 1",
        "geometry.order",
    )


def counts(volume: float, surface: float, spacing: float) -> tuple[float, float]:
    """About how many nodes and cells a mesh has.

    Args:
        volume: Volume of the body.
        surface: Area of its surface.
        spacing: Edge length.
    """
    nodes = (
        NODES_INSIDE * (volume / spacing) / spacing / spacing
        + NODES_ON_SURFACE * (surface / spacing) / spacing
    )
    return nodes, CELLS * (volume / spacing) / spacing / spacing
