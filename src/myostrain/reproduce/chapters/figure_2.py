"""Figure 2: a weak bump, on the coupled line and on one that is held at first."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from myostrain.output.figures.style import BLUE, GREEN, GREY, SEQUENTIAL, VERMILION, new_figure
from myostrain.output.metrics import leading_pulse
from myostrain.reproduce.content import Chapter, Difference, Picture, Statement, Table
from myostrain.reproduce.jobs import Found, Job
from myostrain.reproduce.measurements.cases import resolved
from myostrain.reproduce.measurements.lines import pulse_job
from myostrain.reproduce.page import number
from myostrain.reproduce.verdict import claims

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

TITLE = "Figure 2: a weak bump, and what holding the line does"

END = 0.6
#: Times at which the fields are kept, and those of them that are drawn.
FRAMES = [round(0.01 * k, 2) for k in range(1, 60)]
DRAWN = (0.01, 0.05, 0.1, 0.2, 0.3, 0.4)
HELD = "mechanics.imposed_stretch={value=1.0, until=0.01}"
KINDS = {"coupled": (), "held": (HELD,)}
#: Cells a unit of length: of the sequence of meshes with the bump by nodes, and of the fine mesh.
QUICK_MESHES, MESHES = (2, 4), (1, 2, 4, 8)
#: Bumps on the fine mesh, by names for the numbers: half-width and potential.
BUMPS = {"printed": (1.0, 0.6), "sampled": (1.5, 0.6)}
WIDE = (2.0, 0.4)


def _fine(quick: bool) -> tuple[int, float]:
    """Cells a unit of length, and time step, of the fine mesh."""
    return (4, 1e-3) if quick else (8, 2.5e-4)


def jobs(quick: bool) -> dict[str, Job]:
    """The computations."""
    cells, step = _fine(quick)
    wanted: dict[str, Job] = {}

    def add(name: str, kind: str, *settings: str, cost: float) -> None:
        wanted[f"{name}, {kind}"] = pulse_job(
            "startup-1d", (*settings, *KINDS[kind], f"time.end={END}"), frames=FRAMES, cost=cost
        )

    seconds = 2e-3 * END / step
    for kind, held in KINDS.items():
        add("paper", kind, cost=4.0)
        add("one", kind, "initial.radius=0.5", cost=4.0)
        for n in QUICK_MESHES if quick else MESHES:
            add(f"1/{n}", kind, "time.scheme=second-order", f"time.step={step}", f"geometry.spacing={1 / n}",
                cost=seconds)  # fmt: skip
        for name, (radius, potential) in BUMPS.items() if quick else {**BUMPS, "wide": WIDE}.items():
            add(name, kind, *_bump(cells, radius), f"initial.potential={potential}", f"time.step={step}",
                cost=seconds)  # fmt: skip
        if not quick:
            for name, radius in (("sampled", 1.5), ("wide", 2.0)):
                settings = (*_bump(cells, radius), "time.step=5e-4", *held)
                bisection = {"shape": "step", "low": 0.3, "high": 0.8, "tolerance": 1e-3}
                wanted[f"threshold {name}, {kind}"] = Job(
                    "startup.threshold", {"case": resolved("startup-1d", settings), **bisection}, cost=14.0
                )
    return wanted


def _bump(cells: int, radius: float) -> tuple[str, ...]:
    """A fine mesh that has the bump's width right: the node at its edge takes a share."""
    return (
        "time.scheme=second-order",
        f"geometry.spacing={1 / cells}",
        f"initial.radius={radius}",
        'initial.sampling="mean"',
    )


def chapter(found: Mapping[str, Found], quick: bool) -> Chapter:
    """The chapter."""
    numbers = _numbers(found, quick)
    return Chapter(
        introduction=_introduction(quick),
        statements=_statements(numbers, quick),
        tables=[_table(numbers, quick)],
        pictures=_pictures(found, quick),
        differences=[_difference(numbers, quick)],
        numbers=numbers,
        remarks=_remarks(numbers, quick),
    )


