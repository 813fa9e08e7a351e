"""Pictures of a sheet: potential and stress on the deformed body (the paper's figure 3), isochrones, film."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from myostrain.output.figures.choice import choice
from myostrain.output.figures.data import Recording
from myostrain.output.figures.line import telling_frames
from myostrain.output.figures.maps import NodalMap, nodal_maps
from myostrain.output.figures.page import round_numbers
from myostrain.output.figures.raster import interpolated
from myostrain.output.figures.shown import colours, scalar, shown_fields
from myostrain.output.figures.style import (
    GREY,
    SEQUENTIAL,
    extend,
    new_figure,
    plain,
    save,
    save_film,
)

import numpy as np
import numpy.typing as npt
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation
from PIL import Image

Array = npt.NDArray[np.float64]

#: Times that a picture shows at most.
PANELS = 6
#: Longest scale bar, as a share of a panel's width.
BAR = 0.4
#: Of the film: most frames, dots per inch, milliseconds a frame and of the last.
FRAMES, FILM_DPI, PACE, REST = 60, 100, 80, 1500


def boundary_edges(cells: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Edges of a triangle mesh that belong to one triangle only.

    Args:
        cells: Node numbers (m, 3).

    Returns:
        Node numbers (k, 2) of the edges, each with the smaller number first.
    """
    edges = np.sort(cells[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    return unique[count == 1]


def film_frames(count: int, most: int = FRAMES) -> list[int]:
    """At most so many of ``count`` frames, as evenly spaced as can be, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int)).tolist()


def draw_sheet(recording: Recording, folder: Path) -> list[Path]:
    """Draw ``potential.png``, ``stress.png``, maps such as ``apd90.png``, ``animation.gif`` of a sheet.

    Args:
        recording: The run, with at least one frame.
        folder: Where the pictures go.

    Returns:
        The files written: those for which the fields were recorded.
    """
    written = []
    field = "potential" if recording.has("potential") else "displacement"
    telling = [len(recording.time) - 1]
    if recording.has(field) and not choice().times:
        history = recording.history(field).reshape(len(recording.time), -1)
        telling = telling_frames(history, min(PANELS, len(recording.time)))
    frames = recording.chosen_frames(telling)
    for name, field in shown_fields(recording, ("potential", "stress")).items():
        written.append(_stills(recording, field, frames, folder / f"{name}.png"))
    maps = [each for each in nodal_maps(recording) if choice().wants(each.name)]
    written += [_map(recording, each, folder / f"{each.name}.png") for each in maps]
    if recording.has("potential") and len(recording.time) > 1 and choice().films:
        written.append(_film(recording, folder / "animation.gif"))
    return written


def _page(
    recording: Recording, places: Array, *, deformed: bool, dpi: int | None = None
) -> tuple[Figure, Any]:
    """A figure whose one panel has equal axes and fits the places (n, 2)."""
    low, high = places.min(axis=0), places.max(axis=0)
    low, high = low - 0.04 * (high - low).max(), high + 0.04 * (high - low).max()
    width, height = np.maximum(5.4 * (high - low) / (high - low).max(), 1.2)
    # More for title, labels and colour bar, which is below a wide body.
    width, height = (width + 1.9, height + 1.2) if width < 1.5 * height else (width + 1.4, height + 2.2)
    figure = new_figure(width, height, recording.heading, compress=True, dpi=dpi)
    panel = figure.add_subplot(aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    x, y = ("x", "y") if deformed else ("X", "Y")
    panel.set(xlabel=recording.label(f"${x}$", "length"), ylabel=recording.label(f"${y}$", "length"))
    return figure, panel


def _outline(points: Array, edges: npt.NDArray[np.int64], colour: str, zorder: float = 3) -> LineCollection:
    return LineCollection(list(points[edges]), colors=colour, linewidths=0.8, capstyle="round", zorder=zorder)


def _bar(figure: Figure, panel: Any, mappable: Any, label: str, **options: Any) -> None:
    wide = np.ptp(panel.get_xlim()) > 1.5 * np.ptp(panel.get_ylim())
    place: dict[str, Any] = (
        {"location": "bottom", "aspect": 30} if wide else {"location": "right", "pad": 0.03}
    )
    bar = figure.colorbar(mappable, ax=panel, shrink=0.8, **place, **options)
    bar.set_label(label)
    bar.outline.set_visible(False)


def _stills(recording: Recording, field: str, frames: list[int], path: Path) -> Path:
    """A field on the deformed body at some frames, with the outline of the reference body."""
    values = [scalar(recording.field(field, frame)) for frame in frames]
    bodies = [recording.deformed(frame) for frame in frames]
    edges = boundary_edges(recording.cells)
    cmap, norm, label = colours(recording, field, np.concatenate(values))
    places = np.concatenate([recording.points, *bodies])
    if len(frames) == 1:
        figure, panel = _page(recording, places, deformed=True)
        panels = [panel]
    else:
        figure, panels = _panels(recording, places, len(frames))
    for panel, frame, x, v in zip(panels, frames, bodies, values, strict=True):
        if recording.has("displacement"):
            panel.add_collection(_outline(recording.points, edges, GREY, zorder=1))
        body = Triangulation(*x.T, recording.cells)
        image = panel.tripcolor(body, v, shading="gouraud", zorder=2, cmap=cmap, norm=norm, rasterized=True)
        panel.add_collection(_outline(x, edges, "black"))
        panel.set_title(recording.when(frame))
    extended = extend(norm, np.concatenate(values))
    if len(frames) == 1:
        _bar(figure, panels[0], image, label, extend=extended)
    else:
        ticks = MaxNLocator(5)  # of which labels as long as −0.175 still stand apart
        bar = figure.colorbar(
            image, ax=panels, location="bottom", shrink=0.5, aspect=35, extend=extended, ticks=ticks
        )
        bar.set_label(label)
        bar.outline.set_visible(False)
    return save(figure, path)


def _panels(recording: Recording, places: Array, count: int) -> tuple[Figure, list[Any]]:
    """A figure with equal panels side by side, in rows of equal length, and a scale bar below the first."""
    low, high = places.min(axis=0), places.max(axis=0)
    side = (high - low).max()
    low, high = low - 0.02 * side, high + 0.02 * side
    width, height = np.maximum(3.0 * (high - low) / side, 0.8)
    rows = -(-count // min(count, max(1, int(9.0 / width))))
    columns = -(-count // rows)
    figure = new_figure(
        columns * (width + 0.25) + 0.6, rows * (height + 0.45) + 1.4, recording.heading, compress=True
    )
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    for panel in grid.reshape(-1):
        panel.set(aspect="equal", xlim=(low[0], high[0]), ylim=(low[1] - 0.12 * side, high[1]))
        panel.axis("off")
    _scale_bar(grid[0, 0], low[0] + 0.02 * side, low[1] - 0.03 * side, BAR * (high - low)[0], recording)
    return figure, list(grid.reshape(-1)[:count])


def _scale_bar(panel: Any, x: float, y: float, longest: float, recording: Recording) -> None:
    """A bar of a round length, that is written below it, with its left end at (x, y)."""
    length = max(value for value in round_numbers(longest) if value <= longest * 1.001)
    panel.plot([x, x + length], [y, y], color="#444444", linewidth=2, solid_capstyle="butt", clip_on=False)
    words = f"{length:g} {recording.unit('length')}".strip()
    place = {"textcoords": "offset points", "ha": "center", "va": "top", "fontsize": 8}
    panel.annotate(words, (x + length / 2, y), (0, -3), **place)


def _map(recording: Recording, shown: NodalMap, path: Path) -> Path:
    """A map in bands on the reference body, and the probes."""
    X, cells = recording.points, recording.cells
    never, levels = np.isnan(shown.values), shown.levels
    figure, panel = _page(recording, X, deformed=False)
    panel.tripcolor(
        Triangulation(*X.T, cells), np.zeros(len(X)), cmap=ListedColormap(["#e4e4e4"]), shading="gouraud"
    )
    body = Triangulation(*X.T, cells, mask=never[cells].any(axis=1))
    known = np.where(never, levels[0], shown.values)
    norm = Normalize(levels[0], levels[-1])
    image = panel.tricontourf(body, known, levels=levels, cmap=SEQUENTIAL, extend=extend(norm, known))
    panel.tricontour(body, known, levels=levels, colors="white", linewidths=0.6)
    panel.add_collection(_outline(X, boundary_edges(cells), "black"))
    _bar(figure, panel, image, shown.label)
    halo = [withStroke(linewidth=2.5, foreground="white")]
    for name, place in recording.probes.items():
        panel.plot(*place, "o", color="white", markeredgecolor="black", markersize=5, zorder=4)
        panel.annotate(
            plain(name), place, (5, 4), textcoords="offset points", fontsize=9, path_effects=halo, zorder=5
        )
    if never.any():
        panel.legend(
            handles=[Patch(color="#e4e4e4", label=shown.missing)], loc="lower left", bbox_to_anchor=(0, 1)
        )
    return save(figure, path)


def _film(recording: Recording, path: Path) -> Path:
    """v on the deformed body over time.

    All that stands still is drawn once; a frame costs its pixels and one look-up in a fixed palette.
    """
    frames = film_frames(len(recording.time))
    places, extremes = [recording.points], []
    for frame in frames:
        x = recording.deformed(frame)
        places.append(np.array([x.min(axis=0), x.max(axis=0)]))
        v = recording.field("potential", frame)
        extremes += [np.nanmin(v), np.nanmax(v)]
    norm = Normalize(*recording.potential_range(np.array(extremes)))
    figure, panel = _page(recording, np.concatenate(places), deformed=True, dpi=FILM_DPI)
    edges = boundary_edges(recording.cells)
    if recording.has("displacement"):
        panel.add_collection(_outline(recording.points, edges, GREY, zorder=1))
    label = recording.label("potential $v$", "potential")
    _bar(figure, panel, ScalarMappable(norm, SEQUENTIAL), label, extend=extend(norm, np.array(extremes)))
    clock = panel.set_title(recording.when(-1), animated=True)
    canvas: Any = figure.canvas
    canvas.draw()
    still = canvas.copy_from_bbox(figure.bbox)
    page = np.asarray(canvas.buffer_rgba())
    height, width, _ = page.shape
    mapped = ScalarMappable(norm, SEQUENTIAL)
    outline = panel.add_collection(_outline(recording.points, edges, "black"), autolim=False)
    palette, images = _palette(), []
    for frame in frames:
        canvas.restore_region(still)
        x = recording.deformed(frame)
        places = panel.transData.transform(x) * [1, -1] + [0, height]
        pixels, v = interpolated(places, recording.cells, recording.field("potential", frame), width, height)
        page.reshape(-1, 4)[pixels] = mapped.to_rgba(v, bytes=True)
        outline.set_segments(x[edges])
        clock.set_text(recording.when(frame))
        panel.draw_artist(outline)
        panel.draw_artist(clock)
        whole = Image.frombuffer("RGBA", (width, height), page, "raw", "RGBA", 0, 1).convert("RGB")
        images.append(whole.quantize(palette=palette, dither=Image.Dither.NONE))
    pace = [PACE] * (len(images) - 1) + [REST]
    return save_film(images, pace, path)


def _palette() -> Image.Image:
    """The colours of a film: the map's and greys, so that no frame chooses its own and nothing flickers."""
    hues = ScalarMappable(Normalize(0, 1), SEQUENTIAL).to_rgba(np.linspace(0, 1, 232), bytes=True)[:, :3]
    greys = np.repeat(np.linspace(0, 255, 24).round().astype(np.uint8)[:, None], 3, axis=1)
    palette = Image.new("P", (1, 1))
    palette.putpalette(np.concatenate([hues, greys]).tobytes())
    return palette
