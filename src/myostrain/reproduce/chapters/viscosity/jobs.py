"""The pulse of figure 1 over the relaxation time, and its two limits."""

from __future__ import annotations

from myostrain.reproduce.jobs import Job
from myostrain.reproduce.measurements.lines import pulse_job

TAU = 0.2
#: λ/τ of the sweep.
QUICK_PARTS = (1e-3, 0.1, 0.25, 0.5, 0.7, 1.0, 3.0, 10.0, 1e3)
PARTS = (1e-3, 0.01, 0.03, 0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0, 2.0, 3.0, 10.0, 100.0, 1e3)
#: Time steps at which the least λ, 2 × 10⁻⁴, is run, and seconds that it takes.
STIFF_STEPS = {1e-3: 3.0, 1e-4: 30.0}
#: Mesh and step: of the quick settings, and of the full ones.
GRID = {
    True: ("geometry.spacing=1.0", "time.step=4e-3", "geometry.length=180.0", "time.end=2.6",
           "probes={a=[60.0], b=[100.0]}"),
    False: ("geometry.spacing=0.5", "time.step=1e-3"),
}  # fmt: skip
#: A short line, to see what a time step far above λ does.
SHORT = ("geometry.length=120.0", "time.end=1.6", "probes={a=[40.0], b=[80.0]}")


def parts(quick: bool) -> tuple[float, ...]:
    """λ/τ of the sweep."""
    return QUICK_PARTS if quick else PARTS


def watched(quick: bool) -> float:
    """X of the place where potential and shortening are watched over time."""
    return 60.0 if quick else 100.0


def jobs(quick: bool) -> dict[str, Job]:
    """The computations: the two limits, and the sweep."""
    cost, watch = 2.0 if quick else 12.0, watched(quick)

    def line(part: float, *settings: str, cost: float, watch: float | None = watch) -> Job:
        viscous = [f"mechanics.relaxation_time={part * TAU:.6g}"] if part else []
        return pulse_job("pulse-1d", (*settings, *viscous, "output.rigid_twin=false"), watch=watch, cost=cost)

    wanted = {
        "rigid": pulse_job("pulse-1d-rigid", GRID[quick], watch=watch, cost=0.6 * cost),
        "elastic": line(0.0, *GRID[quick], cost=cost),
        **{f"{part:g}": line(part, *GRID[quick], cost=cost) for part in parts(quick)},
    }
    if not quick:
        for step, seconds in STIFF_STEPS.items():
            grid = (*SHORT, f"time.step={step}")
            wanted[f"stiffest, Δt = {step}"] = line(PARTS[0], *grid, cost=seconds, watch=None)
    return wanted
