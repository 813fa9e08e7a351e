"""A solid seen by a camera that stands still, drawn by PyVista without a screen."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any

from myostrain.errors import InputError
from myostrain.output.figures.style import GREY
from myostrain.output.figures.surface import Surface, boundary, cut_open, hollow

import numpy as np
import numpy.typing as npt
from matplotlib.colors import Normalize
from PIL import Image

Array = npt.NDArray[np.float64]

#: Colours of the body where it has no value, of its edges, and of the reference body's outline.
BARE, EDGE, OUTLINE = "#e4e4e4", "#222222", GREY
#: Edges are where the surface turns by more, in degrees.
EDGE_ANGLE = 40.0
#: Part of the light that comes from everywhere, so that colours keep their meaning.
AMBIENT = 0.84

#: Drawn in a process of its own, because VTK ends the process where it finds no OpenGL.
_TRIAL = """
from vtkmodules import vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetSize(8, 8)
window.Render()
assert window.SupportsOpenGL()
print(window.GetClassName())
"""


@cache
def why_not() -> str | None:
    """Why no solid can be drawn here, and what to do; None if it can."""
    try:
        import vtkmodules.vtkRenderingCore  # noqa: F401
    except ImportError as missing:
        return (
            f"pictures of solids are drawn by PyVista, which is not here ({missing}): "
            "pip install 'myostrain[render]' (`uv sync --extra render` in a checkout)"
        )
    try:
        trial = subprocess.run(
            [sys.executable, "-c", _TRIAL], capture_output=True, text=True, timeout=120, check=False
        )
    except (OSError, subprocess.SubprocessError) as error:
        return f"whether VTK can draw could not be tried ({error})"
    if trial.returncode != 0:
        return "VTK finds no OpenGL to draw with, screen or not; on Debian or Ubuntu: apt install libegl1"
    # The one that worked, straight away: VTK would try a screen first, and complain.
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", trial.stdout.split()[-1])
    try:
        import pyvista  # noqa: F401
    except ImportError as missing:
        return f"PyVista is not here ({missing}): pip install 'myostrain[render]'"
    return None


class View:
    """A direction to look from, in parallel projection: lengths across it are to scale.

    Args:
        towards: From the body to the camera, (3,); not vertical.

    Attributes:
        towards: The same as a unit vector.
        screen: What is to the right and up in the picture, unit vectors (2, 3).
    """

    def __init__(self, towards: Iterable[float]) -> None:
        d = np.asarray(tuple(towards), dtype=float)
        self.towards: Array = d / np.linalg.norm(d)
        right = np.cross([0.0, 0.0, 1.0], self.towards)
        right /= np.linalg.norm(right)
        self.screen: Array = np.stack([right, np.cross(self.towards, right)])

    def frame(self, places: Array) -> tuple[Array, Array]:
        """Lower left corner (2,), by ``screen``, and width and height (2,) of what holds places (q, 3)."""
        flat = places @ self.screen.T
        low, high = flat.min(axis=0), flat.max(axis=0)
        margin = 0.02 * (high - low).max()
        return low - margin, high - low + 2 * margin


@dataclass(frozen=True)
class Look:
    """A way to see a body.

    Attributes:
        name: What to call it.
        surface: What is seen.
        view: From where.
    """

    name: str
    surface: Surface
    view: View


def looks(points: Array, cells: npt.NDArray[np.int64]) -> tuple[Look, Look]:
    """Two ways to see a body, the more telling one first.

    A hollow body is cut open along the wider of X and Y, through its middle, and seen from outside; a full
    one is seen from both ends of a diagonal. The vertical is Z.

    Args:
        points: Nodes (n, 3).
        cells: Node numbers (m, 4).
    """
    whole = boundary(points, cells)
    low, high = points.min(axis=0), points.max(axis=0)
    depth = 0 if (high - low)[0] < 0.999 * (high - low)[1] else 1
    front, side, up = np.eye(3)[depth] * (1 - 2 * depth), np.eye(3)[1 - depth], np.eye(3)[2]
    if hollow(points, cells):
        behind = ((low + high) / 2 - points)[:, depth] * front[depth]
        cut = cut_open(points, cells, behind)
        towards = front + 0.2 * side + 0.35 * up
        return Look("cut open", cut, View(towards)), Look("from outside", whole, View(towards))
    towards = front + 0.45 * side + 0.55 * up
    return Look("from the front, above", whole, View(towards)), Look(
        "from behind, below", whole, View(-towards)
    )


class Scene:
    """One window, in which a surface moves and changes its colours.

    Args:
        look: The surface, and where the camera is.
        points: Nodes at rest, (n, 3).
        places: All that has to fit into the picture, (q, 3).
        pixel: Length of the side of a pixel.
        reference: Whether to draw the outline of the surface at rest, faintly.
        finer: Pixels that are drawn for each of the picture, along a side: with two edges come out smooth,
            and a picture takes three times as long.

    Attributes:
        size: Width and height of the picture in pixels.

    Raises:
        InputError: Nothing can be drawn here.
    """

    def __init__(
        self,
        look: Look,
        points: Array,
        places: Array,
        pixel: float,
        *,
        reference: bool = False,
        finer: int = 2,
    ) -> None:
        if (reason := why_not()) is not None:
            raise InputError(reason)
        pv: Any = importlib.import_module("pyvista")
        self._pv, self.pixel, self._finer = pv, pixel, finer
        self.look, self.view = look, look.view
        view = look.view
        self._low, extent = view.frame(places)
        self.size = (round(extent[0] / pixel), round(extent[1] / pixel))
        self.plotter = pv.Plotter(
            off_screen=True, window_size=[finer * side for side in self.size], lighting="none"
        )
        self.plotter.set_background("white")
        self.plotter.add_light(pv.Light(light_type="camera light", position=(0.4, 0.6, 1.0)))
        self.mesh = self.polygons(look.surface.at(points), look.surface.triangles)
        self._depth = float(np.ptp(places @ view.towards))
        if reference:
            self.outline(self.mesh.copy(), OUTLINE, 1.0, lift=-1.5)
        focus = (self._low + extent / 2) @ view.screen + (places @ view.towards).mean() * view.towards
        camera = self.plotter.camera
        camera.parallel_projection = True
        far = np.ptp(places, axis=0).sum()
        self.plotter.camera_position = [focus + far * view.towards, focus, view.screen[1]]
        camera.parallel_scale = self.size[1] * self.pixel / 2

    def polygons(self, points: Array, triangles: npt.NDArray[np.int64]) -> Any:
        """A PyVista surface of triangles (k, 3) between points (p, 3)."""
        faces = np.column_stack([np.full(len(triangles), 3), triangles])
        return self._pv.PolyData(points.copy(), faces.reshape(-1))

    def add(self, mesh: Any, **look: Any) -> Any:
        """Add a surface; ``look`` as PyVista's ``add_mesh`` has it."""
        light = {"ambient": AMBIENT, "diffuse": 1 - AMBIENT, "specular": 0.0}
        return self.plotter.add_mesh(
            mesh, show_scalar_bar=False, copy_mesh=False, reset_camera=False, **light, **look
        )

    def colour(self, values: Array, cmap: str, norm: Normalize) -> None:
        """Add the surface, coloured by values (p,) at its corners."""
        limits = (float(norm.vmin or 0.0), float(norm.vmax or 0.0))
        self.mesh.point_data["values"] = values.copy()
        self.add(self.mesh, scalars="values", cmap=cmap, clim=limits, interpolate_before_map=True)
        self.outline(self.mesh, EDGE, 1.4)

    def isochrones(self, times: Array, levels: Array, colours: Any) -> None:
        """Add the surface in bands between levels of times (p,), grey where these are NaN.

        Args:
            times: At the corners of the surface.
            levels: Ascending.
            colours: A colour for each band, a Matplotlib colour map.
        """
        never = np.isnan(times)
        triangles = self.look.surface.triangles
        off = never[triangles].any(axis=1)
        if off.any():
            self.add(self.polygons(self.mesh.points, triangles[off]), color=BARE)
        if not off.all():
            known = self.polygons(self.mesh.points, triangles[~off])
            known.point_data["values"] = np.where(never, levels[0], times)
            self.add(
                known,
                scalars="values",
                cmap=colours,
                clim=(levels[0], levels[-1]),
                n_colors=colours.N,
                interpolate_before_map=True,
            )
            lines = known.contour(levels[1:-1], scalars="values") if len(levels) > 2 else None
            if lines is not None and lines.n_points:
                self.plotter.add_mesh(
                    lines, color="white", line_width=self._finer * 0.7, lighting=False, reset_camera=False
                )
        self.outline(self.mesh, EDGE, 1.4)

    def lines(
        self, centres: Array, along: Array, values: Array, cmap: Any, limits: tuple[float, float]
    ) -> None:
        """Add the bare surface and short lines on it, coloured by values.

        Args:
            centres: Middles of the lines, (q, 3).
            along: From end to end, (q, 3).
            values: A value for each, (q,).
            cmap: Colour map.
            limits: Values at its ends.
        """
        self.add(self.mesh, color=BARE)
        self.outline(self.mesh, EDGE, 1.0)
        # Towards the reader, who sees no difference, lest the surface hide them.
        lifted = centres + 2e-3 * self._depth * self.view.towards
        ends = lifted[:, None] + 0.5 * np.array([-1.0, 1.0])[:, None] * along[:, None]
        lines = np.column_stack([np.full(len(ends), 2), np.arange(2 * len(ends)).reshape(-1, 2)])
        made = self._pv.PolyData(ends.reshape(-1, 3), lines=lines.reshape(-1))
        made.cell_data["values"] = values
        self.plotter.add_mesh(
            made,
            scalars="values",
            cmap=cmap,
            clim=limits,
            line_width=self._finer * 1.6,
            lighting=False,
            show_scalar_bar=False,
            reset_camera=False,
        )

    def outline(self, mesh: Any, colour: str, width: float, lift: float = 2e-3) -> None:
        """Add the outline of a surface as it is seen, and its sharp edges.

        Args:
            mesh: The surface.
            colour: Of the lines.
            width: Of the lines, in pixels.
            lift: How far they are moved towards the reader, who sees no difference but for what hides what;
                in depths of the scene.
        """
        lines = self.plotter.add_silhouette(
            mesh, color=colour, line_width=self._finer * width, feature_angle=EDGE_ANGLE, decimate=0
        )
        lines.position = lift * self._depth * self.view.towards

    def move(self, points: Array, values: Array) -> None:
        """Give the surface other corners (p, 3) and values (p,)."""
        self.mesh.points[:] = points
        self.mesh.point_data["values"][:] = values
        self.mesh.GetPoints().Modified()
        self.mesh.point_data["values"].VTKObject.Modified()
        self.mesh.Modified()

    def image(self) -> npt.NDArray[np.uint8]:
        """The picture as it is now, (height, width, 3)."""
        self.plotter.renderer.ResetCameraClippingRange()
        self.plotter.render()
        drawn = Image.fromarray(self.plotter.screenshot(return_img=True)[..., :3])
        return np.asarray(drawn.resize(self.size, Image.Resampling.BOX))

    def project(self, points: Array) -> Array:
        """Pixels (n, 2), from the left and from the top, of points (n, 3)."""
        flat = (points @ self.view.screen.T - self._low) / self.pixel
        return np.column_stack([flat[:, 0], self.size[1] - flat[:, 1]])

    def close(self) -> None:
        """Give the window back."""
        self.plotter.close()
