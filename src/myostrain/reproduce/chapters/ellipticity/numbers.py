"""Where ellipticity is lost: borders by law and approach, and what bounds and closed forms say of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.activation.force_length import force_length
from myostrain.reproduce.chapters.ellipticity.jobs import (
    APPROACHES,
    DEFORMATIONS,
    EXPONENTIAL,
    FAMILIES,
    JUDGED,
    LAWS,
    POLYNOMIAL,
    SLAB_BORDERS,
    SPACINGS,
    gammas,
)
from myostrain.reproduce.jobs import Found
from myostrain.theory import kinking_stretch, least_with_strain

import numpy as np


def numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number of the chapter."""
    at = gammas(quick).index(JUDGED)
    rest = gammas(quick).index(0.0)
    made: dict[str, Any] = {
        "limits": found["limits"].numbers,
        "laws": {},
        "following": {},
        "slab": {},
        "runs": {},
    }
    for name in LAWS:
        one = found[name]
        rows = {
            f"{approach} {family}": {
                **_side(one, f"{approach} {family}", rest, "passive"),
                **_side(one, f"{approach} {family}", at, "active"),
            }
            for approach in APPROACHES
            for family in FAMILIES
        }
        made["laws"][name] = one.numbers | {
            "borders": rows,
            "free_stretch": float(one.arrays["free"][at]),
            "tension": float(one.arrays["tension"][at]),
            "least_on_the_maps": min(float(one.arrays[f"{row} least"].min()) for row in rows),
        }
        made["following"][name] = _following(found[f"{name} following"])
        if not quick:
            made["laws"][name]["compressible_borders_differ_by"] = _difference(
                one, found[f"{name} compressible"]
            )
    for approach in SLAB_BORDERS:
        made["slab"][approach] = found[f"slab {approach}"].numbers | {"spacings": list(SPACINGS[quick])}
        run = found[f"run {approach}"]
        made["runs"][approach] = run.numbers | {"away": run.arrays["away"][:, -1].tolist()}
    made["identity_error"] = max(one["strain"] for one in made["laws"].values())
    made["tension_error"] = max(one["tension_added"] for one in made["laws"].values())
    made["same_sign"] = min(one["signs"] for one in made["laws"].values())
    made["lost_share"] = max(one["lost"] for one in made["laws"].values())
    made["least_polynomial"] = min(
        min(made["laws"][name]["least"], _least_with_strain(found[name])) for name in POLYNOMIAL
    )
    made["neo_hookean_error"] = _neo_hookean_error(found["NeoHookean"])
    made["kinking_error"] = _kinking_error(found)
    made["curve_peak"] = _curve_peak()
    return made


def _side(one: Found, row: str, index: int, name: str) -> dict[str, float]:
    return {f"{name}_{side}": float(one.arrays[f"{row} {side}"][index]) for side in ("below", "above")}


def _least_with_strain(one: Found) -> float:
    return min(float(one.arrays[f"{a} {f} least"].min()) for a in DEFORMATIONS for f in FAMILIES)


def _difference(one: Found, other: Found) -> float:
    """The largest difference of borders that both have; infinite where only one has one."""
    largest = 0.0
    for name in one.arrays:
        if name.endswith((" below", " above")):
            a, b = one.arrays[name], other.arrays[name]
            if np.any(np.isnan(a) != np.isnan(b)):
                return np.inf
            largest = max(largest, float(np.nan_to_num(np.abs(a - b)).max()))
    return largest


def _following(one: Found) -> dict[str, Any]:
    """From which contraction at λ = 1, and at which stretch, ellipticity is lost, for either approach."""
    gamma, lam = one.arrays["gamma"], one.arrays["stretch"]
    made: dict[str, Any] = {"closed_form": one.numbers["closed_form"]}
    for name in ("strain", "stress", "ordinary", "frozen"):
        lost = one.arrays[name] <= 0
        rows = np.flatnonzero(lost.any(axis=1))
        first = rows[0] if len(rows) else None
        made[f"{name}_gamma"] = None if first is None else float(gamma[first])
        made[f"{name}_stretch"] = None if first is None else float(lam[lost[first].argmax()])
        made[f"{name}_earliest_stretch"] = float(lam[lost.any(axis=0).argmax()]) if len(rows) else None
    return made


