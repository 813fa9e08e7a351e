"""Potential and shortening over time at the sheet's centre."""

from __future__ import annotations

from myostrain.output.figures.style import COLOURS, GREY, new_figure
from myostrain.reproduce.content import Measured

from matplotlib.figure import Figure

#: λ/τ that are shown.
SHOWN = (0.0, 1.0, 5.0)


def _waves(measured: Measured) -> Figure:
    figure = new_figure(6.4, 5.2)
    top, bottom = figure.subplots(2, 1, sharex=True)
    elastic = measured.numbers["sheets"]["0.0"]["shortening_peak"]
    for share, colour in zip(SHOWN, COLOURS, strict=False):
        arrays = measured.found[f"sheet {share}"].arrays
        label = "elastic" if share == 0 else f"$\\lambda$ = {share:g} $\\tau$"
        top.plot(arrays["times"], arrays["potential"], color=colour, label=label)
        bottom.plot(arrays["times"], arrays["shortening"] / elastic, color=colour)
    top.set(ylabel="potential $v$")
    bottom.set(xlabel="$t$", ylabel="shortening\n(elastic peak = 1)", xlim=(1.0, 3.0))
    for panel in (top, bottom):
        panel.axhline(0, color=GREY, linewidth=0.5, zorder=1)
    top.legend(loc="upper right")
    return figure


PICTURES = {"viscous-sheet-waves": _waves}
