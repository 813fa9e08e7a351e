"""The pulse on the rigid line and on models of the contracting one, over meshes, steps and schemes."""

from __future__ import annotations

from myostrain.reproduce.jobs import Job
from myostrain.reproduce.measurements.lines import pulse_job

#: Models of the line by a name for the numbers: what the page calls them, and their keys.
RIGID = "rigid"
READINGS = {
    "conservative": ("conservative, as printed in (4.6)–(4.7)", ()),
    "advective": ("advective balance, J ∂v/∂t", ("potential.balance=advective",)),
    "viscous": ("viscoelastic line, λ = 0.4 τ", ("mechanics.relaxation_time=0.08",)),
}
SWEEP = {"beta_02": "activation.beta=0.2", "beta_01": "activation.beta=0.1"}
STRIPS = {"plane_strain": "plane-strain", "plane_stress": "plane-stress"}
STRIP = (
    'geometry={kind="rectangle", size=[180.0, 1.0], spacing=1.0}',
    "fibres={direction=[1.0, 0.0]}",
    "initial.center=[0.0, 0.0]",
    "material.model=NeoHookean",
    "mechanics.fixed=[]",
    "time.end=2.6",
    "probes={a=[80.0, 0.0], b=[130.0, 0.0]}",
)
SPACINGS = (1.0, 0.5, 0.25)
QUICK_STEP, STEP = 4e-3, 1e-3
SECONDS = {1.0: 9.0, 0.5: 11.0, 0.25: 18.0}


def jobs(quick: bool) -> dict[str, Job]:
    """The computations, to t = 5."""
    step = QUICK_STEP if quick else STEP

    def pulse(row: str, *more: str, cost: float) -> Job:
        settings = () if row == RIGID else READINGS[row][1] if row in READINGS else (SWEEP[row],)
        case = "pulse-1d-rigid" if row == RIGID else "pulse-1d"
        return pulse_job(case, (*settings, *more, "output.rigid_twin=false"), cost=cost)

    def line(row: str, spacing: float, step: float) -> Job:
        cost = SECONDS[spacing] * STEP / step * (0.6 if row == RIGID else 1.0)
        return pulse(row, f"geometry.spacing={spacing}", f"time.step={step}", cost=cost)

    wanted = {row: line(row, 1.0, step) for row in (RIGID, *READINGS, *SWEEP)}
    if quick:
        return wanted
    for spacing in SPACINGS[1:]:
        wanted |= {f"{row}, Δx = {spacing}": line(row, spacing, step) for row in (RIGID, *READINGS)}
    for row, seconds in ((RIGID, 15.0), ("conservative", 30.0)):
        wanted[f"{row}, Δt = 5e-4"] = line(row, 1.0, 5e-4)
        wanted[f"{row}, implicit"] = pulse(row, "time.scheme=implicit", cost=seconds)
    for row, kinematics in STRIPS.items():
        settings = (*STRIP, f"mechanics.kinematics={kinematics}", "output.rigid_twin=false")
        wanted[row] = pulse_job("pulse-1d", settings, cost=10.0)
    return wanted
