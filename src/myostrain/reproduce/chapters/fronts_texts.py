"""Words and tables of the chapter on fronts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.reproduce.chapters.fronts_jobs import (
    ALPHA,
    BETA,
    COARSE,
    FASTEST,
    RATE,
    TAU,
    Settings,
    settings,
)
from myostrain.reproduce.content import Difference, Table
from myostrain.reproduce.page import number

INTRODUCTION = """\
On a line whose ends are free the elastic body follows its activation at once, $x' = 1 + \\gamma = 1 - \\beta v$, (4.3)
and (3.4). In material coordinates the potential obeys (4.6),

$$\\frac{\\partial}{\\partial t}((1 - \\beta v) v) - D \\frac{\\partial}{\\partial X}\\left(\\frac{1}{1 - \\beta v}
\\frac{\\partial v}{\\partial X}\\right) = -A (1 - \\beta v) v (v - \\alpha)(v - 1) - A (1 - \\beta v) w.$$

Without recovery, $w = 0$, fronts travel between $v = 0$ and $v = 1$. The paper finds them in closed form, (4.9)–(4.12),
for $A = 1$; for any $A$, $a^2$ of (4.10) is multiplied by $A$ and $c$ of (4.11) by $\\sqrt A$. The *advective* balance,
$J\\, \\partial v / \\partial t$ in place of $\\partial (J v) / \\partial t$, has fronts of the same family (4.9), with
$D a^2 = A (1 - \\alpha\\beta)/(2 - \\beta)$. Below, the simulated line is held at its left end, where $v = 0$, and
excited on the right, as below (4.8); it begins with the exact profile and is measured after some travel: its velocity
from the place of $v = 1/2$, its steepness $a$ as the slope of $\\log(v/(1-v))$ over $x$, which by (4.9) and (4.3) is
constant."""


def statements(n: Mapping[str, Any], quick: bool) -> dict[str, str]:
    """What was measured, by claim."""
    s = settings(quick)
    grid = f"h = {s.spacing:g}, Δt = {s.step:g}"
    e, spread, search = n["equilibria"], n["spreading"], n["search"]
    agreement, orders, limit = n["agreement"], n["orders"], n["limit"]
    temporal, small = n["temporal_variation"], n["infinitesimal"]
    rows = [*n["fronts"], *n["advective"]]
    sweep = f"Over {len(rows)} fronts, α from {min(r['alpha'] for r in rows)} to {max(r['alpha'] for r in rows)} and β "
    sweep += f"from 0 to {max(r['beta'] for r in n['fronts'])} (advective: to {max(r['beta'] for r in n['advective'])}), "
    sweep += f"A = D = {RATE:g}, {grid}"
    return {
        "equilibria": (
            f"Four cells, β = {BETA}, A = {RATE:g}, Δt = 0.002 to t = 0.1: coupled homogeneous lines that begin at an "
            "equilibrium, with and without recovery, conservative and advective, move by at most "
            f"{number(e['drift'])}. Without recovery the rate of homogeneous states with −0.1 < v < 1.1 changes sign "
            f"at {e['zeros']} places, rigid or coupled, and these differ by at most {number(e['moved'])}."
        ),
        "stable-point": (
            f"With recovery, α = {ALPHA}, τ = {TAU}, A = {RATE:g}, β = {BETA}: the growth rate of small homogeneous "
            f"perturbations of either sign is at most {number(e['growth_at_rest'])} at rest, and at least "
            f"{number(e['growth_elsewhere'])} at the two other equilibria, v = 0.5 and 0.6; rigid, conservative and "
            f"advective. Measured from the program's steps (Δt = 10⁻⁴), within {_percent(e['rates_off_linear_algebra'], 2)} of the "
            "eigenvalues of the linearised cell."
        ),
        "diffusion": (
            f"A cosine of amplitude 0.001 on $v$ = 0.5, β = {BETA}, no reaction, 80 cells of 0.25, Δt = 0.001: it decays "
            f"{spread['conservative_over_rigid']:.4f} times as fast as on the rigid line, which is "
            f"$1/((1 - 2\\beta v)(1 - \\beta v))$ = {1 / (1 - BETA) / (1 - BETA / 2):.4f}; advective, "
            f"{spread['advective_over_rigid']:.4f} times, $1/(1 - \\beta v)^2$ = {1 / (1 - BETA / 2) ** 2:.4f}."
        ),
        "temporal-variation": (
            f"Homogeneous states without recovery, 0 < v ≤ 1.1, β = {BETA}: the coupled rate is "
            f"{temporal['least_ratio']:.4f} to {temporal['largest_ratio']:.4f} times the rigid one, growing with $v$ as "
            f"$(1 - \\beta v)/(1 - 2\\beta v)$ does (off by at most {number(temporal['off_exact'])})."
        ),
        "infinitesimal": (
            f"Speeds at β = {small['betas'][0]} and {small['betas'][1]}, α = {ALPHA}, {grid}, exceed the rigid line's by "
            f"{_percent(small['changes'][0], 3)} and {_percent(small['changes'][1], 3)}: an observed order of {small['order']:.3f} in β."
        ),
        "profile": f"{sweep}: the largest difference of v(X) from the integral of (4.9) is "
        f"{number(agreement['potential_error'])}.",
        "steepness": (
            f"{sweep}: measured over exact steepness is {agreement['steepness_least']:.4f} to "
            f"{agreement['steepness_largest']:.4f}. At A = D = 1, α = {ALPHA}, β = {BETA}, over the formula as printed, "
            f"{n['unit_A']['steepness_over_printed']:.5f}."
        ),
        "speed": (
            f"{sweep}: the measured speed over that of the closed form is {agreement['speed_least']:.4f} to "
            f"{agreement['speed_largest']:.4f}; at A = D = 1, α = {ALPHA}, β = {BETA}, over the formula as printed, "
            f"{n['unit_A']['speed_over_printed']:.5f}; extrapolated to h = Δt = 0, {orders['extrapolated_speed']:.6f}. "
            f"A front that comes of a bump (`front-1d`, between X = 50 and 100, h = {s.bump[0]:g}, Δt = {s.bump[1]:g}) "
            f"has {n['bump']['celerity']:.3f}, {n['bump']['ratio']:.4f} times (4.11). The *sign* is the other one: "
            f"with v(+∞) = 1 and α < 1/2 the front travels towards −X, $c$ = {number(n['unit_A']['c'], 4)} at A = D = 1, where "
            f"(4.11) has {-n['unit_A']['c_exact']:.4f}."
        ),
        "place": f"{sweep}, β > 0: the largest difference of x(X) from (4.12), over the shortening of the line, is "
        f"{number(agreement['place_error'])}.",
        "hyperbolic-tangent": (
            f"β = 0, α = {ALPHA}, A = D = {RATE:g}, {grid}: v(X) is within {number(n['tangent']['potential_error'])} of "
            f"the hyperbolic tangent, and travels {n['tangent']['speed_ratio']:.5f} times as fast as $(1 - 2\\alpha)"
            "\\sqrt{DA/2}$."
        ),
        "existence": (
            f"Following both saddles of (4.8) to $v = 1/2$, without (4.9), at α = 0.9 and 0.7 for speeds up to "
            f"{FASTEST:g} $\\sqrt{{DA}}$: fronts up to αβ = {search['last_front']:.4g}, none from "
            f"{search['first_without']:.4g}; where they exist their speeds are those of (4.11) within "
            f"{_percent(search['off_exact'], 1)}. Simulated fronts at α = 0.9 up to αβ = {max(limit['product']):.3g}, {grid}: "
            f"$a^2$ and $1/c^2$ fall towards zero at αβ = {limit['limit_from_steepness']:.4f} and "
            f"{limit['limit_from_speed']:.4f}. So towards the limit the front becomes flat and fast without bound. "
            "A body of this kind cannot come to the limit: see the differences."
        ),
        "faster": (
            "Conservative, all pairs with α < 1/2 and β > 0 of the sweep: the measured speed is at least "
            f"{n['faster']:.4f} times the rigid line's at the same α; {_paper(n)['speed_ratio']:.4f} times at α = {ALPHA}, "
            f"β = {BETA} ({grid})."
        ),
        "sharper": (
            f"The same pairs: ∂v/∂X at v = 1/2 is down to {n['sharper_in_material']:.4f} times the rigid line's, "
            f"{_paper(n)['slope_ratio']:.4f} times at α = {ALPHA}, β = {BETA}, where the length in X from v = 0.1 to "
            f"0.9 is {_paper(n)['width_material_ratio']:.4f} times. In space the front is sharper: measured $a$ is at "
            f"least {n['sharper']:.4f} times the rigid line's, {_paper(n)['steepness_ratio']:.4f} times at α = {ALPHA}, "
            f"β = {BETA}, and the length in x {_paper(n)['width_spatial_ratio']:.4f} times ({grid})."
        ),
    }


def _paper(n: Mapping[str, Any]) -> Mapping[str, Any]:
    """The front at the paper's α and β."""
    row: Mapping[str, Any] = next(r for r in n["fronts"] if (r["alpha"], r["beta"]) == (ALPHA, BETA))
    return row


