"""The tables of equilibria, of fronts over α and β, of ratios to the rigid line, and of orders."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.reproduce.chapters.fronts.jobs import ALPHA, BETA, RATE, Settings, settings
from myostrain.reproduce.content import Measured, Rows
from myostrain.reproduce.words import number

#: The keys of a row of the tables of fronts.
SWEEP = ("c", "c_exact", "steepness", "steepness_exact", "potential_error")
RATIOS = ("speed_ratio", "steepness_ratio", "width_spatial_ratio", "slope_ratio", "width_material_ratio")


def words(measured: Measured) -> dict[str, Any]:
    """What the words name beside the numbers."""
    n, s = measured.numbers, settings(measured.quick)
    grid = f"h = {s.spacing:g}, Δt = {s.step:g}"
    rows = [*n["fronts"], *n["advective"]]
    alphas = [row["alpha"] for row in rows]
    beta, beta_advective = (max(row["beta"] for row in n[of]) for of in ("fronts", "advective"))
    return {
        "settings": s,
        "grid": grid,
        "sweep": f"Over {len(rows)} fronts, α from {min(alphas)} to {max(alphas)} and β from 0 to {beta} "
        f"(advective: to {beta_advective}), A = D = {RATE:g}, {grid}",
        "paper": next(row for row in rows if (row["alpha"], row["beta"]) == (ALPHA, BETA)),
        "retreating": [
            row for row in n["fronts"] if row["alpha"] > 0.5 and row["beta"] > 0 and "speed_ratio" in row
        ],
        "growth": {
            f"{row['model']} {row['potential']}": row["growth"]
            for row in n["equilibria"]["rows"]
            if row["recovery"] == "with_recovery"
        },
    }


def tables(measured: Measured) -> dict[str, Rows]:
    """The rows of the tables."""
    n = measured.numbers
    fronts = [
        (balance, row)
        for balance, of in (("conservative", "fronts"), ("advective", "advective"))
        for row in n[of]
    ]
    return {
        "equilibria": [_equilibrium(row) for row in n["equilibria"]["rows"] if row["model"] != "advective"],
        "sweep": [
            [
                "rigid" if row["beta"] == 0 else balance,
                f"{row['alpha']:g}",
                f"{row['beta']:g}",
                f"{row['alpha'] * row['beta']:.3g}",
                *(row[key] for key in SWEEP),
            ]
            for balance, row in fronts
        ],
        "ratios": [
            [balance, f"{row['alpha']:g}", f"{row['beta']:g}", *(row[key] for key in RATIOS)]
            for balance, row in fronts
            if row["beta"] > 0 and "speed_ratio" in row
        ],
        "orders": _orders(n["orders"], settings(measured.quick)),
    }


def _equilibrium(row: Mapping[str, Any]) -> list[str]:
    kind = "with recovery" if row["recovery"] == "with_recovery" else "without"
    rates = [_rates(row[key]) for key in ("rates", "predicted")]
    return [
        kind,
        f"{row['potential']:g}",
        row["model"],
        *rates,
        "stable" if row["growth"] < 0 else "unstable",
    ]


def _rates(values: list[list[float]]) -> str:
    if len(values) == 2 and values[0][1] != 0:
        return f"{number(values[0][0], 4)} ± {number(abs(values[0][1]), 4)} i"
    return ", ".join(number(re, 4) for re, _ in values)


def _orders(orders: Mapping[str, Any], s: Settings) -> Rows:
    def row(what: str, sizes: list[float], values: list[float], order: float, declared: str) -> list[str]:
        halved = ", ".join(f"{x:g}" for x in sizes)
        return [what, halved, ", ".join(f"{v:.5f}" for v in values), f"{order:.2f}", declared]

    space = (orders["spacings"], orders["speed_by_spacing"], orders["order_in_h"])
    return [row(f"h, at Δt = {s.step:g}", *space, "2")] + [
        row(f"Δt, {scheme}", steps, orders["speed_by_step"][scheme], orders["order_in_step"][scheme],
            "2" if scheme == "second-order" else "1")
        for scheme, steps in orders["steps"].items()
    ]  # fmt: skip
