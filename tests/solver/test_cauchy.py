"""Cauchy stress against closed forms, for every exported kinematics, constraint and bulk modulus."""

import dataclasses

import myostrain as ms
from myostrain import kinematics
from myostrain.materials import NeoHookean, Spring

import numpy as np
import pytest

from mechanics_tools import at_midpoints, described
from solid_tools import quick_kernels

MU, KAPPA = 2.0, 50.0
SIDES = {1: ("left",), 2: ("left", "bottom"), 3: ("left", "front", "bottom")}
ALL = {1: ("left", "right"), 2: ("left", "right", "bottom", "top")}
ALL[3] = (*ALL[2], "front", "back")


def every():
    """One of each exported kinematics for each of its constraints, with and without a bulk modulus."""
    for cls in vars(kinematics).values():
        if not (dataclasses.is_dataclass(cls) and hasattr(cls, "lift")):
            continue
        fields = [f.name for f in dataclasses.fields(cls)]
        for constraint in ("total", "elastic") if "constraint" in fields else (None,):
            given = {} if constraint is None else {"constraint": constraint}
            yield cls(**given)
            if "bulk_modulus" in fields:
                yield cls(**given, bulk_modulus=KAPPA)
                yield cls(**given, bulk_modulus=KAPPA, mixed=True)


def made(kinematic, **parts):
    shape = {
        1: lambda: ms.geometry.Line(length=2.0, spacing=1.0),
        2: lambda: ms.geometry.Rectangle(size=(2.0, 1.0), spacing=1.0),
        3: lambda: ms.geometry.Slab(size=(2.0, 1.0, 1.0), spacing=1.0),
    }[kinematic.dim]()
    fibres = None if kinematic.dim == 1 else ms.UniformFibres(direction=(1.0, *[0.0] * (kinematic.dim - 1)))
    with quick_kernels():
        return ms.Mechanics(
            ms.build(shape, fibres),
            kinematics=kinematic,
            material=Spring(mu=MU) if kinematic.dim == 1 else NeoHookean(mu=MU),
            tolerance=1e-12,
            **described(parts),
        )


def stress(mechanics):
    """The Cauchy stress at the cells' midpoints, (cells, n, n), and the trace at the nodes."""
    with quick_kernels():
        sigma = at_midpoints(mechanics.cauchy(), mechanics.body.mesh)()
    return sigma.reshape(len(sigma), *[mechanics.kinematics.tensor_dim] * 2), mechanics.stress_trace()


def expected(kinematic, diagonal):
    return np.diag(diagonal[: kinematic.tensor_dim])


@pytest.mark.parametrize("kinematic", list(every()), ids=str)
def test_a_block_under_uniform_pressure_reports_it(kinematic):
    """σ = −p 1 in equilibrium with a pressure p all around; no stress across the faces in plane stress."""
    p = 0.7
    mechanics = made(kinematic, pressure=dict.fromkeys(ALL[kinematic.dim], p))
    mechanics.start()
    sigma, trace = stress(mechanics)
    wanted = expected(kinematic, [-p, -p, 0.0 if isinstance(kinematic, kinematics.PlaneStress) else -p])
    np.testing.assert_allclose(sigma, np.broadcast_to(wanted, sigma.shape), atol=1e-8)
    np.testing.assert_allclose(trace, np.trace(wanted), atol=1e-8)


@pytest.mark.parametrize("kinematic", list(every()), ids=str)
def test_a_pull_on_one_side_is_the_only_stress(kinematic):
    """σ₁₁ = T for a pull T on the deformed area; plane strain keeps σ₃₃ = μ (1 − λ⁻²), λ² − λ⁻² = T/μ."""
    T = 1.1
    mechanics = made(kinematic, sliding=SIDES[kinematic.dim], pressure={"right": -T})
    mechanics.start()
    sigma, trace = stress(mechanics)
    third = 0.0
    if isinstance(kinematic, kinematics.PlaneStrain):
        square = T / MU / 2 + np.hypot(T / MU / 2, 1)  # λ²
        third = MU * (1 - 1 / square)
    wanted = expected(kinematic, [T, 0.0, third])
    np.testing.assert_allclose(sigma, np.broadcast_to(wanted, sigma.shape), atol=1e-8)
    np.testing.assert_allclose(trace, np.trace(wanted), atol=1e-8)


@pytest.mark.parametrize("pull", [0.9, -0.9])
def test_a_mixed_body_is_the_same_body(pull):
    """Solid.mixed: the transform of the volume's energy is exact, so that a homogeneous state, far from
    J = 1, is that without a pressure unknown, and the pressure is κ/2 (1/J − J)."""
    found = []
    for mixed in (False, True):
        solid = kinematics.Solid(bulk_modulus=2.0, mixed=mixed)
        mechanics = made(solid, sliding=SIDES[3], pressure={"right": pull, "top": pull / 3, "back": pull / 3})
        mechanics.start()
        x = mechanics.displacement().x.array
        found.append(x.copy())
    np.testing.assert_allclose(found[1], found[0], atol=1e-9)
    lengths = np.ptp(mechanics.body.mesh.geometry.x + found[1].reshape(-1, 3), axis=0)
    J = np.prod(lengths) / 2.0
    assert abs(J - 1) > 0.15
    p = mechanics.u.sub(1).collapse().x.array
    np.testing.assert_allclose(p, 1 / J - J, atol=1e-8)
