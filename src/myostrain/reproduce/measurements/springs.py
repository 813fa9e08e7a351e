"""Active stress beside active strain: springs (1.7)–(1.10), and materials at small strain (1.12)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain import materials
from myostrain.engine import MPI, fem, jit_options
from myostrain.reproduce.jobs import Found
from myostrain.theory import active_strain_force, active_stress_force, equivalent_active_force
from myostrain.validation import with_constants

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx.mesh import create_interval

Array = npt.NDArray[np.float64]


def spring(
    power: int, stiffness: float, rest: float, active_length: float, spreads: Sequence[float], points: int
) -> Found:
    """The active force that a spring needs around its rest length, and what the best constant leaves.

    Args:
        power: 1 for the linear spring, 3 for the cubic one.
        stiffness: k.
        rest: Rest length ℓo.
        active_length: ℓa.
        spreads: The lengths are within ℓo (1 ± spread); the widest comes first.
        points: How many lengths.

    Returns:
        Numbers by spread, in lists: ``smallest`` and ``largest`` active force needed, ``best_constant`` (the
        one with the least largest error) and its ``error`` relative to its own size; ``constant_difference``,
        the largest difference of the forces f of both theories, relative to the largest f, with the paper's
        f_a = −k (ℓa − ℓo)^power, and ``explicit_difference`` with the f_a of each length.
        Arrays over the widest range: ``length``, ``needed``, ``active_strain``, ``active_stress``, the last
        with the best constant there.
    """
    law: dict[str, Any] = {"stiffness": stiffness, "power": power}
    offset = np.asarray(spreads, dtype=float)[:, None] * rest * np.linspace(-1, 1, points)
    length = rest + offset  # (spreads, points)
    needed = equivalent_active_force(length, rest, active_length, **law)
    strain = active_strain_force(length, active_length, **law)
    smallest, largest = needed.min(axis=1), needed.max(axis=1)
    best = (smallest + largest) / 2
    printed = -stiffness * (active_length - rest) ** power

    def difference(active_force: Any) -> list[float]:
        force = active_stress_force(length, rest, active_force, **law)
        worst: list[float] = (np.abs(force - strain).max(axis=1) / np.abs(strain).max(axis=1)).tolist()
        return worst

    numbers = {
        "spreads": list(spreads),
        "smallest": smallest.tolist(),
        "largest": largest.tolist(),
        "best_constant": best.tolist(),
        "error": ((largest - smallest) / 2 / np.abs(best)).tolist(),
        "constant": printed,
        "constant_difference": difference(printed),
        "explicit_difference": difference(needed),
    }
    stress = active_stress_force(length[0], rest, best[0], **law)
    arrays = {"length": length[0], "needed": needed[0], "active_strain": strain[0], "active_stress": stress}
    return Found(numbers, arrays)


def small_strains(
    material: Mapping[str, Any],
    form: str,
    isochoric: bool,
    seed: int,
    directions: int,
    sizes: Sequence[float],
) -> Found:
    """(1.12) with a material of the program: the difference of P(F Fo⁻¹) and P(F) − P(Fo) over the strain.

    F = 1 + ε A with a random A of norm 1, Fo = 1 + ε g n⊗n with a random direction n and 1/2 <= |g| <= 1.
    The stress is P(F) = ∂W/∂F − J p₀ F⁻ᵀ, differentiated by UFL and evaluated by DOLFINx, a sample a cell.

    Args:
        material: ``model``, a name of :mod:`myostrain.materials`, and its parameters.
        form: "residual-free": p₀ makes P(1) = 0. "pulled back": the same, and Jo P(Fe) Fo⁻ᵀ of (1.6) in place
            of P(Fe). "energy alone": p₀ = 0.
        isochoric: Whether F is scaled to det F = 1.
        seed: Of A, n and g.
        directions: How many of them.
        sizes: The strains ε, from large to small.

    Returns:
        Numbers: ``pressure`` p₀; of the directions the ``smallest_order`` and the ``largest_order`` in ε
        between the two smallest strains; the norm of the difference relative to that of P(F) − P(Fo) at the
        largest strain, ``relative_smallest`` and ``relative_median``; ``limit``, the largest norm of the
        difference at the smallest strain. Arrays: ``sizes``, ``differences`` (directions, sizes), norms.
    """
    parameters = dict(material)
    stress = _Stress(getattr(materials, parameters.pop("model"))(**parameters), directions * len(sizes))
    dim = stress.dim
    one = np.eye(dim)
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((directions, 1, dim, dim))
    A /= np.linalg.norm(A, axis=(2, 3), keepdims=True)
    n = rng.standard_normal((directions, 1, dim))
    n /= np.linalg.norm(n, axis=2, keepdims=True)
    g = rng.uniform(0.5, 1.0, (directions, 1, 1, 1)) * rng.choice([-1.0, 1.0], (directions, 1, 1, 1))
    eps = np.asarray(sizes, dtype=float)[:, None, None]
    F = one + eps * A
    if isochoric:
        F /= np.cbrt(np.linalg.det(F))[..., None, None]
    Fo = one + eps * g * n[..., :, None] * n[..., None, :]
    Fe = F @ np.linalg.inv(Fo)

    fibre = np.broadcast_to(n, (*F.shape[:2], dim))
    pressure = 0.0
    if form != "energy alone":
        pressure = float(stress(np.broadcast_to(one, F.shape), fibre)[0, 0, 0, 0])

    def piola(F: Array) -> Array:
        cofactor = np.linalg.det(F)[..., None, None] * np.linalg.inv(F).swapaxes(-1, -2)
        return stress(F, fibre) - pressure * cofactor

    strained = piola(Fe)
    if form == "pulled back":
        strained = np.linalg.det(Fo)[..., None, None] * strained @ np.linalg.inv(Fo).swapaxes(-1, -2)
    linear = piola(F) - piola(Fo)
    difference = np.linalg.norm(strained - linear, axis=(2, 3))
    last = np.log(difference[:, -2] / difference[:, -1]) / np.log(sizes[-2] / sizes[-1])
    relative = difference[:, 0] / np.linalg.norm(linear[:, 0], axis=(1, 2))
    numbers = {
        "pressure": pressure,
        "smallest_order": float(last.min()),
        "largest_order": float(last.max()),
        "relative_smallest": float(relative.min()),
        "relative_median": float(np.median(relative)),
        "limit": float(difference[:, -1].max()),
    }
    return Found(numbers, {"sizes": np.asarray(sizes, dtype=float), "differences": difference})


class _Stress:
    """∂W/∂F of a material at ``count`` samples, one a cell of an interval."""

    def __init__(self, material: Any, count: int) -> None:
        self.dim: int = material.tensor_dim
        mesh = create_interval(MPI.COMM_SELF, count, [0.0, 1.0])
        self._mesh, self._cells = mesh, np.arange(count, dtype=np.int32)
        self._F = fem.Function(fem.functionspace(mesh, ("DG", 0, (self.dim, self.dim))))
        self._fibre = fem.Function(fem.functionspace(mesh, ("DG", 0, (self.dim,))))
        F = ufl.variable(self._F)
        stress = ufl.diff(with_constants(material, mesh).energy(F, self._fibre), F)
        self._stress = fem.Expression(stress, np.array([[0.5]]), jit_options=jit_options())

    def __call__(self, F: Array, fibre: Array) -> Array:
        """Stress for F (..., dim, dim) and fibres (..., dim) of as many samples as there are cells."""
        for function, values in ((self._F, F), (self._fibre, fibre)):
            dofs = function.function_space.dofmap.list[:, 0]
            function.x.array.reshape(len(dofs), -1)[dofs] = np.reshape(values, (len(dofs), -1))
        stress: Array = np.reshape(self._stress.eval(self._mesh, self._cells), F.shape)
        return stress
