"""Clamped bodies whose contraction stretches the rest of them, which a stretch current then drives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from myostrain import build, membranes
from myostrain.activation import Fibre, FibreTension, NashPanfilov2004, Proportional, Relaxing
from myostrain.coupling import Electromechanics
from myostrain.electrics import InitialValues, Place, Potential, StretchCurrent
from myostrain.engine import MPI
from myostrain.geometry import Line, Rectangle, UniformFibres
from myostrain.kinematics import Line as OnALine
from myostrain.kinematics import PlaneStress
from myostrain.materials import NeoHookean, Spring
from myostrain.mechanics import ImposedStretch, Mechanics, Supports
from myostrain.output.tips import Tip, TipTable
from myostrain.reproduce.jobs import Array, Found
from myostrain.reproduce.measurements.signals import first_rise
from myostrain.schemes import SecondOrder
from myostrain.validation import Positive, description

import numpy as np
import ufl

#: Sides of a sheet, all of which are clamped.
SIDES = ("left", "right", "bottom", "top")
#: What excites at the start.
EXCITED = 1.0
#: A sheet whose potential is nowhere above this has come to rest.
SILENT = 0.1
#: Excitation at which the time constants of contraction change.
SWITCH = 0.05


@description
class QuickRecovery(membranes.Membrane):
    """The cubic of Aliev and Panfilov with a recovery that follows at once where the cell is at rest.

    The current is k v (v − a)(v − 1) + v r; dr/dt = ε(v) (k v − r), ε = 1 for v < a, and ``slow`` from a
    on. Of the kind with which A. V. Panfilov, R. H. Keldermann, M. P. Nash, Phys. Rev. Lett. 95 (2005)
    258104, have their pacemakers, as we remember it: their text was not at hand.

    Args:
        k: Rate of the reaction.
        a: Threshold.
        slow: ε where the cell is excited.
    """

    k: Positive = 8.0
    a: Positive = 0.05
    slow: Positive = 0.1
    states: ClassVar[tuple[str, ...]] = ("recovery",)

    def resting_potential(self) -> float:
        """Zero."""
        return 0.0

    def resting_states(self) -> tuple[float, ...]:
        """Zero."""
        return (0.0,)

    def current(self, v: Any, states: Sequence[Any]) -> Any:
        """k v (v − a)(v − 1) + v r."""
        return self.k * v * (v - self.a) * (v - 1) + v * states[0]

    def rates(self, v: Any, states: Sequence[Any]) -> Sequence[Any]:
        """ε(v) (k v − r)."""
        return (np.where(v < self.a, 1.0, self.slow) * (self.k * v - states[0]),)


@dataclass(frozen=True)
class InPlane:
    """Fo = 1 + γ (1 − n⊗n) with the sheet's normal n: the same contraction in all directions of the sheet."""

    def tensor(self, gamma: Any, fibres: Any) -> Any:
        """Fo for γ."""
        return ufl.as_matrix([[1 + gamma, 0, 0], [0, 1 + gamma, 0], [0, 0, 1]])


@dataclass(frozen=True)
class InPlaneTension:
    """A tension in all directions of the sheet: T/2 (C₁₁ + C₂₂ − 2)."""

    def energy(self, F: Any, fibres: Any, tension: Any) -> Any:
        """Energy per reference volume."""
        C = F.T * F
        return tension / 2 * (C[0, 0] + C[1, 1] - 2)


def matched(beta: float, reading: str, modulus: float = 1.0) -> float:
    """The tension that does to a neo-Hookean sheet what the active strain −β does.

    Jo W(F Fo⁻¹) is Jo times the passive energy and that of a tension μ ((1 − β)⁻² − 1), along the fibre or
    in the plane: free bodies shorten by the same with this tension, held ones pull by the same with Jo
    times it.

    Args:
        beta: β.
        reading: "free" or "held".
        modulus: μ.
    """
    tension = modulus * ((1 - beta) ** -2 - 1)
    return tension if reading == "free" else (1 - beta) * tension


