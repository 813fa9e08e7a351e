"""Whether the equations of a solid are elliptic: the acoustic tensor, sampled."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import TYPE_CHECKING

from myostrain.engine import fem, jit_options, lasting
from myostrain.errors import InputError

import numpy as np
import numpy.typing as npt
import ufl

if TYPE_CHECKING:
    from myostrain.mechanics.equilibrium import Mechanics

log = logging.getLogger("myostrain")

Array = npt.NDArray[np.float64]

#: Cells that are looked at, at most, over all processes.
MOST_CELLS = 1000

#: Directions of the first look, spread over half a sphere, about 0.2 apart.
DIRECTIONS = 128

#: How far from the best direction so far the next ones are tried, twice each, and how many around it.
CLOSER, AROUND = (0.1, 0.03, 0.01, 0.003), 8


@dataclass(frozen=True)
class Ellipticity:
    """The least eigenvalue that was found of the acoustic tensor.

    Args:
        minimum: The eigenvalue over the material's modulus at rest; positive as long as the body is elliptic
            where it was sampled.
        where: Material coordinates (3,) of the place.
        direction: Unit normal N (3,) in the reference configuration, up to its sign: that of the plane across
            which the deformation may localize where ``minimum`` is not positive.
    """

    minimum: float
    where: tuple[float, ...]
    direction: tuple[float, ...]


class EllipticityMonitor:
    """Looks for a loss of strong ellipticity, which active strain does not exclude, and warns of it once.

    The acoustic tensor is Q(N)ᵢₖ = Aᵢⱼₖₗ Nⱼ Nₗ with A = ∂²W/∂F∂F, of the stored energy per reference volume,
    active strain or active stress included. Where the body is compressible, strong ellipticity (the strict
    Legendre–Hadamard condition) is m·Q(N) m > 0 for all m and N. Where J is prescribed by a pressure, only
    amplitudes with m·F⁻ᵀN = 0 count, which keep J; the pressure's own part of A drops out, because
    det(F + m⊗N) is linear in m (L. Zee, E. Sternberg, Arch. Rational Mech. Anal. 83 (1983) 53–90).

    The least eigenvalue is sought over unit vectors N at the centres of cells, all of them or
    :data:`MOST_CELLS` spread over the body: in :data:`DIRECTIONS` fixed directions, then ever closer around
    the best one of each cell. So a value is never below the least one of its cells, and a body that is not
    elliptic between centres may go unnoticed. A check takes about 0.2 s.

    Args:
        mechanics: The mechanics of a solid.

    Raises:
        InputError: The body is not a solid.
    """

    names = ("ellipticity",)

    def __init__(self, mechanics: Mechanics) -> None:
        body, active = mechanics.body, mechanics._active
        if body.dim != 3:
            raise InputError('only a solid has this monitor; give "off"', "mechanics.ellipticity")
        mesh = self._mesh = body.mesh
        self._comm = lasting(mesh.comm)
        owned = mesh.topology.index_map(3).size_local
        stride = -(-body.cells // MOST_CELLS)
        # By their numbers in the input, which the processes do not change.
        chosen = mesh.topology.original_cell_index[:owned] % stride == 0
        self._cells = np.flatnonzero(chosen).astype(np.int32)
        self._centres = mesh.geometry.x[mesh.geometry.dofmaps[0][self._cells]].mean(axis=1)
        F = active.lifted(mechanics.u, mechanics.activation)
        # By two numbers and not by F twice: compiling the 81 components takes a minute and more.
        self._along = [fem.Constant(mesh, np.zeros((3, 3))) for _ in range(2)]
        s, t = (ufl.variable(fem.Constant(mesh, 0.0)) for _ in range(2))
        W = active.stored(F + s * self._along[0] + t * self._along[1], mechanics.activation)
        scale = getattr(active._material, "modulus", 1.0)
        centre = np.full((1, 3), 1 / 4)
        second = ufl.diff(ufl.diff(W, s), t) / scale
        self._second = fem.Expression(second, centre, jit_options=jit_options())
        self._normals = None
        if mechanics.kinematics.has_pressure:
            self._normals = fem.Expression(ufl.inv(F).T, centre, jit_options=jit_options())
        self._warned = False

    def check(self) -> Ellipticity:
        """Look at the present configuration; warn the first time that it is not elliptic (collective)."""
        A = self._moduli()
        G = None if self._normals is None else self._normals.eval(self._mesh, self._cells)[:, 0]
        values, directions = least_eigenvalues(A, G)
        mine = []
        for i in np.argsort(values)[:1]:
            mine = [(float(values[i]), tuple(self._centres[i].tolist()), tuple(directions[i].tolist()))]
        found = Ellipticity(*min(entry for part in self._comm.allgather(mine) for entry in part))
        if not found.minimum > 0 and not self._warned:
            self._warned = True
            if self._comm.rank == 0:
                log.warning(
                    "the body is not elliptic near %s: m·Q(N)m is %.3g of the modulus for N = %s; what is "
                    "computed from here on may depend on the mesh",
                    np.round(found.where, 4).tolist(),
                    found.minimum,
                    np.round(found.direction, 4).tolist(),
                )
        return found

    def _moduli(self) -> Array:
        """A over the modulus, (cells, 3, 3, 3, 3)."""
        A = np.empty((len(self._cells), 9, 9))
        basis = np.eye(9).reshape(9, 3, 3)
        for i, k in zip(*np.triu_indices(9), strict=True):
            for constant, direction in zip(self._along, (basis[i], basis[k]), strict=True):
                constant.value[:] = direction
            A[:, i, k] = A[:, k, i] = self._second.eval(self._mesh, self._cells)[:, 0]
        return A.reshape(-1, 3, 3, 3, 3)

    def values(self) -> dict[str, float]:
        """The least eigenvalue by name (collective)."""
        return {"ellipticity": self.check().minimum}


def least_eigenvalues(A: Array, G: Array | None) -> tuple[Array, Array]:
    """The least eigenvalue of the acoustic tensor over directions, and the direction, of many places at once.

    Args:
        A: Second derivatives of the energy by F, (n, 3, 3, 3, 3).
        G: F⁻ᵀ (n, 3, 3) where only amplitudes across F⁻ᵀN count; None where all do.

    Returns:
        Eigenvalues (n,) and unit vectors N (n, 3).
    """
    spread = half_sphere(DIRECTIONS)
    values = _smallest(A, G, np.broadcast_to(spread, (len(A), *spread.shape)))
    best, N = values.min(axis=1), spread[values.argmin(axis=1)]
    angles = 2 * np.pi * np.arange(AROUND) / AROUND
    for radius in np.repeat(CLOSER, 2):
        a, b = _across(N)
        ring = np.cos(angles)[:, None] * a[:, None] + np.sin(angles)[:, None] * b[:, None]
        near = np.cos(radius) * N[:, None] + np.sin(radius) * ring
        values = _smallest(A, G, near)
        better = values.min(axis=1) < best
        best = np.minimum(best, values.min(axis=1))
        N[better] = near[better, values[better].argmin(axis=1)]
    return best, N


def _smallest(A: Array, G: Array | None, N: Array) -> Array:
    """Least eigenvalues (n, d) of the acoustic tensors of directions N (n, d, 3)."""
    pairs = (N[..., :, None] * N[..., None, :]).reshape(*N.shape[:2], 9)
    Q = (pairs @ A.transpose(0, 2, 4, 1, 3).reshape(-1, 9, 9)).reshape(*N.shape[:2], 3, 3)
    if G is None:
        return np.asarray(np.linalg.eigvalsh(Q)[..., 0])
    a, b = _across(N @ G.transpose(0, 2, 1))
    Qa, Qb = (np.einsum("pdij,pdj->pdi", Q, x) for x in (a, b))
    aa, ab, bb = (a * Qa).sum(axis=2), (a * Qb).sum(axis=2), (b * Qb).sum(axis=2)
    return np.asarray((aa + bb) / 2 - np.hypot((aa - bb) / 2, ab))


def _across(n: Array) -> tuple[Array, Array]:
    """Two unit vectors (..., 3) across vectors n (..., 3) and each other."""
    a = np.cross(n, np.eye(3)[np.abs(n).argmin(axis=-1)])
    a /= np.linalg.norm(a, axis=-1, keepdims=True)
    b = np.cross(n, a)
    return a, b / np.linalg.norm(b, axis=-1, keepdims=True)


def half_sphere(number: int) -> Array:
    """Unit vectors (number, 3) spread evenly over half a sphere, a Fibonacci lattice."""
    i = np.arange(number) + 0.5
    z, around = 1 - i / number, np.pi * (1 + 5**0.5) * i
    r = np.sqrt(1 - z**2)
    return np.stack([r * np.cos(around), r * np.sin(around), z], axis=1)
