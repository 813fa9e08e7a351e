"""The bump on the paper's mesh and on fine ones, coupled and held, and the least heights that fire."""

from __future__ import annotations

from myostrain.reproduce.chapters.settings import HELD
from myostrain.reproduce.jobs import Job
from myostrain.reproduce.measurements.cases import resolved
from myostrain.reproduce.measurements.lines import pulse_job

END = 0.6
#: Times at which the fields are kept.
FRAMES = [round(0.01 * k, 2) for k in range(1, 60)]
KINDS = {"coupled": (), "held": (HELD,)}
#: Bumps on the fine mesh, by names for the numbers: half-width and potential.
PRINTED, SAMPLED, WIDE = (1.0, 0.6), (1.5, 0.6), (2.0, 0.4)
#: Of these the least potential that fires is looked for.
THRESHOLDS = ("sampled", "wide")


def meshes(quick: bool) -> tuple[int, ...]:
    """Cells a unit of length, of the sequence of meshes with the bump by nodes."""
    return (2, 4) if quick else (1, 2, 4, 8)


def bumps(quick: bool) -> dict[str, tuple[float, float]]:
    """The bumps on the fine mesh."""
    made = {"printed": PRINTED, "sampled": SAMPLED}
    return made if quick else made | {"wide": WIDE}


def fine(quick: bool) -> tuple[int, float]:
    """Cells a unit of length, and time step, of the fine mesh."""
    return (4, 1e-3) if quick else (8, 2.5e-4)


def jobs(quick: bool) -> dict[str, Job]:
    """The computations."""
    cells, step = fine(quick)
    second, own_step = "time.scheme=second-order", f"time.step={step}"
    wanted: dict[str, Job] = {}

    def add(name: str, *settings: str, cost: float = 2e-3 * END / step) -> None:
        for kind, held in KINDS.items():
            wanted[f"{name}, {kind}"] = pulse_job(
                "startup-1d", (*settings, *held, f"time.end={END}"), frames=FRAMES, cost=cost
            )

    def bump(radius: float) -> tuple[str, ...]:
        """A fine mesh that has the bump's width right: the node at its edge takes a share."""
        return (
            second,
            f"geometry.spacing={1 / cells}",
            f"initial.radius={radius}",
            'initial.sampling="mean"',
        )

    add("paper", cost=4.0)
    add("one", "initial.radius=0.5", cost=4.0)
    for n in meshes(quick):
        add(f"1/{n}", second, own_step, f"geometry.spacing={1 / n}")
    for name, (radius, potential) in bumps(quick).items():
        add(name, *bump(radius), f"initial.potential={potential}", own_step)
    if not quick:
        bisection = {"shape": "step", "low": 0.3, "high": 0.8, "tolerance": 1e-3}
        for name in THRESHOLDS:
            for kind, held in KINDS.items():
                case = resolved("startup-1d", (*bump(bumps(quick)[name][0]), "time.step=5e-4", *held))
                wanted[f"threshold {name}, {kind}"] = Job(
                    "startup.threshold", {"case": case, **bisection}, 14.0
                )
    return wanted
