"""Pictures of a result folder, drawn from the folder alone."""

from __future__ import annotations

from pathlib import Path

from myostrain.errors import InputError, nearest
from myostrain.output.figures.choice import Choice, choice, choosing
from myostrain.output.figures.codes import draw_codes
from myostrain.output.figures.course import draw_deformation, draw_probes, hues
from myostrain.output.figures.curves import draw_curves
from myostrain.output.figures.data import Recording
from myostrain.output.figures.line import draw_line
from myostrain.output.figures.loops import draw_loops
from myostrain.output.figures.maps import nodal_maps
from myostrain.output.figures.measures import draw_measures
from myostrain.output.figures.published import draw_benchmark
from myostrain.output.figures.sheet import draw_sheet
from myostrain.output.figures.shown import PICTURES
from myostrain.output.figures.solid import draw_solid
from myostrain.output.figures.style import GREY, new_figure, plain, save, style
from myostrain.output.figures.tips import draw_tips
from myostrain.output.folder import writing
from myostrain.output.manifest import make_folder

import numpy as np
import numpy.typing as npt

#: Pictures that are of no field of the frames.
OTHERS = (
    "animation",
    "deformation",
    "ecg",
    "evolution",
    "fibres",
    "loops",
    "maps",
    "measures",
    "probes",
    "space-time",
    "tip",
)

Array = npt.NDArray[np.float64]


def draw(folder: Path, wanted: Choice | None = None) -> list[Path]:
    """Draw what is wanted; by default everything a result folder is about into ``folder/figures``.

    A line gives ``potential.png``, ``evolution.png``, ``space-time.png``, with the rigid twin in
    ``folder/rigid`` beside it if there is one, and ``maps.png``; a sheet gives ``potential.png``,
    ``stress.png``, ``activation-times.png``, ``apd90.png``, ``conduction-velocity.png``, ``animation.gif``,
    and ``tip.png`` of a spiral; a solid these, ``displacement.png`` and ``fibres.png``, if PyVista is there;
    cavities ``loop.png``, ``cavities.png`` and ``wiggers.png``; what is measured ``measures.png``, with
    segments ``strains.png`` and ``bullseye.png``; a body that deforms ``deformation.png``; probes give
    ``probes.png``, electrodes ``ecg.png``, published numbers to compare with ``land.png``, published
    activation times or displacements ``published.png``.
    What was not recorded, or not any more because the run failed, is left out. Files of earlier calls are
    replaced.

    Args:
        folder: The result folder of a run.
        wanted: Formats, resolution, times and fields. A field that was recorded is a picture of its own.

    Returns:
        The files written, in the order above; empty if the run ended before its first frame.

    Raises:
        InputError: The folder holds no snapshots or nothing of what is wanted, a file in it cannot be read,
            or nothing can be written into it.
    """
    folder, wanted = Path(folder), wanted or Choice()
    with choosing(wanted):
        written = _draw(folder)
    if wanted.fields and not written:
        raise InputError(f"{folder} holds nothing to draw of {', '.join(wanted.fields)}", "--fields")
    formats = [f".{name}" for name in wanted.formats]
    return [
        path.with_suffix(suffix)
        for path in written
        for suffix in (formats if path.suffix == ".png" else [path.suffix])
    ]


def _draw(folder: Path) -> list[Path]:
    run = Recording(folder)
    wants = choice().wants
    _check_fields(run)
    rigid = folder / "rigid"
    twin = Recording(rigid) if (rigid / "snapshots" / "mesh.npz").is_file() else None
    figures = folder / "figures"
    with style():
        with writing(figures):
            make_folder(figures)
        written = []
        if len(run.time) and run.dim == 1:
            written += draw_line(run, twin, figures)
        elif len(run.time) and run.dim == 2:
            written += draw_sheet(run, figures)
            written += draw_tips(run, twin, figures / "tip.png") if wants("tip") else []
        elif len(run.time) and run.dim == 3:
            written += draw_solid(run, figures)
        if wants("loops"):
            written += draw_loops(run, figures)
        if wants("measures"):
            written += draw_measures(run, figures)
        if wants("deformation"):
            written += draw_deformation(run, figures / "deformation.png")
        if wants("probes"):
            written += draw_probes(run, figures / "probes.png")
        leads = run.table("ecg.csv")
        times, label = leads.pop("time", np.empty(0)), "$\\varphi$ over $\\sigma / \\sigma_e$"
        if run.dim == 3:
            label = run.label(label, "potential")
        if wants("ecg"):
            written += _signals(run, times, leads, label, 0.0, figures / "ecg.png")
    if not run.results or choice().fields:
        return written
    beside = (draw_benchmark, draw_codes, draw_curves)
    return [*written, *(file for draw in beside for file in draw(folder, run.results))]


def _check_fields(run: Recording) -> None:
    """Refuse what cannot be drawn."""
    maps = [each.name for each in nodal_maps(run)]
    known = {*run.snapshots.names, *PICTURES, *maps, *OTHERS}
    for name in choice().fields:
        if name in PICTURES and not run.has(PICTURES[name]):
            raise InputError(
                f"no field '{PICTURES[name]}' was written, which '{name}' shows: add it to output.fields and "
                "run again",
                "--fields",
            )
        if name not in known:
            raise InputError(f"there is no '{name}' to draw; {nearest(name, known)}", "--fields")


def _signals(
    run: Recording, times: Array, signals: dict[str, Array], label: str, level: float, path: Path
) -> list[Path]:
    """Values over time, one curve per name, and a thin line at a level."""
    if len(times) < 2 or not signals:
        return []
    figure = new_figure(7.2, 3.4, run.heading)
    panel = figure.add_subplot()
    curves = zip(signals.values(), hues(len(signals)), strict=True)
    lines = [panel.plot(times, v, color=c)[0] for v, c in curves]
    panel.legend(lines, [f" {plain(name)}" for name in signals], loc="center left", bbox_to_anchor=(1.0, 0.5))
    panel.axhline(level, color=GREY, linewidth=0.5, zorder=1)
    panel.set(xlabel=run.label("$t$", "time"), ylabel=label)
    panel.margins(x=0)
    return [save(figure, path)]
