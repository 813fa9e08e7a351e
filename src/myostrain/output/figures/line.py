"""Pictures of a line: its pulse at the end, over space and time, as it forms (the paper's figures 1, 2)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from myostrain.output.figures.choice import choice
from myostrain.output.figures.data import Recording
from myostrain.output.figures.maps import draw_line_maps
from myostrain.output.figures.shown import colours, shown_fields
from myostrain.output.figures.style import (
    BLUE,
    GREY,
    POTENTIAL,
    SEQUENTIAL,
    VERMILION,
    extend,
    new_figure,
    save,
)

import numpy as np
import numpy.typing as npt
from matplotlib import colormaps
from matplotlib.colors import Normalize

Array = npt.NDArray[np.float64]

#: Rows of the table under the pulse: what it says, the metric's name, and whether it is over a time.
_TABLE = (
    ("celerity", "celerity", True),
    ("width in $X$", "width_material", False),
    ("width in $x$", "width_spatial", False),
)


def sorted_line(coordinate: Array, *values: Array) -> tuple[Array, ...]:
    """A line's nodes from left to right.

    Args:
        coordinate: Material coordinates (n,) in any order.
        values: Nodal values (..., n).

    Returns:
        Coordinates and values in ascending order of the coordinates.
    """
    order = np.argsort(coordinate, kind="stable")
    return coordinate[order], *(value[..., order] for value in values)


def telling_frames(v: Array, count: int) -> list[int]:
    """Frames that share the whole change of the potential evenly.

    A pulse that travels is shown at even times, one that decays fast more often at first.

    Args:
        v: Potential (frames, n).
        count: How many frames, two or more.

    Returns:
        Numbers of at most ``count`` different frames, ascending, the first and the last among them.
    """
    travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(v, axis=0)).sum(axis=1))])
    wanted = np.linspace(0, travelled[-1], count)
    nearest = np.abs(travelled[:, None] - wanted).argmin(axis=0)
    return sorted({0, len(v) - 1, *nearest[1:-1].tolist()})


def leading_edge(X: Array, v: Array, level: float = 0.5) -> Array:
    """The farthest place where the potential falls through a level, linear between nodes.

    Args:
        X: Material coordinates (n,), ascending.
        v: Potential (frames, n).
        level: The level.

    Returns:
        Places (frames,), NaN where the potential does not fall through the level.
    """
    falls = (v[:, :-1] >= level) & (v[:, 1:] < level)
    last = falls.shape[1] - 1 - falls[:, ::-1].argmax(axis=1)
    frames = np.arange(len(v))
    before, after = v[frames, last], v[frames, last + 1]
    share = (level - before) / np.where(before == after, 1.0, after - before)
    return np.where(falls.any(axis=1), X[last] + share * (X[last + 1] - X[last]), np.nan)


def resampled(values: Array, at: Array, count: int) -> Array:
    """Values at evenly spaced places, linear between the given ones.

    Args:
        values: Values (n, k).
        at: Where they are, (n,), strictly ascending, two or more.
        count: How many places, from the first to the last of ``at``.

    Returns:
        Values (count, k).
    """
    places = np.linspace(at[0], at[-1], count)
    i = np.clip(np.searchsorted(at, places, side="right") - 1, 0, len(at) - 2)
    share = ((places - at[i]) / (at[i + 1] - at[i]))[:, None]
    return (1 - share) * values[i] + share * values[i + 1]


def draw_line(recording: Recording, twin: Recording | None, folder: Path) -> list[Path]:
    """Draw ``potential.png``, ``evolution.png``, ``space-time.png`` and ``maps.png`` of a line.

    Args:
        recording: The run, with at least one frame.
        twin: Its rigid twin, if there is one.
        folder: Where the pictures go.

    Returns:
        The files written; none if the potential was not recorded.
    """
    if not recording.has("potential"):
        return []
    if twin is not None and not (twin.dim == 1 and twin.has("potential")):
        twin = None
    wants, written = choice().wants, []
    if wants("potential"):
        written.append(_pulse(recording, twin, folder / "potential.png"))
    if len(recording.time) > 1:
        if wants("evolution"):
            written.append(_evolution(recording, "potential", folder / "evolution.png"))
        if wants("space-time"):
            written.append(_space_time(recording, twin, folder / "space-time.png"))
    for name, field in shown_fields(recording, ()).items():
        if field != "potential":
            written.append(_evolution(recording, field, folder / f"{name}.png"))
    return written + (draw_line_maps(recording, folder / "maps.png") if wants("maps") else [])


def _pulse(recording: Recording, twin: Recording | None, path: Path) -> Path:
    """v over x and below v and w over X at the last frame: the paper's figure 1."""
    moves = recording.has("displacement")
    table = _table(recording, {} if twin is None else twin.metrics, moves)
    heights = ([2.6] if moves else []) + [2.6] + ([0.24 * (len(table) + 1)] if table else [])
    figure = new_figure(7.2, sum(heights) + 0.9, recording.heading)
    panels = figure.subplots(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0]
    runs: list[tuple[Recording, int, dict[str, Any]]] = [
        (recording, -1, {"color": BLUE, "label": "contracting" if moves else "rigid", "zorder": 2.2})
    ]
    if twin is not None:
        same_time = int(np.abs(twin.time - recording.time[-1]).argmin())
        runs.append((twin, same_time, {"color": VERMILION, "label": "rigid", "dashes": (4, 2)}))
    material = panels[1 if moves else 0]
    recovery = recording.has("recovery") and _scaled(recording)
    for run, frame, line in runs:
        material.plot(*_over(run, frame, run.points), **line)
        if moves:
            panels[0].plot(*_over(run, frame, run.deformed(frame)), **line)
    for run, frame, line in runs:
        if recovery and run.has("recovery"):
            label = "recovery $w$" if run is recording else None
            thin = line | {"label": label, "linewidth": 0.9, "alpha": 0.85}
            material.plot(*_over(run, frame, run.points, "recovery"), **thin)
    _axes(material, recording, "material $X$" if moves else "$X$", with_recovery=recovery)
    if moves:
        _axes(panels[0], recording, "spatial $x$")
        same = _both(panels[0].get_xlim(), material.get_xlim())
        panels[0].set_xlim(same)
        material.set_xlim(same)
    for panel in panels[: 1 + moves]:
        if _scaled(recording):
            panel.set_ylim(*_both(panel.get_ylim(), (POTENTIAL[0], POTENTIAL[1] + 0.08)))
        panel.legend(loc="best")
    panels[0].set_title(recording.when(-1))
    if table:
        _write_table(panels[-1], table, [run[2] for run in runs])
    return save(figure, path)


