"""When a solve ends: what it leaves of the error, step by step."""

import myostrain as ms
from myostrain.kinematics import Line, PlaneStrain, PlaneStress, Solid
from myostrain.materials import NeoHookean, Spring

import numpy as np
import pytest

from mechanics_tools import described, sheet

TOLERANCE = 1e-6


def line(**parts):
    body = ms.build(ms.geometry.Line(length=10.0, spacing=0.5))
    return ms.Mechanics(body, kinematics=Line(), material=Spring(), **described({"fixed": ["left"]}), **parts)


def plane(kinematics):
    def make(**parts):
        return ms.Mechanics(
            sheet(size=(2.0, 2.0), spacing=0.5),
            kinematics=kinematics,
            material=NeoHookean(),
            **described({"robin": 1.0}),
            **parts,
        )

    return make


def slab(**parts):
    fibres = ms.UniformFibres(direction=(2.0, 1.0, 0.5), sheet=(-1.0, 2.0, 0.0))
    body = ms.build(ms.geometry.Slab(size=(4.0, 2.0, 1.0), spacing=1.0), fibres)
    return ms.Mechanics(
        body, kinematics=Solid(), material=NeoHookean(), **described({"fixed": ["left"]}), **parts
    )


BODIES = {
    "line": line,
    "plane stress": plane(PlaneStress()),
    "plane strain": plane(PlaneStrain(constraint="elastic")),
    "solid": slab,
}


@pytest.mark.parametrize("relaxation_time", [0.0, 0.3])
@pytest.mark.parametrize("name, steps", [*((name, 20) for name in BODIES), ("plane stress", 80)])
def test_what_a_step_leaves_is_within_the_tolerance(name, steps, relaxation_time):
    """Mechanics: "largest error that iterating leaves in the displacement". Each step of a contraction and
    release, from the extrapolation and by the tangent that is kept, is followed by a solve of the same step
    with fresh tangents to 1e-12; with 80 steps most end after one correction that is trusted.
    """
    mechanics = BODIES[name](tolerance=TOLERANCE, relaxation_time=relaxation_time)
    solver, x = mechanics.solver, mechanics.activation.function_space.tabulate_dof_coordinates()[:, 0]
    left, wanted = [], solver.tolerance
    mechanics.start()
    for step in range(1, steps + 1):
        time = step / steps
        wave = 0.6 + 0.4 * np.cos(2 * np.pi * (x / x.max() - time))
        mechanics.activation.x.array[:] = -0.25 * np.sin(np.pi * time) ** 2 * wave
        mechanics.solve(time, order=min(step, 2))
        found, kept = mechanics.u.x.array.copy(), solver.state()
        solver.tolerance = 1e-12 * mechanics.size
        for _ in range(2):
            solver.forget()
            solver.solve()
        left.append(np.abs(found - mechanics.u.x.array)[measured(mechanics)].max() / wanted)
        solver.tolerance = wanted
        solver.restore(kept)
        mechanics.u.x.array[:] = found
        mechanics.accept(time)
    assert max(left) < 1.0, left
    if steps == 80:
        assert solver.counters.newton < 1.5 * steps


def measured(mechanics):
    """The displacement's entries of the unknown."""
    space = mechanics.u.function_space
    return space.sub(0).collapse()[1] if mechanics.kinematics.has_pressure else slice(None)
