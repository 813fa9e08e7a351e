"""Section 7: the contracting sheet of figure 3."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.reproduce.chapters import figure_3_pictures as pictures
from myostrain.reproduce.chapters import figure_3_text as text
from myostrain.reproduce.content import Chapter, Statement, Table
from myostrain.reproduce.jobs import Found, Job
from myostrain.reproduce.measurements.cases import resolved
from myostrain.reproduce.measurements.sheets import sheet_job
from myostrain.reproduce.verdict import Numbers, claims

import numpy as np

TITLE = "A pulse on a contracting sheet: figure 3 (section 7)"

#: On the line through the bump's middle (95, 25) along (−1, 1), 30, 60 and 90 from it: the fibres' direction,
#: or that across them where the fibres are turned. Then three places that the pulse has passed at t = 3.
PROBES = (
    "probes={out30=[73.787, 46.213], out60=[52.574, 67.426], out90=[31.36, 88.64], "
    "centre=[65.0, 90.0], left=[20.0, 90.0], right=[110.0, 90.0]}"
)
RIGID = "mechanics.imposed_stretch={value=1.0, until=inf}"
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

#: Probes at which pulses are compared: settled, and passed at t = 3 whatever the diffusivity.
PULSES = ("out60", "centre", "left", "right")


def jobs(quick: bool) -> dict[str, Job]:
    """Runs of ``sheet-2d``, as it is or coarser, and of lines and strips to compare with."""
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


def chapter(found: Mapping[str, Found], quick: bool) -> Chapter:
    """The chapter."""
    numbers = measured(found)
    said = text.Words(numbers, quick)
    return Chapter(
        introduction=said.introduction(),
        statements=_statements(numbers, said),
        tables=_tables(numbers, said),
        pictures=pictures.all_pictures(found, said),
        differences=said.differences(),
        numbers=numbers,
        remarks=said.remarks(),
    )


def measured(found: Mapping[str, Found]) -> dict[str, Any]:
    """Every number of the chapter, nested by subject."""
    runs = {name: outcome.numbers for name, outcome in found.items() if "pulses" in outcome.numbers}
    numbers: dict[str, Any] = {
        "mesh": found["mesh"].numbers,
        "start": found["start"].numbers,
        "runs": runs,
        "celerity": _celerities(runs),
        "like_1d": {
            "coupled line (4.6)": _alike(runs["stress"], runs["line"]),
            "rigid sheet, rigid line": _alike(runs["rigid"], runs["line rigid"]),
            "plane stress, free strip": _alike(runs["stress"], runs["strip stress"]),
            "plane strain, free strip": _alike(runs["strain"], runs["strip strain"]),
        },
        "isotropy": {k: _isotropy(runs[k], runs[f"{k} ratio 4"]) for k in ("stress", "strain", "rigid")},
        "fixed_domain": {k: _difference(found["rigid"], found[k]) for k in ("stress", "strain")},
        "constraint": {k: _constraint(runs[k], runs[f"{k} elastic"]) for k in ("stress", "strain")},
        "weak_form": {"printed": growth_rates(-1, -1), "signs of (7.2)": growth_rates(1, 1)},
        "circular": _circular(found["rigid"]),
    }
    if "stress finer" in runs:
        numbers["convergence"] = {
            k: _convergence(runs[k], runs[f"{k} finer"]) for k in ("rigid", "stress", "rigid ratio 4")
        }
    return numbers


def _outward(run: Mapping[str, Any]) -> float:
    """Celerity from 30 to 90 away from the bump's middle."""
    return 60.0 / (run["pulses"]["out90"]["activation"] - run["pulses"]["out30"]["activation"])


def _celerities(runs: Mapping[str, Any]) -> dict[str, Any]:
    rigid = _outward(runs["rigid"])
    found: dict[str, Any] = {"rigid": rigid}
    for kind in ("stress", "strain"):
        along, across = _outward(runs[kind]), _outward(runs[f"{kind} turned"])
        fits, fixed = runs[kind]["celerity"], runs["rigid"]["celerity"]
        X = {at: runs[kind]["steepness"][f"along_{at}"] for at in "Xx"}
        found[kind] = {
            "along": along,
            "across": across,
            "along_ratio": along / rigid,
            "across_ratio": across / rigid,
            "along_ratio_fitted": fits["along"] / fixed["along"],
            "across_ratio_fitted": fits["across"] / fixed["across"],
            "steepness_ratio_X": X["X"] / runs["rigid"]["steepness"]["along_X"],
            "steepness_ratio_x": X["x"] / runs["rigid"]["steepness"]["along_x"],
        }
    for kind in ("rigid", "stress", "strain"):
        fits = runs[f"{kind} ratio 4"]["celerity"]
        found[f"{kind} ratio 4"] = {**fits, "ratio": fits["across"] / fits["along"]}
    strips = {
        kind: 60.0 / (runs[kind]["pulses"]["b"]["activation"] - runs[kind]["pulses"]["a"]["activation"])
        for kind in ("line rigid", "line", "strip rigid", "strip stress", "strip strain")
    }
    return found | {"one_dimension": strips}


