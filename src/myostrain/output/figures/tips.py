"""Trajectories of the tips of spiral waves on a sheet."""

from __future__ import annotations

from pathlib import Path

from myostrain.output.figures.data import Recording
from myostrain.output.figures.sheet import boundary_edges
from myostrain.output.figures.style import SEQUENTIAL, new_figure, save

import numpy as np
from matplotlib.collections import LineCollection


def draw_tips(recording: Recording, twin: Recording | None, path: Path) -> list[Path]:
    """Draw where the tips were, coloured by time: in the reference body, and in space where it deforms.

    Args:
        recording: The run.
        twin: Its rigid twin, whose tips are drawn beside.
        path: Where to.

    Returns:
        The file; none where no tip was recorded.
    """
    found = recording.table("tip.csv")
    if not len(found.get("time", ())):
        return []
    X, x = (np.column_stack([found[name] for name in names]) for names in ("XY", "xy"))
    panels = [(f"reference body{_turning(recording)}", "$X$", "$Y$", X, found["time"])]
    if twin is not None and len((other := twin.table("tip.csv")).get("time", ())):
        places = np.column_stack([other["X"], other["Y"]])
        panels.append((f"rigid body{_turning(twin)}", "$X$", "$Y$", places, other["time"]))
    if recording.has("displacement") and not np.array_equal(X, x):
        panels.append(("in space", "$x$", "$y$", x, found["time"]))
    outline = recording.points[boundary_edges(recording.cells)]
    low, high = recording.points.min(axis=0), recording.points.max(axis=0)
    margin = 0.04 * (high - low).max()
    width, height = np.maximum(4.2 * (high - low) / (high - low).max(), 1.5)
    figure = new_figure(1.3 + (width + 0.7) * len(panels), height + 1.8, recording.heading, compress=True)
    axes = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    first, last = found["time"].min(), found["time"].max()
    for panel, (title, across, up, places, times) in zip(axes, panels, strict=True):
        # At rest, faintly: what it is in space changes all the time.
        panel.add_collection(LineCollection(list(outline), colors="#444444", linewidths=0.7))
        dots = panel.scatter(
            *places.T, c=times, s=4, cmap=SEQUENTIAL, vmin=first, vmax=max(last, first + 1e-12), linewidths=0
        )
        panel.set(aspect="equal", xlim=(low[0] - margin, high[0] + margin), title=title)
        panel.set(ylim=(low[1] - margin, high[1] + margin))
        panel.set(xlabel=recording.label(across, "length"), ylabel=recording.label(up, "length"))
    bar = figure.colorbar(dots, ax=list(axes), shrink=0.8, pad=0.02)
    bar.set_label(recording.label("$t$", "time"))
    bar.outline.set_visible(False)
    return [save(figure, path)]


def _turning(recording: Recording) -> str:
    """A line with period and radius of the core, where they were found."""
    found = recording.metrics
    if found.get("tip_period") is None:
        return ""
    return f"\nperiod {found['tip_period']:.4g}, core radius {found['tip_radius']:.3g}"
