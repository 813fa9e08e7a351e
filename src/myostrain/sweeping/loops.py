"""The pressure–volume loops of a sweep over each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from myostrain.output.figures.loops import cavities_in, last_beat, scales
from myostrain.output.figures.style import COLOURS, SEQUENTIAL, new_figure, plain, save, style
from myostrain.output.reader import Reader
from myostrain.sweeping.members import Member

import numpy as np
from matplotlib import colormaps

#: Lines that a legend lists; more share a colour scale without one.
LISTED = 12


def draw_loops(folder: Path, members: Sequence[Member]) -> list[Path]:
    """Draw ``figures/loops.png``: the last beat of each run, a panel a cavity, labelled by the swept values.

    Args:
        folder: The sweep's.
        members: The runs that are done.

    Returns:
        The file; none where no run has cavities.
    """
    found = []
    for member in members:
        table = (recording := Reader(folder / member.name)).table("cavities.csv")
        if names := cavities_in(table):
            found.append((member, recording, table, names))
    if not found:
        return []
    _, first, _, names = found[0]
    (volume, across), (pressure, up) = scales(first)
    many = len(found) > min(LISTED, len(COLOURS))
    colours = [colormaps[SEQUENTIAL](i / len(found)) for i in range(len(found))] if many else list(COLOURS)
    with style():
        figure = new_figure(4.4 * len(names) + 0.4, 4.2, members[0].case.title)
        panels = np.atleast_1d(figure.subplots(1, len(names), squeeze=False)).reshape(-1)
        for (member, recording, table, own), colour in zip(found, colours, strict=False):
            last = last_beat(recording, table["time"])
            for panel, name in zip(panels, names, strict=True):
                if name in own:
                    V, p = table[f"volume_{name}"][last], table[f"pressure_{name}"][last]
                    panel.plot(
                        volume * V, pressure * p, color=colour, linewidth=1.6, label=plain(member.said)
                    )
        for panel, name in zip(panels, names, strict=True):
            panel.set(xlabel=across, ylabel=up, title=plain(name) if len(names) > 1 else "")
        if len(found) <= LISTED:
            panels[0].legend(fontsize="small")
        return [save(figure, folder / "figures" / "loops.png")]
