"""Activation that answers to the length, staggered with mechanics: when does the length swing?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from myostrain.activation import Fibre, FibreTension, Rossi2014
from myostrain.coupling import Electromechanics
from myostrain.electrics import GivenPotential
from myostrain.engine import MPI
from myostrain.errors import ComputationError
from myostrain.geometry import Rectangle, UniformFibres, build
from myostrain.kinematics import PlaneStress
from myostrain.mechanics.equilibrium import Mechanics
from myostrain.mechanics.loads import Loads
from myostrain.mechanics.supports import Supports
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements.muscle import calcium_for
from myostrain.reproduce.measurements.points import (
    ONE,
    Array,
    Points,
    active_tensors,
    free_stretches,
    held_force,
    material,
)
from myostrain.schemes import Implicit, Scheme, SecondOrder, Staggered

import numpy as np

SCHEMES: dict[str, Scheme] = {"staggered": Staggered(), "second-order": SecondOrder(), "implicit": Implicit()}
#: Changes of the stretch from step to step of which a growth is measured.
SEEN = (1e-9, 3e-3)
#: The share by which the load differs from the isometric force.
OFF = 1e-3
#: Step of differences, in γ or relative to the tension.
STEP = 1e-4


@dataclass(frozen=True)
class Answering:
    """A tension or γ that answers to the stretch at once: a = a₀ (1 + β (λ − λ₀)), and a₀ at the start.

    Args:
        size: a₀.
        slope: β.
        at: λ₀.
        yields: "tension" or "strain".
    """

    size: float
    slope: float
    at: float
    yields: str
    drivers = ("stretch", "time")

    def activation(self, states: Any, drivers: Any) -> Any:
        """The value for this stretch; neither a push nor an extension."""
        return self.limit(drivers) if drivers["time"] > 0 else self.size

    def limit(self, drivers: Any) -> Any:
        """The value for this stretch, whatever the time."""
        return self.size * np.maximum(1 + self.slope * (drivers["stretch"] - self.at), 0.0)


@dataclass(frozen=True)
class Lagging(Answering):
    """The same with a time: da/dt = (a∞(λ) − a)/τ, τ = 1, whose step is exact for a frozen λ."""

    states = ("value",)

    def initial_states(self, drivers: Any) -> Any:
        """a₀."""
        return (self.size,)

    def advance(self, states: Any, drivers: Any, step: float) -> Any:
        """The exact step."""
        limit = self.limit(drivers)
        return (limit + (states[0] - limit) * np.exp(-step))[None]

    def activation(self, states: Any, drivers: Any) -> Any:
        """The state."""
        return states[0]


@dataclass(frozen=True)
class Shortening(Answering):
    """A tension or γ that falls with the shortening: a = a₀ (1 + β dλ/dt), by the last two stretches."""

    states = ("stretch", "rate")

    def initial_states(self, drivers: Any) -> Any:
        """At rest at λ₀."""
        return self.at, 0.0

    def advance(self, states: Any, drivers: Any, step: float) -> Any:
        """The difference of the last two stretches over the step."""
        return np.stack([drivers["stretch"], (drivers["stretch"] - states[0]) / step])

    def activation(self, states: Any, drivers: Any) -> Any:
        """The value for this rate."""
        return self.size * (1 + self.slope * states[1])


@dataclass(frozen=True)
class Clamped:
    """The law of Rossi et al. at a calcium that stays, from γ₀.

    Args:
        law: The law.
        calcium: The calcium, μM.
        gamma: γ₀.
    """

    law: Rossi2014
    calcium: float
    gamma: float
    drivers = ("stretch",)
    states = ("gamma",)

    def initial_states(self, drivers: Any) -> Any:
        """γ₀."""
        return (self.gamma,)

    def advance(self, states: Any, drivers: Any, step: float) -> Any:
        """The step of Rossi et al.; in ms."""
        calcium = np.full_like(drivers["stretch"], self.calcium)
        return self.law.advance(states, {"calcium": calcium, "stretch": drivers["stretch"]}, step)

    def activation(self, states: Any, drivers: Any) -> Any:
        """γ."""
        return states[0]


class Strip:
    """A sheet of two triangles that bears about its isometric force as a dead load, its sides free.

    Args:
        law: The passive law.
        approach: "strain", Fo along the fibre, or "stress".
        activation: γ, or the tension, at that stretch.
        at: The stretch at which it was isometric, λ₀.
    """

    def __init__(self, law: Mapping[str, Any], approach: str, activation: float, at: float) -> None:
        passive = material(law)
        points = Points(passive, 1)
        strain = approach == "strain"

        def state(a: float) -> tuple[Array, float]:
            return (active_tensors({"kind": "Fibre"}, np.array([a])), 0.0) if strain else (ONE[None], a)

        Fo, tension = state(activation)
        isometric = held_force(points, Fo, np.array([at]), tension)[0]
        self.load, self.size, self.at = float(isometric * (1 + OFF)), activation, at

        def stretch(a: float) -> float:
            Fo, tension = state(a)
            return float(free_stretches(points, Fo, tension=tension, pull=self.load)[0, 0])

        self.stretch = stretch
        self.yields = "strain" if strain else "tension"
        self.mechanics = Mechanics(
            build(
                Rectangle(size=(1.0, 1.0), spacing=1.0), UniformFibres(direction=(1.0, 0.0)), MPI.COMM_SELF
            ),
            kinematics=PlaneStress(),
            material=passive,
            active=Fibre() if strain else FibreTension(),
            supports=Supports(sliding=("left", "bottom")),
            loads=Loads(traction={"right": (self.load, 0.0)}),
            tolerance=1e-11,
        )

    def run(self, law: Any, scheme: str, step: float, steps: int) -> tuple[Array, int]:
        """λ over the steps (steps + 1,), NaN from where it fails, and the iterations of the coupling."""
        given: Any = GivenPotential(self.mechanics.body)
        model = Electromechanics(given, self.mechanics, law=law, scheme=SCHEMES[scheme])
        model.start()
        found = np.full(steps + 1, np.nan)
        found[0] = self.mechanics.fibre_stretch().mean()
        for n in range(steps):
            try:
                model.step((n + 1) * step)
            except ComputationError:
                break
            found[n + 1] = self.mechanics.fibre_stretch().mean()
        return found, model.coupling_iterations


def growth(stretch: Array) -> float | None:
    """By how much the change of λ grows from step to step at last, while it is small; None if it never is."""
    change = np.abs(np.diff(stretch))
    seen = (change[:-1] > SEEN[0]) & (change[:-1] < SEEN[1]) & (change[1:] > SEEN[0]) & (change[1:] < SEEN[1])
    ratios = change[1:][seen] / change[:-1][seen]
    return float(np.median(ratios[-3:])) if len(ratios) > 2 else None


def predicted(gain: float, scheme: str) -> float:
    """The growth of a law that answers at once with da/dλ · dλ/da = −gain.

    Staggered, z = −gain; with the stretch extrapolated by the last two, z² + 2 gain z − gain = 0.
    """
    return gain if scheme == "staggered" else gain + float(np.sqrt(gain**2 + gain))


def swings(
    law: Mapping[str, Any],
    approach: str,
    activation: float,
    at: float,
    slopes: Sequence[float],
    steps: int,
) -> Found:
    """What a strip does whose activation answers to its length, at some β, by each scheme.

    Args:
        law: The passive law.
        approach: "strain" or "stress".
        activation: γ, or the tension, at λ₀.
        at: λ₀, at which the strip is isometric before.
        slopes: β.
        steps: How many.

    Returns:
        Numbers: ``load``; ``gain``, −da/dλ · dλ/da at the equilibrium λ*, over β; by scheme, lists over
        β: ``growth``, ``predicted``; ``away``, the largest |λ − λ*| of the last three steps, infinite if it
        failed; ``iterations`` a step of the implicit scheme. Arrays: "SCHEME" (β, steps + 1), λ;
        ``equilibrium`` (β,).
    """
    strip = Strip(law, approach, activation, at)
    numbers: dict[str, Any] = {"load": strip.load}
    exact = np.array([equilibrium(strip, slope) for slope in slopes])
    arrays: dict[str, Array] = {"equilibrium": exact}
    for scheme in SCHEMES:
        found = [strip.run(Answering(activation, b, at, strip.yields), scheme, 1.0, steps) for b in slopes]
        arrays[scheme] = np.array([stretch for stretch, _ in found])
        away = np.abs(arrays[scheme][:, -3:] - exact[:, None]).max(axis=1)
        numbers[scheme] = {"away": np.where(np.isnan(away), np.inf, away).tolist()}
        if scheme == "implicit":
            numbers[scheme]["iterations"] = [iterations / steps for _, iterations in found]
        else:
            gains = [gain(strip, slope, lam) for slope, lam in zip(slopes, exact, strict=True)]
            numbers[scheme]["growth"] = [growth(stretch) for stretch, _ in found]
            numbers[scheme]["predicted"] = [predicted(one, scheme) for one in gains]
            numbers["gain"] = gains
    return Found(numbers, arrays)


def equilibrium(strip: Strip, slope: float) -> float:
    """λ at which the strip is in equilibrium with the activation that belongs to it, by the secant."""
    low, high = strip.at - 0.01, strip.at + 0.01

    def defect(lam: float) -> float:
        return strip.stretch(strip.size * (1 + slope * (lam - strip.at))) - lam

    a, b = defect(low), defect(high)
    for _ in range(30):
        if abs(b) < 1e-12 or a == b:
            break
        low, high, a = high, high - b * (high - low) / (b - a), b
        b = defect(high)
    return high


def gain(strip: Strip, slope: float, lam: float) -> float:
    """−da/dλ · dλ/da at the equilibrium."""
    a = strip.size * (1 + slope * (lam - strip.at))
    step = STEP * abs(a)
    follows = (strip.stretch(a + step) - strip.stretch(a - step)) / (2 * step)
    return float(-strip.size * slope * follows)


def steps_of_time(
    law: Mapping[str, Any],
    approach: str,
    activation: float,
    at: float,
    slope: float,
    shares: Sequence[float],
    steps: int,
) -> Found:
    """The largest stable step of a law with a time of its own, the least of one that sees the velocity.

    da/dt = (a∞(λ) − a)/τ grows by e − (1 − e) k a step, e = exp(−Δt/τ), k its gain: stable for
    Δt < τ ln((k + 1)/(k − 1)), and always for k ≤ 1. a = a₀ (1 + c dλ/dt), with κ = −a₀ c (dλ/da)/Δt, grows
    by (κ + √(κ² + 4κ))/2: stable for κ < 1/2, a step that is *longer* than 2 a₀ c |dλ/da|.

    Args:
        law: The passive law.
        approach: "strain" or "stress".
        activation: γ, or the tension, at λ₀.
        at: λ₀, at which the strip is isometric before.
        slope: β of the law with a time, and c/τ of the other one.
        shares: Steps, over the bounds; over τ for a law that is always stable.
        steps: How many.

    Returns:
        Numbers by law, "lagging" and "velocity": ``bound`` over τ, None where there is none; lists over the
        shares, ``step`` over τ, ``growth`` and ``predicted``. Arrays: "LAW" (shares, steps + 1), λ.
    """
    strip = Strip(law, approach, activation, at)
    lam = equilibrium(strip, slope)
    k, still = gain(strip, slope, lam), equilibrium(strip, 0.0)
    instant = gain(strip, slope, still)
    lagging = float(np.log((k + 1) / (k - 1))) if k > 1 else None
    bounds = {"lagging": lagging, "velocity": 2 * instant}

    def lag(step: float) -> float:
        left = np.exp(-step)
        return float(abs(left - (1 - left) * k))

    def velocity(step: float) -> float:
        kappa = instant / step
        return float((kappa + np.sqrt(kappa**2 + 4 * kappa)) / 2)

    laws: dict[str, tuple[Any, Any]] = {
        "lagging": (Lagging(activation, slope, at, strip.yields), lag),
        "velocity": (Shortening(activation, slope, at, strip.yields), velocity),
    }
    numbers: dict[str, Any] = {"gain": k}
    arrays: dict[str, Array] = {}
    for name, (one, expected) in laws.items():
        lengths = [share * (bounds[name] or 1.0) for share in shares]
        found = np.array([strip.run(one, "staggered", step, steps)[0] for step in lengths])
        numbers[name] = {
            "bound": bounds[name],
            "step": lengths,
            "growth": [growth(stretch) for stretch in found],
            "predicted": [expected(step) for step in lengths],
        }
        arrays[name] = found
    return Found(numbers, arrays)


def rossi(law: Mapping[str, Any], gamma: float, at: float, step: float, steps: int) -> Found:
    """The law of Rossi et al. at a calcium that stays, one pass a step: its gain and what the strip does.

    Args:
        law: The passive law.
        gamma: γ in its equilibrium at λ₀.
        at: λ₀.
        step: Length of the steps, ms.
        steps: How many.

    Returns:
        Numbers: ``calcium``, μM; ``gain``, −dγ∞/dλ · dλ/dγ at λ₀; ``moved``, by scheme, the largest change of
        λ in the last three steps. Arrays: ``staggered`` and ``second-order`` (steps + 1,), λ.
    """
    strip, contraction = Strip(law, "strain", gamma, at), Rossi2014()
    calcium = calcium_for(contraction, gamma, at)
    low, high = contraction.equilibrium(np.full(2, calcium), np.array([at - STEP, at + STEP]))
    follows = (strip.stretch(gamma + STEP) - strip.stretch(gamma - STEP)) / (2 * STEP)
    clamped = Clamped(contraction, calcium, gamma)
    arrays = {name: strip.run(clamped, name, step, steps)[0] for name in ("staggered", "second-order")}
    moved = {name: float(np.abs(np.diff(found[-4:])).max()) for name, found in arrays.items()}
    gained = float(-(high - low) / (2 * STEP) * follows)
    return Found({"calcium": calcium, "gain": gained, "moved": moved}, arrays)
