"""Rates of homogeneous states, fronts beside the closed forms, orders, and where fronts end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.reproduce.chapters.fronts import jobs as setup
from myostrain.reproduce.chapters.fronts.jobs import ALPHA, BETA, RATE, name
from myostrain.reproduce.jobs import Found

import numpy as np


def numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number of the chapter."""
    s = setup.settings(quick)
    fronts = [_row(found, a, b, "conservative") for a, b in s.fronts]
    advective = [_row(found, a, b, "advective") for a, b in s.advective]
    advancing = [row for row in fronts if row["alpha"] < 0.5 and row["beta"] > 0]
    rows = [*fronts, *advective]
    unit = found["unit_A"].numbers
    return {
        "equilibria": _equilibria(found),
        "temporal_variation": _temporal_variation(found),
        "spreading": _spreading(found),
        "infinitesimal": _infinitesimal(found),
        "fronts": fronts,
        "advective": advective,
        "agreement": {
            "potential_error": max(row["potential_error"] for row in rows),
            "place_error": max(row["place_error"] / row["shortening"] for row in rows if row["beta"] > 0),
            "unsettled": max(row["unsettled"] for row in rows),
            **_range("steepness", [row["steepness"] / row["steepness_exact"] for row in rows]),
            **_range("speed", [row["c"] / row["c_exact"] for row in rows]),
        },
        "unit_A": {"alpha": ALPHA, "beta": BETA, "D": 1.0, **unit, **_printed(ALPHA, BETA, 1.0, unit)},
        "orders": _orders(found, s),
        "bump": {
            "celerity": found["bump"].numbers["metrics"]["celerity"],
            "ratio": -found["bump"].numbers["metrics"]["celerity"]
            / found[name(ALPHA, BETA)].numbers["c_exact"],
        },
        "tangent": _tangent(found[name(ALPHA, 0.0)]),
        "faster": min(row["speed_ratio"] for row in advancing),
        "sharper": min(row["steepness_ratio"] for row in advancing),
        "sharper_in_material": min(row["slope_ratio"] for row in advancing),
        "limit": _limit(fronts),
        "search": _search(found),
        "refused": {
            balance: found[f"refused_{balance}"].numbers for balance in ("conservative", "advective")
        },
    }


def readings(n: Mapping[str, Any]) -> dict[str, Any]:
    """What is judged, by claim and reading."""
    agreement, extrapolated = n["agreement"], n["orders"]["extrapolated_speed"]
    ratios = {
        "least_ratio": agreement["speed_least"],
        "largest_ratio": agreement["speed_largest"],
        "ratio_at_unit_A": n["unit_A"]["speed_over_printed"],
        "ratio_extrapolated": extrapolated,
        "ratio_from_a_bump": n["bump"]["ratio"],
    }
    steepness = {
        "least_ratio": agreement["steepness_least"],
        "largest_ratio": agreement["steepness_largest"],
        "ratio_at_unit_A": n["unit_A"]["steepness_over_printed"],
    }
    e, search, limit = n["equilibria"], n["search"], n["limit"]
    printed = "as printed"
    return {
        "equilibria": {printed: {"drift": e["drift"], "zeros": e["zeros"], "moved": e["moved"]}},
        "stable-point": {
            printed: {"growth_at_rest": e["growth_at_rest"], "least_growth_elsewhere": e["growth_elsewhere"]}
        },
        "diffusion": {
            "as printed (4.5)": {"ratio": n["spreading"]["conservative_over_rigid"]},
            "the advective balance": {"ratio": n["spreading"]["advective_over_rigid"]},
        },
        "temporal-variation": {printed: {"least_ratio": n["temporal_variation"]["least_ratio"]}},
        "infinitesimal": {
            printed: {"order": n["infinitesimal"]["order"], "change": n["infinitesimal"]["changes"][-1]}
        },
        "profile": {printed: {"largest_error": agreement["potential_error"]}},
        "steepness": {printed: steepness},
        # c / c_exact is over the velocity that solves (4.8) with a > 0; the printed c is its negative.
        "speed": {
            "as printed, v(X − ct) with v(+∞) = 1": {key: -value for key, value in ratios.items()},
            "(4.11) is the speed towards −X, v(X + ct)": ratios,
        },
        "place": {printed: {"largest_error": agreement["place_error"]}},
        "hyperbolic-tangent": {printed: n["tangent"]},
        "existence": {
            printed: {
                "last_front": search["last_front"],
                "first_without": search["first_without"],
                "limit_from_steepness": limit["limit_from_steepness"],
                "limit_from_speed": limit["limit_from_speed"],
            }
        },
        "faster": {printed: {"least_ratio": n["faster"]}},
        "sharper": {
            "slope in the material": {"least_ratio": n["sharper_in_material"]},
            "slope in space, which is a of (4.9)": {"least_ratio": n["sharper"]},
        },
    }