def _alike(sheet: Mapping[str, Any], line: Mapping[str, Any]) -> dict[str, float]:
    """A pulse at the sheet's centre against a line's, and celerities."""
    here, there = sheet["pulses"]["centre"], line["pulses"]["a"]
    height = there["maximum"] - there["minimum"]
    celerity = 60.0 / (line["pulses"]["b"]["activation"] - there["activation"])
    return {
        "peak": (here["maximum"] - there["maximum"]) / height,
        "trough": (here["minimum"] - there["minimum"]) / height,
        "duration": here["duration"] / there["duration"],
        "celerity": _outward(sheet) / celerity,
    }


def _isotropy(isotropic: Mapping[str, Any], ratio_4: Mapping[str, Any]) -> dict[str, float | None]:
    pairs = [(isotropic["pulses"][name], ratio_4["pulses"][name]) for name in PULSES]
    heights = [a["maximum"] - a["minimum"] for a, _ in pairs]
    found: dict[str, float | None] = {
        "height": max(
            abs(b[key] - a[key]) / height
            for (a, b), height in zip(pairs, heights, strict=True)
            for key in ("maximum", "minimum")
        ),
        "duration": max(abs(b["duration"] / a["duration"] - 1) for a, b in pairs),
    }
    one, other = isotropic["largest"], ratio_4["largest"]
    if one["displacement"] > 0:
        found |= {key: other[key] / one[key] for key in ("displacement", "strain")}
        found["stress"] = (other["stress_high"] - other["stress_low"]) / (
            one["stress_high"] - one["stress_low"]
        )
    return found


def _difference(rigid: Found, coupled: Found) -> float:
    """Relative mean-square difference of v at t = 3, at the same material points."""
    weight, v = coupled.arrays["weight"], coupled.arrays["potential"]
    return float(np.sqrt(weight @ (rigid.arrays["potential"] - v) ** 2 / (weight @ v**2)))


def _constraint(total: Mapping[str, Any], elastic: Mapping[str, Any]) -> dict[str, float]:
    return {
        "volume_J": total["volume"]["change"],
        "worst_triangle_J": total["volume"]["cell_error"],
        "volume_Fe": elastic["volume"]["change"],
        "volume_Fe_wanted": elastic["volume"]["wanted"],
        "celerity_ratio": _outward(elastic) / _outward(total),
    }


def _circular(rigid: Found) -> float:
    """How far arrival is from a function of the distance from the bump alone, relative to the latest one."""
    X, T = rigid.arrays["X"], rigid.arrays["activation"]
    r = np.linalg.norm(X - [95.0, 25.0], axis=1)
    known = ~np.isnan(T) & (r > 30)
    left = T[known] - np.polynomial.Polynomial.fit(r[known], T[known], 3)(r[known])
    return float(np.sqrt(np.mean(left**2)) / T[known].max())


def _convergence(run: Mapping[str, Any], finer: Mapping[str, Any]) -> dict[str, float]:
    """Changes from the chapter's settings to the finer ones, relative."""
    found = {
        "celerity": _outward(run) / _outward(finer) - 1,
        "across_over_along": (run["celerity"]["across"] / run["celerity"]["along"])
        / (finer["celerity"]["across"] / finer["celerity"]["along"])
        - 1,
        "duration": run["pulses"]["centre"]["duration"] / finer["pulses"]["centre"]["duration"] - 1,
        "peak": run["pulses"]["centre"]["maximum"] / finer["pulses"]["centre"]["maximum"] - 1,
    }
    if finer["largest"]["displacement"] > 0:
        keys = ("displacement", "strain", "stress_low", "stress_high")
        found |= {key: run["largest"][key] / finer["largest"][key] - 1 for key in keys}
        shares = [r["relevance"]["tenth"]["displacement_share"] for r in (run, finer)]
        found["displacement_share"] = shares[0] / shares[1] - 1
    return found


def growth_rates(diffusion: int, recovery: int) -> dict[str, float]:
    """Growth rates of small disturbances of rest, for signs (1 as in (7.2)) of diffusion and recovery.

    Linearised at v = w = 0, with D = A = 100, α = 0.1, τ = 0.2: ∂v/∂t = −(± D k² + A α) v ∓ A w and
    ∂w/∂t = v − w/τ.

    Returns:
        The largest real part of an eigenvalue: ``uniform`` for k = 0, ``wave`` for the wavelength 10.
    """
    D = A = 100.0
    k = 2 * np.pi / 10

    def rate(square: float) -> float:
        matrix = [[-diffusion * D * square - A * 0.1, -recovery * A], [1.0, -1 / 0.2]]
        return float(np.linalg.eigvals(matrix).real.max())

    return {"uniform": rate(0.0), "wave": rate(k**2)}


