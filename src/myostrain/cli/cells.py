"""Commands of membranes: a cell without a body, and a wave on a cable."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from myostrain.cli.commands import _load_engine, _warnings_shown, app, screen
from myostrain.cli.options import Force, Out, Quiet
from myostrain.errors import InputError, nearest
from myostrain.run.progress import ProgressDisplay

import typer

#: Options of both commands.
Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change a parameter, such as set=ENDO, or stimulus.strength and stimulus.duration.",
    ),
]


def membrane_of(model: str, values: dict[str, Any]) -> Any:
    """A membrane by its name, or by the path of a file that holds it, with values of its parameters.

    Raises:
        InputError: There is no such model, or a value cannot be.
    """
    from myostrain.case.parsing import make
    from myostrain.case.sections import CELLS

    if "/" in model or Path(model).suffix:
        cls, values = CELLS["file"], {"path": str(Path(model).absolute()), **values}
    elif model in CELLS and model != "file":
        cls = CELLS[model]
    else:
        raise InputError(f"'{model}' is not a membrane; {nearest(model, set(CELLS) - {'file'})}", "MODEL")
    return make(cls, getattr(cls, "gathered", dict)(values), "cell", also=("stimulus",))


def _asked(model: str, overrides: list[str] | None) -> tuple[Any, tuple[float, float]]:
    """The membrane of a command, and the stimulus.

    Raises:
        InputError: Neither the command nor the membrane says one, or a key cannot be.
    """
    from myostrain.case.overrides import override
    from myostrain.case.sections import CELLS

    values: dict[str, Any] = {}
    override(values, overrides or [])
    if model in CELLS and isinstance(values.get("cell"), dict):  # as a case has it: cell.g_Na=5
        values = {**values.pop("cell"), **values}
    # A list names a file's own stimulus; strength and duration are those of the pulses that pace.
    names = isinstance(values.get("stimulus"), list) and model not in CELLS
    stimulus = {} if names else values.pop("stimulus", {})
    membrane = membrane_of(model, values)
    known = ("strength", "duration")
    if not isinstance(stimulus, dict) or not set(stimulus) <= set(known):
        raise InputError("give stimulus.strength and stimulus.duration", "--set stimulus")
    if not all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in stimulus.values()):
        raise InputError("give numbers", "--set stimulus")
    declared = dict(zip(known, getattr(membrane, "pacing", None) or (), strict=False))
    both = {**declared, **stimulus}
    if len(both) < 2:
        raise InputError(
            f"{_called(model, membrane)} declares no stimulus: say its strength, a rate of v, and its "
            "duration, such as --set stimulus.strength=40 --set stimulus.duration=1",
            "--set stimulus",
        )
    return membrane, (both["strength"], both["duration"])


def _called(model: str, membrane: Any) -> str:
    """What a command calls a membrane: its name, or that of its file."""
    from myostrain.case.sections import CELLS

    return type(membrane).__name__ if model in CELLS else Path(model).stem


@app.command()
def cell(
    model: Annotated[
        str | None,
        typer.Argument(
            metavar="MODEL", help="A membrane, or a file that holds one; without it, they are listed."
        ),
    ] = None,
    overrides: Overrides = None,
    cycle: Annotated[
        float | None, typer.Option("--cycle", metavar="T", help="Time between two beats; 1000 ms by default.")
    ] = None,
    beats: Annotated[int, typer.Option("--beats", metavar="N", help="Number of beats.")] = 10,
    step: Annotated[
        float | None, typer.Option("--step", metavar="DT", help="Time step; 0.01 ms by default.")
    ] = None,
    out: Out = None,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Pace a membrane without a body.

    It gives durations, calcium, a picture, and a state for a tissue to start from.
    """
    _load_engine()
    from myostrain.case.parsing import plain
    from myostrain.case.sections import CELLS
    from myostrain.output.folder import check_ready, free_name
    from myostrain.single_cell import cell as pace
    from myostrain.single_cell import write_cell

    if model is None:
        for name in sorted(set(CELLS) - {"file"}):
            typer.echo(f"{name:26}{(CELLS[name].__doc__ or '').splitlines()[0]}")
        return
    membrane, stimulus = _asked(model, overrides)
    name = _called(model, membrane)
    folder = out if out is not None else free_name(Path("runs") / f"cell-{name}")
    check_ready(folder, force=force)
    with _warnings_shown(True), ProgressDisplay(True, bar=not quiet) as display:
        paced = pace(
            membrane,
            cycle=cycle,
            beats=beats,
            stimulus=stimulus,
            step=step,
            progress=lambda end: display.start(name, beats, end),
        )
    kind = type(membrane).__name__
    results = write_cell(paced, folder, kind, plain(membrane), force=force, title=name)
    screen.print(f"{name}, beat {beats} of {beats}, a stimulus every {paced.cycle:g}")
    for key in (*paced.last, "alternans"):
        if results[key] is not None:
            unit = results["units"].get(key, "")
            screen.print(f"  {key:22} {results[key]:.5g} {unit}".rstrip())
        elif key in paced.notes:
            screen.print(f"  {key:22} none: {paced.notes[key]}")
    screen.print(f"numbers in {folder / 'results.json'}, the picture {folder / 'figures' / 'cell.png'}")


