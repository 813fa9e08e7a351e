"""Running a case into a result folder: the steps of ``myostrain run``, for scripts too."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from myostrain import cases
from myostrain.case.case import Case
from myostrain.engine import MPI
from myostrain.errors import InputError
from myostrain.output import curves, published
from myostrain.output.codes import compare_times, known
from myostrain.output.folder import check_path, load_results, on_first, write_atomically, write_json, writing
from myostrain.output.lock import FolderLock
from myostrain.output.log import RunLog, log_end, log_start
from myostrain.output.manifest import claim
from myostrain.run.resume import differences, fixed, said
from myostrain.run.schedule import Progress

#: Is in the result folder while figures are drawn.
DRAWING = ".drawing"

#: Keys that leave the problem which is solved as it is.
NUMERICS = (
    *("name.", "title.", "cost.", "units.", "output.", "probes.", "electrodes.", "solver."),
    *(
        "geometry.spacing.",
        "geometry.order.",
        "geometry.layers.",
        "geometry.apex_ratio.",
        "geometry.apex_reach.",
        "potential.refinement.",
        "potential.mass.",
        "potential.reaction.",
        "time.step.",
        "time.scheme.",
    ),
    *("mechanics.every.", "mechanics.tolerance.", "mechanics.augmentation.", "mechanics.ellipticity."),
    *("mechanics.spectral_radius.", "mechanics.normals."),
)

#: Metrics of the rigid twin that are compared.
COMPARED = (
    *("celerity", "width_material", "width_spatial"),
    *("tip_period", "tip_radius", "tip_drift", "tip_deviation"),
)


def run_case(
    case: Case,
    out: str | Path,
    *,
    force: bool = False,
    resume: bool = False,
    comm: Any = MPI.COMM_WORLD,
    progress: Callable[[str, int, float], Progress] | None = None,
    figures: bool = True,
    draw: Callable[[Path], object] | None = None,
    start_seconds: float = 0.0,
) -> dict[str, Any]:
    """Run a case, and its rigid twin where it has one, and draw its figures.

    Args:
        case: The case.
        out: Result folder.
        force: Whether results of an earlier run in ``out`` may be removed.
        resume: Whether to go on from the last checkpoint in ``out``; of a run that ended, the results are
            returned, unless the case has a later end.
        comm: MPI communicator.
        progress: Makes what is told of the progress, from a name, the number of steps and the end.
        figures: Whether to draw.
        draw: Draws the figures of a result folder; by default
            :func:`~myostrain.output.figures.draw.draw`.
        start_seconds: Seconds that passed before, for the record.

    Returns:
        What ``results.json`` holds.

    Raises:
        InputError: The case cannot be run as it is.
        ComputationError: The computation failed.
        Interrupted: A signal ended it after a checkpoint.
    """
    if not isinstance(case, Case):
        raise InputError(f"{case!r}: give a Case, such as Case.from_file(cases.path('pulse-1d'))", "case")
    out = Path(out)
    check_path(out, "--out")
    if resume and (ended := _ended(out, comm)) and not goes_on(case, ended):
        _draw(out, comm, wanted=figures and pictures_missing(out), draw=draw)
        return ended
    simulation = case.simulation(comm, out, force, resume)
    try:
        on_first(comm, partial(_begin, case, out), out / "case.toml")
        with RunLog(out, comm, append=resume):
            log_start(case.parameters, simulation.model, comm.size)
            twin: dict[str, Any] | None = None
            if case.output.rigid_twin:
                twin = run_case(
                    case.rigid(),
                    out / "rigid",
                    force=resume and not (out / "rigid" / "case.toml").exists(),
                    resume=resume and (out / "rigid" / "case.toml").exists(),
                    comm=comm,
                    progress=progress,
                    figures=False,
                )

            def finish(results: dict[str, Any]) -> None:
                results["seconds"] |= {"start": start_seconds}
                results["seconds"]["total"] += start_seconds
                if twin is not None:
                    results["metrics"] |= compare(results["metrics"], twin["metrics"])
                if changes := changed_problem(case):
                    results["notes"]["benchmark"] = (
                        f"not compared with published numbers, which are of another problem: {said(changes)}"
                    )
                elif found := compare_times(case.name, results["probes"]):
                    results["metrics"] |= found["times"]
                    results["published"] = found
                elif curves.known(case.name):
                    found = curves.compare(case.name, out, comm)
                    results["metrics"] |= {f"rms_{key}": entry["rms"] for key, entry in found.items()}
                    results["curves"] = found
                elif found := published.compare(case.name, simulation.model.mechanics, out, comm):
                    results["metrics"] |= {name: entry["value"] for name, entry in found.items()}
                    results["benchmark"] = found

            shown = None if progress is None else progress(case.name, simulation.steps, simulation.end)
            results = simulation.run(shown, finish)
            log_end(results)
    finally:
        simulation.close()
    with RunLog(out, comm, append=True):
        spent = _draw(out, comm, wanted=figures, draw=draw)
        results["seconds"] |= {"figures": spent, "total": results["seconds"]["total"] + spent}
        on_first(comm, lambda: write_json(out / "results.json", results), out / "results.json")
    return results


def _begin(case: Case, out: Path) -> None:
    if case.output.rigid_twin:
        claim(out / "rigid")
    (out / "results.json").unlink(missing_ok=True)  # of a run that goes on to a later end
    write_atomically(out / "case.toml", case.to_toml())


def changed_problem(case: Case) -> dict[str, tuple[Any, Any]]:
    """In what a case that is called as one with published numbers is another problem; else nothing.

    Mesh sizes, load steps, solvers and what is written belong to no problem.
    """
    over_time = known(case.name) or curves.known(case.name)
    if published.find(case.name) is None and not over_time:
        return {}
    shipped = Case.from_file(cases.path(case.name)).parameters
    found = differences(shipped, json.loads(json.dumps(case.parameters)))
    kept = (*NUMERICS, "time.end.") if over_time else NUMERICS  # when, not whether, it is activated
    return {key: pair for key, pair in found.items() if not f"{key}.".startswith(kept)}


def goes_on(case: Case, ended: Mapping[str, Any]) -> bool:
    """Whether a case goes on where a run has ended: to a later end.

    Args:
        case: The case.
        ended: ``results.json`` of the run.

    Raises:
        InputError: It differs otherwise.
    """
    found = differences(ended.get("parameters", {}), json.loads(json.dumps(case.parameters)))
    if not found:
        return False
    refused = fixed(found)
    if refused or case.time.end <= ended["time"] * (1 + 1e-9):
        raise InputError(
            f"the run had ended, at t = {ended['time']:g}, and was another ({said(refused or found)}): put "
            "that back, give a later time.end to go on, or run it again into another folder",
            "--resume",
        )
    return True


def _ended(out: Path, comm: Any) -> dict[str, Any] | None:
    """The results of a run that has ended, None of one that has not (collective)."""
    found: dict[str, Any] | InputError | None = None
    if comm.rank == 0 and (out / "results.json").exists():
        try:
            found = load_results(out)
        except InputError as error:
            found = error
    found = comm.bcast(found, root=0)
    if isinstance(found, InputError):
        raise found
    return found


def _draw(out: Path, comm: Any, *, wanted: bool, draw: Callable[[Path], object] | None) -> float:
    """Draw the figures of a run that has ended, on the first process; returns the seconds it took.

    Until all are there the folder says so, and a run that is killed meanwhile draws them when it is resumed.
    """
    begin, problem = time.perf_counter(), None
    if wanted and comm.rank == 0 and (out / "snapshots").is_dir():
        try:
            _drawn(out, draw)
        except InputError as error:
            problem = error
    problem, spent = comm.bcast((problem, time.perf_counter() - begin), root=0)
    if problem is not None:
        raise problem
    return float(spent)


def _drawn(out: Path, draw: Callable[[Path], object] | None) -> None:
    if draw is None:
        from myostrain.output.figures import draw as here

        draw = here.draw
    with writing(out):
        lock = FolderLock(out)
        write_atomically(out / DRAWING)
    try:
        draw(out)
        (out / DRAWING).unlink(missing_ok=True)
    finally:
        lock.release()


def pictures_missing(out: Path) -> bool:
    """Whether a run that has ended was stopped before all its figures were drawn."""
    return (out / "snapshots").is_dir() and (not (out / "figures").exists() or (out / DRAWING).exists())


def compare(metrics: dict[str, Any], rigid: dict[str, Any]) -> dict[str, Any]:
    """The rigid twin's metrics and the ratios to them, None where a number does not exist."""
    found: dict[str, Any] = {}
    for name in (name for name in COMPARED if name in metrics):
        own, other = metrics[name], rigid[name]
        found[f"{name}_rigid"] = other
        found[f"{name}_ratio"] = own / other if own is not None and other else None
    return found
