"""docs/benchmarks.md and its plot, from what `work_precision.py` and `membranes.py` measured.

What is measured stands between two comments, and is all that is written again: text around it is kept.
"""

from __future__ import annotations

import os
import platform
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent.parent / "docs"
PAGE = DOCS / "benchmarks.md"
PLOT = DOCS / "images" / "work_precision.png"

#: Bytes that one number takes where the page speaks of MB.
MEGA = 1e6


def error(found: dict, reference: dict) -> float:
    """Largest relative error of the activation times at the probes that both reach, in percent."""
    pairs = [(found["activation"][name], true) for name, true in reference["activation"].items()]
    return max(abs(a / b - 1) for a, b in pairs if a is not None and b is not None) * 100


def signed(found: dict, reference: dict, probe: str = "near") -> float:
    """Relative error of the activation time at one probe, in percent."""
    return (found["activation"][probe] / reference["activation"][probe] - 1) * 100


def variants(found: dict, kind: str) -> list[tuple[list[float], dict]]:
    """Measurements whose names begin with a word, with the numbers that follow it."""
    names = [name for name in found if name.split()[0] == kind]
    return [([float(part) for part in name.split()[1:]], found[name]) for name in names]


def table(header: str, rows: list[str]) -> str:
    """A Markdown table."""
    return "\n".join([header, "|" + "---|" * (header.count("|") - 1), *rows])


def put(name: str, text: str, page: Path = PAGE) -> None:
    """Write a part of the page: in place of what the last measurement left, else at the end."""
    first, last = f"<!-- {name}: written by make bench -->", f"<!-- end of {name} -->"
    old = page.read_text(encoding="utf-8") if page.exists() else "# Benchmarks\n"
    before, found, rest = old.partition(first)
    _, closed, after = rest.partition(last)
    if bool(found) != bool(closed):
        raise SystemExit(f"{page}: of the comments around {name} one is missing")
    before = before if found else before.rstrip("\n") + "\n\n"
    page.write_text(f"{before}{first}\n{text.strip()}\n{last}{after or chr(10)}", encoding="utf-8")
    print(f"wrote {name} in {page}")


def write(found: dict) -> None:
    """Write what concerns the sheet and draw the plot."""
    book = found["textbook"]
    book_seconds = book["step"] * found["end"] / 1e-3
    in_time, in_space = found["reference in time"], found["reference in space"]
    first = found["first order"]
    first_seconds = first["stepping"] / first["steps"] * found["end"] / 1e-3
    sections = [
        intro(found, book, book_seconds),
        time_section(found, book_seconds, in_time, first_seconds),
        space_section(found, book_seconds, in_space),
        scaling_section(found),
        rest(found, book),
    ]
    put("sheet", "\n".join(sections))
    draw(found, book_seconds, first_seconds)


def intro(found: dict, book: dict, book_seconds: float) -> str:
    low, high = (1e3 * value for value in book["spread"])
    return f"""Written by `make bench`: {processor()}, {os.cpu_count()} cores that others use too, `OMP_NUM_THREADS=1`, one process
unless said. Medians of {found["repeat"]} runs, each in a process of its own, the variants in turn, so that the ratios
are fair although the seconds drift. "Seconds" are those of stepping to t = {found["end"]:g}, without start-up and output.

The opponent is `benchmarks/textbook.py`: plain DOLFINx as a careful user would write it, Newton with a fresh MUMPS
factorization in every iteration, mechanics in every step, first order in time, Δt = 1e-3. On the mesh of
`sheet-2d` ({book["nodes"]} nodes, {book["cells"]} triangles) it takes **{1e3 * book["step"]:.0f} ms a step** ({low:.0f} to {high:.0f}), so
{book_seconds:.0f} s to t = {found["end"]:g} (steps times the median of its first {found["textbook_steps"]}; its step costs the same all along).

![work against precision](images/work_precision.png)
"""