def membrane_of(given: Mapping[str, Any]) -> Any:
    """A membrane of the program, or the one of this module: "model" and its parameters."""
    others = dict(given)
    model = others.pop("model")
    return QuickRecovery(**others) if model == "QuickRecovery" else getattr(membranes, model)(**others)


def activation_of(approach: str, beta: float, rise: float, fall: float) -> tuple[Any, Any]:
    """What contracts, and the law that it follows, with the same time constants for strain and stress.

    Args:
        approach: "strain", "stress" (matched free) or "stress, held" (matched held), along the fibre; with
            " in plane" after it in all directions of the sheet.
        beta: β of the strain.
        rise: Time constant where the cell is excited; 0 follows the potential at once.
        fall: Elsewhere.
    """
    kind, plane = approach.removesuffix(" in plane"), approach.endswith(" in plane")
    if kind == "strain":
        law: Any = Proportional(beta=beta)
        if rise > 0:
            law = Relaxing(beta=beta, rise=rise, fall=fall, threshold=SWITCH)
        return InPlane() if plane else Fibre(), law
    tension = matched(beta, "free" if kind == "stress" else "held")
    law = NashPanfilov2004(tension=tension, rate=1 / fall, above=fall / rise, threshold=SWITCH)
    return InPlaneTension() if plane else FibreTension(), law


def currents(conductance: float) -> list[StretchCurrent]:
    """The stretch current; none at zero."""
    return [StretchCurrent(conductance=conductance)] if conductance > 0 else []


def clamped_sheet(size: float, spacing: float, active: Any) -> Mechanics:
    """A square that is clamped on all sides, fibres along X."""
    body = build(
        Rectangle(size=(size, size), spacing=spacing), UniformFibres(direction=(1.0, 0.0)), MPI.COMM_SELF
    )
    return Mechanics(
        body,
        kinematics=PlaneStress(),
        material=NeoHookean(),
        active=active,
        supports=Supports(fixed=SIDES),
        tolerance=1e-5,
    )


def sheet(
    membrane: Mapping[str, Any],
    approach: str,
    conductance: float,
    size: float,
    spacing: float,
    step: float,
    every: int,
    end: float,
    center: Sequence[float],
    beta: float = 0.3,
    rise: float = 10.0,
    fall: float = 1.0,
    radius: float = 4.0,
) -> Found:
    """One stimulus in a clamped square: whether it is excited again and again by its own contraction.

    Args:
        membrane: "model" and parameters.
        approach: As in :func:`activation_of`, and ``beta``, ``rise``, ``fall``.
        conductance: g.
        size: Of the square.
        spacing: Of its mesh.
        step: Time step.
        every: Steps between solves of mechanics.
        end: Time at which it ends, unless the sheet is at rest before.
        center: Of the stimulus, shares of the size.
        beta: β.
        rise: Time constant of contraction.
        fall: Time constant of relaxation.
        radius: Of the stimulus.

    Returns:
        Numbers: ``beats``, the mean number of upstrokes over the sheet, the first included; ``most`` of a
        node; ``silent``: when it came to rest, None where it has not; ``period``: the median over nodes of
        the last interval between two upstrokes, None without; ``stretched``: the largest g (√C − 1) of a
        node; ``first_drive``: the same until half the sheet has been excited; ``nodes``. Arrays: ``times``
        (t,), ``excited`` (t,), the share above the threshold; ``X`` (n, 2), ``cells`` (m, 3), ``first`` and
        ``second`` (n,), times of the first two upstrokes, NaN for none; ``frames`` (4, n), the potential at
        ``frame_times`` (4,).
    """
    active, law = activation_of(approach, beta, rise, fall)
    mechanics = clamped_sheet(size, spacing, active)
    place = Place(center=tuple(size * share for share in center), radius=radius)
    potential = Potential(
        mechanics.body,
        membrane=membrane_of(membrane),
        diffusivity=1.0,
        mass="averaged",
        deformation=mechanics.deformation,
        initial=[InitialValues(where=place, potential=EXCITED)],
        stretch_currents=currents(conductance),
    )
    model = Electromechanics(potential, mechanics, law=law, scheme=SecondOrder(every=every))
    model.start()
    v, weight = potential.v.x.array, potential.weight
    upstrokes = _Upstrokes(v, potential.threshold)
    rows, frames, silent = [(0.0, upstrokes.excited(weight))], [], None
    opened = first = 0.0
    wanted = [end * share for share in (0.1, 0.25, 0.6, 1.0)]
    for number in range(1, round(end / step) + 1):
        time = number * step
        model.step(time)
        upstrokes.look(time, v)
        rows.append((time, upstrokes.excited(weight)))
        opened = max(opened, float(potential.stretch_slope.max()))
        if np.count_nonzero(upstrokes.count) < len(v) / 2:
            first = opened
        if wanted and time >= wanted[0] * (1 - 1e-9):
            frames.append((wanted.pop(0), v.copy()))
        if v.max() < SILENT:
            silent = time
            break
    frames += [(time, np.zeros_like(v)) for time in wanted]
    space = potential.v.function_space
    numbers = {
        "beats": float((weight * upstrokes.count).sum() / weight.sum()),
        "most": int(upstrokes.count.max()),
        "silent": silent,
        "period": upstrokes.period(),
        "stretched": opened,
        "first_drive": first,
        "nodes": len(v),
    }
    times, share = np.array(rows).T
    arrays = {
        "times": times,
        "excited": share,
        "X": space.tabulate_dof_coordinates()[:, :2],
        "cells": np.asarray(space.dofmap.list),
        "first": upstrokes.first,
        "second": upstrokes.second,
        "frame_times": np.array([time for time, _ in frames]),
        "frames": np.array([values for _, values in frames]),
    }
    return Found(numbers, arrays)


