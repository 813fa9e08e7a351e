"""Nanoseconds a node and step of every membrane by its own integrator, and of what else could compute it.

    python benchmarks/membranes.py [--others=PYTHON] [--repeat=15] [--out=FILE] [--reuse=FILE]
    python benchmarks/membranes.py ours|others REPEAT [MODEL ...]   # one measurement, in this Python

A step is what the potential asks for: all states advanced, the current and its slope in v. 16,384 nodes
have potentials from all of the membrane's range and states at rest; the step is 0.01. Each kind of
measurement is a process of its own, one after the other in one run: compiled, compiled on two processes at
once with as many nodes each, NumPy, what a machine without a compiler falls back to. Times are processor
seconds, since others use the machine too; of the repeats, the least and the median.

PYTHON is that of an environment with others: numba, gotranx, and fenicsx-beat for its file of the model of
ten Tusscher and Panfilov, of which gotranx makes a step of first order (generalised Rush–Larsen, no slope)
in NumPy, compiled by numba, and in C, compiled with our flags:

    uv venv others && uv pip install --python others numba gotranx==2.9.*
    uv pip install --python others --no-deps fenicsx-beat==0.7.*
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from apart import apart

NODES = 16_384
LENGTH = 0.01
FILE = "cli/templates/niederer_benchmark/tentusscher_panfilov_2006_epi_cell.ode"
FLAGS = ["-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math"]


def times(step: Callable[[], Any], repeat: int) -> list[float]:
    """Least and median processor time, in ns a node, after a first call that compiles."""
    step()
    found = []
    for _ in range(repeat):
        begin = time.process_time_ns()
        step()
        found.append((time.process_time_ns() - begin) / NODES)
    return [min(found), statistics.median(found)]


def ours(repeat: int, names: list[str]) -> dict:
    """Each membrane, both orders."""
    import myostrain as ms
    from myostrain.membranes import Step
    from myostrain.membranes.reaction import Reaction

    from mpi4py import MPI

    found = {}
    exported = [n for n in ms.membranes.__all__ if hasattr(getattr(ms.membranes, n), "current")]
    for name in names or [n for n in exported if n not in ("Membrane", "FileMembrane")]:
        membrane = getattr(ms.membranes, name)()
        rest = np.array(membrane.resting_states(), dtype=float).reshape(-1, 1)
        states = np.repeat(rest, NODES, axis=1)
        v = np.random.default_rng(1).uniform(*membrane.range, NODES)
        for order in (1, 2):
            reaction, out = Reaction(membrane, comm=MPI.COMM_WORLD), np.empty_like(states)
            weight = (1.0 if order == 1 else 1.5) / LENGTH
            step = Step(LENGTH, weight, -weight * states, states, v, order)
            reaction.solve(v, states.copy(), step, out)
            MPI.COMM_WORLD.Barrier()
            here = times(lambda r=reaction, s=states, p=step, o=out, u=v: r.solve(u, s, p, o), repeat)
            slowest = [max(ranks) for ranks in zip(*MPI.COMM_WORLD.allgather(here), strict=True)]
            found[f"{name} {order}"] = [len(states), type(reaction.integrator).__name__, *slowest]
    return found if MPI.COMM_WORLD.rank == 0 else {}


def others(repeat: int) -> dict:
    """What gotranx makes of the model of ten Tusscher and Panfilov: NumPy, numba, C."""
    import gotranx
    import numba

    ode = gotranx.load_ode(Path(find_spec("beat").submodule_search_locations[0]) / FILE)
    scheme = [gotranx.schemes.Scheme.generalized_rush_larsen]
    model: dict[str, Any] = {}
    exec(gotranx.cli.gotran2py.get_code(ode, scheme=scheme), model)  # what its own demos do
    parameters = model["init_parameter_values"](stim_amplitude=0.0)
    states = np.repeat(model["init_state_values"]()[:, None], NODES, axis=1)
    states[model["state_index"]("V")] = np.random.default_rng(1).uniform(-90.0, 45.0, NODES)
    plain = model["generalized_rush_larsen"]
    found = {"gotranx, NumPy": times(lambda: plain(states, 0.0, LENGTH, parameters), repeat)}

    single = numba.njit(plain)

    @numba.njit
    def each(states: Any, parameters: Any, out: Any) -> None:
        for node in range(states.shape[1]):
            out[:, node] = single(states[:, node], 0.0, LENGTH, parameters)

    out = np.empty_like(states)
    try:
        found["gotranx, numba"] = times(lambda: each(states, parameters, out), repeat)
    except numba.core.errors.NumbaError as error:
        print(f"numba refuses: {str(error).splitlines()[0]}", file=sys.stderr)

    text = gotranx.cli.gotran2c.get_code(ode, scheme=scheme)
    text += """
void each(long n, const double *states, double h, const double *parameters, double *out)
{
  for (long node = 0; node < n; ++node)
    generalized_rush_larsen(states + NUM_STATES*node, 0.0, h, parameters, out + NUM_STATES*node);
}
"""
    with tempfile.TemporaryDirectory() as folder:
        source, made = Path(folder) / "model.c", Path(folder) / "model.so"
        source.write_text(text, encoding="utf-8")
        subprocess.run(["cc", *FLAGS, "-fPIC", "-shared", "-o", made, source, "-lm"], check=True)
        library = ctypes.CDLL(str(made))
    by_node = np.ascontiguousarray(states.T)
    after = np.empty_like(by_node)
    number = ctypes.c_double
    pointers = [a.ctypes.data_as(ctypes.POINTER(number)) for a in (by_node, parameters, after)]
    found["gotranx, C"] = times(
        lambda: library.each(ctypes.c_long(NODES), pointers[0], number(LENGTH), pointers[1], pointers[2]),
        repeat,
    )
    return found


def measured(
    side: str, repeat: int, python: str = sys.executable, processes: int = 1, **settings: str
) -> dict:
    """One kind of measurement in processes of its own."""
    print(f"  {side} on {processes}", *settings, flush=True)
    return apart(__file__, side, repeat, python=python, processes=processes, **settings)


def everything(repeat: int, python: str | None) -> dict:
    """All measurements."""
    load = os.getloadavg()[0]
    found = {
        "compiled": measured("ours", repeat),
        "two": measured("ours", repeat, processes=2),
        "numpy": measured("ours", 3, MYOSTRAIN_NO_COMPILER="1"),
        "others": measured("others", repeat, python) if python else {},
    }
    return {**found, "repeat": repeat, "load": [load, os.getloadavg()[0]]}


def main() -> None:
    """Measure, and write the table of docs/benchmarks.md."""
    if len(sys.argv) > 1 and sys.argv[1] in ("ours", "others"):
        repeat, names = int(sys.argv[2]), sys.argv[3:]
        if found := ours(repeat, names) if sys.argv[1] == "ours" else others(repeat):
            print(json.dumps(found))
        return
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--others", help="the Python of an environment with numba, gotranx and fenicsx-beat")
    parser.add_argument("--repeat", type=int, default=15)
    parser.add_argument("--out", type=Path, default=Path("runs/membranes.json"), help="where numbers go")
    parser.add_argument("--reuse", type=Path, help="write the table from the measurements in this file")
    given = parser.parse_args()
    if given.reuse:
        found = json.loads(given.reuse.read_text(encoding="utf-8"))
    else:
        found = everything(given.repeat, given.others)
        given.out.parent.mkdir(parents=True, exist_ok=True)
        given.out.write_text(json.dumps(found, indent=1), encoding="utf-8")
    import page

    page.put("membranes", page.membranes(found))


if __name__ == "__main__":
    main()
