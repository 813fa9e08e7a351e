"""The tables of figure 1."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.reproduce.chapters.figure_1.jobs import QUICK_STEP, READINGS, STEP
from myostrain.reproduce.chapters.figure_1.numbers import NAMES, judged
from myostrain.reproduce.content import Measured, Rows
from myostrain.reproduce.words import more, number

TITLES = {
    "rigid": "rigid",
    "conservative": "conservative, as printed",
    "advective": "advective",
    "viscous": "viscoelastic, $\\lambda = 0.4\\,\\tau$",
    "beta_02": "conservative, $\\beta = 0.2$",
    "beta_01": "conservative, $\\beta = 0.1$",
}
IMPLICIT = {"rigid": "rigid, first-order implicit", "conservative": "conservative, first-order implicit"}
STRIPS = {
    "plane_strain": "incompressible strip, plane strain",
    "plane_stress": "incompressible strip, plane stress",
}


def words(measured: Measured) -> dict[str, Any]:
    """What the words name beside the numbers."""
    ratios = judged(measured.numbers)

    def each(key: str, larger: str, smaller: str) -> str:
        return "; ".join(
            f"{text}: {more(ratios[row][key], larger, smaller)}" for row, (text, _) in READINGS.items()
        )

    grid = f"extrapolated from Δx = 1/2 and 1/4 at Δt = {number(STEP)}"
    if measured.quick:
        grid = f"at Δx = 1, Δt = {number(QUICK_STEP)} (quick settings, good to 1 %)"
    return {
        "grid": grid,
        "judged": ratios,
        "faster": each("celerity_ratio", "faster", "slower"),
        "wider": each("width_ratio", "wider", "shorter"),
        "picture_grid": f"Δx = 1, Δt = {number(measured.numbers['step'])}, t = 5",
    }


def tables(measured: Measured) -> dict[str, Rows]:
    """The rows of the tables."""
    n = measured.numbers

    def rows(of: str, ratios: str, titles: Mapping[str, str]) -> list[list[str | None]]:
        return [_cells(titles[row], values, n[ratios][row]) for row, values in n[of].items()]

    paper = rows("rows", "ratios", TITLES)
    if measured.quick:
        return {"paper": paper}
    strips = [[*cells[:4], None, *cells[5:]] for cells in rows("strips", "strip_ratios", STRIPS)]
    return {
        "paper": [*paper, *rows("implicit", "implicit_ratios", IMPLICIT), *strips],
        "converged": rows("converged", "converged_ratios", TITLES),
    }


def _cells(title: str, row: Mapping[str, float], ratio: Mapping[str, float]) -> list[str | None]:
    """Values, and behind them their ratios to the rigid line."""
    keys = ("celerity_ratio", "width_material_ratio", "width_ratio", "position_ratio", "maximum_ratio",
            "minimum_ratio")  # fmt: skip
    cells = (
        f"{row[name]:.{digits}f} ({ratio[key]:.3f})".replace("-", "−")
        for name, key, digits in zip(NAMES, keys, (2, 2, 2, 1, 3, 3), strict=True)
    )
    return [title, *cells]
