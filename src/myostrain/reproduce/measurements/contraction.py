"""When and for how long a place contracts after the potential has risen there, on lines and sheets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.activation import Rossi2014
from myostrain.case.case import Case
from myostrain.coupling import Electromechanics
from myostrain.reproduce.jobs import Array, Found, Job
from myostrain.reproduce.measurements.cases import resolved
from myostrain.reproduce.measurements.signals import first_rise, last_fall
from myostrain.reproduce.measurements.viscous import AtProbe

import numpy as np

#: The excitation at which a place counts as excited.
LEVEL = 0.5


def course_job(
    name: str,
    overrides: Sequence[str],
    *,
    stages: Sequence[tuple[float, float]],
    watch: float | tuple[float, float],
    places: tuple[float, float] | None = None,
    cost: float = 1.0,
) -> Job:
    """The job that runs a named case and follows one place, see :func:`course`.

    Args:
        name: The case.
        overrides: "KEY=VALUE", as on the command line.
        stages: Time steps, each with the time until which it is taken.
        watch: The place.
        places: X of the two between which the celerity is measured, on a line.
        cost: Seconds that it takes, roughly.
    """
    case = resolved(name, overrides)
    parameters = {"case": case, "stages": [list(stage) for stage in stages], "watch": watch, "places": places}
    return Job("contraction.course", parameters, cost)


def course(
    case: Mapping[str, Any],
    stages: Sequence[tuple[float, float]],
    watch: float | Sequence[float],
    places: Sequence[float] | None,
) -> Found:
    """Run a line or a sheet with steps that grow behind the front, and follow one place.

    Args:
        case: The case, resolved; its time step and its end are not used.
        stages: Time steps, each with the time until which it is taken.
        watch: The place, at a node of a line.
        places: X of the two places of a line between which the celerity is measured; None for none.

    Returns:
        Numbers: those of :func:`timing`, and with ``places`` those of :func:`pulse`. Arrays: ``times`` (m,),
        ``excitation`` (m,), ``shortening`` (m,), ``calcium`` (m,) if there is one; on a line ``X`` (n,),
        the ``arrival`` (n,) of the front and the ``front_stretch`` (n,) there and then; NaN for never.
    """
    model = Case.from_dict(case).build()
    model.start()
    lines = model.potential.body.dim == 1
    follow: Any = _OnLine(model, watch) if lines else _OnSheet(model, watch, case["fibres"]["direction"])
    follow.update()
    for step, end in stages:
        start = model.time
        for k in range(round((end - start) / step)):
            model.step(start + (k + 1) * step)
            if model.in_step:
                follow.update()
    arrays = follow.arrays()
    times, excitation, shortening = (arrays[name] for name in ("times", "excitation", "shortening"))
    numbers: dict[str, Any] = timing(times, excitation, shortening)
    if lines and places is not None:
        numbers |= pulse(arrays, places)
    return Found(numbers, arrays)


def timing(times: Array, excitation: Array, shortening: Array) -> dict[str, float | None]:
    """When a place contracts, and for how long, beside its potential.

    Args:
        times: Times (m,), ascending.
        excitation: The potential (m,), 0 at rest.
        shortening: 1 − |F f0| (m,).

    Returns:
        ``upstroke``, when the excitation rises through a half, from which the following times count, None
        where something does not happen: ``duration``, until it falls through half of its largest value, and
        ``repolarization``, through a tenth; ``peak``, the largest shortening; ``peak_delay`` and
        ``rise_delay``, until this and half of it are reached; ``half_end``, ``tenth_end``, until a half and a
        tenth of it are left. ``half_length`` is the time for which half of it is exceeded over that
        of the potential; ``tenth_length`` is ``tenth_end`` over ``repolarization``; ``delay_share`` is
        ``peak_delay`` over ``repolarization``; ``excitation_peak``.
    """
    begin = first_rise(times, excitation, LEVEL)
    made: dict[str, float | None] = {"upstroke": begin, "excitation_peak": float(excitation.max())}
    names = ("duration", "repolarization", "peak_delay", "rise_delay", "half_end", "tenth_end")
    made |= dict.fromkeys((*names, "half_length", "tenth_length", "delay_share"))
    made["peak"] = largest = float(shortening.max())
    if begin is None:
        return made
    after = times - begin
    made["duration"] = last_fall(after, excitation, excitation.max() / 2)
    made["repolarization"] = last_fall(after, excitation, excitation.max() / 10)
    if largest < 1e-6 or np.argmax(shortening) == len(times) - 1:
        return made
    made["peak_delay"] = delay = _top(after, shortening)
    made["rise_delay"] = first_rise(after, shortening, largest / 2)
    made["half_end"] = last_fall(after, shortening, largest / 2)
    made["tenth_end"] = last_fall(after, shortening, largest / 10)
    rise, end, duration = made["rise_delay"], made["half_end"], made["duration"]
    if rise is not None and end is not None and duration is not None:
        made["half_length"] = (end - rise) / duration
    if (whole := made["repolarization"]) is not None:
        made["delay_share"] = delay / whole
        made["tenth_length"] = None if made["tenth_end"] is None else made["tenth_end"] / whole
    return made


def _top(times: Array, values: Array) -> float:
    """When the largest value is reached: the top of the parabola through it and its neighbours."""
    i = int(np.argmax(values))
    if i in (0, len(values) - 1):
        return float(times[i])
    t, y = times[i - 1 : i + 2] - times[i], values[i - 1 : i + 2] - values[i]
    a, b, _ = np.polyfit(t, y, 2)
    return float(times[i] - b / (2 * a)) if a < 0 else float(times[i])


def pulse(arrays: Mapping[str, Array], places: Sequence[float]) -> dict[str, float | None]:
    """A pulse that travels steadily, from what passes one place: then c ∂/∂X is −∂/∂t.

    Args:
        arrays: ``times``, ``excitation``, ``shortening`` of the place; ``X`` and ``arrival`` of the line.
        places: X of two places.

    Returns:
        ``celerity`` in X between them; ``width_material``, ``width_spatial``, the lengths in X and x between
        upstroke and downstroke at an excitation of a half (each dt brings dX = c dt of material, x′ dX of
        space); ``steepness_material``, ``steepness_spatial``, the largest slopes of the excitation over X and
        x in the upstroke. None where the pulse does not come or end.
    """
    names = ("celerity", "width_material", "width_spatial", "steepness_material", "steepness_spatial")
    made: dict[str, float | None] = dict.fromkeys(names)
    times, excitation, stretch = arrays["times"], arrays["excitation"], 1 - arrays["shortening"]
    begin = first_rise(times, excitation, LEVEL)
    first, second = np.interp(places, arrays["X"], arrays["arrival"])
    if begin is None or not second - first > 0:
        return made
    celerity = float((places[1] - places[0]) / (second - first))
    rates = np.diff(excitation) / np.diff(times) / celerity
    middle = (stretch[1:] + stretch[:-1]) / 2
    made |= {
        "celerity": celerity,
        "steepness_material": float(rates.max()),
        "steepness_spatial": float((rates / middle).max()),
    }
    if (end := last_fall(times, excitation, LEVEL)) is not None:
        passed = np.concatenate([[0.0], np.cumsum(np.diff(times) * middle)])
        ends = np.interp([begin, end], times, passed)
        made["width_material"] = celerity * (end - begin)
        made["width_spatial"] = celerity * float(ends[1] - ends[0])
    return made


def arrivals(times: Array, excitation: Array, stretch: Array) -> tuple[Array, Array]:
    """When places are first excited, and their stretch then, linear in time; NaN for never.

    Args:
        times: Times (m,), ascending.
        excitation: Excitations (m, n).
        stretch: Stretches (m, n).
    """
    rises = (excitation[:-1] < LEVEL) & (excitation[1:] >= LEVEL)
    k, n = rises.argmax(axis=0), np.arange(excitation.shape[1])
    before, after = excitation[k, n], excitation[k + 1, n]
    share = np.where(
        rises.any(axis=0), (LEVEL - before) / np.where(after > before, after - before, 1.0), np.nan
    )
    return times[k] + share * (times[k + 1] - times[k]), stretch[k, n] + share * (
        stretch[k + 1, n] - stretch[k, n]
    )


class _OnLine:
    """Keeps excitation and displacement of a whole line, in ascending X."""

    def __init__(self, model: Electromechanics, watch: Any) -> None:
        X = model.potential.v.function_space.tabulate_dof_coordinates()[:, 0]
        self._model, self._order = model, np.argsort(X)
        self._X = X[self._order]
        self._node = int(np.argmin(np.abs(self._X - watch)))
        self._times: list[float] = []
        self._excitation: list[Array] = []
        self._u: list[Array] = []
        self._calcium: list[float] = []

    def update(self) -> None:
        """Sample the present state."""
        potential, u = self._model.potential, self._model.displacement()
        self._times.append(self._model.time)
        self._excitation.append(potential.excitation[self._order])
        self._u.append(np.zeros_like(self._X) if u is None else u[self._order, 0].copy())
        if potential.calcium is not None:
            calcium = potential.field_values()[potential.calcium]
            self._calcium.append(float(calcium[self._order[self._node]]))

    def arrays(self) -> dict[str, Array]:
        """What the place has gone through, and when the front passed; stretches are those of two cells."""
        i, excitation = self._node, np.array(self._excitation)
        stretch = 1 + np.gradient(np.array(self._u), self._X, axis=1)
        arrival, there = arrivals(np.array(self._times), excitation, stretch)
        found = {
            "times": np.array(self._times),
            "excitation": excitation[:, i],
            "shortening": 1 - stretch[:, i],
            "X": self._X,
            "arrival": arrival,
            "front_stretch": there,
        }
        return found | ({"calcium": np.array(self._calcium)} if self._calcium else {})


class _OnSheet:
    """Keeps excitation and shortening of the triangle at a place."""

    def __init__(self, model: Electromechanics, watch: Any, direction: Sequence[float]) -> None:
        self._model = model
        self._probe = AtProbe(model, "watched", watch, direction)
        self._rest, self._top = 0.0, 1.0

    def update(self) -> None:
        """Sample the present state."""
        self._probe.update(0, self._model.time)

    def arrays(self) -> dict[str, Array]:
        """What the place has gone through."""
        membrane = self._model.potential.membrane
        rest = membrane.resting_potential()
        excitation = (np.array(self._probe.potential) - rest) / (membrane.range[1] - rest)
        times, shortening = np.array(self._probe.times), np.array(self._probe.shortening)
        return {"times": times, "excitation": excitation, "shortening": shortening}


def mapped(
    case: Mapping[str, Any],
    stages: Sequence[tuple[float, float]],
    watch: float,
    beta: float,
    relaxation: Sequence[float],
    rise: Sequence[float],
    fall: Sequence[float],
    thresholds: Sequence[float],
    rossi: Sequence[Sequence[float]],
    samples: int,
) -> Found:
    """Contraction of a free place under many laws, from the potential of a rigid line alone.

    On a free line the stretch is 1 + γ, or follows it as the dashpot says, at each place by itself.

    Args:
        case: A rigid line, resolved.
        stages: Time steps, each with the time until which it is taken.
        watch: The place.
        beta: β of γ = −β × excitation.
        relaxation: Relaxation times λ of the viscous line.
        rise: Rise times of the relaxing law.
        fall: Fall times of the same.
        thresholds: The excitations at which it changes from one to the other.
        rossi: (α, μ) of the law of Rossi and others, if the membrane has calcium.
        samples: Steps over which the courses are integrated.

    Returns:
        Numbers: :func:`timing` without any contraction. Arrays by NAME MEASURE, where NAME is ``viscosity``
        (λ), ``relaxing`` (thresholds, rise, fall) or ``rossi`` and MEASURE one of ``peak_delay``,
        ``rise_delay``, ``half_end``, ``tenth_end``, ``delay_share``, ``half_length``, ``tenth_length``,
        ``peak`` and ``left``, the shortening at the end over its peak; NaN for None.
    """
    run = course(case, stages, watch, None)
    times = np.linspace(0.0, run.arrays["times"][-1], samples + 1)
    v = np.interp(times, run.arrays["times"], run.arrays["excitation"])
    made: dict[str, Array] = {}

    def keep(name: str, shortenings: Array, shape: Sequence[int]) -> None:
        found = [timing(times, v, one) | {"left": one[-1] / one.max()} for one in shortenings.T]
        for measure in MEASURES:
            values = np.array([one[measure] for one in found], dtype=float)
            made[f"{name} {measure}"] = values.reshape(shape)

    keep("viscosity", viscous(times, v, beta, np.array(relaxation)), (len(relaxation),))
    grid = np.meshgrid(thresholds, rise, fall, indexing="ij")
    flat = [one.ravel() for one in grid]
    keep("relaxing", relaxing(times, v, beta, flat[1], flat[2], flat[0]), grid[0].shape)
    if rossi:
        calcium = np.interp(times, run.arrays["times"], run.arrays["calcium"])
        laws = [Rossi2014(alpha=alpha, mu=mu) for alpha, mu in rossi]
        keep("rossi", np.stack([driven(times, calcium, law) for law in laws], axis=1), (len(laws),))
    return Found(run.numbers, made)


MEASURES = (
    "peak_delay",
    "rise_delay",
    "half_end",
    "tenth_end",
    "delay_share",
    "half_length",
    "tenth_length",
    "peak",
    "left",
)


def viscous(times: Array, v: Array, beta: float, relaxation: Array) -> Array:
    """1 − x′ (m, n) of the free viscous line for λ (n,): λ y′ + y = γ/(1 + γ) for y = (x′ − 1)/(1 + γ)."""
    gamma = -beta * v
    middle = (gamma[1:] + gamma[:-1]) / 2
    y = np.zeros((len(times), len(relaxation)))
    decay = np.exp(-np.diff(times)[:, None] / relaxation)
    for k, goal in enumerate(middle / (1 + middle)):
        y[k + 1] = goal + (y[k] - goal) * decay[k]
    return np.asarray(-y * (1 + gamma)[:, None])


def relaxing(times: Array, v: Array, beta: float, rise: Array, fall: Array, threshold: Array) -> Array:
    """−γ (m, n) of τ γ′ = −βv − γ with τ = rise above a threshold and fall below, each (n,)."""
    middle = (v[1:] + v[:-1]) / 2
    shortening = np.zeros((len(times), len(rise)))
    for k, (u, step) in enumerate(zip(middle, np.diff(times), strict=True)):
        decay = np.exp(-step / np.where(u > threshold, rise, fall))
        shortening[k + 1] = beta * u + (shortening[k] - beta * u) * decay
    return shortening


def driven(times: Array, calcium: Array, law: Any) -> Array:
    """−γ (m,) of a free place under a law of calcium and stretch, λ = 1 + γ, by its own steps."""
    gamma = np.zeros(1)
    found = [0.0]
    for c, step in zip((calcium[1:] + calcium[:-1]) / 2, np.diff(times), strict=True):
        drivers = {"calcium": np.array([c]), "stretch": 1 + gamma}
        gamma = law.advance(gamma[None], drivers, step)[0]
        found.append(-float(gamma[0]))
    return np.array(found)
