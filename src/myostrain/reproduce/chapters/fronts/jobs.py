"""Homogeneous states, fronts over α and β, orders, a front of a bump, and the search for fronts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from myostrain.reproduce.chapters.settings import ADVECTIVE, RIGID
from myostrain.reproduce.jobs import Job
from myostrain.reproduce.measurements.cases import case_job, resolved
from myostrain.theory import speed, steepness

import numpy as np

MODELS = {"rigid": [RIGID], "conservative": [], "advective": [ADVECTIVE]}
ALPHA, TAU, BETA, RATE = 0.1, 0.2, 0.3, 100.0
#: Equilibria v without recovery, and with it: v (v − α)(v − 1) + τ v = 0.
EQUILIBRIA = {"without_recovery": (0.0, ALPHA, 1.0), "with_recovery": (0.0, 0.5, 0.6)}
#: β at which the limit of small strain is taken, from large to small.
SMALL = (0.02, 0.01)
#: h of the runs for the order in the time step.
COARSE = 0.5
SCHEMES = ("second-order", "staggered", "implicit")
#: α and β of the search for fronts of any shape.
SEARCH = {
    0.9: (0.3, 0.45, 0.5, 0.52, 0.54, 0.55, 0.56, 0.58, 0.6, 0.7, 0.8, 0.9),
    0.7: (0.3, 0.5, 0.6, 0.65, 0.7, 0.705, 0.72, 0.73, 0.75, 0.8, 0.9),
}
FASTEST = 12.0


@dataclass(frozen=True)
class Settings:
    """Mesh, step and extent of the sweeps: α and β, of which all pairs are run and ``more`` beside them."""

    spacing: float
    step: float
    alphas: tuple[float, ...]
    betas: tuple[float, ...]
    more: tuple[tuple[float, float], ...]
    advective: tuple[tuple[float, float], ...]
    spacings: tuple[float, ...]
    steps: tuple[float, ...]
    implicit_steps: tuple[float, ...]
    bump: tuple[float, float]

    @property
    def fronts(self) -> list[tuple[float, float]]:
        """(α, β) with the conservative balance."""
        return [*((a, b) for a in self.alphas for b in self.betas), *self.more]

    def steps_of(self, scheme: str) -> tuple[float, ...]:
        """Time steps for the order of a scheme, each half of the one before."""
        return self.implicit_steps if scheme == "implicit" else self.steps


QUICK = Settings(
    spacing=0.25,
    step=2e-3,
    alphas=(0.1, 0.3, 0.7, 0.9),
    betas=(0.0, 0.15, 0.3),
    more=((0.1, 0.45), (0.9, 0.45)),
    advective=((0.1, 0.3), (0.1, 0.8), (0.3, 0.3), (0.7, 0.3)),
    spacings=(1.0, 0.5, 0.25),
    steps=(4e-3, 2e-3, 1e-3),
    implicit_steps=(8e-3, 4e-3, 2e-3),
    bump=(0.5, 2e-3),
)
FULL = Settings(
    spacing=0.125,
    step=5e-4,
    alphas=(0.1, 0.2, 0.3, 0.4, 0.7, 0.9),
    betas=(0.0, 0.075, 0.15, 0.225, 0.3, 0.375, 0.45),
    more=((0.9, 0.48), (0.95, 0.48)),
    advective=tuple((a, b) for a in (0.1, 0.3, 0.7) for b in (0.15, 0.3, 0.45, 0.6, 0.8)),
    spacings=(1.0, 0.5, 0.25, 0.125),
    steps=(4e-3, 2e-3, 1e-3, 5e-4),
    implicit_steps=(4e-3, 2e-3, 1e-3, 5e-4),
    bump=(0.25, 1e-3),
)


def settings(quick: bool) -> Settings:
    """The settings."""
    return QUICK if quick else FULL


def name(alpha: float, beta: float, balance: str = "conservative") -> str:
    """What the job of a front is called."""
    return f"{balance}_alpha_{alpha * 100:.0f}_beta_{beta * 1000:.0f}"


def front(
    alpha: float,
    beta: float,
    spacing: float,
    step: float,
    *,
    balance: str = "conservative",
    scheme: str = "second-order",
    rate: float = RATE,
) -> Job:
    """A front as in the paper, over a time of 20/A (12/A for β > 0.4), with A = D = ``rate``.

    The line is so long that v is within exp(−10) of its limits at both ends.
    """
    end = (20 if beta < 0.4 else 12) / rate
    theory = {"diffusivity": rate, "A": rate, "balance": balance}
    a = float(np.asarray(steepness(alpha, beta, **theory)))  # type: ignore[arg-type]
    to_the_left = float(np.asarray(speed(alpha, beta, **theory))) * end  # type: ignore[arg-type]
    start = 10 / a + max(0.0, to_the_left)
    case = resolved(
        "front-1d",
        [
            f"cell.alpha={alpha}",
            f"cell.A={rate}",
            f"potential.diffusivity={rate}",
            f"potential.balance={balance}",
            f"activation.beta={beta}",
            f"geometry.length={np.ceil(start + 10 / a / (1 - beta) + max(0.0, -to_the_left))}",
            f"geometry.spacing={spacing}",
            f"time.step={step * RATE / rate}",
            f"time.end={end}",
            f"time.scheme={scheme}",
            "probes={middle=[10.0]}",
        ],
    )
    iterated = 1.0 if beta < 0.4 or balance == "advective" else 12.0
    if scheme == "implicit":
        iterated = 6.0
    cost = 0.2 + end * rate / RATE / step * 1.2e-3 * iterated * (1 + 0.01 / spacing)
    return Job("fronts.travel", {"case": case, "start": start}, round(cost, 1))


def jobs(quick: bool) -> dict[str, Job]:
    """The computations."""
    s = settings(quick)
    made = _homogeneous()
    for alpha, beta in s.fronts:
        made[name(alpha, beta)] = front(alpha, beta, s.spacing, s.step)
    for alpha, beta in s.advective:
        made[name(alpha, beta, "advective")] = front(alpha, beta, s.spacing, s.step, balance="advective")
    for beta in SMALL:
        made[name(ALPHA, beta)] = front(ALPHA, beta, s.spacing, s.step)
    made["unit_A"] = front(ALPHA, BETA, s.spacing, s.step, rate=1.0)
    made |= {mesh(h): front(ALPHA, BETA, h, s.step) for h in s.spacings}
    for scheme in SCHEMES:
        for number, step in enumerate(s.steps_of(scheme)):
            made[stepped(scheme, number)] = front(ALPHA, BETA, COARSE, step, scheme=scheme)
    spacing, step = s.bump
    made["bump"] = case_job("front-1d", [*BUMP, f"geometry.spacing={spacing}", f"time.step={step}"], cost=2.0)
    for alpha, betas in SEARCH.items():
        parameters = {"alpha": alpha, "betas": list(betas), "fastest": FASTEST, "speeds": 241, "points": 1000}
        made[f"search_alpha_{alpha * 100:.0f}"] = Job("fronts.shooting", parameters, 0.7)
    for balance in ("conservative", "advective"):
        case = resolved("front-1d", ["activation.beta=0.5", f"potential.balance={balance}"])
        made[f"refused_{balance}"] = Job("fronts.refusal", {"case": case}, 0.1)
    return made


BUMP = ("geometry.length=120.0", "probes={a=[50.0], b=[100.0]}", "time.end=1.75")


def mesh(spacing: float) -> str:
    """The job of the order in h."""
    return f"spacing_{spacing * 1000:.0f}"


def stepped(scheme: str, number: int) -> str:
    """The job of the order in the time step."""
    return f"{scheme}_{number}"


def _homogeneous() -> dict[str, Job]:
    """Four cells, solved to round-off."""
    tiny = (
        "geometry.length=4.0",
        "probes={middle=[2.0]}",
        "mechanics.tolerance=1e-13",
        "solver.potential={ksp_rtol=1e-14}",
    )
    made = {}
    for model, setting in MODELS.items():
        for kind, potentials in EQUILIBRIA.items():
            recovery = "true" if kind == "with_recovery" else "false"
            parameters = {
                "case": resolved(
                    "front-1d", [*tiny, f"cell.recovery={recovery}", f"cell.tau={TAU}", *setting]
                ),
                "potentials": list(potentials),
                "drift": [2e-3, 0.1],
                "growth": [1e-4, 1e-3, 1e-4],
            }
            made[f"{kind}_{model}"] = Job("fronts.homogeneous", parameters, 0.6)
        made[f"temporal_variation_{model}"] = Job(
            "fronts.temporal_variation", _small_step(tiny, setting), 0.5
        )
        spread: Sequence[str] = (
            "geometry.length=20.0",
            "geometry.spacing=0.25",
            "cell.A=0.0",
            "time.end=0.05",
        )
        cosine = {"case": resolved("front-1d", [*tiny, *spread, *setting]), "potential": 0.5, "size": 1e-3}
        made[f"spreading_{model}"] = Job("fronts.spreading", cosine, 0.3)
    return made


def _small_step(tiny: Sequence[str], setting: Sequence[str]) -> dict[str, object]:
    implicit = ('time.scheme="implicit"', "time.tolerance=1e-13")
    states = np.round(np.linspace(-0.1, 1.1, 24), 12).tolist()  # none of them an equilibrium
    return {"case": resolved("front-1d", [*tiny, *implicit, *setting]), "potentials": states, "step": 1e-6}