def threshold(highest: float, lowest: float = 0.5, tolerance: float = 0.05, **given: Any) -> Found:
    """The least conductance at which a square goes on being excited: see :func:`sheet`.

    Args:
        highest: Conductance up to which is looked.
        lowest: From which on.
        tolerance: Of the conductance.
        given: What :func:`sheet` takes but for the conductance.

    Returns:
        Numbers: ``least``, None where there is none; ``below``, the largest that came to rest before it.
    """

    def lasts(conductance: float) -> bool:
        return sheet(conductance=conductance, **given).numbers["silent"] is None

    # Upwards: beyond a pacemaker there may be none again.
    steps = np.linspace(lowest, highest, 2 * round(highest - lowest) + 1).tolist()
    below = lowest
    for step in steps:
        if not lasts(step):
            below = step
            continue
        high = step
        while high - below > tolerance:
            middle = (below + high) / 2
            below, high = (below, middle) if lasts(middle) else (middle, high)
        return Found({"least": high, "below": below})
    return Found({"least": None, "below": below})


class _Upstrokes:
    """Counts how often nodes are excited, and when; what starts excited is excited at time 0."""

    def __init__(self, v: Array, threshold: float) -> None:
        self._above, self._threshold = v >= threshold, threshold
        self.count = self._above.astype(float)
        self.first = np.where(self._above, 0.0, np.nan)
        self.second = np.full(len(v), np.nan)
        self._last, self._interval = self.first.copy(), np.full(len(v), np.nan)

    def look(self, time: float, v: Array) -> None:
        """At the potential of a time."""
        above = v >= self._threshold
        rises = above & ~self._above
        self._above = above
        self.first[rises & (self.count == 0)] = time
        self.second[rises & (self.count == 1)] = time
        self._interval[rises] = time - self._last[rises]
        self._last[rises] = time
        self.count[rises] += 1

    def excited(self, weight: Array) -> float:
        """The share that is above the threshold."""
        return float(weight[self._above].sum() / weight.sum())

    def period(self) -> float | None:
        """The median of the last intervals between two upstrokes."""
        known = self._interval[np.isfinite(self._interval)]
        return float(np.median(known)) if len(known) else None


