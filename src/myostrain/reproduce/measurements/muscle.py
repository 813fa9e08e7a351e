"""A strip of muscle along its fibre, by active strain and by active stress: forces, releases, sensitivity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.activation import Rossi2014
from myostrain.activation.force_length import force_length
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements.points import (
    ONE,
    Array,
    Points,
    active_tensors,
    free_stretches,
    held_force,
    material,
)

import numpy as np

#: Step of differences in the logarithm of stretches and parameters, and in γ.
STEP = 1e-3


#: Changes of the logarithms of the three stretches that keep the volume.
WAYS = np.array([[1.0, 0.0, -1.0], [0.0, 1.0, -1.0]])


def matched(points: Points, deformation: Mapping[str, Any], gamma: float) -> dict[str, Any]:
    """A free and an isometric piece under γ, and the two tensions that match it.

    Returns:
        ``Fo`` (1, 3, 3); ``free``, the stretch λ of the free piece along the fibre; ``isometric``, its force
        per reference area at λ = 1; ``tension``, which shortens the passive piece as much; and
        ``contraction``, by how much a tension of the size of the isometric force shortens it.
    """
    Fo, one = active_tensors(deformation, np.array([gamma])), ONE[None]
    free = free_stretches(points, Fo)[:, 0]
    isometric = held_force(points, Fo, np.ones(1))
    return {
        "Fo": Fo,
        "free": float(free[0]),
        "isometric": float(isometric[0]),
        "tension": float(-held_force(points, one, free)[0] / free[0]),
        "contraction": float(1 - free_stretches(points, one, tension=isometric)[0, 0]),
    }


def strip(
    law: Mapping[str, Any],
    deformations: Mapping[str, Mapping[str, Any]],
    gammas: Sequence[float],
    stretches: Sequence[float],
    loads: Sequence[float],
) -> Found:
    """A strip with free sides: free contraction, isometric force, force over length, force over velocity.

    The tension is constant, T; P = T λ is its force per reference area. It is matched twice: to the same
    free contraction, and to the same isometric force.

    Args:
        law: ``model``, a name of :mod:`myostrain.materials`, and its parameters.
        deformations: Active deformations, "kind" a name of :mod:`myostrain.activation`, by name.
        gammas: Active strains; the last one is looked at closely.
        stretches: λ of the force–length curves.
        loads: Shares of the isometric force to which it is released.

    Returns:
        Numbers by deformation: those of :func:`matched` for the last γ; ``slope``, d ln P/d ln λ of the force
        that activation adds, at λ = 1; ``velocity`` and ``stress_velocity``, see :func:`released`, of the
        unloaded strip, and ``half`` and ``stress_half``, at half the isometric force, over it. Arrays:
        ``passive`` (λ,); by deformation ``NAME force`` (λ,) and, over γ, ``NAME free``, ``NAME isometric``,
        ``NAME tension`` and ``NAME contraction``; ``NAME velocity`` and ``NAME stress velocity`` (loads,).
    """
    passive_law, lam, shares = material(law), np.asarray(stretches, dtype=float), np.asarray(loads)
    points = Points(passive_law, max(len(lam), 3))
    ones = np.broadcast_to(ONE, (len(lam), 3, 3))
    arrays: dict[str, Array] = {"stretch": lam, "passive": held_force(points, ones, lam), "load": shares}
    numbers: dict[str, Any] = {"modulus": passive_law.modulus}
    near = np.exp(np.array([-STEP, 0.0, STEP]))
    rest = held_force(points, np.broadcast_to(ONE, (3, 3, 3)), near)
    numbers["passive_stiffness"] = float((rest[2] - rest[0]) / (2 * STEP))
    for name, deformation in deformations.items():
        found = [matched(points, deformation, gamma) for gamma in gammas]
        for key in ("free", "isometric", "tension", "contraction"):
            arrays[f"{name} {key}"] = np.array([one[key] for one in found])
        last = found[-1]
        Fo = last.pop("Fo")
        arrays[f"{name} force"] = held_force(points, np.broadcast_to(Fo, ones.shape), lam)
        local = held_force(points, np.broadcast_to(Fo, (3, 3, 3)), near) - rest
        stressed = held_force(points, np.broadcast_to(ONE, (3, 3, 3)), near, last["tension"]) - rest
        velocity = released(points, Fo, 0.0, shares)
        stress_velocity = released(points, ONE[None], last["tension"], shares)
        arrays |= {f"{name} velocity": velocity, f"{name} stress velocity": stress_velocity}
        half = np.array([0.0, 0.5])
        numbers[name] = last | {
            "slope": float(np.log(local[2] / local[0]) / (2 * STEP)),
            "stress_slope": float(np.log(stressed[2] / stressed[0]) / (2 * STEP)),
            "stiffness": float((local[2] - local[0]) / (2 * STEP)) + numbers["passive_stiffness"],
            "velocity": float(released(points, Fo, 0.0, half)[0]),
            "stress_velocity": float(released(points, ONE[None], last["tension"], half)[0]),
            "half": _ratio(released(points, Fo, 0.0, half)),
            "stress_half": _ratio(released(points, ONE[None], last["tension"], half)),
        }
    return Found(numbers, arrays)


def _ratio(two: Array) -> float:
    return float(two[1] / two[0])


def released(points: Points, Fo: Array, tension: float, loads: Array) -> Array:
    """How fast a viscous isometric strip begins to shorten when its force is let down to shares of itself.

    The viscous stress is the program's, S = 2 τ μ Jo Fo⁻ᵀ-transported (see
    :class:`~myostrain.mechanics.active_body.ActiveBody`): S_i = 2 τ μ Jo a_i⁻⁴ λ_i² d(ln λ_i)/dt along the
    axes.

    Args:
        points: The points.
        Fo: Fo (1, 3, 3), diagonal.
        tension: Ta.
        loads: Shares (n,) of the isometric force.

    Returns:
        −dλ/dt (n,) over the isometric force P₀, in units of 1/(τ μ).
    """
    stretches = free_stretches(points, Fo, np.ones(1), tension=tension)[0]
    power = np.diag(points.stress()[0]) * stretches
    force = power[0] - power[2]
    a = np.diag(Fo[0])
    viscous = 2 * points.modulus * a.prod() * a**-4 * stretches**4
    drive = np.zeros((len(loads), 3))
    drive[:] = -power
    drive[:, 0] += force * loads
    rates = np.linalg.solve(WAYS @ np.diag(viscous) @ WAYS.T, WAYS @ drive.T)[0]
    return np.asarray(-rates * points.modulus / force)


def followed(law: Mapping[str, Any], gamma: float, loads: Sequence[float], mu: float) -> Found:
    """An isometric strip whose γ is in the equilibrium of Rossi et al., released to shares of its force.

    It jumps to the length of the new load at once, γ being what it was, and goes on as γ does.

    Args:
        law: The passive law.
        gamma: γ at λ = 1, transversely isotropic.
        loads: Shares of the isometric force.
        mu: μ of the law, ms μM⁻².

    Returns:
        Numbers: ``calcium``, μM. Arrays (loads,): ``load``; ``stretch`` right after the release; ``rate``
        dγ/dt and ``velocity`` −dλ/dt there, per second.
    """
    contraction, shares = Rossi2014(mu=mu), np.asarray(loads, dtype=float)
    points = Points(material(law), len(shares))
    kind = {"kind": "TransverselyIsotropic"}
    calcium = calcium_for(contraction, gamma)

    def at(value: float) -> Array:
        return free_stretches(points, np.repeat(active_tensors(kind, np.array([value])), len(shares), 0),
                              pull=shares * force)[:, 0]  # fmt: skip

    force = held_force(points, active_tensors(kind, np.array([gamma])), np.ones(1))[0]
    lam = at(gamma)
    follows = (at(gamma + STEP) - at(gamma - STEP)) / (2 * STEP)
    step = 1e-4  # ms
    c = np.full(len(shares), calcium)
    after = contraction.advance(np.full((1, len(shares)), gamma), {"calcium": c, "stretch": lam}, step)[0]
    rate = (after - gamma) / step * 1000
    numbers = {"calcium": calcium, "isometric": float(force)}
    return Found(numbers, {"load": shares, "stretch": lam, "rate": rate, "velocity": -follows * rate})


def calcium_for(law: Rossi2014, gamma: float, stretch: float = 1.0) -> float:
    """The calcium, μM, at which γ is the equilibrium at a stretch."""
    force = -2 * stretch**2 * ((1 + gamma) ** -3 - 1)
    return law.c0 + float(np.sqrt(force / (law.alpha * force_length(stretch, law.sarcomere))))


def sensitivity(
    law: Mapping[str, Any],
    deformation: Mapping[str, Any],
    gamma: float,
    groups: Mapping[str, Sequence[str]],
) -> Found:
    """What a change of passive parameters does to contraction and force while the activation stays.

    Args:
        law: The passive law.
        deformation: The active deformation.
        gamma: γ.
        groups: Names of parameters that change together, by name.

    Returns:
        Numbers: d ln q/d ln p of ``contraction`` 1 − λ of the free strip and of the ``isometric`` force, by
        approach ("strain"; "stress", matched to the free contraction; "force", to the isometric force) and
        group of parameters p; and by "activation" in place of a group: to γ, or the tension.
    """
    points = Points(material(law), 1)
    middle = matched(points, deformation, gamma)
    tensions = {"stress": middle["tension"], "force": middle["isometric"]}
    before = _reached(points, deformation, gamma, tensions, 1.0)
    after = {"activation": _reached(points, deformation, gamma, tensions, np.exp(STEP))}
    for name, group in groups.items():
        changed = Points(material({**law} | {key: law[key] * np.exp(STEP) for key in group}), 1)
        after[name] = _reached(changed, deformation, gamma, tensions, 1.0)
    return Found(
        {
            approach: {
                name: {what: float(np.log(one[approach][what] / value) / STEP) for what, value in of.items()}
                for name, one in after.items()
            }
            for approach, of in before.items()
        }
    )


def _reached(
    points: Points,
    deformation: Mapping[str, Any],
    gamma: float,
    tensions: Mapping[str, float],
    factor: float,
) -> dict[str, dict[str, float]]:
    """Contraction and isometric force by approach, at activations times a factor."""
    one = np.ones(1)
    Fo = active_tensors(deformation, np.array([gamma * factor]))
    cases = {"strain": (Fo, 0.0)} | {name: (ONE[None], T * factor) for name, T in tensions.items()}
    return {
        name: {
            "contraction": float(1 - free_stretches(points, tensor, tension=T)[0, 0]),
            "isometric": float(held_force(points, tensor, one, T)[0]),
        }
        for name, (tensor, T) in cases.items()
    }
