"""The viscous sheet: the delay and the longer mechanical wave that section 8 announces."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.output.figures.style import COLOURS, GREY, new_figure
from myostrain.reproduce.content import Chapter, Difference, Picture, Statement, Table
from myostrain.reproduce.jobs import Found, Job
from myostrain.reproduce.measurements.cases import resolved
from myostrain.reproduce.page import number
from myostrain.reproduce.verdict import claims

import numpy as np
from matplotlib.figure import Figure

TITLE = "A viscous sheet (section 8)"

TAU = 0.2
#: λ/τ of the sheets; the last one is all but rigid.
SHARES = (0.0, 0.1, 0.4, 1.0, 5.0, 50.0)
#: λ/τ that are shown over time.
SHOWN = (0.0, 1.0, 5.0)
#: λ/τ of the sheet that does not stretch below rest.
RECTIFIED = 5.0
PROBE = "centre"
#: Contractions of the free block.
SIZES = (0.3, 0.02, 0.01)
BLOCK = 0.7


def jobs(quick: bool) -> dict[str, Job]:
    """A sheet for each λ, one whose activation stops at rest, the free block, and random motions."""
    mesh = ["geometry.spacing=3.0", "time.step=6e-3"] if quick else []
    cost = 3.0 if quick else 20.0

    def sheet(share: float, rectified: bool = False) -> Job:
        case = resolved("sheet-2d", [*mesh, f"mechanics.relaxation_time={share * TAU}"])
        return Job("viscous.wave", {"case": case, "probe": PROBE, "rectified": rectified}, cost)

    def block(kinematics: str, size: float) -> Job:
        steps = 100 if quick else 400
        return Job(
            "viscous.free_block",
            {"kinematics": kinematics, "size": size, "relaxation_time": BLOCK, "steps": steps},
            1.0,
        )

    samples = {"samples": 2000, "seed": 1, "relaxation_time": 0.3, "mu": 2.0}
    return {
        **{f"sheet {share}": sheet(share) for share in SHARES},
        "rectified": sheet(RECTIFIED, rectified=True),
        **{f"{k} {size}": block(k, size) for k in ("plane-stress", "plane-strain") for size in SIZES},
        "motions": Job("viscous.dissipation", samples, 0.5),
    }


def chapter(found: Mapping[str, Found], quick: bool) -> Chapter:
    """Delay and length of the mechanical wave over λ/τ, frame indifference, dissipation, the line's limit."""
    named = claims("viscous-sheet")
    rows = {share: _row(found, f"sheet {share}") for share in SHARES} | {
        "rectified": _row(found, "rectified")
    }
    orders = {k: _order(found, k) for k in ("plane-stress", "plane-strain")}
    block = {
        "order_plane_stress": orders["plane-stress"],
        "order_plane_strain": orders["plane-strain"],
        "difference_plane_stress": found["plane-stress 0.02"].numbers["difference"],
        "difference_plane_strain": found["plane-strain 0.02"].numbers["difference"],
    }
    motions = found["motions"].numbers
    readings = {_reading(share): rows[share] for share in (1.0, 0.4, 5.0, 50.0)}
    readings["λ = 5 τ, and no stretch below rest"] = rows["rectified"]
    one, most = rows[1.0], rows["rectified"]
    mesh = (
        "`sheet-2d` with spacing 3, Δt = 6e-3, mechanics every 4 steps"
        if quick
        else "`sheet-2d` as it ships: 12,097 nodes, Δt = 3e-3, mechanics every 4 steps"
    )
    statements = [
        Statement(
            named["viscous-delay"],
            f"At λ = τ the shortening of the fibre at the centre rises {number(one['rise_delay'])} later than the "
            f"potential, {number(100 * one['rise_delay_over_duration'])} % of the pulse's duration, and peaks "
            f"{number(one['peak_delay'])} later; the elastic sheet's rises {number(rows[0.0]['rise_delay'])} later. "
            f"The peak of the shortening is {number(100 * one['peak_over_elastic'])} % of the elastic one ({mesh}).",
            readings,
        ),
        Statement(
            named["viscous-length"],
            f"At λ = τ the mechanical wave lasts {number(one['length_ratio'])} times as long as the potential's. "
            f"It is longer only where little is left of it: {number(rows[50.0]['length_ratio'])} times at λ = 50 τ, "
            f"with {number(100 * rows[50.0]['peak_over_elastic'])} % of the elastic shortening. One reason is that "
            "γ = −βv stretches the fibre where v undershoots its rest, which pulls the wave's tail back; with "
            f"γ = −β max(v, 0) it lasts {number(most['length_ratio'])} times as long at λ = 5 τ, with "
            f"{number(100 * most['peak_over_elastic'])} % of the elastic shortening.",
            readings,
        ),
        Statement(
            named["viscous-frame"],
            f"{motions['samples']} random motions in three dimensions, with random fibres and activations: the "
            f"least power is {number(motions['least'])} of the largest, its distance from "
            "$2\\lambda\\mu J_o |\\mathbf{F}_o^{-T}\\dot{\\mathbf{E}}\\mathbf{F}_o^{-1}|^2$ is "
            f"{number(motions['defect'])}; seen from a turning frame the stress changes by "
            f"{number(motions['frame'])} of itself, and a rigid motion gives {number(motions['rigid'])}.",
            {"printed": motions},
        ),
        Statement(
            named["viscous-line"],
            f"A free sheet under γ(t) = −g sin² πt, λ = {BLOCK}: its strain along the fibre over 2/3 (plane stress) "
            "or 1/2 (plane strain), which is its share in the elastic limit, against $x' - 1$ of the line. Relative "
            f"to g, they differ by {number(block['difference_plane_stress'])} and "
            f"{number(block['difference_plane_strain'])} at g = 0.02; from g = 0.02 to 0.01 with the powers "
            f"{number(orders['plane-stress'])} and {number(orders['plane-strain'])} of g.",
            {"printed": block},
        ),
    ]
    return Chapter(
        INTRODUCTION,
        statements,
        tables=[_table(rows, mesh)],
        pictures=[
            Picture(
                "viscous-sheet-waves",
                f"Potential and shortening of the fibre at the centre of the sheet over time ({mesh}).",
                "Curves of the potential and of the shortening over time for three relaxation times: the larger "
                "λ, the later and the smaller the shortening.",
                lambda: _waves(found),
            )
        ],
        differences=[_longer(rows), _dashpot(found)],
        numbers={
            "sheets": {str(share): row for share, row in rows.items()},
            "free block": block,
            "free block, γ to −0.3": {
                k: found[f"{k} 0.3"].numbers["difference"] for k in ("plane-stress", "plane-strain")
            },
            "line's dashpot, least power": found["plane-stress 0.3"].numbers["line_power"],
            "random motions": motions,
        },
    )