def _numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    names = ["paper", "one", *(f"1/{n}" for n in (QUICK_MESHES if quick else MESHES)), *BUMPS]
    names += [] if quick else ["wide"]
    numbers: dict[str, Any] = {
        name: {kind: _outcome(found[f"{name}, {kind}"]) for kind in KINDS} for name in names
    }
    if not quick:
        numbers["thresholds"] = {
            name: {kind: found[f"threshold {name}, {kind}"].numbers["threshold"] for kind in KINDS}
            for name in ("sampled", "wide")
        }
    return numbers


def _outcome(found: Found) -> dict[str, float | None]:
    """Largest v at t = 0.3 and at the end, and the speed in X of the front in between the last two tenths."""
    times, X = found.arrays["times"], found.arrays["X"]
    peaks = found.arrays["potential"].max(axis=1)

    def at(time: float) -> int:
        return int(np.argmin(np.abs(times - time)))

    fronts = [leading_pulse(X, x, v) for x, v in
              ((found.arrays["x"][i], found.arrays["potential"][i]) for i in (at(END - 0.1), at(END)))]  # fmt: skip
    first, last = fronts
    return {
        "peak_03": float(peaks[at(0.3)]),
        "peak": float(peaks[at(END)]),
        "front": None if last is None else last.front,
        "front_speed": None if first is None or last is None else (last.front - first.front) / 0.1,
    }


def _where(quick: bool) -> str:
    cells, step = _fine(quick)
    return f"Δx = 1/{cells}, Δt = {number(step)}, second order"


def _introduction(quick: bool) -> str:
    return rf"""
The line of figure 1 starts from $v = 0.6$ for $-1 < x < 1$ and rest elsewhere. The coupled line contracts at once
to $x' = 1 - \beta v$; the held one is kept at $x' = 1$ for $0 < t < 0.01$ and then let go, which keeps $Jv$ and $Jw$
of each particle. We compute half the line, $0 \le X \le 60$ with a plane of symmetry at X = 0, to t = {END}. The
paper's own setting is Δx = 1, Δt = {number(1e-3)} and a first-order implicit scheme.

On the mesh of the paper the bump is three nodes, X = −1, 0 and 1, each of which stands for a cell of length 1: an
amount $\int v\,dX = 3 \times 0.6$, that of a bump of half-width 1.5 rather than 1. With {"n"} cells a unit it is
$1 + 1/(2n)$. (Without the two end nodes, as "<" could be read, one node is left.) So "converged" has two readings: the bump as printed, $-1 \le X \le 1$, or as sampled,
$-1.5 \le X \le 1.5$, both on a fine mesh ({_where(quick)}) on which the node at the bump's edge takes its share.
"""


def _statements(numbers: Any, quick: bool) -> list[Statement]:
    claim, paper = claims("figure-2"), numbers["paper"]
    printed, sampled = numbers["printed"], numbers["sampled"]

    def held(of: Any) -> dict[str, float | None]:
        return {name: of["held"][name] for name in ("peak", "front_speed")}

    def fired(of: Any) -> str:
        return (
            f"{of['peak']:.3f}, its front at X = {of['front']:.1f} and travelling at {of['front_speed']:.1f}"
            if of["front_speed"] is not None
            else f"{number(of['peak'])}"
        )

    texts = ["the printed equations on the paper's mesh", "half-width 1 as printed, fine mesh",
             "half-width 1.5 as three nodes with Δx = 1 have it, fine mesh"]  # fmt: skip
    both = {texts[1]: printed, texts[2]: sampled}
    return [
        Statement(
            claim["damped"],
            f"Δx = 1, Δt = {number(1e-3)}, implicit: the largest v is {number(paper['coupled']['peak_03'])} when "
            f"t = 0.3 and {number(paper['coupled']['peak'])} when t = {END}.",
            {texts[0]: {"peak": paper["coupled"]["peak"]}},
        ),
        Statement(
            claim["damped-converged"],
            f"{_where(quick)}: the largest v when t = {END} is {number(printed['coupled']['peak'])} with half-width 1 "
            f"and {number(sampled['coupled']['peak'])} with half-width 1.5.",
            {text: {"peak": of["coupled"]["peak"]} for text, of in both.items()},
        ),
        Statement(
            claim["fires"],
            f"Δx = 1, Δt = {number(1e-3)}, implicit: the largest v when t = {END} is {fired(paper['held'])}.",
            {texts[0]: held(paper)},
        ),
        Statement(
            claim["fires-converged"],
            f"{_where(quick)}: from half-width 1 the held line decays, too: the largest v when t = {END} is "
            f"{fired(printed['held'])}. From half-width 1.5 it is {fired(sampled['held'])}, while the coupled line has "
            f"{number(sampled['coupled']['peak'])}.",
            {text: {**held(of), "coupled_peak": of["coupled"]["peak"]} for text, of in both.items()},
        ),
    ]


