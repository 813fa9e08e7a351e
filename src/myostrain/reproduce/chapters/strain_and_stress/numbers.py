"""How far strain and stress differ: strips, tubes, jumps, and steps of time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.activation.force_length import force_length
from myostrain.reproduce.chapters.strain_and_stress.jobs import (
    EJECTED,
    FILLED,
    GAMMA,
    LAWS,
    RADII,
    SLOPES,
)
from myostrain.reproduce.jobs import Array, Found

import numpy as np

#: Strain; the tension matched to the free contraction, and to the isometric force.
APPROACHES = ("strain", "stress", "force")
STRESSES = APPROACHES[1:]
EXPONENTIAL = ("Guccione1995", "HolzapfelOgden2009")
#: Half of the isometric force; a/P₀ of Hill's hyperbola for heart muscle.
HALF, HILL = 0.5, 0.25


def numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number of the chapter."""
    made: dict[str, Any] = {"laws": {}}
    for name in LAWS:
        strip, released = found[f"{name} strip"].numbers, found[f"{name} released"].arrays
        made["laws"][name] = {
            "strip": {
                kind: strip[kind] | {"force_ratio": strip[kind]["isometric"] / strip[kind]["tension"]}
                for kind in ("fibre", "transversely isotropic")
            },
            "passive_stiffness": strip["passive_stiffness"],
            "modulus": strip["modulus"],
            "released": {
                "unloaded": float(released["velocity"][0]),
                "fastest": float(released["velocity"].max()),
            },
            "sensitivity": found[f"{name} sensitivity"].numbers,
            "tube": {approach: _chamber(found[f"{name} tube"], approach) for approach in APPROACHES},
            "jumps": found[f"{name} jumps"].numbers,
            "swings": {a: found[f"{name} {a} swings"].numbers for a in ("strain", "stress")},
            "steps": {a: found[f"{name} {a} steps"].numbers for a in ("strain", "stress")},
            "rossi": found[f"{name} rossi"].numbers,
        }
        if not quick:
            made["laws"][name]["jumps_solid"] = found[f"{name} jumps, solid"].numbers
    made["neo_hookean_error"] = _neo_hookean_error(found)
    made["curve_slope"] = _slope_of_curve()
    made["hill_shape"] = HILL
    made["hill"] = (1 - HALF) / (1 + HALF / HILL)
    made["ventricle"] = {} if quick else {a: found[f"{a} ventricle"].numbers["metrics"] for a in APPROACHES}
    made["beats"] = {} if quick else {a: found[f"{a} beat"].numbers for a in ("strain", "stress")}
    return made


def _slope_of_curve() -> float:
    """D ln RFL/d ln λ at λ = 1 of the force–length curve of the program."""
    step = 1e-4
    low, high = force_length(np.exp([-step, step]))
    return float(np.log(high / low) / (2 * step))


def _neo_hookean_error(found: Mapping[str, Found]) -> float:
    """A neo-Hookean body under strain is 1 + γ times the one under the matched stress, in strip and tube."""
    a = 1 + GAMMA
    strip, tube = found["NeoHookean strip"], found["NeoHookean tube"].arrays
    one, lam = strip.numbers["fibre"], strip.arrays["stretch"]
    stress = strip.arrays["passive"] + one["tension"] * lam
    errors = [
        np.abs(strip.arrays["fibre force"] - a * stress).max(),
        np.abs(strip.arrays["fibre force"] - (lam / a - a / lam**2)).max(),
        abs(one["free"] - a ** (2 / 3)),
        abs(one["tension"] - (a**-2 - 1)),
        abs(one["slope"] - (1 - 2 * a) / (1 + a)),
        abs(one["velocity"] - 1 / (2 * a**-3 + a)),
        np.abs(tube["fibre strain pressure"] - a * tube["fibre stress pressure"]).max(),
        *(
            np.abs(tube[f"fibre strain {key}"] - tube[f"fibre stress {key}"]).max()
            for key in ("stretch", "twist")
        ),
    ]
    return float(max(errors))