def _row(found: Mapping[str, Found], alpha: float, beta: float, balance: str) -> dict[str, Any]:
    """A front, and its ratios to the rigid line's at the same α and mesh where that was run."""
    own = found[name(alpha, beta, balance)].numbers
    row: dict[str, Any] = {"alpha": alpha, "beta": beta, **own}
    rigid = found.get(name(alpha, 0.0))
    if rigid is not None:
        row["speed_ratio"] = own["c"] / rigid.numbers["c"]
        for key in ("steepness", "slope", "width_material", "width_spatial"):
            row[f"{key}_ratio"] = own[key] / rigid.numbers[key]
    return row


def _range(key: str, values: Sequence[float]) -> dict[str, float]:
    return {f"{key}_least": min(values), f"{key}_largest": max(values)}


def _printed(alpha: float, beta: float, D: float, own: Mapping[str, Any]) -> dict[str, float]:
    """(4.10) and (4.11) letter by letter; |c|, as the sign is judged elsewhere."""
    a = np.sqrt((1 - 2 * alpha * beta) / (1 - beta) / (2 * D))
    c = (1 - 2 * alpha) / 2 * np.sqrt(2 * D / ((1 - beta) * (1 - 2 * alpha * beta)))
    return {"steepness_over_printed": float(own["steepness"] / a), "speed_over_printed": float(-own["c"] / c)}


def _equilibria(found: Mapping[str, Found]) -> dict[str, Any]:
    rows: list[dict[str, Any]] = []
    at_rest: list[float] = []
    elsewhere: list[float] = []
    for kind, potentials in setup.EQUILIBRIA.items():
        for model in setup.MODELS:
            own = found[f"{kind}_{model}"].numbers
            for i, v in enumerate(potentials):
                growth = max(re for re, _ in own["rates"][i])
                row = {"recovery": kind, "model": model, "potential": v, "growth": growth}
                row |= {key: own[key][i] for key in ("drift", "rates", "predicted", "bent")}
                rows.append(row)
                if kind == "with_recovery":
                    (at_rest if v == 0 else elsewhere).append(growth)
    zeros = {model: found[f"temporal_variation_{model}"].numbers["zeros"] for model in setup.MODELS}
    coupled = [row for row in rows if row["model"] != "rigid"]
    mismatch = [
        abs(complex(*p) - complex(*q)) / abs(complex(*q))
        for row in rows
        for p, q in zip(row["rates"], row["predicted"], strict=True)
    ]
    return {
        "rows": rows,
        "drift": max(row["drift"] for row in coupled),
        "zeros": min(map(len, zeros.values())),
        "zeros_by_model": zeros,
        "moved": max(
            abs(a - b)
            for model in ("conservative", "advective")
            for a, b in zip(zeros[model], zeros["rigid"], strict=False)
        ),
        "growth_at_rest": max(at_rest),
        "growth_elsewhere": min(elsewhere),
        "rates_off_linear_algebra": max(mismatch),
    }


def _temporal_variation(found: Mapping[str, Found]) -> dict[str, Any]:
    v, rigid = (found["temporal_variation_rigid"].arrays[key] for key in ("potential", "rate"))
    contracted = v > 0
    ratio = (found["temporal_variation_conservative"].arrays["rate"] / rigid)[contracted]
    exact = ((1 - BETA * v) / (1 - 2 * BETA * v))[contracted]
    return {
        "potential": v[contracted].tolist(),
        "ratio": ratio.tolist(),
        "least_ratio": float(ratio.min()),
        "largest_ratio": float(ratio.max()),
        "off_exact": float(np.abs(ratio / exact - 1).max()),
    }


def _spreading(found: Mapping[str, Found]) -> dict[str, float]:
    rate = {model: found[f"spreading_{model}"].numbers["rate"] for model in setup.MODELS}
    return {
        **rate,
        "conservative_over_rigid": rate["conservative"] / rate["rigid"],
        "advective_over_rigid": rate["advective"] / rate["rigid"],
    }


