"""The start-up chapter's tables and pictures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.output.figures.style import BLUE, GREEN, GREY, VERMILION, new_figure
from myostrain.reproduce.chapters.startup_jobs import (
    DENSE,
    DRIVEN,
    FAMILIES,
    MODES,
    SCHEMES,
    SPACINGS,
    TOLERANCES,
)
from myostrain.reproduce.content import Picture, Table
from myostrain.reproduce.jobs import Found

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

#: Colour and marker of a line.
LOOKS = {"coupled": (BLUE, "o"), "held": (VERMILION, "s"), "rigid": (GREEN, "^")}


def tables(found: Mapping[str, Found], n: Mapping[str, Any], quick: bool) -> list[Table]:
    """The tables."""
    rows: list[list[Any]] = []
    for family in FAMILIES:
        for width in sorted({row["half_width"] for row in n["map"] if row["family"] == family}):
            points = {r["mode"]: r for r in n["map"] if (r["family"], r["half_width"]) == (family, width)}
            conditions = []
            for name in ("held", "coupled"):
                known = sorted({r["half_width"] for r in n["map"] if r["family"] == family})
                conditions.append(found[f"(5.2) {family} {name}"].numbers["from"][known.index(width)])
            thresholds = [points[mode]["threshold"] if mode in points else None for mode in MODES]
            rows.append([_settings(family), f"{width:g}", *thresholds, *conditions])
    tolerance, closer = TOLERANCES[quick]
    made = [
        Table(
            f"Least height that fires, by bisection to {tolerance:g} (without recovery: {closer:g}), and least height "
            "that satisfies (5.2) for $F = 1$ and for the coupled line, $F = 1 - \\beta v$. Steps of 1e-3, "
            "scheme of second order, end at t = 0.3 (without recovery at 1). A dash: none up to a height of "
            "one, or not computed" + (" at the quick settings." if quick else "."),
            ["bump", "$R$", *MODES, "(5.2), $F = 1$", "(5.2), coupled"],
            rows,
        )
    ]
    steps = "2e-4" if quick else "1e-4"
    names = {"sheet": "sheet, $J = 1$", "line": "line, $J = x'$"}
    forms = {"printed": "as printed", "weighted": "with $J$", "whole": "with $J$ and $J_t$"}
    defects = [
        [names[body], forms[form]]
        + [found[f"energy {body} {scheme}"].numbers[form][-1] for scheme in SCHEMES]
        + [n["energy"][body][form]["remainder"]]
        for body, form in (("sheet", "printed"), ("line", "printed"), ("line", "weighted"), ("line", "whole"))
    ]
    made.append(
        Table(
            f"What is missing in (5.1), integrated over time, relative to the sum of the terms; steps of {steps}, "
            f"to t = {0.01 if quick else 0.02}, and extrapolated to a step of zero (the worst scheme). "
            "Reaction and recovery are summed at the nodes, as the scheme does it.",
            ["body", "form", *SCHEMES, "step of zero"],
            defects,
        )
    )
    made.append(
        Table(
            "A homogeneous potential on a small body that contracts by an active strain of −0.3 within 0.01, "
            "or is held until 0.01 and let go (line at $x'$ = 1.3 where v = 0, else at 1; sheet at stretches 1.2 and 0.9). "
            "Scheme of second order, steps of 1e-3, end at t = 0.2 (without recovery at 1).",
            ["experiment", "v at first", "v at t = 0.01", "largest", "v at the end", "fibre's stretch"],
            [
                [name.split(",")[0] + (", w = 0" if name.endswith("w = 0") else ""), DRIVEN[name][1]]
                + [run[key] for key in ("after", "largest", "last", "stretch")]
                for name, run in n["driven"].items()
            ],
        )
    )
    if not quick:
        made.append(
            Table(
                "Least height of a step of $R$ = 2 that fires, by bisection to 5e-4, with steps of 1e-3: the bump "
                "sampled at the nodes (so that it covers half a cell more than $R$), and by means.",
                ["cells", "coupled, nodes", "held, nodes", "coupled, means", "held, means"],
                [
                    [f"{h:g}"]
                    + [
                        n["closer"][f"window {s} {m} {h:g}"]
                        for s in ("nodal", "mean")
                        for m in ("coupled", "held")
                    ]
                    for h in SPACINGS
                ],
            )
        )
    return made


def _settings(family: str) -> str:
    shape, spacing, sampling, recovery = FAMILIES[family]
    mean = ", each node the mean around it" if sampling == "mean" else ""
    return f"{'step' if shape == 'step' else 'smooth'}{'' if recovery else ', w = 0'}, cells of {spacing:g}{mean}"


def pictures(found: Mapping[str, Found], n: Mapping[str, Any], quick: bool) -> list[Picture]:
    """The pictures."""

    def maps() -> Figure:
        figure = new_figure(6.4, 9.0)
        families = [family for family in FAMILIES if FAMILIES[family][3]]
        for axes, family in zip(figure.subplots(len(families), 1, sharex=True), families, strict=True):
            _draw_map(axes, found, n, family)
        axes.set_xlabel("half-width $R$")
        lines = [Line2D([], [], color=c, marker=m, label=mode) for mode, (c, m) in LOOKS.items()]
        figure.legend(handles=lines, loc="outside lower center", ncols=3)
        return figure

    def defects() -> Figure:
        return _draw_defects(found)

    made = [
        Picture(
            "startup-map",
            "Which bumps fire: those above the lines (bisection; scheme of second order, steps of 1e-3). Grey: the bumps "
            "that satisfy (5.2) for $F = 1$ on the same mesh. The cross is figure 2's bump.",
            "Three maps of height over half-width of a bump with firing thresholds of the coupled, held and rigid line "
            "and the region where condition (5.2) holds",
            maps,
        )
    ]
    made.append(
        Picture(
            "startup-energy",
            "What is missing in (5.1) over the time step; on the line as it is printed, and with $J$ and the "
            "term of $J_t$. Settings as in the table.",
            "Defect of the energy identity over the time step, falling at orders one and two, but constant for the line as "
            "printed",
            defects,
        )
    )
    return made


def _draw_map(axes: Any, found: Mapping[str, Found], n: Mapping[str, Any], family: str) -> None:
    dense = found[f"(5.2) {family} dense"].numbers
    low, high = (np.array(dense[name], dtype=float) for name in ("from", "to"))
    axes.fill_between(DENSE, low, high, color=GREY, alpha=0.3, linewidth=0)
    if np.isfinite(low).any():
        axes.text(26, 0.62, "(5.2) holds", color="#444444", ha="center")
    for mode, (colour, marker) in LOOKS.items():
        rows = [r for r in n["map"] if (r["family"], r["mode"]) == (family, mode)]
        x = [r["half_width"] for r in rows]
        y = np.array([r["threshold"] for r in rows], dtype=float)
        axes.plot(x, y, color=colour, marker=marker, markersize=5, linewidth=1.4, label=mode)
    if FAMILIES[family][0] == "step":
        axes.plot(1, 0.6, "x", color="black", markersize=8, markeredgewidth=2)
    axes.set(xscale="log", ylim=(0, 1.02), ylabel="height of the bump", title=_settings(family))
    axes.set_xticks([1, 2, 3, 5, 10, 20, 40], ["1", "2", "3", "5", "10", "20", "40"], minor=False)
    axes.minorticks_off()
    axes.set_xlim(0.9, 44)


def _draw_defects(found: Mapping[str, Found]) -> Figure:
    figure = new_figure(6.4, 4.4)
    axes = figure.subplots()
    markers = {"second-order": "o", "implicit": "s", "staggered": "^"}
    for body, form, colour, line in (
        ("line", "printed", VERMILION, "-"),
        ("line", "whole", BLUE, "-"),
        ("sheet", "printed", GREEN, "-"),
    ):
        for scheme, marker in markers.items():
            values = np.abs(found[f"energy {body} {scheme}"].numbers[form])
            steps = 4e-4 / 2.0 ** np.arange(len(values))
            axes.loglog(steps, values, color=colour, marker=marker, linestyle=line, markersize=5)
    names = {VERMILION: "line, as printed", BLUE: "line, with $J$ and $J_t$", GREEN: "sheet, as printed"}
    handles = [Line2D([], [], color=colour, label=name) for colour, name in names.items()]
    handles += [
        Line2D([], [], color="#444444", marker=marker, linestyle="none", label=name)
        for name, marker in markers.items()
    ]
    figure.legend(handles=handles, ncols=2, loc="outside lower center")
    axes.set_xticks(steps, [f"{step:g}" for step in steps])
    axes.minorticks_off()
    axes.set(xlabel="time step", ylabel="relative defect of (5.1)")
    return figure