def _chamber(found: Found, approach: str) -> dict[str, float]:
    """The tube filled and isovolumic, ejected to half of that pressure, and at one ejected volume."""
    arrays = found.arrays
    V = arrays["volume"]
    p, passive = arrays[f"fibre {approach} pressure"], arrays["passive pressure"]
    slope, added = np.gradient(p, V), np.log(np.maximum(p - passive, 1e-300))

    def at(values: Array, volume: float) -> float:
        return float(np.interp(volume, V, values))

    top = at(p, FILLED)
    full = V <= FILLED + 1e-9
    below = np.flatnonzero(full & (p <= top / 2))
    last = below[-1]
    end = float(np.interp(top / 2, p[last : last + 2], V[last : last + 2]))
    wall = arrays[f"fibre {approach} wall"]
    before = at(arrays["passive wall"], FILLED)
    twist = arrays[f"fibre {approach} twist"] - at(arrays["passive twist"], FILLED)
    return {
        "pressure": top,
        "filling_pressure": at(passive, FILLED),
        "end_volume": end,
        "ejection_fraction": 1 - end / FILLED,
        "elastance": (top / 2) / (FILLED - end) * FILLED / top,
        "slope_filled": at(slope, FILLED) * FILLED / top,
        "slope_ejected": at(slope, end) * FILLED / top,
        "frank_starling": at(np.gradient(added, np.log(V)), FILLED),
        "thickening": at(wall, EJECTED) / before - 1,
        "twist": at(twist, EJECTED) * RADII[1],
        "axial": at(arrays[f"fibre {approach} stretch"], EJECTED) / at(arrays["passive stretch"], FILLED),
    }


def readings(n: Mapping[str, Any]) -> dict[str, Any]:
    """What is judged, by claim and reading."""
    measured, laws = "as measured", n["laws"]
    neo, guccione, holzapfel = (laws[name] for name in LAWS)
    strips = {name: one["strip"]["fibre"] for name, one in laws.items()}
    return {
        "neo-hookean": {
            measured: {
                "largest_error": n["neo_hookean_error"],
                "force_ratio": strips["NeoHookean"]["force_ratio"],
            }
        },
        "isometric": {
            measured: {
                "Guccione": strips["Guccione1995"]["force_ratio"],
                "Holzapfel_Ogden": strips["HolzapfelOgden2009"]["force_ratio"],
            }
        },
        "force-length": {
            measured: {
                "stress": max(abs(one["stress_slope"] - 1) for one in strips.values()),
                "Guccione": strips["Guccione1995"]["slope"] / n["curve_slope"],
                "Holzapfel_Ogden": strips["HolzapfelOgden2009"]["slope"] / n["curve_slope"],
            }
        },
        "force-velocity": {
            measured: {
                "half_load": max(
                    abs(one[key] - HALF) for one in strips.values() for key in ("half", "stress_half")
                ),
                "strain_over_stress": max(abs(_velocities(one) - _dashpots()) for one in strips.values()),
                "rossi_fastest": max(one["released"]["fastest"] for one in laws.values()),
                "rossi_unloaded": max(one["released"]["unloaded"] for one in laws.values()),
            }
        },
        "chamber": {
            measured: {
                "convex_with_strain": sum(_bend(laws[name], "strain") > 1 for name in EXPONENTIAL),
                "concave_with_stress": sum(_bend(one, "force") < 1 for one in laws.values()),
                "Guccione_strain": guccione["tube"]["strain"]["frank_starling"],
                "Holzapfel_Ogden_strain": holzapfel["tube"]["strain"]["frank_starling"],
                "stress": max(one["tube"][a]["frank_starling"] for one in laws.values() for a in STRESSES),
            }
        },
        "wall": {
            measured: {
                "thickening_spread": float(
                    np.ptp([one["tube"][a]["thickening"] for one in laws.values() for a in APPROACHES])
                ),
                "neo_hookean_twist": neo["tube"]["strain"]["twist"] / neo["tube"]["stress"]["twist"],
                "Guccione_twist": guccione["tube"]["strain"]["twist"] / guccione["tube"]["force"]["twist"],
                "Holzapfel_Ogden_twist": holzapfel["tube"]["strain"]["twist"]
                / holzapfel["tube"]["force"]["twist"],
            }
        },
        "sensitivity": {
            measured: {
                "strain_contraction": _largest(laws, "strain", "stiffness", "contraction", 0.0),
                "strain_force": _largest(laws, "strain", "stiffness", "isometric", 1.0),
                "stress_force": _largest(laws, "stress", "stiffness", "isometric", 0.0),
                "stress_contraction": max(
                    one["sensitivity"]["stress"]["stiffness"]["contraction"] for one in laws.values()
                ),
                "force_per_gamma": holzapfel["sensitivity"]["strain"]["activation"]["isometric"],
            }
        },
        "newton": {measured: newton([one["jumps"] for one in laws.values()])},
        "staggering": {measured: _swings(laws)},
        "steps": {measured: _steps(laws)},
        "rossi": {
            measured: {
                "largest_gain": max(abs(one["rossi"]["gain"]) for one in laws.values()),
                "moved": max(max(one["rossi"]["moved"].values()) for one in laws.values()),
            }
        },
    }


