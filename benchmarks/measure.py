"""One measurement in a process of its own, so that memory and start-up are its own; prints a line of JSON.

python benchmarks/measure.py ours [KEY=VALUE ...]        # a run of sheet-2d with these keys set
python benchmarks/measure.py line [KEY=VALUE ...]        # a run of pulse-1d
python benchmarks/measure.py textbook STEPS DT SPACING   # so many steps of the textbook solution
"""

from __future__ import annotations

import json
import resource
import sys
import time

import numpy as np

BEGIN = time.perf_counter()


def ours(case_name: str, overrides: list[str]) -> dict:
    """Run a case without output; seconds, activation times, counts, memory, bytes that a step must move."""
    import myostrain as ms
    from myostrain import cases

    case = ms.Case.from_file(cases.path(case_name), overrides)
    simulation = case.simulation()
    first_step = []

    class FirstStep:
        def update(self, step: int, time_: float) -> None:
            if step == 1:
                first_step.append(time.perf_counter() - BEGIN)

    results = simulation.run(FirstStep())
    model = simulation.model
    seconds = results["seconds"]
    return {
        "activation": {name: probe["activation_time"] for name, probe in results["probes"].items()},
        "celerity": results["metrics"]["celerity"],
        "seconds": seconds,
        "stepping": seconds["total"] - seconds["setup"],
        "to_first_step": first_step[0],
        "steps": results["steps"],
        "solver": results["solver"],
        "unknowns": results["unknowns"],
        "cells": results["cells"],
        "bytes": least_bytes(model, results),
    }


def least_bytes(model, results: dict) -> float:
    """Bytes that the run must move at least: matrices, factor and vectors, each once where it is used.

    A conjugate-gradient iteration reads the matrix (8 bytes a value, 4 a column) and moves about ten vectors;
    a correction of the mechanics reads the factor twice; assemblies read coordinates and dofs of each cell.
    """
    potential, mechanics = results["solver"]["potential"], results["solver"]["mechanics"]
    nodes = results["unknowns"]["potential"]
    ksp = model.potential.solver.ksp
    nonzeros = ksp.getOperators()[0].getInfo()["nz_used"]
    iteration = 12 * nonzeros + 80 * nodes
    pointwise = 30 * 8 * nodes
    factor = model.mechanics.solver.ksp.getPC().getFactorMatrix().getInfo()["nz_used"]
    cell = 3 * (2 * 8 + 3 * 4 + 3 * 8)
    assembly = cell * results["cells"]
    return (
        potential["linear"] * iteration
        + results["steps"] * pointwise
        + mechanics["linear"] * (2 * 12 * factor)
        + (mechanics["assemblies"] + potential["assemblies"]) * assembly
    )


def textbook(steps: int, dt: float, spacing: float) -> dict:
    """Step the textbook solution of sheet-2d; seconds a step (median), arrival at the probes."""
    import myostrain as ms
    from myostrain import cases
    from myostrain.output.probes import ActivationTimes, Probes

    from textbook import Textbook

    case = ms.Case.from_file(cases.path("sheet-2d"), [f"geometry.spacing={spacing}"])
    mesh = ms.build(case.geometry, case.fibres).mesh
    (a, b), bump = case.initial.center, case.initial
    solution = Textbook(
        mesh,
        fibre=case.fibres.direction,
        dt=dt,
        initial=lambda x: np.where(np.hypot(x[0] - a, x[1] - b) <= bump.radius, bump.potential, 0.0),
    )
    seen = ActivationTimes(solution.v, Probes(solution.v.function_space, case.probes))
    spent = []
    for number in range(steps):
        begin = time.perf_counter()
        solution.step()
        spent.append(time.perf_counter() - begin)
        seen.observe(number * dt, (number + 1) * dt)
    return {
        "activation": seen.at_probes(),
        "step": float(np.median(spent)),
        "seconds": solution.seconds,
        "steps": steps,
        "cells": int(mesh.topology.index_map(2).size_global),
    }


def bandwidth() -> float:
    """Memory bandwidth in bytes a second: the best of a few copies of 256 MB."""
    source = np.ones(32_000_000)
    target = np.empty_like(source)
    best = np.inf
    for _ in range(5):
        begin = time.perf_counter()
        np.copyto(target, source)
        best = min(best, time.perf_counter() - begin)
    return 2 * source.nbytes / best


def main() -> None:
    """Measure what the arguments say."""
    what, *rest = sys.argv[1:]
    if what == "ours":
        found = ours("sheet-2d", rest)
    elif what == "line":
        found = ours("pulse-1d", rest)
    elif what == "bandwidth":
        found = {"bytes_per_second": bandwidth()}
    else:
        found = textbook(int(rest[0]), float(rest[1]), float(rest[2]))
    found["peak_memory"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    print(json.dumps(found))


if __name__ == "__main__":
    main()
