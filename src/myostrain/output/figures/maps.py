"""What there is of every node at the end of a run, as maps: activation, duration, conduction velocity."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from myostrain.output.figures.data import Recording
from myostrain.output.figures.style import BLUE, new_figure, save

import numpy as np
import numpy.typing as npt
from matplotlib.ticker import MaxNLocator

Array = npt.NDArray[np.float64]

#: Shares of the nodes below both ends of a scale: around cores and where waves meet or end are outliers.
OUTLIERS = (0.05, 0.95)
#: A map whose values differ less than this, as part of their size, is of one value.
SAME = 1e-3


@dataclass(frozen=True)
class NodalMap:
    """A map.

    Args:
        name: Of its picture.
        values: At the nodes, (n,); NaN for none.
        levels: Ends of its bands, ascending.
        label: What it is, with its unit.
        missing: What it means where there is none.
    """

    name: str
    values: Array
    levels: Array
    label: str
    missing: str


def band_levels(values: Array, count: int = 12) -> Array:
    """Round numbers, evenly spaced, that enclose all given ones.

    Args:
        values: Values, NaN for none.
        count: At most so many intervals.

    Returns:
        At least two levels, ascending; none where there is no value, or one only.
    """
    if np.isnan(values).all() or np.nanmin(values) == np.nanmax(values):
        return np.empty(0)
    locator = MaxNLocator(count, steps=[1, 2, 2.5, 5, 10])
    return np.asarray(locator.tick_values(np.nanmin(values), np.nanmax(values)))


def nodal_maps(recording: Recording) -> list[NodalMap]:
    """The maps of a run with something to see: ``activation-times``, ``apd90``, ``conduction-velocity``."""
    times = recording.activation()
    found: list[NodalMap] = []
    if times is None:
        return found
    label = recording.label("activation time", "time")
    found.append(NodalMap("activation-times", times, band_levels(times), label, "not activated"))
    for percent, values in recording.durations().items():
        label = recording.label(f"APD{percent}", "time")
        found.append(NodalMap(f"apd{percent}", values, _levels(values), label, "no beat has ended"))
    if "conduction_velocity" in recording.maps:
        values = recording.maps["conduction_velocity"][0]
        label = recording.rate_label("conduction velocity", "length", "time")
        found.append(NodalMap("conduction-velocity", values, _levels(values), label, "no velocity"))
    whole = [np.isfinite(each.values)[recording.cells].all(axis=1).any() for each in found]
    return [each for each, some in zip(found, whole, strict=True) if some and len(each.levels)]


def _levels(values: Array) -> Array:
    """Levels for values with outliers, or that may all be nearly the same."""
    if np.isnan(values).all():
        return np.empty(0)
    low, high = np.nanquantile(values, OUTLIERS)
    size = SAME * max(abs(low), abs(high))
    if high - low < size:
        low, high = low - 5 * size, high + 5 * size
    return band_levels(np.array([low, high]))


def draw_line_maps(recording: Recording, path: Path) -> list[Path]:
    """Draw the maps of a line, over X; none where there are none."""
    maps = nodal_maps(recording)
    if not maps:
        return []
    figure = new_figure(7.2, 0.9 + 1.9 * len(maps), recording.heading)
    panels = figure.subplots(len(maps), 1, sharex=True, squeeze=False)[:, 0]
    order = np.argsort(recording.points[:, 0])
    for panel, each in zip(panels, maps, strict=True):
        panel.plot(recording.points[order, 0], each.values[order], color=BLUE)
        panel.set_ylabel(each.label)
        panel.margins(x=0)
        if each.name != "activation-times":
            panel.set_ylim(each.levels[0], each.levels[-1])
    panels[-1].set_xlabel(recording.label("material $X$", "length"))
    figure.align_ylabels()
    return [save(figure, path)]