def equilibria_table(n: Mapping[str, Any]) -> Table:
    """Equilibria and their growth rates."""
    rows = []
    for row in n["equilibria"]["rows"]:
        if row["model"] == "advective":
            continue
        kind = "with recovery" if row["recovery"] == "with_recovery" else "without"
        nature = "stable" if row["growth"] < 0 else "unstable"
        rows.append(
            [
                kind,
                f"{row['potential']:g}",
                row["model"],
                _rates(row["rates"]),
                _rates(row["predicted"]),
                nature,
            ]
        )
    return Table(
        f"Growth rates of homogeneous perturbations of ±10⁻⁴ about every equilibrium: of the program's steps (Δt = 10⁻⁴, "
        f"t = 10⁻³, second-order scheme, four cells), and the eigenvalues of its linearised cell. α = {ALPHA}, τ = {TAU}, "
        f"A = {RATE:g}, β = {BETA}. Advective rates are those of the rigid line.",
        ["recovery", "$v$", "line", "measured", "linear algebra", "so"],
        rows,
    )


def _rates(values: list[list[float]]) -> str:
    if len(values) == 2 and values[0][1] != 0:
        return f"{number(values[0][0], 4)} ± {number(abs(values[0][1]), 4)} i"
    return ", ".join(number(re, 4) for re, _ in values)