def arrival(
    membrane: Mapping[str, Any],
    conductance: float,
    clamped: bool,
    beta: float,
    length: float,
    spacing: float,
    step: float,
    end: float,
) -> Found:
    """A wave along a line: when it is in the middle, where the line's ends are clamped or free.

    Returns:
        Numbers: ``middle``, the time of the upstroke there, None for none; ``beats`` of the middle by the
        end. Arrays: ``potential`` (n,) at the end.
    """
    mechanics = Mechanics(
        build(Line(length=length, spacing=spacing), comm=MPI.COMM_SELF),
        kinematics=OnALine(),
        material=Spring(),
        supports=Supports(fixed=("left", "right") if clamped else ()),
    )
    potential = Potential(
        mechanics.body,
        membrane=membrane_of(membrane),
        diffusivity=1.0,
        balance="advective",
        deformation=mechanics.deformation,
        initial=[InitialValues(where=Place(center=(0.0,), radius=5.0), potential=0.9)],
        stretch_currents=currents(conductance),
    )
    model = Electromechanics(potential, mechanics, law=Proportional(beta=beta))
    X = potential.v.function_space.tabulate_dof_coordinates()[:, 0]
    middle, v = int(np.abs(X - length / 2).argmin()), potential.v.x.array
    model.start()
    rows = [v[middle]]
    for number in range(1, round(end / step) + 1):
        model.step(number * step)
        rows.append(v[middle])
    values: Array = np.array(rows)
    times: Array = np.linspace(0.0, end, len(values))
    above = values >= potential.threshold
    numbers = {
        "middle": first_rise(times, values, potential.threshold),
        "beats": int((above[1:] & ~above[:-1]).sum()),
    }
    return Found(numbers, {"potential": v.copy()})


def window(
    membrane: Mapping[str, Any], drives: Sequence[float], duration: float, step: float, end: float
) -> Found:
    """How long after its upstroke a point can be excited again by a stretch, for drives g (√C − 1).

    All of a line is stretched at once, for a while; each of its uncoupled nodes is in the state of a point
    that was excited a time of its own before.

    Args:
        membrane: "model" and parameters.
        drives: g (√C − 1).
        duration: How long the stretch lasts.
        step: Time step; also between the nodes' times.
        end: The longest delay that is looked at.

    Returns:
        Numbers: ``earliest`` delay by drive, None where none excites; ``duration`` of the potential, from
        the upstroke to its fall through the threshold. Arrays: ``times`` (t,), ``potential`` (t,), of a
        point that is not stretched, and ``recovery`` (t,).
    """
    cell = membrane_of(membrane)
    body = build(Line(length=1.0, spacing=1.0), comm=MPI.COMM_SELF)
    potential = Potential(body, membrane=cell, diffusivity=1.0)
    model = Electromechanics(potential, None, scheme=SecondOrder())
    potential.v.x.array[:] = EXCITED
    model.start()
    v, rows = potential.v.x.array, []
    for number in range(round(end / step) + 1):
        if number:
            model.step(number * step)
        rows.append((number * step, v[0], potential.field_values()["recovery"][0]))
    times, course, recovery = np.array(rows).T
    fall = first_rise(times, -course, -potential.threshold)
    earliest = [_earliest(cell, times, course, recovery, drive, duration, step) for drive in drives]
    numbers = {"drives": list(drives), "earliest": earliest, "duration": fall}
    return Found(numbers, {"times": times, "potential": course, "recovery": recovery})


