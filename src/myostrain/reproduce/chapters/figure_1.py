"""Figure 1: a pulse on the rigid and on the contracting line."""

from __future__ import annotations

from collections.abc import Mapping
from math import log2
from typing import Any

from myostrain.reproduce.chapters.figure_1_pictures import pictures
from myostrain.reproduce.content import Chapter, Difference, Statement, Table
from myostrain.reproduce.jobs import Found, Job
from myostrain.reproduce.measurements.lines import extrapolated, pulse_job
from myostrain.reproduce.page import number
from myostrain.reproduce.verdict import claims

TITLE = "Figure 1: a pulse on a rigid and on a contracting line"

#: Models of the line by a name for the numbers: what the page calls them, and their keys.
RIGID = "rigid"
READINGS = {
    "conservative": ("conservative, as printed in (4.6)–(4.7)", ()),
    "advective": ("advective balance, J ∂v/∂t", ("potential.balance=advective",)),
    "viscous": ("viscoelastic line, λ = 0.4 τ", ("mechanics.relaxation_time=0.08",)),
}
#: The same, for tables.
SHORT = {
    "conservative": "conservative, as printed",
    "advective": "advective",
    "viscous": "viscoelastic, $\\lambda = 0.4\\,\\tau$",
}
SWEEP = {"beta_02": "activation.beta=0.2", "beta_01": "activation.beta=0.1"}
STRIPS = {"plane_strain": "plane-strain", "plane_stress": "plane-stress"}
STRIP = (
    'geometry={kind="rectangle", size=[180.0, 1.0], spacing=1.0}',
    "fibres={direction=[1.0, 0.0]}",
    "initial.center=[0.0, 0.0]",
    "material.model=NeoHookean",
    "mechanics.fixed=[]",
    "time.end=2.6",
    "probes={a=[80.0, 0.0], b=[130.0, 0.0]}",
)
SPACINGS = (1.0, 0.5, 0.25)
QUICK_STEP, STEP = 4e-3, 1e-3
NAMES = ("celerity", "width_material", "width_spatial", "front_spatial", "potential_max", "potential_min")
SECONDS = {1.0: 9.0, 0.5: 11.0, 0.25: 18.0}


def line_job(row: str, spacing: float, step: float) -> Job:
    """The job of a row of the table on the line, to t = 5."""
    settings = () if row == RIGID else READINGS[row][1] if row in READINGS else (SWEEP[row],)
    return pulse_job(
        "pulse-1d-rigid" if row == RIGID else "pulse-1d",
        (*settings, f"geometry.spacing={spacing}", f"time.step={step}", "output.rigid_twin=false"),
        cost=SECONDS[spacing] * STEP / step * (0.6 if row == RIGID else 1.0),
    )


def jobs(quick: bool) -> dict[str, Job]:
    """The computations."""
    step = QUICK_STEP if quick else STEP
    wanted = {row: line_job(row, 1.0, step) for row in (RIGID, *READINGS, *SWEEP)}
    if quick:
        return wanted
    for spacing in SPACINGS[1:]:
        wanted |= {f"{row}, Δx = {spacing}": line_job(row, spacing, step) for row in (RIGID, *READINGS)}
    for row in (RIGID, "conservative"):
        wanted[f"{row}, Δt = 5e-4"] = line_job(row, 1.0, 5e-4)
        name = "pulse-1d-rigid" if row == RIGID else "pulse-1d"
        wanted[f"{row}, implicit"] = pulse_job(
            name, ("time.scheme=implicit", "output.rigid_twin=false"), cost=15.0 if row == RIGID else 30.0
        )
    for row, kinematics in STRIPS.items():
        settings = (*STRIP, f"mechanics.kinematics={kinematics}", "output.rigid_twin=false")
        wanted[row] = pulse_job("pulse-1d", settings, cost=10.0)
    return wanted


def chapter(found: Mapping[str, Found], quick: bool) -> Chapter:
    """The chapter."""
    numbers = _numbers(found, quick)
    ratios = numbers["ratios"] if quick else numbers["converged_ratios"]
    paper = numbers["ratios"]
    judged = {text: ratios[row] for row, (text, _) in READINGS.items()}
    statements = [
        Statement(claim, _measured(name, ratios, paper, numbers, quick), judged)
        for name, claim in claims("figure-1").items()
    ]
    return Chapter(
        introduction=_introduction(quick),
        statements=statements,
        tables=_tables(numbers, quick),
        pictures=pictures(found, numbers["step"]),
        differences=[_difference(ratios, numbers)],
        numbers=numbers,
        remarks=_remarks(numbers, quick),
    )