def _percent(value: float, digits: int) -> str:
    return f"{100 * value:.{digits}f} %"


def sweep_table(n: Mapping[str, Any], grid: str) -> Table:
    """Speeds and steepness over α and β."""
    rows: list[list[str | float | int | None]] = []
    for balance, found in (("conservative", n["fronts"]), ("advective", n["advective"])):
        rows += [
            [
                "rigid" if row["beta"] == 0 else balance,
                f"{row['alpha']:g}",
                f"{row['beta']:g}",
                f"{row['alpha'] * row['beta']:.3g}",
                row["c"],
                row["c_exact"],
                row["steepness"],
                row["steepness_exact"],
                row["potential_error"],
            ]
            for row in found
        ]
    return Table(
        f"Fronts with v(−∞) = 0, v(+∞) = 1, A = D = {RATE:g}, {grid}, second-order scheme (iterated for β ≥ 0.4, "
        "conservative): velocity in v(X − ct), steepness, and the largest error of v(X).",
        ["balance", "α", "β", "αβ", "$c$", "exact", "$a$", "exact", "error of $v$"],
        rows,
    )


def sharpness_table(n: Mapping[str, Any], grid: str) -> Table:
    """Ratios to the rigid line."""
    rows: list[list[str | float | int | None]] = [
        [
            balance,
            f"{row['alpha']:g}",
            f"{row['beta']:g}",
            *(
                row[f"{key}_ratio"]
                for key in ("speed", "steepness", "width_spatial", "slope", "width_material")
            ),
        ]
        for balance, found in (("conservative", n["fronts"]), ("advective", n["advective"]))
        for row in found
        if row["beta"] > 0 and "speed_ratio" in row
    ]
    return Table(
        f"Sharper and faster? Measured ratios to the rigid line at the same α, A = D = {RATE:g}, {grid}: speed, "
        "steepness $a$ (∂v/∂x at v = 1/2 is $a/4$), length in x from v = 0.1 to 0.9, and in the material ∂v/∂X at "
        "v = 1/2 and the length in X.",
        ["balance", "α", "β", "speed", "$a$", "length in $x$", "slope in $X$", "length in $X$"],
        rows,
    )


def order_table(n: Mapping[str, Any], s: Settings) -> Table:
    """Observed orders."""
    orders = n["orders"]

    def row(what: str, sizes: list[float], values: list[float], order: float, declared: str) -> list[Any]:
        return [
            what,
            ", ".join(f"{x:g}" for x in sizes),
            ", ".join(f"{v:.5f}" for v in values),
            f"{order:.2f}",
            declared,
        ]

    rows = [
        row(
            f"h, at Δt = {s.step:g}",
            orders["spacings"],
            orders["speed_by_spacing"],
            orders["order_in_h"],
            "2",
        )
    ]
    rows += [
        row(
            f"Δt, {scheme}",
            orders["steps"][scheme],
            orders["speed_by_step"][scheme],
            orders["order_in_step"][scheme],
            "2" if scheme == "second-order" else "1",
        )
        for scheme in orders["steps"]
    ]
    return Table(
        f"Speed over (4.11) at α = {ALPHA}, β = {BETA}, conservative, A = D = {RATE:g}, as h or Δt is halved (h = "
        f"{COARSE:g} where Δt is), and the order observed from the differences of the last three.",
        ["halved", "sizes", "speed over exact", "observed order", "declared"],
        rows,
    )


