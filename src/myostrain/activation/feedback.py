"""How strongly γ answers to the potential, measured on the law; and whether the balance bears it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from myostrain.activation.checks import KEY
from myostrain.activation.contracts import Array
from myostrain.activation.nodal_activation import NodalActivation
from myostrain.engine import MPI, lasting
from myostrain.errors import InputError

import numpy as np

#: Potentials over the membrane's range at which a law is evaluated.
SAMPLES = 101


@dataclass(frozen=True)
class Feedback:
    """How γ answers to the potential, at the worst of all nodes and potentials; u is counted from rest.

    Args:
        lowest: The lowest 1 + γ.
        growth: The lowest derivative of (1 + γ) u in u.
        strength: The largest −u γ′/(1 + γ): by how much J u answers to u through J = 1 + γ.
    """

    lowest: float
    growth: float
    strength: float


def measured(gamma: Callable[[float], Array], low: float, high: float, rest: float, comm: Any) -> Feedback:
    """Evaluate γ (nodes,) at potentials from ``low`` to ``high`` (collective).

    Derivatives are differences of second order, at the ends too: exact for what is quadratic in u.

    Raises:
        InputError: γ is not finite somewhere.
    """
    potentials = np.linspace(low, high, SAMPLES)
    step = potentials[1] - potentials[0]
    lowest, growth, strength, bad = np.inf, np.inf, -np.inf, np.inf
    window: list[tuple[float, Array]] = []

    def take(at: int, weights: tuple[float, float, float]) -> None:
        """The derivatives at one of the last three potentials."""
        nonlocal growth, strength
        u, stretch = window[at]
        slope = sum(w * one for w, (_, one) in zip(weights, window, strict=True)) / (2 * step)
        product = sum(w * v * one for w, (v, one) in zip(weights, window, strict=True)) / (2 * step)
        growth = min(growth, float(np.min(product, initial=np.inf)))
        with np.errstate(divide="ignore", invalid="ignore"):
            answer = -u * slope / stretch
        strength = max(strength, float(np.max(answer, initial=-np.inf)))

    for index, potential in enumerate(potentials):
        window = [*window[-2:], (potential - rest, 1 + gamma(float(potential)))]
        if not np.isfinite(window[-1][1]).all():
            bad = float(potential)
            break
        lowest = min(lowest, float(np.min(window[-1][1], initial=np.inf)))
        if index == 2:
            take(0, (-3.0, 4.0, -1.0))
        if index >= 2:
            take(1, (-1.0, 0.0, 1.0))
        if index == SAMPLES - 1:
            take(2, (1.0, -4.0, 3.0))
    least = np.array([lowest, growth, -strength, bad])
    lasting(comm).Allreduce(MPI.IN_PLACE, least, op=MPI.MIN)
    if np.isfinite(least[3]):
        raise InputError(f"the law gives what is not finite where the potential is {least[3]:.6g}", KEY)
    return Feedback(float(least[0]), float(least[1]), -float(least[2]))


def check_well_posed(activation: NodalActivation, potential: Any, follows: bool) -> float:
    """Refuse an activation that makes Fo singular, or the balance of the potential backward-parabolic.

    With v counted from rest: where J follows 1 + γ(v) at once, ∂((1 + γ) v)/∂t = (1 + γ + v γ′) ∂v/∂t, whose
    factor must be positive over the membrane's range: for γ = −βv and v up to 1 that is 2β < 1, stricter than
    the paper's αβ < 1/2. The law is evaluated at the nodes with its present states and other drivers: what
    has a time of its own does not follow v at once, and is not bound by it.

    Args:
        activation: The law at the nodes.
        potential: The potential, or one that is given.
        follows: Whether J follows γ.

    Returns:
        The largest −v γ′/(1 + γ), by how much J v answers to v through J; zero where J does not follow.

    Raises:
        InputError: The activation is singular, or the balance ill-posed.
    """
    if not activation.answers:
        return 0.0
    (low, high), rest, comm = potential.range, potential.rest, potential.body.comm

    def gamma(value: float) -> Array:
        return activation.at_potential(value, (value - rest) / potential.scale)

    found = measured(gamma, low, high, rest, comm)
    key = "activation.beta" if hasattr(activation.law, "beta") else "activation"
    if not found.lowest > 0:
        raise InputError(
            f"the active deformation is singular: 1 + γ = {found.lowest:.3g} for v in [{low:g}, {high:g}]",
            key,
        )
    most = lasting(comm).allreduce(float(np.max(potential.v.x.array, initial=low)), op=MPI.MAX)
    if most > high:
        lowest = float(np.min(1 + gamma(most), initial=np.inf))
        at_most = lasting(comm).allreduce(lowest, op=MPI.MIN)
        if not at_most > 0:
            raise InputError(
                f"the active deformation is singular: 1 + γ = {at_most:.3g} for v = {most:.3g}",
                "initial.potential",
            )
    if potential.balance != "conservative" or not follows:
        return 0.0
    if found.growth < 1e-9:
        raise InputError(
            "the conservative balance is ill-posed where (1 + γ(v)) v, v counted from rest, does not grow "
            "with v (γ = −βv, with v from 0 to 1, needs β < 0.5); a smaller beta, potential.balance = "
            '"advective", or on a line mechanics.relaxation_time > 0',
            key,
        )
    return max(found.strength, 0.0)


def over_a_step(activation: NodalActivation, potential: Any, follows: bool, step: float, order: int) -> float:
    """The largest −v γ′/(1 + γ) for γ at the end of a step, over its potential there.

    A law whose time is short beside the step follows v within it, as one without states does at once.

    Args:
        activation: The law at the nodes.
        potential: The potential.
        follows: Whether J follows γ.
        step: Length of the step.
        order: 1: the drivers are frozen at the end of the step; 2: at its middle.
    """
    if not activation.answers or potential.balance != "conservative" or not follows:
        return 0.0
    (low, high), rest = potential.range, potential.rest

    def gamma(value: float) -> Array:
        return activation.at_potential(value, (value - rest) / potential.scale, step, order)

    return max(measured(gamma, low, high, rest, potential.body.comm).strength, 0.0)