def _table(numbers: Any, quick: bool) -> Table:
    cells, step = _fine(quick)

    def row(title: str, width: float, of: Any) -> list[Any]:
        peaks = [of[kind][name] for kind in KINDS for name in ("peak_03", "peak")]
        return [title, width, *peaks, of["held"]["front_speed"]]

    rows = [row(f"Δx = 1, implicit, Δt = {number(1e-3)} (the paper's)", 1.5, numbers["paper"])]
    rows.append(row("the same, node X = 0 alone", 0.5, numbers["one"]))
    rows += [
        row("Δx = 1" + (f"/{n}" if n > 1 else ""), 1 + 0.5 / n, numbers[f"1/{n}"])
        for n in (QUICK_MESHES if quick else MESHES)
    ]
    for name, (radius, potential) in ({**BUMPS} if quick else {**BUMPS, "wide": WIDE}).items():
        rows.append(row(f"Δx = 1/{cells}, exact, v = {potential}", radius, numbers[name]))
    return Table(
        f"Largest v, coupled and held, and the speed in X of the held line's front just before t = {END}; half-width "
        f"of the bump as it is on the mesh. Second-order scheme, Δt = {number(step)}, but for the first two rows. "
        "Nodes with |X| at most 1 take v = 0.6; where it says exact, the node at the edge of the bump takes its share.",
        [
            "mesh and bump",
            "half-width",
            "coupled, t = 0.3",
            f"t = {END}",
            "held, t = 0.3",
            f"t = {END}",
            "speed",
        ],
        rows,
    )


def _remarks(numbers: Any, quick: bool) -> str:
    if quick:
        return ""
    found = numbers["thresholds"]
    cells, _ = _fine(quick)
    return (
        "**The window.** The least potential that fires (v above 1/2 when t = 0.3), by bisection to 10⁻³ with "
        f"Δx = 1/{cells}, Δt = {number(5e-4)}: for half-width 1.5 "
        f"{found['sampled']['coupled']:.3f} coupled and {found['sampled']['held']:.3f} held, for half-width 2 "
        f"{found['wide']['coupled']:.3f} coupled and {found['wide']['held']:.3f} held. In between, holding the line "
        "decides. The map over amplitude and width is in the chapter on the start-up of a pulse (section 5)."
    )


def _difference(numbers: Any, quick: bool) -> Difference:
    cells, step = _fine(quick)
    paper, printed, sampled = numbers["paper"], numbers["printed"], numbers["sampled"]
    return Difference(
        "Figure 2 and the mesh (section 6)",
        f"""
With Δx = 1 the held bump fires (largest v {paper["held"]["peak"]:.3f} when t = {END}) and the coupled one decays, as
the paper shows. On a fine mesh the bump as printed, $v = 0.6$ for $-1 < x < 1$, decays in both cases (held:
{number(printed["held"]["peak"])}). The reason is that with Δx = 1 the bump is three nodes of length 1, hence of
half-width 1.5. A bump of half-width 1.5 on a fine mesh ({_where(quick)}) does what the figure shows: coupled
{number(sampled["coupled"]["peak"])}, held {sampled["held"]["peak"]:.3f}. So the effect is one of the equations and
not of the mesh; the initial datum that goes with it is $v = 0.6$ for $-1.5 < x < 1.5$. The command runs the printed
bump, held, on a fine mesh; with `--set initial.radius=1.5` it fires.
""",
        f"myostrain run startup-1d --set geometry.spacing={1 / cells} --set time.step={step} "
        "--set time.scheme=second-order --set initial.sampling=mean "
        "--set 'mechanics.imposed_stretch={value=1.0, until=0.01}' --out runs/figure-2-fine",
    )


