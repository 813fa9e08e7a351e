"""A picture of the fibres of a solid."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from myostrain.errors import InputError
from myostrain.output.figures.data import Recording
from myostrain.output.figures.page import Page, scale
from myostrain.output.figures.scene import Scene, looks
from myostrain.output.figures.style import BLUE, GREEN, ORANGE, VERMILION, save, style
from myostrain.output.figures.surface import hollow

import numpy as np
import numpy.typing as npt
from matplotlib.colors import LinearSegmentedColormap, Normalize

if TYPE_CHECKING:
    from myostrain.geometry import Body

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

#: Fibres drawn at most; of more, every second, third, ... is.
MOST = 12_000
#: Colours of lines: −90 and 90 degrees are one direction.
CYCLIC = LinearSegmentedColormap.from_list(
    "angles", ["#333333", BLUE, GREEN, ORANGE, VERMILION, "#882255", "#333333"]
)


def helix_angles(points: Array, f0: Array, axis: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Angles of fibres with the horizontal, −90 to 90 degrees: positive if they rise anticlockwise.

    Args:
        points: Where (n, 3).
        f0: Fibres (n, 3).
        axis: X and Y of the vertical axis that "anticlockwise" is about.
    """
    arm = points[:, :2] - axis
    around = (
        np.column_stack([-arm[:, 1], arm[:, 0]]) / np.maximum(np.linalg.norm(arm, axis=1), 1e-300)[:, None]
    )
    rise, forth = f0[:, 2], (f0[:, :2] * around).sum(axis=1)
    return np.degrees(np.arctan2(rise * np.where(forth < 0, -1, 1), np.abs(forth)))


def plane_angles(f0: Array) -> Array:
    """Angles of fibres (n, 3), seen along Z, with X: −90 to 90 degrees, positive from X towards Y."""
    x, y = f0[:, 0], f0[:, 1]
    return np.degrees(np.arctan2(y * np.where(x < 0, -1, 1), np.abs(x)))


def draw_fibres(body: Body, path: Path, axis: tuple[float, float] = (0.0, 0.0)) -> None:
    """Write a picture of the fibres of a body, cut open and from outside where it is hollow.

    Colours are the helix angles of a hollow body, and the angles in the plane of X and Y of a full one. Every
    process of the body's takes part, the first one draws.

    Args:
        body: A body of three dimensions.
        path: The picture, ``.png``.
        axis: X and Y of the body's long axis, which is along Z.

    Raises:
        InputError: The body is not a solid, or PyVista is not there.
    """
    from myostrain.output.fields import cell_fibres

    if body.dim != 3:
        raise InputError("fibres are drawn of solids")
    mesh = body.mesh
    own = mesh.topology.index_map(3).size_local
    corners = mesh.geometry.x[mesh.geometry.dofmaps[0][:own, :4]]
    parts = body.comm.gather((corners, cell_fibres(body)), root=0)
    if parts is not None:
        corners, f0 = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        points, cells = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
        with style():
            _draw(points, cells.reshape(-1, 4), f0, "Fibres", "", axis, path)


def draw_recorded_fibres(recording: Recording, path: Path) -> Path:
    """Write a picture of the fibres of a run, as :func:`draw_fibres` does, in the present style.

    The long axis is the Z axis of ventricles that myostrain meshes, and through the middle of other bodies.

    Args:
        recording: The run, of a solid, with fibres.
        path: The picture, ``.png``.
    """
    assert recording.fibres is not None
    low, high = recording.points.min(axis=0), recording.points.max(axis=0)
    own = recording.case.get("geometry", {}).get("kind") in ("ventricle", "biventricle")
    axis = (0.0, 0.0) if own else (float(low[0] + high[0]) / 2, float(low[1] + high[1]) / 2)
    title, unit = recording.heading, recording.unit("length")
    return _draw(recording.points, recording.cells, recording.fibres, title, unit, axis, path)


def _draw(
    points: Array, cells: Indices, f0: Array, title: str, unit: str, axis: tuple[float, float], path: Path
) -> Path:
    """Short lines along fibres (m, 3) of the cells (m, 4) that are seen, on two views of the body."""
    both = looks(points, cells)
    columns, pixel = scale([look.view for look in both], points, len(both))
    scenes = [Scene(look, points, points, pixel) for look in both]
    page = Page(title, unit, scenes, columns)
    helix = hollow(points, cells)
    for number, scene in enumerate(scenes):
        surface = scene.look.surface
        corners = surface.at(points)[surface.triangles]
        chosen = slice(None, None, 1 + len(corners) // MOST)
        along, centres = f0[surface.cell[chosen]], corners[chosen].mean(axis=1)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        twice = np.linalg.norm(normal, axis=1, keepdims=True)
        normal = (normal / np.maximum(twice, 1e-300))[chosen]
        length = 1.1 * np.sqrt(twice.sum() / 2 / len(centres))
        angles = helix_angles(centres, along, axis) if helix else plane_angles(along)
        # What of them is within the surface: lines that come out of it would be cut off by it at random.
        within = along - (along * normal).sum(axis=1, keepdims=True) * normal
        scene.lines(centres, length * within, angles, CYCLIC, (-90.0, 90.0))
        page.panel(number, scene.image(), scene.look.name)
        scene.close()
        page.axes(scene, right=number == 1)
    label = "helix angle (degrees)" if helix else "angle with $x$ in the plane of $x$ and $y$ (degrees)"
    page.bar(Normalize(-90.0, 90.0), CYCLIC, label, ticks=range(-90, 91, 30))
    return save(page.figure, path)
