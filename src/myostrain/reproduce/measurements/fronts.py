"""Homogeneous states and travelling fronts on the contracting line: the start of section 4, and 4.1."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.case.case import Case
from myostrain.coupling import Electromechanics
from myostrain.errors import InputError
from myostrain.output.metrics import leading_pulse
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements.signals import first_rise
from myostrain.theory import profile, spatial_coordinate, speed, steepness

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: Increment of a complex step, whose square vanishes beside one.
COMPLEX_STEP = 1e-100


def homogeneous(
    case: Mapping[str, Any], potentials: Sequence[float], drift: Sequence[float], growth: Sequence[float]
) -> Found:
    """What becomes of homogeneous states (v, w = τv) of the line, and of small perturbations of them.

    Args:
        case: A case on a line, resolved.
        potentials: v of each state.
        drift: Time step and end of the runs from the states themselves.
        growth: Time step, end and size of the perturbations of either sign, of v and of w.

    Returns:
        Numbers: ``drift``, by state the largest change of v and w; ``rates``, by state the real and imaginary
        parts of the rates at which perturbations grow, [[re, im], ...], of the program's own steps;
        ``predicted``, the same by linear algebra from the cell's and the activation's functions; ``bent``,
        by state how far the responses to both signs are from opposite, relative.
    """
    made = Case.from_dict(case)
    model = made.build()
    states = [[v] + [made.cell.tau * v] * len(made.cell.states) for v in potentials]
    found: dict[str, Any] = {"drift": [], "rates": [], "predicted": [], "bent": []}
    for state in states:
        point = np.array(state)
        found["drift"].append(float(np.abs(_advance(model, point, *drift) - point).max()))
        step, end, size = growth
        both = [
            [_advance(model, point + sign * size * e, step, end) for sign in (1, -1)]
            for e in np.eye(len(point))
        ]
        propagator = np.array([(up - down) / (2 * size) for up, down in both]).T
        found["bent"].append(
            max(float(np.linalg.norm(up + down - 2 * point) / np.linalg.norm(up - down)) for up, down in both)
        )
        found["rates"].append(_parts(np.log(np.linalg.eigvals(propagator).astype(complex)) / end))
        found["predicted"].append(_parts(np.linalg.eigvals(_linearised(made, point))))
    return Found(found)


def temporal_variation(case: Mapping[str, Any], potentials: Sequence[float], step: float) -> Found:
    """∂v/∂t of homogeneous states without recovery, by one small implicit step of the program.

    Args:
        case: A case on a line without recovery, resolved, with the implicit scheme.
        potentials: v of the states, ascending, four or more.
        step: The time step.

    Returns:
        Arrays: ``potential`` and ``rate``. Numbers: ``zeros``, where the rate changes sign, by the cubic
        through four states.
    """
    model = Case.from_dict(case).build()
    v = np.asarray(potentials, dtype=float)
    rate = np.array([(_advance(model, np.array([value]), step, step)[0] - value) / step for value in v])
    zeros = []
    for i in np.flatnonzero(rate[:-1] * rate[1:] < 0).tolist():
        first = min(max(i - 1, 0), len(v) - 4)
        near = slice(first, first + 4)
        roots = np.polynomial.Polynomial.fit(v[near], rate[near], 3).roots()
        zeros.append(float(min(roots.real, key=lambda root: abs(root - (v[i] + v[i + 1]) / 2))))
    return Found({"zeros": zeros}, {"potential": v, "rate": rate})


def spreading(case: Mapping[str, Any], potential: float, size: float) -> Found:
    """How fast a cosine of one half wave over the line decays on a homogeneous potential, without reaction.

    Args:
        case: A case on a line with A = 0, resolved.
        potential: The homogeneous potential.
        size: Amplitude of the cosine.

    Returns:
        Numbers: ``rate`` of the decay.
    """
    made = Case.from_dict(case)
    model = made.build()
    X = _coordinates(model)
    wave = np.cos(np.pi * X / X.max())
    model.potential.v.x.array[:] = potential + size * wave
    model.start()
    steps = round(made.time.end / made.time.step)
    for number in range(1, steps + 1):
        model.step(number * made.time.step)
    weight = model.potential.weight
    left = float((weight * wave * model.potential.v.x.array).sum() / (weight * wave**2).sum())
    return Found({"rate": float(np.log(size / left) / made.time.end)})


def travel(case: Mapping[str, Any], start: float) -> Found:
    """A front as in the paper, v = 0 on the left and v = 1 on the right, that begins with the exact profile.

    Args:
        case: A case on a line without recovery, resolved; the left end is fixed.
        start: Material coordinate of v = 1/2 at first.

    Returns:
        Numbers, the exact ones of (4.9)–(4.12) as ``..._exact``: the velocity ``c`` in v(X − ct), of the
        second half of the run, and ``unsettled``, by how much that of the quarter before differs, relative;
        ``steepness``, the slope of log(v / (1 − v)) over x where 0.05 < v < 0.95; ``slope``, ∂v/∂X at
        v = 1/2; ``width_material`` and ``width_spatial`` from v = 0.1 to 0.9; ``potential_error`` and
        ``place_error``, the largest differences of v(X) and x(X) from (4.9) and (4.12), the exact front
        placed where the measured one has v = 1/2; ``shortening`` of the whole line; ``nodes``; ``steps``.
        Arrays at the end: ``X``, ``x``, ``v``, and ``v_exact``, ``x_exact``.
    """
    made = Case.from_dict(case)
    alpha, beta = made.cell.alpha, made.law.beta
    theory: dict[str, Any] = {
        "diffusivity": made.potential.diffusivity,
        "A": made.cell.A,
        "balance": made.potential.balance,
    }
    simulation = made.simulation()
    model = simulation.model
    X = _coordinates(model)
    order = np.argsort(X)
    v = model.potential.v.x.array
    v[:] = profile(X - start, alpha, beta, **theory)
    front = _Front(model, order, every=max(1, simulation.steps // 60))
    front.update(0, 0.0)
    simulation.run(front)
    times, places = np.array(front.times), np.array(front.places)
    late = times >= times[-1] / 2
    before = (times >= times[-1] / 4) & ~late
    c = float(np.polyfit(times[late], places[late], 1)[0])
    c_before = float(np.polyfit(times[before], places[before], 1)[0])

    assert model.mechanics is not None
    X, v = X[order], v[order]
    x = X + model.mechanics.displacement().x.array[order]
    inside = (v > 0.05) & (v < 0.95)
    half, slope = front.crossing(v)
    v_exact = np.asarray(profile(X, alpha, beta, center=half, **theory))
    x_exact = np.asarray(spatial_coordinate(X, alpha, beta, center=half, **theory))
    a = float(steepness(alpha, beta, **theory))
    levels = np.interp([0.1, 0.9], v, X), np.interp([0.1, 0.9], v, x)
    numbers = {
        "c": c,
        "c_exact": -float(speed(alpha, beta, **theory)),
        "unsettled": abs(c_before / c - 1),
        "steepness": float(np.polyfit(x[inside], np.log(v[inside] / (1 - v[inside])), 1)[0]),
        "steepness_exact": a,
        "slope": slope,
        "slope_exact": a * (1 - beta / 2) / 4,
        "width_material": float(np.ptp(levels[0])),
        "width_spatial": float(np.ptp(levels[1])),
        "potential_error": float(np.abs(v - v_exact).max()),
        "place_error": float(np.abs(x - x_exact).max()),
        "shortening": float((X - x)[-1]),
        "nodes": len(X),
        "steps": simulation.steps,
    }
    return Found(numbers, {"X": X, "x": x, "v": v, "v_exact": v_exact, "x_exact": x_exact})


def refusal(case: Mapping[str, Any]) -> Found:
    """Whether the program refuses to build a case.

    Returns:
        Numbers: ``refused``, 1 or 0, and the ``message``.
    """
    try:
        Case.from_dict(case).build()
    except InputError as error:
        return Found({"refused": 1, "message": str(error)})
    return Found({"refused": 0, "message": ""})


def shooting(alpha: float, betas: Sequence[float], fastest: float, speeds: int, points: int) -> Found:
    """All monotone fronts of (4.8) with A = D = 1, whatever their shape: by shooting, without (4.9).

    With v′ = q v (1 − v)(1 − βv) and y = log(v / (1 − v)), (4.8) is

        dq/dy = −q (1 − 2v) − c (1 − 2βv) − (v − α) / q,

    and the family (4.9) is q = a. A front leaves the saddle v = 0 on its only outgoing branch and enters the
    saddle v = 1 on its only ingoing one: both are followed to v = 1/2, and it exists where they meet.

    Args:
        alpha: α > 1/2: the fronts retreat, c > 0.
        betas: β of each search.
        fastest: c is searched up to it.
        speeds: How many c.
        points: Points in y from −12 to 0 and from 0 to 12.

    Returns:
        Numbers: ``betas`` and ``c``, None where the branches do not meet for 0 < c <= fastest.
    """
    beta, c = np.meshgrid(np.asarray(betas, dtype=float), np.linspace(0, fastest, speeds), indexing="ij")
    drag = c * (1 - 2 * beta)
    leaving = (-c + np.sqrt(c**2 + 4 * alpha)) / 2
    entering = (drag + np.sqrt(drag**2 + 4 * (1 - alpha))) / 2

    def rate(y: float, q: Array) -> Array:
        v = 1 / (1 + np.exp(-y))
        slope: Array = -q * (1 - 2 * v) - c * (1 - 2 * beta * v) - (v - alpha) / q
        return slope

    def follow(q: Array, begin: float) -> Array:
        """Fourth-order Runge–Kutta to y = 0; a branch that comes down to v′ = 0 ends there."""
        y, h = begin, -begin / points
        for _ in range(points):
            k1 = rate(y, q)
            k2 = rate(y + h / 2, np.maximum(q + h / 2 * k1, FLOOR))
            k3 = rate(y + h / 2, np.maximum(q + h / 2 * k2, FLOOR))
            k4 = rate(y + h, np.maximum(q + h * k3, FLOOR))
            moved = np.maximum(q + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), FLOOR)
            q = np.where(q > FLOOR, moved, FLOOR)
            y += h
        return q

    gap = follow(leaving, -12.0) - follow(entering, 12.0)
    found: list[float | None] = []
    for one in gap:
        turns = np.flatnonzero(one[:-1] * one[1:] < 0)
        found.append(first_rise(c[0], one * np.sign(one[turns[0] + 1]), 0.0) if len(turns) else None)
    return Found({"betas": list(betas), "c": found})


#: Where a branch of :func:`shooting` has come down to v′ = 0.
FLOOR = 1e-3


class _Front:
    """Records where the front is."""

    def __init__(self, model: Electromechanics, order: npt.NDArray[np.intp], every: int) -> None:
        self._model, self._order, self._every = model, order, every
        self._X = _coordinates(model)[order]
        self.times: list[float] = []
        self.places: list[float] = []

    def update(self, step: int, reached: float) -> None:
        if step % self._every == 0:
            self.times.append(reached)
            self.places.append(self.crossing(self._model.potential.v.x.array[self._order])[0])

    def crossing(self, v: Array) -> tuple[float, float]:
        """X of v = 1/2, which rises to the right, and ∂v/∂X there."""
        pulse = leading_pulse(-self._X[::-1], -self._X[::-1], v[::-1])
        assert pulse is not None
        return -pulse.front, pulse.slope


def _coordinates(model: Electromechanics) -> Array:
    X: Array = model.potential.v.function_space.tabulate_dof_coordinates()[:, 0].copy()
    return X


def _advance(model: Electromechanics, state: Array, step: float, end: float) -> Array:
    """Means of potential and states after a run from homogeneous ones."""
    potential = model.potential
    potential.v.x.array[:], potential.states[:] = state[0], state[1:, None]
    model.start()
    for number in range(1, round(end / step) + 1):
        model.step(number * step)
    return np.array([values.mean() for values in potential.field_values().values()])


def _linearised(case: Case, state: Array) -> Array:
    """Matrix L of the homogeneous (v, w)′ = L (v, w) about an equilibrium.

    Conservative: ∂(Jv)/∂t = J f, ∂(Jw)/∂t = J g with f = g = 0 there, so that M L = J (f, g)′ with the matrix
    M of ∂(Jv, Jw)/∂(v, w). Advective: M = J.
    """
    n = len(state)
    held = case.mechanics.imposed_stretch is not None

    def balances(values: Any) -> Any:
        v, states = values[0], list(values[1:])
        return np.array([-case.cell.current(v, states), *case.cell.rates(v, states)])

    def amounts(values: Any) -> Any:
        ratio = 1.0 if held else 1 + case.law.activation((), {"excitation": values[0]})
        return np.array([ratio * value for value in values])

    def derivative(f: Any) -> Array:
        columns = [f(state + 1j * COMPLEX_STEP * e).imag / COMPLEX_STEP for e in np.eye(n)]
        return np.array(columns, dtype=float).T

    J = 1.0 if held else 1 + float(case.law.activation((), {"excitation": state[0]}))
    conserved = case.potential.balance == "conservative"
    M = derivative(amounts) if conserved else J * np.eye(n)
    return np.linalg.solve(M, J * derivative(balances))


def _parts(values: npt.NDArray[Any]) -> list[list[float]]:
    """[[re, im], ...] in ascending order."""
    return sorted([float(value.real), float(value.imag)] for value in values)
