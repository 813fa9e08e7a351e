"""The picture of a run beside published numbers, drawn from the result folder alone."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from myostrain.errors import InputError
from myostrain.output.figures.style import COLOURS, GREY, new_figure, save, style
from myostrain.output.folder import read_regular, writing
from myostrain.output.manifest import make_folder
from myostrain.output.published import STRAINS, Benchmark, find, wall_strains

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]


def draw_benchmark(folder: Path, results: dict[str, Any]) -> list[Path]:
    """Draw ``figures/land.png`` of a run with published numbers beside it: deformed lines and their strains.

    Args:
        folder: The result folder.
        results: Its ``results.json``.

    Returns:
        The file written; none where there is nothing to compare with.

    Raises:
        InputError: It cannot be written.
    """
    file = folder / "lines.csv"
    benchmark = find(results.get("case", ""))
    if benchmark is None or "benchmark" not in results or not file.exists():
        return []
    lines = _lines(file)
    figures = folder / "figures"
    with writing(figures):
        make_folder(figures)
    with style():
        figure = new_figure(7.2, 5.4 if benchmark.strains else 4.2, results["parameters"].get("title", ""))
        if benchmark.strains:
            grid = figure.add_gridspec(3, 2, width_ratios=[1.0, 1.3])
            _shape(figure.add_subplot(grid[:, 0]), benchmark, lines, results["benchmark"], across=True)
            _strains([figure.add_subplot(grid[i, 1]) for i in range(3)], benchmark, lines)
        else:
            _shape(figure.add_subplot(), benchmark, lines, results["benchmark"], across=False)
        figure.supxlabel(_said(benchmark, results["benchmark"]), fontsize=9, ha="left", x=0.02)
        return [save(figure, figures / "land.png")]


def _lines(file: Path) -> dict[str, tuple[Array, Array]]:
    """Positions (n, 3) by line, at rest and deformed."""
    rows: dict[str, list[list[float]]] = {}
    try:
        for name, *numbers in list(csv.reader(read_regular(file).decode().splitlines()))[1:]:
            rows.setdefault(name, []).append([float(number) for number in numbers])
        return {name: (np.array(table)[:, :3], np.array(table)[:, 3:6]) for name, table in rows.items()}
    except (OSError, ValueError, IndexError, csv.Error) as error:
        raise InputError(f"{file} cannot be read: {error}; repair it or remove it") from error


def _said(benchmark: Benchmark, found: dict[str, Any]) -> str:
    """The quantities in words, a line each."""
    texts = []
    for name, entry in found.items():
        low, high = entry["published"]
        texts.append(
            f"{benchmark.quantities[name].what}: {entry['value']:.3f}; published {low:g} to {high:g}, "
            f"converged {entry['converged']:g}"
        )
    return "\n".join(texts)


def _shape(panel: Axes, benchmark: Benchmark, lines: Any, found: dict[str, Any], *, across: bool) -> None:
    """The lines: at rest, deformed, deformed on a fine mesh; published values as bands."""

    def place(x: Array) -> tuple[Array, Array]:
        return (np.hypot(x[:, 0], x[:, 1]) if across else x[:, 0]), x[:, 2]

    for colour, (name, (rest, deformed)) in zip(COLOURS, lines.items(), strict=False):
        panel.plot(*place(rest), color=GREY, linewidth=0.8, label="at rest" if colour == COLOURS[0] else None)
        fine = benchmark.lines[name].converged
        panel.plot(*place(fine), color=colour, linewidth=1.0, label=name)
        panel.plot(*place(deformed), "o", color=colour, markersize=4)
    for entry in found.values():
        at, height = place(np.array([entry["position"]]))
        panel.plot(
            [at[0]] * 2, entry["published"], color="black", linewidth=6, alpha=0.3, solid_capstyle="butt"
        )
        panel.plot(at, height, "x", color="black", markersize=5)
    panel.plot([], [], "o", color=GREY, markersize=4, label="this run")
    panel.plot([], [], color="black", linewidth=6, alpha=0.3, label="published", solid_capstyle="butt")
    panel.plot([], [], "x", color="black", markersize=5, label="its point")
    panel.set(xlabel="distance from the axis" if across else "x", ylabel="z", aspect="equal")
    panel.legend(fontsize=7, loc="upper left", bbox_to_anchor=(0.0, 1.0))


def _strains(panels: list[Axes], benchmark: Benchmark, lines: Any) -> None:
    """Strains along the lines from apex to base, of this run and of the fine mesh."""
    rest = np.stack([line[0] for line in lines.values()])
    own = wall_strains(rest, np.stack([line[1] for line in lines.values()]))
    fine = wall_strains(rest, np.stack([benchmark.lines[name].converged for name in lines]))
    s = np.linspace(0.0, 1.0, rest.shape[1])
    for panel, name, mine, other in zip(panels, STRAINS, own, fine, strict=True):
        for colour, points, curve in zip(COLOURS, mine, other, strict=False):
            panel.plot(s, curve, color=colour, linewidth=1.0)
            panel.plot(s, points, "o", color=colour, markersize=3)
        panel.axhline(0.0, color=GREY, linewidth=0.5, zorder=1)
        panel.set(ylabel=f"{name}\nstrain")
    panels[-1].set(xlabel="from apex (0) to base (1)")
