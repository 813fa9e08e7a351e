"""Section 5: the energy of an initial potential, and which bumps start a pulse."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.reproduce.chapters.startup_jobs import LATER, MODES, SPACINGS, TOLERANCES, WEAK, jobs
from myostrain.reproduce.chapters.startup_numbers import all_numbers, point, rest
from myostrain.reproduce.chapters.startup_show import pictures, tables
from myostrain.reproduce.content import Chapter, Difference, Statement
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.page import number
from myostrain.reproduce.verdict import claims

__all__ = ["TITLE", "chapter", "jobs"]

TITLE = "Start-up of a pulse: energy, thresholds and strain (section 5)"


_INTRODUCTION = r"""
Diffusion damps a potential and the reaction feeds it. Section 5 multiplies the equations of $v$ and $w$ by
$v$ and by $A w$, adds them and finds how the energy $\int (v^2 + A w^2)/2$ changes (5.1). At $t = 0$, where
$w = 0$, the energy grows where
$$A \int v^2 (v - \alpha)(1 - v) \, d\Omega \ge D \int |\mathbf{F}^{-T} \text{Grad} v|^2 d\Omega \quad (5.2)$$
and for a homogeneous strain this is certain where the least eigenvalue of $\mathbf{C}$ is above the ratio of
the right side, taken without $\mathbf{F}$, to the left one (5.4). Here we check the identity, ask of many bumps
whether (5.2) tells those that fire from those that decay, and see what a contraction can do to a potential.

Where $J$ is not one, as on the line of section 4, our derivation has $J$ in front of every integrand of (5.1)
and one term more, $-\frac{1}{2} \int J_t (v^2 + A w^2)$, since $v \, \partial (J v)/\partial t$ is
$\partial (J v^2/2)/\partial t + J_t v^2/2$.