INTRODUCTION = """
The paper announces a viscoelastic substrate for two things that its model leaves out: contraction comes later than the
potential, and lasts longer. For a sheet, and in the form that a solid takes, we add the Kelvin–Voigt stress

$$\\mathbf{P}_v = \\mathbf{F}\\mathbf{S}, \\quad \\mathbf{S} = J_o \\mathbf{F}_o^{-1} \\left( 2\\lambda\\mu\\,
\\mathbf{F}_o^{-T}\\dot{\\mathbf{E}}\\mathbf{F}_o^{-1} \\right) \\mathbf{F}_o^{-T}, \\quad
\\mathbf{E} = \\frac{1}{2}(\\mathbf{F}^T\\mathbf{F} - \\mathbf{1})$$

to the stress (3.3): the rate of the strain is measured from the intermediate configuration, as (4.14) asks. It does not
depend on the frame because $\\mathbf{E}$ does not, and its power per reference volume,
$2\\lambda\\mu J_o |\\mathbf{F}_o^{-T}\\dot{\\mathbf{E}}\\mathbf{F}_o^{-1}|^2$, is never negative.
"""


def _reading(share: float) -> str:
    return "λ = τ" if share == 1 else f"λ = {share:g} τ"


def _row(found: Mapping[str, Found], name: str) -> dict[str, Any]:
    """The numbers of one sheet, and what the claims are about."""
    numbers, elastic = found[name].numbers, found["sheet 0.0"].numbers
    v, s = numbers["potential"], numbers["shortening"]
    return {
        "celerity": numbers["metrics"]["celerity"],
        "potential_duration": v["duration"],
        "shortening_duration": s["duration"],
        "shortening_peak": s["peak"],
        "rise_delay": numbers["rise_delay"],
        "peak_delay": numbers["peak_delay"],
        "rise_delay_over_duration": numbers["rise_delay"] / v["duration"],
        "length_ratio": None if s["duration"] is None else s["duration"] / v["duration"],
        "peak_over_elastic": s["peak"] / elastic["shortening"]["peak"],
    }


