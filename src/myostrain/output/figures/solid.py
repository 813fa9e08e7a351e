"""Pictures of a solid, drawn on the deformed body: potential, displacement, stress, isochrones, film."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from myostrain.output.figures.choice import choice
from myostrain.output.figures.data import Recording
from myostrain.output.figures.fibres import draw_recorded_fibres
from myostrain.output.figures.line import telling_frames
from myostrain.output.figures.maps import NodalMap, nodal_maps
from myostrain.output.figures.page import Page, scale
from myostrain.output.figures.scene import BARE, Look, Scene, looks, why_not
from myostrain.output.figures.sheet import FILM_DPI, PACE, REST, film_frames
from myostrain.output.figures.shown import colours, shown_fields
from myostrain.output.figures.style import (
    SEQUENTIAL,
    extend,
    plain,
    save,
    save_film,
)

import numpy as np
import numpy.typing as npt
from matplotlib import colormaps
from matplotlib.colors import BoundaryNorm, Normalize
from matplotlib.patheffects import withStroke
from PIL import Image

Array = npt.NDArray[np.float64]

log = logging.getLogger("myostrain")

#: Times that a picture shows at most.
PANELS = 6
#: Greys among the colours of a film, white and black with them; what is above is white.
GREYS, NEARLY_WHITE = 16, 243
#: A potential that differs less than this between places, as part of its size, tells nothing.
UNIFORM = 1e-3


def draw_solid(recording: Recording, folder: Path) -> list[Path]:
    """Draw the pictures of a solid: on the deformed body, with the outline of the reference body.

    ``potential.png``, ``displacement.png`` and ``stress.png`` show it at several times,
    ``activation-times.png`` the activation times on the reference body from two sides, ``fibres.png`` the
    fibres, and ``animation.gif`` the potential over time. Where the potential is the same everywhere, as
    in a benchmark of mechanics, its picture is left out, and the film shows the displacement. Ventricles are
    cut open.

    Where PyVista is not installed, or cannot draw, a warning is logged and nothing is drawn.

    Args:
        recording: The run, with at least one frame.
        folder: Where the pictures go.

    Returns:
        The files written: those for which the fields were recorded.
    """
    if (reason := why_not()) is not None:
        log.warning("no pictures of the body: %s; then `myostrain plot %s`", reason, recording.folder)
        return []
    return _Solid(recording, folder).draw()


class _Solid:
    """A recording, and what is common to its pictures."""

    def __init__(self, recording: Recording, folder: Path) -> None:
        self.recording, self.folder = recording, folder
        self.looks = looks(recording.points, recording.cells)
        self.film = recording.chosen_frames(film_frames(len(recording.time)))
        # All at the corners of the surface only: the inside of a fine body would fill the memory.
        self.seen = self.looks[0].surface
        self.moves = recording.has("displacement")
        rest = self.seen.at(recording.points)
        moved = self._history("displacement") if self.moves else np.zeros((1, *rest.shape))
        self.corners = np.broadcast_to(rest + moved, (len(self.film), *rest.shape))
        self.places = np.concatenate([recording.points, self.corners.reshape(-1, 3)])
        self.size = np.linalg.norm(moved, axis=2)
        potential = self._history("potential") if recording.has("potential") else None
        self.wave = potential is None or bool(
            np.ptp(potential, axis=1).max() > UNIFORM * np.abs(potential).max()
        )
        self.potential = potential if self.wave else None
        telling = self.size if self.potential is None else self.potential
        count = min(PANELS, len(self.film))
        self.times = (
            list(range(len(self.film)))
            if choice().times
            else (telling_frames(telling, count) if len(telling) == len(self.film) else [len(self.film) - 1])
        )

    def _history(self, name: str, times: Sequence[int] | None = None) -> Array:
        """A field at the corners of the surface, (times, p) or (times, p, 3); by default at all."""
        frames = self.film if times is None else [self.film[time] for time in times]
        return np.stack([self.seen.at(self.recording.field(name, frame)) for frame in frames])

    def draw(self) -> list[Path]:
        """Draw all that the recording has the fields for."""
        recording, written = self.recording, []
        filmed: tuple[str, Array] | None = None
        for name, field in shown_fields(recording, ("potential", "displacement", "stress")).items():
            whole = {"potential": self.potential, "displacement": self.size}.get(field)
            if field in ("potential", "displacement"):
                if whole is None or (field == "displacement" and not whole.max() > 0):
                    continue
                filmed = filmed or (field, whole)
                values, scaled = whole[self.times], whole
            else:
                values = scaled = self._history(field, self.times)
            path = self.folder / f"{name}.png"
            written.append(self._times(values, *colours(recording, field, scaled), path))
        if self.wave:
            maps = [each for each in nodal_maps(recording) if choice().wants(each.name)]
            written += [self._map(each, self.folder / f"{each.name}.png") for each in maps]
        if recording.fibres is not None and choice().wants("fibres"):
            written.append(draw_recorded_fibres(recording, self.folder / "fibres.png"))
        if len(self.film) > 1 and filmed is not None and choice().films:
            field, values = filmed
            written.append(
                self._film(values, *colours(recording, field, values), self.folder / "animation.gif")
            )
        return written

    def _scene(self, look: Look, pixel: float, finer: int = 2) -> Scene:
        X = self.recording.points
        return Scene(look, X, self.places, pixel, reference=self.moves, finer=finer)

    def _page(self, scenes: Sequence[Scene], columns: int, dpi: int | None = None) -> Page:
        return Page(self.recording.heading, self.recording.unit("length"), scenes, columns, dpi)

    def _times(self, values: Array, cmap: str, norm: Normalize, label: str, path: Path) -> Path:
        """A field (times, p) on the deformed body at the times that are shown."""
        look = self.looks[0]
        columns, pixel = scale([look.view], self.places, len(self.times))
        scene = self._scene(look, pixel)
        page = self._page([scene] * len(self.times), columns)
        scene.colour(values[0], cmap, norm)
        for number, time in enumerate(self.times):
            scene.move(self.corners[time], values[number])
            page.panel(number, scene.image(), self.recording.when(self.film[time]))
        scene.close()
        page.bar(norm, cmap, label, extend=extend(norm, values))
        page.axes(scene)
        return save(page.figure, path)

    def _map(self, shown: NodalMap, path: Path) -> Path:
        """A map in bands on the reference body, and the probes."""
        recording, levels = self.recording, shown.levels
        X = recording.points
        columns, pixel = scale([look.view for look in self.looks], X, len(self.looks))
        scenes = [Scene(look, X, X, pixel) for look in self.looks]
        page = self._page(scenes, columns)
        bands = colormaps[SEQUENTIAL].resampled(len(levels) - 1)
        for number, scene in enumerate(scenes):
            scene.isochrones(scene.look.surface.at(shown.values), levels, bands)
            panel = page.panel(number, scene.image(), scene.look.name)
            scene.close()
            page.axes(scene, right=number == 1)
            if number == 0:
                _mark(panel, scene, recording.probes)
        page.bar(BoundaryNorm(levels, bands.N), bands, shown.label)
        if np.isnan(shown.values).any():
            page.note(BARE, shown.missing)
        return save(page.figure, path)

    def _film(self, values: Array, cmap: str, norm: Normalize, label: str, path: Path) -> Path:
        """A field (frames, p) on the deformed body over time; all around it is drawn once."""
        look = self.looks[0]
        _, pixel = scale([look.view], self.places, 1, FILM_DPI)
        scene = self._scene(look, pixel, finer=1)
        page = self._page([scene], 1, FILM_DPI)
        page.bar(norm, cmap, label, extend=extend(norm, values))
        page.axes(scene)
        scene.colour(values[0], cmap, norm)
        page.panel(0, scene.image(), "", animated=True)
        canvas: Any = page.figure.canvas
        canvas.draw()
        still = canvas.copy_from_bbox(page.figure.bbox)
        images = []
        for time, frame in enumerate(self.film):
            scene.move(self.corners[time], values[time])
            canvas.restore_region(still)
            page.titled.set_text(self.recording.when(frame))
            page.titled.axes.draw_artist(page.titled)
            whole = np.array(canvas.buffer_rgba())[..., :3]
            whole[page.box(0)] = scene.image()
            images.append(Image.fromarray(whole))
        scene.close()
        palette = _palette(images)
        frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
        pace = [PACE] * (len(frames) - 1) + [REST]
        return save_film(frames, pace, path)


def _mark(panel: Any, scene: Scene, probes: dict[str, Array]) -> None:
    """Show where the probes are, also those within the body."""
    halo = [withStroke(linewidth=2.5, foreground="white")]
    for name, place in probes.items():
        x, y = scene.project(place[None])[0]
        panel.plot(x, y, "o", color="white", markeredgecolor="black", markersize=4, zorder=4)
        panel.annotate(
            plain(name), (x, y), (4, 4), textcoords="offset points", fontsize=9, path_effects=halo, zorder=5
        )


def _palette(images: Sequence[Image.Image]) -> Image.Image:
    """Colours for all frames of a film, so that no frame chooses its own and nothing flickers."""
    some = [images[i] for i in film_frames(len(images), 6)]
    width, height = some[0].size
    sheet = Image.new("RGB", (width, height * len(some)))
    for number, image in enumerate(some):
        sheet.paste(image, (0, number * height))
    found = np.array(sheet.quantize(256 - GREYS).getpalette() or [], dtype=np.uint8).reshape(-1, 3)
    found[found.min(axis=1) > NEARLY_WHITE] = 255  # else the page takes one of these for its white
    greys = np.repeat(np.linspace(0, 255, GREYS).round().astype(np.uint8)[:, None], 3, axis=1)
    palette = Image.new("P", (1, 1))
    palette.putpalette(np.concatenate([found[: 256 - GREYS], greys]).tobytes())
    return palette
