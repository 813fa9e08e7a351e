"""Lines and points with a stretch current: waves, and what excites in their wake."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain import build
from myostrain.activation import Proportional
from myostrain.coupling import Electromechanics
from myostrain.electrics import InitialValues, Place, Potential
from myostrain.engine import MPI
from myostrain.geometry import Line
from myostrain.kinematics import Line as OnALine
from myostrain.materials import Spring
from myostrain.mechanics import ImposedStretch, Mechanics, Supports
from myostrain.reproduce.jobs import Array, Found
from myostrain.reproduce.measurements.matched import currents, membrane_of
from myostrain.reproduce.measurements.signals import first_rise
from myostrain.reproduce.measurements.stepping import along, recorded, stepped
from myostrain.schemes import SecondOrder

import numpy as np

#: What excites at the start.
EXCITED = 1.0


def contracting_line(
    membrane: Any, conductance: float, clamped: bool, beta: float, length: float, spacing: float,
    source: Any = None,
) -> Electromechanics:  # fmt: skip
    """A line that contracts by γ = −βv, excited at its left end, its ends clamped or free."""
    mechanics = Mechanics(
        build(Line(length=length, spacing=spacing), comm=MPI.COMM_SELF),
        kinematics=OnALine(),
        material=Spring(),
        supports=Supports(fixed=("left", "right") if clamped else ()),
    )
    potential = Potential(
        mechanics.body,
        membrane=membrane,
        diffusivity=1.0,
        balance="advective",
        deformation=mechanics.deformation,
        initial=[InitialValues(where=Place(center=(0.0,), radius=5.0), potential=0.9)],
        stretch_currents=currents(conductance),
        source=source,
    )
    return Electromechanics(potential, mechanics, law=Proportional(beta=beta))


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
    model = contracting_line(membrane_of(membrane), conductance, clamped, beta, length, spacing)
    potential = model.potential
    middle = np.abs(along(potential) - length / 2).argmin()
    times, values = recorded(model, step, end, middle)
    above = values >= potential.threshold
    numbers = {
        "middle": first_rise(times, values, potential.threshold),
        "beats": int((above[1:] & ~above[:-1]).sum()),
    }
    return Found(numbers, {"potential": potential.v.x.array.copy()})


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

    def look(time: float) -> tuple[float, ...]:
        return time, potential.v.x.array[0], potential.field_values()["recovery"][0]

    times, course, recovery = np.array([look(0.0), *map(look, stepped(model, step, end))]).T
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
    order = np.argsort(along(potential))
    model = Electromechanics(potential, line, law=Proportional(beta=0.0))
    states = potential.states
    potential.v.x.array[order], states[0][order] = course[later], recovery[later]
    potential.states = states
    model.start()
    v, peak = potential.v.x.array, np.zeros(len(later))
    for _ in stepped(model, step, duration):
        np.maximum(peak, v[order], out=peak)
    fired = peak >= cell.threshold
    silent = np.flatnonzero(~fired)
    if not len(silent):
        return float(times[later[0]])
    return None if silent[-1] == len(later) - 1 else float(times[later[silent[-1] + 1]])
