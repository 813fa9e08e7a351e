"""The contracting line by finite differences: an independent reference for the finite element program.

Shares nothing with myostrain but the equations of the paper (Ambrosi, Arioli, Nobile, Quarteroni 2011),
numbered as there; only NumPy and SciPy.  Non-dimensional.  Second order in space (finite volumes around the
nodes X = 0, dx, 2 dx, ..., zero flux at both ends), and in time the variable-order implicit method of LSODA
to a tolerance far below the error in space, so that a result is that of dx alone.

    from reference.line_fd import Line, solve
    pulse = solve(Line(mechanics="elastic"))
    pulse.celerity, pulse.width_material, pulse.width_spatial, pulse.potential_max

Equations, with J = x' and F = J ("line"), f = v (v - alpha)(v - 1), D and A as in (3.5):

    conservative (4.4), (4.7)   d(J v)/dt = (D J F^-2 v')' - A J f - A J w,   d(J w)/dt = J (v - w/tau)
    advective                   J dv/dt   = (D J F^-2 v')' - A J f - A J w,      dw/dt  =    v - w/tau

    rigid          J = 1
    elastic        J = 1 - beta v                                                   (4.3), (3.4)
    viscoelastic   J = 1 + e (1 - beta v),  lambda de/dt + e + beta v / (1 - beta v) = 0,  e(0) = 0
                   which is lambda d/dt[(x'-1)/(1+gamma)] + (x' - 1 - gamma)/(1+gamma) = 0, at first x' = 1;
                   (4.14) as printed has no activation when lambda -> 0
    imposed        J = s for 0 < t < until, then free: J v and J w of each particle are conserved at the
                   release (v and w themselves in the advective form)
    "strip"        J = 1 and F = sqrt(1 - beta v): (7.2) on a free plane-strain incompressible strip

Run as a program it prints the numbers of the paper's figures 1 and 2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.integrate import LSODA


@dataclass(frozen=True)
class Line:
    """A case: by default figure 1 of the paper, elastic and conservative."""

    mechanics: str = "elastic"  # or "rigid", "viscoelastic"
    balance: str = "conservative"  # or "advective"
    kinematics: str = "line"  # or "strip"
    relaxation_time: float = 0.0  # lambda, with mechanics = "viscoelastic"
    recovery: bool = True
    imposed_stretch: tuple[float, float] | None = None  # (value, until)

    alpha: float = 0.1
    tau: float = 0.2
    A: float = 100.0
    diffusivity: float = 100.0
    beta: float = 0.3

    length: float = 400.0
    spacing: float = 1.0
    potential: float = 0.9  # v = potential at X <= radius, else 0
    radius: float = 5.0
    averaged: bool = False  # a node takes the bump's average over its volume, not its value there
    initial: Callable | None = None  # or v(X) in place of the bump

    end: float = 5.0
    sample: float = 1e-3  # between the times at which the probes are read
    probes: tuple[float, ...] = (100.0, 200.0)
    rtol: float = 1e-7
    atol: float = 1e-9

    def __post_init__(self):
        def one_of(name, *allowed):
            if getattr(self, name) not in allowed:
                raise ValueError(f"{name} = {getattr(self, name)!r} is none of {allowed}")

        one_of("mechanics", "elastic", "rigid", "viscoelastic")
        one_of("balance", "conservative", "advective")
        one_of("kinematics", "line", "strip")
        if (self.mechanics == "viscoelastic") != (self.relaxation_time > 0):
            raise ValueError("a viscoelastic line, and no other, needs a relaxation_time > 0")
        if self.kinematics == "strip" and (self.mechanics == "viscoelastic" or self.imposed_stretch):
            raise ValueError("the strip is elastic or rigid, and free")
        if abs(self.length / self.spacing - round(self.length / self.spacing)) > 1e-9:
            raise ValueError("spacing must divide length")
        if self.imposed_stretch and not 0 < self.imposed_stretch[1] < self.end:
            raise ValueError("an imposed stretch must be let go between 0 and end")


@dataclass
class Result:
    """What a run leaves: the fields at the end, the probes over time, and the numbers asked of them."""

    case: Line
    X: np.ndarray  # (nodes,) material coordinates
    v: np.ndarray  # (nodes,) potential at the end
    w: np.ndarray  # (nodes,) recovery at the end
    J: np.ndarray  # (nodes,) stretch x' at the end (of the strip, F)
    times: np.ndarray  # (samples,)
    traces: np.ndarray  # (samples, probes) potential at the probes
    peaks: np.ndarray  # (samples,) largest potential on the line
    steps: int = 0
    x: np.ndarray = field(init=False)  # (nodes,) spatial coordinates at the end, x(X = 0) = 0

    def __post_init__(self):
        self.x = np.concatenate([[0.0], np.cumsum((self.J[1:] + self.J[:-1]) / 2 * np.diff(self.X))])

    @property
    def potential_max(self) -> float:
        """Of the nodes, at the end."""
        return float(self.v.max())

    @property
    def potential_min(self) -> float:
        """Of the nodes, at the end."""
        return float(self.v.min())

    @property
    def activation_times(self) -> list[float | None]:
        """First time at which v crosses 0.5 upward at each probe, linear in time between samples."""
        found = []
        for trace in self.traces.T:
            up = np.flatnonzero((trace[:-1] < 0.5) & (trace[1:] >= 0.5))
            if up.size == 0:
                found.append(None)
                continue
            i = up[0]
            part = (0.5 - trace[i]) / (trace[i + 1] - trace[i])
            found.append(float(self.times[i] + part * (self.times[i + 1] - self.times[i])))
        return found

    @property
    def celerity(self) -> float | None:
        """Material distance between the first two probes over the difference of their activation times."""
        a, b = self.activation_times[:2]
        return None if a is None or b is None else (self.case.probes[1] - self.case.probes[0]) / (b - a)

    def crossings(self, level: float = 0.5) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """(X, x) of the upstroke and the downstroke of the leading pulse at the end; None if one lacks."""
        above = self.v >= level
        front = np.flatnonzero(above[:-1] & ~above[1:])
        if front.size == 0:
            return None
        tail = np.flatnonzero(~above[: front[-1]] & above[1 : front[-1] + 1])
        if tail.size == 0:
            return None

        def at(i):
            part = (level - self.v[i]) / (self.v[i + 1] - self.v[i])
            return tuple(float(c[i] + part * (c[i + 1] - c[i])) for c in (self.X, self.x))

        return at(front[-1]), at(tail[-1])

    @property
    def width_material(self) -> float | None:
        """Distance in X between the upstroke and the downstroke crossing of v = 0.5, at the end."""
        found = self.crossings()
        return None if found is None else found[0][0] - found[1][0]

    @property
    def width_spatial(self) -> float | None:
        """The same distance in x."""
        found = self.crossings()
        return None if found is None else found[0][1] - found[1][1]


def solve(case: Line) -> Result:
    """Integrate the line to `case.end`."""
    nodes = round(case.length / case.spacing) + 1
    X = np.arange(nodes) * case.spacing
    state = np.zeros((nodes, 3 if case.mechanics == "viscoelastic" else 2))
    state[:, 0] = _initial(case, X)

    count = round(case.end / case.sample)
    if abs(count * case.sample - case.end) > 1e-9 * case.end:
        raise ValueError("sample must divide end")
    times = np.arange(count + 1) * case.sample
    traces, peaks = np.empty((count + 1, len(case.probes))), np.empty(count + 1)

    def record(k, y):
        v = y.reshape(state.shape)[:, 0]
        traces[k] = np.interp(case.probes, X, v)
        peaks[k] = v.max()

    record(0, state)
    held = case.imposed_stretch
    if held is None:
        state, steps = _integrate(case, state, None, 0.0, case.end, times, record)
    else:
        stretch, until = held
        state, steps = _integrate(case, state, stretch, 0.0, until, times, record)
        state = _release(case, state, stretch)
        state, more = _integrate(case, state, None, until, case.end, times, record)
        steps += more
    J = _stretch(case, state)[0]
    if case.kinematics == "strip":
        J = np.sqrt(1 - case.beta * state[:, 0]) if case.mechanics == "elastic" else J
    return Result(case, X, state[:, 0], state[:, 1], J, times, traces, peaks, steps)


def _initial(case, X):
    """The potential at t = 0: the bump by its values (X = radius belongs to it) or by its averages."""
    if case.initial is not None:
        return case.initial(X)
    if case.averaged:
        left, right = np.maximum(X - case.spacing / 2, 0.0), X + case.spacing / 2
        return case.potential * np.clip((case.radius - left) / (right - left), 0.0, 1.0)
    return np.where(case.radius + 1e-9 * case.spacing >= X, case.potential, 0.0)


def _stretch(case, state, held=None):
    """J and its derivatives with respect to v and e."""
    v = state[:, 0]
    one, nil = np.ones_like(v), np.zeros_like(v)
    if held is not None:
        return held * one, nil, nil
    if case.mechanics == "rigid" or case.kinematics == "strip":
        return one, nil, nil
    if case.mechanics == "elastic":
        return 1 - case.beta * v, -case.beta * one, nil
    e = state[:, 2]
    return 1 + e * (1 - case.beta * v), -case.beta * e, 1 - case.beta * v


def _release(case, state, stretch):
    """The state just after an imposed stretch is let go."""
    state = state.copy()
    v, w = state[:, 0].copy(), state[:, 1].copy()
    if case.mechanics == "viscoelastic":  # the dashpot keeps x' for the moment
        state[:, 2] = (stretch - 1) / (1 - case.beta * v)
        return state
    if case.balance == "conservative":
        if case.mechanics == "elastic":  # (1 - beta v) v = J v before
            if np.any(4 * case.beta * stretch * v > 1):
                raise RuntimeError("the released state does not exist: J v exceeds 1 / (4 beta)")
            state[:, 0] = 2 * stretch * v / (1 + np.sqrt(1 - 4 * case.beta * stretch * v))
            state[:, 1] = stretch * w / (1 - case.beta * state[:, 0])
        else:
            state[:, 0], state[:, 1] = stretch * v, stretch * w
    return state


def _rates(case, shape, held):
    """The right-hand side of dy/dt = rates(t, y), y the unknowns node by node."""
    conservative = case.balance == "conservative"
    volume = np.full(shape[0], case.spacing)
    volume[[0, -1]] /= 2
    alpha, beta, A, D, tau = case.alpha, case.beta, case.A, case.diffusivity, case.tau
    flux = np.zeros(shape[0] + 1)

    def rates(_, y):
        state = y.reshape(shape)
        v, w = state[:, 0], state[:, 1]
        J, J_v, J_e = _stretch(case, state, held)
        contracting_strip = case.kinematics == "strip" and case.mechanics == "elastic"
        resistance = 1 - beta * v if contracting_strip else J  # F^2 / J
        flux[1:-1] = 2 * D * np.diff(v) / (case.spacing * (resistance[1:] + resistance[:-1]))
        supply = np.diff(flux) / volume - A * J * (v * (v - alpha) * (v - 1) + w)

        rate = np.empty(shape)
        J_t = 0.0
        if shape[1] == 3:
            strain = state[:, 2]
            rate[:, 2] = -(strain + beta * v / (1 - beta * v)) / case.relaxation_time
            J_t = J_e * rate[:, 2]
        if conservative:
            rate[:, 0] = (supply - v * J_t) / (J + v * J_v)
            J_t = J_t + J_v * rate[:, 0]
            rate[:, 1] = v - w / tau - w * J_t / J
        else:
            rate[:, 0] = supply / J
            rate[:, 1] = v - w / tau
        if not case.recovery:
            rate[:, 1] = 0.0
        return rate.ravel()

    return rates


def _integrate(case, state, held, start, end, times, record):
    """From start to end, recording at the sample times in (start, end]; the final state, the steps taken."""
    shape = state.shape
    band = 2 * shape[1] - 1
    solver = LSODA(
        _rates(case, shape, held), start, state.ravel(), end,
        rtol=case.rtol, atol=case.atol, first_step=1e-7, lband=band, uband=band,
    )  # fmt: skip
    k = int(np.searchsorted(times, start * (1 + 1e-12), side="right"))
    steps = 0
    while solver.status == "running":
        message = solver.step()
        if solver.status == "failed":
            raise RuntimeError(f"the reference line failed at t = {solver.t}: {message}")
        steps += 1
        v = solver.y.reshape(shape)[:, 0]
        if case.mechanics == "elastic" and case.balance == "conservative" and 2 * case.beta * v.max() >= 1:
            raise RuntimeError(f"2 beta v >= 1 at t = {solver.t}: the conservative line is ill-posed there")
        if k < times.size and times[k] <= solver.t:
            interpolant = solver.dense_output()
            while k < times.size and times[k] <= solver.t:
                record(k, interpolant(times[k]))
                k += 1
    return solver.y.reshape(shape).copy(), steps


def startup_threshold(case: Line, low: float = 0.2, high: float = 0.8, tolerance: float = 1e-3) -> float:
    """The least bump potential from which a pulse starts: v > 0.5 somewhere at the end; by bisection.

    NaN where no potential tried below `high` starts one.
    """
    top = high
    while high - low > tolerance:
        middle = (low + high) / 2
        if solve(replace(case, potential=middle)).potential_max > 0.5:
            high = middle
        else:
            low = middle
    return (low + high) / 2 if high < top else float("nan")


STARTUP = Line(length=60.0, end=0.3, potential=0.6, radius=1.0, probes=())
"""Figure 2, coupled; with imposed_stretch = (1.0, 0.01) its second half."""


def main() -> None:
    import time

    begin = time.perf_counter()
    rows = {
        "rigid": Line(mechanics="rigid"),
        "conservative, elastic": Line(),
        "advective, elastic": Line(balance="advective"),
        "strip (7.2), plane strain": Line(kinematics="strip"),
    }
    for part in (0.02, 0.1, 0.25, 0.4, 0.45, 0.5, 0.75, 1.0, 2.0, 5.0, 20.0):
        case = Line(mechanics="viscoelastic", relaxation_time=part * 0.2)
        rows[f"viscoelastic, lambda = {part} tau"] = case
    for spacing in (1.0, 0.25):
        print(f"\nspacing {spacing}: celerity, ratio, width X, ratio, width x, ratio, v max, v min")
        base = None
        for name, case in rows.items():
            r = solve(replace(case, spacing=spacing))
            base = base or r
            numbers = ("celerity", "width_material", "width_spatial")
            row = "".join(f"{getattr(r, k):8.3f} {getattr(r, k) / getattr(base, k):6.3f}" for k in numbers)
            print(f"{name:34}{row} {r.potential_max:8.4f} {r.potential_min:8.4f}")
    print("\nfigure 2: largest v at t = 0.3, coupled and held until 0.01; then the bump potentials that")
    print("fire, half-width 1 coupled, held, half-width 2 coupled, held: bump by nodes, and averaged")
    for spacing in (1.0, 0.5, 0.25, 0.125):
        coupled = replace(STARTUP, spacing=spacing, sample=0.01, rtol=1e-6, atol=1e-8)
        held = replace(coupled, imposed_stretch=(1.0, 0.01))
        line = [f"{solve(case).potential_max:7.4f}" for case in (coupled, held)]
        for averaged in (False, True):
            for radius in (1.0, 2.0):
                bump = dict(radius=radius, averaged=averaged)
                line.append(f"{startup_threshold(replace(coupled, **bump), high=1.5):.3f}")
                line.append(f"{startup_threshold(replace(held, **bump), high=0.8):.3f}")
        print(f"spacing {spacing}:", *line)
    print(f"\n{time.perf_counter() - begin:.1f} s")


if __name__ == "__main__":
    main()
