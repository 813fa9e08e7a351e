"""Section 4.2: a pulse on the viscoelastic line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.reproduce.chapters.viscosity_pictures import pictures
from myostrain.reproduce.content import Chapter, Difference, Statement, Table
from myostrain.reproduce.jobs import Found, Job
from myostrain.reproduce.measurements.lines import lowest, pulse_job
from myostrain.reproduce.page import number
from myostrain.reproduce.verdict import claims

import numpy as np

TITLE = "Viscoelasticity of the line (section 4.2)"

TAU = 0.2
#: λ/τ of the sweep.
QUICK_PARTS = (1e-3, 0.1, 0.25, 0.5, 0.7, 1.0, 3.0, 10.0, 1e3)
PARTS = (1e-3, 0.01, 0.03, 0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0, 2.0, 3.0, 10.0, 100.0, 1e3)
#: λ/τ at which the delay of section 8 is judged.
JUDGED = 1.0
#: Time steps at which the least λ, 2 × 10⁻⁴, is run, and seconds that it takes.
STIFF_STEPS = {1e-3: 3.0, 1e-4: 30.0}
READING = "(4.14) with the contraction as its rest state"
PRINTED = "(4.14) as printed"
WATCH = 100.0
QUICK_WATCH = 60.0
#: Mesh and step: of the quick settings, and of the full ones.
GRID = {
    True: ("geometry.spacing=1.0", "time.step=4e-3", "geometry.length=180.0", "time.end=2.6",
           "probes={a=[60.0], b=[100.0]}"),
    False: ("geometry.spacing=0.5", "time.step=1e-3"),
}  # fmt: skip


def jobs(quick: bool) -> dict[str, Job]:
    """The computations: the two limits, and the sweep."""
    cost, watch = (2.0, QUICK_WATCH) if quick else (12.0, WATCH)
    wanted = {
        "rigid": pulse_job("pulse-1d-rigid", GRID[quick], watch=watch, cost=0.6 * cost),
        "elastic": pulse_job("pulse-1d", (*GRID[quick], "output.rigid_twin=false"), watch=watch, cost=cost),
    }
    for part in QUICK_PARTS if quick else PARTS:
        settings = (*GRID[quick], f"mechanics.relaxation_time={part * TAU:.6g}", "output.rigid_twin=false")
        wanted[f"{part:g}"] = pulse_job("pulse-1d", settings, watch=watch, cost=cost)
    if not quick:
        wanted |= {f"stiffest, Δt = {step}": _stiffest(step, cost) for step, cost in STIFF_STEPS.items()}
    return wanted


def _stiffest(step: float, cost: float) -> Job:
    """The least λ on a short line, to see what a time step far above λ does."""
    short = (
        "geometry.length=120.0",
        "time.end=1.6",
        "probes={a=[40.0], b=[80.0]}",
        "output.rigid_twin=false",
    )
    settings = (*short, f"time.step={step}", f"mechanics.relaxation_time={PARTS[0] * TAU:.6g}")
    return pulse_job("pulse-1d", settings, cost=cost)


def chapter(found: Mapping[str, Found], quick: bool) -> Chapter:
    """The chapter."""
    numbers = _numbers(found, quick)
    return Chapter(
        introduction=_introduction(quick),
        statements=_statements(numbers, quick),
        tables=[_table(numbers, quick)],
        pictures=pictures(found, numbers, settings(quick), QUICK_WATCH if quick else WATCH),
        differences=_differences(numbers),
        numbers=numbers,
        remarks=_remarks(numbers, quick),
    )


NAMES = ("celerity", "width_material", "width_spatial", "half_width", "shortening_max", "shortening_half_width",
         "peak_delay", "rise_delay")  # fmt: skip


def _numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    parts = QUICK_PARTS if quick else PARTS
    limits = {row: {name: found[row].numbers[name] for name in NAMES} for row in ("elastic", "rigid")}
    sweep = [{"part": part, **{name: found[f"{part:g}"].numbers[name] for name in NAMES}} for part in parts]
    elastic, rigid = limits["elastic"], limits["rigid"]
    for row in sweep:
        row |= {
            "celerity_share": (row["celerity"] - rigid["celerity"])
            / (elastic["celerity"] - rigid["celerity"]),
            "width_ratio": row["width_spatial"] / rigid["width_spatial"],
            "width_material_ratio": row["width_material"] / rigid["width_material"],
            "wave_ratio": None
            if row["shortening_half_width"] is None
            else row["shortening_half_width"] / row["half_width"],
        }
    celerity, inner = np.array([row["celerity"] for row in sweep]), sweep[1:-1]
    place = {
        name: lowest(np.log10(parts), np.array([row[name] for row in sweep]))
        for name in ("width_spatial", "width_material")
    }
    numbers: dict[str, Any] = {
        "limits": limits,
        "sweep": sweep,
        "elastic_limit": {name: sweep[0][name] / elastic[name] for name in ("celerity", "width_spatial")},
        "rigid_limit": {name: sweep[-1][name] / rigid[name] for name in ("celerity", "width_spatial")},
        "printed_over_elastic": {name: rigid[name] / elastic[name] for name in ("celerity", "width_spatial")},
        "celerity_rises_by_at_most": float(np.diff(celerity).max()),
        "celerity_share": [min(r["celerity_share"] for r in inner), max(r["celerity_share"] for r in inner)],
        "least_width": {
            name: {"part": 10 ** place[name][0], "value": value, "ratio": value / rigid[name]}
            for name, (_, value) in place.items()
        },
        "judged": next(row for row in sweep if row["part"] == JUDGED),
    }
    if not quick:
        coarse, fine = (found[f"stiffest, Δt = {step}"].numbers for step in STIFF_STEPS)
        numbers["step_error"] = {
            name: coarse[name] / fine[name] - 1 for name in ("celerity", "width_spatial", "potential_max")
        }
    return numbers


def settings(quick: bool) -> str:
    """Mesh and step in words."""
    if quick:
        return "Δx = 1, Δt = 4 × 10⁻³, a line of length 180 at t = 2.6 (quick settings, good to 1 %)"
    return "Δx = 1/2, Δt = 10⁻³, a line of length 400 at t = 5"


def _introduction(quick: bool) -> str:
    return rf"""
