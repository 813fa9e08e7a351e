"""Tables of what was matched and what differs, and the curves as columns."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.chapters.strain_and_stress import jobs
from myostrain.reproduce.content import Measured, Rows
from myostrain.reproduce.words import fixed, number

#: What a tension is matched to, by approach.
SAYS = {"strain": "strain", "stress": "stress, same contraction", "force": "stress, same force"}


def words(measured: Measured) -> dict[str, Any]:
    """What the words name beside the numbers."""
    laws = measured.numbers["laws"]
    return {
        "names": jobs.NAMES,
        "strips": {name: one["strip"]["fibre"] for name, one in laws.items()},
        "seconds": {
            name: one["jumps"]["strain"]["seconds"] / one["jumps"]["stress"]["seconds"]
            for name, one in laws.items()
        },
        "fastest": max(one["released"]["fastest"] for one in laws.values()),
        "unloaded": max(one["released"]["unloaded"] for one in laws.values()),
        "says": SAYS,
    }


def tables(measured: Measured) -> dict[str, Rows]:
    """The rows of the tables."""
    laws = measured.numbers["laws"]
    made: dict[str, Rows] = {
        "matching": [
            [jobs.NAMES[name], kind, number(s["free"]), number(s["isometric"]), number(s["tension"]),
             number(s["force_ratio"]), number(1 - s["free"]), number(s["contraction"])]
            for name, one in laws.items()
            for kind, s in one["strip"].items()
        ],
        "slopes": [
            [jobs.NAMES[name], number(s["slope"]), number(s["stress_slope"]),
             number(s["stiffness"] / s["isometric"]),
             number((one["passive_stiffness"] + s["tension"]) / s["tension"]),
             number(s["velocity"] / s["stress_velocity"]), number(one["released"]["fastest"])]
            for name, one in laws.items()
            for s in (one["strip"]["fibre"],)
        ],
        "chamber": [
            [jobs.NAMES[name] if approach == "strain" else "", SAYS[approach],
             *(number(t[key]) for key in ("pressure", "frank_starling", "ejection_fraction", "elastance",
                                          "slope_filled", "slope_ejected", "thickening", "twist"))]
            for name, one in laws.items()
            for approach, t in one["tube"].items()
        ],
        "sensitivity": [
            [jobs.NAMES[name] if approach == "strain" else "", SAYS[approach],
             *(_share(parts, group, what) for group in ("stiffness", "exponents", "activation")
               for what in ("contraction", "isometric"))]
            for name, one in laws.items()
            for approach, parts in one["sensitivity"].items()
        ],
        "newton": [
            [jobs.NAMES[name] if approach == "strain" else "", body, SAYS[approach], j["first"],
             ("beyond " if j["jump"] <= jobs.LARGEST else "") + number(j["jump"]),
             j["corrections"], j["factorizations"],
             fixed(j["seconds"] / one[key]["stress"]["seconds"], 1)]
            for key, body in (("jumps", "sheet"), ("jumps_solid", "block"))
            for name, one in laws.items()
            for approach, j in one.get(key, {}).items()
        ],
        "staggering": [
            [jobs.NAMES[name] if approach == "strain" else "", approach, jobs.SLOPES[k],
             number(s["gain"][k]), _growth(s["staggered"], k), _growth(s["second-order"], k),
             fixed(s["implicit"]["iterations"][k], 1)]
            for name, one in laws.items()
            for approach, s in one["swings"].items()
            for k in range(len(jobs.SLOPES))
        ],
        "steps": [
            [jobs.NAMES[name] if approach == "strain" else "", approach, number(s["gain"]),
             "none" if s["lagging"]["bound"] is None else number(s["lagging"]["bound"]),
             number(s["velocity"]["bound"]), number(s["velocity"]["growth"][0]),
             number(s["velocity"]["growth"][1])]
            for name, one in laws.items()
            for approach, s in one["steps"].items()
        ],
    }  # fmt: skip
    if not measured.quick:
        made["ventricle"] = [
            [SAYS[approach], *(number(m[key]) for key in ("ejection_fraction", "wall_thickening", "twist",
                                                          "longitudinal_shortening", "fibre_shortening"))]
            for approach, m in measured.numbers["ventricle"].items()
        ]  # fmt: skip
        made["beats"] = [
            [jobs.BEATS[approach][0]["kind"], scheme, number(s["swing"]), number(s["shortest"]),
             fixed(s["iterations"], 1) if s["iterations"] else None]
            for approach, one in measured.numbers["beats"].items()
            for scheme, s in one.items()
        ]  # fmt: skip
    return made


def _share(parts: dict[str, Any], group: str, what: str) -> str | None:
    """A logarithmic derivative; None where the law has no such parameters."""
    if group not in parts:
        return None
    return fixed(round(parts[group][what], 2) + 0.0, 2).replace("-", "−")


def _growth(of: dict[str, Any], k: int) -> str:
    """The growth by step, as measured and as predicted; what leaves the linear range at once has none."""
    found = of["growth"][k]
    return f"{'–' if found is None else number(found)} ({number(of['predicted'][k])})"


def data(measured: Measured) -> dict[str, dict[str, Any]]:
    """Force over length, pressure over volume, and stretches from step to step."""
    made: dict[str, dict[str, Any]] = {}
    for name in jobs.LAWS:
        strip, tube = measured.found[f"{name} strip"].arrays, measured.found[f"{name} tube"].arrays
        columns = {"stretch": strip["stretch"], "passive": strip["passive"]}
        for kind in jobs.DEFORMATIONS:
            one = measured.numbers["laws"][name]["strip"][kind]
            key = kind.replace(" ", "_")
            columns |= {
                f"{key}_strain": strip[f"{kind} force"],
                f"{key}_stress": strip["passive"] + one["tension"] * strip["stretch"],
                f"{key}_force": strip["passive"] + one["isometric"] * strip["stretch"],
            }
        made[f"force-length-{name}"] = columns
        made[f"tube-{name}"] = {key.replace(" ", "_"): value for key, value in tube.items()}
        swings: dict[str, list[Any]] = {
            key: [] for key in ("approach", "beta", "scheme", "step", "stretch", "equilibrium")
        }
        for approach in ("strain", "stress"):
            arrays = measured.found[f"{name} {approach} swings"].arrays
            for scheme in ("staggered", "second-order", "implicit"):
                for k, slope in enumerate(jobs.SLOPES):
                    lam = arrays[scheme][k]
                    swings["approach"] += [approach] * len(lam)
                    swings["beta"] += [slope] * len(lam)
                    swings["scheme"] += [scheme] * len(lam)
                    swings["step"] += list(range(len(lam)))
                    swings["stretch"] += lam.tolist()
                    swings["equilibrium"] += [float(arrays["equilibrium"][k])] * len(lam)
        made[f"staggering-{name}"] = swings
    return made
