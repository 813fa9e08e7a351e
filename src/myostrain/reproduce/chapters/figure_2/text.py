"""The table of bumps and meshes."""

from __future__ import annotations

from typing import Any

from myostrain.reproduce.chapters.figure_2.jobs import KINDS, bumps, fine, meshes
from myostrain.reproduce.chapters.figure_2.pictures import DRAWN
from myostrain.reproduce.content import Measured, Rows
from myostrain.reproduce.words import number


def words(measured: Measured) -> dict[str, Any]:
    """What the words name beside the numbers."""
    cells, step = fine(measured.quick)

    def fired(of: Any) -> str:
        if of["front_speed"] is None:
            return number(of["peak"])
        return (
            f"{of['peak']:.3f}, its front at X = {of['front']:.1f} and travelling at {of['front_speed']:.1f}"
        )

    return {
        "cells": cells,
        "step": step,
        "grid": f"Δx = 1/{cells}, Δt = {number(step)}, second order",
        "paper_step": number(1e-3),
        "drawn": ", ".join(f"{time:g}" for time in DRAWN),
        "fired": {name: fired(measured.numbers[name]["held"]) for name in ("paper", "printed", "sampled")},
    }


def tables(measured: Measured) -> dict[str, Rows]:
    """The rows of the tables."""
    cells, _ = fine(measured.quick)

    def row(title: str, width: float, name: str) -> list[Any]:
        of = measured.numbers[name]
        peaks = [of[kind][peak] for kind in KINDS for peak in ("peak_03", "peak")]
        return [title, width, *peaks, of["held"]["front_speed"]]

    return {
        "bumps": [
            row(f"Δx = 1, implicit, Δt = {number(1e-3)} (the paper's)", 1.5, "paper"),
            row("the same, node X = 0 alone", 0.5, "one"),
            *(
                row("Δx = 1" + (f"/{n}" if n > 1 else ""), 1 + 0.5 / n, f"1/{n}")
                for n in meshes(measured.quick)
            ),
            *(
                row(f"Δx = 1/{cells}, exact, v = {potential}", radius, name)
                for name, (radius, potential) in bumps(measured.quick).items()
            ),
        ]
    }
