"""How far Newton's method goes in one jump of the activation, and what a way in small steps takes."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from myostrain.activation import Fibre, FibreTension
from myostrain.engine import MPI
from myostrain.errors import ComputationError
from myostrain.geometry import Rectangle, Slab, UniformFibres, build
from myostrain.kinematics import PlaneStress, Solid
from myostrain.mechanics.equilibrium import Mechanics
from myostrain.mechanics.supports import Supports
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements.muscle import matched
from myostrain.reproduce.measurements.points import Points, material

#: How often the largest jump is halved.
HALVINGS = 6


def jumps(
    law: Mapping[str, Any], gamma: float, largest: float, spacing: float, steps: int, solid: bool
) -> Found:
    """A body that is clamped on one side: the largest jump from rest, and the way to γ in steps.

    Strain along the fibre and the tensions that match the strip, for each size of γ.

    Args:
        law: The passive law.
        gamma: γ at the end of the way.
        largest: γ of the largest jump that is tried.
        spacing: Of the mesh.
        steps: Steps of the way.
        solid: Whether it is an incompressible block of 2 × 1 × 1; else a sheet of 2 × 1 in plane stress.

    Returns:
        Numbers by approach, "strain", "stress" (matched to the free contraction) and "force" (to the
        isometric force): ``jump``, the largest γ (of that size, or the tension matched to it) at which
        Newton's method converges from rest in one jump; ``first``, corrections of the jump to γ, None if it
        fails; ``corrections`` and ``factorizations`` of the way; ``seconds`` of it.
    """
    passive = material(law)
    points = Points(passive, 1)
    shape: Any = Slab(size=(2.0, 1.0, 1.0), spacing=spacing)
    fibres = UniformFibres(direction=(1.0, 0.2, 0.0), sheet=(0.0, 0.0, 1.0))
    if not solid:
        shape, fibres = Rectangle(size=(2.0, 1.0), spacing=spacing), UniformFibres(direction=(1.0, 0.2))
    body = build(shape, fibres, MPI.COMM_SELF)
    both = {
        approach: Mechanics(
            body,
            kinematics=Solid() if solid else PlaneStress(),
            material=passive,
            active=active,
            supports=Supports(fixed=("left",)),
            tolerance=1e-8,
        )
        for approach, active in (("strain", Fibre()), ("tension", FibreTension()))
    }

    def activation(approach: str, size: float) -> float:
        if approach == "strain":
            return size
        found = matched(points, {"kind": "Fibre"}, size)
        return float(found["tension" if approach == "stress" else "isometric"])

    numbers: dict[str, Any] = {}
    for approach in ("strain", "stress", "force"):
        mechanics = both["strain" if approach == "strain" else "tension"]

        def corrections(size: float, approach: str = approach, mechanics: Any = mechanics) -> int | None:
            """How many a jump from rest takes; None where it fails."""
            mechanics.activation.x.array[:] = 0.0
            mechanics.start(0.0)
            mechanics.activation.x.array[:] = activation(approach, size)
            mechanics.solver.forget()
            try:
                return int(mechanics.solver.solve())
            except ComputationError:
                return None

        numbers[approach] = {"first": corrections(gamma)}
        good, bad = 0.0, largest
        if corrections(largest) is not None:
            good = largest
        else:
            for _ in range(HALVINGS):
                middle = (good + bad) / 2
                good, bad = (middle, bad) if corrections(middle) is not None else (good, middle)
        numbers[approach]["jump"] = good
        numbers[approach] |= _way(mechanics, activation(approach, gamma), steps)
    return Found(numbers)


def _way(mechanics: Mechanics, end: float, steps: int) -> dict[str, float]:
    mechanics.activation.x.array[:] = 0.0
    mechanics.start(0.0)
    before, began = mechanics.solver.counters.as_dict(), time.perf_counter()
    for step in range(1, steps + 1):
        mechanics.activation.x.array[:] = end * step / steps
        mechanics.solve(float(step))
        mechanics.accept(float(step))
    after, seconds = mechanics.solver.counters.as_dict(), time.perf_counter() - began
    return {
        "corrections": after["newton"] - before["newton"],
        "factorizations": after["factorizations"] - before["factorizations"],
        "seconds": seconds,
    }
