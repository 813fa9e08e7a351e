"""Section 1.1: active stress and active strain, of springs and at small strain."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from myostrain.output.figures.style import BLUE, GREEN, GREY, VERMILION, new_figure
from myostrain.reproduce.content import Chapter, Picture, Statement, Table
from myostrain.reproduce.jobs import Found, Job
from myostrain.reproduce.page import number
from myostrain.reproduce.verdict import claims

import numpy as np
from matplotlib.figure import Figure

TITLE = "Active stress and active strain in zero dimensions (section 1.1)"

STIFFNESS, REST, ACTIVE = 1.3, 1.0, 0.7
SPREADS = (0.5, 0.1, 0.01)
SIZES = tuple(0.3 / 2**k for k in range(9))
MATERIALS: dict[str, dict[str, Any]] = {
    "neo-Hookean": {"model": "NeoHookean", "mu": 1.0},
    "Mooney–Rivlin": {"model": "MooneyRivlin", "mu": 1.0, "mu_2": 0.5},
    "linear spring": {"model": "Spring", "mu": 1.0},
}
RESIDUAL_FREE, PULLED_BACK, ENERGY_ALONE = "residual-free", "pulled back", "energy alone"


def jobs(quick: bool) -> dict[str, Job]:
    """Springs, and (1.12) for each material, form of the stress and kind of F."""
    shared: dict[str, Any] = {"stiffness": STIFFNESS, "rest": REST, "active_length": ACTIVE}
    shared |= {"spreads": list(SPREADS), "points": 1001}
    made = {name: Job("springs.spring", {"power": m, **shared}, 0.1) for name, m in POWERS.items()}
    for key, (material, form, isochoric) in ROWS.items():
        parameters = {
            "material": MATERIALS[material],
            "form": form,
            "isochoric": isochoric,
            "seed": 2011,
            "directions": 250 if quick else 2000,
            "sizes": list(SIZES),
        }
        made[key] = Job("springs.small_strains", parameters, 0.1 if quick else 0.5)
    return made


POWERS = {"linear": 1, "cubic": 3}

#: Rows of (1.12) by name: material, form of the stress, whether det F = 1. A spring has no pressure.
ROWS = {
    "neo_hookean": ("neo-Hookean", RESIDUAL_FREE, False),
    "neo_hookean_isochoric": ("neo-Hookean", RESIDUAL_FREE, True),
    "neo_hookean_pulled_back": ("neo-Hookean", PULLED_BACK, False),
    "neo_hookean_residual": ("neo-Hookean", ENERGY_ALONE, False),
    "mooney_rivlin": ("Mooney–Rivlin", RESIDUAL_FREE, False),
    "mooney_rivlin_isochoric": ("Mooney–Rivlin", RESIDUAL_FREE, True),
    "mooney_rivlin_pulled_back": ("Mooney–Rivlin", PULLED_BACK, False),
    "mooney_rivlin_residual": ("Mooney–Rivlin", ENERGY_ALONE, False),
    "spring": ("linear spring", RESIDUAL_FREE, False),
}

STRESSES = {
    RESIDUAL_FREE: "$\\partial W/\\partial F - J p_0 F^{-T}$",
    PULLED_BACK: "the same, and pulled back (1.6)",
    ENERGY_ALONE: "$\\partial W/\\partial F$ alone",
}


def chapter(found: Mapping[str, Found], quick: bool) -> Chapter:
    """The chapter."""
    said = claims("springs")
    linear, cubic = (found[name].numbers for name in POWERS)
    rows = {name: found[name].numbers for name in ROWS}
    printed = [name for name, (_, form, _) in ROWS.items() if form == RESIDUAL_FREE]
    pulled = [name for name, (_, form, _) in ROWS.items() if form == PULLED_BACK]
    orders = _orders(rows, printed)
    pulled_orders = _orders(rows, pulled)
    least = min(rows[name]["relative_smallest"] for name in (*printed, *pulled))
    directions = 250 if quick else 2000
    statements = [
        Statement(
            said["linear"],
            f"A spring with $k$ = {STIFFNESS}, $\\ell_o$ = {REST}, $\\ell_a$ = {ACTIVE}, at 1001 lengths within "
            f"{_percent(SPREADS[0], 0)} of $\\ell_o$: with $f_a$ = {number(linear['constant'])} the forces of (1.7) and (1.8) "
            f"differ by at most {number(linear['constant_difference'][0])} of the largest force.",
            {"as printed": {"difference": linear["constant_difference"][0]}},
        ),
        Statement(
            said["cubic"],
            "The $f_a$ with which (1.9) and (1.10) agree is $-k\\delta(3e^2 - 3e\\delta + \\delta^2)$, with "
            "$e = \\ell - \\ell_o$ and $\\delta = \\ell_a - \\ell_o$. For the same spring, now cubic, it goes from "
            f"{number(cubic['smallest'][0])} to {number(cubic['largest'][0])} over lengths within {_percent(SPREADS[0], 0)} "
            f"of $\\ell_o$. The best constant there, {number(cubic['best_constant'][0])}, is wrong by up to "
            f"{_percent(cubic['error'][0], 0)} of itself; over lengths within {_percent(SPREADS[-1], 0)} by {_percent(cubic['error'][-1], 1)}.",
            {"as printed": {"error": cubic["error"][0], "error_where_it_is_least": min(cubic["error"])}},
        ),
        Statement(
            said["explicit"],
            "With that $f_a(\\ell)$ in place of a constant the forces of the cubic spring differ by at most "
            f"{number(cubic['explicit_difference'][0])} of the largest force, at the same 1001 lengths.",
            {"as printed": {"difference": cubic["explicit_difference"][0]}},
        ),
        Statement(
            said["small-strains"],
            f"For each of {directions} random $A$, $n$ and $g$, $F = 1 + \\varepsilon A$ and "
            "$F_o = 1 + \\varepsilon g\\, n \\otimes n$. Without residual stress, $P(1) = 0$, the difference of both "
            f"sides falls with an observed order in $\\varepsilon$ between {orders['smallest_order']:.4f} and "
            f"{orders['largest_order']:.4f}, for the neo-Hookean and the Mooney–Rivlin material, $\\det F = 1$ or "
            "not, and the spring of the line. The stress pulled back as in (1.6) keeps the order: "
            f"{pulled_orders['smallest_order']:.4f} to {pulled_orders['largest_order']:.4f}.",
            {"as printed, without residual stress": orders},
        ),
        Statement(
            said["only-small"],
            f"At $\\varepsilon$ = {SIZES[0]} the sides differ by at least {_percent(least, 1)} of the norm of "
            "$P(F) - P(F_o)$ in every direction tried, with either form of the stress; the median for the neo-Hookean "
            f"material is {_percent(rows['neo_hookean']['relative_median'], 0)}.",
            {"as printed": {"least_relative_difference": least}},
        ),
    ]
    residual = rows["neo_hookean_residual"]
    return Chapter(
        introduction=_INTRODUCTION,
        statements=statements,
        tables=[_cubic_table(cubic), _order_table(rows, directions)],
        pictures=[
            Picture(
                "springs-forces",
                f"Springs with $k$ = {STIFFNESS}, rest length {REST}, active length {ACTIVE}. Above: the active force "
                "that makes active stress and active strain agree at a length. Below: forces of the cubic spring, "
                "active strain (1.10) and active stress (1.9) with the best constant.",
                "Two panels over the length of a spring: the active force needed, flat for the linear and a parabola "
                "for the cubic spring; and the forces of the cubic spring, which differ.",
                partial(_draw_springs, found["linear"], found["cubic"]),
            ),
            Picture(
                "springs-small-strains",
                f"The difference of both sides of (1.12) over the strain ε, neo-Hookean material, {directions} random "
                "directions: median (line) and all (band).",
                "Log-log plot: three of the differences fall with slope two, the one with a residual stress is flat.",
                partial(_draw_orders, found),
            ),
        ],
        remarks=_REMARKS.format(
            limit=number(residual["limit"]),
            size=number(SIZES[-1]),
            order=f"{abs(residual['smallest_order']):.0e}",
        ),
        numbers={
            "linear": linear,
            "cubic": cubic,
            "small_strains": rows,
            "orders": orders,
            "orders_pulled_back": pulled_orders,
            "least_relative_difference": least,
        },
    )


_INTRODUCTION = """\
A spring of stiffness $k$ and rest length $\\ell_o$ is activated. With *active stress* a force $f_a$ is added to the
spring's; with *active strain* the rest length becomes $\\ell_a$:

$$k(\\ell - \\ell_o)^m + f_a = f, \\qquad k(\\ell - \\ell_a)^m = f,$$

with $m = 1$ for the linear spring, (1.7) and (1.8), and $m = 3$ for the cubic one, (1.9) and (1.10). In three
dimensions the rest length becomes $F_o = 1 + \\gamma\\, n \\otimes n$, and the question is whether the stress
$P(F F_o^{-1})$ of the elastic part is the passive stress and something that knows of $F_o$ alone, (1.12). We put
the program's own materials into it: their energies, differentiated by UFL and evaluated by DOLFINx."""

_REMARKS = """\
**“In the absence of residual stress”** is essential to (1.12), as the paper says. The stress of the energy (3.1)
alone is not free of it: $\\partial W/\\partial F$ of the neo-Hookean material is $\\mu F$, which at $F = 1$ is
$\\mu 1$. With it the difference of both sides tends to $\\mu 1$, of norm $\\sqrt{{3}} \\mu$ (measured: {limit} at
ε = {size}), with an observed order of {order}. With the pressure of (3.3) that balances it at rest, $p_0 = \\mu$, for
Mooney–Rivlin $p_0 = \\mu + 2 \\mu_2$, the order is two. So P in (1.12) has to be the stress with its pressure, not
the derivative (1.5) of the energy alone."""