def _numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number: rows and their ratios to the rigid line, at Δx = 1 and converged."""
    rows = {row: _row(found[row]) for row in (RIGID, *READINGS, *SWEEP)}
    numbers: dict[str, Any] = {
        "spacing": 1.0,
        "step": QUICK_STEP if quick else STEP,
        "time": 5.0,
        "rows": rows,
        "ratios": {row: _ratios(values, rows[RIGID]) for row, values in rows.items()},
    }
    if quick:
        return numbers
    meshes = {
        row: [rows[row], *(_row(found[f"{row}, Δx = {h}"]) for h in SPACINGS[1:])]
        for row in (RIGID, *READINGS)
    }
    limits = {
        row: {name: extrapolated(medium[name], fine[name]) for name in NAMES}
        for row, (_, medium, fine) in meshes.items()
    }
    halved = {row: _row(found[f"{row}, Δt = 5e-4"]) for row in (RIGID, "conservative")}
    implicit = {row: _row(found[f"{row}, implicit"]) for row in (RIGID, "conservative")}
    strips = {row: _row(found[row]) for row in STRIPS}
    fine_ratios = {row: _ratios(values[-1], meshes[RIGID][-1]) for row, values in meshes.items()}
    limit_ratios = {row: _ratios(values, limits[RIGID]) for row, values in limits.items()}
    return numbers | {
        "meshes": {
            row: dict(zip(("1", "1/2", "1/4"), values, strict=True)) for row, values in meshes.items()
        },
        "orders": {
            row: {name: _order(*(mesh[name] for mesh in values)) for name in NAMES[:4]}
            for row, values in meshes.items()
        },
        "converged": limits,
        "converged_ratios": limit_ratios,
        "converged_error": max(
            abs(limit_ratios[row][name] - fine_ratios[row][name])
            for row in READINGS
            for name in ("celerity_ratio", "width_ratio", "position_ratio")
        ),
        "step_halved": halved,
        "step_error": max(abs(halved[row][n] / rows[row][n] - 1) for row in halved for n in NAMES[:4]),
        "implicit": implicit,
        "implicit_ratios": {row: _ratios(values, implicit[RIGID]) for row, values in implicit.items()},
        "strips": strips,
        "strip_ratios": {row: _ratios(values, rows[RIGID]) for row, values in strips.items()},
    }


def _row(found: Found) -> dict[str, float]:
    return {name: found.numbers[name] for name in NAMES}


def _ratios(row: Mapping[str, float], rigid: Mapping[str, float]) -> dict[str, float]:
    """A row over the rigid line's; the widths both over its one width."""
    names = {
        "celerity_ratio": "celerity",
        "width_ratio": "width_spatial",
        "width_material_ratio": "width_material",
        "position_ratio": "front_spatial",
        "maximum_ratio": "potential_max",
        "minimum_ratio": "potential_min",
    }
    return {ratio: row[name] / rigid[name] for ratio, name in names.items()}


def _order(coarse: float, medium: float, fine: float) -> float:
    return log2(abs((coarse - medium) / (medium - fine)))


def percent(ratio: float, more: str, less: str) -> str:
    """A ratio in words: "12.3 % longer"."""
    return f"{abs(ratio - 1) * 100:.1f} % {more if ratio > 1 else less}"


def _at(quick: bool) -> str:
    step = number(QUICK_STEP)
    return (
        f"at Δx = 1, Δt = {step} (quick settings, good to 1 %)"
        if quick
        else f"extrapolated from Δx = 1/2 and 1/4 at Δt = {number(STEP)}"
    )


def _introduction(quick: bool) -> str:
    return rf"""
A pulse is started at the left end of a line, $0 \le X \le 400$, and looked at when $t = 5$; $\alpha = 0.1$,
$\tau = 0.2$, $D = A = 100$. The paper compares the standard FitzHugh–Nagumo line with the one that contracts by
$x' = 1 - \beta v$, both drawn against the spatial coordinate $x$. It does not restate $\beta$ here; we take the
0.3 of section 3, and smaller ones beside it.

Celerity is material length over time, between X = 100 and X = 200; it is the speed in $x$ too, since a steady
pulse pulls back the tissue ahead of it by the same length all the time. Widths are between the two
places where $v = 1/2$, in $x$ unless we say otherwise. Three readings are judged: the conservative balance
$\partial (Jv)/\partial t$ as printed, the advective one $J\,\partial v/\partial t$, and the conservative one on
the viscoelastic line of section 4.2 with $\lambda = 0.4\,\tau$. Numbers under the statements are
{_at(quick)}; the scheme is of second order in time.
"""