def _earliest(
    cell: Any, times: Array, course: Array, recovery: Array, drive: float, duration: float, step: float
) -> float | None:
    """The first delay from which on every state of the course that has repolarised is excited again."""
    later = np.flatnonzero((course < cell.threshold) & (times > times[course.argmax()]))
    if not len(later):
        return None
    stretch = 1.1
    line = Mechanics(
        build(Line(length=float(max(1, len(later) - 1)), spacing=1.0), comm=MPI.COMM_SELF),
        kinematics=OnALine(),
        material=Spring(),
        imposed_stretch=ImposedStretch(value=stretch),
    )
    potential = Potential(
        line.body,
        membrane=cell,
        diffusivity=1e-9,
        deformation=line.deformation,
        stretch_currents=currents(drive / (stretch - 1)),
    )
    order = np.argsort(potential.v.function_space.tabulate_dof_coordinates()[:, 0])
    model = Electromechanics(potential, line, law=Proportional(beta=0.0))
    states = potential.states
    potential.v.x.array[order], states[0][order] = course[later], recovery[later]
    potential.states = states
    model.start()
    v, peak = potential.v.x.array, np.zeros(len(later))
    for number in range(1, round(duration / step) + 1):
        model.step(number * step)
        np.maximum(peak, v[order], out=peak)
    fired = peak >= cell.threshold
    silent = np.flatnonzero(~fired)
    if not len(silent):
        return float(times[later[0]])
    return None if silent[-1] == len(later) - 1 else float(times[later[silent[-1] + 1]])


def spiral(
    membrane: Mapping[str, Any],
    approach: str,
    conductance: float,
    size: float,
    spacing: float,
    step: float,
    every: int,
    end: float,
    beta: float = 0.3,
    rise: float = 10.0,
    fall: float = 1.0,
) -> Found:
    """A spiral in a clamped square, begun from crossed fields as in the case ``spiral-2d``.

    Returns:
        Numbers: ``period``, ``radius``, ``drift``, ``deviation`` of the tip that is followed, in the
        reference body, None where there is no circle; ``tips`` at the last look and ``tips_max``;
        ``silent``, whether the sheet has come to rest, and ``end``, when it has, or the end. Arrays:
        ``path`` (t, 3): time, X and Y of the tip that was followed last; ``potential`` (n,) at the end,
        ``X`` (n, 2), ``cells`` (m, 3).
    """
    active, law = activation_of(approach, beta, rise, fall)
    mechanics = clamped_sheet(size, spacing, active)

    def box(x: float, y: float) -> Place:
        return Place(box=((0.0, 0.0), (x, y)))

    sixth, high = size / 6, size * 25 / 60
    potential = Potential(
        mechanics.body,
        membrane=membrane_of(membrane),
        diffusivity=1.0,
        mass="averaged",
        deformation=mechanics.deformation,
        initial=[
            InitialValues(where=box(sixth, size), potential=EXCITED),
            InitialValues(where=box(size, high), states={"recovery": 2.0}),
            InitialValues(where=box(sixth, high), potential=EXCITED, states={"recovery": 2.0}),
        ],
        stretch_currents=currents(conductance),
    )
    model = Electromechanics(potential, mechanics, law=law, scheme=SecondOrder(every=every))
    model.start()
    v, looks, table = potential.v.x.array, 2 * every, TipTable(model, Tip(), None)
    before = v.copy()
    path: list[Any] = []
    for number in range(1, round(end / step) + 1):
        model.step(number * step)
        if number % looks == 0:
            table.add(before, step)
            path = table.state()["path"] or path
        before[:] = v
        if v.max() < SILENT:
            break
    metrics = table.metrics()
    numbers: dict[str, Any] = {
        name: metrics[f"tip_{name}"] for name in ("period", "radius", "drift", "deviation")
    }
    numbers |= {"tips": metrics["tips"], "tips_max": metrics["tips_max"]}
    numbers |= {"silent": bool(v.max() < SILENT), "end": model.time}
    space = potential.v.function_space
    way: Array = np.array(path, dtype=np.float64)
    arrays = {
        "potential": v.copy(),
        "path": way.reshape(-1, 3),
        "X": space.tabulate_dof_coordinates()[:, :2],
        "cells": np.asarray(space.dofmap.list),
    }
    return Found(numbers, arrays)