A bump *fires* if $v$ exceeds 0.5 somewhere at $t$ = 0.3. We look for the threshold in its height by bisection,
for bumps $v = a$ on $|X| \le R$ ("steps", as in figure 2) and for smooth ones, $v = a \exp(-(X/R)^2)$; on the
*coupled* line (4.6), on the line *held* at $x' = 1$ until $t$ = 0.01 and then let go, and on the *rigid* one.
Everywhere $\alpha$ = 0.1, $\tau$ = 0.2, $D = A$ = 100, $\beta$ = 0.3.
"""


def chapter(found: Mapping[str, Found], quick: bool) -> Chapter:
    """The chapter."""
    numbers = all_numbers(found, quick)
    return Chapter(
        introduction=_INTRODUCTION,
        statements=_statements(numbers, quick),
        tables=tables(found, numbers, quick),
        pictures=pictures(found, numbers, quick),
        differences=_differences(numbers),
        numbers=numbers,
        remarks=_remarks(numbers, quick),
    )


def _statements(n: Mapping[str, Any], quick: bool) -> list[Statement]:
    every = claims("startup")
    sheet, line, rates = n["energy"]["sheet"]["printed"], n["energy"]["line"], n["rates"]
    yes, no, sides, driven = n["with_recovery"], n["without_recovery"], n["sides"], n["driven"]
    wide = point(n, "paper", "rigid", 40.0)
    close = point(n, "smooth, w = 0", "coupled", 6.5)
    steps = "4e-4 and 2e-4 to t = 0.01" if quick else "2e-4 and 1e-4 to t = 0.02"
    needed = sides["stretch"][0]
    said = {
        "energy-sheet": f"A plane-stress sheet of side 24 on the elastic support, cells of 2, a smooth bump in a corner, "
        f"steps of {steps}. Observed orders: second-order {number(sheet['order_second_order'])}, implicit "
        f"{number(sheet['order_implicit'])}, staggered {number(sheet['order_staggered'])}; what is missing "
        f"at a step of zero is at most {number(sheet['remainder'])} of the sum of the terms.",
        "energy-line": f"The coupled line, length 40, cells of 1, steps of {steps}. As printed, without $J$, the two sides "
        f"differ by {number(line['printed']['remainder'])} of the sum of the terms, however small the step; with "
        f"the weight $J$ alone by {number(line['weighted']['remainder'])}; with the term of $J_t$ too by "
        f"{number(line['whole']['remainder'])}, at orders {number(line['whole']['order_second_order'])}, "
        f"{number(line['whole']['order_implicit'])} and {number(line['whole']['order_staggered'])}.",
        "begins-to-grow": f"Bumps of four heights on a line held at $x'$ = 1.3 (cells of 0.25) and on a sheet held at "
        f"stretches 1.2 and 0.9 (cells of 0.5), two steps of 2e-6 and 1e-6: the sign is that of (5.2) in "
        f"all but {rates['wrong_signs']} of 8, the rate off by at most {number(rates['discrepancy'])} of the "
        "sum of both sides.",
        "minimum-energy": f"Of {yes['points']} combinations of shape, half-width and line, {yes['fire']} have a threshold "
        f"below a height of one. The least energy at a threshold, half the integral of $v^2$, is "
        f"{number(yes['least_energy'])}, at $R$ = {yes['least_energy_half_width']:g}; it is not one number: the "
        f"largest is {number(yes['largest_energy'])}.",
        "sufficient": f"Of {yes['satisfiable']} combinations for which some height satisfies (5.2), heights that satisfy it "
        f"decay in {yes['not_sufficient']}: wide and low bumps, and smooth ones. The rigid step of "
        f"$R$ = 40 (cells of 1, steps of 1e-3) satisfies (5.2) from a height of "
        f"{number(wide['satisfied_from'])} on and fires from {number(wide['threshold'])} on, since $w$, absent "
        "from (5.2), grows meanwhile. Without recovery little is missing: the coupled smooth bump of "
        f"$R$ = 6.5 satisfies (5.2) from {close['satisfied_from']:.4f} and fires (by t = 1) from "
        f"{close['threshold']:.4f}. For steps with $R \\le 10$, as in figure 2, (5.2) did suffice, by at "
        f"least {number(yes['least_margin_narrow_steps'])} in height.",
        "necessary": f"In {yes['exceptions']} of {yes['fire']} combinations bumps that do not satisfy (5.2) fire. A step "
        "of $R$ = 2 satisfies it at no height (cells of 1), and fires from "
        f"{number(point(n, 'paper', 'coupled', 2.0)['threshold'])} on (coupled): diffusion first lowers the bump's "
        "edges, and what remains is above the threshold.",
        "figure-2-fails": "Exact integrals of the bump $v$ = 0.6 on $|X| \\le 1$, linear between the nodes, on the coupled line: "
        + "; ".join(
            f"cells of {h:g}: {number(g)} against {number(c)}"
            for h, g, c in zip(SPACINGS, sides["gain"], sides["coupled"], strict=True)
        )
        + ". The right side grows as one over the cell size: a bump with a jump satisfies (5.2) on no mesh that "
        "is fine enough.",
        "figure-2-held": f"Held at $x'$ = 1 (cells of 1), the bump of figure 2 gives {number(sides['gain'][0])} against "
        f"{number(sides['held'][0])}, free {number(sides['coupled'][0])}: (5.2) fails in both panels, and so it "
        "is not what separates them. The held line does fire, and the coupled one does not, as printed.",
        "minimum-strain": f"For figure 2's bump (cells of 1) (5.4) asks for $x'$ above {number(needed)}. By bisection, the "
        f"line that is held until t = 0.01 fires from $x'$ = {number(n['least_stretch'])} on. The stretch of "
        f"(5.4) is enough: held at 2 throughout, the line fires (largest v {number(n['stretched_peak'])} at "
        "t = 0.3). It is not the least one.",
        "incompressible": "Principal stretches from 1/1.3 to 1.3 in a plane, and the third that keeps the volume, on a "
        "cube of 1,296 tetrahedra: of a ball-shaped signal diffusion never takes less than for F = 1 "
        f"(least ratio {number(n['isochoric']['ball'])}; exactly, one third of the trace of "
        "$\\mathbf{C}^{-1}$, which is at least one), and the least eigenvalue of $\\mathbf{C}$ is never above "
        f"{number(n['isochoric']['eigenvalue'])}. For a signal that varies along two directions or one, as in "
        f"a sheet, it takes as little as {number(n['isochoric']['column'])} and "
        f"{number(n['isochoric']['layer'])} of that.",
        "rest": "Line and plane-stress sheet with $v$ = 0, contracted by an active strain of −0.3 within 0.01 (stretch of the "
        f"fibre at the end {number(driven['line contracts, v = 0']['stretch'])} and "
        f"{number(driven['sheet contracts, v = 0']['stretch'])}), or held at a stretch of 1.3 (line), 1.2 and 0.9 "
        f"(sheet), and let go: largest |v| {rest(n):g} in all of 200 steps each.",
        "nonzero": f"A homogeneous potential of {WEAK}, below $\\alpha$, while an active strain grows to −0.3 within 0.01. The "
        f"line conserves $J v$, and $v$ rises to {number(driven['line contracts']['largest'])}; the incompressible "
        f"sheet leaves it alone. From {LATER} the contracting line fires "
        f"(v up to {number(driven['line contracts, higher']['largest'])}), the rigid one does not "
        f"({number(driven['rigid, higher']['largest'])}).",
    }
    margin = {"least_margin": yes["least_margin"]}
    rise = {
        name: max(driven[run]["largest"] for run in runs) / WEAK
        for name, runs in {
            "line": ["line contracts"],
            "sheet": ["sheet contracts", "sheet let go"],
        }.items()
    }
    readings: dict[str, Mapping[str, Mapping[str, float | None]]] = {
        "energy-sheet": {"plane-stress sheet": sheet},
        "energy-line": {"as printed": line["printed"], "with J and the term of J_t": line["whole"]},
        "begins-to-grow": {"held line and sheet": rates},
        "minimum-energy": {"line": yes},
        "sufficient": {"with recovery": margin, "without recovery (w = 0)": no},
        "necessary": {"with recovery": yes},
        "figure-2-fails": {"coupled line": {"largest_ratio": max(sides["ratio_coupled"])}},
        "figure-2-held": {"cells of 1": {"ratio": sides["ratio_held"][0]}},
        "minimum-strain": {"held until t = 0.01": {"ratio": n["least_stretch"] / needed}},
        "incompressible": {
            "a signal that varies in all directions": {"least_loss": n["isochoric"]["ball"]},
            "a signal that varies in the plane of a sheet only": {"least_loss": n["isochoric"]["column"]},
        },
        "rest": {"line and sheet": {"largest_potential": rest(n)}},
        "nonzero": {
            "line, J = x′": {"rise": rise["line"]},
            "incompressible body, J = 1 (3.8)": {"rise": rise["sheet"]},
        },
    }
    return [Statement(claim, said[name], readings[name]) for name, claim in every.items()]


def _differences(n: Mapping[str, Any]) -> list[Difference]:
    line, sides, driven = n["energy"]["line"], n["sides"], n["driven"]
    wide, close = point(n, "paper", "coupled", 40.0), point(n, "smooth", "rigid", 3.0)
    let_go = driven["line let go, w = 0"]
    return [
        Difference(
            "The energy identity (5.1) where J is not one",
            "(5.1) closes for an incompressible body, to the order of the scheme. On the line of sections 4 and 6, where "
            f"$J = x'$, it is off by {number(line['printed']['remainder'])} of the sum of its terms at any step. With "
            "$J$ in front of every integrand and $-\\frac{1}{2} \\int J_t (v^2 + A w^2)$ on the right it closes "
            f"(to {number(line['whole']['remainder'])}). The condition (5.2) stays what it is while the line is "
            "held at a homogeneous stretch.",
            "myostrain reproduce startup",
        ),
        Difference(
            "(5.2) and the two panels of figure 2",
            f"Free, figure 2's bump gives {number(sides['gain'][0])} against {number(sides['coupled'][0])} in (5.2); held "
            f"at $x'$ = 1, {number(sides['gain'][0])} against {number(sides['held'][0])} (cells of 1). So the strain of "
            "figure 2(b) does not make the bump satisfy (5.2), and still it fires: (5.2) is not what separates the "
            "panels. The right side grows as one over the cell size, because the bump jumps; with finer cells (5.2) "
            "holds for no such bump. The command shows the held line firing (potential_max).",
            "myostrain run startup-1d --set mechanics.imposed_stretch='{value=1.0, until=0.01}'",
        ),
        Difference(
            "(5.2) and (5.4) are neither sufficient nor necessary for a pulse",
            "(5.2) says that the energy begins to grow, and it does. A pulse needs more than that, because $w$ grows meanwhile "
            f"and because bumps change shape. A step of $R$ = 40 and height {LATER} on the coupled line satisfies (5.2) "
            f"(from {number(wide['satisfied_from'])} on, cells of 1) and decays (threshold "
            f"{number(wide['threshold'])}); even a homogeneous {LATER} does. A smooth bump of $R$ = 3 satisfies it from "
            f"{number(close['satisfied_from'])} on and needs {number(close['threshold'])} (rigid). Conversely, most "
            "bumps that fire do not satisfy it at their threshold. A wording that the numbers bear out: (5.2) is the "
            "condition for the energy to grow at first.",
            f"myostrain run startup-1d --set geometry.length=100.0 --set initial.radius=40.0 "
            f"--set initial.potential={LATER}",
        ),
        Difference(
            "The minimum strain (5.4)",
            f"For figure 2's bump (5.4) asks for $x'$ above {number(sides['stretch'][0])}; at the paper's spacing, a stretch "
            f"of {number(n['least_stretch'])} until t = 0.01 is enough (the command takes 0.9). In an incompressible body "
            "det $\\mathbf{C}$ = 1, so that the least eigenvalue in (5.4) is at most one: (5.4) can hold only where the "
            "undeformed body satisfies (5.2) already. The paper says that this eigenvalue cannot be much smaller than "
            "one; what limits the effect is that it cannot be larger. (5.2) itself can be reached by an isochoric "
            "strain for a signal that varies along the stretched directions only, not for a ball-shaped one.",
            "myostrain run startup-1d --set mechanics.imposed_stretch='{value=0.9, until=0.01}'",
        ),
        Difference(
            "A contraction can raise a potential where J is not one",
            "From rest nothing can be raised, and in an incompressible body nothing at all: both are exact here. But the "
            "conservative line keeps $J v$, so that its contraction raises a potential that is there: for $J \\ne 1$ "
            "(2.8) contains $-v \\, \\partial J/\\partial t$. A homogeneous "
            f"{WEAK}, below $\\alpha$ = 0.1, held at $x'$ = 1 and let go at t = 0.01, jumps from "
            f"{number(let_go['before'])} to {number(let_go['after'])}, above $\\alpha$, and without recovery it goes "
            "on to one, where the rigid line decays. (The command; until=inf for the rigid line.) With recovery an active "
            f"strain of −0.3 makes {LATER} fire, which decays on the rigid line.",
            "myostrain run startup-1d --set cell.recovery=false --set initial.radius=60.0 "
            f"--set initial.potential={WEAK} --set time.end=1.0 "
            "--set mechanics.imposed_stretch='{value=1.0, until=0.01}'",
        ),
    ]


def _remarks(n: Mapping[str, Any], quick: bool) -> str:
    coarse = {mode: point(n, "paper", mode, 2.0)["threshold"] for mode in ("coupled", "held")}
    fine = {mode: point(n, "fine", mode, 2.0)["threshold"] for mode in ("coupled", "held")}
    text = (
        "**The window of figure 2's effect.** For a step of $R$ = 2 the thresholds are "
        f"{number(coarse['coupled'])} (coupled) and {number(coarse['held'])} (held) at the paper's spacing, "
        f"{number(fine['coupled'])} and {number(fine['held'])} with cells of 0.25 and the bump's mean at each node. "
    )
    if quick:
        return (
            text
            + f"At the quick settings thresholds are known to {TOLERANCES[True][0] / 2:g}; the full settings refine the mesh further."
        )
    closer = n["closer"]
    limits = {m: closer[f"window mean {m} 0.125"] for m in ("coupled", "held")}
    change = max(abs(limits[m] - closer[f"window mean {m} 0.25"]) for m in limits)
    nodal = {m: 2 * closer[f"window nodal {m} 0.125"] - closer[f"window nodal {m} 0.25"] for m in limits}
    later = max(
        abs(closer[f"later {m} {w}"] - n_threshold)
        for m in MODES
        for w in ("2", "40")
        if (n_threshold := point(n, "paper", m, float(w))["threshold"]) is not None
    )
    implicit = max(
        abs(closer[f"implicit {m} {w:g}"] - point(n, "paper", m, w)["threshold"])
        for m, w in (("coupled", 2.0), ("held", 1.0))
    )
    return text + (
        f"With cells of 0.125 and means they are {number(limits['coupled'])} and {number(limits['held'])}, which the last "
        f"refinement changed by at most {number(change)}. Sampled at the nodes, the bump covers half a cell more and "
        "the thresholds converge at first order only, extrapolated to "
        f"{number(nodal['coupled'])} and {number(nodal['held'])}.\n\n"
        f"**What the thresholds hang on.** Asking at t = 0.5 instead of 0.3 moves them by at most {number(later)} (steps "
        "of $R$ = 2 and 40, cells of 1, bisection to 2e-3); the paper's implicit scheme, at its step of 1e-3, by at most "
        f"{number(implicit)} (coupled, $R$ = 2; held, $R$ = 1). The bisection takes for granted that a bump higher "
        "than one that fires does so too."
    )
