"""Runs of ``sheet-2d``, as it is or coarser, and of lines and strips to compare with."""

from __future__ import annotations

from myostrain.reproduce.chapters.settings import RIGID
from myostrain.reproduce.jobs import Job
from myostrain.reproduce.measurements.cases import resolved
from myostrain.reproduce.measurements.sheets import sheet_job

#: On the line through the bump's middle (95, 25) along (−1, 1), 30, 60 and 90 from it: the fibres' direction,
#: or that across them where the fibres are turned. Then three places that the pulse has passed at t = 3.
PROBES = (
    "probes={out30=[73.787, 46.213], out60=[52.574, 67.426], out90=[31.36, 88.64], "
    "centre=[65.0, 90.0], left=[20.0, 90.0], right=[110.0, 90.0]}"
)
STRAIN = ("mechanics.kinematics=plane-strain", "mechanics.every=10")
TURNED = "fibres.direction=[1.0, 1.0]"
RATIO_4 = "potential.diffusivity=[100.0, 25.0]"
ELASTIC = "mechanics.constraint=elastic"
#: A free strip along the fibres: the sheet's own equations in one dimension.
STRIP = (
    'geometry={kind="rectangle", size=[160.0, 2.0], spacing=1.0}',
    "fibres.direction=[1.0, 0.0]",
    "initial.center=[0.0, 1.0]",
    "mechanics.robin=0.0",
    "probes={a=[60.0, 1.0], b=[120.0, 1.0]}",
    "time.end=2.7",
)
LINE = ("geometry.length=160.0", "time.step=3e-3", "probes={a=[60.0], b=[120.0]}", "time.end=2.7")


def jobs(quick: bool) -> dict[str, Job]:
    """The computations."""
    step = "time.step=7.5e-3" if quick else "time.step=3e-3"
    own = ("geometry.spacing=2.6", step, PROBES) if quick else (step, PROBES)
    fine = ("geometry.spacing=2.0", step, PROBES) if quick else (step, PROBES)
    more = 1 if quick else 6  # times the cost

    def sheet(cost: float, *overrides: str) -> Job:
        return sheet_job("sheet-2d", overrides, cost=cost * more)

    found = {
        "mesh": Job("sheets.mesh", {"case": resolved("sheet-2d")}, 1),
        "start": Job(
            "sheets.start",
            {"case": resolved("sheet-2d", [*own, "time.step=2e-3", "time.end=0.62"])},
            2.5 * more,
        ),
        "rigid": sheet(1.5, *own, RIGID),
        "stress": sheet(2.5, *own),
        "strain": sheet(5, *own, *STRAIN),
        "stress turned": sheet(2.5, *own, TURNED),
        "strain turned": sheet(5, *own, *STRAIN, TURNED),
        "rigid ratio 4": sheet(2, *fine, RIGID, RATIO_4),
        "stress ratio 4": sheet(4, *fine, RATIO_4),
        "strain ratio 4": sheet(7, *fine, *STRAIN, RATIO_4),
        "stress elastic": sheet(4, *own, ELASTIC),
        "strain elastic": sheet(9, *own, STRAIN[0], ELASTIC),  # there J follows v: mechanics more often
        "line rigid": sheet_job("pulse-1d-rigid", LINE, cost=2),
        "line": sheet_job("pulse-1d", LINE, cost=3),
        "strip rigid": sheet_job("sheet-2d", [*STRIP, step, RIGID], cost=1.5),
        "strip stress": sheet_job("sheet-2d", [*STRIP, step], cost=2),
        "strip strain": sheet_job("sheet-2d", [*STRIP, step, STRAIN[0]], cost=4),
    }
    if not quick:
        finer = ("geometry.spacing=0.8", "time.step=2e-3", PROBES)
        found |= {
            "rigid finer": sheet(5, *finer, RIGID),
            "stress finer": sheet(10, *finer),
            "rigid ratio 4 finer": sheet(5, *finer, RIGID, RATIO_4),
        }
    return found