def differences(n: Mapping[str, Any]) -> list[Difference]:
    """Where the paper and the numbers differ."""
    unit, paper, limit = n["unit_A"], _paper(n), n["limit"]
    retreating = [r for r in n["fronts"] if r["alpha"] > 0.5 and r["beta"] > 0 and "speed_ratio" in r]
    bump = " ".join(f"--set '{setting}'" for setting in MIRRORED)
    return [
        Difference(
            "The sign of c in (4.11)",
            "In v(X − ct) with v(−∞) = 0, v(+∞) = 1 and a > 0, as in (4.8) and (4.9), the front travels towards −X for "
            "α < 1/2: the excited state lies on the right and invades the rest. Putting (4.9) into (4.8) gives "
            "$c a = -(1 - 2\\alpha)/(2(1 - \\beta))$, so $c$ is the negative of (4.11). Measured at A = D = 1, "
            f"α = {ALPHA}, β = {BETA}: {number(unit['c'], 4)}, printed: {number(-unit['c_exact'], 4)}. We read (4.11) as the speed. The "
            "command excites the right end; the probe at X = 300 activates before the one at X = 200.",
            f"myostrain run front-1d {bump}",
        ),
        Difference(
            "αβ < 1/2 is not the bound that a contracting line meets first (section 4.1)",
            "The fronts exist up to αβ = 1/2, as the paper says. But (4.6) is $(1 - 2\\beta v)\\, \\partial v/\\partial t = "
            "\\ldots$, which is parabolic forward in time only while 2βv < 1: with v up to 1, only for β < 1/2. As α < 1, "
            "αβ = 1/2 would need β > 1/2, so that no well-posed line of this kind reaches the limit. For β ≥ 1/2 the closed form still solves (4.8), but no initial state evolves into it, "
            "and the program refuses such a case, with this reason. The nearest front that we simulated has "
            f"αβ = {max(limit['product']):.3g} and agrees with (4.10) and (4.11). The advective balance has no such bound: "
            "it needs αβ < 1, which β < 1 and α < 1 imply.",
            "myostrain run front-1d --set activation.beta=0.5",
        ),
        Difference(
            "“Sharper” holds in space, and for α < 1/2 (section 4.1)",
            "The steepness $a$ of (4.10) exceeds the rigid line's for α < 1/2. In space the front is the logistic "
            "function of steepness $a$ whatever β, so there it is sharper. In the material its slope carries the factor "
            f"$1 - \\beta v$ of (4.9): at α = {ALPHA}, β = {BETA}, ∂v/∂X at v = 1/2 is {paper['slope_ratio']:.3f} times "
            f"the rigid line's and the length from v = 0.1 to 0.9 is {paper['width_material_ratio']:.3f} times, while in "
            f"space it is {paper['width_spatial_ratio']:.3f} times. For α > 1/2, where the front retreats, it is faster "
            f"too ({min(r['speed_ratio'] for r in retreating):.3f} times or more), but less steep: "
            f"{min(r['steepness_ratio'] for r in retreating):.3f} to "
            f"{max(r['steepness_ratio'] for r in retreating):.3f} times. Both balances alike.",
            "myostrain reproduce fronts",
        ),
    ]


#: The front that starts on the right.
MIRRORED = ("initial.center=[400.0]", "probes={a=[300.0], b=[200.0]}")


def remarks(n: Mapping[str, Any]) -> str:
    """What else was seen."""
    at = {
        (r["model"], r["potential"]): r for r in n["equilibria"]["rows"] if r["recovery"] == "with_recovery"
    }
    return f"""\
**Three equilibria with recovery.** Equilibria of (4.6) and (4.7) have $w = \\tau v$ and
$v ((v - \\alpha)(v - 1) + \\tau) = 0$. At the paper's α = {ALPHA}, τ = {TAU} this has the roots 0, 0.5 and 0.6: rest is
not the only equilibrium. These parameters lie just inside that region, α < 1 − 2√τ = {1 - 2 * TAU**0.5:.4f}, beyond which
the two vanish. Both are unstable, v = 0.5 a saddle (growth {number(at["rigid", 0.5]["growth"])} rigid,
{number(at["conservative", 0.5]["growth"])} coupled) and v = 0.6 a focus ({number(at["rigid", 0.6]["growth"])} and
{number(at["conservative", 0.6]["growth"])}), so the paper's “the null stable point” is right: it is the only stable one.
The coupling changes rates, by $(1 - \\beta v)/(1 - 2\\beta v)$ without recovery, but not a sign.

**Speed per material or spatial length.** Here the tissue ahead of the front is held, and then the front has the same
speed in x as in X, as x − X is the same at any place of the front. Were the tissue behind it held, its speed in x would
be $1 - \\beta$ times as large.

**The two balances.** What (4.10) and (4.11) say of the advective balance at 2β they say of the conservative one at β:
the speeds and $a$ of both are equal there, as the table shows at β = 0.3 and 0.15.

**Settled?** Velocities of the last half of each run and of the quarter before it agree within
{number(n["agreement"]["unsettled"])}, and the table of orders shows what mesh and step leave."""
