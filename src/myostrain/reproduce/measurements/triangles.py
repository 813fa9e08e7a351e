"""What is measured on nodal values, on triangles and over time: plain functions of arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from myostrain.output.metrics import LEVEL
from myostrain.reproduce.jobs import Array
from myostrain.reproduce.measurements.signals import first_rise

import numpy as np
import numpy.typing as npt

Indices = npt.NDArray[np.integer[Any]]
Flags = npt.NDArray[np.bool_]

#: Fronts are judged at least so far from the middle of the bump, where they have forgotten it.
STARTED = 30.0

#: And so far from the boundary, which fronts reach head-on and too fast: twice a front's thickness.
INSIDE = 15.0


def pulse(times: Array, v: Array) -> dict[str, float | None]:
    """What a pulse does at one place.

    Args:
        times: Times (n,).
        v: Potential there (n,).

    Returns:
        ``activation``: when it first rises through 0.5; ``duration``: until it falls through 0.5;
        ``maximum``, ``minimum``, and ``rest``: the time after its fall that was seen. None where it has not
        happened; crossings are linear in time.
    """
    up = first_rise(times, v, LEVEL)
    after = times >= (np.inf if up is None else up)
    down = first_rise(times[after], -v[after], -LEVEL)
    whole = up is not None and down is not None
    return {
        "activation": up,
        "duration": down - up if up is not None and down is not None else None,
        "maximum": float(v.max()) if whole else None,
        "minimum": float(v.min()) if whole else None,
        "rest": float(times[-1]) - down if down is not None else None,
    }


def growth(times: Array, area: Array) -> dict[str, float | None]:
    """From when an area (n,) grows for good, ``grows``, and when it is twice the first, ``doubled``."""
    large = np.flatnonzero(area >= 2 * area[0])
    if not len(large):
        return {"grows": None, "doubled": None}
    shrinks = np.flatnonzero(np.diff(area[: large[0] + 1]) < 0)
    return {
        "grows": float(times[shrinks[-1] + 1]) if len(shrinks) else float(times[0]),
        "doubled": first_rise(times, area, 2 * area[0]),
    }


def celerities(X: Array, cells: Indices, T: Array, fibre: Array, picked: Flags) -> dict[str, Any]:
    """Celerities along and across the fibres, fitted to activation times.

    A plane front in direction n under D = diag(along, across) travels at the root of n·D n, up to a factor,
    so that g = Grad T satisfies a g_f² + b g_s² = 1 with the squared celerities a and b.

    Args:
        X: Nodes (n, 2).
        cells: Node numbers (m, 3).
        T: Activation times (n,), NaN for never.
        fibre: Unit fibre direction (2,).
        picked: Triangles (m,) to fit, but for those that no front has crossed.

    Returns:
        ``along`` and ``across``: celerities; ``scatter``: root mean square of a g_f² + b g_s² − 1;
        ``triangles``: how many were fitted; the others are None where there are fewer than ten.
    """
    picked = picked & ~np.isnan(T[cells]).any(axis=1)
    if (count := int(picked.sum())) < 10:
        return {"along": None, "across": None, "scatter": None, "triangles": count}
    g, area = gradients(X, cells[picked], T), areas(X, cells[picked])
    squares = np.column_stack([g @ fibre, g @ cross_fibre(fibre)]) ** 2
    root = np.sqrt(area)
    ab, *_ = np.linalg.lstsq(squares * root[:, None], root, rcond=None)
    along, across = np.sqrt(np.where(ab > 0, ab, np.nan)).tolist()
    scatter = float(np.sqrt(np.average((squares @ ab - 1) ** 2, weights=area)))
    return {"along": along, "across": across, "scatter": scatter, "triangles": count}


def settled(X: Array, cells: Indices, bump: Array, rim: Indices) -> Flags:
    """Which triangles (m,) are far enough from the bump's middle (2,) and nodes ``rim`` of the boundary."""
    middles = X[cells].mean(axis=1)
    squares = (middles**2).sum(axis=1)[:, None] - 2 * middles @ X[rim].T + (X[rim] ** 2).sum(axis=1)
    far = np.linalg.norm(middles - bump, axis=1) > STARTED
    return np.asarray(far & (squares.min(axis=1) > INSIDE**2))


