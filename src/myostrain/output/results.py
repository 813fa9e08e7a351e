"""The numbers of a run: what ``results.json`` holds."""

from __future__ import annotations

import html
import logging
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from myostrain.engine import MPI
from myostrain.output.citations import bibtex
from myostrain.output.folder import write_atomically, write_json
from myostrain.output.metrics import last_durations, leading_pulse
from myostrain.output.page import table
from myostrain.output.probes import Probes
from myostrain.output.quantities import attributes
from myostrain.solvers.linear import owned_dofs

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from myostrain.coupling import Electromechanics

Array = npt.NDArray[np.float64]

log = logging.getLogger("myostrain")


def metrics(
    model: Electromechanics, probes: Probes, activation: dict[str, list[float]]
) -> tuple[dict[str, float | None], dict[str, str]]:
    """Numbers that describe the present state and the wave so far, and why some do not exist.

    celerity is the material distance of the first two probes over the difference of their first activation
    times; on a line, width_material and width_spatial are of the leading pulse, and front_slope is |∂v/∂X| at
    its front, all at the membrane's threshold; None where a number does not exist.
    """
    potential, mechanics = model.potential, model.mechanics
    comm = potential.body.comm
    v = potential.v.x.array
    celerity, reason = _celerity(probes, activation, model.time)
    notes = {} if reason is None else {"celerity": reason}
    highest = float(comm.allreduce(v.max(initial=-np.inf), MPI.MAX))
    lowest = float(comm.allreduce(v.min(initial=np.inf), MPI.MIN))
    found: dict[str, float | None] = {
        "celerity": celerity,
        "potential_max": highest,
        "potential_min": lowest,
        "amount": potential.amount(),
    }
    low, high = potential.range
    if highest > 2 * high - low or lowest < 2 * low - high:
        notes["potential_max"] = f"far out of the range that the membrane declares, {low:g} to {high:g}"
        log.warning(
            "the potential lies between %.5g and %.5g at the end, far out of the membrane's range, %g to %g: "
            "the stimulus is too strong, or the steps are too long",
            *(lowest, highest, low, high),
        )
    displacement = np.zeros((len(v), potential.body.dim))
    if mechanics is not None:
        displacement = model.transfer.displacement().x.array.reshape(-1, potential.body.dim)
    size = float(np.linalg.norm(displacement, axis=1).max(initial=0.0))
    found["displacement_max"] = float(comm.allreduce(size, MPI.MAX))
    found |= (
        _line_metrics(model, displacement)
        if potential.body.dim == 1
        else dict.fromkeys(("width_material", "width_spatial", "front_slope"))
    )
    return found, notes


def _celerity(
    probes: Probes, activation: dict[str, list[float]], end: float
) -> tuple[float | None, str | None]:
    """The celerity, or why there is none."""
    if len(probes.names) < 2:
        return None, "the celerity is taken between the first two probes, and there are not two"
    names = probes.names[:2]
    for name in names:
        if not activation[name]:
            return None, f"probe '{name}' was not activated"
    first, second = (activation[name][0] for name in names)
    # Times are interpolated in a step: what differs by round-off is at once.
    if abs(second - first) <= 1e-9 * max(abs(end), abs(first), abs(second)):
        return None, f"probes '{names[0]}' and '{names[1]}' were activated at the same time"
    return float(np.linalg.norm(probes.positions[1] - probes.positions[0]) / (second - first)), None


def _line_metrics(model: Electromechanics, displacement: Any) -> dict[str, float | None]:
    space = model.potential.v.function_space
    owned = space.dofmap.index_map.size_local
    X = space.tabulate_dof_coordinates()[:owned, 0]
    parts = model.potential.body.comm.allgather(
        (X, displacement[:owned, 0], model.potential.v.x.array[:owned])
    )
    X, u, v = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(X)
    pulse = leading_pulse(X[order], (X + u)[order], v[order], model.potential.threshold)
    if pulse is None:
        return dict.fromkeys(("width_material", "width_spatial", "front_slope"))
    return {
        "width_material": pulse.width_material,
        "width_spatial": pulse.width_spatial,
        "front_slope": pulse.slope,
    }