def _both(one: tuple[float, float], other: tuple[float, float]) -> tuple[float, float]:
    return min(one[0], other[0]), max(one[1], other[1])


def _scaled(recording: Recording) -> bool:
    """Whether the potential is one of those that rest at 0 and peak near 1."""
    return recording.potential_range(recording.field("potential")) == POTENTIAL


def _over(run: Recording, frame: int, coordinates: Array, name: str = "potential") -> tuple[Array, ...]:
    """Abscissae and values of one curve; the nodes are sorted by X, so that a fold of x would show."""
    _, x, values = sorted_line(run.points[:, 0], coordinates[:, 0], run.field(name, frame).reshape(-1))
    return x, values


def _axes(panel: Any, recording: Recording, name: str, *, with_recovery: bool = False) -> None:
    """Labels of a panel that shows v over a coordinate, no margin at the sides, a thin line at rest."""
    panel.margins(x=0)
    panel.set_xlabel(recording.label(name, "length"))
    panel.set_ylabel(recording.label("$v$, $w$" if with_recovery else "$v$", "potential"))
    panel.axhline(recording.rest, color=GREY, linewidth=0.5, zorder=1)


def _table(recording: Recording, twin: dict[str, Any], moves: bool) -> list[list[str]]:
    """Rows of text: what, the run's, the twin's, their ratio; without the latter if there is no twin."""
    rows, length, time = [], recording.unit("length"), recording.unit("time")
    for label, name, rate in _TABLE:
        mine, other = recording.metrics.get(name), twin.get(name)
        if mine is None or (name == "width_spatial" and not moves):
            continue
        unit = (f"{length}/{time}" if time else "") if rate else length
        row = [f"{label} ({unit})" if length and unit else label, f"{mine:.4g}"]
        if twin:
            row += ["–", "–"] if other is None else [f"{other:.4g}", f"{mine / other:.3f}" if other else "–"]
        rows.append(row)
    return rows


