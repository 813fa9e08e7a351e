"""Viscous sheets and lines: the mechanical wave beside the electrical one, and what viscosity dissipates."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, ClassVar

from myostrain.activation import Fibre
from myostrain.case.case import Case
from myostrain.coupling import Electromechanics
from myostrain.engine import MPI, fem, jit_options
from myostrain.geometry import Microstructure, Rectangle, UniformFibres, build
from myostrain.kinematics import PlaneStrain, PlaneStress, Solid
from myostrain.materials import NeoHookean
from myostrain.mechanics.active_body import ActiveBody
from myostrain.mechanics.equilibrium import Mechanics
from myostrain.output.probes import Probes
from myostrain.reproduce.jobs import Array, Found
from myostrain.reproduce.measurements import signals

import numpy as np
import ufl
from dolfinx import mesh as dmesh


@dataclass(frozen=True)
class Rectified:
    """γ = −β max(v, 0): as (3.4), but a potential below rest does not stretch.

    Args:
        beta: Contraction at v = 1.
    """

    beta: float

    drivers: ClassVar[tuple[str, ...]] = ("potential",)

    def activation(self, states: Any, drivers: Any) -> Any:
        """Active strain for the potential."""
        return -self.beta * np.maximum(drivers["potential"], 0.0)


def wave(case: Mapping[str, Any], probe: str, rectified: bool) -> Found:
    """Run a sheet and follow potential and shortening of the fibre at one of its probes.

    Args:
        case: The case, resolved; its fibres are uniform.
        probe: Name of the probe.
        rectified: Whether γ = −β max(v, 0) in place of the case's law.

    Returns:
        Numbers: ``metrics``; of the ``potential`` v and of the ``shortening`` 1 − |F f0| the largest value
        ``peak``, when it is reached, ``peak_time``, when half of it is reached first, ``rise_time``, and for
        how long it is exceeded, ``duration`` (None if to the end of the run); ``peak_delay`` and
        ``rise_delay`` of the shortening. Arrays (samples,): ``times``, ``potential`` and ``shortening``.
    """
    described = Case.from_dict(case)
    if rectified:
        described = dataclasses.replace(described, law=Rectified(described.law.beta))
    simulation = described.simulation()
    recorder = AtProbe(simulation.model, probe, case["probes"][probe], case["fibres"]["direction"])
    recorder.every = getattr(simulation.model.scheme, "every", 1)
    results = simulation.run(recorder)
    times = np.array(recorder.times)
    potential, shortening = np.array(recorder.potential), np.array(recorder.shortening)
    early, late = signals.wave(times, potential), signals.wave(times, shortening)
    numbers = {
        "metrics": results["metrics"],
        "potential": early,
        "shortening": late,
        "peak_delay": signals.difference(late["peak_time"], early["peak_time"]),
        "rise_delay": signals.difference(late["rise_time"], early["rise_time"]),
    }
    return Found(numbers, {"times": times, "potential": potential, "shortening": shortening})


class AtProbe:
    """Samples v and 1 − |F f0| in the probe's triangle, where mechanics has been solved."""

    every = 1

    def __init__(
        self, model: Electromechanics, name: str, place: Sequence[float], direction: Sequence[float]
    ) -> None:
        space = model.potential.v.function_space
        self._model = model
        self._probe = Probes(space, {name: place})
        # At a node several triangles meet: the lower left one, whatever their order.
        self._corners = Probes(space, {name: [x - 1e-3 for x in place]}).corners[0]
        X = space.tabulate_dof_coordinates()[self._corners, :2]
        self._X = (X[1:] - X[0]).T
        self._f0 = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
        self.times: list[float] = []
        self.potential: list[float] = []
        self.shortening: list[float] = []

    def update(self, step: int, time: float) -> None:
        """Sample the state that mechanics was solved for."""
        if step % self.every:
            return
        assert self._model.mechanics is not None
        u = self._model.mechanics.displacement().x.array.reshape(-1, 2)[self._corners]
        F = np.eye(2) + (u[1:] - u[0]).T @ np.linalg.inv(self._X)
        self.times.append(time)
        self.potential.append(float(self._probe.local(self._model.potential.v.x.array)[0]))
        self.shortening.append(float(1 - np.linalg.norm(F @ self._f0)))


