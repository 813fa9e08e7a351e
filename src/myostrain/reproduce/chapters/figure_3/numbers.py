"""Celerities, pulses, displacement and strain of the sheet, beside one dimension and between the runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from myostrain.reproduce.jobs import Found

import numpy as np

#: Probes at which pulses are compared: settled, and passed at t = 3 whatever the diffusivity.
PULSES = ("out60", "centre", "left", "right")


def numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number of the chapter."""
    runs = {name: outcome.numbers for name, outcome in found.items() if "pulses" in outcome.numbers}
    made: dict[str, Any] = {
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
        made["convergence"] = {
            k: _convergence(runs[k], runs[f"{k} finer"]) for k in ("rigid", "stress", "rigid ratio 4")
        }
    return made


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


def readings(n: Mapping[str, Any]) -> dict[str, Any]:
    """What is judged, by claim and reading."""
    celerity, runs, start, like = n["celerity"], n["runs"], n["start"], n["like_1d"]
    kinds = {"plane stress": "stress", "plane strain": "strain"}
    strip = "against a free strip of the same equations"

    def both(number: Callable[[str], Any]) -> dict[str, Any]:
        return {name: number(kind) for name, kind in kinds.items()}

    return {
        "mesh": {"our egg": n["mesh"]},
        "few-steps": {
            "front and back": {"steps": _in_steps(start["back"])},
            "the front alone": {"steps": _in_steps(start["grows"])},
        },
        "like-one-dimension": {
            "plane stress against the coupled line (4.6)": like["coupled line (4.6)"],
            f"plane stress {strip}": like["plane stress, free strip"],
            f"plane strain {strip}": like["plane strain, free strip"],
            "the rigid sheet against the rigid line": like["rigid sheet, rigid line"],
        },
        "isotropy-potential": both(lambda kind: n["isotropy"][kind]),
        "isotropy-mechanics": both(lambda kind: n["isotropy"][kind]),
        "half": {
            name: {"ratio": celerity[f"{kind} ratio 4"]["ratio"]}
            for name, kind in {**kinds, "rigid body": "rigid"}.items()
        },
        "faster-along": both(lambda kind: {"ratio": celerity[kind]["along_ratio"]}),
        "faster-across": both(lambda kind: {"ratio": celerity[kind]["across_ratio"]}),
        "steeper": {
            f"{name}, {place}": {"ratio": celerity[kind][f"steepness_ratio_{at}"]}
            for at, place in (("X", "material X"), ("x", "spatial x"))
            for name, kind in kinds.items()
        },
        "fixed-domain": both(lambda kind: {"difference": n["fixed_domain"][kind]}),
        "relevant-displacement": {
            f"{what}, {name}": {"share": runs[kind]["relevance"]["tenth"][f"{what}_share"]}
            for what in ("displacement", "strain")
            for name, kind in kinds.items()
        },
        "fibres-contract": both(
            lambda kind: {
                f"{to}_fibres": runs[kind]["stretch"][of]
                for to, of in (("along", "fibre"), ("across", "cross"))
            }
        ),
        "incompressible": both(lambda kind: n["constraint"][kind]),
        "weak-form": {
            "signs as printed": n["weak_form"]["printed"],
            "signs of (7.2)": n["weak_form"]["signs of (7.2)"],
        },
    }


def _in_steps(time: float | None) -> float | None:
    """In steps of the paper's Δt = 0.001."""
    return None if time is None else time / 1e-3
