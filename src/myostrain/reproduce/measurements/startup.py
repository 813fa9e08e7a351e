"""Which bumps start a pulse, and what a contraction does to a potential."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from itertools import permutations
from typing import Any

import myostrain as ms
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements.cases import resolved
from myostrain.theory import startup

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

#: D = A, α and β of the paper's figures.
RATE, ALPHA, BETA = 100.0, 0.1, 0.3

#: A bump fires if the potential exceeds this somewhere at the end.
FIRED = 0.5
#: A potential nowhere above this part of the threshold α cannot recover: the reaction only takes from it.
LOST = 0.5


def threshold(
    case: Mapping[str, Any],
    shape: str,
    low: float,
    high: float,
    tolerance: float,
    guess: float | None = None,
) -> Found:
    """The least height of a bump that fires, by bisection: a taller one is taken to fire, too.

    Args:
        case: Resolved parameters of a case on a line; its bump is the one of shape "step".
        shape: "step", or "gaussian": v = a exp(−(X/radius)²) with the bump's radius.
        low: A height that does not fire.
        high: The largest height to be tried.
        tolerance: Width of the last interval.
        guess: About where it is, which saves runs and does not change the outcome.

    Returns:
        Numbers: ``threshold``, the middle of the last interval, None where ``high`` does not fire.

    Raises:
        ValueError: ``low`` fires.
    """
    made = ms.Case.from_dict(case)
    model = made.build()

    def fires(height: float) -> bool:
        return _fires(made, model, _bump(made, model, shape, height))

    return Found({"threshold": bisect(fires, low, high, tolerance, guess)})


def least_stretch(case: Mapping[str, Any], low: float, high: float, tolerance: float) -> Found:
    """The least imposed stretch at which a case's bump fires, by bisection.

    Args:
        case: Resolved parameters of a case on a line with an imposed stretch.
        low: A stretch at which it does not fire.
        high: The largest stretch to be tried.
        tolerance: Width of the last interval.

    Returns:
        Numbers: ``stretch``, None where ``high`` does not fire.
    """

    def fires(value: float) -> bool:
        mechanics = {**case["mechanics"], "imposed_stretch": {**case["mechanics"]["imposed_stretch"]}}
        mechanics["imposed_stretch"]["value"] = value
        made = ms.Case.from_dict({**case, "mechanics": mechanics})
        model = made.build()
        return _fires(made, model, model.potential.v.x.array.copy())

    return Found({"stretch": bisect(fires, low, high, tolerance)})


def satisfied(shape: str, spacing: float, sampling: str, widths: Sequence[float], contracted: bool) -> Found:
    """The heights for which a bump on a line satisfies (5.2), by exact integrals on the mesh.

    Args:
        shape: "step" or "gaussian".
        spacing: Size of the cells.
        sampling: Of the step: "nodal" or "mean".
        widths: Half-widths (multiples of ``spacing`` for a step), or the Gaussian's.
        contracted: Whether F = 1 − β v, the line that is free at t = 0, in place of F = 1.

    Returns:
        Numbers, a list by widths each: ``from`` and ``to``, the ends of the interval of heights up to 1, None
        where there is none; ``square``: ∫ v² dX over the whole line for the height 1.
    """
    heights = np.linspace(0.005, 1.0, 201)
    numbers: dict[str, Any] = {"from": [], "to": [], "square": []}
    for width in widths:
        X, cells, v = line_bump(shape, spacing, sampling, width)
        # Over a² it is a polynomial of degree two in a, unless the loss depends on a by F.
        tried = heights if contracted else heights[:: len(heights) // 2]
        surplus = np.array([_surplus(X, cells, a * v, contracted) / a**2 for a in tried])
        if not contracted:
            surplus = np.polynomial.Polynomial.fit(tried, surplus, 2)(heights)
        ends = _positive_interval(heights, surplus)
        numbers["from"].append(ends and ends[0])
        numbers["to"].append(ends and ends[1])
        left, right = v[:-1], v[1:]
        numbers["square"].append(float(2 * spacing / 3 * np.sum(left**2 + left * right + right**2)))
    return Found(numbers)


def sides(spacings: Sequence[float], height: float, width: float) -> Found:
    """Both sides of (5.2) for a step on lines of several cell sizes, nodal sampling, over the whole line.

    Returns:
        Numbers, a list by ``spacings`` each: ``gain``, ``held`` (loss for F = 1), ``coupled`` (loss for
        F = 1 − β v), ``stretch``: the x′ that (5.4) asks for.
    """
    numbers: dict[str, Any] = {"gain": [], "held": [], "coupled": [], "stretch": []}
    for spacing in spacings:
        X, cells, v = line_bump("step", spacing, "nodal", width)
        v = height * v
        numbers["gain"].append(2 * startup.reaction_power(X, cells, v, alpha=ALPHA, A=RATE))
        numbers["held"].append(2 * startup.diffusion_loss(X, cells, v, diffusivity=RATE))
        F = _contraction(cells, v)
        numbers["coupled"].append(2 * startup.diffusion_loss(X, cells, v, F=F, diffusivity=RATE))
        least = startup.sufficient_stretch(X, cells, v, alpha=ALPHA, A=RATE, diffusivity=RATE)
        numbers["stretch"].append(float(np.sqrt(least)))
    return Found(numbers)


def isochoric(cells: int, largest: float, steps: int) -> Found:
    """How far a homogeneous isochoric strain can lower what diffusion takes from a bump in three dimensions.

    Args:
        cells: Cells along each side of the cube, six tetrahedra each.
        largest: Largest principal stretch in the sheet, its inverse the least.
        steps: Stretches tried along each axis.

    Returns:
        Numbers: ``ball``, ``column``, ``layer``: the least ∫ |F⁻ᵀ Grad v|² over that of F = 1 for
        a Gaussian of three, two or one coordinates; ``eigenvalue``, the largest λ_min(C).
    """
    X, tetrahedra = _cube(cells)
    stretches = np.geomspace(1 / largest, largest, steps)
    pairs = [(a, b) for a in stretches for b in stretches]
    largest_least = max(min(a, b, 1 / (a * b)) ** 2 for a, b in pairs)
    numbers: dict[str, Any] = {"eigenvalue": float(largest_least)}
    for name, axes in (("ball", 3), ("column", 2), ("layer", 1)):
        v = np.exp(-((X[:, :axes] / 0.4) ** 2).sum(axis=1))
        rest = startup.diffusion_loss(X, tetrahedra, v)
        losses = [startup.diffusion_loss(X, tetrahedra, v, F=np.diag([a, b, 1 / (a * b)])) for a, b in pairs]
        numbers[name] = min(losses) / rest
    return Found(numbers)


def line_bump(shape: str, spacing: float, sampling: str, width: float) -> tuple[Array, Array, Array]:
    """Nodes (n, 1) of half a line, its cells (n − 1, 2) and a bump of height 1 on it (n,)."""
    length = 60.0 + width
    X = np.linspace(0.0, length, round(length / spacing) + 1)
    if shape == "gaussian":
        v = np.exp(-((X / width) ** 2))
    else:
        v = np.where(width * (1 + 1e-12) >= X, 1.0, 0.0)
        if sampling == "mean":  # half of what surrounds the node on the edge lies in the bump
            v[round(width / spacing)] = 0.5
    nodes = np.arange(len(X))
    return X[:, None], np.stack([nodes[:-1], nodes[1:]], axis=1), v


def _contraction(cells: Array, v: Array) -> Array:
    """F = 1 + γ (4.3) at the centres of the cells."""
    return (1 - BETA * v[cells].mean(axis=1))[:, None, None]


def _surplus(X: Array, cells: Array, v: Array, contracted: bool) -> float:
    """Left side of (5.2) less the right one."""
    F = _contraction(cells, v) if contracted else None
    gain = startup.reaction_power(X, cells, v, alpha=ALPHA, A=RATE)
    return gain - startup.diffusion_loss(X, cells, v, F=F, diffusivity=RATE)


def _positive_interval(x: Array, y: Array) -> tuple[float, float] | None:
    """Ends of the interval in which y, concave in x, is positive; linear between the points."""
    inside = np.flatnonzero(y > 0)
    if not len(inside):
        return None
    first, last = inside[0], inside[-1]
    low, high = x[first], x[last]
    if first:
        low = np.interp(0.0, y[[first - 1, first]], x[[first - 1, first]])
    if last < len(x) - 1:
        high = np.interp(0.0, y[[last + 1, last]], x[[last + 1, last]])
    return float(low), float(high)


def _cube(n: int) -> tuple[Array, Array]:
    """The cube [−1, 1]³ in 6 n³ tetrahedra: nodes and cells."""
    axis = np.linspace(-1.0, 1.0, n + 1)
    X = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    step = np.array([(n + 1) ** 2, n + 1, 1])
    corners = (np.indices((n, n, n)).reshape(3, -1).T * step).sum(axis=1)
    paths = [np.cumsum([0, *step[list(order)]]) for order in permutations(range(3))]
    return X, np.concatenate([corners[:, None] + path for path in paths])


def bisect(
    fires: Callable[[float], bool], low: float, high: float, tolerance: float, guess: float | None = None
) -> float | None:
    """The value at which ``fires`` turns true, None if it is false at ``high``.

    With a guess, intervals of the bisection that are wider than four tolerances are passed over if the one
    about the guess holds the value.

    Raises:
        ValueError: It is true at ``low``.
    """
    near = (low, high)
    while guess is not None and near[1] - near[0] > 4 * tolerance:
        near = _half(near, guess < sum(near) / 2)
    if near != (low, high) and fires(near[1]) and not fires(near[0]):
        low, high = near
    else:
        if not fires(high):
            return None
        if fires(low):
            raise ValueError(f"{low} fires: the bisection must begin below the threshold")
    while high - low > tolerance:
        low, high = _half((low, high), fires((low + high) / 2))
    return (low + high) / 2


def _half(interval: tuple[float, float], lower: bool) -> tuple[float, float]:
    low, high = interval
    middle = (low + high) / 2
    return (low, middle) if lower else (middle, high)


def _bump(case: ms.Case, model: ms.Electromechanics, shape: str, height: float) -> np.ndarray:
    """Nodal values of the bump."""
    (initial,), space = case.initial, model.potential.v.function_space
    if shape == "gaussian":
        X = space.tabulate_dof_coordinates()[:, 0]
        return np.asarray(height * np.exp(-((X / initial.where.radius) ** 2)))
    return np.asarray(height * initial.where.share(model.potential.body, space, "initial"))


def _fires(case: ms.Case, model: ms.Electromechanics, v: np.ndarray) -> bool:
    potential = model.potential.v.x.array
    potential[:] = v
    model.start()
    for number in range(1, round(case.time.end / case.time.step) + 1):
        model.step(number * case.time.step)
        if potential.max() < LOST * case.cell.alpha:
            return False
    return bool(potential.max() > FIRED)


def driven(
    body: str, potential: float, recovery: bool, drive: Mapping[str, Any], end: float, step: float
) -> Found:
    """A homogeneous potential on a small body that is contracted, or held and then let go.

    Args:
        body: "line" (J = x′) or "sheet" (plane stress, J = 1).
        potential: The potential at first.
        recovery: Whether w exists.
        drive: {"strain": γ, "until": t}: an active strain, whatever the potential, that grows linearly from
            zero until then and stays; or {"stretch": [...], "until": t}: γ = −0.3 v, the body held at
            this homogeneous stretch until then; or neither: the rigid body.
        end: Simulated time at which to end.
        step: Time step.

    Returns:
        Numbers: ``before`` and ``after``, the potential at the first node one step before and right after
        ``until`` (contraction: at the start and at ``until``); ``largest``, the largest |v| anywhere at any
        time; ``last``, the largest v at the end; ``stretch``, of the first axis, the fibre, at the end.
    """
    model, strain = _driven_model(body, potential, recovery, drive)
    v = model.potential.v.x.array
    until = drive.get("until", 0.0)
    model.start()
    before = after = float(v[0])
    largest = float(np.abs(v).max())
    for number in range(1, round(end / step) + 1):
        time = number * step
        if strain is not None:
            strain.strain = drive["strain"] * min(time / until, 1.0)
        if "stretch" in drive and time <= until * (1 + 1e-9):
            before = float(v[0])
        model.step(time)
        if time <= until * (1 + 1e-9):
            after = float(v[0])
        largest = max(largest, float(np.abs(v).max()))
    return Found(
        {
            "before": before,
            "after": after,
            "largest": largest,
            "last": float(v.max()),
            "stretch": _fibre_stretch(model),
        }
    )


class _Contraction:
    """An active strain that does not depend on the potential."""

    drivers = ("potential",)
    strain = 0.0

    def activation(self, states: Any, drivers: Any) -> Any:
        return self.strain


#: Small free bodies, solved to round-off.
BODIES = {
    "line": ("startup-1d", "geometry.length=10.0", "initial.radius=10.0", "probes={a=[5.0]}"),
    "sheet": ("sheet-2d", 'geometry={kind="rectangle", size=[6.0, 6.0], spacing=1.0}',
              "fibres.direction=[1.0, 0.0]", "probes={a=[3.0, 3.0]}", 'potential.mass="lumped"',
              "mechanics.robin=0.0", "mechanics.every=1",
              "initial={potential=0.0, center=[3.0, 3.0], radius=10.0}"),
}  # fmt: skip
EXACT = ("mechanics.tolerance=1e-12", "solver.potential={ksp_rtol=1e-13}", "time.scheme=second-order")


def _driven_model(
    body: str, potential: float, recovery: bool, drive: Mapping[str, Any]
) -> tuple[ms.Electromechanics, _Contraction | None]:
    name, *settings = BODIES[body]
    settings += [*EXACT, f"initial.potential={potential}", f"cell.recovery={str(recovery).lower()}"]
    if "strain" not in drive:
        value, until = drive.get("stretch", 1.0), drive.get("until", "inf")
        settings.append(f"mechanics.imposed_stretch={{value={value}, until={until}}}")
    case = ms.Case.from_dict(resolved(name, settings))
    strain = _Contraction() if "strain" in drive else None
    return (case if strain is None else dataclasses.replace(case, law=strain)).build(), strain


def _fibre_stretch(model: ms.Electromechanics) -> float:
    """|F e₁| of the homogeneous deformation, which a support may have turned."""
    assert model.mechanics is not None
    dim = model.potential.body.dim
    X = model.potential.v.function_space.tabulate_dof_coordinates()[:, :dim]
    x = X + model.mechanics.displacement().x.array.reshape(-1, dim)
    affine = np.linalg.lstsq(np.column_stack([X, np.ones(len(X))]), x, rcond=None)[0]
    return float(np.linalg.norm(affine[0]))
