"""The pressure–volume loops of several runs over each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from myostrain.output.figures.loops import cavities_in, last_beat, scales
from myostrain.output.figures.style import COLOURS, SEQUENTIAL, new_figure, plain, save, style
from myostrain.output.reader import Reader

import numpy as np
from matplotlib import colormaps

#: Lines that a legend lists; more share a colour scale without one.
LISTED = 12


def draw_loops_beside(
    runs: Sequence[tuple[str, Reader]], path: Path, title: str = "", least: int = 1
) -> list[Path]:
    """Draw the last beat of each run, one panel per cavity.

    Args:
        runs: What each is called, and the run; those without cavities are left out.
        path: Where to; its ending says the format.
        title: Title of the figure.
        least: How many runs with cavities there have to be.

    Returns:
        The file; none where too few runs have cavities.
    """
    found = []
    for said, recording in runs:
        table = recording.table("cavities.csv")
        if names := cavities_in(table):
            found.append((said, recording, table, names))
    if len(found) < least or not found:
        return []
    _, first, _, names = found[0]
    (volume, across), (pressure, up) = scales(first)
    many = len(found) > min(LISTED, len(COLOURS))
    colours = [colormaps[SEQUENTIAL](i / len(found)) for i in range(len(found))] if many else list(COLOURS)
    with style():
        figure = new_figure(4.4 * len(names) + 0.4, 4.2, title)
        panels = np.atleast_1d(figure.subplots(1, len(names), squeeze=False)).reshape(-1)
        for (said, recording, table, own), colour in zip(found, colours, strict=False):
            last = last_beat(recording, table["time"])
            for panel, name in zip(panels, names, strict=True):
                if name in own:
                    V, p = table[f"volume_{name}"][last], table[f"pressure_{name}"][last]
                    panel.plot(volume * V, pressure * p, color=colour, linewidth=1.6, label=plain(said))
        for panel, name in zip(panels, names, strict=True):
            panel.set(xlabel=across, ylabel=up, title=plain(name) if len(names) > 1 else "")
        if len(found) <= LISTED:
            panels[0].legend(fontsize="small")
        return [save(figure, path)]