def wave_metrics(
    potential: Any, beats: Array, ends: Mapping[float, Array], velocity: Array
) -> dict[str, float | None]:
    """What maps of the nodes say of the whole body; None where no node has a value (collective).

    ``conduction_velocity_median`` of the first activation, and of each percentage of repolarisation
    ``apd90_median``, ``apd90_min`` and ``apd90_max`` of the nodes' last beats that have ended.

    Args:
        potential: The potential.
        beats: Activation times (beats, local nodes).
        ends: Repolarisation times by percentage, likewise.
        velocity: Conduction velocity (local nodes,).
    """
    maps = {f"apd{percent:g}": last_durations(beats, times) for percent, times in ends.items()}
    found: dict[str, float | None] = {}
    for name, values in {"conduction_velocity": velocity, **maps}.items():
        own = values[: owned_dofs(potential.v.function_space)]
        whole = np.concatenate(potential.body.comm.allgather(own[np.isfinite(own)]))
        sorts: dict[str, Any] = {"median": np.median}
        if name in maps:
            sorts |= {"min": np.min, "max": np.max}
        for sort, function in sorts.items():
            found[f"{name}_{sort}"] = float(function(whole)) if len(whole) else None
    return found


def solver_counts(model: Electromechanics) -> dict[str, dict[str, float]]:
    """Solves, iterations, factorizations of each solver; of the coupling, iterations and lags."""
    counts: dict[str, dict[str, float]] = {"potential": {}}
    if model.potential.solver is not None:  # none where the potential is given
        counts["potential"] |= model.potential.solver.counters.as_dict()
    if model.mechanics is not None:
        counts["mechanics"] = {**model.mechanics.solver.counters.as_dict()}
    counts["coupling"] = {
        "iterations": model.coupling_iterations,
        "switches": model.switches,
        "displacement_lag": model.displacement_lag,
        "stretch_lag": model.stretch_lag,
    }
    return counts


def unknowns(model: Electromechanics) -> dict[str, int]:
    """Number of unknowns of each field over all processes."""
    potential = model.potential
    nodes = int(potential.v.function_space.dofmap.index_map.size_global)
    counts = {"potential": nodes, "states": nodes * len(potential.state_names)}
    if model.mechanics is not None:
        space = model.mechanics.u.function_space
        counts["mechanics"] = int(space.dofmap.index_map.size_global * space.dofmap.index_map_bs)
    return counts


def tolerances(model: Electromechanics) -> dict[str, float]:
    """At what the solvers stopped: relative residual of the potential, absolute error of the displacement."""
    found = {}
    if model.potential.solver is not None:
        found["potential"] = float(model.potential.solver.ksp.getTolerances()[0])
    if model.mechanics is not None:
        found["mechanics"] = model.mechanics.solver.tolerance
    return found


class Outcome(dict[str, Any]):
    """What ``results.json`` holds; a notebook shows the metrics, with their meaning."""

    def _repr_html_(self) -> str:
        rows = []
        for name, value in self["metrics"].items():
            about = attributes(name, self["units"], None)
            unit = about.get("units", "").removeprefix("1")
            rows.append((name, "–" if value is None else f"{value:.5g}", unit, about["long_name"]))
        took = f"{self['steps']} steps to t = {self['time']:g} in {self['seconds']['total']:.1f} s"
        head = f"<b>{html.escape(str(self['case']))}</b>: {took}"
        return head + table(("metric", "value", "unit", "meaning"), rows)


def write(out: Path, results: Mapping[str, Any]) -> None:
    """Write ``references.bib``, what to cite for a run, and ``results.json``, last.

    Args:
        out: The result folder.
        results: What ``results.json`` holds.

    Raises:
        OSError: They cannot be written.
    """
    write_atomically(out / "references.bib", bibtex(results["citations"]))
    write_json(out / "results.json", results)


def about_solution(model: Electromechanics) -> dict[str, Any]:
    """How and with what effort the model was solved."""
    scheme = model.scheme
    return {
        "scheme": {"name": type(scheme).__name__, **vars(scheme), "order": scheme.order},
        "tolerances": tolerances(model),
        "solver": solver_counts(model),
        "cells": model.potential.body.cells,
        "unknowns": unknowns(model),
    }
