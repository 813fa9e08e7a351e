"""A sheet, watched in every step: pulses at probes, local celerities, where it deforms, its volume."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.case.case import Case
from myostrain.coupling import Electromechanics
from myostrain.engine import compile_form, fem
from myostrain.mechanics.equilibrium import Mechanics
from myostrain.output.metrics import LEVEL
from myostrain.reproduce.jobs import Array, Found, Job
from myostrain.reproduce.measurements.cases import resolved
from myostrain.reproduce.measurements.signals import first_rise
from myostrain.reproduce.measurements.triangles import (
    Indices,
    area_above,
    areas,
    celerities,
    gradients,
    growth,
    pulse,
    quantiles,
    relevance,
    settled,
    strains,
    stretches,
)
from myostrain.run.simulation import Simulation
from myostrain.solvers.linear import assemble_nodal

import numpy as np
import ufl

#: Fronts within this angle (degrees) of a direction count as going along it.
CONE = 20.0

#: Share of the body's area, at either end, that extremes of the stress leave out: peaks at single nodes.
PEAKS = 0.002


def sheet_job(name: str, overrides: Sequence[str] = (), *, cost: float = 1.0) -> Job:
    """The job that runs a named case and measures what :func:`run` does.

    Args:
        name: The case.
        overrides: "KEY=VALUE", as on the command line.
        cost: Seconds that it takes, roughly.
    """
    return Job("sheets.run", {"case": resolved(name, overrides)}, cost)


def mesh(case: Mapping[str, Any]) -> Found:
    """Count a sheet's mesh, without running anything.

    Returns:
        Numbers: ``nodes``, ``triangles``, ``area`` of the body, ``width`` and ``height`` of the rectangle
        that it fills, ``edge``: the mean length of a side of a triangle.
    """
    potential = Case.from_dict(case).build().potential
    X, cells = mesh_arrays(potential.v.function_space)
    sides = X[cells[:, [1, 2, 0]]] - X[cells]
    width, height = np.ptp(X, axis=0).tolist()
    numbers = {
        "nodes": len(X),
        "triangles": len(cells),
        "area": float(areas(X, cells).sum()),
        "width": width,
        "height": height,
        "edge": float(np.linalg.norm(sides, axis=2).mean()),
    }
    return Found(numbers)


def run(case: Mapping[str, Any]) -> Found:
    """Run a sheet or a line, and look at it in every step.

    Returns:
        Numbers: ``metrics``, ``cells``, ``nodes``, ``steps``, ``step``; by probe in ``pulses``, what
        :func:`~myostrain.reproduce.measurements.triangles.pulse` says. On a sheet also

        - ``celerity``, ``stretch``, ``relevance``: see the functions of these names there; at the end;
        - ``steepness``: median |Grad v| in fronts that go ``along_X`` and ``across_X`` the fibres, and
          |grad v| in x, ``along_x`` and ``across_x``; None without ten triangles in such a front;
        - ``largest``, over all times: ``displacement`` |u|, ``strain`` |E|, and ``stress_low`` and
          ``stress_high`` of the trace; of strain and stress without the outermost 0.2 % of the area;
        - ``volume``: see :func:`volumes`; at the end.

        Arrays: ``times`` (steps + 1,), ``probes`` (steps + 1, probes). On a sheet ``X`` (n, 2), ``cells``
        (m, 3), ``weight`` (n,), the nodes' areas, and at the end ``potential`` (n,), ``u`` (n, 2),
        ``stress_trace`` (n,), ``activation`` (n,), NaN for never.
    """
    simulation = Case.from_dict(case).simulation()
    model = simulation.model
    watch = _Watch(simulation, case)
    results = simulation.run(watch)
    times, histories = np.array(watch.times), np.array(watch.probes)
    numbers: dict[str, Any] = {
        "metrics": results["metrics"],
        "cells": results["cells"],
        "nodes": len(model.potential.weight),
        "steps": results["steps"],
        "step": results["step"],
        "pulses": {name: pulse(times, histories[:, i]) for i, name in enumerate(simulation.probes.names)},
    }
    arrays = {"times": times, "probes": histories}
    sheet = watch.sheet
    if sheet is None:
        return Found(numbers, arrays)
    assert model.mechanics is not None  # a case has one
    X, cells, fibre = sheet.X, sheet.cells, sheet.fibre
    v, u = model.potential.v.x.array.copy(), sheet.displacement().copy()
    T = np.asarray(simulation.activation_times)
    numbers |= {
        "celerity": celerities(X, cells, T, fibre, sheet.settled),
        "steepness": sheet.steepness(),
        "largest": sheet.largest,
        "volume": volumes(model.mechanics),
        "stretch": stretches(X, cells, u, v, fibre),
        "relevance": relevance(X, cells, u, v),
    }
    arrays |= {
        "X": X,
        "cells": cells,
        "weight": model.potential.weight.copy(),
        "potential": v,
        "u": u,
        "stress_trace": model.mechanics.stress_trace(),
        "activation": T,
    }
    return Found(numbers, arrays)


def start(case: Mapping[str, Any]) -> Found:
    """Watch a bump become a pulse: from short steps, the area where v > 0.5 and the middle of the bump.

    Returns:
        Numbers: ``grows`` and ``doubled``, see :func:`~myostrain.reproduce.measurements.triangles.growth`;
        ``back``: when v in the middle of the bump falls through 0.5, so that the pulse has two sides;
        None where it has not happened. Arrays: ``times`` (steps + 1,), ``excited`` (steps + 1,), the area,
        and ``middle`` (steps + 1,), v in the middle of the bump.
    """
    checked = Case.from_dict({**case, "probes": {"middle": case["initial"]["center"]}})
    simulation = checked.simulation()
    v = simulation.model.potential.v
    X, cells = mesh_arrays(v.function_space)
    rows: list[tuple[float, float, float]] = []

    class Watch:
        def update(self, step: int, reached: float) -> None:
            values = v.x.array
            (middle,) = simulation.probes.gather(simulation.probes.local(values))
            rows.append((reached, area_above(X, cells, values), float(middle)))

    watch = Watch()
    watch.update(0, 0.0)
    simulation.run(watch)
    times, excited, middle = np.array(rows).T
    numbers = growth(times, excited) | {"back": first_rise(times, -middle, -LEVEL)}
    return Found(numbers, {"times": times, "excited": excited, "middle": middle})


class _Watch:
    """Looks at probes after every step, and at the whole body sixty times."""

    def __init__(self, simulation: Simulation, case: Mapping[str, Any]) -> None:
        self._model: Electromechanics = simulation.model
        self._points = simulation.probes
        self._v = self._model.potential.v
        self._before = self._v.x.array.copy()
        self.times: list[float] = []
        self.probes: list[Array] = []
        self.sheet = _Sheet(self._model, case) if self._model.potential.body.dim == 2 else None
        self._often = max(1, simulation.steps // 60)
        self._look(0.0)

    def update(self, step: int, reached: float) -> None:
        """After a step."""
        self._look(reached)
        if self.sheet is not None and step % self._often == 0:
            self.sheet.look(self._before)
        self._before[:] = self._v.x.array

    def _look(self, time: float) -> None:
        self.times.append(time)
        self.probes.append(self._points.gather(self._points.local(self._v.x.array)))


class _Sheet:
    """What is largest on a sheet, and how steep its fronts are."""

    def __init__(self, model: Electromechanics, case: Mapping[str, Any]) -> None:
        assert model.mechanics is not None  # a case has one
        self._model, self._mechanics = model, model.mechanics
        space = model.potential.v.function_space
        self.X, self.cells = mesh_arrays(space)
        self.fibre = np.asarray(case["fibres"]["direction"]) / np.linalg.norm(case["fibres"]["direction"])
        rim = fem.locate_dofs_topological(space, 1, self._mechanics.body.boundary_facets(None))
        self.settled = settled(self.X, self.cells, np.asarray(case["initial"]["center"][:2]), rim)
        self._areas = areas(self.X, self.cells)
        self.largest = {"displacement": 0.0, "strain": 0.0, "stress_low": 0.0, "stress_high": 0.0}
        self._steep: list[Array] = []

    def displacement(self) -> Array:
        return self._mechanics.displacement().x.array.reshape(-1, 2)

    def look(self, before: Array) -> None:
        """Take what is largest now, if it is so far; and the fronts, rising from the potential before."""
        F = np.eye(2) + gradients(self.X, self.cells, self.displacement())
        low, high = quantiles(
            self._mechanics.stress_trace(), self._model.potential.weight, (PEAKS, 1 - PEAKS)
        )
        now = {
            "displacement": float(np.linalg.norm(self.displacement(), axis=1).max()),
            "strain": quantiles(np.linalg.norm(strains(F), axis=(1, 2)), self._areas, (1 - PEAKS,))[0],
            "stress_high": high,
        }
        self.largest |= {name: max(self.largest[name], value) for name, value in now.items()}
        self.largest["stress_low"] = min(self.largest["stress_low"], low)
        v = self._model.potential.v.x.array
        mean, was = v[self.cells].mean(axis=1), before[self.cells].mean(axis=1)
        front = self.settled & (np.abs(mean - LEVEL) < 0.1) & (mean > was)
        g = gradients(self.X, self.cells[front], v)
        spatial = np.linalg.solve(F[front].transpose(0, 2, 1), g[:, :, None])[:, :, 0]
        along = np.abs(g @ self.fibre) / np.linalg.norm(g, axis=1)
        self._steep.append(
            np.column_stack([np.linalg.norm(g, axis=1), np.linalg.norm(spatial, axis=1), along])
        )

    def steepness(self) -> dict[str, float | None]:
        """See :func:`run`."""
        X, x, along = np.concatenate([*self._steep, np.empty((0, 3))]).T
        ways = {"along": along > np.cos(np.radians(CONE)), "across": along < np.sin(np.radians(CONE))}
        return {f"{way}_{at}": _median(s[p]) for way, p in ways.items() for at, s in (("X", X), ("x", x))}


def volumes(mechanics: Mechanics) -> dict[str, float]:
    """The volume of the deformed body, and how well its constraint holds.

    Returns:
        ``change``: ∫ J dX / ∫ dX − 1; ``wanted``: the same of what the constraint asks for, 1 or Jo;
        ``cell_error``: the largest |mean of J / mean of what is asked for − 1| over a triangle;
        ``area_change``: of the plane, ∫ det F₂ dX / ∫ dX − 1.
    """
    domain, kinematics = mechanics.body.mesh, mechanics.kinematics
    u = ufl.split(mechanics.u)[0] if kinematics.has_pressure else mechanics.u
    F = ufl.Identity(2) + ufl.grad(u)
    Jo = 1 + mechanics.activation
    J, wanted = ufl.det(kinematics.lift(F, Jo)), ufl.as_ufl(kinematics.volume_ratio(F, Jo))
    test = ufl.TestFunction(fem.functionspace(domain, ("DG", 0)))
    dx = ufl.dx(domain=domain, metadata={"quadrature_degree": 2})

    def integrals(density: Any) -> Array:
        return assemble_nodal(compile_form(density * test * dx))

    area, volume, asked = integrals(fem.Constant(domain, 1.0)), integrals(J), integrals(wanted)
    return {
        "change": float(volume.sum() / area.sum() - 1),
        "wanted": float(asked.sum() / area.sum() - 1),
        "cell_error": float(np.abs(volume / asked - 1).max()),
        "area_change": float(integrals(ufl.det(F)).sum() / area.sum() - 1),
    }


def mesh_arrays(space: fem.FunctionSpace) -> tuple[Array, Indices]:
    """Nodes (n, dim) and node numbers (m, dim + 1) of a P1 space."""
    X = space.tabulate_dof_coordinates()[:, : space.mesh.geometry.dim]
    return X, np.asarray(space.dofmap.list)


def _median(values: Array) -> float | None:
    return float(np.median(values)) if len(values) >= 10 else None