@app.command()
def cable(
    model: Annotated[str, typer.Argument(metavar="MODEL", help="A membrane, or a file that holds one.")],
    overrides: Overrides = None,
    diffusivity: Annotated[
        float | None,
        typer.Option("--diffusivity", metavar="D", help="0.1 mm²/ms by default; 1 where time has no unit."),
    ] = None,
    velocity: Annotated[
        float | None,
        typer.Option(
            "--velocity",
            metavar="V",
            help="Find the D that gives this velocity, in mm/ms for a membrane in ms.",
        ),
    ] = None,
    spacing: Annotated[
        float | None,
        typer.Option("--spacing", metavar="H", help="Distance between nodes; fine enough by default."),
    ] = None,
    step: Annotated[
        float | None, typer.Option("--step", metavar="DT", help="Time step; fine enough by default.")
    ] = None,
    length: Annotated[
        float | None,
        typer.Option("--length", metavar="L", help="Length of the cable; long enough by default."),
    ] = None,
    mass: Annotated[
        str, typer.Option("--mass", metavar="averaged|lumped", help="Mass matrix, like potential.mass.")
    ] = "averaged",
    out: Out = None,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Measure a membrane's conduction velocity on a cable.

    Or find the diffusivity for a given velocity. The cable is rigid.
    """
    _load_engine()
    from myostrain.case.parsing import plain
    from myostrain.conduction import cable as measure
    from myostrain.conduction import write_cable
    from myostrain.output.folder import check_ready, free_name

    membrane, stimulus = _asked(model, overrides)
    changed = any(text.lstrip().startswith("stimulus") for text in overrides or [])
    name = _called(model, membrane)
    folder = out if out is not None else free_name(Path("runs") / f"cable-{name}")
    check_ready(folder, force=force)
    with _warnings_shown(True), ProgressDisplay(True, bar=not quiet) as display:
        found = measure(
            membrane,
            diffusivity=diffusivity,
            velocity=velocity,
            spacing=spacing,
            step=step,
            length=length,
            stimulus=stimulus if changed else None,
            mass=mass,  # type: ignore[arg-type]
            progress=lambda what, nodes, end: display.start(f"{name}, {what}", nodes, end, "X"),
        )
    kind = type(membrane).__name__
    results = write_cable(found, folder, kind, plain(membrane), force=force, title=name)
    units = results["units"]

    def line(key: str, value: float, of: str) -> None:
        screen.print(f"  {key:22} {value:.5g} {units.get(of, '')}".rstrip())

    screen.print(f"{name} on a rigid cable")
    line("velocity", found.velocity, "velocity")
    if results["velocity_cm_per_s"] is not None:
        line("", results["velocity_cm_per_s"], "velocity_cm_per_s")
    line("error, about", found.error, "velocity")
    line("diffusivity", found.diffusivity, "diffusivity")
    for mesh in results["meshes"]:
        h, dt = (f"{mesh[key]:.4g} {units.get(key, '')}".rstrip() for key in ("spacing", "step"))
        line(f"h = {h}, {dt}", mesh["velocity"], "velocity")
    if found.off is not None:
        screen.print(f"  {'off the wanted one':22} {100 * found.off:.2g} %")
    screen.print(f"numbers in {folder / 'results.json'}, the picture {folder / 'figures' / 'cable.png'}")
