"""Pictures of the sheet: what figure 3 shows, isochrones, displacement and strain, pulses over time."""

from __future__ import annotations

from functools import partial
from typing import Any

from myostrain.output.figures.maps import band_levels
from myostrain.output.figures.sheet import boundary_edges
from myostrain.output.figures.style import (
    BLUE,
    DIVERGING,
    GREEN,
    GREY,
    POTENTIAL,
    SEQUENTIAL,
    VERMILION,
    extend,
    new_figure,
)
from myostrain.reproduce.content import Measured
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements.triangles import gradients, strains

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

#: Ends of the axes: the body's rectangle and a little more.
FRAME = {"xlim": (-6.0, 136.0), "ylim": (-6.0, 186.0), "aspect": "equal"}


def _body(
    panel: Any, run: Found, values: Any, norm: Normalize, colours: str, *, deformed: bool = True
) -> Any:
    """Nodal values (n,) on the body, with the outlines of both states."""
    X, cells = run.arrays["X"], run.arrays["cells"].astype(int)
    x = X + run.arrays["u"]
    image = panel.tripcolor(
        Triangulation(*x.T, cells), values, norm=norm, cmap=colours, zorder=2, shading="gouraud"
    )
    edges = boundary_edges(cells)
    panel.add_collection(LineCollection(list(X[edges]), colors=GREY, linewidths=0.8, zorder=1))
    panel.add_collection(LineCollection(list(x[edges]), colors="black", linewidths=0.8, zorder=3))
    panel.set(**FRAME)
    return image


def _bar(figure: Figure, image: Any, panels: Any, label: str, **given: Any) -> None:
    bar = figure.colorbar(image, ax=panels, shrink=0.8, pad=0.02, **given)
    bar.set_label(label)
    bar.outline.set_visible(False)


def _axes(panels: Any, x: str, y: str) -> None:
    """Labels on the outer axes alone."""
    for panel in panels[-1]:
        panel.set_xlabel(x)
    for panel in panels[:, 0]:
        panel.set_ylabel(y)


def _fibres(panel: Any) -> None:
    """A double arrow that shows the fibres' direction."""
    panel.annotate("", (30, 12), (8, 34), arrowprops={"arrowstyle": "<->", "color": "#444444"}, zorder=4)
    panel.text(3, 3, "fibres", fontsize=9, color="#444444")


def _pair(what: str, measured: Measured) -> Figure:
    """Potential above, trace of the stress below, one column per run, one scale per row."""
    runs = [measured.found[f"{kind}{what}"] for kind in ("stress", "strain")]
    names = ("plane stress", "plane strain")
    figure = new_figure(7.2, 8.5, compress=True)
    panels = figure.subplots(2, len(runs), sharex=True, sharey=True, squeeze=False)
    traces = [run.arrays["stress_trace"] for run in runs]
    size = max(float(np.quantile(np.abs(trace), 0.99)) for trace in traces)
    scales = Normalize(*POTENTIAL), Normalize(-size, size)
    for column, run, name in zip(panels.T, runs, names, strict=True):
        v = _body(column[0], run, run.arrays["potential"], scales[0], SEQUENTIAL)
        stress = _body(column[1], run, run.arrays["stress_trace"], scales[1], DIVERGING)
        column[0].set_title(name)
    _fibres(panels[0, 0])
    _axes(panels, "$x$", "$y$")
    _bar(figure, v, panels[0], "potential $v$")
    _bar(
        figure,
        stress,
        panels[1],
        "trace of the Cauchy stress",
        extend=extend(scales[1], np.concatenate(traces)),
    )
    return figure