def newton(laws: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """What is judged of Newton's method, from the jumps of each law: strain over stress, the worst law."""

    def over(what: str, approach: str) -> list[float]:
        return [float(jumps["strain"][what] / jumps[approach][what]) for jumps in laws]

    return {
        "corrections": max(over("corrections", "force")),
        "corrections_at_same_contraction": max(over("corrections", "stress")),
        "jump": min(over("jump", "force")),
    }


def _dashpots() -> float:
    """How much slower strain is than stress by the closed form: 3/2 over (1 + γ)⁻³ + (1 + γ)/2."""
    a = 1 + GAMMA
    return 1.5 / (a**-3 + a / 2)


def _velocities(one: Mapping[str, Any]) -> float:
    return float(one["velocity"] / one["stress_velocity"])


def _bend(law: Mapping[str, Any], approach: str) -> float:
    """The slope of pressure over volume where the tube is filled, over that where it has ejected."""
    one = law["tube"][approach]
    return float(one["slope_filled"] / one["slope_ejected"])


def _largest(laws: Mapping[str, Any], approach: str, group: str, what: str, exact: float) -> float:
    return max(abs(one["sensitivity"][approach][group][what] - exact) for one in laws.values())


def _swings(laws: Mapping[str, Any]) -> dict[str, float]:
    pairs = [
        (measured, expected)
        for one in laws.values()
        for of in one["swings"].values()
        for scheme in ("staggered", "second-order")
        for measured, expected in zip(of[scheme]["growth"], of[scheme]["predicted"], strict=True)
        if measured is not None
    ]
    gentle, steep = range(len(SLOPES))
    return {
        "growth_error": max(abs(a - b) for a, b in pairs),
        "growths_measured": len(pairs),
        "stress_swings_at_1_45": sum(
            one["swings"]["stress"]["staggered"]["predicted"][gentle] > 1 for one in laws.values()
        ),
        "stress_swings_at_4_9": sum(
            one["swings"]["stress"]["staggered"]["away"][steep] > 0.05 for one in laws.values()
        ),
        "strain_largest_gain": max(max(one["swings"]["strain"]["gain"]) for one in laws.values()),
        "strain_away": max(max(one["swings"]["strain"]["staggered"]["away"]) for one in laws.values()),
        "strain_second_order_swings_at_4_9": sum(
            one["swings"]["strain"]["second-order"]["predicted"][steep] > 1 for one in laws.values()
        ),
        "implicit_away": max(
            max(of["implicit"]["away"]) for one in laws.values() for of in one["swings"].values()
        ),
    }


def _steps(laws: Mapping[str, Any]) -> dict[str, float]:
    every = [of for one in laws.values() for of in one["steps"].values()]
    pairs = [
        (measured, expected, share)
        for of in every
        for law in ("lagging", "velocity")
        for share, (measured, expected) in enumerate(
            zip(of[law]["growth"], of[law]["predicted"], strict=True)
        )
        if measured is not None
    ]
    velocity = [of["velocity"]["growth"] for of in every]
    stress = [one["steps"]["stress"] for one in laws.values()]
    return {
        "growth_error": max(abs(a - b) for a, b, _ in pairs),
        "stress_bound": max(of["lagging"]["bound"] for of in stress),
        "strain_bounds": sum(one["steps"]["strain"]["lagging"]["bound"] is not None for one in laws.values()),
        "shorter_grows": min(shorter for shorter, _ in velocity),
        "longer_decays": max(longer for _, longer in velocity),
        "strain_over_stress": max(
            one["steps"]["strain"]["velocity"]["bound"] / one["steps"]["stress"]["velocity"]["bound"]
            for one in laws.values()
        ),
    }