def time_section(found: dict, book_seconds: float, in_time: dict, first_seconds: float) -> str:
    bandwidth = found["bandwidth"]
    rows = []
    for (step, every), run in variants(found, "time"):
        potential, mechanics, seconds = run["solver"]["potential"], run["solver"]["mechanics"], run["seconds"]
        bound = run["bytes"] / bandwidth
        rows.append(
            f"| {step:g} | {every:.0f} | {run['stepping']:.1f} | **{book_seconds / run['stepping']:.0f}×** | "
            f"{error(run, in_time):.3f} % | {seconds['potential']:.1f} / {seconds['mechanics']:.1f} | "
            f"{potential['linear'] / run['steps']:.1f} | {mechanics['linear'] / mechanics['solves']:.1f} | "
            f"{mechanics['factorizations']} | {run['stepping'] / bound:.1f} |"
        )
    header = (
        "| Δt | mechanics every | seconds | textbook / this | error | seconds: potential / mechanics | "
        "CG iterations a step | corrections a solve | factorizations | times the bandwidth bound |"
    )
    slope = signed(found["textbook, coarse"], in_time) - signed(
        found["textbook, coarse, half the step"], in_time
    )
    needed = 2 * slope / 0.5
    first = found["first order, arrival"]
    return f"""## Error in time, on the same mesh

The second-order scheme; `sheet-2d` ships Δt = 3e-3 with mechanics every 4 steps. The error is the largest relative one
of the activation times at the six probes, against Δt = 1e-3 with mechanics in every step.

{table(header, rows)}

"Times the bandwidth bound": the seconds over the time in which the bytes that the run must move at least (matrices,
factors, vectors, geometry, each once where it is used; `benchmarks/measure.py`) pass at the measured
{bandwidth / 1e9:.1f} GB/s. Seconds of the phases include the start, with the first factorization.

The textbook's own error in time at Δt = 1e-3 is {2 * slope:.1f} % (twice the change of arrival that half the step makes, on
3,169 nodes): to come to 0.5 % it would take steps {needed:.1f} times smaller, and the ratios would be {needed:.1f} times larger.

The project's first-order scheme, the paper's fixed-point iteration (`time.scheme = "implicit"`, Δt = 1e-3), takes
{first_seconds:.0f} s ({book_seconds / first_seconds:.1f}× the textbook's speed; measured over {found["first order"]["steps"]} steps) with {first["solver"]["coupling"]["iterations"] / first["steps"]:.1f} iterations a step; its
error at the first probe is {abs(signed(first, in_time)):.2f} %.

**Steps of varying size** were judged and left out. A perfect controller with the same largest local error (Δt³ times the
third derivative of v, its largest value over the body) would need {100 * found["coasting"]["share"]:.0f} % of the steps: a front is in the body
nearly all the time. That is the most there is to gain, before rejected steps, and before the factors and
preconditioners that are kept now would have to be made again at each change of the step.
"""


def space_section(found: dict, book_seconds: float, in_space: dict) -> str:
    rows = [
        f"| {h:g} | {run['nodes']} | {step:g} | {every:.0f} | {run['stepping']:.1f} | "
        f"{book_seconds / run['stepping']:.0f}× | {error(run, in_space):.2f} % |"
        for (h, step, every), run in variants(found, "space")
    ]
    header = (
        "| spacing | nodes | Δt | mechanics every | seconds | textbook on 12,097 nodes / this | total error |"
    )
    finer = found["textbook, finer"]
    return f"""## Total error, against the converged solution

Reference: {in_space["nodes"]} nodes, Δt = 2e-3, mechanics every 2 steps. The averaged mass matrix and the mean sampling of the
bump make coarse meshes good; a coarser mesh is where the next factor comes from.

{table(header, rows)}

The textbook (consistent mass, nodal bump) is {signed(found["textbook, arrival"], in_space):+.1f} % off at the first probe on 12,097 nodes, which is its error in time
less that in space; that they cancel there is luck. On {finer["nodes"]} nodes it takes {finer["step"]:.1f} s a step.
"""


def scaling_section(found: dict) -> str:
    rows = []
    for (h, processes), run in variants(found, "scaling"):
        if processes > 1:
            continue
        two = found[f"scaling {h:g} 2"]
        cost = 1e6 * run["stepping"] / run["steps"] / run["nodes"]
        mechanics = run["solver"]["mechanics"]
        rows.append(
            f"| {run['nodes']} | {cost:.2f} | {run['solver']['potential']['linear'] / run['steps']:.1f} | "
            f"{two['solver']['potential']['linear'] / run['steps']:.1f} | "
            f"{mechanics['linear'] / mechanics['solves']:.1f} | {run['peak_memory'] / run['nodes'] / 1e3:.1f} | "
            f"{run['stepping'] / two['stepping']:.2f}× |"
        )
    header = (
        "| nodes | µs a node and step | CG iterations a step | on two processes | corrections a solve | "
        "peak memory (kB a node) | two processes / one |"
    )
    return f"""## Size and processes

The first 60 steps at Δt = 3e-3, mechanics every 4 steps, on refined meshes. The potential's preconditioner is a kept
incomplete Cholesky factorization with one level of fill, three beyond 100,000 nodes (process by process); mechanics keeps one complete
factorization. With 382,000 unknowns a correction by it takes a fifth of one by kept multigrid, so that no
size was found at which the default should change; the incomplete factors beat Jacobi from 50,000 nodes on, and
multigrid at every size tried.

{table(header, rows)}
"""


