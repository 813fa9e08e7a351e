"""A picture of runs over each other: probes and measures over time, a panel each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from myostrain.output.figures.style import COLOURS, SEQUENTIAL, new_figure, plain, save, style
from myostrain.output.opening import Results

import numpy as np
import numpy.typing as npt
from matplotlib import colormaps

#: Panels of probes, and of measures, at most.
PROBES, MEASURES = 6, 12

#: A curve by run: times, values and what xarray says of them.
Curves = Mapping[int, tuple[Any, Any, Mapping[str, str]]]


def draw_comparison(runs: Sequence[Results], names: Sequence[str], path: Path) -> Path | None:
    """Draw what at least two runs have: the potential at each probe, and each measure that changes.

    Args:
        runs: The runs.
        names: What they are called.
        path: Where to; its ending says the format.

    Returns:
        The path; None if there is nothing to draw.
    """
    panels = {**_probes(runs), **_measures(runs)}
    if not panels:
        return None
    count = len(runs)
    colours = (
        list(COLOURS) if count <= len(COLOURS) else [colormaps[SEQUENTIAL](i / count) for i in range(count)]
    )
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    with style():
        figure = new_figure(3.7 * columns, 2.4 * rows + 0.3 + 0.2 * count)
        axes = np.atleast_1d(figure.subplots(rows, columns, squeeze=False)).reshape(-1)
        handles: dict[int, Any] = {}
        for panel, (title, curves) in zip(axes, panels.items(), strict=False):
            for number, (times, values, _) in curves.items():
                # Later runs are dashed, so that an equal one below shows.
                dashes = (None, None) if number == 0 else (5, 1 + number)
                (line,) = panel.plot(times, values, color=colours[number], dashes=dashes, linewidth=1.5)
                handles.setdefault(number, line)
            panel.set_title(plain(title), fontsize=9)
            panel.margins(x=0)
            _label(panel, next(iter(curves.values())))
        for panel in axes[len(panels) :]:
            panel.axis("off")
        told = sorted(handles)
        figure.legend([handles[n] for n in told], [plain(names[n]) for n in told], loc="outside lower left")
        return save(figure, path)


def _label(panel: Any, curve: tuple[Any, Any, Mapping[str, str]]) -> None:
    times, _, about = curve
    unit, time = about.get("units", "1"), times.attrs.get("units", "1")
    panel.set_xlabel("$t$" if time == "1" else f"$t$ ({plain(time)})")
    if unit != "1":
        panel.set_ylabel(plain(unit))


def _probes(runs: Sequence[Results]) -> dict[str, Curves]:
    """The potential at probes that two runs have."""
    found: dict[str, dict[int, tuple[Any, Any, Mapping[str, str]]]] = {}
    for number, run in enumerate(runs):
        if "potential" not in run.probes:
            continue
        for name in run.probes["probe"].values.tolist():
            v = run.probes["potential"].sel(probe=name)
            found.setdefault(f"potential at {name}", {})[number] = (v["time"], v, v.attrs)
    return _shared(found, PROBES)


def _measures(runs: Sequence[Results]) -> dict[str, Curves]:
    """Measures that two runs have and that change in one of them."""
    found: dict[str, dict[int, tuple[Any, Any, Mapping[str, str]]]] = {}
    for number, run in enumerate(runs):
        for name, values in run.measures.items():
            if not str(name).startswith("reaction_") or abs(values).max() > run.least_force:
                found.setdefault(str(name), {})[number] = (values["time"], values, values.attrs)
    changing = {
        name: curves
        for name, curves in found.items()
        if any(_changes(values.to_numpy()) for _, values, _ in curves.values())
    }
    return _shared(changing, MEASURES)


def _changes(values: npt.NDArray[np.float64]) -> bool:
    return len(values) > 1 and bool(np.ptp(values) > 1e-9 * np.abs(values).max())


def _shared(found: Mapping[str, Curves], most: int) -> dict[str, Curves]:
    return dict([(name, curves) for name, curves in found.items() if len(curves) > 1][:most])