def _statements(numbers: Mapping[str, Any], said: text.Words) -> list[Statement]:
    celerity, runs = numbers["celerity"], numbers["runs"]
    kinds = {"plane stress": "stress", "plane strain": "strain"}
    shares: dict[str, Numbers] = {
        f"{what}, {name}": {"share": runs[kind]["relevance"]["tenth"][f"{what}_share"]}
        for what in ("displacement", "strain")
        for name, kind in kinds.items()
    }
    stretch = {name: runs[kind]["stretch"] for name, kind in kinds.items()}
    start = numbers["start"]
    readings: dict[str, dict[str, Numbers]] = {
        "mesh": {"our egg": numbers["mesh"]},
        "few-steps": {
            "front and back": {"steps": _in_steps(start["back"])},
            "the front alone": {"steps": _in_steps(start["grows"])},
        },
        "like-one-dimension": {
            "plane stress against the coupled line (4.6)": numbers["like_1d"]["coupled line (4.6)"],
            "plane stress against a free strip of the same equations": numbers["like_1d"][
                "plane stress, free strip"
            ],
            "plane strain against a free strip of the same equations": numbers["like_1d"][
                "plane strain, free strip"
            ],
            "the rigid sheet against the rigid line": numbers["like_1d"]["rigid sheet, rigid line"],
        },
        "isotropy-potential": {name: numbers["isotropy"][kind] for name, kind in kinds.items()},
        "isotropy-mechanics": {name: numbers["isotropy"][kind] for name, kind in kinds.items()},
        "half": {
            name: {"ratio": celerity[f"{kind} ratio 4"]["ratio"]}
            for name, kind in {**kinds, "rigid body": "rigid"}.items()
        },
        "faster-along": {n: {"ratio": celerity[k]["along_ratio"]} for n, k in kinds.items()},
        "faster-across": {n: {"ratio": celerity[k]["across_ratio"]} for n, k in kinds.items()},
        "steeper": {
            f"{n}, {name}": {"ratio": celerity[k][f"steepness_ratio_{at}"]}
            for at, name in (("X", "material X"), ("x", "spatial x"))
            for n, k in kinds.items()
        },
        "fixed-domain": {n: {"difference": numbers["fixed_domain"][k]} for n, k in kinds.items()},
        "relevant-displacement": shares,
        "fibres-contract": {
            name: {"along_fibres": s["fibre"], "across_fibres": s["cross"]} for name, s in stretch.items()
        },
        "incompressible": {name: numbers["constraint"][kind] for name, kind in kinds.items()},
        "weak-form": {"signs as printed": numbers["weak_form"]["printed"]}
        | {"signs of (7.2)": numbers["weak_form"]["signs of (7.2)"]},
    }
    words = said.measured()
    return [Statement(c, words[name], readings[name]) for name, c in claims("figure-3").items()]


def _in_steps(time: float | None) -> float | None:
    """In steps of the paper's Δt = 0.001."""
    return None if time is None else time / 1e-3


def _tables(numbers: Mapping[str, Any], said: text.Words) -> list[Table]:
    runs = numbers["runs"]
    rows = []
    for name, label in text.ROWS.items():
        run = runs[name]
        fits, large, centre = run["celerity"], run["largest"], run["pulses"]["centre"]
        moved = large["displacement"] > 0
        rows.append(
            [label, fits["along"], fits["across"], centre["maximum"], centre["minimum"], centre["duration"]]
            + ([large["displacement"], large["stress_low"], large["stress_high"]] if moved else [None] * 3)
            + [round(100 * run["volume"][key], 3) + 0.0 for key in ("change", "area_change")]
        )
    head = ["run", "along", "across", "max $v$", "min $v$", "duration", "max $|u|$", "least tr σ"]
    tables = [Table(said.table_runs(), [*head, "greatest tr σ", "volume, %", "area, %"], rows)]
    one = numbers["celerity"]["one_dimension"]
    lines = [
        [label, one[name], *(runs[name]["pulses"]["a"][k] for k in ("maximum", "minimum", "duration"))]
        for name, label in text.LINES.items()
    ]
    tables.append(Table(said.table_lines(), ["run", "celerity", "max $v$", "min $v$", "duration"], lines))
    if "convergence" in numbers:
        keys = list(numbers["convergence"]["stress"])
        parts = numbers["convergence"]
        tables.append(
            Table(
                said.table_convergence(),
                ["change, %", *(text.ROWS[name] for name in parts)],
                [
                    [key.replace("_", " "), *(100 * p[key] if key in p else None for p in parts.values())]
                    for key in keys
                ],
            )
        )
    return tables
