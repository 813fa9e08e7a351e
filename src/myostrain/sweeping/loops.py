"""The pressure–volume loops of a sweep over each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from myostrain.output.figures.loops_beside import draw_loops_beside
from myostrain.output.reader import Reader
from myostrain.sweeping.members import Member


def draw_loops(folder: Path, members: Sequence[Member]) -> list[Path]:
    """Draw ``figures/loops.png``: the last beat of each run, labelled by the swept values.

    Args:
        folder: The sweep's.
        members: The runs that are done.

    Returns:
        The file; none where no run has cavities.
    """
    runs = [(member.said, Reader(folder / member.name)) for member in members]
    title = members[0].case.title if members else ""
    return draw_loops_beside(runs, folder / "figures" / "loops.png", title)
