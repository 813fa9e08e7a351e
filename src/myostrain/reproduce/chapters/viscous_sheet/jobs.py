"""A sheet for each λ, one whose activation stops at rest, the free block, and random motions."""

from __future__ import annotations

from myostrain.reproduce.jobs import Job
from myostrain.reproduce.measurements.cases import resolved

TAU = 0.2
#: λ/τ of the sheets; the last one is all but rigid.
SHARES = (0.0, 0.1, 0.4, 1.0, 5.0, 50.0)
#: λ/τ of the sheet that does not stretch below rest.
RECTIFIED = 5.0
KINEMATICS = ("plane-stress", "plane-strain")
#: Contractions of the free block, and its λ.
SIZES = (0.3, 0.02, 0.01)
BLOCK = 0.7


def jobs(quick: bool) -> dict[str, Job]:
    """The computations."""
    mesh = ["geometry.spacing=3.0", "time.step=6e-3"] if quick else []
    # A dashpot remembers what each step leaves over: with the case's tolerance, 1e-5, the duration of the
    # shortening at λ = 5 τ is 4 % off.
    mesh.append("mechanics.tolerance=1e-8")
    cost = 3.0 if quick else 20.0

    def sheet(share: float, rectified: bool = False) -> Job:
        case = resolved("sheet-2d", [*mesh, f"mechanics.relaxation_time={share * TAU}"])
        return Job("viscous.wave", {"case": case, "probe": "centre", "rectified": rectified}, cost)

    block = {"relaxation_time": BLOCK, "steps": 100 if quick else 400}
    samples = {"samples": 2000, "seed": 1, "relaxation_time": 0.3, "mu": 2.0}
    return {
        **{f"sheet {share}": sheet(share) for share in SHARES},
        "rectified": sheet(RECTIFIED, rectified=True),
        **{
            f"{k} {size}": Job("viscous.free_block", {"kinematics": k, "size": size, **block})
            for k in KINEMATICS
            for size in SIZES
        },
        "motions": Job("viscous.dissipation", samples, 0.5),
    }
