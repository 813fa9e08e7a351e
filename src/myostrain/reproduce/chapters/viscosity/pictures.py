"""Celerity and widths over the relaxation time, and the contraction behind the potential."""

from __future__ import annotations

from myostrain.output.figures.style import BLUE, GREEN, GREY, VERMILION, new_figure
from myostrain.reproduce.content import Measured

import numpy as np
from matplotlib.figure import Figure

#: λ/τ whose contraction is drawn over time.
SHOWN = (0.1, 1.0, 3.0)


def _sweep(measured: Measured) -> Figure:
    figure = new_figure(6.0, 5.2)
    above, below = figure.subplots(2, 1, sharex=True)
    sweep, limits = measured.numbers["sweep"], measured.numbers["limits"]
    parts = [row["part"] for row in sweep]
    curves = ((above, "celerity", "celerity", BLUE), (below, "width_material", "width in $X$", GREEN),
              (below, "width_spatial", "width in $x$", VERMILION))  # fmt: skip
    for axes, name, text, colour in curves:
        axes.semilogx(parts, [row[name] for row in sweep], "o-", color=colour, markersize=4, label=text)
    for axes, names in ((above, ("celerity",)), (below, ("width_material", "width_spatial"))):
        axes.margins(y=0.12)
        ends = [("rigid", limits["rigid"][names[0]], 1.0, "right")]
        ends += [("elastic", limits["elastic"][name], 0.0, "left") for name in names]
        for text, value, where, side in ends:
            axes.axhline(value, color=GREY, linewidth=0.8, linestyle="--", zorder=0)
            offset = {"xytext": (6 if where == 0 else -6, 3), "textcoords": "offset points"}
            look = {"ha": side, "va": "bottom", "color": "#555555", "fontsize": 9}
            axes.annotate(text, (where, value), xycoords=("axes fraction", "data"), **offset, **look)
    above.set(ylabel="celerity")
    below.set(xlabel=r"$\lambda/\tau$", ylabel="width at $v$ = 1/2")
    below.legend(loc="upper right", bbox_to_anchor=(1.0, 0.95))
    return figure


def _delay(measured: Measured) -> Figure:
    figure = new_figure(6.0, 5.6)
    for axes, part in zip(figure.subplots(len(SHOWN), 1, sharex=True), SHOWN, strict=True):
        arrays = measured.found[f"{part:g}"].arrays
        times, v, shortening = (arrays[f"watch_{name}"] for name in ("times", "potential", "shortening"))
        begin = times[int(np.argmax(v > 0.5))]
        axes.plot(times - begin, v / v.max(), color=BLUE, label="potential")
        axes.plot(times - begin, shortening / shortening.max(), color=VERMILION, label="shortening")
        axes.set(ylim=(-0.25, 1.1), xlim=(-0.2, 1.2), title=rf"$\lambda$ = {part:g} $\tau$")
        axes.axhline(0, color=GREY, linewidth=0.6, zorder=0)
    figure.axes[0].legend(loc="upper right")
    figure.axes[-1].set_xlabel("time after the upstroke")
    figure.supylabel("over its maximum", fontsize=10)
    return figure


PICTURES = {"viscosity-sweep": _sweep, "viscosity-delay": _delay}