Section 4.2 puts a spring and a dashpot side by side (Voigt–Kelvin), with a relaxation time $\lambda$, and prints

$$\lambda \frac{{d}}{{dt}}\left(\frac{{x' - 1}}{{1 + \gamma}}\right) + \frac{{x' - 1}}{{1 + \gamma}} = 0.
\qquad (4.14)$$

As printed, no contraction is in it: with $y = (x' - 1)/(1 + \gamma)$ it reads $\lambda \frac{{dy}}{{dt}} + y = 0$, so a line that
starts relaxed, $y = 0$, stays at $x' = 1$ for every $\lambda$, and any other start is forgotten. With $x' - 1 -
\gamma$ in both places it would give $x' = 1 + \gamma$ for every $\lambda$ instead. The equation that has both limits
which the paper states, and that this program solves, has the contraction in the spring alone:

$$\lambda \frac{{d}}{{dt}}\left(\frac{{x' - 1}}{{1 + \gamma}}\right) + \frac{{x' - 1 - \gamma}}{{1 + \gamma}} = 0,
\qquad x' = 1 \text{{ at }} t = 0.$$

The spring pulls towards $x' = 1 + \gamma$ (4.3), the dashpot resists. Here is the pulse of figure 1 on it, for
$\lambda$ from $\tau/1000$ to $1000\,\tau$, $\tau = 0.2$, $\beta = 0.3$; {settings(quick)}.
"""


def _statements(numbers: Any, quick: bool) -> list[Statement]:
    claim = claims("viscosity")
    first, last, judged = numbers["sweep"][0], numbers["sweep"][-1], numbers["judged"]
    elastic, rigid = numbers["limits"]["elastic"], numbers["limits"]["rigid"]
    printed = numbers["printed_over_elastic"]
    low, high = numbers["celerity_share"]
    least = numbers["least_width"]["width_spatial"]

    def limit(values: Mapping[str, float]) -> dict[str, float | None]:
        return {"celerity_ratio": values["celerity"], "width_ratio": values["width_spatial"]}

    none = {"peak_delay_share": None, "rise_delay_share": None}
    duration = judged["half_width"] / judged["celerity"]
    delays = {name + "_share": judged[name] / duration for name in ("peak_delay", "rise_delay")}
    return [
        Statement(
            claim["viscous-elastic-limit"],
            f"With $\\lambda = \\tau/1000$ celerity and width in x are {first['celerity']:.2f} and "
            f"{first['width_spatial']:.2f}, on the elastic line {elastic['celerity']:.2f} and "
            f"{elastic['width_spatial']:.2f}. Equation (4.14) as printed keeps the line rigid, whatever $\\lambda$: "
            f"celerity {printed['celerity']:.2f} of the elastic line's.",
            {PRINTED: limit(printed), READING: limit(numbers["elastic_limit"])},
        ),
        Statement(
            claim["viscous-rigid-limit"],
            f"With $\\lambda = 1000\\,\\tau$ celerity and width in x are {last['celerity']:.2f} and "
            f"{last['width_spatial']:.2f}, on the rigid line {rigid['celerity']:.2f} and "
            f"{rigid['width_spatial']:.2f}; the line shortens by {number(last['shortening_max'])} at most. "
            f"Equation (4.14) as printed gives the rigid line itself.",
            {
                PRINTED: {"celerity_ratio": 1.0, "width_ratio": 1.0, "shortening": 0.0},
                READING: {**limit(numbers["rigid_limit"]), "shortening": last["shortening_max"]},
            },
        ),
        Statement(
            claim["viscous-velocity"],
            f"As $\\lambda$ grows the celerity falls from {first['celerity']:.2f} to {last['celerity']:.2f}, from each of "
            f"the {len(numbers['sweep'])} values to the next, by {number(-numbers['celerity_rises_by_at_most'])} at "
            f"least. Of the way from rigid to elastic, the intermediate ones are at {low:.4f} to {high:.4f}. As printed, "
            f"(4.14) has no intermediate values.",
            {
                PRINTED: {"least_share": 0.0, "largest_share": 0.0, "largest_rise": 0.0},
                READING: {
                    "least_share": low,
                    "largest_share": high,
                    "largest_rise": numbers["celerity_rises_by_at_most"],
                },
            },
        ),
        Statement(
            claim["viscous-width"],
            f"The width in x falls from {elastic['width_spatial']:.2f} (elastic) to a minimum of "
            f"{least['value']:.2f} at $\\lambda$ = {least['part']:.2f} $\\tau$ and comes back to "
            f"{rigid['width_spatial']:.2f} (rigid): at its least it is {(1 - least['ratio']) * 100:.0f} % shorter than "
            f"in the shorter of the two limits. The width in X does the same, with its minimum, "
            f"{numbers['least_width']['width_material']['value']:.2f}, at $\\lambda$ = "
            f"{numbers['least_width']['width_material']['part']:.2f} $\\tau$. (As printed, (4.14) has no intermediate "
            f"values to judge.)",
            {READING: {"least_width_over_the_shorter_limit": least["value"]
                       / min(elastic["width_spatial"], rigid["width_spatial"])}},
        ),
        Statement(
            claim["viscous-delay"],
            f"At X = {QUICK_WATCH if quick else WATCH:g} with $\\lambda = \\tau$ the shortening peaks "
            f"{judged['peak_delay']:.3f} after the potential, and rises through half its maximum "
            f"{judged['rise_delay']:.3f} after the potential does; the potential is above half its maximum for "
            f"{duration:.3f}. On the elastic line both come at once. As printed, (4.14) has no contraction.",
            {PRINTED: none, READING: delays},
        ),
        Statement(
            claim["viscous-long-wave"],
            "Over the length where each is more than half its maximum, in X: "
            + "; ".join(
                f"$\\lambda$ = {row['part']:g} $\\tau$: contraction {row['shortening_half_width']:.1f}, potential "
                f"{row['half_width']:.1f}, ratio {row['wave_ratio']:.2f}, at a largest shortening of "
                f"{row['shortening_max']:.3f}"
                for row in numbers["sweep"]
                if row["part"] in (0.1, 1.0, 3.0, 10.0) and row["wave_ratio"] is not None
            )
            + ". The wave gets as long as one likes, and as weak. As printed, (4.14) has no contraction.",
            {
                PRINTED: {"length_ratio": None, "shortening_share": 0.0},
                **{
                    f"{READING}, λ = {row['part']:g} τ": {
                        "length_ratio": row["wave_ratio"],
                        "shortening_share": row["shortening_max"] / elastic["shortening_max"],
                    }
                    for row in numbers["sweep"]
                    if 1.0 <= row["part"] <= 10.0
                },
            },
        ),
    ]  # fmt: skip


def _table(numbers: Any, quick: bool) -> Table:
    elastic, rigid = numbers["limits"]["elastic"], numbers["limits"]["rigid"]

    def cells(title: str, row: Mapping[str, Any]) -> list[Any]:
        wave = row["shortening_half_width"]
        return [title, row["celerity"], row["width_material"], row["width_spatial"],
                row["width_spatial"] / rigid["width_spatial"], row["shortening_max"], row["peak_delay"],
                row["rise_delay"], None if wave is None else wave / row["half_width"]]  # fmt: skip

    rows = [cells("elastic", elastic), *(cells(f"{row['part']:g}", row) for row in numbers["sweep"])]
    return Table(
        f"The pulse of figure 1 over λ/τ. {settings(quick)}; delays at X = {QUICK_WATCH if quick else WATCH:g}; a dash: "
        "there is no contraction, or it ends neither there nor then.",
        ["$\\lambda/\\tau$", "celerity", "width in X", "width in x", "over rigid", "largest $1 - x'$",
         "delay of peaks", "delay of rises", "contraction/potential, length"],
        [*rows, cells("rigid", {**rigid, "shortening_half_width": None, "peak_delay": None, "rise_delay": None})],
    )  # fmt: skip


def _differences(numbers: Any) -> list[Difference]:
    elastic, rigid = numbers["limits"]["elastic"], numbers["limits"]["rigid"]
    least = numbers["least_width"]["width_spatial"]
    return [
        Difference(
            "No contraction in equation (4.14)",
            """
As printed, $\\lambda \\frac{d}{dt}\\left(\\frac{x' - 1}{1 + \\gamma}\\right) + \\frac{x' - 1}{1 + \\gamma} = 0$ is an
equation for $y = (x' - 1)/(1 + \\gamma)$ alone whose solutions are $y(0)\\, e^{-t/\\lambda}$: the potential never
contracts the line, and $\\lambda \\to 0$ gives $x' = 1$ rather than (4.3), of which (4.14) is to be a generalisation. We
solve $\\lambda \\frac{d}{dt}\\left(\\frac{x' - 1}{1 + \\gamma}\\right) + \\frac{x' - 1 - \\gamma}{1 + \\gamma} = 0$ with
$x' = 1$ at first, which has the limits that section 4.2 describes: elastic for $\\lambda \\ll \\tau$, rigid for
$\\lambda \\gg \\tau$. (With $x' - 1 - \\gamma$ under the derivative, too, there would be no rigid limit.) The command
runs it with $\\lambda = \\tau/1000$; its pulse is that of the elastic line.
""",
            "myostrain run pulse-1d --set mechanics.relaxation_time=2e-4 --out runs/viscous-elastic-limit",
        ),
        Difference(
            "The width at intermediate relaxation times (section 4.2)",
            f"""
The paper: for intermediate $\\lambda$ "the propagating signal has a velocity and width within those of the extreme
cases". The velocity has. The width in $x$ is {elastic["width_spatial"]:.2f} on the elastic line and
{rigid["width_spatial"]:.2f} on the rigid one, but {least["value"]:.2f} at $\\lambda$ = {least["part"]:.2f} $\\tau$,
{(1 - least["ratio"]) * 100:.0f} % less than either; the width in $X$ has a minimum as well. The command runs the pulse near that minimum beside the
rigid line.
""",
            "myostrain run pulse-1d --set mechanics.relaxation_time=0.1 --out runs/viscous-width",
        ),
    ]


def _remarks(numbers: Any, quick: bool) -> str:
    text = """
**A relaxation time below the time step.** The least $\\lambda$, 2 × 10⁻⁴, is shorter than the time step. The rate
in (4.14) is taken implicitly, so this is stable, and the line then simply follows its elastic rest state.
"""
    if quick:
        return text
    error = numbers["step_error"]
    return text + (
        f"On a short line with Δx = 1, Δt = {number(1e-3)} in place of {number(1e-4)}, half of that $\\lambda$, changes the "
        f"celerity by {number(error['celerity'])}, the width in x by {number(error['width_spatial'])} and the largest "
        f"potential by {number(error['potential_max'])}, relative."
    )