def _neo_hookean_error(one: Found) -> float:
    """The neo-Hookean body's least eigenvalue on the maps, against its closed form."""
    gamma = one.arrays["gamma"]
    side = (1 + gamma) ** -0.5
    ones = np.ones_like(gamma)
    stretches = {
        "fibre": np.stack([1 + gamma, ones, ones], axis=1),
        "transversely isotropic": np.stack([1 + gamma, side, side], axis=1),
    }
    return max(
        float(np.abs(one.arrays[f"{name} {family} least"] - least_with_strain(a)[:, None]).max())
        for name, a in stretches.items()
        for family in FAMILIES
    )


def _kinking_error(found: Mapping[str, Found]) -> float:
    """Borders of the exponential laws under active strain, against the stretch at which fibres kink.

    In the plane family the sheet direction makes up for the fibre and the normal keeps e_n = 1 for Fo along
    the fibre, so that λ = (1 + γ) √(1 − b_fn/b_f).
    """
    errors = []
    for name, along, shear in (("Guccione1995", "bf", "bfs"), ("Usyk2002", "bff", "bfn")):
        one = found[name]
        exact = (1 + one.arrays["gamma"]) * kinking_stretch(LAWS[name][along], LAWS[name][shear])
        errors.append(float(np.abs(one.arrays["fibre plane below"] - exact).max()))
    return max(errors)


def _curve_peak() -> float:
    """The stretch from which on the equilibrium of Rossi et al. contracts less: where RFL/λ² is largest."""
    lam = np.linspace(0.9, 1.3, 4001)
    return float(lam[(force_length(lam) / lam**2).argmax()])


def readings(n: Mapping[str, Any]) -> dict[str, Any]:
    """What is judged, by claim and reading."""
    measured = "as measured"
    limits, laws, following = n["limits"], n["laws"], n["following"]
    slope = max(abs(a / b - 1) for a, b in zip(limits["slopes"], limits["closed_form"], strict=True))
    exponential = [following[name] for name in EXPONENTIAL]
    plane = [laws[name]["borders"] for name in ("Guccione1995", "Usyk2002")]
    ratios = [one["fibre plane"]["active_below"] / one["tension plane"]["active_below"] for one in plane]
    slab = n["slab"].values()
    beyond = [b / one["border"] for one in slab for b in one["borders"] if b is not None]
    nearer = [b / a for one in slab for a, b in zip(one["borders"], one["borders"][1:], strict=False)]
    return {
        "frozen": {
            measured: {
                "identity_error": n["identity_error"],
                "same_sign": n["same_sign"],
                "share_not_elliptic": n["lost_share"],
                "least_of_polynomial_laws": n["least_polynomial"],
            }
        },
        "tension": {
            measured: {
                "tension_error": n["tension_error"],
                "critical_push": limits["push"],
                "slope_error": slope,
            }
        },
        "exponential": {
            measured: {
                "kinking_error": n["kinking_error"],
                "strain_over_stress": max(ratios),
                "isometric_gamma": laws["Usyk2002"]["isometric"]["transversely isotropic"],
            }
        },
        "following": {
            measured: {
                "contraction": max(one["strain_gamma"] or -np.inf for one in following.values()),
                "earliest_over_peak": min(
                    (one["strain_earliest_stretch"] or np.inf) / n["curve_peak"] for one in following.values()
                ),
                "lost_with_gamma_frozen": sum(one["frozen_gamma"] is not None for one in following.values()),
                "laws": sum(one["strain_gamma"] is not None for one in following.values()),
            }
        },
        "which-first": {
            measured: {
                "exponential_laws_strain_first": sum(_before(one) for one in exponential),
                "polynomial_laws_stress_first": sum(not _before(following[name]) for name in POLYNOMIAL),
            }
        },
        "line": {measured: {"beta_v": limits["line"]}},
        "slab": {
            measured: {
                "largest_over_border": max(beyond),
                "least_refined_over_coarse": min(nearer),
                "waves_refined_over_coarse": min(
                    b / a for one in slab for a, b in zip(one["waves"], one["waves"][1:], strict=False)
                ),
                "last_over_border": max(
                    max(1.0 if at is None else at for at in run["reached"]) / n["slab"][approach]["border"]
                    for approach, run in n["runs"].items()
                ),
            }
        },
    }


def _before(one: Mapping[str, Any]) -> bool:
    """Whether the strain loses ellipticity at a smaller contraction than the stress."""
    strain, stress = (one[f"{name}_gamma"] for name in ("strain", "stress"))
    return strain is not None and (stress is None or strain > stress)
