"""The first 300 steps of `sheet-2d` beside a textbook DOLFINx solution on the same mesh.

    python benchmarks/sheet.py [--steps 300] [--blocks 6]

Prints milliseconds a step, the ratio to the textbook, and how much the arrival of the wave at two points
differs from that of the run that solves mechanics in every step. The variants take turns in blocks of steps,
so that a machine whose speed drifts treats them alike; the median block is quoted.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import myostrain as ms
from myostrain import cases
from myostrain.output.probes import ActivationTimes, Probes

import numpy as np

from textbook import Textbook

POINTS = {"near": (86.0, 34.0), "nearer": (84.0, 26.0)}


class Ours:
    """myostrain with one scheme, stepped like the textbook."""

    def __init__(self, scheme: str, every: int, step: float) -> None:
        overrides = [f"time.scheme={scheme}", f"mechanics.every={every}", f"time.step={step}"]
        self.case = ms.Case.from_file(cases.path("sheet-2d"), overrides)
        self.model = self.case.build()
        self.model.start()
        self._step = step

    @property
    def v(self):
        return self.model.potential.v

    def step(self) -> None:
        self.model.step((self.model.steps + 1) * self._step)


def textbook_like(ours: Ours) -> Textbook:
    """The textbook solution of the same case on the same mesh."""
    case = ours.case
    (a, b), bump = case.initial.center, case.initial
    return Textbook(
        ours.model.potential.body.mesh,
        fibre=case.fibres.direction,
        alpha=case.cell.alpha,
        tau=case.cell.tau,
        A=case.cell.A,
        D=case.potential.diffusivity,
        beta=case.law.beta,
        mu=case.material.mu,
        robin=case.mechanics.robin,
        dt=case.time.step,
        initial=lambda x: np.where(np.hypot(x[0] - a, x[1] - b) <= bump.radius, bump.potential, 0.0),
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=300)
    parser.add_argument(
        "--blocks", type=int, default=6, help="blocks of steps in which the variants take turns"
    )
    arguments = parser.parse_args()
    step = 1e-3
    every_step = Ours("staggered", 1, step)
    variants: dict[str, tuple[object, Callable[[], None]]] = {}
    variants["textbook, mechanics every step"] = (book := textbook_like(every_step), book.step)
    variants["staggered, every step"] = (every_step, every_step.step)
    for scheme in ("staggered", "second-order"):
        made = Ours(scheme, 5, step)
        variants[f"{scheme}, every 5 steps"] = (made, made.step)

    space = every_step.v.function_space
    seen = {name: ActivationTimes(thing.v, Probes(space, POINTS)) for name, (thing, _) in variants.items()}
    blocks: dict[str, list[float]] = {name: [] for name in variants}
    size = max(1, arguments.steps // arguments.blocks)
    for block in range(arguments.blocks):
        for name, (_, advance) in variants.items():
            spent = 0.0
            for number in range(block * size, (block + 1) * size):
                begin = time.perf_counter()
                advance()
                spent += time.perf_counter() - begin
                seen[name].observe(number * step, (number + 1) * step)
            blocks[name].append(spent / size * 1e3)

    body = every_step.model.potential.body
    nodes = space.dofmap.index_map.size_global
    print(f"sheet-2d: {nodes} nodes, {body.cells} triangles, dt = {step}, {arguments.blocks * size} steps")
    base = np.median(blocks["textbook, mechanics every step"])
    truth = seen["staggered, every step"].at_probes()
    print(f"{'':34} {'ms a step':>10} {'ratio':>7}   arrival: difference to the run that solves every step")
    for name in variants:
        median = np.median(blocks[name])
        arrivals = seen[name].at_probes()
        differences = ", ".join(
            f"{probe} {100 * (arrivals[probe] / truth[probe] - 1):+.3f} %"
            if arrivals[probe] and truth[probe]
            else "-"
            for probe in POINTS
        )
        print(f"{name:34} {median:10.1f} {base / median:6.1f}x   {differences}")


if __name__ == "__main__":
    main()
