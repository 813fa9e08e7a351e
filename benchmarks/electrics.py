"""The electrics alone: a rigid slab with TenTusscherPanfilov2006, beside fenicsx-beat on the same mesh.

python benchmarks/electrics.py [--spacing=0.128] [--end=100] [--step=0.05] [--beat=PYTHON] [--out=FILE]
python benchmarks/electrics.py ours|beat SPACING END STEP   # one side, in this Python

The slab, conductivities and stimulus are those of the N-version benchmark (docs/niederer.md); spacing 0.128
gives 200,000 nodes. fenicsx-beat splits the operators (Godunov), takes first-order generalised Rush–Larsen
steps by NumPy code that gotranx generates from the model's file in its own wheel, and solves the diffusion
by its defaults; this takes them of second order. Neither writes anything. Each side runs in a process of its
own, one after the other. The first step, in which formulas are compiled, is left out. Others use the machine
too: the processor seconds are what counts.

fenicsx-beat is no dependency. PYTHON is that of an environment which has it, made once:

    uv venv beat && uv pip install --python beat dolfinx-solver-real==0.11.* gotranx==2.9.*
    uv pip install --python beat --no-deps fenicsx-beat==0.7.*
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import time
from pathlib import Path

from apart import apart

SIZE = (20.0, 7.0, 3.0)
#: mm²/ms: harmonic means of the conductivities (S/m) over χ Cm.
ALONG, ACROSS = (s / (140 * 0.01) for s in (0.17 * 0.62 / (0.17 + 0.62), 0.019 * 0.24 / (0.019 + 0.24)))
STRENGTH, DURATION, CORNER = 50 / (140 * 0.01), 2.0, 1.5


def cells(spacing: float) -> list[int]:
    """Boxes along each side."""
    return [max(1, round(side / spacing)) for side in SIZE]


class Clock:
    """Times steps from the end of the first one, in which formulas are compiled, to that of the last."""

    def update(self, step: int, _time: float) -> None:
        """A step has been taken."""
        self.last = step - 1, time.perf_counter(), time.process_time()
        if step == 1:
            self.first = self.last

    def found(self) -> dict:
        """Steps, seconds and processor seconds."""
        return {
            key: b - a for key, a, b in zip(("steps", "seconds", "cpu"), self.first, self.last, strict=True)
        }


def ours(spacing: float, end: float, step: float) -> dict:
    """Step the slab by myostrain."""
    import myostrain as ms

    body = ms.build(
        ms.geometry.Slab(size=SIZE, spacing=spacing), ms.geometry.UniformFibres(direction=(1.0, 0.0, 0.0))
    )
    corner = ms.Place(box=((0.0, 0.0, 0.0), (CORNER, CORNER, CORNER)))
    potential = ms.Potential(
        body,
        membrane=ms.membranes.TenTusscherPanfilov2006(),
        diffusivity=(ALONG, ACROSS),
        mass="averaged",
        stimuli=[ms.Stimulus(where=corner, strength=STRENGTH, duration=DURATION)],
    )
    simulation = ms.Simulation(ms.Electromechanics(potential), step=step, end=end)
    clock = Clock()
    found = simulation.run(clock)
    return {
        "nodes": len(potential.v.x.array),
        **clock.found(),
        "iterations": found["solver"]["potential"]["linear"] / found["steps"],
        "potential": [float(potential.v.x.array.min()), float(potential.v.x.array.max())],
    }


def beat(spacing: float, end: float, step: float) -> dict:
    """Step the slab by fenicsx-beat."""
    import dolfinx_solver  # noqa: F401

    import beat as package
    import dolfinx
    import gotranx
    import numpy as np
    import ufl
    from mpi4py import MPI

    file = Path(package.__file__).parent / "cli/templates/niederer_benchmark"
    ode = gotranx.load_ode(file / "tentusscher_panfilov_2006_epi_cell.ode")
    scheme = [gotranx.schemes.Scheme.generalized_rush_larsen]
    model: dict = {}
    exec(gotranx.cli.gotran2py.get_code(ode, scheme=scheme), model)  # what the package's own demos do
    mesh = dolfinx.mesh.create_box(MPI.COMM_WORLD, [np.zeros(3), np.array(SIZE)], cells(spacing))
    now = dolfinx.fem.Constant(mesh, 0.0)
    x = ufl.SpatialCoordinate(mesh)
    inside = ufl.And(ufl.And(ufl.le(x[0], CORNER), ufl.le(x[1], CORNER)), ufl.le(x[2], CORNER))
    applied = ufl.conditional(ufl.And(ufl.le(now, DURATION), inside), STRENGTH, 0.0)
    tensor = ufl.as_tensor(np.diag([ALONG, ACROSS, ACROSS]))
    pde = package.MonodomainModel(time=now, mesh=mesh, M=tensor, I_s=applied, C_m=1.0)
    v = dolfinx.fem.Function(dolfinx.fem.functionspace(mesh, ("Lagrange", 1)))
    parameters = model["init_parameter_values"](stim_amplitude=0.0)
    states = model["init_state_values"]()
    membrane = package.odesolver.DolfinODESolver(
        v_ode=v,
        v_pde=pde.state,
        fun=model["generalized_rush_larsen"],
        init_states=states,
        parameters=parameters,
        num_states=len(states),
        v_index=model["state_index"]("V"),
    )
    solver = package.MonodomainSplittingSolver(pde=pde, ode=membrane)
    clock = Clock()
    for number in range(round(end / step)):
        solver.step((number * step, (number + 1) * step))
        clock.update(number + 1, 0.0)
    found = pde.state.x.array
    return {
        "nodes": len(found),
        **clock.found(),
        "potential": [float(found.min()), float(found.max())],
    }


def measured(python: str, side: str, numbers: list[float]) -> dict:
    """One side in a process of its own."""
    found = apart(__file__, side, *numbers, python=python)
    per = 1e9 / found["nodes"] / found["steps"]
    print(
        f"{side}: {found['nodes']} nodes, {found['steps']} steps, {found['cpu']:.0f} processor seconds "
        f"({found['seconds']:.0f} s), {found['cpu'] * per:.0f} ns a node and step, "
        f"peak memory {found['memory'] / 1e6:.0f} MB, v at the end {found['potential']}",
        flush=True,
    )
    return found


def main() -> None:
    """Measure."""
    if len(sys.argv) > 1 and sys.argv[1] in ("ours", "beat"):
        numbers = [float(number) for number in sys.argv[2:]]
        found = ours(*numbers) if sys.argv[1] == "ours" else beat(*numbers)
        found["memory"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        print(json.dumps(found))
        return
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--spacing", type=float, default=0.128)
    parser.add_argument("--end", type=float, default=100.0, help="ms")
    parser.add_argument("--step", type=float, default=0.05, help="ms")
    parser.add_argument("--beat", help="the Python that has fenicsx-beat; without one only ours is run")
    parser.add_argument("--out", type=Path, default=Path("runs/electrics.json"), help="where the numbers go")
    given = parser.parse_args()
    numbers = [given.spacing, given.end, given.step]
    found = {"ours": measured(sys.executable, "ours", numbers)}
    if given.beat:
        found["beat"] = measured(given.beat, "beat", numbers)
        time_, memory = (found["beat"][key] / found["ours"][key] for key in ("cpu", "memory"))
        print(f"fenicsx-beat / ours: {time_:.1f} times the processor time, {memory:.1f} times the memory")
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
