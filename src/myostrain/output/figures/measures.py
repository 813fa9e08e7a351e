"""What is measured of a solid over time, strains in the segments of a left ventricle, and its bull's eye."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from myostrain.output.figures.data import Recording
from myostrain.output.figures.style import COLOURS, GREY, new_figure, plain, save, symmetric_range
from myostrain.output.quantities import attributes
from myostrain.output.reader import ROUNDING
from myostrain.output.segment_names import COUNT, NAMES

import numpy as np
import numpy.typing as npt
from matplotlib import colormaps

Array = npt.NDArray[np.float64]

STRAINS = ("longitudinal", "circumferential", "radial")

#: Letters in a line of a panel's title.
TITLE = 36

#: Changes of less than this share of a value are not shown as changes.
LEAST = 1e-3

#: What has pictures of its own, or the sum of which is there.
ELSEWHERE = re.compile(r"time|(volume|pressure|reaction)_.*|.*(?<!_)_\d+|(?!apex_).*_strain")


def draw_measures(recording: Recording, folder: Path) -> list[Path]:
    """Draw ``measures.png``, what ``measures.csv`` has over time, and pictures of segments if it has them.

    ``strains.png`` has the strains of the 17 segments over time, ``bullseye.png`` the greatest ones, and the
    greatest stress of the fibre, where they are. Strains in the pictures are those since the first row, as
    since the end of diastole where a run begins with the preload.

    Args:
        recording: The run.
        folder: Where the pictures go.

    Returns:
        The files; none of a run without measures.
    """
    table = recording.table("measures.csv")
    if len(table.get("time", ())) < 2:
        return []
    written = []
    shown = [name for name in table if name == "volume_ratio" or not ELSEWHERE.fullmatch(name)]
    if recording.dim < 3:  # of a solid there is much else
        shown += forces(recording, table)
    if shown:
        written.append(_over_time(recording, {name: table[name] for name in shown}, table["time"], folder))
    if f"{STRAINS[0]}_strain_{COUNT}" in table:
        strains = {kind: since_first(table, kind) for kind in STRAINS}
        written.append(_strains(recording, strains, table["time"], folder))
        written.append(_bulls_eyes(recording, strains, table, folder))
    return written


def forces(recording: Recording, table: Mapping[str, Array]) -> list[str]:
    """Columns of forces, without sums that vanish, such as those of springs all round."""
    largest = {name: np.abs(values).max() for name, values in table.items() if name.startswith("reaction_")}
    least = max(recording.least_force, ROUNDING * max(largest.values(), default=0.0))
    return [name for name, force in largest.items() if force > least]


def since_first(table: Mapping[str, Array], kind: str) -> Array:
    """Strains (17, rows) of the segments since the first row, as shares of the lengths then."""
    stretch = 1 + np.array([table[f"{kind}_strain_{n}"] for n in range(1, COUNT + 1)])
    return np.asarray(stretch / stretch[:, :1] - 1)


def _over_time(recording: Recording, shown: Mapping[str, Array], time: Array, folder: Path) -> Path:
    columns = min(3, len(shown))
    rows = -(-len(shown) // columns)
    figure = new_figure(2.8 * columns, 0.6 + 1.9 * rows, recording.heading)
    panels = figure.subplots(rows, columns, sharex=True, squeeze=False).reshape(-1)
    for panel, (name, values) in zip(panels, shown.items(), strict=False):
        about = attributes(name, recording.units or {}, recording.dim)
        unit = about.get("units", "1")
        panel.plot(time, values, color=COLOURS[0])
        words = about["long_name"] + (f" ({unit})" if unit != "1" else "")
        panel.set_title(plain(textwrap.fill(words, TITLE)), fontsize=8)
        panel.margins(x=0)
        _widen(panel, values)
    for panel in panels[len(shown) :]:
        panel.set_axis_off()
    for panel in panels[-columns:]:
        panel.set(xlabel=recording.label("$t$", "time"))
    return save(figure, folder / "measures.png")


def _widen(panel: Any, values: Array) -> None:
    """Show what hardly changes as what hardly changes."""
    middle, least = (values.max() + values.min()) / 2, LEAST * np.abs(values).max()
    if np.ptp(values) < least:
        panel.set_ylim(middle - least, middle + least)


def _strains(recording: Recording, strains: Mapping[str, Array], time: Array, folder: Path) -> Path:
    figure = new_figure(7.6, 3.0, recording.heading)
    panels = figure.subplots(1, len(strains), sharex=True)
    rings = [(range(6), "basal"), (range(6, 12), "mid"), (range(12, 16), "apical"), (range(16, 17), "apex")]
    for panel, (kind, values) in zip(panels, strains.items(), strict=True):
        for (ring, name), colour in zip(rings, COLOURS, strict=False):
            lines = panel.plot(time, 100 * values[list(ring)].T, color=colour, linewidth=0.8)
            lines[0].set_label(name)
        panel.plot(time, 100 * values.mean(axis=0), color="black", linewidth=1.6, label="mean")
        panel.axhline(0, color=GREY, linewidth=0.5, zorder=1)
        panel.set(xlabel=recording.label("$t$", "time"), title=kind)
        panel.margins(x=0)
    panels[0].set(ylabel="strain since the first row (%)")
    panels[-1].legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return save(figure, folder / "strains.png")


def _bulls_eyes(
    recording: Recording, strains: Mapping[str, Array], table: Mapping[str, Array], folder: Path
) -> Path:
    """A panel each of the strains of largest magnitude, and of the greatest stress."""
    peaks = {f"{kind} strain (%)": 100 * _largest(values) for kind, values in strains.items()}
    stress = np.array([table[f"fibre_stress_{n}"] for n in range(1, COUNT + 1)])
    peaks[recording.label("stress along the fibre\n", "stress")] = _largest(stress)
    figure = new_figure(8.4, 2.9, recording.heading)
    for number, (title, values) in enumerate(peaks.items(), start=1):
        panel = figure.add_subplot(1, len(peaks), number, projection="polar")
        low, high = symmetric_range(values)
        colours = colormaps["RdBu_r"](np.clip((values - low) / (high - low), 0, 1))
        for n in range(COUNT):
            begin, width, inner = _place(n)
            edge = "white" if n < COUNT - 1 else "none"
            panel.bar(begin, 1.0, width, inner, align="edge", color=colours[n], edgecolor=edge)
            middle = (begin + width / 2, inner + 0.5) if n < COUNT - 1 else (0.0, 0.0)
            shade = "white" if abs(values[n]) > 0.6 * high else "black"
            panel.annotate(f"{values[n]:.3g}", middle, ha="center", va="center", fontsize=6, color=shade)
        panel.set_axis_off()
        panel.set_title(title, fontsize=8)
    return save(figure, folder / "bullseye.png")


def _largest(values: Array) -> Array:
    """Of each row (17, rows) the value of largest magnitude."""
    return np.asarray(np.take_along_axis(values, np.abs(values).argmax(axis=1)[:, None], axis=1)[:, 0])


def _place(n: int) -> tuple[float, float, float]:
    """Where segment n + 1 begins, how wide it is, and its inner radius: anterior above, septum left."""
    if NAMES[n] == "apex":
        return 0.0, 2 * np.pi, 0.0
    if n >= 12:
        return np.radians(45 + 90 * (n - 12)), np.pi / 2, 1.0
    return np.radians(60 + 60 * (n % 6)), np.pi / 3, 3.0 - n // 6