def rest(found: dict, book: dict) -> str:
    line, reference = found["line"], found["reference of the line"]
    off = abs(line["celerity"] / reference["celerity"] - 1) * 100
    shipped = found["time 0.003 4"]
    return f"""## The line

`pulse-1d` to t = 5 at Δt = 8e-3: {line["stepping"]:.2f} s of stepping, celerity {off:.2f} % from that at Δt = 5e-4.

## Memory and start-up

Peak memory {shipped["peak_memory"] / MEGA:.0f} MB, the textbook's {book["peak_memory"] / MEGA:.0f} MB. From the start of Python to the end of the first step of
`sheet-2d`, kernels cached: {shipped["to_first_step"]:.1f} s.
"""


def membranes(found: dict) -> str:
    """The section on membranes."""
    rows = []
    for name, (states, integrator, least, middle) in found["compiled"].items():
        model, order = name.split()
        two, plain = found["two"][name][3], found["numpy"][name][3]
        rows.append(
            f"| {model} | {states} | {integrator} | {order} | **{least:.1f}** | {middle:.1f} | "
            f"{middle / two:.2f} | {plain:.0f} | {plain / middle:.0f}× |"
        )
    header = (
        "| model | states | integrator | order | ns, least | ns, median | one / two processes | "
        "NumPy, ns | NumPy / this |"
    )
    text = f"""## Membranes

Processor nanoseconds a node and step on one core: all states advanced, the current and its slope in v, for 16,384 nodes at
potentials from all of the range, Δt = 0.01 (`benchmarks/membranes.py`). Least and median of {found["repeat"]} repeats in one run, on a
machine with a load of {found["load"][0]:.0f} to {found["load"][1]:.0f} on {os.cpu_count()} cores: the least is nearest to what an idle core takes. "One / two processes": the median
on one over that of the slower of two that run at once with as many nodes each; 1 is perfect, and other programs on the
cores lower it. NumPy is what runs without a compiler (median of 3).

{table(header, rows)}
"""
    if found["others"]:
        least, middle = found["compiled"]["TenTusscherPanfilov2006 1"][2:]
        rows = [f"| this, C | {least:.0f} | {middle:.0f} | 1 |"]
        rows += [f"| {n} | {a:.0f} | {b:.0f} | {b / middle:.1f} |" for n, (a, b) in found["others"].items()]
        text += f"""
What gotranx makes of the same model (ten Tusscher and Panfilov, epicardium) in the same run: generalised Rush–Larsen steps of
first order, as generated; they include the potential's step, and no slope. On one core:

{table("| TenTusscherPanfilov2006, order 1 | ns, least | ns, median | times this |", rows)}
"""
    return text


def draw(found: dict, book_seconds: float, first_seconds: float) -> None:
    """Plot error against seconds."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    in_time, in_space = found["reference in time"], found["reference in space"]
    figure = Figure(figsize=(6.8, 4.4), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()

    def curve(kind: str, reference: dict, style: str, label: str) -> None:
        points = sorted((run["stepping"], error(run, reference)) for _, run in variants(found, kind))
        axes.loglog(*zip(*points, strict=True), style, label=label)

    def point(seconds: float, value: float, marker: str, label: Any) -> None:
        axes.loglog([seconds], [value], marker, markersize=8, linestyle="none", label=label)

    curve("time", in_time, "o-", "second order: error in time, 12,097 nodes")
    curve("space", in_space, "s--", "second order: total error, 3,169 to 24,031 nodes")
    first = abs(signed(found["first order, arrival"], in_time))
    point(first_seconds, first, "^", "the paper's scheme, Δt = 1e-3: error in time")
    slope = signed(found["textbook, coarse"], in_time) - signed(
        found["textbook, coarse, half the step"], in_time
    )
    point(book_seconds, 2 * slope, "X", "textbook, Δt = 1e-3: error in time")
    axes.set_xlabel("seconds of stepping to t = 3")
    axes.set_ylabel("error of activation times (%)")
    axes.grid(visible=True, which="major", alpha=0.4)
    axes.grid(visible=True, which="minor", alpha=0.15)
    axes.legend(fontsize=8)
    PLOT.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(PLOT)


def processor() -> str:
    """Name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next(
        (line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.machine()
    )
