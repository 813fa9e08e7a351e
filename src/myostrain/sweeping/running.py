"""A sweep: a case over values of its keys, one folder per run, one table; resumable."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from myostrain.case.case import Case
from myostrain.case.running import pictures_missing
from myostrain.engine import MPI
from myostrain.errors import InputError
from myostrain.output.folder import check_path, prepare, write_json, writing
from myostrain.output.manifest import claim, make_folder
from myostrain.output.opening import Results
from myostrain.output.opening import open as open_results
from myostrain.output.reader import Reader
from myostrain.sweeping.loops import draw_loops
from myostrain.sweeping.members import Member, Plan, check_same, plan, read_plan
from myostrain.sweeping.picture import choose, draw
from myostrain.sweeping.pool import run_all
from myostrain.sweeping.table import DONE, FAILED, Rows

if TYPE_CHECKING:
    import xarray as xr

#: Is told what goes on, how many runs are done, and how many there are.
Tell = Callable[[str, float, float], None]


class Sweep:
    """A sweep that has ended.

    Attributes:
        folder: Its folder; the runs are in ``001``, ``002``, ...
        table: Every metric over the swept keys, as in ``table.nc``, with units and long names; NaN where a
            run has no such number; ``status`` is "done" or "failed", ``run`` the folder. A key is chosen by
            ``table.sel({"activation.beta": 0.1})``.
        values: Values of the swept keys by run.
        failed: Why runs failed, by run.
        pictures: The pictures drawn.
    """

    def __init__(
        self, folder: Path, table: xr.Dataset, runs: Plan, failed: Mapping[str, str], pictures: Sequence[Path]
    ) -> None:
        self.folder, self.table, self.failed, self.pictures = folder, table, dict(failed), list(pictures)
        self.values = {member.name: dict(member.values) for member in runs.members}
        self._said = {member.name: member.said for member in runs.members}

    @property
    def runs(self) -> dict[str, Results]:
        """The runs that are done, by name, as :func:`myostrain.open` reads them."""
        return {name: open_results(self.folder / name) for name in self.values if name not in self.failed}

    def report(self) -> list[str]:
        """A line for each run that failed: which, with which values, and why."""
        return [f"{name} ({self._said[name]}) failed: {reason}" for name, reason in self.failed.items()]

    def __repr__(self) -> str:
        """How many runs, over what, and which failed."""
        done = len(self.values) - len(self.failed)
        return "\n".join([f"Sweep({self.folder}: {done} of {len(self.values)} runs done)", *self.report()])

    def _repr_html_(self) -> str:
        failed = "".join(f"<li>{line}</li>" for line in self.report())
        return f"{self.table._repr_html_()}<ul>{failed}</ul>"


def sweep(
    case: str | Path | Case | None,
    values: Mapping[str, Any] | None = None,
    *,
    out: str | Path,
    jobs: int = 1,
    grid: bool = True,
    resume: bool = False,
    force: bool = False,
    figures: bool = True,
    plot: Sequence[str] = (),
    tell: Tell | None = None,
) -> Sweep:
    """Run a case over values of its keys; each run is a process of its own and has its own folder.

    A run that fails is reported and left, and the others go on. ``out`` gets ``table.csv`` and ``table.nc``,
    one row per run, and pictures of metrics and of pressure–volume loops.

    Args:
        case: A named case, a case file (a text with "/" or ".toml", or a path), or a case; None goes on with
            the one in ``out``, if ``resume``.
        values: By dotted key a list of values, or one value that all runs have. A value that is a list itself
            is a tuple, or a list in the list: ``{"fibres.direction": [(1, 0), (1, 1)]}``.
        out: Folder of the sweep.
        jobs: How many runs go on at a time.
        grid: Whether every value of a key meets all values of the others; else they go side by side, the
            first values of all keys, the second ones, ...
        resume: Whether to go on with the sweep in ``out``: what is done or has failed is left, what was
            stopped goes on from its checkpoint. Remove the folder of a run that failed to try it again.
        force: Whether results of an earlier sweep in ``out`` may be removed.
        figures: Whether each run draws its figures.
        plot: Metrics of the picture; some that differ by default.
        tell: Is told how far the sweep is.

    Raises:
        InputError: A run's case is not allowed (before any has begun), or ``out`` cannot be used.
    """
    out = Path(out)
    check_path(out, "--out")
    if any(name.startswith(("PMI_", "OMPI_COMM")) for name in os.environ):
        raise InputError("a sweep starts its runs itself: leave mpiexec out, and give --jobs")
    if jobs < 1:
        raise InputError(f"{jobs}: give 1 or more", "--jobs")
    kept = out / "sweep.json"
    runs = _planned(case, values, kept, grid=grid, resume=resume)
    lock = prepare(out, force=force, comm=MPI.COMM_SELF, resume=resume)
    try:
        with writing(out):
            write_json(kept, runs.as_json())
            for member in runs.members:
                claim(out / member.name)
        return _sweep(runs, out, jobs, figures, plot, tell or (lambda name, done, total: None))
    finally:
        if lock is not None:
            lock.release()


def _planned(case: Any, values: Mapping[str, Any] | None, kept: Path, *, grid: bool, resume: bool) -> Plan:
    if case is None:
        if not resume or not kept.exists():
            if resume:
                raise InputError(
                    f"{kept.parent} holds no sweep to go on with (sweep.json); name the folder of one, "
                    "or a case",
                    "--out",
                )
            raise InputError("name a case, or go on with a sweep by --resume --out DIR", "CASE")
        if values:
            raise InputError("goes with CASE: a sweep that has begun has its values", "--set")
        return read_plan(kept)
    asked = plan(case, values or {}, grid=grid)
    if resume and kept.exists():
        check_same(read_plan(kept), asked, kept.parent)
    return asked


def _sweep(runs: Plan, out: Path, jobs: int, figures: bool, plot: Sequence[str], tell: Tell) -> Sweep:
    rows, failed = Rows(runs, out), dict[str, str]()
    waiting = []
    for member in runs.members:
        here = out / member.name
        if (here / "results.json").exists() and not (figures and pictures_missing(here)):
            rows.done(member.name)
        elif failure := _failure(here):
            failed[member.name] = failure
            rows.status[member.name] = FAILED
        else:
            waiting.append(member)
    total, last = len(runs.members), ""

    def ended(member: Member, how: Mapping[str, Any]) -> None:
        if how["status"] == DONE:
            rows.done(member.name)
        else:
            failed[member.name] = str(how.get("reason", how["status"]))
            rows.status[member.name] = FAILED
        with writing(out):
            rows.write_csv()

    def progress(shares: Mapping[str, float]) -> None:
        nonlocal last
        over = len(rows.metrics) + len(failed)
        wrong = f", {len(failed)} failed" if failed else ""
        going = ", ".join(f"{name} {100 * share:.0f} %" for name, share in shares.items())
        said = f"{over} of {total} runs{wrong}{'; ' if going else ''}{going}"
        if said != last:
            tell(said, over + sum(shares.values()), total)
        last = said

    progress({})
    run_all(waiting, out, jobs=jobs, figures=figures, ended=ended, tell=progress)
    with writing(out):
        rows.write_csv()
        table = rows.write_netcdf()
        make_folder(out / "figures")
    about = {name: dict(variable.attrs) for name, variable in table.data_vars.items()}
    pictures = draw(rows, choose(rows, plot), about, out / "figures" / "metrics.png")
    pictures += draw_loops(out, [member for member in runs.members if member.name not in failed])
    ordered = {name: failed[name] for name in rows.status if name in failed}
    return Sweep(out, table, runs, ordered, pictures)


def _failure(folder: Path) -> str | None:
    """Why a run failed at its last try, None if it did not."""
    found = Reader(folder).failure if folder.is_dir() else None
    if found is None:
        return None
    when = "" if found.get("time") is None else f"at t = {float(found['time']):.6g}: "
    return f"{when}{found.get('reason')}"
