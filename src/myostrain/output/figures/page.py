"""A page of views of a solid: panels to scale, their axes, one colour bar."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from myostrain.output.figures.choice import choice
from myostrain.output.figures.scene import Scene, View
from myostrain.output.figures.style import new_figure

import numpy as np
import numpy.typing as npt
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.patches import Patch

Array = npt.NDArray[np.float64]

#: In inches: gap between panels, title of a panel, a line of the page's title, the strip below the panels.
GAP, HEAD, LINE, STRIP = 0.15, 0.3, 0.24, 1.05
#: Narrowest page, longest arrow of the axes, in inches.
NARROWEST, ARROW = 5.0, 0.55


def _layout(count: int, wide: bool) -> tuple[int, float, float]:
    """How many panels are side by side, and how wide and high each may be in inches."""
    if count == 1:
        return 1, 6.6, 5.0
    if count == 2:
        return 2, 4.4, 4.2
    return (2, 4.4, 3.0) if wide else (3, 2.9, 3.4)


def scale(views: Sequence[View], places: Array, count: int, dpi: int | None = None) -> tuple[int, float]:
    """How many of some panels go side by side, and how long a pixel of all of them is.

    Args:
        views: From where the panels are seen.
        places: All that has to fit into each, (q, 3).
        count: Number of panels.
        dpi: Dots per inch.
    """
    extents = np.max([view.frame(places)[1] for view in views], axis=0)
    columns, width, height = _layout(count, extents[0] > 1.3 * extents[1])
    return columns, float(max(extents[0] / width, extents[1] / height)) / (dpi or choice().dpi)


class Page:
    """A figure with panels for pictures of scenes, all to one scale.

    Args:
        title: Of the page.
        unit: Of lengths; empty for none.
        scenes: The scene that each panel is to show.
        columns: How many panels are side by side.
        dpi: Dots per inch.
    """

    def __init__(
        self, title: str, unit: str, scenes: Sequence[Scene], columns: int, dpi: int | None = None
    ) -> None:
        dpi = dpi or choice().dpi
        self._unit, self._dpi = unit, dpi
        columns = min(columns, len(scenes))
        rows = -(-len(scenes) // columns)
        cell = np.max([scene.size for scene in scenes], axis=0) / dpi
        self._width = max(NARROWEST, columns * (cell[0] + GAP) + GAP)
        lines = -(-len(title) // max(20, int(11 * self._width)))
        above = 0.12 + lines * LINE
        self._height = above + rows * (cell[1] + HEAD) + STRIP
        self.figure = new_figure(self._width, self._height, title, dpi=dpi)
        self.figure.set_layout_engine("none")
        self._places = []
        left = (self._width - columns * (cell[0] + GAP) + GAP) / 2
        for number, scene in enumerate(scenes):
            row, column = divmod(number, columns)
            size = np.array(scene.size) / dpi
            x = left + column * (cell[0] + GAP) + (cell[0] - size[0]) / 2
            y = self._height - above - (row + 1) * (cell[1] + HEAD) + (cell[1] - size[1]) / 2
            self._places.append((round(x * dpi), round(y * dpi), *scene.size))

    def _axes(self, x: float, y: float, width: float, height: float) -> Any:
        """Axes at a place in pixels, from the left and the bottom."""
        w, h = self._width * self._dpi, self._height * self._dpi
        return self.figure.add_axes((x / w, y / h, width / w, height / h))

    def panel(self, number: int, image: npt.NDArray[np.uint8], title: Any, **text: Any) -> Any:
        """Show a picture; returns its axes, whose units are the picture's pixels."""
        panel = self._axes(*self._places[number])
        panel.imshow(image, extent=(0, image.shape[1], image.shape[0], 0), interpolation="none")
        panel.set_axis_off()
        self.titled = panel.set_title(title, **text)
        return panel

    def box(self, number: int) -> tuple[slice, slice]:
        """Rows and columns that a panel's picture has in the page's."""
        x, y, width, height = self._places[number]
        top = round(self._height * self._dpi) - y - height
        return slice(top, top + height), slice(x, x + width)

    def bar(self, norm: Normalize, cmap: Any, label: str, **options: Any) -> None:
        """The colour bar, below the panels."""
        inches = (1.75, 0.62, self._width - 3.5, 0.14)
        bar = self.figure.colorbar(
            ScalarMappable(norm, cmap),
            cax=self._axes(*(side * self._dpi for side in inches)),
            orientation="horizontal",
            **options,
        )
        bar.set_label(label)
        bar.outline.set_visible(False)

    def note(self, colour: str, text: str) -> None:
        """Say what a colour means that the bar has not."""
        place = (1.7 / self._width, 0.76 / self._height)
        self.figure.legend(
            handles=[Patch(color=colour, label=text)], loc="lower left", bbox_to_anchor=place, borderaxespad=0
        )

    def axes(self, scene: Scene, *, right: bool = False) -> None:
        """Arrows along the axes as a scene shows them, of a round length that is written beside them."""
        longest = ARROW * self._dpi * scene.pixel
        length = max(value for value in round_numbers(longest) if value <= longest * 1.001)
        side = 1.5 * self._dpi
        panel = self._axes(self._width * self._dpi - side if right else 0, 0, side, STRIP * self._dpi)
        panel.set(xlim=(0, 1.5), ylim=(0, STRIP))
        panel.set_axis_off()
        arrows = scene.view.screen.T * length / scene.pixel / self._dpi
        low, high = np.minimum(arrows.min(axis=0), 0), np.maximum(arrows.max(axis=0), 0)
        start = np.array([0.6, 0.6]) - (low + high) / 2
        for name, arrow in zip("xyz", arrows, strict=True):
            if np.linalg.norm(arrow) < 0.15 * ARROW:
                continue  # it points at the reader
            look = {"arrowstyle": "-|>", "color": "#444444", "shrinkA": 0, "shrinkB": 0, "linewidth": 0.9}
            panel.annotate("", start + arrow, start, arrowprops={**look, "mutation_scale": 7})
            place = start + arrow + 0.1 * arrow / np.linalg.norm(arrow)
            panel.text(*place, f"${name}$", ha="center", va="center", fontsize=9)
        panel.text(
            0.55,
            0.04,
            f"each {length:g} {self._unit}".strip() + " long",
            ha="center",
            va="bottom",
            fontsize=8,
        )


def round_numbers(about: float) -> list[float]:
    """1, 2, 5 and so on times powers of ten, around a number."""
    power = 10.0 ** np.floor(np.log10(about))
    return [float(f"{factor * power:.6g}") for factor in (0.5, 1, 2, 5)]
