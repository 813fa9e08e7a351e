"""Bodies that are stretched, at once or slowly, all of them or a part: whether that excites them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from myostrain import build, membranes
from myostrain.activation import Proportional
from myostrain.coupling import Electromechanics
from myostrain.electrics import Place, Potential, StretchCurrent
from myostrain.engine import MPI
from myostrain.geometry import Body, Line, Rectangle, UniformFibres
from myostrain.kinematics import Line as OnALine
from myostrain.kinematics import PlaneStress
from myostrain.materials import NeoHookean, Spring
from myostrain.mechanics import ImposedStretch, Mechanics, Supports
from myostrain.reproduce.jobs import Array, Found
from myostrain.reproduce.measurements.matched import membrane_of
from myostrain.reproduce.measurements.stepping import along, recorded, stepped
from myostrain.schemes import SecondOrder
from myostrain.theory import least_drive

import numpy as np

#: What couples nodes that are to be points of their own: nothing, but a diffusivity must be positive.
UNCOUPLED = 1e-9
#: Length of a line of points, and its cells' size.
LENGTH = 2.0
#: Steps between solves of mechanics where a line is moved slowly.
EVERY = 4
#: A held body does not contract: what is measured is the current, not what it leads to.
PASSIVE = Proportional(beta=0.0)


def moved(stretch: float, ramp: float, length: float) -> tuple[tuple[float, float], ...]:
    """The displacement of one end over time that stretches a line to λ within the time of a ramp."""
    return ((0.0, 0.0), (ramp, length * (stretch - 1)))


def held_line(
    stretch: float, ramp: float, until: float, length: float = LENGTH, spacing: float = 1.0
) -> Mechanics:
    """A line at a stretch: from the start until a time, or reached by moving its end during a ramp."""
    body = build(Line(length=length, spacing=spacing), comm=MPI.COMM_SELF)
    held: dict[str, Any]
    if ramp > 0:
        ends: Any = {"right": {"x": moved(stretch, ramp, length)}}
        held = {"supports": Supports(fixed=("left",), displacement=ends)}
    else:
        held = {"imposed_stretch": ImposedStretch(value=stretch, until=until)}
    return Mechanics(body, kinematics=OnALine(), material=Spring(), **held)


def excited(
    mechanics: Mechanics,
    membrane: Any,
    currents: Sequence[StretchCurrent],
    step: float,
    end: float,
    *,
    since: float = 0.0,
    diffusivity: float = UNCOUPLED,
    balance: Any = "conservative",
    far: bool = False,
    every: int = 1,
) -> tuple[float | None, float]:
    """Run a body from rest, until it is above the membrane's threshold, or falls back without having been.

    Args:
        mechanics: The body.
        membrane: Its membrane.
        currents: Its stretch currents.
        step: Time step.
        end: When to stop at the latest.
        since: From when on it may be seen to fall back: to seven tenths of what it had reached.
        diffusivity: D.
        balance: Of the potential.
        far: Whether it is excited when its end with the largest X is, in place of any node.
        every: Steps between solves of mechanics.

    Returns:
        When it is excited, None for never; and the largest |v − rest|, as a share of the membrane's range.
    """
    potential = Potential(
        mechanics.body,
        membrane=membrane,
        diffusivity=diffusivity,
        balance=balance,
        deformation=mechanics.deformation,
        stretch_currents=currents,
    )
    model = Electromechanics(potential, mechanics, law=PASSIVE, scheme=SecondOrder(every=every))
    watched = [along(potential).argmax()] if far else slice(None)
    model.start()
    v, largest, peak = potential.v.x.array, 0.0, -np.inf
    for time in stepped(model, step, end):
        largest = max(largest, float(np.abs(v - potential.rest).max()) / potential.scale)
        if v[watched].max() >= potential.threshold:
            return time, largest
        top = float(v.max())
        peak = max(peak, top)
        fallen = top - potential.rest < 0.7 * (peak - potential.rest)
        if fallen and peak < potential.threshold and time > since:
            break
    return None, largest


def bisected(fires: Callable[[float], bool], low: float, high: float, tolerance: float) -> float | None:
    """The least value that fires, to a relative tolerance; None where ``high`` does not."""
    if not fires(high):
        return None
    while high - low > tolerance * high:
        middle = (low + high) / 2
        if fires(middle):
            high = middle
        else:
            low = middle
    return (low + high) / 2


def thresholds(
    membrane: Mapping[str, Any],
    conductances: Sequence[float],
    reversal: float,
    span: float,
    highest: float,
    step: float,
    end: float,
    tolerance: float,
) -> Found:
    """The stretch to which a line at rest must be brought at once, and held, to be excited.

    Args:
        membrane: "model" and parameters.
        conductances: g.
        reversal: E.
        span: The √C − 1 at which g is open.
        highest: Multiple of the estimate up to which is looked, from 0.9 of it on.
        step: Time step.
        end: Time within which it must be excited.
        tolerance: Of λ − 1, relative.

    Returns:
        Numbers: ``estimate`` of g (λ − 1)/span, see :func:`~myostrain.theory.least_drive`; by conductance
        ``estimated`` λ, measured ``stretch`` λ and ``drive``, g (λ − 1)/span there; None where not found.
    """
    cell = membrane_of(membrane)
    estimate = least_drive(cell, reversal)
    rows: dict[str, list[float | None]] = {"estimated": [], "stretch": [], "drive": []}
    low, high = 0.9 * estimate, highest * estimate
    for g in conductances:
        current = [StretchCurrent(conductance=g, reversal=reversal, span=span)]

        def fires(drive: float, g: float = g, current: Sequence[StretchCurrent] = current) -> bool:
            line = held_line(1 + drive * span / g, 0.0, np.inf)
            return excited(line, cell, current, step, end)[0] is not None

        found = None
        if high < highest * estimate and not fires(low):  # near that of the last conductance
            found = bisected(fires, low, high, tolerance)
        if found is None:
            found = bisected(fires, 0.9 * estimate, highest * estimate, tolerance)
        rows["estimated"].append(1 + estimate * span / g)
        rows["stretch"].append(None if found is None else 1 + found * span / g)
        rows["drive"].append(found)
        if found is not None:
            low, high = found * (1 - tolerance), found * (1 + tolerance)
    return Found({"estimate": estimate, "conductances": list(conductances), **rows})


def slow(
    membrane: Mapping[str, Any],
    conductance: float,
    times: Sequence[float],
    way: str,
    highest: float,
    step: float,
    end: float,
    tolerance: float,
) -> Found:
    """The stretch that excites a line which is stretched slowly and then held, or for a short time.

    Args:
        membrane: "model" and parameters.
        conductance: g, reversal 1.
        times: Of the ramp by which an end of the line is moved, or for which the line is held.
        way: "ramp" or "brief".
        highest: λ − 1 up to which is looked.
        step: Time step.
        end: Time after the ramp within which it must be excited.
        tolerance: Of λ − 1, relative.

    Returns:
        Numbers: ``times``; and by time ``stretch`` λ, None where not found.
    """
    cell = membrane_of(membrane)
    current = [StretchCurrent(conductance=conductance, reversal=1.0, span=1.0)]
    low, found = 0.5 * least_drive(cell, 1.0) / conductance, []
    for time in times:

        def fires(beyond: float, time: float = time) -> bool:
            ramp, until = (time, np.inf) if way == "ramp" else (0.0, time)
            line = held_line(1 + beyond, ramp, until)
            last = end + ramp
            how: Any = {"since": max(ramp, 1.0), "balance": "advective", "every": EVERY if ramp > 0 else 1}
            return excited(line, cell, current, step, last, **how)[0] is not None

        beyond = bisected(fires, low, highest, tolerance)
        found.append(None if beyond is None else 1 + beyond)
    return Found({"times": list(times), "stretch": found})


def segments(
    membrane: Mapping[str, Any],
    halves: Sequence[float],
    length: float,
    spacing: float,
    diffusivity: float,
    highest: float,
    step: float,
    end: float,
    tolerance: float,
) -> Found:
    """What a part of a line needs that alone has the current: the neighbours draw on it.

    Args:
        membrane: "model" and parameters.
        halves: Half lengths of that part, in the middle of the line: the line is its half.
        length: Half of the line.
        spacing: Of its nodes.
        diffusivity: D.
        highest: Multiple of the estimate up to which is looked.
        step: Time step.
        end: Time within which the far end of the half line must be excited.
        tolerance: Of the drive, relative.

    Returns:
        Numbers: ``halves``; and by these ``drive``, the least g (λ − 1) that starts a wave, None where none.
    """
    cell, beyond = membrane_of(membrane), 0.1
    estimate, found = least_drive(cell, 1.0), []
    for half in halves:
        inside = Place(box=((0.0,), (half,)))

        def fires(drive: float, inside: Place = inside) -> bool:
            current = StretchCurrent(conductance=drive / beyond, reversal=1.0, span=1.0, where=inside)
            line = held_line(1 + beyond, 0.0, np.inf, length, spacing)
            stretched = diffusivity * (1 + beyond) ** 2  # per length in the reference, as at rest
            return excited(line, cell, [current], step, end, diffusivity=stretched, far=True)[0] is not None

        found.append(bisected(fires, estimate, highest * estimate, tolerance))
    return Found({"halves": list(halves), "drive": found})


def held_on(membrane: Mapping[str, Any], drives: Sequence[float], step: float, end: float) -> Found:
    """Points that are stretched at rest and held for long: each node of a line has a g of its own.

    Returns:
        Numbers by drive g (λ − 1): whether it ``fired``, and the ``swing`` of v in the later half.
        Arrays: ``times`` (t,), ``potential`` (t, drives), ``drives``.
    """
    cell, beyond = membrane_of(membrane), 0.1
    line = held_line(1 + beyond, 0.0, np.inf, float(len(drives) - 1), 1.0)
    potential = Potential(
        line.body, membrane=cell, diffusivity=UNCOUPLED, deformation=line.deformation,
        stretch_currents=[_by_node(line.body, np.asarray(drives) / beyond)],
    )  # fmt: skip
    model = Electromechanics(potential, line, law=PASSIVE)
    times, v = recorded(model, step, end, np.argsort(along(potential)))
    fired, late = v.max(axis=0) >= potential.threshold, v[len(v) // 2 :]
    numbers = {"fired": fired.tolist(), "swing": np.ptp(late, axis=0).tolist()}
    return Found(numbers, {"times": times, "potential": v, "drives": np.asarray(drives, dtype=float)})


def _by_node(body: Body, values: Array) -> StretchCurrent:
    """A current whose conductances are these, by the place of the nodes."""
    order = np.argsort(along(Potential(body, membrane=membranes.FitzHughNagumo())))
    nodal: Any = np.empty(len(order))
    nodal[order] = values
    return StretchCurrent(conductance=nodal, reversal=1.0, span=1.0)


def unexcited(membrane: Mapping[str, Any], balance: str, stretch: float, step: float, end: float) -> Found:
    """Bodies without a stretch current that are held and moved from rest.

    Args:
        membrane: "model" and parameters.
        balance: Of the potential.
        stretch: λ, reached within half the time where a body is moved.
        step: Time step.
        end: Time.

    Returns:
        Numbers, each the largest |v − rest| of the membrane's range: ``held`` line, at once; ``moved`` line;
        ``sheared`` sheet, whose side is moved along itself and away from the other by λ − 1 of its length.
    """
    cell = membrane_of(membrane)

    def largest(mechanics: Mechanics) -> float:
        return excited(mechanics, cell, (), step, end, diffusivity=1.0, balance=balance)[1]

    away = moved(stretch, end / 2, LENGTH)
    body = build(
        Rectangle(size=(LENGTH, LENGTH), spacing=1.0), UniformFibres(direction=(1.0, 1.0)), MPI.COMM_SELF
    )
    sheet = Mechanics(
        body,
        kinematics=PlaneStress(),
        material=NeoHookean(),
        supports=Supports(fixed=("left",), displacement={"right": {"x": away, "y": away}}),
    )
    return Found(
        {
            "held": largest(held_line(stretch, 0.0, np.inf)),
            "moved": largest(held_line(stretch, end / 2, np.inf)),
            "sheared": largest(sheet),
        }
    )
