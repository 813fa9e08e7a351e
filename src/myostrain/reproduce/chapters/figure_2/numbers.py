"""What becomes of each bump: its largest potential, and the front that it makes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.output.metrics import leading_pulse
from myostrain.reproduce.chapters.figure_2.jobs import END, KINDS, THRESHOLDS, bumps, meshes
from myostrain.reproduce.jobs import Found

import numpy as np

#: What the bumps on the paper's mesh and on the fine one are called.
PAPER = "the printed equations on the paper's mesh"
FINE = {
    "printed": "half-width 1 as printed, fine mesh",
    "sampled": "half-width 1.5 as three nodes with Δx = 1 have it, fine mesh",
}


def numbers(found: Mapping[str, Found], quick: bool) -> dict[str, Any]:
    """Every number of the chapter."""
    names = ["paper", "one", *(f"1/{n}" for n in meshes(quick)), *bumps(quick)]
    made: dict[str, Any] = {
        name: {kind: _outcome(found[f"{name}, {kind}"]) for kind in KINDS} for name in names
    }
    if not quick:
        made["thresholds"] = {
            name: {kind: found[f"threshold {name}, {kind}"].numbers["threshold"] for kind in KINDS}
            for name in THRESHOLDS
        }
    return made


def _outcome(found: Found) -> dict[str, float | None]:
    """Largest v at t = 0.3 and at the end, and the speed in X of the front in between the last two tenths."""
    times, X, x, v = (found.arrays[name] for name in ("times", "X", "x", "potential"))
    peaks = v.max(axis=1)

    def at(time: float) -> int:
        return int(np.argmin(np.abs(times - time)))

    first, last = (leading_pulse(X, x[i], v[i]) for i in (at(END - 0.1), at(END)))
    return {
        "peak_03": float(peaks[at(0.3)]),
        "peak": float(peaks[at(END)]),
        "front": None if last is None else last.front,
        "front_speed": None if first is None or last is None else (last.front - first.front) / 0.1,
    }


def readings(n: Mapping[str, Any]) -> dict[str, Any]:
    """What is judged, by claim and reading."""

    def coupled(of: Mapping[str, Any]) -> dict[str, float | None]:
        return {"peak": of["coupled"]["peak"]}

    def held(of: Mapping[str, Any]) -> dict[str, float | None]:
        return {name: of["held"][name] for name in ("peak", "front_speed")}

    fine = {text: n[name] for name, text in FINE.items()}
    return {
        "damped": {PAPER: coupled(n["paper"])},
        "damped-converged": {text: coupled(of) for text, of in fine.items()},
        "fires": {PAPER: held(n["paper"])},
        "fires-converged": {
            text: held(of) | {"coupled_peak": of["coupled"]["peak"]} for text, of in fine.items()
        },
    }
