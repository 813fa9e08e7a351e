"""The first milliseconds of `heartbeat-3d` beside a textbook solution of the same heart.

    python benchmarks/heart.py [--spacing=9] [--layers=2] [--end=20] [--out=FILE]
    python benchmarks/heart.py ours|textbook SPACING LAYERS END      # one side

The textbook solution (`textbook_heart.py`) takes the mesh, the directions of fibres, the depth in the wall
and the filled state from myostrain, and nothing else. Both solve mechanics and circulation every 2 ms and the
potential every 0.1 ms, and write nothing; the search for the state at the preload, and the compilation of
formulas, are left out. Each side runs in a process of its own, one after the other. Others use the machine
too: the processor seconds are what counts. Volumes and pressures of both are printed beside each other.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import time
from pathlib import Path

from apart import apart


def case(spacing: float, layers: int, end: float):
    """The case on its mesh."""
    import myostrain as ms
    from myostrain import cases

    sets = [f"geometry.spacing={spacing}", f"geometry.layers={layers}", f"time.end={end}"]
    return ms.Case.from_file(cases.path("heartbeat-3d"), [*sets, f"output.every={end}"])


def ours(spacing: float, layers: int, end: float) -> dict:
    """Step the heart by myostrain."""
    from myostrain.case import building
    from myostrain.engine import MPI

    given = case(spacing, layers, end)
    model = building.model(given, MPI.COMM_SELF)
    model.start()
    history = [list(model.mechanics.cavities.values().values())[:2]]
    step = given.time.step
    model.step(step)  # formulas are compiled
    clock = time.process_time(), time.perf_counter()
    for number in range(1, round(end / step)):
        model.step((number + 1) * step)
        if (number + 1) % model.every == 0:
            history.append(list(model.mechanics.cavities.values().values())[:2])
    counters = model.mechanics.solver.counters.as_dict()
    return {
        "unknowns": int(model.mechanics.u.function_space.dofmap.index_map.size_global),
        "cpu": time.process_time() - clock[0],
        "seconds": time.perf_counter() - clock[1],
        "history": history,
        "counts": counters,
    }


def textbook(spacing: float, layers: int, end: float) -> dict:
    """Step the heart by the textbook solution."""
    import dolfinx_solver  # noqa: F401
    from myostrain import geometry
    from myostrain.case import building
    from myostrain.engine import MPI

    from textbook_heart import Heart

    given = case(spacing, layers, end)
    filled = building.model(given, MPI.COMM_SELF)
    filled.start()
    body = filled.mechanics.body
    fibres, meshed = body.fibres, body.meshed
    directions = fibres.f0, fibres.s0, fibres.n0
    heart = Heart(
        body.mesh, meshed.facet_tags, meshed.boundaries, *directions, geometry.depth(body), given.time.step
    )
    heart.fill(filled.mechanics.u)
    heart.newton.clear()
    clock = time.process_time(), time.perf_counter()
    heart.beat(end)
    return {
        "unknowns": int(heart.state.function_space.dofmap.index_map.size_global),
        "cpu": time.process_time() - clock[0],
        "seconds": time.perf_counter() - clock[1],
        "mechanics": heart.seconds,
        "history": [[V, p] for _, V, p, _ in heart.history],
        "newton": heart.newton,
    }


def measure(side: str, numbers: list[str]) -> dict:
    """One side in a process of its own."""
    found = apart(__file__, side, *numbers)
    print(f"{side}: {found['unknowns']} unknowns, {found['cpu']:.1f} processor seconds", flush=True)
    return found


def main() -> None:
    """Measure what the arguments say."""
    if sys.argv[1:2] in (["ours"], ["textbook"]):
        spacing, layers, end = sys.argv[2:]
        found = {"ours": ours, "textbook": textbook}[sys.argv[1]](float(spacing), int(layers), float(end))
        found["peak_memory"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        print(json.dumps(found))
        return
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--spacing", type=float, default=9.0)
    parser.add_argument("--layers", type=int, default=2)
    parser.add_argument("--end", type=float, default=20.0)
    parser.add_argument("--out", type=Path, default=Path("runs/heart.json"), help="where the numbers go")
    given = parser.parse_args()
    numbers = [str(given.spacing), str(given.layers), str(given.end)]
    runs = {side: measure(side, numbers) for side in ("ours", "textbook")}
    for name, index in (("volume", 0), ("pressure", 1)):
        ends = [runs[side]["history"][-1][index] for side in ("ours", "textbook")]
        print(f"{name} at {given.end:g} ms: ours {ends[0]:.6g}, textbook {ends[1]:.6g}")
    there, here = runs["textbook"], runs["ours"]
    print(
        f"{there['cpu'] / here['cpu']:.1f} times as fast; {sum(there['newton'])} factorizations in "
        f"{len(there['newton'])} solves there, {here['counts']} here"
    )
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text(json.dumps(runs, indent=1))


if __name__ == "__main__":
    main()