def _orders(rows: Mapping[str, Any], names: list[str]) -> dict[str, float]:
    return {
        "smallest_order": min(rows[name]["smallest_order"] for name in names),
        "largest_order": max(rows[name]["largest_order"] for name in names),
    }


def _percent(value: float, digits: int) -> str:
    return f"{100 * value:.{digits}f} %"


def _cubic_table(cubic: Mapping[str, Any]) -> Table:
    rows = [
        [_percent(spread, 0), low, high, best, error, printed]
        for spread, low, high, best, error, printed in zip(
            *(cubic[k] for k in ("spreads", "smallest", "largest", "best_constant", "error")),
            cubic["constant_difference"],
            strict=True,
        )
    ]
    return Table(
        f"The cubic spring ($k$ = {STIFFNESS}, $\\ell_o$ = {REST}, $\\ell_a$ = {ACTIVE}) at 1001 lengths within so "
        "much of $\\ell_o$: the smallest and largest $f_a$ that makes (1.9) and (1.10) agree, the best constant, its "
        "largest error relative to itself, and the error of the force with $f_a = -k(\\ell_a - \\ell_o)^3$, which "
        "is right without a load only, relative to the largest force.",
        [
            "lengths",
            "smallest $f_a$",
            "largest $f_a$",
            "best constant",
            "its error",
            "error with $-k\\delta^3$",
        ],
        rows,
    )


def _order_table(rows: Mapping[str, Any], directions: int) -> Table:
    return Table(
        f"(1.12) over {directions} random directions: $\\|A\\| = 1$, $1/2 \\le |g| \\le 1$, ε from {SIZES[0]} halved "
        f"eight times; orders between the two smallest strains. $\\mu$ = 1, $\\mu_2$ = 0.5. The last column is the "
        f"median of the difference relative to $\\|P(F) - P(F_o)\\|$ at ε = {SIZES[0]}.",
        ["material", "stress", "$p_0$", "smallest order", "largest order", "relative difference"],
        [
            [
                material + (", $\\det F = 1$" if isochoric else ""),
                STRESSES[form],
                rows[name]["pressure"],
                rows[name]["smallest_order"]
                if form != ENERGY_ALONE
                else f"{rows[name]['smallest_order']:.0e}",
                rows[name]["largest_order"] if form != ENERGY_ALONE else f"{rows[name]['largest_order']:.0e}",
                rows[name]["relative_median"],
            ]
            for name, (material, form, isochoric) in ROWS.items()
        ],
    )


def _draw_springs(linear: Found, cubic: Found) -> Figure:
    figure = new_figure(6.0, 5.6)
    above, below = figure.subplots(2, 1, sharex=True)
    length = cubic.arrays["length"]
    above.plot(length, linear.arrays["needed"], color=GREY, label="linear spring")
    above.plot(length, cubic.arrays["needed"], color=BLUE, label="cubic spring")
    best = cubic.numbers["best_constant"][0]
    above.axhline(best, color=VERMILION, linestyle="--", label="best constant, cubic spring")
    above.set_ylabel("active force $f_a$ needed")
    above.legend(loc="upper center")
    below.plot(length, cubic.arrays["active_strain"], color=BLUE, label="active strain (1.10)")
    below.plot(
        length,
        cubic.arrays["active_stress"],
        color=VERMILION,
        linestyle="--",
        label="active stress (1.9), best constant",
    )
    below.axhline(0, color=GREY, linewidth=0.7)
    below.set_xlabel("length $\\ell$")
    below.set_ylabel("force $f$ of the cubic spring")
    below.legend(loc="upper left")
    return figure


def _draw_orders(found: Mapping[str, Found]) -> Figure:
    figure = new_figure(6.0, 4.2)
    axes = figure.subplots()
    shown = {
        "neo_hookean_residual": (VERMILION, "energy alone: residual stress"),
        "neo_hookean": (BLUE, "without residual stress"),
        "neo_hookean_pulled_back": (GREEN, "the same, pulled back (1.6)"),
    }
    for name, (colour, label) in shown.items():
        sizes, differences = found[name].arrays["sizes"], found[name].arrays["differences"]
        axes.fill_between(
            sizes, differences.min(axis=0), differences.max(axis=0), color=colour, alpha=0.18, lw=0
        )
        axes.plot(sizes, np.median(differences, axis=0), "o-", markersize=4, color=colour, label=label)
    guide = np.array([SIZES[-1], SIZES[2]])
    axes.plot(guide, 3 * guide**2, color=GREY, linestyle=":", label="slope 2")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("strain ε")
    axes.set_ylabel("norm of the difference in (1.12)")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.91))
    return figure
