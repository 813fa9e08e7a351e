"""One measurement in a process of its own, so that memory and start-up are its own; prints a line of JSON.

python benchmarks/measure.py sheet [KEY=VALUE ...]       # a run of sheet-2d with these keys set
python benchmarks/measure.py line [KEY=VALUE ...]        # a run of pulse-1d
python benchmarks/measure.py textbook STEPS DT SPACING   # so many steps of the textbook solution
python benchmarks/measure.py coasting [KEY=VALUE ...]    # what steps of varying size could save on sheet-2d
python benchmarks/measure.py bandwidth                   # memory bandwidth
"""

from __future__ import annotations

import json
import resource
import sys
import time

import numpy as np

BEGIN = time.perf_counter()


def run(case_name: str, overrides: list[str]) -> dict:
    """Run a case without output; seconds, activation times, counts, memory, bytes that a step must move."""
    import myostrain as ms
    from myostrain import cases

    simulation = ms.Case.from_file(cases.path(case_name), overrides).simulation()
    first_step = []

    class FirstStep:
        def update(self, step: int, time_: float) -> None:
            if step == 1:
                first_step.append(time.perf_counter() - BEGIN)

    results = simulation.run(FirstStep())
    model = simulation.model
    seconds = results["seconds"]
    found = {
        "activation": {name: probe["activation_time"] for name, probe in results["probes"].items()},
        "celerity": results["metrics"].get("celerity"),
        "seconds": seconds,
        "stepping": seconds["total"] - seconds["setup"],
        "to_first_step": first_step[0],
        "steps": results["steps"],
        "nodes": results["unknowns"]["potential"],
        "solver": results["solver"],
    }
    if model.potential.body.comm.size == 1 and case_name == "sheet-2d":
        found["bytes"] = least_bytes(model, results)
    return found


def least_bytes(model, results: dict) -> float:
    """Bytes that the run must move at least: matrices, factors and vectors, each once where it is used.

    An iteration for the potential reads the matrix and half of it with fill twice (8 bytes a value, 4 a
    column) and moves about ten vectors; a correction of mechanics reads its factor twice; an assembly reads
    the coordinates, dofs and values of each cell, and that of the potential writes the matrix.
    """
    potential, mechanics = results["solver"]["potential"], results["solver"]["mechanics"]
    nodes = results["unknowns"]["potential"]
    ksp = model.potential.solver.ksp
    nonzeros = ksp.getOperators()[0].getInfo()["nz_used"]
    incomplete = ksp.getPC().getFactorMatrix().getInfo()["nz_used"]
    iteration = 12 * (nonzeros + 2 * incomplete) + 10 * 8 * nodes
    pointwise = 30 * 8 * nodes
    factor = model.mechanics.solver.ksp.getPC().getFactorMatrix().getInfo()["nz_used"]
    cell = 3 * (2 * 8 + 3 * 4 + 3 * 8)
    return (
        potential["linear"] * iteration
        + results["steps"] * pointwise
        + mechanics["linear"] * (2 * 12 * factor)
        + (mechanics["assemblies"] + potential["assemblies"]) * cell * results["cells"]
        + potential["assemblies"] * 12 * nonzeros
    )


def textbook(steps: int, dt: float, spacing: float) -> dict:
    """Step the textbook solution of sheet-2d; seconds a step (median), arrival at the probes."""
    import myostrain as ms
    from myostrain import cases
    from myostrain.output.probes import ActivationTimes, Probes

    from textbook import Textbook

    case = ms.Case.from_file(cases.path("sheet-2d"), [f"geometry.spacing={spacing}"])
    mesh = ms.build(case.geometry, case.fibres).mesh
    (bump,) = case.initial
    a, b = bump.where.center
    solution = Textbook(
        mesh,
        fibre=case.fibres.direction,
        dt=dt,
        initial=lambda x: np.where(np.hypot(x[0] - a, x[1] - b) <= bump.where.radius, bump.potential, 0.0),
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
        "steps": steps,
        "nodes": int(mesh.geometry.index_map().size_global),
        "cells": int(mesh.topology.index_map(2).size_global),
    }


def coasting(overrides: list[str]) -> dict:
    """Share of the steps that a perfect controller of the step would need for the same largest local error.

    The local error of BDF2 goes with Δt³ times the third derivative of v: where its largest value over the
    body is e, a step (e_max / e)^(1/3) longer has the error of the worst one. The jump at the start is left
    out.
    """
    import myostrain as ms
    from myostrain import cases

    simulation = ms.Case.from_file(cases.path("sheet-2d"), overrides).simulation()
    past: list[np.ndarray] = []
    times, sizes = [], []

    class Watch:
        def update(self, step: int, time_: float) -> None:
            past.insert(0, simulation.model.potential.v.x.array.copy())
            if len(past) > 4:
                past.pop()
                a, b, c, d = past
                times.append(time_)
                sizes.append(float(np.abs(a - 3 * b + 3 * c - d).max()))

    simulation.run(Watch())
    inside = np.asarray(times) > 0.1
    size = np.asarray(sizes)[inside]
    return {"share": float(np.mean((size / size.max()) ** (1 / 3))), "least": float(size.min() / size.max())}


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
    if what == "bandwidth":
        found = {"bytes_per_second": bandwidth()}
    elif what == "textbook":
        found = textbook(int(rest[0]), float(rest[1]), float(rest[2]))
    elif what == "coasting":
        found = coasting(rest)
    else:
        found = run({"sheet": "sheet-2d", "line": "pulse-1d"}[what], rest)
    found["peak_memory"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024

    from mpi4py import MPI

    if MPI.COMM_WORLD.rank == 0:
        print(json.dumps(found))


if __name__ == "__main__":
    main()
