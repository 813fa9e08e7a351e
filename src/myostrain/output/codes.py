"""Activation times of a run beside those of published codes."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from importlib import resources
from typing import Any

#: Cases with published activation times, and where these are.
FOLDERS = {"niederer-3d": "niederer"}

#: What finite differences tend to (tests/reference/niederer_fd.py), ms, by case and point.
CONVERGED = {
    "niederer-3d": dict(
        zip(
            (f"P{number}" for number in range(1, 10)),
            (1.221, 26.39, 31.60, 41.19, 8.24, 27.78, 32.80, 42.19, 19.52),
            strict=True,
        )
    )
}


def known(name: str) -> bool:
    """Whether codes have published activation times of the case of this name."""
    return name in FOLDERS


def published_times(name: str) -> list[dict[str, Any]]:
    """What codes found: code, method, spacing, step, source, and the times by point."""
    file = resources.files("myostrain.cases") / FOLDERS[name] / "activation_times.csv"
    texts = ("code", "method", "source")
    return [
        {key: value if key in texts else float(value) for key, value in row.items()}
        for row in csv.DictReader(file.read_text(encoding="utf-8").splitlines())
    ]


def compare_times(name: str, probes: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """What ``results.json`` holds under ``published``; empty for a case without published times.

    Args:
        name: Name of the case.
        probes: What ``results.json`` holds of the probes.

    Returns:
        ``times`` by point, None of one that was never activated; ``codes``, see :func:`published_times`;
        ``converged`` by point, where known; and ``error``, relative to it.
    """
    if not known(name):
        return {}
    codes, converged = published_times(name), CONVERGED[name]
    points = [key for key in codes[0] if key.startswith("P")]
    times = {point: probes[point]["activation_time"] for point in points if point in probes}
    errors = {
        point: times[point] / value - 1 for point, value in converged.items() if times.get(point) is not None
    }
    return {"times": times, "converged": converged, "error": errors, "codes": codes}