def _write_table(panel: Any, rows: list[list[str]], lines: list[dict[str, Any]]) -> None:
    panel.axis("off")
    columns = np.linspace(0.28, 0.82, 4)
    heads = [*((line["label"], line["color"]) for line in lines), ("ratio", "black")]
    step = 1 / (len(rows) + 1)
    for column, (head, colour) in zip(columns[1 : len(rows[0])], heads, strict=False):
        panel.text(column, 1 - step / 2, head, color=colour, ha="right", va="center", weight="bold")
    for i, row in enumerate(rows, start=1):
        for column, text in zip(columns, row, strict=False):
            panel.text(column, 1 - (i + 0.5) * step, text, ha="right", va="center")


def _evolution(recording: Recording, field: str, path: Path, count: int = 6) -> Path:
    """A field over x at a few times; of v the paper's figure 2."""
    frames = recording.chosen_frames(telling_frames(recording.history("potential"), count))
    figure = new_figure(7.2, 3.6, recording.heading)
    panel = figure.add_subplot()
    hues = colormaps[SEQUENTIAL](np.linspace(0.0, 0.9, len(frames)))
    for frame, colour in zip(frames, hues, strict=True):
        panel.plot(
            *_over(recording, frame, recording.deformed(frame), field),
            color=colour,
            label=recording.when(frame),
        )
    _axes(panel, recording, "spatial $x$" if recording.has("displacement") else "$X$")
    if field != "potential":
        _, _, label = colours(recording, field, np.zeros(1))
        panel.set_ylabel(recording.label("displacement $u$", "length") if field == "displacement" else label)
    panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return save(figure, path)


def _space_time(recording: Recording, twin: Recording | None, path: Path) -> Path:
    """v over X and t, with the twin's front dashed."""
    X, v = sorted_line(recording.points[:, 0], recording.history("potential"))
    figure = new_figure(7.2, 4.4, recording.heading)
    panel = figure.add_subplot()
    norm = Normalize(*recording.potential_range(v))
    fine = resampled(resampled(v, recording.time, 600).T, X, 1200).T
    extent = (X[0], X[-1], recording.time[0], recording.time[-1])
    image = panel.imshow(fine, norm=norm, extent=extent, origin="lower", aspect="auto")
    bar = figure.colorbar(image, ax=panel, extend=extend(norm, v), pad=0.02)
    bar.set_label(recording.label("potential $v$", "potential"))
    bar.outline.set_visible(False)
    if twin is not None:
        X, v = sorted_line(twin.points[:, 0], twin.history("potential"))
        panel.plot(
            leading_edge(X, v, twin.threshold),
            twin.time,
            color="white",
            dashes=(4, 2),
            linewidth=1.3,
            label=f"rigid front, $v$ = {twin.threshold:g}",
        )
        panel.legend(loc="lower right", labelcolor="white")
    panel.set(xlim=(X[0], X[-1]), ylim=(recording.time[0], recording.time[-1]))
    panel.set(xlabel=recording.label("material $X$", "length"), ylabel=recording.label("$t$", "time"))
    return save(figure, path)
