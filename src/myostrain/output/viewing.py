"""A run as an interactive page: one HTML file, which needs no network and no other file."""

from __future__ import annotations

import base64
import html
import json
from pathlib import Path
from typing import Any

from myostrain.errors import InputError
from myostrain.output.figures.data import Recording
from myostrain.output.figures.shown import colours, scalar
from myostrain.output.figures.surface import boundary
from myostrain.output.folder import check_path, write_atomically, writing
from myostrain.output.page import page

import numpy as np
import numpy.typing as npt
from matplotlib import colormaps

Array = npt.NDArray[np.float64]

#: Frames, fibres and samples of a probe that a page has at most.
FRAMES, FIBRES, SAMPLES = 60, 4000, 500

#: Bytes of the fields on a page; with more there are fewer frames.
MOST = 40_000_000


def view(folder: str | Path, out: str | Path | None = None) -> Path:
    """Write a page that shows a run: a slider for the time, fields, the deformed body, a cut, fibres, probes.

    Args:
        folder: The result folder, also of a run that goes on or failed.
        out: The page; ``view.html`` in the folder by default. Is replaced.

    Returns:
        The page.

    Raises:
        InputError: The folder holds no frames, or the page cannot be written.
    """
    folder = Path(folder)
    check_path(folder, "DIR")
    run = Recording(folder)
    if not len(run.time):
        raise InputError(f"{folder} holds no frame yet: there is nothing to see")
    path = Path(out) if out is not None else folder / "view.html"
    check_path(path, "--out")
    here = Path(__file__).with_name
    data = json.dumps(_content(run)).replace("</", "<\\/")
    body = "\n".join(
        [
            f"<style>{here('viewer.css').read_text(encoding='utf-8')}</style>",
            here("viewer.html").read_text(encoding="utf-8"),
            f'<script type="application/json" id="data">{data}</script>',
            f"<script>{here('viewer.js').read_text(encoding='utf-8')}</script>",
        ]
    )
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, page(html.escape(run.title), body))
    return path


def _content(run: Recording) -> dict[str, Any]:
    """All that the page shows."""
    dim = run.dim
    nodes, cells = _seen(run)
    frames = _frames(run, len(nodes))
    fields, moved = [], None
    for name in sorted(run.snapshots.names):
        raw = np.stack([run.field(name, frame)[nodes] for frame in frames])
        values = raw if raw.ndim == 2 else np.stack([scalar(each) for each in raw])
        cmap, norm, label = colours(run, name, values)
        low, high = float(norm.vmin or 0.0), float(norm.vmax or 0.0)  # both are there
        fields.append(
            {
                "name": name,
                "label": label.replace("$", "").replace(r"\gamma", "γ"),
                "low": low,
                "high": high,
                "map": cmap,
                **_packed(values),
            }
        )
        if name == "displacement":
            moved = _packed(_in_space(raw))
    maps = {each["map"] for each in fields}
    return {
        "dim": dim,
        "points": _floats(_in_space(run.points[nodes])),
        "cells": _integers(cells),
        "fields": fields,
        "displacement": moved,
        "times": [float(run.time[frame]) for frame in frames],
        "timeUnit": run.unit("time"),
        "lengthUnit": run.unit("length"),
        "maps": {name: _hues(name) for name in maps},
        "fibres": _fibres(run),
        "probes": _probes(run),
    }


def _hues(name: str) -> list[list[int]]:
    """Red, green and blue of a colour map, from its lower to its upper end."""
    hues: list[list[int]] = (colormaps[name](np.linspace(0, 1, 256))[:, :3] * 255).astype(int).tolist()
    return hues


def _seen(run: Recording) -> tuple[Any, Any]:
    """Nodes that are seen, and lines or triangles between them: of a solid its boundary, else all."""
    if run.dim < 3:
        return np.arange(len(run.points)), run.cells
    surface = boundary(run.points, run.cells)
    return surface.first, surface.triangles


def _frames(run: Recording, nodes: int) -> list[int]:
    """At most so many frames that the page stays small, evenly spread, the first and the last among them."""
    each = 2 * nodes * (len(run.snapshots.names) + 3)
    most = max(2, min(FRAMES, MOST // each))
    return np.unique(np.linspace(0, len(run.time) - 1, most).round().astype(int)).tolist()


def _fibres(run: Recording) -> dict[str, str] | None:
    """Fibres at the centres of some cells: places and directions."""
    if run.fibres is None:
        return None
    some = np.linspace(0, len(run.cells) - 1, min(len(run.cells), FIBRES)).round().astype(int)
    centres = run.points[run.cells[some]].mean(axis=1)
    return {"points": _floats(_in_space(centres)), "directions": _floats(_in_space(run.fibres[some]))}


def _probes(run: Recording) -> list[dict[str, Any]]:
    """Where the probes are, and the potential there over time."""
    times, histories = run.probe_histories("potential")
    every = np.linspace(0, max(0, len(times) - 1), min(len(times), SAMPLES))
    some = np.unique(every.round().astype(int)).tolist()
    found = []
    for name, place in run.probes.items():
        values = histories.get(name, np.empty(0))
        curve = [float(f"{values[i]:.5g}") for i in some] if len(values) else []
        nearest = int(np.linalg.norm(run.points - place, axis=1).argmin())
        found.append(
            {
                "name": name,
                "point": [*map(float, place), *[0.0] * (3 - len(place))],
                "moved": _node(run, nearest),
                "times": [float(f"{times[i]:.6g}") for i in some],
                "values": curve,
            }
        )
    return found


def _node(run: Recording, node: int) -> list[list[float]]:
    """Displacement of a node at the frames of the page."""
    if not run.has("displacement"):
        return []
    frames = _frames(run, len(_seen(run)[0]))
    return [[float(f"{x:.6g}") for x in _in_space(run.field("displacement", f)[[node]])[0]] for f in frames]


def _in_space(vectors: Array) -> Array:
    """Vectors (..., dim) with three components."""
    return np.pad(vectors, [*[(0, 0)] * (vectors.ndim - 1), (0, 3 - vectors.shape[-1])])


def _packed(values: Array) -> dict[str, Any]:
    """Values as 16-bit shares of their range."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    span = high - low or 1.0
    shares = np.nan_to_num((values - low) / span * 65535).round().astype("<u2")
    return {"least": low, "span": span, "data": base64.b64encode(shares.tobytes()).decode()}


def _floats(values: Array) -> str:
    return base64.b64encode(values.astype("<f4").tobytes()).decode()


def _integers(values: Any) -> str:
    return base64.b64encode(np.asarray(values).astype("<u4").tobytes()).decode()
