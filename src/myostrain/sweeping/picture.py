"""A picture of a sweep: metrics over the swept keys."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from myostrain.errors import InputError, nearest
from myostrain.output.figures.style import COLOURS, SEQUENTIAL, new_figure, plain, save, style
from myostrain.sweeping.members import Member, as_text
from myostrain.sweeping.table import Rows

import numpy as np
from matplotlib import colormaps

#: Panels where nothing is chosen, and which metrics come first then.
PANELS = 6
FIRST = (
    *("celerity", "conduction_velocity_median", "width_material", "width_spatial", "apd90_median"),
    *("displacement_max", "ejection_fraction", "stroke_volume", "fibre_shortening", "twist", "tip_period"),
)

#: Lines that a legend lists; more share a colour scale.
LISTED = 12


def choose(rows: Rows, asked: Sequence[str] = ()) -> list[str]:
    """Which metrics to draw: those asked for, or some that differ between the runs.

    Raises:
        InputError: One does not exist.
    """
    for name in asked:
        if rows.metrics and name not in rows.names:
            raise InputError(f"no metric is called '{name}'; {nearest(name, rows.names)}", "--plot")
    if asked:
        return list(asked)
    differing = [name for name in rows.names if _differs(rows.values(name)) and not rows.vanishes(name)]
    ordered = [name for name in FIRST if name in differing]
    return [*ordered, *(name for name in differing if name not in ordered)][:PANELS]


def _differs(values: Sequence[float]) -> bool:
    """Whether values differ by more than a thousandth."""
    there = np.array(values)[np.isfinite(values)]
    return len(there) > 1 and bool(np.ptp(there) > 1e-3 * np.abs(there).max())


def draw(
    rows: Rows, metrics: Sequence[str], about: Mapping[str, Mapping[str, str]], path: Path
) -> list[Path]:
    """Draw metrics, a panel each, over the key with most values; a line for each value of the others.

    Args:
        rows: The table.
        metrics: Names.
        about: Long names and units by name.
        path: Where to.

    Returns:
        The file written; none if there is nothing to draw.
    """
    plan = rows.plan
    if not metrics or not rows.metrics:
        return []
    numeric = {key: _numeric(values) for key, values in plan.axes.items()}
    across = max(plan.axes, key=lambda key: (numeric[key], len(plan.axes[key])))
    lines: dict[str, list[Member]] = {}
    for member in plan.members:
        others = {key: value for key, value in member.values.items() if key != across}
        label = ", ".join(f"{key} = {as_text(value)}" for key, value in others.items()) if plan.grid else ""
        lines.setdefault(label, []).append(member)
    many = len(lines) > min(LISTED, len(COLOURS))
    colours = [colormaps[SEQUENTIAL](i / len(lines)) for i in range(len(lines))] if many else list(COLOURS)
    columns = min(3, len(metrics))
    height = -(-len(metrics) // columns)
    legend = 0.22 * len(lines) if 1 < len(lines) <= LISTED else 0.0
    with style():
        figure = new_figure(3.4 * columns + 0.4, 2.7 * height + 0.5 + legend, plan.members[0].case.title)
        panels = np.atleast_1d(figure.subplots(height, columns, squeeze=False)).reshape(-1)
        ticks = [as_text(value) for value in plan.axes[across]]
        for panel, name in zip(panels, metrics, strict=False):
            for (label, members), colour in zip(lines.items(), colours, strict=False):
                _line(panel, rows, members, name, across, numeric[across], label=plain(label), color=colour)
            unit = about.get(name, {}).get("units", "1")
            panel.set(xlabel=plain(across), ylabel=plain(name if unit == "1" else f"{name} ({unit})"))
            if not numeric[across]:
                panel.set_xticks(range(len(ticks)), [plain(tick) for tick in ticks], rotation=20, ha="right")
        for panel in panels[len(metrics) :]:
            panel.axis("off")
        if legend:
            handles, labels = panels[0].get_legend_handles_labels()
            figure.legend(handles, labels, loc="outside lower left")
        return [save(figure, path)]


def _line(
    panel: Any, rows: Rows, members: Sequence[Member], metric: str, across: str, numeric: bool, **how: Any
) -> None:
    """One line of a panel; a gap where a run has no such number."""
    values = dict(zip((m.name for m in rows.plan.members), rows.values(metric), strict=True))
    order = list(rows.plan.axes[across])
    x = [member.values[across] if numeric else order.index(member.values[across]) for member in members]
    along = np.argsort(x)
    y = np.array([values[member.name] for member in members])
    panel.plot(np.array(x)[along], y[along], marker="o", markersize=4, linewidth=1.4 if numeric else 0, **how)


def _numeric(values: Sequence[Any]) -> bool:
    return all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
