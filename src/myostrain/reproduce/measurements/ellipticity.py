"""Where active points lose strong ellipticity: the acoustic tensor over activation and deformation."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from myostrain.activation import Rossi2014
from myostrain.activation.force_length import force_length
from myostrain.materials import NeoHookean
from myostrain.mechanics.ellipticity import half_sphere, least_eigenvalues
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements.points import (
    Array,
    Points,
    active_tensors,
    free_stretches,
    isochoric,
    material,
    tension_for,
)
from myostrain.theory import critical_slope, least_with_tension

import numpy as np

#: How often the border is halved, from the spacing of the grid.
HALVINGS = 12

TENSION = "tension"

#: Points at a time of the search over directions.
AT_ONCE = 2000

#: Active strains at which the isometric body is looked at.
ISOMETRIC = np.linspace(0.0, -0.5, 101)

#: Directions in which the ordinary ellipticity is looked at.
DIRECTIONS = 400

#: Step of differences in γ and λ.
STEP = 1e-5


def plane(stretch: Any) -> Array:
    """F (..., 3, 3) of stretches (...) along the fibre that the sheet direction makes up for."""
    lam = np.asarray(stretch, dtype=float)
    return np.stack([lam, 1 / lam, np.ones_like(lam)], axis=-1)[..., None] * np.eye(3)


def shear(amount: Any) -> Array:
    """F (..., 3, 3) of simple shears (...) along the fibre, in the plane with the sheet direction."""
    k = np.asarray(amount, dtype=float)
    F = np.zeros((*k.shape, 3, 3))
    F[...] = np.eye(3)
    F[..., 0, 1] = k
    return F


#: Families of deformations that keep the volume, by name.
FAMILIES: dict[str, Callable[[Any], Array]] = {"uniaxial": isochoric, "plane": plane, "shear": shear}


def least(
    points: Points, F: Array, Fo: Any = None, tension: Any = 0.0, *, all_amplitudes: bool = False
) -> Any:
    """The least eigenvalue (n,) of the acoustic tensor over the modulus, and its direction m (n, 3)."""
    points.put(F, Fo, tension)
    G = None if all_amplitudes else np.linalg.inv(F).swapaxes(-1, -2)
    return _sought(points.moduli() / points.modulus, G)


def _sought(A: Array, G: Array | None) -> tuple[Array, Array]:
    """The least eigenvalues and their directions, so many points at a time that the memory is moderate."""
    parts = [slice(i, i + AT_ONCE) for i in range(0, len(A), AT_ONCE)]
    found = [least_eigenvalues(A[part], None if G is None else G[part]) for part in parts]
    values, directions = (np.concatenate(each) for each in zip(*found, strict=True))
    return values, directions


def examined(
    law: Mapping[str, Any],
    deformations: Mapping[str, Mapping[str, Any]],
    gammas: Sequence[float],
    grids: Mapping[str, Sequence[float]],
    seed: int,
    samples: int,
    bulk_modulus: float | None = None,
) -> Found:
    """The least eigenvalue of a law over γ, or a tension, and stretch or shear, and where it is zero.

    The tension is the one that shortens free passive points as much as γ along the fibre alone,
    Fo = 1 + γ f⊗f, does.

    Args:
        law: ``model``, a name of :mod:`myostrain.materials`, and its parameters.
        deformations: Active deformations, "kind" a name of :mod:`myostrain.activation`, by name.
        gammas: Active strains.
        grids: Stretches or shears by a name of :data:`FAMILIES`, ascending, of one length.
        seed: See :func:`identities`.
        samples: See :func:`identities`.
        bulk_modulus: κ of a nearly incompressible body over the modulus; None for an incompressible one.

    Returns:
        Numbers: see :func:`identities`, and ``isometric``, :func:`isometric_border` by deformation.
        Arrays: ``gamma``, ``tension`` over the modulus, ``free`` the stretch
        of free points; for each approach (a name of ``deformations``, or "tension") and family, under
        "approach family": ``least`` (γ, stretch) over the modulus, and ``below``, ``above``: the stretches
        nearest to the free one at which it is zero, NaN where there is none.
    """
    passive, gamma = material(law), np.asarray(gammas, dtype=float)
    tables = {name: np.asarray(values, dtype=float) for name, values in grids.items()}
    rows = [(approach, family) for approach in [*deformations, TENSION] for family in tables]
    size = len(next(iter(tables.values())))
    kappa = None if bulk_modulus is None else bulk_modulus * passive.modulus
    points = incompressible = Points(passive, max(len(rows) * len(gamma) * size, samples, len(ISOMETRIC)))
    if kappa is not None:
        points = Points(passive, len(rows) * len(gamma) * size, kappa)
    free = free_stretches(incompressible, active_tensors({"kind": "Fibre"}, gamma))[:, 0]
    tension = tension_for(incompressible, free)
    one = np.broadcast_to(np.eye(3), (len(gamma), 3, 3))
    tensors = {name: active_tensors(kind, gamma) for name, kind in deformations.items()}
    Fo = np.stack([tensors.get(approach, one) for approach, _ in rows])  # (rows, γ, 3, 3)
    T = np.stack([tension * (approach == TENSION) for approach, _ in rows])
    starts = np.stack([free * (family != "shear") for _, family in rows])

    def at(x: Array) -> Array:
        """The least eigenvalues for stretches or shears (rows, γ, n)."""
        F = np.stack([FAMILIES[family](part) for (_, family), part in zip(rows, x, strict=True)])
        each = (np.repeat(part[:, :, None], x.shape[2], axis=2) for part in (Fo, T))
        flat = [F.reshape(-1, 3, 3)] + [part.reshape(-1, *part.shape[3:]) for part in each]
        return np.asarray(least(points, *flat, all_amplitudes=kappa is not None)[0]).reshape(x.shape)

    shape = (len(rows), len(gamma), size)
    grid = np.broadcast_to(np.stack([tables[family] for _, family in rows])[:, None], shape)
    found = at(grid)
    arrays = {"gamma": gamma, "free": free, "tension": tension / passive.modulus}
    sides = _borders(grid, found, starts, at)
    for (approach, family), *parts in zip(rows, found, *sides, strict=True):
        for name, part in zip(("least", "below", "above"), parts, strict=True):
            arrays[f"{approach} {family} {name}"] = part
    numbers: dict[str, Any] = identities(incompressible, deformations, seed, samples)
    numbers["isometric"] = {
        name: isometric_border(points, kind, all_amplitudes=kappa is not None)
        for name, kind in deformations.items()
    }
    return Found(numbers | {"modulus": passive.modulus}, arrays)


def _borders(grid: Array, table: Array, start: Array, at: Callable[[Array], Array]) -> tuple[Array, Array]:
    """Where a table (..., n) over a grid first turns negative from ``start`` (...) down and up, halved."""
    outward = np.array([-1, 1])[:, None, None]
    away = outward[..., None] * (grid - start[..., None])  # (2, ..., n)
    nearest = np.where((table <= 0) & (away > 0), away, np.inf).min(axis=-1)
    lost = np.isfinite(nearest)
    before = np.where((away > 0) & (away < nearest[..., None]), away, 0.0).max(axis=-1)
    good, bad = before, np.where(lost, nearest, before)
    for _ in range(HALVINGS):
        middle = (good + bad) / 2
        negative = np.moveaxis(at(np.moveaxis(start + outward * middle, 0, -1)), -1, 0) <= 0
        bad, good = np.where(negative, middle, bad), np.where(negative, good, middle)
    below, above = np.where(lost, start + outward * (good + bad) / 2, np.nan)
    return below, above


def isometric_border(points: Points, deformation: Mapping[str, Any], *, all_amplitudes: bool) -> float | None:
    """The γ at which a body that is held at F = 1 is not elliptic any more; None down to −0.5."""
    Fo = active_tensors(deformation, ISOMETRIC)
    F = np.broadcast_to(np.eye(3), Fo.shape)
    values, _ = least(points, F, Fo, all_amplitudes=all_amplitudes)
    lost = np.flatnonzero(values <= 0)
    if not len(lost) or lost[0] == 0:
        return 0.0 if len(lost) else None
    near = slice(lost[0] - 1, lost[0] + 1)
    return float(np.interp(0.0, values[near][::-1], ISOMETRIC[near][::-1]))


def identities(
    points: Points, deformations: Mapping[str, Mapping[str, Any]], seed: int, samples: int
) -> dict[str, float]:
    """Q(m; F) = Jo Qe(Fo⁻ᵀm; F Fo⁻¹) at random F and m, and what a constant tension adds.

    Args:
        points: Points of the law.
        deformations: Active deformations by name.
        seed: Of F, of γ from −0.35 to 0.1, of Ta and m.
        samples: How many of them.

    Returns:
        ``strain``: the largest difference of both sides over the largest entry of Q, over all deformations;
        ``tension``: that of Q − Qe − Ta (m·f)² 1; ``signs``: the share of samples in which active body at F
        and passive body at F Fo⁻¹, each minimised by itself, are both elliptic or both not; ``lost``: the
        share in which they are not; ``least``: of the active body over the modulus.
    """
    rng = np.random.default_rng(seed)
    U = np.exp(rng.uniform(-0.5, 0.5, (samples, 3)))
    U /= np.cbrt(U.prod(axis=1, keepdims=True))
    R, S = (np.linalg.qr(rng.standard_normal((samples, 3, 3)))[0] for _ in range(2))
    F = R @ (U[:, :, None] * S)
    F *= np.sign(np.linalg.det(F))[:, None, None]
    m = rng.standard_normal((samples, 3))
    m /= np.linalg.norm(m, axis=1, keepdims=True)
    gamma, tension = rng.uniform(-0.35, 0.1, samples), rng.uniform(-3, 3, samples) * points.modulus

    def acoustic(normals: Array) -> Array:
        return np.einsum("nijkl,nj,nl->nik", points.moduli(), normals, normals)

    def difference(one: Array, other: Array) -> float:
        return float((np.abs(one - other).max(axis=(1, 2)) / np.abs(other).max(axis=(1, 2))).max())

    errors, signs, lost, lowest = [], [], [], []
    for kind in deformations.values():
        Fo = active_tensors(kind, gamma)
        back = np.linalg.inv(Fo)
        points.put(F, Fo)
        active = acoustic(m)
        found, elastic = least(points, F, Fo)[0], least(points, F @ back)[0]
        expected = np.linalg.det(Fo)[:, None, None] * acoustic(np.einsum("nji,nj->ni", back, m))
        errors.append(difference(active, expected))
        signs.append(float(np.mean((found > 0) == (elastic > 0))))
        lost.append(float(np.mean(elastic <= 0)))
        lowest.append(float(found.min()))
    points.put(F)
    expected = acoustic(m) + (tension * m[:, 0] ** 2)[:, None, None] * np.eye(3)
    points.put(F, tension=tension)
    return {
        "strain": max(errors),
        "tension_added": difference(acoustic(m), expected),
        "signs": min(signs),
        "lost": max(lost),
        "least": min(lowest),
    }


def following(law: Mapping[str, Any], calcium: Sequence[float], stretches: Sequence[float]) -> Found:
    """The same where the activation follows the stretch of the fibre at once.

    Active strain: Fo = 1 + γ f⊗f with the equilibrium of :class:`~myostrain.activation.Rossi2014`, to which a
    slow deformation keeps it; the stress P(F, γ(λ)) has no energy, and of its acoustic tensor the symmetric
    part counts. Active stress: the tension T RFL(λ)/RFL(1) of the same force–length curve, with T as in
    :func:`examined` for the γ at λ = 1. F is a stretch along the fibre with equal sides.

    Args:
        law: ``model``, a name of :mod:`myostrain.materials`, and its parameters.
        calcium: Calcium, μM.
        stretches: Stretches λ.

    Returns:
        Numbers: ``closed_form``: the largest difference of the tension's least eigenvalues from
        :func:`~myostrain.theory.least_with_tension` over the modulus, for a neo-Hookean law. Arrays over the
        modulus: ``gamma`` at λ = 1 and ``tension`` T (calcium,); ``strain``, ``stress`` and ``frozen`` (the
        strain's with γ frozen), (calcium, λ); ``ordinary``: by how much the determinant of the strain's
        acoustic tensor is that with γ frozen, at least: where it is negative, the equations are not elliptic.
    """
    passive, rossi = material(law), Rossi2014()
    c, lam = (part.ravel() for part in np.meshgrid(calcium, stretches, indexing="ij"))
    points = Points(passive, len(c))
    at_one = rossi.equilibrium(np.asarray(calcium, dtype=float), np.ones(len(calcium)))
    fibre = {"kind": "Fibre"}
    free = free_stretches(points, active_tensors(fibre, at_one))[:, 0]
    largest = tension_for(points, free)
    T_max = np.repeat(largest, len(stretches))

    def slope(function: Callable[[Array], Array]) -> Array:
        return (function(lam + STEP) - function(lam - STEP)) / (2 * STEP)

    def tension(stretch: Array) -> Array:
        return np.asarray(T_max * force_length(stretch) / force_length(1.0))

    def gamma(stretch: Array) -> Array:
        return np.asarray(rossi.equilibrium(c, stretch))

    F = isochoric(lam)
    along = F @ np.diag([1.0, 0.0, 0.0])  # F f⊗f
    G = np.linalg.inv(F).swapaxes(-1, -2)

    def stress(change: float) -> Array:
        points.put(F, active_tensors(fibre, gamma(lam) + change))
        return points.stress()

    by_gamma = (stress(STEP) - stress(-STEP)) / (2 * STEP)
    points.put(F, active_tensors(fibre, gamma(lam)))
    frozen = points.moduli()
    added = np.einsum("n,nij,nkl->nijkl", slope(gamma) / lam, by_gamma, along)
    points.put(F, tension=tension(lam))
    pulled = points.moduli() + np.einsum("n,nij,nkl->nijkl", slope(tension) / lam, along, along)
    moduli = {
        "strain": frozen + (added + added.transpose(0, 3, 4, 1, 2)) / 2,
        "stress": pulled,
        "frozen": frozen,
    }
    shape, modulus = (len(calcium), len(stretches)), passive.modulus
    found = {name: _sought(A / modulus, G)[0].reshape(shape) for name, A in moduli.items()}
    # Q of the whole is that of the frozen one with p⊗q added: its determinant is 1 + q·Q⁻¹p times as large.
    numbers: dict[str, Any] = {"closed_form": None}
    found["ordinary"] = _determinant_ratio(frozen, by_gamma, along * (slope(gamma) / lam)[:, None, None], G)
    found["ordinary"] = found["ordinary"].reshape(shape)
    if isinstance(passive, NeoHookean):
        exact = least_with_tension(lam, tension(lam) / modulus, slope(tension) / modulus).reshape(shape)
        numbers["closed_form"] = float(np.abs(found["stress"] - exact).max())
    return Found(
        numbers,
        {"gamma": at_one, "stretch": np.asarray(stretches, dtype=float), "tension": largest / modulus}
        | found,
    )


def _determinant_ratio(A: Array, P: Array, D: Array, G: Array) -> Array:
    """The least 1 + q·Q(m)⁻¹p over m, with p = P m, q = D m and amplitudes across F⁻ᵀm, of points (n,)."""
    m = half_sphere(DIRECTIONS)
    a = np.cross(m, np.eye(3)[np.abs(m).argmin(axis=1)])
    normal = m @ G.transpose(0, 2, 1)  # (n, d, 3)
    a = np.cross(normal, a)
    a /= np.linalg.norm(a, axis=2, keepdims=True)
    b = np.cross(normal, a)
    b /= np.linalg.norm(b, axis=2, keepdims=True)
    plane = np.stack([a, b], axis=2)  # (n, d, 2, 3)
    pairs = (m[:, :, None] * m[:, None, :]).reshape(-1, 9)
    Q = (pairs @ A.transpose(0, 2, 4, 1, 3).reshape(-1, 9, 9)).reshape(*normal.shape[:2], 3, 3)
    Q = plane @ Q @ plane.swapaxes(2, 3)
    p, q = ((plane @ (m @ part.transpose(0, 2, 1))[..., None])[..., 0] for part in (P, D))
    solved = np.linalg.solve(Q, p[..., None])[..., 0]
    return np.asarray((1 + (q * solved).sum(axis=2)).min(axis=1))


def limits(tensions: Sequence[float]) -> Found:
    """The tension, and its slope over the stretch, at which an unstretched neo-Hookean body is not elliptic.

    Args:
        tensions: T/μ at which the slope is sought.

    Returns:
        Numbers over μ: ``push`` the critical constant tension; ``slopes`` dT/dλ by T, and ``closed_form`` of
        them; and of the line ``line``, the β v at which its elastic strain does not rise with its stretch.
    """
    points = Points(NeoHookean(mu=1.0), len(tensions) + 1)
    one = np.broadcast_to(np.eye(3), (len(tensions) + 1, 3, 3))
    fibre = np.diag([1.0, 0.0, 0.0])
    T = np.array([*tensions, 0.0])

    def lost(x: Array) -> Any:
        constant, slope = np.where(T != 0, T, x), np.where(T != 0, x, 0.0)
        points.put(one, tension=constant)
        A = points.moduli() + np.einsum("n,ij,kl->nijkl", slope, fibre, fibre)
        return least_eigenvalues(A, np.array(one))[0] <= 0

    good, bad = np.zeros(len(T)), np.full(len(T), -100.0)
    for _ in range(40):
        middle = (good + bad) / 2
        beyond = lost(middle)
        good, bad = np.where(beyond, good, middle), np.where(beyond, middle, bad)
    push, slopes = float(good[-1]), good[:-1]
    # The line: Fe = J/(1 − β V/J) at J = 1, by differences, over β v = β V.
    activity = np.linspace(0.0, 0.9, 1801)
    strain = [(1 + h) / (1 - activity / (1 + h)) for h in (-STEP, STEP)]
    rise = (strain[1] - strain[0]) / (2 * STEP)
    line = float(np.interp(0.0, -rise, activity))
    return Found(
        {
            "push": push,
            "tensions": list(tensions),
            "slopes": slopes.tolist(),
            "closed_form": critical_slope(tensions).tolist(),
            "line": line,
        }
    )