def dissipation(samples: int, seed: int, relaxation_time: float, mu: float) -> Found:
    """The viscous power P : Ḟ for random F, Ḟ, fibres and activations in three dimensions.

    Returns:
        Numbers, relative to the largest power: ``least`` power; ``defect`` from 2 λ μ Jo |Fo⁻ᵀ Ė Fo⁻¹|²;
        and, relative to the largest stress, the stress of a rigid motion, ``rigid``, and by how much S
        changes when the motion is seen from a turning frame, ``frame``.
    """
    rng = np.random.default_rng(seed)
    F = np.eye(3) + 0.3 * rng.uniform(-1, 1, (samples, 3, 3))
    rate = rng.standard_normal((samples, 3, 3))
    n = rng.standard_normal((samples, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    gamma = rng.uniform(-0.5, 0.3, samples)
    spin = rng.standard_normal((samples, 3, 3))
    spin -= spin.transpose(0, 2, 1)
    Q, _ = np.linalg.qr(rng.standard_normal((samples, 3, 3)))
    stress = _viscous_stress(n, gamma, relaxation_time, mu)
    S = stress(_strain_rate(F, rate))
    turned = stress(_strain_rate(Q @ F, Q @ (rate + spin @ F)))
    rigid = stress(_strain_rate(F, spin @ F))
    Fo = np.eye(3) + gamma[:, None, None] * n[:, :, None] * n[:, None, :]
    back = np.linalg.inv(Fo)
    inner = back.transpose(0, 2, 1) @ _strain_rate(F, rate) @ back
    exact = 2 * relaxation_time * mu * np.linalg.det(Fo) * (inner**2).sum((1, 2))
    power = np.einsum("nij,nij->n", F @ S, rate)
    return Found(
        {
            "least": float(power.min() / power.max()),
            "defect": float(np.abs(power - exact).max() / power.max()),
            "rigid": float(np.abs(rigid).max() / np.abs(S).max()),
            "frame": float(np.abs(turned - S).max() / np.abs(S).max()),
            "samples": samples,
        }
    )


def _strain_rate(F: Array, rate: Array) -> Array:
    return (F.transpose(0, 2, 1) @ rate + rate.transpose(0, 2, 1) @ F) / 2


def _viscous_stress(n: Array, gamma: Array, relaxation_time: float, mu: float) -> Any:
    """The program's own S (samples, 3, 3) as a function of Ė: a sample is a cell of a mesh."""
    mesh = dmesh.create_interval(MPI.COMM_SELF, len(n), [0.0, 1.0])
    fields = {shape: fem.Function(fem.functionspace(mesh, ("DG", 0, shape))) for shape in ((3, 3), (3,), ())}
    _put(fields[3,], n)
    _put(fields[()], gamma)
    solid = Solid(bulk_modulus=1.0)  # without a pressure
    body: Any = SimpleNamespace(mesh=mesh, dim=3, fibres=Microstructure(fields[3,]))
    equations = ActiveBody(body, solid, NeoHookean(mu), Fibre(), relaxation_time)
    S = fem.Expression(
        equations.viscous_stress(fields[3, 3], fields[()]), np.array([[0.5]]), jit_options=jit_options()
    )

    def stress(strain_rate: Array) -> Array:
        _put(fields[3, 3], strain_rate)
        return np.asarray(S.eval(mesh, np.arange(len(n), dtype=np.int32))).reshape(-1, 3, 3)

    return stress


def _put(function: Any, samples: Array) -> None:
    cells = function.function_space.dofmap.list[:, 0]
    values = function.x.array.reshape(len(cells), -1)
    values[cells] = np.reshape(samples, (len(cells), -1))


def free_block(kinematics: str, size: float, relaxation_time: float, steps: int) -> Found:
    """A free sheet under γ(t) = −size sin²(π t) for 0 ≤ t ≤ 1, and the line (4.14) under the same.

    Args:
        kinematics: "plane-stress" or "plane-strain".
        size: Largest contraction.
        relaxation_time: λ.
        steps: Time steps, second order.

    Returns:
        Arrays over time: ``times``; ``sheet``, the stretch along the fibre less one, over its share in the
        elastic limit for small γ (2/3 or 1/2); ``line``, x′ − 1. Numbers: the largest ``difference`` of the
        two, relative to ``size``; ``line_power``, the least power of the line's dashpot, the rate of
        (x′ − 1)/(1 + γ) times that of x′, relative to the largest.
    """
    case = PlaneStress() if kinematics == "plane-stress" else PlaneStrain()
    share = 2 / 3 if kinematics == "plane-stress" else 1 / 2
    body = build(Rectangle(size=(2.0, 1.0), spacing=1.0), UniformFibres(direction=(1.0, 0.0)))
    mechanics = Mechanics(
        body,
        kinematics=case,
        material=NeoHookean(1.0),
        relaxation_time=relaxation_time,
        tolerance=1e-11,
    )
    mechanics.start(0.0)
    grad = ufl.grad(ufl.split(mechanics.u)[0] if case.has_pressure else mechanics.u)
    expression = fem.Expression(grad, np.array([[1 / 3, 1 / 3]]), jit_options=jit_options())
    times = np.linspace(0, 1, steps + 1)[1:]
    active = -size * np.sin(np.pi * times) ** 2
    stretches = []
    for time, gamma in zip(times, active, strict=True):
        mechanics.activation.x.array[:] = gamma
        mechanics.solve(time, order=2)
        mechanics.accept(time)
        F = np.eye(2) + np.asarray(expression.eval(body.mesh, np.array([0], dtype=np.int32))).reshape(2, 2)
        stretches.append(np.linalg.norm(F[:, 0]))
    sheet = (np.array(stretches) - 1) / share
    line = _line(times, size, relaxation_time)
    rate = np.gradient(line / (1 + active), times) * np.gradient(line, times)
    return Found(
        {
            "difference": float(np.abs(sheet - line).max() / size),
            "line_power": float(rate.min() / rate.max()),
        },
        {"times": times, "sheet": sheet, "line": line, "gamma": active},
    )


def _line(times: Array, size: float, relaxation_time: float, finer: int = 20) -> Array:
    """x′ − 1 of (4.14) by the trapezoidal rule for e = (x′ − 1)/(1 + γ): λ e′ = γ/(1 + γ) − e."""
    fine = np.linspace(0, times[-1], finer * len(times) + 1)
    gamma = -size * np.sin(np.pi * fine) ** 2
    goal = gamma / (1 + gamma)
    h = fine[1] / (2 * relaxation_time)
    r, s = (1 - h) / (1 + h), h / (1 + h)
    e = np.zeros_like(fine)
    for k in range(1, len(fine)):
        e[k] = r * e[k - 1] + s * (goal[k - 1] + goal[k])
    return np.asarray((e * (1 + gamma))[finer::finer])