def _isochrones(measured: Measured) -> Figure:
    runs = [measured.found[name] for name in ("rigid", "stress", "rigid ratio 4", "stress ratio 4")]
    names = ("rigid, isotropic", "coupled, isotropic", "rigid, ratio 4", "coupled, ratio 4")
    figure = new_figure(7.2, 8.5, compress=True)
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    levels = band_levels(np.array([0.0, 3.0]))
    for panel, run, name in zip(panels.flat, runs, names, strict=True):
        X, T = run.arrays["X"], run.arrays["activation"]
        cells = run.arrays["cells"].astype(int)
        bump = np.isnan(T) & (np.linalg.norm(X - [95.0, 25.0], axis=1) < 12)
        never = np.isnan(T) & ~bump
        body = Triangulation(*X.T, cells, mask=never[cells].any(axis=1))
        known = np.where(np.isnan(T), 0.0, T)
        image = panel.tricontourf(body, known, levels=levels, cmap=SEQUENTIAL)
        panel.tricontour(body, known, levels=levels, colors="white", linewidths=0.6)
        edges = boundary_edges(cells)
        panel.add_collection(LineCollection(list(X[edges]), colors="black", linewidths=0.8, zorder=3))
        panel.set(title=name, **FRAME)
    _fibres(panels[0, 0])
    _axes(panels, "$X$", "$Y$")
    _bar(figure, image, panels, "activation time")
    return figure


def _relevance(measured: Measured) -> Figure:
    run = measured.found["stress"]
    figure = new_figure(7.2, 5.0, compress=True)
    panels = figure.subplots(1, 2, sharex=True, sharey=True, squeeze=False)
    X, cells, u = run.arrays["X"], run.arrays["cells"].astype(int), run.arrays["u"]
    strain = np.linalg.norm(strains(np.eye(2) + gradients(X, cells, u)), axis=(1, 2))
    share, sums = np.zeros(len(X)), np.zeros(len(X))  # of the triangles around each node, their mean
    np.add.at(share, cells, 1.0)
    np.add.at(sums, cells, strain[:, None])
    sizes = {"displacement $|u|$": np.linalg.norm(u, axis=1), "strain $|E|$": sums / share}
    for panel, (label, size) in zip(panels[0], sizes.items(), strict=True):
        norm = Normalize(0.0, float(np.quantile(size, 0.998)))
        image = _body(panel, run, size, norm, "magma_r")
        x = X + u
        panel.tricontour(
            Triangulation(*x.T, cells),
            run.arrays["potential"],
            levels=[-0.1, 0.1],
            colors=BLUE,
            linestyles="solid",
            linewidths=1.2,
            zorder=4,
        )
        _bar(figure, image, panel, label, location="bottom", extend="max")
    _axes(panels, "$x$", "$y$")
    return figure


def _pulses(measured: Measured) -> Figure:
    figure = new_figure(7.2, 3.8)
    panel = figure.add_subplot()
    found = measured.found
    shown = (
        ("stress", 3, "sheet, plane stress", BLUE, "-"),
        ("strain", 3, "sheet, plane strain", GREEN, "-"),
        ("rigid", 3, "sheet, rigid", GREY, "-"),
        ("line", 0, "line (4.6)", VERMILION, "--"),
        ("line rigid", 0, "line, rigid", "#333333", "--"),
    )
    for name, probe, label, colour, style in shown:
        pulse = found[name].numbers["pulses"][("a" if probe == 0 else "centre")]
        times = found[name].arrays["times"] - pulse["activation"]
        part = (times > -0.2) & (times < 1.0)
        panel.plot(times[part], found[name].arrays["probes"][part, probe], style, color=colour, label=label)
    panel.axhline(0, color=GREY, linewidth=0.5, zorder=1)
    panel.set(xlabel="time after activation", ylabel="potential $v$", xlim=(-0.2, 1.0))
    panel.legend(loc="upper right")
    return figure


PICTURES = {
    "figure-3": partial(_pair, ""),
    "figure-3-ratio-4": partial(_pair, " ratio 4"),
    "figure-3-elastic": partial(_pair, " elastic"),
    "figure-3-isochrones": _isochrones,
    "figure-3-relevance": _relevance,
    "figure-3-pulses": _pulses,
}
