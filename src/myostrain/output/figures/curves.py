"""The picture of displacements over time over those of published teams, from the result folder alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from myostrain.output.curves import AXES, displacements, published
from myostrain.output.figures.style import COLOURS, GREY, new_figure, save, style
from myostrain.output.folder import writing
from myostrain.output.manifest import make_folder

import numpy as np


def draw_curves(folder: Path, results: dict[str, Any]) -> list[Path]:
    """Draw ``figures/published.png``: each component at each point, of this run and of the teams.

    Args:
        folder: The result folder.
        results: Its ``results.json``.

    Returns:
        The file written; none where nothing is published.

    Raises:
        InputError: It cannot be written.
    """
    found = results.get("curves")
    if not found:
        return []
    curves, (times, own) = published(results["case"]), displacements(folder)
    points = [point for point in curves.points if f"{point}_x" in found]
    with writing(folder / "figures"):
        make_folder(folder / "figures")
    with style():
        figure = new_figure(7.2, 5.6, results["parameters"].get("title", ""))
        panels = figure.subplots(len(AXES), len(points), sharex=True, squeeze=False)
        for column, point in enumerate(points):
            for row, axis in enumerate(AXES):
                panel, entry = panels[row, column], found[f"{point}_{axis}"]
                teams = 1e3 * curves.points[point][:, :, row]
                low, high = teams.min(axis=0), teams.max(axis=0)
                panel.fill_between(curves.times, low, high, color=GREY, alpha=0.4, linewidth=0, label="teams")
                panel.plot(curves.times, teams.T, color=GREY, linewidth=0.5)
                panel.plot(
                    curves.times, np.median(teams, axis=0), color="black", linewidth=0.9, label="median"
                )
                panel.plot(times, 1e3 * own[point][:, row], color=COLOURS[0], linewidth=1.3, label="this run")
                panel.set_title(
                    f"rms to the median {1e3 * entry['rms']:.2g}, of teams up to "
                    f"{1e3 * entry['rms_of_teams'][1]:.2g} mm",
                    fontsize=8,
                )
                panel.set(ylabel=f"{point}: $u_{axis}$, mm")
                panel.margins(x=0)
            panels[-1, column].set(xlabel="$t$, s")
        panels[0, 0].legend(fontsize=7, loc="lower right")
        return [save(figure, folder / "figures" / "published.png")]
