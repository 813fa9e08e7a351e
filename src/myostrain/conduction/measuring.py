"""The conduction velocity of a membrane, and the diffusivity that gives a wanted one."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, get_args

from myostrain.conduction.wave import Cable, Progress, Wave, travel
from myostrain.electrics.diffusion import Mass
from myostrain.errors import ComputationError, InputError
from myostrain.membranes import check_membrane
from myostrain.single_cell import cell

log = logging.getLogger("myostrain")

#: Diffusivity unless given, by the membrane's unit of time: mm²/ms, mm²/s; non-dimensional without one.
DIFFUSIVITIES = {"ms": 0.1, "s": 100.0}
#: Spacing, length of the cable and of what is stimulated, in √(D T); the step, in T, the duration of the
#: upstroke of a single cell.
SPACING, LENGTH, EXCITED, STEP = 0.4, 60.0, 8.0, 1 / 20
#: The stimulus, in the membrane's own of a single cell: beside it the cable draws current.
STRONGER = 2.0
#: Estimated relative error at which the mesh is fine enough, and how many meshes there are at most.
ENOUGH, MESHES = 3e-3, 4
#: By how much the velocities in both halves of the measured part may differ.
STEADY, LENGTHENED = 5e-3, 2
#: Nodes and steps at most.
MOST_NODES, MOST_STEPS = 100_000, 1e7
#: How near to a wanted velocity a given spacing is brought, and in how many cables at most.
NEAR, TRIES = 1e-3, 8


@dataclass(frozen=True)
class Conducted:
    """How fast a membrane conducts.

    Args:
        membrane: The model.
        waves: The waves that were measured, each on a mesh and with steps half as large as the one before.
        wanted: Velocity that D was to give, None where D was given.
        fixed_spacing: Whether ``wanted`` was wanted on the first mesh, rather than without an error in space.
        tried: Diffusivities that were tried and the velocities that they gave.
    """

    membrane: Any
    waves: Sequence[Wave]
    wanted: float | None = None
    fixed_spacing: bool = False
    tried: Sequence[tuple[float, float]] = ()

    @property
    def diffusivity(self) -> float:
        """D."""
        return self.waves[-1].cable.diffusivity

    @property
    def velocity(self) -> float:
        """Velocity, extrapolated from the two finest meshes as for an error of second order."""
        coarse, fine = (wave.velocity for wave in self.waves[-2:])
        return fine + (fine - coarse) / 3

    @property
    def error(self) -> float:
        """Estimate of its error: how far the extrapolation is from the finest mesh."""
        return abs(self.velocity - self.waves[-1].velocity)

    @property
    def off(self) -> float | None:
        """By how much, relatively, the check is from the wanted velocity; None where D was given."""
        if self.wanted is None:
            return None
        return (self.waves[0].velocity if self.fixed_spacing else self.velocity) / self.wanted - 1

    @property
    def centimetres(self) -> float:
        """Factor that makes the velocity cm/s, for lengths in mm; NaN where time has no unit."""
        return {"ms": 100.0, "s": 0.1}.get(str(getattr(self.membrane, "time_unit", None)), math.nan)


def cable(
    membrane: Any,
    *,
    diffusivity: float | None = None,
    velocity: float | None = None,
    spacing: float | None = None,
    step: float | None = None,
    length: float | None = None,
    stimulus: tuple[float, float] | None = None,
    mass: Mass = "averaged",
    progress: Callable[[str, int, float], Progress] | None = None,
) -> Conducted:
    """Measure the conduction velocity on a rigid cable, as ``myostrain cable`` does.

    A wave goes from X = 0 along the cable; the velocity is that of the straight line through the activation
    times between half and nine tenths of the length. It is measured on two meshes, the second one with half
    the spacing and half the step, and on finer ones until the estimated error is below 0.3 %, unless the
    spacing is given.

    Lengths are in the unit that the diffusivity is given in: mm for mm²/ms. Unless given, spacing and length
    are 0.4 and sixty times √(D T), where T is the duration of the upstroke of a single cell: the
    range of its potential over its steepest rise; the step is T/20.

    Args:
        membrane: The model.
        diffusivity: D; unless given 0.1 for a model in ms (mm²/ms), 100 for one in s (mm²/s), otherwise 1.
        velocity: A velocity that is wanted: D is changed until the cable has it. With a spacing given, until
            the cable has it on that mesh. The diffusivity is then where to begin.
        spacing: Distance of the nodes of the first mesh.
        step: Step of time on the first mesh.
        length: Length of the cable.
        stimulus: Strength (rate of v) and duration at X = 0; unless given twice the membrane's ``pacing``.
        mass: Mass matrix, "averaged" or "lumped".
        progress: Makes what is told of each wave, from a name, the number of nodes and the length.

    Raises:
        InputError: No membrane, or a number that cannot be.
        ComputationError: The cable does not conduct.
    """
    check_membrane(membrane)
    numbers = {"velocity": velocity, "spacing": spacing, "step": step, "length": length}
    for key, value in {"diffusivity": diffusivity, **numbers}.items():
        if value is not None and not (math.isfinite(value) and value > 0):
            raise InputError(f"{value:g}: give a positive number", key)
    if mass not in get_args(Mass):
        raise InputError(f"'{mass}' is not a mass matrix; allowed: {', '.join(get_args(Mass))}", "mass")
    begin = _planned(membrane, diffusivity, spacing, step, length, stimulus, mass)

    def go(planned: Cable) -> Wave:
        name = f"D = {planned.diffusivity:.4g}, h = {planned.spacing:.4g}"
        return travel(membrane, planned, None if progress is None else lambda n, x: progress(name, n, x))

    def measured(planned: Cable) -> list[Wave]:
        if length is None:
            planned, first = _settled(go, planned)
        else:
            first = go(planned)
            if first.unsteady > STEADY:
                log.warning(
                    "the wave is not steady: its velocity changes by %.1f %% between both halves of where it "
                    "is measured; take a longer cable",
                    100 * first.unsteady,
                )
        waves = [first]
        while True:
            last = waves[-1].cable
            waves.append(go(replace(last, spacing=last.spacing / 2, step=last.step / 2)))
            found = Conducted(membrane, waves)
            if spacing is not None or found.error <= ENOUGH * found.velocity or len(waves) == MESHES:
                return waves

    waves = measured(begin)
    if velocity is None:
        return Conducted(membrane, waves)
    first = Conducted(membrane, waves).velocity if spacing is None else waves[0].velocity
    tried = [(begin.diffusivity, first)]
    if spacing is None:
        # All lengths go with √D, so that what is computed is the same and v goes with √D to round-off.
        factor = (velocity / first) ** 2
        waves = measured(_scaled(waves[0].cable, factor))
        found = Conducted(membrane, waves, velocity, tried=tried)
        return replace(found, tried=[*tried, (found.diffusivity, found.velocity)])
    planned = waves[0].cable
    while not abs(tried[-1][1] / velocity - 1) <= NEAR:
        if len(tried) == TRIES:
            raise ComputationError(
                f"no diffusivity was found that gives {velocity:g} on nodes {spacing:g} apart; nearest was "
                f"{min(tried, key=lambda pair: abs(pair[1] - velocity))[1]:.5g}",
                advice="a smaller --spacing.",
            )
        planned = replace(planned, diffusivity=_next(tried, velocity))
        tried.append((planned.diffusivity, go(planned).velocity))
    waves = measured(planned)
    return Conducted(membrane, waves, velocity, fixed_spacing=True, tried=tried)


def _planned(
    membrane: Any,
    diffusivity: float | None,
    spacing: float | None,
    step: float | None,
    length: float | None,
    stimulus: tuple[float, float] | None,
    mass: Mass,
) -> Cable:
    """The first cable, what is not given from the upstroke of a single cell."""
    declared = getattr(membrane, "pacing", None)
    given = declared if stimulus is None else stimulus
    if given is None:
        raise InputError(
            f"{type(membrane).__name__} declares no pacing: give strength (rate of v) and duration",
            "stimulus",
        )
    strength, duration = map(float, given)
    paced = declared or given
    beat = cell(membrane, beats=1, stimulus=paced).last
    rise, peak, rest = (beat[name] for name in ("upstroke_velocity", "peak", "rest"))
    if rise is None or peak is None or rest is None or not rise > 0:
        raise ComputationError(
            f"no wave: a single cell is not excited by a rate of {paced[0]:g} for {paced[1]:g}",
            advice="a larger --set stimulus.strength or stimulus.duration, or a membrane that is excitable.",
        )
    if stimulus is None:
        strength *= STRONGER
    T = (peak - rest) / rise
    D = (
        DIFFUSIVITIES.get(str(getattr(membrane, "time_unit", None)), 1.0)
        if diffusivity is None
        else diffusivity
    )
    scale = math.sqrt(D * T)
    h = SPACING * scale if spacing is None else spacing
    excited = max(EXCITED * scale, 2 * h)
    L = max(LENGTH * scale, 40 * h, 5 * excited) if length is None else length
    if not max(20 * h, 2 * excited) <= L:
        raise InputError(
            f"{L:g}: give at least {max(20 * h, 2 * excited):.4g}, twenty nodes and twice what is stimulated",
            "length",
        )
    if L / h > MOST_NODES:
        raise InputError(f"{h:g}: that makes {L / h:.2g} nodes; give {L / MOST_NODES:.2g} or more", "spacing")
    dt = STEP * T if step is None else step
    if not dt <= 10 * T:
        raise InputError(f"{dt:g}: the upstroke takes {T:.3g}; give a step below {10 * T:.3g}", "step")
    time = L / scale * T
    if time / dt > MOST_STEPS:
        raise InputError(
            f"{dt:g}: that makes {time / dt:.2g} steps; give {time / MOST_STEPS:.2g} or more", "step"
        )
    return Cable(D, h, dt, L, excited, (strength, duration), T, mass)


def _settled(go: Callable[[Cable], Wave], planned: Cable) -> tuple[Cable, Wave]:
    """A cable so long that the wave is steady where it is measured, and the wave."""
    wave = go(planned)
    for _ in range(LENGTHENED):
        if wave.unsteady <= STEADY:
            break
        planned = replace(planned, length=2 * planned.length)
        wave = go(planned)
    else:
        log.warning("the wave is not steady: its velocity still changes by %.2g", wave.unsteady)
    return planned, wave


def _scaled(planned: Cable, factor: float) -> Cable:
    """The same cable for another D, with all lengths scaled along."""
    root = math.sqrt(factor)
    return replace(
        planned,
        diffusivity=planned.diffusivity * factor,
        spacing=planned.spacing * root,
        length=planned.length * root,
        excited=planned.excited * root,
    )


def _next(tried: Sequence[tuple[float, float]], wanted: float) -> float:
    """A diffusivity to try: v² goes with D at first, then the secant of log v over log D."""
    (D, v), before = tried[-1], tried[-2:-1]
    power = 0.5
    if before and before[0][0] != D:
        power = math.log(v / before[0][1]) / math.log(D / before[0][0])
        power = min(max(power, 0.2), 2.0)
    return D * (wanted / v) ** (1 / power)
