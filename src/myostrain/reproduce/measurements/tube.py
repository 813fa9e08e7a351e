"""A thick-walled tube with helical fibres, semi-analytic: pressure over volume by strain and by stress."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain.errors import ComputationError
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements.muscle import matched
from myostrain.reproduce.measurements.points import ONE, Array, Points, material

import numpy as np

#: Points of Gauss through the wall.
GAUSS = 12
#: Corrections of Newton's method at most, and how far one may go: in ln Λ, and in the twist per length.
MOST, LONGEST = 200, np.array([0.05, 0.1])
#: Step of the differences that its tangent is made of.
STEP = 1e-5


class Tube:
    """An incompressible tube under F = diag(R/(rΛ), r/R, Λ) + rψ e_θ⊗e_z: inflated, stretched and twisted.

    r² = (V/π + R² − Rᵢ²)/Λ, where V is the volume inside per reference length, Λ the axial stretch and ψ the
    twist per reference length. Its ends are closed and free to turn: for a given V it is in equilibrium where
    its energy E(V, Λ, ψ) is stationary in Λ and ψ, and the pressure is ∂E/∂V.

    Args:
        law: The passive law.
        radii: Inner and outer radius.
        helix: Angles of the fibres to e_θ inside and outside, degrees, linear between; sheets are radial.
        states: How many volumes there are at a time, at most.
    """

    def __init__(self, law: Any, radii: tuple[float, float], helix: tuple[float, float], states: int) -> None:
        self.inner, self.outer = radii
        nodes, weights = np.polynomial.legendre.leggauss(GAUSS)
        share = (1 + nodes) / 2
        self.R = self.inner + (self.outer - self.inner) * share
        self._weights = np.pi * (self.outer - self.inner) * weights * self.R
        angle = np.radians(helix[0] + (helix[1] - helix[0]) * share)
        zero, c, s = np.zeros(GAUSS), np.cos(angle), np.sin(angle)
        # Columns: fibre, sheet, normal in the frame (r, θ, z).
        self._frame = np.stack(
            [np.stack([zero, c, s], 1), np.stack([zero + 1, zero, zero], 1), np.stack([zero, s, -c], 1)], 2
        )
        self.points = Points(law, states * GAUSS)

    def energy_gradient(self, q: Array, Fo: Array, tension: float) -> Array:
        """∂E/∂q (n, 3) at q = (V, ln Λ, ψ) (n, 3)."""
        V, stretch, psi = q[:, :1], np.exp(q[:, 1:2]), q[:, 2:]
        R = self.R
        r = np.sqrt((V / np.pi + R**2 - self.inner**2) / stretch)
        F = np.zeros((*r.shape, 3, 3))
        F[..., 0, 0], F[..., 1, 1] = R / (r * stretch), r / R
        F[..., 1, 2], F[..., 2, 2] = r * psi, stretch
        # What F does when r and ln Λ change: the first component keeps the volume.
        of_r = np.zeros_like(F)
        of_r[..., 0, 0], of_r[..., 1, 1], of_r[..., 1, 2] = -R / (r**2 * stretch), 1 / R, psi
        of_stretch = -r[..., None, None] / 2 * of_r
        of_stretch[..., 0, 0] -= F[..., 0, 0]
        of_stretch[..., 2, 2] += stretch
        of_twist = np.zeros_like(F)
        of_twist[..., 1, 2] = r
        self.points.put((F @ self._frame).reshape(-1, 3, 3), Fo, tension)
        P = self.points.stress().reshape(F.shape) @ self._frame.swapaxes(1, 2)
        ways = of_r / (2 * np.pi * r * stretch)[..., None, None], of_stretch, of_twist
        return np.stack([np.einsum("nrij,nrij,r->n", P, way, self._weights) for way in ways], axis=1)

    def settle(self, volumes: Array, Fo: Array = ONE, tension: float = 0.0) -> dict[str, Array]:
        """The tube in equilibrium at volumes (n,), one after the other where one is far from the next.

        Returns:
            ``volume``, ``pressure``, ``stretch`` Λ, ``twist`` ψ, and ``wall``, the wall's thickness, (n,).

        Raises:
            ComputationError: No equilibrium is found.
        """
        q = np.stack([volumes, np.zeros_like(volumes), np.zeros_like(volumes)], axis=1)
        longest, before = np.ones(len(q)), np.zeros((len(q), 2))
        for _ in range(MOST):
            gradient = self.energy_gradient(q, Fo, tension)
            tangent = np.empty((len(q), 2, 2))
            for k in range(2):
                moved = [q.copy(), q.copy()]
                for other, side in zip(moved, (-STEP, STEP), strict=True):
                    other[:, 1 + k] += side
                low, high = (self.energy_gradient(other, Fo, tension)[:, 1:] for other in moved)
                tangent[:, :, k] = (high - low) / (2 * STEP)
            values, vectors = np.linalg.eigh((tangent + tangent.swapaxes(1, 2)) / 2)
            values = np.maximum(np.abs(values), 1e-6 * self.points.modulus)  # towards less energy
            step = -np.einsum("nij,nj,nkj,nk->ni", vectors, 1 / values, vectors, gradient[:, 1:])
            # Shorter where it turns back, as for free points.
            turned = (step * before).sum(axis=1) < 0
            longest = np.minimum(np.where(turned, longest / 2, 1.5 * longest), 1.0)
            step *= np.minimum(1.0, longest / np.maximum(np.abs(step / LONGEST).max(axis=1), 1e-300))[:, None]
            before = step
            q[:, 1:] += step
            if np.abs(step).max() < 1e-9:
                return self._described(q, gradient[:, 0])
        raise ComputationError("the tube finds no equilibrium", advice="a smaller activation.")

    def _described(self, q: Array, pressure: Array) -> dict[str, Array]:
        V, stretch, twist = q[:, 0], np.exp(q[:, 1]), q[:, 2]
        inside = np.sqrt(V / (np.pi * stretch))
        outside = np.sqrt((V / np.pi + self.outer**2 - self.inner**2) / stretch)
        return {
            "volume": V,
            "pressure": pressure,
            "stretch": stretch,
            "twist": twist,
            "wall": outside - inside,
        }


def chamber(
    law: Mapping[str, Any],
    deformations: Mapping[str, Mapping[str, Any]],
    gamma: float,
    radii: tuple[float, float],
    helix: tuple[float, float],
    volumes: Sequence[float],
) -> Found:
    """The tube passive and active, by strain and by the tensions that match the strip.

    Args:
        law: ``model``, a name of :mod:`myostrain.materials`, and its parameters.
        deformations: Active deformations by name.
        gamma: γ.
        radii: See :class:`Tube`.
        helix: See :class:`Tube`.
        volumes: Volumes over the reference one, ascending.

    Returns:
        Arrays: ``volume`` over the reference one, and, under "STATE KEY", those of :meth:`Tube.settle` of the
        states "passive", "NAME strain", "NAME stress" (matched to the free contraction), and "NAME force" (to
        the isometric force). Numbers: the tensions by name of deformation.
    """
    passive, reference = material(law), np.pi * radii[0] ** 2
    tube = Tube(passive, radii, helix, len(volumes))
    V = reference * np.asarray(volumes, dtype=float)
    arrays: dict[str, Array] = {"volume": V / reference}
    states: dict[str, tuple[Any, float]] = {"passive": (ONE, 0.0)}
    numbers = {}
    for name, deformation in deformations.items():
        one = matched(Points(passive, 1), deformation, gamma)
        states |= {
            f"{name} strain": (one["Fo"][0], 0.0),
            f"{name} stress": (ONE, one["tension"]),
            f"{name} force": (ONE, one["isometric"]),
        }
        numbers[name] = {"stress": one["tension"], "force": one["isometric"]}
    for state, (Fo, tension) in states.items():
        found = tube.settle(V, Fo, tension)
        arrays |= {f"{state} {key}": value for key, value in found.items() if key != "volume"}
    return Found(numbers, arrays)
