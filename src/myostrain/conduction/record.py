"""The result folder of a cable: ``results.json``, and a picture of the wave and the fit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from myostrain.conduction.measuring import Conducted
from myostrain.conduction.wave import MEASURED
from myostrain.engine import MPI, versions
from myostrain.output.figures.style import BLUE, GREY, VERMILION, new_figure, save, style
from myostrain.output.folder import results_folder, write_json

import matplotlib as mpl
import numpy as np


def units_of(membrane: Any) -> dict[str, str]:
    """Units of what a cable has, lengths in mm; none for a non-dimensional membrane."""
    time = getattr(membrane, "time_unit", None)
    potential = getattr(membrane, "potential_unit", None)
    found = {} if potential is None else {"potential": potential}
    if time is None:
        return found
    speeds = dict.fromkeys(("velocity", "error", "wanted"), f"mm/{time}")
    lengths = dict.fromkeys(("spacing", "length", "excited"), "mm")
    return (
        found | speeds | lengths | {"step": time, "diffusivity": f"mm²/{time}", "velocity_cm_per_s": "cm/s"}
    )


def results_of(found: Conducted, model: str, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """What ``results.json`` holds.

    Args:
        found: What was measured.
        model: Name of the membrane.
        parameters: Its parameters, all resolved.
    """
    first = found.waves[0].cable
    cm = found.velocity * found.centimetres
    return {
        "model": model,
        "completed": True,
        "velocity": found.velocity,
        "velocity_cm_per_s": None if math.isnan(cm) else cm,
        "error": found.error,
        "diffusivity": found.diffusivity,
        "wanted": found.wanted,
        "off": found.off,
        "tried": [{"diffusivity": D, "velocity": v} for D, v in found.tried],
        "meshes": [
            {
                "spacing": float(wave.X[1]),
                "step": wave.cable.step,
                "nodes": len(wave.X),
                "velocity": wave.velocity,
                "unsteady": wave.unsteady,
            }
            for wave in found.waves
        ],
        "length": first.length,
        "excited": first.excited,
        "stimulus": dict(zip(("strength", "duration"), first.stimulus, strict=True)),
        "mass": first.mass,
        "units": units_of(found.membrane),
        "parameters": dict(parameters),
        "versions": versions(),
    }


def write_cable(
    found: Conducted,
    out: Path,
    model: str,
    parameters: Mapping[str, Any],
    *,
    force: bool = False,
    title: str | None = None,
) -> dict[str, Any]:
    """Write a result folder.

    Args:
        found: What was measured.
        out: The folder.
        model: Name of the membrane.
        parameters: Its parameters, all resolved.
        force: Whether results of an earlier run in it may be removed.
        title: What the picture calls it; the name unless given.

    Returns:
        What ``results.json`` holds.

    Raises:
        InputError: The folder holds something already, or cannot be written.
    """
    results = results_of(found, model, parameters)
    with results_folder(out, "cable", force=force, comm=MPI.COMM_SELF) as picture:
        draw_cable(found, title or model, picture)
        write_json(out / "results.json", results)
    return results


def draw_cable(found: Conducted, model: str, path: Path) -> Path:
    """Draw the wave of the finest mesh: the potential along X at times, and when it comes, with the fit.

    Args:
        found: What was measured.
        model: What the membrane is called.
        path: Where to, replaced if it exists.

    Raises:
        InputError: It cannot be written.
    """
    wave, units = found.waves[-1], units_of(found.membrane)

    def label(text: str, of: str) -> str:
        return f"{text} ({units[of]})" if of in units else text

    speed = f"{found.velocity:.4g} {units.get('velocity', '')}".strip()
    if not math.isnan(found.centimetres):
        speed += f" = {found.velocity * found.centimetres:.4g} cm/s"
    D = f"D = {found.diffusivity:.4g} {units.get('diffusivity', '')}".strip()
    with style():
        figure = new_figure(8.4, 3.6, f"{model}: {speed} at {D}")
        along, when = figure.subplots(1, 2)
        colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, len(wave.frames)))
        for (time, v), colour in zip(wave.frames, colours, strict=True):
            along.plot(wave.X, v, color=colour, linewidth=1.4, label=f"{time:.3g}")
        along.axhline(found.membrane.threshold, color=GREY, linewidth=0.8, linestyle=":")
        along.set_xlabel(label("X", "length"))
        along.set_ylabel(label("potential", "potential"))
        beside = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5)}
        along.legend(title=label("time", "step"), fontsize=8, title_fontsize=8, **beside)
        along.margins(x=0)
        slope, start = wave.fit()
        begin, end = (share * wave.X[-1] for share in MEASURED)
        when.axvspan(begin, end, color=GREY, alpha=0.15, linewidth=0, label="measured here")
        when.plot(wave.X, wave.activation, color=BLUE, label="activation time")
        when.plot(wave.X, start + wave.X / slope, color=VERMILION, linestyle="--", linewidth=1.2, label="fit")
        when.set_xlabel(label("X", "length"))
        when.set_ylabel(label("time", "step"))
        when.set_ylim(0, None)
        when.margins(x=0)
        when.legend(loc="upper left")
        return save(figure, path)
