"""The objects that run, from the descriptions of a case."""

from __future__ import annotations

import logging
import time
from pathlib import Path
from typing import Any

from myostrain import geometry
from myostrain.case import size_estimate
from myostrain.case.parsing import plain
from myostrain.coupling import Electromechanics
from myostrain.course import missed_peaks
from myostrain.electrics import GivenPotential, Potential
from myostrain.mechanics import Loads, Mechanics, Supports, unloaded
from myostrain.mechanics.loads import components_of
from myostrain.run.simulation import Simulation
from myostrain.single_cell import end_state, resting_at
from myostrain.transfer import NestedMesh, SameMesh, Transfer

log = logging.getLogger("myostrain")

#: Tolerance of the mechanics at least in the search for the unloaded reference.
UNLOADED = 1e-8


def model(case: Any, comm: Any) -> Electromechanics:
    """Make the coupled problem of a case, with the initial values set.

    Args:
        case: A :class:`~myostrain.Case`.
        comm: MPI communicator.

    Raises:
        InputError: What only shows on the mesh.
    """
    body = geometry.build(case.geometry, case.fibres, comm)
    levels = case.potential.refinement
    size_estimate.check_refinement(case, body)
    if case.is_rigid:
        return Electromechanics(_potential(case, geometry.refined(body, levels), None), scheme=case.scheme)
    parts = _mechanics(case)
    if case.unload:
        pressures = case.cavities.circuit().preload.tolist()
        named = dict(zip(case.cavities.names, pressures, strict=True))
        body = unloaded(body, named, **{**parts, "tolerance": min(UNLOADED, case.mechanics.tolerance)})
    fine = geometry.refined(body, levels)
    mechanics = Mechanics(body, **parts)
    transfer: Transfer = NestedMesh(mechanics, fine) if levels else SameMesh(mechanics)
    coupled = dict(law=case.law, scheme=case.scheme, activity=_activity(case, fine), transfer=transfer)
    if case.drive is not None:
        given: Any = GivenPotential(body, case.drive)
        return Electromechanics(given, mechanics, **coupled)
    return Electromechanics(_potential(case, fine, transfer.deformation), mechanics, **coupled)


def _mechanics(case: Any) -> dict[str, Any]:
    """What the mechanics of a case is made of."""
    return dict(
        kinematics=case.kinematics,
        material=case.material,
        active=case.active,
        supports=Supports(
            fixed=case.mechanics.fixed,
            sliding=case.mechanics.sliding,
            displacement=case.mechanics.displacement or {},
            robin=case.mechanics.robin,
            robin_boundary=case.mechanics.robin_boundary,
            robin_normal=case.mechanics.robin_normal or {},
            damping=case.mechanics.damping or {},
            damping_normal=case.mechanics.damping_normal or {},
            normals=case.mechanics.normals,
            support_factor=case.mechanics.support_factor or {},
        ),
        loads=Loads(pressure=case.mechanics.pressure or {}, traction=case.mechanics.traction or {}),
        cavities=case.cavities,
        relaxation_time=case.mechanics.relaxation_time,
        viscosity=case.mechanics.viscosity,
        density=case.mechanics.density,
        spectral_radius=case.mechanics.spectral_radius,
        imposed_stretch=case.mechanics.imposed_stretch,
        tolerance=case.mechanics.tolerance,
        options=case.solver.get("mechanics"),
    )


def _potential(case: Any, body: geometry.Body, deformation: Any) -> Potential:
    return Potential(
        body,
        membrane=_begun(case),
        diffusivity=case.potential.diffusivity,
        balance=case.potential.balance,
        mass=case.potential.mass,
        reaction=case.potential.reaction,
        deformation=deformation,
        integrator=case.beginning.integrates(case.cell),
        variations=case.variations,
        initial=case.initial,
        stimuli=case.stimuli,
        stretch_currents=case.stretch_currents,
        options=case.solver.get("potential"),
    )


def _activity(case: Any, body: geometry.Body) -> Any:
    ends = case.transmural.transmural
    if ends is None:
        return 1.0
    return geometry.transmural(body, ends, case.transmural.transmural_between)


def _warn_of_missed_peaks(case: Any, step: float) -> None:
    """Warn of peaks in time that lie between two steps, where nothing sees them."""
    courses: dict[str, Any] = {
        f"mechanics.pressure.{k}": c for k, c in (case.mechanics.pressure or {}).items()
    }
    for part, components in (case.mechanics.displacement or {}).items():
        courses |= {f"mechanics.displacement.{part}.{name}": c for name, c in components.items()}
    for part, course in (case.mechanics.traction or {}).items():
        for i, component in enumerate(components_of(course)):
            courses[f"mechanics.traction.{part}.{i}"] = component
    if case.drive is not None:
        courses["drive.potential"] = case.drive.potential
    for key, course in courses.items():
        for when, value in missed_peaks(course, step, case.time.end):
            log.warning(
                "%s: its peak %g at t = %g lies between two steps of %g and is not reached; take steps "
                "that hit it",
                key,
                value,
                when,
                step,
            )


def _begun(case: Any) -> Any:
    """The membrane, with its rest where a cell ended if the case says so."""
    folder = case.beginning.initial
    if folder is None:
        return case.cell
    end = end_state(folder, case.cell, type(case.cell).__name__, plain(case.cell))
    return resting_at(case.cell, end)


def _files(case: Any) -> dict[str, tuple[Path, ...]]:
    """The files that the case is from, by the key that names them."""
    parts = {"geometry.path": case.geometry, "fibres.path": case.fibres, "cell.path": case.cell}
    found = {key: part.files for key, part in parts.items() if hasattr(part, "files")}
    if case.drive is not None and case.drive.path is not None:
        found["drive.path"] = (case.drive.path,)
    if case.beginning.initial is not None:
        found["cell.initial"] = (case.beginning.initial / "results.json",)
    tables = [stimulus.times for stimulus in case.stimuli if stimulus.times is not None]
    if tables:
        found["stimulus.times"] = tuple(tables)
    return found


def simulation(case: Any, comm: Any, out: Path | None, force: bool, resume: bool) -> Simulation:
    """Build the model of a case and the simulation that runs it.

    Args:
        case: A :class:`~myostrain.Case`.
        comm: MPI communicator.
        out: Result folder; None writes nothing.
        force: Whether results of an earlier run in ``out`` may be removed.
        resume: Whether to go on from the last checkpoint in ``out``.

    Raises:
        InputError: It would not fit into memory or on the disk, or see :func:`model`.
    """
    begin = time.perf_counter()
    size_estimate.check(case, out, comm)
    made = Simulation(
        model(case, comm),
        step=case.time.step,
        end=case.time.end,
        out=out,
        probes=case.probes,
        every=None if case.output.every is None else min(case.output.every, case.time.end),
        fields=case.output.fields,
        checkpoint_every=case.output.checkpoint_every,
        checkpoint_seconds=case.output.checkpoint_seconds,
        title=case.title,
        units=plain(case.units),
        repolarization=case.output.repolarization,
        tip=case.output.tip,
        electrodes=case.electrodes,
        septum=case.output.septum,
        ellipticity=case.mechanics.ellipticity,
        force=force,
        resume=resume,
        case={"name": case.name, "parameters": case.parameters, "files": _files(case)},
        setup_seconds=time.perf_counter() - begin,
    )
    _warn_of_missed_peaks(case, made.step)
    return made