def _order(found: Mapping[str, Found], kinematics: str) -> float:
    coarse, fine = (found[f"{kinematics} {size}"].numbers["difference"] for size in SIZES[1:])
    return float(np.log2(coarse / fine))


def _table(rows: Mapping[Any, Mapping[str, Any]], mesh: str) -> Table:
    columns = (
        "celerity",
        "potential_duration",
        "shortening_duration",
        "length_ratio",
        "rise_delay",
        "peak_delay",
        "shortening_peak",
    )
    return Table(
        f"Waves at the centre of the sheet, plane stress, β = 0.3 ({mesh}). Durations are the time above half of the "
        "wave's own peak; delays are of the shortening behind the potential, of half of the peak and of the peak.",
        (
            "$\\lambda/\\tau$",
            "celerity",
            "duration of v",
            "of the shortening",
            "ratio",
            "delay, rise",
            "delay, peak",
            "largest shortening",
        ),
        [
            ("5, no stretch below rest" if share == "rectified" else f"{share:g}", *(row[c] for c in columns))
            for share, row in rows.items()
        ],
    )


def _waves(found: Mapping[str, Found]) -> Figure:
    figure = new_figure(6.4, 5.2)
    top, bottom = figure.subplots(2, 1, sharex=True)
    elastic = found["sheet 0.0"].numbers["shortening"]["peak"]
    for share, colour in zip(SHOWN, COLOURS, strict=False):
        arrays = found[f"sheet {share}"].arrays
        label = "elastic" if share == 0 else f"$\\lambda$ = {share:g} $\\tau$"
        top.plot(arrays["times"], arrays["potential"], color=colour, label=label)
        bottom.plot(arrays["times"], arrays["shortening"] / elastic, color=colour)
    top.set(ylabel="potential $v$")
    bottom.set(xlabel="$t$", ylabel="shortening\n(elastic peak = 1)", xlim=(1.0, 3.0))
    for panel in (top, bottom):
        panel.axhline(0, color=GREY, linewidth=0.5, zorder=1)
    top.legend(loc="upper right")
    return figure


def _longer(rows: Mapping[Any, Mapping[str, Any]]) -> Difference:
    return Difference(
        "Section 8: viscosity delays the contraction, but hardly lengthens it",
        "The concluding remarks expect both the delay and the longer mechanical wave from viscoelasticity. With a "
        "Kelvin–Voigt sheet we find the delay, "
        f"{number(rows[1.0]['rise_delay_over_duration'])} of the pulse's duration at λ = τ, while the mechanical wave is "
        f"{number(rows[0.4]['length_ratio'])}, {number(rows[1.0]['length_ratio'])} and "
        f"{number(rows[5.0]['length_ratio'])} times as long as the potential's at λ = 0.4 τ, τ and 5 τ, with "
        f"{number(100 * rows[0.4]['peak_over_elastic'])}, {number(100 * rows[1.0]['peak_over_elastic'])} and "
        f"{number(100 * rows[5.0]['peak_over_elastic'])} % of the elastic shortening. The undershoot of v and the "
        "neighbouring tissue, which is at rest again, both pull the fibre back. An activation with dynamics of its "
        "own, as the paper also suggests, may be what lengthens it.",
        "myostrain reproduce viscous-sheet",
    )


def _dashpot(found: Mapping[str, Found]) -> Difference:
    least = found["plane-stress 0.3"].numbers["line_power"]
    return Difference(
        "(4.14): the dashpot of the line can give power back",
        "The viscous stress of (4.14) is proportional to d/dt[(x′ − 1)/(1 + γ)], which changes with γ even where x′ "
        "stands still, and so its product with the rate of x′ need not be positive. On a free line under "
        f"γ(t) = −0.3 sin² πt, λ = {BLOCK}, it falls to {number(least)} of its largest value. For sheets we therefore "
        "take the rate at fixed $\\mathbf{F}_o$, whose power is a square; the two agree to first order in the strain, "
        f"and differ by {number(found['plane-stress 0.3'].numbers['difference'])} of γ (plane stress) at γ = −0.3.",
        "myostrain reproduce viscous-sheet",
    )
