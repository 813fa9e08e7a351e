"""A membrane without a body: paced by a stimulus, beat after beat."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from myostrain.errors import ComputationError, InputError, nearest
from myostrain.membranes import check_membrane
from myostrain.membranes.exponential import exponential_step
from myostrain.membranes.reaction import GATE_MARGIN
from myostrain.membranes.tracing import traced
from myostrain.pointwise import TimeLoop
from myostrain.single_cell.beat import measure_beat

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: Beats unless given.
BEATS = 10
#: Time between two beats of a model that counts time in this unit, and its step.
CYCLES = {"ms": 1000.0, "s": 1.0}
STEPS = {"ms": 0.01, "s": 1e-5}
#: The same where time has no unit: so many durations of the stimulus, which is so many steps long.
DURATIONS, STEPS_OF_A_STIMULUS = 200.0, 100
#: Samples of a cycle that the trace holds, about; of the stimulus ten more. Beats that it holds at most.
SAMPLES, KEPT_BEATS = 2000, 10
#: Steps of a beat at most: potential and calcium are kept of each.
MOST_STEPS = 20_000_000
#: By how many spans of its range the potential may leave it; beyond, the steps are too long or the
#: stimulus is too strong, though all are numbers.
FAR = 10


class Progress(Protocol):
    """What is told how far it is."""

    def update(self, step: int, time: float) -> None:
        """``step`` beats are done, the time is ``time``."""
        ...


@dataclass(frozen=True)
class Paced:
    """A membrane that was paced.

    Args:
        membrane: The model.
        cycle: Time between the beginnings of two beats.
        stimulus: Strength (rate of v) and duration of what excites each.
        step: Step of time, None where steps were adaptive.
        time: Times of the samples (n,) since the first beat began; of the last ten beats at most.
        potential: Potential (n,).
        states: States by name, (n,) each.
        beats: What each beat measures, see :func:`~myostrain.single_cell.beat.measure_beat`.
        notes: Why something of the last beat has no value, by its name.
        end: Potential and states after the last beat, by name.
    """

    membrane: Any
    cycle: float
    stimulus: tuple[float, float]
    step: float | None
    time: Array
    potential: Array
    states: Mapping[str, Array]
    beats: Sequence[Mapping[str, float | None]]
    notes: Mapping[str, str]
    end: Mapping[str, float]

    @property
    def last(self) -> Mapping[str, float | None]:
        """What the last beat measures."""
        return self.beats[-1]

    @property
    def alternans(self) -> float | None:
        """Difference between the APD90 of the last two beats; None where one has none."""
        if len(self.beats) < 2 or None in (pair := [beat["apd90"] for beat in self.beats[-2:]]):
            return None
        return abs(pair[1] - pair[0])  # type: ignore[operator]

    @property
    def calcium(self) -> Array | None:
        """The calcium (n,), None where the membrane has none."""
        name = getattr(self.membrane, "calcium", None)
        return None if name is None else self.states[name]


class _Phase(NamedTuple):
    seen: Array  # potential, and calcium, after each step
    times: Any
    sampled: Array
    sample_times: Any


def cell(
    membrane: Any,
    *,
    cycle: float | None = None,
    beats: int = BEATS,
    stimulus: tuple[float, float] | None = None,
    step: float | None = None,
    initial: Mapping[str, float] | None = None,
    progress: Callable[[float], Progress] | None = None,
) -> Paced:
    """Pace a membrane without a body, as ``myostrain cell`` does.

    Each beat begins with the stimulus, a constant rate of v; steps hit its edges. A step is the exponential
    one of second order of all states and the potential alike, as that of
    :class:`~myostrain.membranes.GeneralizedRushLarsen`, compiled. Without a compiler, and for a model that
    cannot be traced, SciPy's LSODA takes its place, with tolerance 1e-7.

    Args:
        membrane: The model.
        cycle: Time between two beats; 1000 ms unless given, or 200 durations of the stimulus where time has
            no unit.
        beats: Number of beats.
        stimulus: Strength (rate of v) and duration; the membrane's ``pacing`` unless given.
        step: Step of time; 0.01 ms unless given, or a hundredth of the stimulus where time has no unit.
        initial: Potential ("potential") and states to begin with, by name; at rest unless given.
        progress: Makes what is told of each beat, from the time at which the last one ends.

    Raises:
        InputError: No membrane, or a number that cannot be.
        ComputationError: A gate has left [0, 1], the potential its range by far, or one is not a number.
    """
    check_membrane(membrane)
    names = tuple(getattr(membrane, "states", ()))
    strength, duration = _stimulus(membrane, stimulus)
    unit = getattr(membrane, "time_unit", None)
    cycle = CYCLES.get(str(unit), DURATIONS * duration) if cycle is None else float(cycle)
    step = STEPS.get(str(unit), duration / STEPS_OF_A_STIMULUS) if step is None else float(step)
    if not (np.isfinite(cycle) and cycle > duration):
        raise InputError(
            f"{cycle:g}: give a time longer than the stimulus, which lasts {duration:g}", "cycle"
        )
    if not (np.isfinite(step) and 0 < step <= cycle - duration):
        raise InputError(f"{step:g}: give a positive time, shorter than the cycle", "step")
    if cycle / step > MOST_STEPS:
        raise InputError(
            f"{cycle:g}: that makes {cycle / step:.2g} steps of {step:g}; give {MOST_STEPS * step:.3g} at "
            "most, or longer steps",
            "cycle",
        )
    if not (beats >= 1 and beats % 1 == 0):
        raise InputError(f"{beats}: give a number of beats, one or more", "beats")
    values = np.array(
        [membrane.resting_potential(), *membrane.resting_states()][: 1 + len(names)], dtype=float
    )
    for name, value in (initial or {}).items():
        if name not in (known := ["potential", *names]):
            raise InputError(f"'{name}' is not a state; {nearest(name, known)}", "initial")
        if not np.isfinite(value):
            raise InputError(f"{name} is {value}: give a finite number", "initial")
        values[known.index(name)] = value
    advance, compiled = _integrator(membrane, names)
    calcium = getattr(membrane, "calcium", None)
    watched = [0] if calcium is None else [0, 1 + names.index(calcium)]
    shown = None if progress is None else progress(beats * cycle)
    kept: list[tuple[Array, Array]] = []
    measured: list[Mapping[str, float | None]] = []
    notes: dict[str, str] = {}
    for beat in range(int(beats)):
        begin, start = beat * cycle, values.copy()
        sampling = max(1, round(cycle / SAMPLES / step))
        phases = [
            advance(
                values,
                begin,
                duration,
                strength,
                step,
                max(1, min(sampling, int(duration / step / 10))),
                watched,
            ),
            advance(values, begin + duration, cycle - duration, 0.0, step, sampling, watched),
        ]
        found, notes = measure_beat(
            np.concatenate([[0.0], *(phase.times - begin for phase in phases)]),
            np.vstack([start[watched], *(phase.seen for phase in phases)]).T,
            float(getattr(membrane, "threshold", 0.5)),
            (strength, duration),
        )
        measured.append(found)
        if beat >= beats - KEPT_BEATS:
            first = [] if kept else [(np.array([begin]), start[np.newaxis])]
            kept += [*first, *((phase.sample_times, phase.sampled) for phase in phases)]
        if shown is not None:
            shown.update(beat + 1, begin + cycle)
    time, samples = (np.concatenate(parts) for parts in zip(*kept, strict=True))
    return Paced(
        membrane,
        cycle,
        (strength, duration),
        step if compiled else None,
        time,
        samples[:, 0],
        dict(zip(names, samples[:, 1:].T, strict=True)),
        measured,
        notes,
        dict(zip(("potential", *names), map(float, values), strict=True)),
    )


def _stimulus(membrane: Any, given: tuple[float, float] | None) -> tuple[float, float]:
    found: Any = getattr(membrane, "pacing", None) if given is None else given
    if found is None:
        raise InputError(
            f"{type(membrane).__name__} declares no pacing: give strength (rate of v) and duration",
            "stimulus",
        )
    try:
        strength, duration = map(float, found)
    except (TypeError, ValueError):
        raise InputError(f"{found!r}: give strength (rate of v) and duration", "stimulus") from None
    if not (np.isfinite(strength) and np.isfinite(duration) and duration > 0):
        raise InputError(f"{found}: give a finite strength and a positive duration", "stimulus")
    return strength, duration


def _integrator(membrane: Any, names: tuple[str, ...]) -> tuple[Callable[..., _Phase], bool]:
    """What advances the values over a time in which the stimulus is constant, and whether it is compiled."""
    loop = _compiled(membrane, names)

    def advance(
        values: Array,
        begin: float,
        length: float,
        applied: float,
        step: float,
        every: int,
        watched: list[int],
    ) -> _Phase:
        steps = max(1, int(np.ceil(length / step * (1 - 1e-12))))
        times, ends = length * np.arange(1, steps + 1) / steps, _samples(steps, every)
        if loop is None:
            found = _by_scipy(membrane, values, applied, times, begin)
            for end in ends:
                if _wrong(membrane, names, found[end]) is not None:
                    raise _failure(membrane, names, found[end], begin + times[end])
            values[:] = found[-1]
            return _Phase(found[:, watched], begin + times, found[ends], begin + times[ends])
        run, numbers = loop
        seen, sampled, taken = run(values, [length / steps, applied, *numbers], steps, every, watched)
        if taken < steps:
            raise _failure(membrane, names, values, begin + times[taken])
        if len(ends) > len(sampled):
            sampled = np.vstack([sampled, values])
        return _Phase(seen, begin + times, sampled, begin + times[ends])

    return advance, loop is not None


def _samples(steps: int, every: int) -> Any:
    """The steps after which all values are kept: each so many, and the last one."""
    return np.union1d(np.arange(every - 1, steps, every), steps - 1)


def _compiled(membrane: Any, names: tuple[str, ...]) -> tuple[TimeLoop, list[float]] | None:
    """The loop over steps and the values of the parameters; None where it cannot be compiled."""
    model = traced(membrane)
    if model is None:
        return None
    graph = model.graph
    values = [graph.input("potential"), *(graph.input(f"state {name}") for name in names)]
    length, applied = (graph.input(name, varies=False) for name in ("length of the step", "applied rate"))
    after = exponential_step(
        lambda y: [applied - model.current(y[0], y[1:]), *model.rates(y[0], y[1:])],
        values,
        length,
        2,
        every_state=True,
    )
    good: Any = True
    for (low, high), value in zip(_limits(membrane, names), after, strict=True):
        good = (value >= low) & (value <= high) & good
    loop = TimeLoop(values, [length, applied, *model.scalars], [*after, good])
    return (loop, model.numbers(membrane)) if loop.compiled else None


def _by_scipy(membrane: Any, values: Array, applied: float, times: Array, begin: float) -> Array:
    from scipy.integrate import solve_ivp

    def rates(_: float, y: Array) -> Array:
        v, states = y[:1], y[1:, np.newaxis]
        found = [applied - membrane.current(v, states), *(membrane.rates(v, states) if len(states) else ())]
        return np.array([np.broadcast_to(rate, 1)[0] for rate in found], dtype=float)

    with np.errstate(all="ignore"):
        found = solve_ivp(
            rates,
            (0.0, times[-1]),
            values,
            "LSODA",
            t_eval=times,
            rtol=1e-7,
            atol=1e-10,
            first_step=times[0] / 10,
        )
    if not found.success or not np.isfinite(found.y).all():
        raise ComputationError(
            f"LSODA could not go on: {found.message}",
            time=begin + float(found.t[-1] if len(found.t) else 0.0),
        )
    return np.ascontiguousarray(found.y.T)


def _limits(membrane: Any, names: tuple[str, ...]) -> list[tuple[float, float]]:
    """Between what the potential and the states have to be."""
    low, high = getattr(membrane, "range", (0.0, 1.0))
    far = FAR * (high - low)
    gates = getattr(membrane, "gates", ())
    of_states = [(-GATE_MARGIN, 1 + GATE_MARGIN) if name in gates else (-1e100, 1e100) for name in names]
    return [(low - far, high + far), *of_states]


def _wrong(membrane: Any, names: tuple[str, ...], values: Array) -> str | None:
    """What is wrong with the potential or a state, in words; None if nothing is."""
    limits = _limits(membrane, names)
    for name, value, (low, high) in zip(("potential", *names), values.tolist(), limits, strict=True):
        if low <= value <= high:
            continue
        what = "the potential" if name == "potential" else f"the state {name}"
        if not np.isfinite(value):
            return f"{what} is {value}"
        if name in getattr(membrane, "gates", ()):
            return f"the gate {name} has left [0, 1]: {value:.6g}"
        if name != "potential":
            return f"{what} is {value:.6g}"
        range_ = tuple(getattr(membrane, "range", (0.0, 1.0)))
        return f"{what} is {value:.6g}, far out of its range {range_}"
    return None


def _failure(membrane: Any, names: tuple[str, ...], values: Array, time: float) -> ComputationError:
    reason = _wrong(membrane, names, values) or "a value is out of bounds"
    return ComputationError(
        f"{type(membrane).__name__}: {reason}",
        time=time,
        advice="a smaller step, a weaker stimulus, or other parameters.",
    )