def _infinitesimal(found: Mapping[str, Found]) -> dict[str, Any]:
    rigid = found[name(ALPHA, 0.0)].numbers["c"]
    changes = [found[name(ALPHA, beta)].numbers["c"] / rigid - 1 for beta in setup.SMALL]
    order = np.log(changes[0] / changes[1]) / np.log(setup.SMALL[0] / setup.SMALL[1])
    return {"betas": list(setup.SMALL), "changes": changes, "order": float(order)}


def _orders(found: Mapping[str, Found], s: setup.Settings) -> dict[str, Any]:
    """Observed orders of the speed, from the last three of each sequence of halved h or Δt."""
    meshes = [found[setup.mesh(h)].numbers for h in s.spacings]
    in_space = [n["c"] / n["c_exact"] for n in meshes]
    in_time = {}
    for scheme in setup.SCHEMES:
        runs = [found[setup.stepped(scheme, i)].numbers for i in range(len(s.steps_of(scheme)))]
        in_time[scheme] = [n["c"] / n["c_exact"] for n in runs]
    second, steps = in_time["second-order"], s.steps
    curvature = (second[-1] - second[-2]) / (steps[-2] ** 2 - steps[-1] ** 2)
    return {
        "spacings": list(s.spacings),
        "speed_by_spacing": in_space,
        "order_in_h": _order(in_space),
        "steps": {scheme: list(s.steps_of(scheme)) for scheme in setup.SCHEMES},
        "speed_by_step": in_time,
        "order_in_step": {scheme: _order(values) for scheme, values in in_time.items()},
        "extrapolated_speed": in_space[-1] + (in_space[-1] - in_space[-2]) / 3 + curvature * s.step**2,
    }


def _order(values: Sequence[float]) -> float:
    return float(np.log2((values[-3] - values[-2]) / (values[-2] - values[-1])))


def _tangent(rigid: Found) -> dict[str, float]:
    """The rigid front beside the hyperbolic tangent, written out."""
    X, v = rigid.arrays["X"], rigid.arrays["v"]
    half = float(np.interp(0.5, v, X))
    tangent = (1 + np.tanh(np.sqrt(RATE / (8 * RATE)) * (X - half))) / 2
    return {
        "potential_error": float(np.abs(v - tangent).max()),
        "speed_ratio": -rigid.numbers["c"] / ((1 - 2 * ALPHA) * np.sqrt(RATE * RATE / 2)),
    }


def _limit(fronts: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Where the measured a² and 1/c², divided by what does not depend on αβ, come to zero: α = 0.9."""
    rows = [row for row in fronts if row["alpha"] == 0.9]
    beta = np.array([row["beta"] for row in rows])
    product = 0.9 * beta
    from_steepness = np.array([2 * (1 - row["beta"]) * row["steepness"] ** 2 for row in rows])
    from_speed = np.array([RATE**2 * 0.8**2 / (2 * (1 - row["beta"]) * row["c"] ** 2) for row in rows])
    near = product > 0.2
    zeros = [
        float(np.polynomial.Polynomial.fit(product[near], values[near], 1).roots()[0])
        for values in (from_steepness, from_speed)
    ]
    return {
        "product": product.tolist(),
        "from_steepness": from_steepness.tolist(),
        "from_speed": from_speed.tolist(),
        "limit_from_steepness": zeros[0],
        "limit_from_speed": zeros[1],
    }


def _search(found: Mapping[str, Found]) -> dict[str, Any]:
    rows = []
    for alpha in setup.SEARCH:
        own = found[f"search_alpha_{alpha * 100:.0f}"].numbers
        for beta, c in zip(own["betas"], own["c"], strict=True):
            exact = None
            if alpha * beta < 0.5:
                exact = (2 * alpha - 1) / 2 * float(np.sqrt(2 / ((1 - beta) * (1 - 2 * alpha * beta))))
            rows.append({"alpha": alpha, "beta": beta, "product": alpha * beta, "c": c, "c_exact": exact})
    both = [row for row in rows if row["c"] is not None and row["c_exact"] is not None]
    return {
        "rows": rows,
        "last_front": max(row["product"] for row in rows if row["c"] is not None),
        "first_without": min(row["product"] for row in rows if row["c"] is None),
        "off_exact": max(abs(row["c"] / row["c_exact"] - 1) for row in both),
    }
