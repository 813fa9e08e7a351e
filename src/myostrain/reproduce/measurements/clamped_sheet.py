"""Clamped squares whose contraction stretches the rest of them: one stimulus, and what follows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain import build
from myostrain.coupling import Electromechanics
from myostrain.electrics import InitialValues, Place, Potential, StretchCurrent
from myostrain.engine import MPI
from myostrain.geometry import Rectangle, UniformFibres
from myostrain.kinematics import PlaneStress
from myostrain.materials import NeoHookean
from myostrain.mechanics import Mechanics, Supports
from myostrain.reproduce.jobs import Array, Found
from myostrain.reproduce.measurements.matched import activation_of, currents, membrane_of
from myostrain.reproduce.measurements.stepping import stepped
from myostrain.schemes import SecondOrder

import numpy as np

#: Sides of a sheet, all of which are clamped.
SIDES = ("left", "right", "bottom", "top")
#: What excites at the start.
EXCITED = 1.0
#: A sheet whose potential is nowhere above this has come to rest.
SILENT = 0.1


def clamped_sheet(
    membrane: Any,
    contraction: tuple[Any, Any],
    stretch_currents: Sequence[StretchCurrent],
    initial: Sequence[InitialValues],
    size: float,
    spacing: float,
    every: int,
) -> Electromechanics:
    """A square that is clamped on all sides, fibres along X, with D = 1.

    Args:
        membrane: Its membrane.
        contraction: What contracts and the law that it follows, of
            :func:`~myostrain.reproduce.measurements.matched.activation_of`.
        stretch_currents: Its stretch currents.
        initial: Initial values.
        size: Its side.
        spacing: Of its mesh.
        every: Steps between solves of mechanics.
    """
    body = build(
        Rectangle(size=(size, size), spacing=spacing), UniformFibres(direction=(1.0, 0.0)), MPI.COMM_SELF
    )
    active, law = contraction
    mechanics = Mechanics(
        body,
        kinematics=PlaneStress(),
        material=NeoHookean(),
        active=active,
        supports=Supports(fixed=SIDES),
        tolerance=1e-5,
    )
    potential = Potential(
        body,
        membrane=membrane,
        diffusivity=1.0,
        mass="averaged",
        deformation=mechanics.deformation,
        initial=initial,
        stretch_currents=stretch_currents,
    )
    return Electromechanics(potential, mechanics, law=law, scheme=SecondOrder(every=every))


def drawn(potential: Potential) -> dict[str, Array]:
    """What a picture of a sheet needs: nodes ``X`` (n, 2) and ``cells`` (m, 3)."""
    space = potential.v.function_space
    return {"X": space.tabulate_dof_coordinates()[:, :2], "cells": np.asarray(space.dofmap.list)}


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
    place = Place(center=tuple(size * share for share in center), radius=radius)
    model = clamped_sheet(
        membrane_of(membrane),
        activation_of(approach, beta, rise, fall),
        currents(conductance),
        [InitialValues(where=place, potential=EXCITED)],
        size,
        spacing,
        every,
    )
    model.start()
    potential = model.potential
    v, weight = potential.v.x.array, potential.weight
    upstrokes = _Upstrokes(v, potential.threshold)
    rows, frames, silent = [(0.0, upstrokes.excited(weight))], [], None
    opened = first = 0.0
    wanted = [end * share for share in (0.1, 0.25, 0.6, 1.0)]
    for time in stepped(model, step, end):
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
        **drawn(potential),
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
