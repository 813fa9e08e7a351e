"""A picture of the fibres of a solid."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from myostrain.engine import fem
from myostrain.errors import InputError
from myostrain.geometry import Body

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

#: Fibres drawn at most; of more, every second, third, ... is.
MOST = 12_000
PANEL = 900  # pixels
#: Colours of lines: −90 and 90 degrees are one direction.
CYCLIC = "twilight_shifted"


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


def draw_fibres(body: Body, path: Path, axis: tuple[float, float] = (0.0, 0.0)) -> None:
    """Write a picture of the fibres: on the surface, and cut open along Y = ``axis[1]``.

    Colours are the helix angles. Every process of the body's takes part, the first one draws.

    Args:
        body: A body of three dimensions.
        path: The picture, ``.png``.
        axis: X and Y of the body's long axis, which is along Z.

    Raises:
        InputError: The body is no solid, or PyVista is not there.
    """
    if body.dim != 3:
        raise InputError("fibres are drawn of solids")
    mesh = body.mesh
    cells = np.arange(mesh.topology.index_map(3).size_local, dtype=np.int32)
    corners = mesh.geometry.x[mesh.geometry.dofmaps[0][cells]]
    # In each cell at its centre, then on each of its sides, numbered as the corner that it has not.
    weights = np.vstack([np.full(4, 1 / 4), (1 - np.eye(4)) / 3])
    f0 = fem.Expression(body.f0, weights[:, 1:].copy()).eval(mesh, cells)
    points = weights @ corners
    cell, side = _outer_sides(body)
    others = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])
    facets = np.take_along_axis(corners[cell], others[side][:, :, None], axis=1)
    found = (points[:, 0], f0[:, 0], points[cell, side + 1], f0[cell, side + 1], facets, corners[cell, side])
    parts = body.comm.gather(found, root=0)
    if body.comm.rank == 0:
        joined = [np.concatenate(arrays) for arrays in zip(*parts, strict=True)]
        _Picture(axis, *joined).draw(path)


def _outer_sides(body: Body) -> tuple[Indices, Indices]:
    """Cells with a side on the boundary, and which side, (n,) each; a cell with two appears twice."""
    topology = body.mesh.topology
    topology.create_connectivity(3, 2)
    facets = body.boundary_facets(None)
    sides = topology.connectivity(3, 2).array.reshape(-1, 4)[: topology.index_map(3).size_local]
    cell, side = np.nonzero(np.isin(sides, facets))
    return cell, side


@dataclass(frozen=True)
class _Picture:
    """Fibres at points within and on the surface, its triangles, and the corners behind these."""

    axis: tuple[float, float]
    points: Array
    f0: Array
    surface_points: Array
    surface_f0: Array
    facets: Array
    behind: Array
    def draw(self, path: Path) -> None:
        pv = _pyvista()
        number = len(self.facets)
        triangles = np.column_stack([np.full(number, 3), np.arange(3 * number).reshape(-1, 3)])
        surface = pv.PolyData(self.facets.reshape(-1, 3), triangles.reshape(-1))
        length = 1.1 * np.sqrt(surface.area / number)
        # Fibres on the surface are lifted a little, lest its triangles hide them.
        edges = self.facets[:, 1:] - self.facets[:, :1]
        normal = np.cross(edges[:, 0], edges[:, 1])
        normal *= np.sign((normal * (self.surface_points - self.behind)).sum(axis=1, keepdims=True))
        lifted = self.surface_points + 0.05 * length * normal / np.linalg.norm(normal, axis=1, keepdims=True)
        beyond = lifted[:, 1] > self.axis[1]
        layer = (self.points[:, 1] > self.axis[1]) & (self.points[:, 1] < self.axis[1] + length)
        half = surface.clip("-y", origin=(*self.axis, 0.0))
        panels = (
            (surface, lifted, self.surface_f0),
            (half, np.r_[lifted[beyond], self.points[layer]], np.r_[self.surface_f0[beyond], self.f0[layer]]),
        )
        plotter = pv.Plotter(off_screen=True, shape=(1, 2), window_size=(2 * PANEL, PANEL), border=False)
        plotter.set_background("white")
        for panel, (body, points, f0) in enumerate(panels):
            plotter.subplot(0, panel)
            plotter.add_mesh(body, color="#e0e0e0")
            plotter.add_mesh(
                self._lines(pv, points, f0, length),
                cmap=CYCLIC,
                clim=(-90, 90),
                line_width=4,
                lighting=False,
                show_scalar_bar=panel == 1,
                scalar_bar_args={
                    "vertical": True,
                    "position_x": 0.88,
                    "position_y": 0.1,
                    "height": 0.5,
                    "width": 0.06,
                    "color": "black",
                    "n_labels": 5,
                    "fmt": "%.0f",
                },
            )
            plotter.view_xz()
            plotter.camera.elevation = 15 * panel
        try:
            plotter.screenshot(str(path))
        finally:
            plotter.close()

    def _lines(self, pv: Any, points: Array, f0: Array, length: float) -> Any:
        """Short lines along fibres, with their helix angles."""
        chosen = slice(None, None, 1 + len(points) // MOST)
        points, f0 = points[chosen], f0[chosen]
        ends = points[:, None] + 0.5 * length * np.array([-1.0, 1.0])[:, None] * f0[:, None]
        lines = np.column_stack([np.full(len(points), 2), np.arange(2 * len(points)).reshape(-1, 2)])
        made = pv.PolyData(ends.reshape(-1, 3), lines=lines.reshape(-1))
        made.cell_data["helix angle"] = helix_angles(points, f0, self.axis)
        return made


def _pyvista() -> Any:
    try:
        import pyvista
    except ImportError as missing:
        raise InputError(
            f"pictures of solids are drawn by PyVista, which is not here ({missing}): "
            "`uv sync --extra render` in a checkout of myostrain, or `pip install pyvista`"
        ) from missing
    return pyvista
