"""Commands over several runs: a sweep, a comparison."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from myostrain.cli.commands import _load_engine, _warnings_shown, app, screen
from myostrain.cli.options import CaseName, Quiet
from myostrain.errors import InputError
from myostrain.run.progress import ProgressDisplay, errors

import typer


@app.command()
def sweep(
    case: CaseName = None,
    overrides: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=[V, V, ...]",
            help="Values of a key to sweep over; KEY=VALUE is the same in all runs. Where the values are "
            "lists, give a list of lists: KEY=[[1, 0], [1, 1]].",
        ),
    ] = None,
    listed: Annotated[
        bool,
        typer.Option("--list", help="No grid: the first value of every key, then the second, ..."),
    ] = False,
    jobs: Annotated[int, typer.Option("--jobs", metavar="N", help="How many runs at a time.")] = 1,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder of the sweep; a new one under runs/ by default."),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the sweep in DIR; CASE is not needed.")
    ] = False,
    force: Annotated[
        bool, typer.Option("--force", help="Replace the results of an earlier sweep in DIR.")
    ] = False,
    plot: Annotated[
        str, typer.Option("--plot", metavar="METRIC,...", help="Metrics to draw; a few by default.")
    ] = "",
    figures: Annotated[
        bool, typer.Option("--figures/--no-figures", help="Whether each run draws its figures.")
    ] = True,
    quiet: Quiet = False,
) -> None:
    """Run a case over values of its keys.

    There is one folder per run, a table of all metrics, and a picture.
    """
    _load_engine()
    from myostrain.case.overrides import split
    from myostrain.output.folder import free_name
    from myostrain.sweeping import sweep as run_sweep

    if resume and out is None:
        raise InputError("needs --out DIR, the folder of the sweep to go on with", "--resume")
    values: dict[str, Any] = {}
    for assignment in overrides or []:
        key, value = split(assignment)
        if key in values:
            raise InputError("this key is given twice; put all its values into one list", f"--set {key}")
        values[key] = value
    folder = out or free_name(Path("runs") / f"sweep-{Path(case or '').stem}")
    try:
        with _warnings_shown(True, once=True), ProgressDisplay(True, bar=not quiet) as display:
            done = run_sweep(
                case,
                values,
                out=folder,
                jobs=jobs,
                grid=not listed,
                resume=resume,
                force=force,
                figures=figures,
                plot=[name.strip() for name in plot.split(",") if name.strip()],
                tell=lambda said, n, total: display.computations(said, n, total, "sweep"),
            )
    except KeyboardInterrupt:
        errors.print(f"myostrain: go on with `myostrain sweep --resume --out {folder}`")
        raise
    for line in done.report():
        errors.print(f"myostrain: {line}")
    screen.print(f"{len(done.values) - len(done.failed)} of {len(done.values)} runs done, in {folder}")
    pictures = "".join(f", the picture {path}" for path in done.pictures)
    screen.print(f"the table is {folder / 'table.csv'} and {folder / 'table.nc'}{pictures}")
    raise typer.Exit(3 if done.failed else 0)


@app.command()
def compare(
    folders: Annotated[list[Path], typer.Argument(metavar="DIR", help="Two or more result folders.")],
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Folder for metrics.csv and pictures.")
    ] = None,
    page: Annotated[
        bool,
        typer.Option("--html", help="Everything on one page, index.html; in runs/compare without --out."),
    ] = False,
) -> None:
    """Compare runs: metrics, probes and measures side by side.

    Metrics have their differences from the first run; loops of cavities are drawn over each other.
    """
    from myostrain.output.comparing import compare as beside
    from myostrain.output.folder import free_name

    found = beside(*folders)
    screen.print(repr(found))
    if page and out is None:
        out = free_name(Path("runs") / "compare")
    if out is not None:
        for path in found.write(out, page=page):
            screen.print(str(path))