def _pictures(found: Mapping[str, Found], quick: bool) -> list[Picture]:
    shown = ", ".join(f"{time:g}" for time in DRAWN)
    return [
        Picture(
            "figure-2",
            f"The paper's figure 2: potential at t = {shown}, on the coupled line and on the one held until t = 0.01. "
            f"Δx = 1, Δt = {number(1e-3)}, implicit.",
            "Coupled, the bump decays; held at first, it grows into a front that travels.",
            partial(_profiles, found),
        ),
        Picture(
            "figure-2-meshes",
            f"Largest potential over time, held (solid) and coupled (dashed). Δx = 1: the paper's setting; fine: "
            f"{_where(quick)}.",
            "With three nodes at Δx = 1 and with half-width 1.5 on a fine mesh, the held line fires and the coupled one "
            "decays; with half-width 1 on a fine mesh both decay.",
            partial(_peaks, found),
        ),
    ]


def _profiles(found: Mapping[str, Found]) -> Figure:
    figure = new_figure(6.0, 5.0)
    colours = mpl.colormaps[SEQUENTIAL](np.linspace(0.0, 0.88, len(DRAWN)))
    for axes, kind, title in zip(
        figure.subplots(2, 1, sharex=True),
        KINDS,
        ("(a) coupled", "(b) held at $x'$ = 1 for $t$ < 0.01"),
        strict=True,
    ):
        arrays = found[f"paper, {kind}"].arrays
        X = np.concatenate([-arrays["X"][:0:-1], arrays["X"]])
        axes.plot(X, np.where(np.abs(X) <= 1, 0.6, 0.0), ":", color=GREY, label="0")
        for time, colour in zip(DRAWN, colours, strict=True):
            v = arrays["potential"][int(np.argmin(np.abs(arrays["times"] - time)))]
            axes.plot(X, np.concatenate([v[:0:-1], v]), color=colour, label=f"{time:g}")
        axes.set(ylim=(-0.25, 1.0), xlim=(-42, 30), ylabel="potential $v$")
        axes.set_title(title, loc="right")
    figure.axes[0].legend(loc="upper left", title="$t$", ncols=2)
    figure.axes[1].set_xlabel("material coordinate $X$")
    return figure


def _peaks(found: Mapping[str, Found]) -> Figure:
    figure = new_figure(6.0, 3.8)
    axes = figure.subplots()
    shown = {
        "paper": ("Δx = 1, three nodes", "black"),
        "sampled": ("fine, half-width 1.5", VERMILION),
        "printed": ("fine, half-width 1", BLUE),
    }
    for name, (text, colour) in shown.items():
        for kind, line in (("held", "-"), ("coupled", "--")):
            arrays = found[f"{name}, {kind}"].arrays
            axes.plot(
                [0, *arrays["times"]],
                [BUMPS["printed"][1], *arrays["potential"].max(axis=1)],
                line,
                color=colour,
                label=text if kind == "held" else None,
            )
    axes.axhline(0.1, color=GREEN, linewidth=0.8, zorder=0)
    axes.annotate(r"$\alpha$", (0.3, 0.1), (0, 3), textcoords="offset points", color=GREEN)
    axes.set(xlim=(0, 0.31), ylim=(0, 1.0), xlabel="time $t$", ylabel="largest $v$")
    axes.legend(loc="center right")
    return figure