def _measured(name: str, ratios: Any, paper: Any, numbers: Any, quick: bool) -> str:
    """What was measured for a claim."""
    own = ratios["conservative"]

    def each(key: str, more: str, less: str) -> str:
        return "; ".join(
            f"{text}: {percent(ratios[row][key], more, less)}" for row, (text, _) in READINGS.items()
        )

    faster, wider = each("celerity_ratio", "faster", "slower"), each("width_ratio", "wider", "shorter")
    rows = numbers["rows"]
    if name in ("pulse-faster", "pulse-celerity"):
        at_paper = "" if quick else (
            f" At the paper's Δx = 1, Δt = {number(STEP)} the printed equations give "
            f"{percent(paper['conservative']['celerity_ratio'], 'faster', 'slower')}, with the paper's first-order "
            f"implicit scheme {percent(numbers['implicit_ratios']['conservative']['celerity_ratio'], 'faster', 'slower')}."
        )  # fmt: skip
        position = percent(own["position_ratio"], "farther", "less far")
        return (
            f"Celerity against the rigid line's: {faster}.{at_paper} A picture at one time shows the position of "
            f"the front instead, which holds the start, too: at t = 5 the printed model's is {position}."
        )
    if name in ("pulse-shorter", "pulse-width"):
        return (
            f"Width in x against the rigid line's: {wider}. In the material the printed model's pulse is even "
            f"{percent(own['width_material_ratio'], 'wider', 'shorter')}."
        )
    if name == "pulse-both":
        return f"Celerity: {faster}. Width in x: {wider}."
    if name == "pulse-maximum":
        values = ", ".join(f"{text} {rows[row]['potential_max']:.3f}" for row, (text, _) in READINGS.items())
        return (
            f"Largest v at t = 5 on the mesh with Δx = 1: rigid {rows[RIGID]['potential_max']:.3f}, {values}."
        )
    values = ", ".join(f"{text} {number(rows[row]['potential_min'])}" for row, (text, _) in READINGS.items())
    return (
        f"Least v at t = 5 on the mesh with Δx = 1: rigid {number(rows[RIGID]['potential_min'])}, {values}. "
        f"The undershoot behind the printed model's pulse is {(1 - own['minimum_ratio']) * 100:.0f} % shallower; the "
        f"reading that bears out both percentages of figure 1 has it "
        f"{(1 - ratios['viscous']['minimum_ratio']) * 100:.0f} % shallower."
    )


def _tables(numbers: Any, quick: bool) -> list[Table]:
    head = ["line", "celerity", "width in X", "width in x", "front in x", "v max", "v min"]

    def cells(title: str, row: Mapping[str, float], ratio: Mapping[str, float], position: bool = True) -> Any:
        """Values, and behind them their ratios to the rigid line."""
        keys = ("celerity_ratio", "width_material_ratio", "width_ratio", "position_ratio", "maximum_ratio",
                "minimum_ratio")  # fmt: skip
        shown = [
            f"{row[name]:.{digits}f} ({ratio[key]:.3f})".replace("-", "−")
            for name, key, digits in zip(NAMES, keys, (2, 2, 2, 1, 3, 3), strict=True)
        ]
        return [title, *shown[:3], shown[3] if position else None, *shown[4:]]

    titles = {RIGID: "rigid", **SHORT}
    titles |= {"beta_02": "conservative, $\\beta = 0.2$", "beta_01": "conservative, $\\beta = 0.1$"}
    rows = [cells(titles[row], values, numbers["ratios"][row]) for row, values in numbers["rows"].items()]
    if not quick:
        for row, title in (
            ("rigid", "rigid, first-order implicit"),
            ("conservative", "conservative, first-order implicit"),
        ):
            rows.append(cells(title, numbers["implicit"][row], numbers["implicit_ratios"][row]))
        for row, title in (("plane_strain", "incompressible strip, plane strain"),
                           ("plane_stress", "incompressible strip, plane stress")):  # fmt: skip
            rows.append(cells(title, numbers["strips"][row], numbers["strip_ratios"][row], position=False))
    caption = (
        f"Figure 1 on the paper's mesh: Δx = 1, 400 cells, Δt = {number(numbers['step'])}, t = 5; in brackets the "
        "ratio to the rigid line by the same scheme."
    )
    if quick:
        return [Table(caption, head, rows)]
    caption += (
        " The strips, 180 × 1 in squares of side 1 cut into triangles, fibres along them, all sides free, obey (7.2) "
        "and are looked at when t = 2.6."
    )
    fine = [
        cells(titles[row], values, numbers["converged_ratios"][row])
        for row, values in numbers["converged"].items()
    ]
    orders = [o["celerity"] for o in numbers["orders"].values()]
    fine_caption = (
        f"The same, converged: extrapolated with order 2 from Δx = 1/2 and 1/4, Δt = {number(STEP)}. Observed orders of "
        f"the celerity are {min(orders):.2f} to {max(orders):.2f}; the ratios differ from those at Δx = 1/4 by "
        f"{number(numbers['converged_error'])} at most. Half the time step changes celerities, widths and positions by "
        f"{number(numbers['step_error'])} at most, relative."
    )
    return [Table(caption, head, rows), Table(fine_caption, head, fine)]


