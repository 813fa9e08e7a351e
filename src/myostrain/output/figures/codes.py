"""The picture of activation times beside those of published codes, from the result folder alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from myostrain.output.figures.style import COLOURS, GREY, new_figure, save, style
from myostrain.output.folder import writing
from myostrain.output.manifest import make_folder

import numpy as np


def draw_codes(folder: Path, results: dict[str, Any]) -> list[Path]:
    """Draw ``figures/published.png``: times at the points, and those of each code on each of its meshes.

    Args:
        folder: The result folder.
        results: Its ``results.json``.

    Returns:
        The file written; none where nothing is published.

    Raises:
        InputError: It cannot be written.
    """
    found = results.get("published")
    if not found or not found["times"]:
        return []
    points = list(found["times"])
    names = list(dict.fromkeys(code["code"] for code in found["codes"]))
    marks = dict(zip((0.1, 0.2, 0.5), "ov^", strict=True))
    units = results.get("units", {})
    length, time = units.get("length", ""), f" ({units['time']})" if "time" in units else ""
    with writing(folder / "figures"):
        make_folder(folder / "figures")
    with style():
        figure = new_figure(7.2, 4.2, results["parameters"].get("title", ""))
        panel = figure.add_subplot()
        for number, name in enumerate(names):
            colour, away = COLOURS[(number + 1) % len(COLOURS)], 0.15 * (number + 1)
            finest: dict[float, dict[str, Any]] = {}
            for code in found["codes"]:
                if code["code"] == name and code["step"] <= finest.get(code["spacing"], code)["step"]:
                    finest[code["spacing"]] = code
            for spacing, code in finest.items():
                panel.plot(
                    [i + away for i in range(len(points))],
                    [code[point] for point in points],
                    marks.get(spacing, "s"),
                    color=colour,
                    markersize=4,
                    label=f"{name}, {code['method']}, {spacing:g} {length}".rstrip(),
                )
        panel.plot(range(len(points)), list(found["times"].values()), "D", color=COLOURS[0], label="this run")
        known = [(points.index(point), time) for point, time in found["converged"].items() if point in points]
        if known:
            at, limits = np.array(known).T
            panel.hlines(limits, at - 0.3, at + 0.6, color=GREY, label="converged")
        panel.set_xticks(range(len(points)), points)
        panel.set(ylabel=f"activation time{time}", yscale="log")
        panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=8)
        return [save(figure, folder / "figures" / "published.png")]
