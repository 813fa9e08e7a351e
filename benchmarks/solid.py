"""Speed and scaling of solids: the contracting slab of docs/solids-solvers.md beside a textbook solution.

    python benchmarks/solid.py [--repeat 2] [--sizes 4] [--out runs/solid.json]   # everything
    python benchmarks/solid.py ours 28 10 6 [KEY=VALUE ...]           # one run, with PETSc options
    python benchmarks/solid.py textbook 28 10 6

A slab 20 × 7 × 3 of so many boxes, neo-Hookean, J = 1, free, contracts to γ = −0.2 along x in 5 steps. Each
run is a process of its own; those that are compared alternate. Seconds a step are all seconds of solving over
5, the first factorization and the state at rest included; beside them those of the processor, which say
more where others use the machine. The tables go into docs/solids-solvers.md, all numbers into the file.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import resource
import sys
import time
from pathlib import Path
from statistics import median

import page
from apart import apart

SIZE = (20.0, 7.0, 3.0)
STEPS, GAMMA = 5, 0.2
#: 10,080 tetrahedra, 46,683 + 2,233 unknowns.
SLAB = (28, 10, 6)
#: Refinements: 48,916, 122,241, 363,036 and 1,005,000 unknowns.
REFINEMENTS = [SLAB, (39, 14, 8), (56, 20, 12), (80, 28, 17)]
#: How many of them by kept factors too; those of the third took over a quarter of an hour.
FACTORIZED = 2
BLOCK = "pc_type=fieldsplit"


def box(n):
    with contextlib.suppress(ImportError):
        import dolfinx_solver  # noqa: F401

    import numpy as np
    from dolfinx import mesh
    from mpi4py import MPI

    return mesh.create_box(MPI.COMM_WORLD, [np.zeros(3), np.array(SIZE)], n, mesh.CellType.tetrahedron)


def ours(n, options: dict) -> dict:
    """Run the slab by myostrain."""
    import myostrain as ms
    import myostrain.engine
    from myostrain.geometry import Body, Meshed, UniformFibres
    from myostrain.kinematics import Solid
    from myostrain.materials import NeoHookean

    meshed = Meshed(box(n), None, {}, None, {})
    body = Body(meshed, UniformFibres(direction=(1.0, 0.0, 0.0)).directions_on(meshed))
    solid = ms.Mechanics(body, kinematics=Solid(), material=NeoHookean(), options=options or None)
    spent, counts, begin, loaded = [], [], time.process_time(), 0.0
    for step in range(STEPS + 1):
        solid.activation.x.array[:] = -GAMMA * step / STEPS
        before = solid.seconds
        if step:
            solid.solve(step / STEPS)
            solid.accept(step / STEPS)
        else:
            solid.start()
            loaded = time.process_time()
        spent.append(solid.seconds - before)
        counts.append(solid.solver.counters.as_dict())
    return {
        "unknowns": int(solid.u.function_space.dofmap.index_map.size_global),
        "step": sum(spent) / STEPS,
        "step_cpu": (time.process_time() - begin) / STEPS,
        "loaded_cpu": (time.process_time() - loaded) / STEPS,
        "spent": spent,
        "counts": counts,
        "error": error(solid.u, 0),
    }


def textbook(n) -> dict:
    """Run the slab by the textbook solution."""
    from textbook_solid import Textbook

    solid = Textbook(box(n), SIZE)
    begin = time.process_time()
    for step in range(1, STEPS + 1):
        solid.step(-GAMMA * step / STEPS)
    return {
        "unknowns": int(solid.u.function_space.dofmap.index_map.size_global),
        "step": sum(solid.seconds) / STEPS,
        "step_cpu": (time.process_time() - begin) / STEPS,
        "spent": solid.seconds,
        "newton": solid.newton,
        "error": error(solid.u, 0),
    }


def error(u, part: int) -> float:
    """Largest error of the displacement against the closed form, less the rigid motion between them.

    F = diag(λ, λ^(-1/2), λ^(-1/2)) with λ = (1 + γ)^(2/3).
    """
    import numpy as np

    v = u.sub(part).collapse()
    x = v.function_space.tabulate_dof_coordinates()
    stretch = (1 - GAMMA) ** (2 / 3)
    wanted = x * np.array([stretch, stretch**-0.5, stretch**-0.5])
    found = x + v.x.array.reshape(-1, 3)
    a, b = found - found.mean(axis=0), wanted - wanted.mean(axis=0)
    left, _, right = np.linalg.svd(a.T @ b)
    return float(np.abs(a @ left @ right - b).max())


def measure(*arguments: str) -> dict:
    """One run in a process of its own."""
    print("  ", *arguments, flush=True)
    return apart(__file__, *arguments)


def everything(repeat: int, sizes: int) -> dict:
    """The comparison, alternating, and the first refinements by both of our solvers."""
    slab = [str(k) for k in SLAB]
    runs: dict = {"ours": [], "textbook": []}
    for _ in range(repeat):
        for name, seen in runs.items():
            seen.append(measure(name, *slab))
    for key, clock in {"step": "seconds", "step_cpu": "processor seconds"}.items():
        steps = {name: median(run[key] for run in seen) for name, seen in runs.items()}
        print(
            f"textbook {steps['textbook']:.2f} {clock} a step, ours {steps['ours']:.2f}: "
            f"{steps['textbook'] / steps['ours']:.1f} times as fast"
        )
    scaling = []
    for number, n in enumerate(REFINEMENTS[:sizes]):
        for solver in ("direct", BLOCK) if number < FACTORIZED else (BLOCK,):
            run = measure("ours", *map(str, n), solver)
            linear, newton = run["counts"][-1]["linear"], run["counts"][-1]["newton"]
            print(
                f"{run['unknowns']:7d} {solver:20s} {run['step_cpu']:8.2f} processor seconds a step, "
                f"{1e6 * run['step_cpu'] / run['unknowns']:6.1f} µs an unknown, {newton} corrections, "
                f"{linear} iterations, {run['peak_memory'] / 1e9:.1f} GB, error {run['error']:.1e}"
            )
            scaling.append({"solver": solver, **run})
    return {"comparison": runs, "scaling": scaling}


def tables(found: dict) -> str:
    """The tables of the page: ours beside the textbook, and the refinements that were measured."""

    def of(name: str, value) -> float:
        return median(value(run) for run in found["comparison"][name])

    ways = {
        "seconds a step": lambda run: run["step"],
        "of the processor": lambda run: run["step_cpu"],
        "load steps alone, of the processor": lambda run: run.get("loaded_cpu", run["step_cpu"]),
        "memory (MB)": lambda run: run["peak_memory"] / 1e6,
    }
    books, kept = ([of(name, way) for way in ways.values()] for name in ("textbook", "ours"))
    counts = {"textbook": sum(found["comparison"]["textbook"][0]["newton"])}
    counts["ours"] = found["comparison"]["ours"][0]["counts"][-1]["newton"]
    unknowns, runs = found["comparison"]["ours"][0]["unknowns"], len(found["comparison"]["ours"])
    rows = [
        f"| {name} | {' | '.join(f'{value:.3g}' for value in values)} | {counts[side]} |"
        for name, side, values in (("textbook", "textbook", books), ("kept factors", "ours", kept))
    ]
    ratios = [f"**{a / b:.1f}**" for a, b in zip(books[:3], kept[:3], strict=True)]
    rows.append(f"| ratio | {' | '.join(ratios)} | | |")
    text = page.table(f"| {unknowns:,} unknowns | {' | '.join(ways)} | corrections |", rows)
    text = f"One process, medians of {runs} runs of each side in turn, all seconds over {STEPS}:\n\n{text}"
    if found["scaling"]:
        rows = [
            f"| {run['unknowns']:,} | {'blocks' if run['solver'] == BLOCK else 'kept factors'} | "
            f"{run['step_cpu']:.2f} | {1e6 * run['step_cpu'] / run['unknowns']:.0f} | "
            f"{run['counts'][-1]['newton']} | {run['counts'][-1]['linear']} | "
            f"{run['peak_memory'] / 1e9:.2f} |"
            for run in found["scaling"]
        ]
        header = (
            "| unknowns | solver | processor seconds a step | µs an unknown | corrections | "
            "solutions with the tangent or iterations | memory (GB) |"
        )
        text += f"\n\n{page.table(header, rows)}"
    return text


def main() -> None:
    """Measure what the arguments say."""
    what, *rest = sys.argv[1:] or ["--repeat=2"]
    if what in ("ours", "textbook"):
        n = tuple(int(k) for k in rest[:3])
        if what == "textbook":
            found = textbook(n)
        else:
            if "direct" in rest:
                import myostrain.solvers.saddle_point

                myostrain.solvers.saddle_point.LARGE = 10**9
            options = dict(item.split("=", 1) for item in rest[3:] if "=" in item)
            found = ours(n, options)
        found["peak_memory"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        print(json.dumps(found))
        return
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeat", type=int, default=2, help="runs of each side of the comparison")
    parser.add_argument("--sizes", type=int, default=len(REFINEMENTS), help="how many refinements")
    parser.add_argument("--out", type=Path, default=Path("runs/solid.json"), help="where the numbers go")
    arguments = parser.parse_args()
    found = everything(arguments.repeat, arguments.sizes)
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    arguments.out.write_text(json.dumps(found, indent=1))
    page.put("slab", tables(found), page.DOCS / "solids-solvers.md")


if __name__ == "__main__":
    main()
