"""One wave along one rigid cable: when it comes to each node, and how fast it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

from myostrain import geometry
from myostrain.coupling import Electromechanics
from myostrain.electrics import Place, Potential, Stimulus
from myostrain.electrics.diffusion import Mass
from myostrain.engine import MPI
from myostrain.errors import ComputationError
from myostrain.schemes import SecondOrder

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: Where along the cable the wave is measured, and where it is drawn; shares of the length.
MEASURED, DRAWN = (0.5, 0.9), (0.15, 0.3, 0.45, 0.6, 0.75, 0.9)
#: Durations of the upstroke that the front may stand still.
PATIENCE = 100.0


class Progress(Protocol):
    """What is told how far a wave is."""

    def update(self, step: int, reached: float) -> None:
        """``step`` nodes are activated, the last of them at X = ``reached``."""
        ...


@dataclass(frozen=True)
class Cable:
    """A rigid cable and how a wave is started on it, in units of the membrane.

    Args:
        diffusivity: D.
        spacing: Distance of the nodes.
        step: Step of time.
        length: Length.
        excited: Length that is stimulated, at X = 0.
        stimulus: Strength (rate of v) and duration of the stimulus.
        upstroke: Duration of the upstroke: how long the front may stand still is counted in it.
        mass: Mass matrix, "averaged" or "lumped".
    """

    diffusivity: float
    spacing: float
    step: float
    length: float
    excited: float
    stimulus: tuple[float, float]
    upstroke: float
    mass: Mass = "averaged"


@dataclass(frozen=True)
class Wave:
    """A wave that went along a cable.

    Args:
        cable: The cable; its spacing divides its length.
        X: Nodes (n,).
        activation: When v crosses the membrane's threshold at each (n,), NaN where it has not.
        frames: Times and the potential (n,) at them, while it travels.
    """

    cable: Cable
    X: Array
    activation: Array
    frames: list[tuple[float, Array]] = field(default_factory=list)

    def fit(self, begin: float = MEASURED[0], end: float = MEASURED[1]) -> tuple[float, float]:
        """The straight line t = a + X/c through the activation times of a part: c and a.

        Args:
            begin: Where the part begins, a share of the length.
            end: Where it ends.
        """
        X = self.X / self.X[-1]
        part = (begin - 1e-9 <= X) & (end + 1e-9 >= X)
        slowness, start = np.polyfit(self.X[part], self.activation[part], 1)
        return float(1 / slowness), float(start)

    @property
    def velocity(self) -> float:
        """Velocity in the measured part of the cable."""
        return self.fit()[0]

    @property
    def unsteady(self) -> float:
        """By how much, relatively, the velocities in both halves of the measured part differ."""
        middle = sum(MEASURED) / 2
        first, second = self.fit(MEASURED[0], middle)[0], self.fit(middle, MEASURED[1])[0]
        return abs(second / first - 1)


def travel(membrane: Any, cable: Cable, progress: Callable[[int, float], Progress] | None = None) -> Wave:
    """Excite one end of a cable and follow the wave until it has nearly come to the other.

    The scheme is the second-order one of a rigid body, on this process alone.

    Args:
        membrane: The model.
        cable: The cable.
        progress: Makes what is told of it, from the number of nodes to come to and the length.

    Raises:
        ComputationError: No wave: the stimulus does not start one, it stops on its way, or all nodes are
            activated at once.
    """
    body = geometry.build(geometry.Line(length=cable.length, spacing=cable.spacing), comm=MPI.COMM_SELF)
    strength, duration = cable.stimulus
    # The edge of what is stimulated lies between two nodes.
    place = Place(box=((-cable.spacing,), (cable.excited + cable.spacing / 2,)))
    potential = Potential(
        body,
        membrane=membrane,
        diffusivity=cable.diffusivity,
        mass=cable.mass,
        stimuli=[Stimulus(where=place, strength=strength, duration=duration)],
    )
    model = Electromechanics(potential, scheme=SecondOrder())
    model.start()
    order = np.argsort(potential.v.function_space.tabulate_dof_coordinates()[:, 0])
    X = potential.v.function_space.tabulate_dof_coordinates()[order, 0]
    # Places are marked to the right of a node by round-off, not by half a cell.
    marks = [int(np.searchsorted(X, share * X[-1] * (1 - 1e-9))) for share in DRAWN]
    level, last = potential.threshold, marks[-1]
    activation = np.full(len(X), np.nan)
    frames: list[tuple[float, Array]] = []
    old, moved, reached, count = potential.v.x.array[order], 0.0, 0, 0
    shown = None if progress is None else progress(last, cable.length)
    patience = PATIENCE * cable.upstroke + 2 * duration
    highest = float(old.max())
    while np.isnan(activation[last]):
        count += 1
        start, end = model.time, count * cable.step
        model.step(end)
        v = potential.v.x.array[order]
        if not np.isfinite(v).all():
            raise ComputationError("the potential is not a number", time=end, advice="a smaller --step.")
        highest = max(highest, float(v.max()))
        new = (old < level) & (v >= level) & np.isnan(activation)
        if new.any():
            activation[new] = start + (end - start) * (level - old[new]) / (v[new] - old[new])
            front = int(np.flatnonzero(new)[-1])
            if front > reached:
                reached, moved = front, end
                if len(frames) < len(marks) and front >= marks[len(frames)]:
                    frames.append((end, v.copy()))
        if end - moved > patience:
            raise _no_wave(cable, reached and float(X[reached]), highest, level, end)
        if shown is not None:
            shown.update(max(1, min(reached, last)), float(X[reached]))
        old = v
    if not activation[last] - activation[marks[2]] > 2 * cable.step:
        raise ComputationError(
            "all of the cable is activated at once: the membrane excites itself, or its steps blow up",
            time=model.time,
            advice="a smaller --step, or parameters with which the membrane rests.",
        )
    return Wave(cable, X, activation, frames)


def _no_wave(cable: Cable, reached: float, highest: float, level: float, time: float) -> ComputationError:
    (strength, duration), excited = cable.stimulus, cable.excited
    if highest < level:
        return ComputationError(
            f"no wave: the stimulus of {strength:g} for {duration:g} on the first {excited:.4g} of the "
            f"cable does not start one (the potential reached {highest:.4g}, the threshold is {level:g})",
            time=time,
            advice="a larger --set stimulus.strength or stimulus.duration, or a membrane that is excitable.",
        )
    return ComputationError(
        f"no wave: it stops at X = {reached:.4g} of {cable.length:.4g}. With D = {cable.diffusivity:g}, "
        f"nodes {cable.spacing:.4g} apart may be too far from each other to excite one another",
        time=time,
        advice="a smaller --spacing, a larger --diffusivity or --set stimulus.strength, or a membrane that "
        "is excitable.",
    )
