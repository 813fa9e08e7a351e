"""Pictures of a result folder, drawn from the folder alone."""

from __future__ import annotations

from pathlib import Path

from myostrain.output.figures.data import Recording
from myostrain.output.figures.line import draw_line
from myostrain.output.figures.published import draw_benchmark
from myostrain.output.figures.sheet import draw_sheet
from myostrain.output.figures.solid import draw_solid
from myostrain.output.figures.style import COLOURS, GREY, SEQUENTIAL, new_figure, plain, save, style
from myostrain.output.folder import writing
from myostrain.output.manifest import make_folder

from matplotlib import colormaps


def draw(folder: Path) -> list[Path]:
    """Draw everything a result folder is about into ``folder/figures``.

    A line gives ``potential.png``, ``evolution.png`` and ``space-time.png``, with the rigid twin in
    ``folder/rigid`` beside it if there is one; a sheet gives ``potential.png``, ``stress.png``,
    ``activation.png`` and ``animation.gif``; a solid these, ``displacement.png`` and ``fibres.png``, if
    PyVista is there; probes of any body give ``probes.png``, published numbers to compare with ``land.png``.
    What was not recorded, or not any more because the run failed, is left out. Files of earlier calls are
    replaced.

    Args:
        folder: The result folder of a run.

    Returns:
        The files written, in the order above; empty if the run ended before its first frame.

    Raises:
        InputError: The folder holds no snapshots, a file in it cannot be read, or nothing can be
            written into it.
    """
    folder = Path(folder)
    run = Recording(folder)
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
        elif len(run.time) and run.dim == 3:
            written += draw_solid(run, figures)
        written += _probes(run, figures / "probes.png")
    return written + (draw_benchmark(folder, run.results) if run.results else [])


def _probes(run: Recording, path: Path) -> list[Path]:
    """v over time at the probes."""
    times, histories = run.probe_histories("potential")
    if len(times) < 2 or not histories:
        return []
    figure = new_figure(7.2, 3.4, run.title)
    panel = figure.add_subplot()
    count = len(histories)
    colours = (
        COLOURS[:count] if count <= len(COLOURS) else [colormaps[SEQUENTIAL](i / count) for i in range(count)]
    )
    lines = [panel.plot(times, v, color=c)[0] for v, c in zip(histories.values(), colours, strict=True)]
    panel.legend(
        lines, [f" {plain(name)}" for name in histories], loc="center left", bbox_to_anchor=(1.0, 0.5)
    )
    panel.axhline(0, color=GREY, linewidth=0.5, zorder=1)
    panel.set(xlabel=run.label("$t$", "time"), ylabel=run.label("$v$", "potential"))
    panel.margins(x=0)
    return [save(figure, path)]