def stretches(X: Array, cells: Indices, u: Array, v: Array, fibre: Array) -> dict[str, float | None]:
    """Mean stretches where v > 0.5: ``fibre`` |F n|, ``cross`` |F s| in the plane, ``area`` det F₂.

    Args:
        X: Nodes (n, 2).
        cells: Node numbers (m, 3).
        u: Displacement (n, 2).
        v: Potential (n,).
        fibre: Unit fibre direction (2,).
    """
    F = np.eye(2) + gradients(X, cells, u)
    inside = v[cells].mean(axis=1) > LEVEL
    if not inside.any():
        return {"fibre": None, "cross": None, "area": None}
    weights = areas(X, cells)[inside]
    measured = {
        "fibre": np.linalg.norm(F @ fibre, axis=1),
        "cross": np.linalg.norm(F @ cross_fibre(fibre), axis=1),
        "area": np.linalg.det(F),
    }
    return {k: float(np.average(value[inside], weights=weights)) for k, value in measured.items()}


def relevance(X: Array, cells: Indices, u: Array, v: Array) -> dict[str, dict[str, float | None]]:
    """How much of displacement and strain is where the pulse is not small, by the threshold |v|.

    Args:
        X: Nodes (n, 2).
        cells: Node numbers (m, 3).
        u: Displacement (n, 2).
        v: Potential (n,).

    Returns:
        By threshold, ``twentieth``, ``tenth`` and ``fifth`` of one: ``area``: share of the body where |v| is
        larger; ``displacement`` and ``strain``: mean |u| and mean |E| (Green and Lagrange's, in the plane)
        elsewhere, relative to that inside; ``..._share``: share of ∫ |u|² dX and ∫ |E|² dX that is inside;
        None where there is no inside.
    """
    weights, at = areas(X, cells), v[cells].mean(axis=1)
    sizes = {
        "displacement": np.linalg.norm(u[cells].mean(axis=1), axis=1),
        "strain": np.linalg.norm(strains(np.eye(2) + gradients(X, cells, u)), axis=(1, 2)),
    }
    found: dict[str, dict[str, float | None]] = {}
    for word, threshold in (("twentieth", 0.05), ("tenth", 0.1), ("fifth", 0.2)):
        inside = np.abs(at) > threshold
        numbers: dict[str, float | None] = {"area": float(weights[inside].sum() / weights.sum())}
        for name, size in sizes.items():
            energy = float(weights @ size**2)
            if not energy > 0 or not inside.any() or inside.all():
                numbers |= {name: None, f"{name}_share": None}
                continue
            within = np.average(size[inside], weights=weights[inside])
            numbers[name] = float(np.average(size[~inside], weights=weights[~inside]) / within)
            numbers[f"{name}_share"] = float(weights[inside] @ size[inside] ** 2 / energy)
        found[word] = numbers
    return found


def area_above(X: Array, cells: Indices, v: Array, level: float = LEVEL) -> float:
    """Area where a piecewise linear v (n,) is above a level."""
    low, middle, high = np.sort(v[cells], axis=1).T
    # Of the triangle's corners one side is cut off; products of differences of flat data may vanish.
    tiny = np.finfo(float).tiny
    cut_low = (level - low) ** 2 / np.maximum((middle - low) * (high - low), tiny)
    cut_high = (high - level) ** 2 / np.maximum((high - middle) * (high - low), tiny)
    share = np.where(level <= middle, 1 - cut_low, cut_high)
    share = np.where(level <= low, 1.0, np.where(level >= high, 0.0, share))
    return float(areas(X, cells) @ share)


def areas(X: Array, cells: Indices) -> Array:
    """Areas (m,) of triangles."""
    a, b = X[cells[:, 1]] - X[cells[:, 0]], X[cells[:, 2]] - X[cells[:, 0]]
    return np.asarray(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2)


def gradients(X: Array, cells: Indices, values: Array) -> Array:
    """Gradients of nodal values (n,) or (n, 2) on triangles: (m, 2) or (m, 2, 2), derivatives last."""
    edges = X[cells[:, 1:]] - X[cells[:, :1]]
    rises = (values[cells[:, 1:]] - values[cells[:, :1]]).reshape(len(cells), 2, values[0].size)
    found = np.linalg.solve(edges, rises).transpose(0, 2, 1)
    return found[:, 0] if values.ndim == 1 else found


def strains(F: Array) -> Array:
    """Green and Lagrange's strain (m, 2, 2) in the plane, E = (FᵀF − 1)/2."""
    return np.asarray((F.transpose(0, 2, 1) @ F - np.eye(2)) / 2)


def quantiles(values: Array, weights: Array, shares: Sequence[float]) -> list[float]:
    """Values below which these shares of the weight are."""
    order = np.argsort(values)
    below = np.cumsum(weights[order]) - weights[order] / 2
    return np.interp(np.asarray(shares) * weights.sum(), below, values[order]).tolist()


def cross_fibre(fibre: Array) -> Array:
    """The unit vector (2,) across the fibre in the plane."""
    return np.array([-fibre[1], fibre[0]])