def _remarks(numbers: Any, quick: bool) -> str:
    ratios = numbers["ratios"]
    sweep = "; ".join(
        f"$\\beta$ = {beta}: {percent(ratios[row]['celerity_ratio'], 'faster', 'slower')} and "
        f"{percent(ratios[row]['width_ratio'], 'wider', 'shorter')} in x"
        for beta, row in (("0.1", "beta_01"), ("0.2", "beta_02"), ("0.3", "conservative"))
    )
    text = f"""
**Another β?** The paper does not restate $\\beta$ for this figure. With the printed equations {sweep}. A smaller
$\\beta$ gives the celerity, but none of them a pulse that is shorter in $x$.
"""
    if quick:
        return text
    strips = "; ".join(
        f"{title}: {percent(numbers['strip_ratios'][row]['celerity_ratio'], 'faster', 'slower')}, "
        f"{percent(numbers['strip_ratios'][row]['width_ratio'], 'wider', 'shorter')} in x"
        for row, title in (
            ("plane_strain", "plane strain, where the stretch is $\\sqrt{1 + \\gamma}$"),
            ("plane_stress", "plane stress, where it is $(1 + \\gamma)^{2/3}$"),
        )
    )
    return (
        text
        + f"""
**Incompressible strips.** Equation (7.2) has no $J$. On a thin strip that contracts freely along its fibres
({strips}) it makes the celerity's claim true, too, but not the width's.
"""
    )


def _difference(ratios: Any, numbers: Any) -> Difference:
    printed, viscous, advective = (ratios[row] for row in ("conservative", "viscous", "advective"))
    return Difference(
        "The two percentages of figure 1 (section 6)",
        f"""
The paper: the coupled pulse is faster by "of order 10%" and shorter by "about 25%". Equations (4.6)–(4.7) with
$\\beta = 0.3$ give a pulse that is {percent(printed["celerity_ratio"], "faster", "slower")} and
{percent(printed["width_ratio"], "wider", "shorter")} in $x$; a smaller $\\beta$ brings both differences down
together, to {percent(numbers["ratios"]["beta_01"]["celerity_ratio"], "faster", "slower")} and
{percent(numbers["ratios"]["beta_01"]["width_ratio"], "wider", "shorter")} with $\\beta = 0.1$. The advective balance
$J\\,\\partial v/\\partial t$ gives {percent(advective["celerity_ratio"], "faster", "slower")} and
{percent(advective["width_ratio"], "wider", "shorter")}; the viscoelastic line of section 4.2 with
$\\lambda = 0.4\\,\\tau$ gives both of the paper's numbers:
{percent(viscous["celerity_ratio"], "faster", "slower")} and {percent(viscous["width_ratio"], "wider", "shorter")},
with an undershoot that is {(1 - viscous["minimum_ratio"]) * 100:.0f} % shallower than the rigid line's. We cannot
tell which model drew the figure; some relaxation of the contraction, wanted or from the way in which the two
equations were solved in turn, would explain it. The command runs the printed model beside the rigid line and prints
both; add `--set mechanics.relaxation_time=0.08` for the viscoelastic one.
""",
        "myostrain run pulse-1d --out runs/figure-1",
    )
