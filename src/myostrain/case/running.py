"""Running a case into a result folder: the steps of ``myostrain run``, for scripts too."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from myostrain.case.case import Case
from myostrain.engine import MPI
from myostrain.output import published
from myostrain.output.folder import on_first, write_atomically
from myostrain.output.log import RunLog, log_end, log_start
from myostrain.run.simulation import Progress

#: Metrics of the rigid twin that are compared.
COMPARED = ("celerity", "width_material", "width_spatial")


def run_case(
    case: Case,
    out: str | Path,
    *,
    force: bool = False,
    resume: bool = False,
    comm: Any = MPI.COMM_WORLD,
    progress: Callable[[str, int, float], Progress] | None = None,
    figures: bool = True,
) -> dict[str, Any]:
    """Run a case, and its rigid twin where it has one, and draw its figures.

    Args:
        case: The case.
        out: Result folder.
        force: Whether results of an earlier run in ``out`` may be removed.
        resume: Whether to go on from the last checkpoint in ``out``; of a run that ended, the results are
            returned.
        comm: MPI communicator.
        progress: Makes what is told of the progress, from a name, the number of steps and the end.
        figures: Whether to draw.

    Returns:
        What ``results.json`` holds.

    Raises:
        InputError: The case cannot be run as it is.
        ComputationError: The computation failed.
        Interrupted: A signal ended it after a checkpoint.
    """
    out = Path(out)
    if resume and comm.bcast((out / "results.json").exists() if comm.rank == 0 else None, root=0):
        _draw(out, comm, wanted=figures and not (out / "figures").exists())
        return load_results(out)
    simulation = case.simulation(comm, out, force, resume)
    try:
        on_first(comm, lambda: write_atomically(out / "case.toml", case.to_toml()), out / "case.toml")
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
                if twin is not None:
                    results["metrics"] |= compare(results["metrics"], twin["metrics"])
                if found := published.compare(case.name, simulation.model.mechanics, out, comm):
                    results["metrics"] |= {name: entry["value"] for name, entry in found.items()}
                    results["benchmark"] = found

            shown = None if progress is None else progress(case.name, simulation.steps, simulation.end)
            results = simulation.run(shown, finish)
            log_end(results)
    finally:
        simulation.close()
    with RunLog(out, comm, append=True):
        _draw(out, comm, wanted=figures)
    return results


def _draw(out: Path, comm: Any, *, wanted: bool) -> None:
    """Draw the figures of a run that has ended, on the first process."""
    if wanted and comm.rank == 0 and (out / "snapshots").is_dir():
        from myostrain.output.figures.draw import draw

        draw(out)
    comm.Barrier()


def compare(metrics: dict[str, Any], rigid: dict[str, Any]) -> dict[str, Any]:
    """The rigid twin's metrics and the ratios to them, None where a number does not exist."""
    found: dict[str, Any] = {}
    for name in COMPARED:
        own, other = metrics[name], rigid[name]
        found[f"{name}_rigid"] = other
        found[f"{name}_ratio"] = own / other if own is not None and other else None
    return found


def load_results(folder: Path) -> dict[str, Any]:
    """Read ``results.json`` of a folder."""
    return dict(json.loads((folder / "results.json").read_text(encoding="utf-8")))
