"""The start-up of a pulse: the energy condition of section 5 of the paper, for any initial potential.

The paper is D. Ambrosi, G. Arioli, F. Nobile, A. Quarteroni, SIAM J. Appl. Math. 71(2), 2011,
doi 10.1137/100788379.  With the balances multiplied by v and by A w, on a body with J = det F, fluxless at
its boundary,

    d/dt int J (v²/2 + A w²/2) = - int J D |F^-T Grad v|² - A int J v² (v - alpha)(v - 1) - A int J w²/tau
                                 - 1/2 int dJ/dt (v² + A w²)

which for J = 1 (3.8) is (5.1).  At w = 0 on a body at rest (dJ/dt = 0), with the last line and w gone, the
energy grows where (5.2) holds: reaction_power >= diffusion_loss, `grows` for short.  For F homogeneous that
is certain where the least eigenvalue of C = Fᵀ F exceeds `sufficient_stretch`, (5.4).

The volume ratio J weights both sides on the line of section 4, where F = J = x'.  On a line held at a
homogeneous stretch it cancels and (5.2) is what it is for J = 1.  On the free elastic line, J = 1 - beta v
(4.3), the balance (4.6) times v is at w = 0

    d/dt int (v²/2 - 2 beta v³/3) = - int D (v')²/J - A int J v² (v - alpha)(v - 1)

so that the weighted condition says when this energy grows.

The potential is linear on simplices (intervals, triangles, tetrahedra), and for such a function every
integral here is exact: over a simplex of volume V in d dimensions, with the values v_0 ... v_d at its
corners,

    int v^k = V k! d! / (k + d)! h_k(v_0, ..., v_d),   h_k the sum of all monomials of degree k.

Everything is non-dimensional, as in the paper.  No mesh library, no solver: only NumPy.
"""

from __future__ import annotations

from math import factorial

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["diffusion_loss", "grows", "reaction_power", "sufficient_stretch"]

Array = NDArray[np.float64]

#: Volume of a simplex, relative to that of a cube on its edges, at which it counts as flat.
FLAT = 1e-13


def reaction_power(
    points: ArrayLike, cells: ArrayLike, v: ArrayLike, *, alpha: float, A: float = 1.0, J: ArrayLike = 1.0
) -> float:
    """What the reaction gives, the left side of (5.2): A int J v² (v - alpha)(1 - v), at w = 0.

    Args:
        points: Material coordinates of the nodes, (n, dim), dim 1, 2 or 3.
        cells: Nodes of each simplex, (m, dim + 1), any orientation.
        v: Potential at the nodes (n,), linear between them.
        alpha: Threshold of the cubic reaction.
        A: Rate of the reaction, A > 0.
        J: Volume ratio det F > 0, one number or one a cell (m,); 1 on an incompressible body (3.8).

    Raises:
        ValueError: Shapes that do not fit, a degenerate cell, a value that is not finite or out of range.
    """
    _, volumes, values, J = _checked(points, cells, v, J)
    _demand_positive("A", A)
    _demand_finite("alpha", alpha)
    square, cube, fourth = (_moments(values, k) for k in (2, 3, 4))
    return float(A * np.sum(J * volumes * ((1 + alpha) * cube - fourth - alpha * square)))


def diffusion_loss(
    points: ArrayLike,
    cells: ArrayLike,
    v: ArrayLike,
    *,
    F: ArrayLike | None = None,
    diffusivity: ArrayLike = 1.0,
    J: ArrayLike = 1.0,
) -> float:
    """What diffusion takes, the right side of (5.2): int J (F^-T Grad v) . D (F^-T Grad v).

    Args:
        points: As in `reaction_power`.
        cells: As in `reaction_power`.
        v: As in `reaction_power`.
        F: Gradient of the deformation with det F > 0, (dim, dim) where it is homogeneous or one a cell,
            (m, dim, dim); the reference configuration unless given.
        diffusivity: D > 0, or a symmetric positive definite tensor (dim, dim) in space.
        J: As in `reaction_power`; it is not taken from F, which in a plane has no thickness.

    Raises:
        ValueError: As `reaction_power`; or F or D is not as it must be.
    """
    edges, volumes, values, J = _checked(points, cells, v, J)
    gradients = _gradients(edges, values)
    if F is not None:
        F_transposed = np.swapaxes(_checked_F(F, *gradients.shape), -1, -2)
        gradients = np.linalg.solve(F_transposed, gradients[..., None])[..., 0]
    D = _checked_D(diffusivity, gradients.shape[1])
    return float(np.sum(J * volumes * np.einsum("mi,ij,mj->m", gradients, D, gradients)))


def grows(
    points: ArrayLike,
    cells: ArrayLike,
    v: ArrayLike,
    *,
    alpha: float,
    A: float = 1.0,
    F: ArrayLike | None = None,
    diffusivity: ArrayLike = 1.0,
    J: ArrayLike = 1.0,
) -> bool:
    """Whether (5.2) holds: the energy of this initial potential begins to grow, at w = 0, dJ/dt = 0.

    Arguments and errors are those of `reaction_power` and `diffusion_loss`.
    """
    gain = reaction_power(points, cells, v, alpha=alpha, A=A, J=J)
    return gain >= diffusion_loss(points, cells, v, F=F, diffusivity=diffusivity, J=J)


def sufficient_stretch(
    points: ArrayLike,
    cells: ArrayLike,
    v: ArrayLike,
    *,
    alpha: float,
    A: float = 1.0,
    diffusivity: ArrayLike = 1.0,
) -> float:
    """The right side of (5.4): a homogeneous F whose C = Fᵀ F has all eigenvalues above it satisfies (5.2).

    It is a square of a stretch: on a line, x' must exceed its root.  A tensor D enters by its largest
    eigenvalue.  In an incompressible body the least eigenvalue of C is at most one, so (5.4) can be met only
    where this is below one, which is (5.2) for F = 1.

    Arguments are those of `reaction_power` and `diffusion_loss`.

    Raises:
        ValueError: As these; or the reaction gives nothing (its integral is not positive), so that no stretch
            suffices.
    """
    gain = reaction_power(points, cells, v, alpha=alpha, A=A)
    if not gain > 0:
        raise ValueError(
            f"no stretch suffices: the reaction gives A int v²(v - alpha)(1 - v) = {gain:.6g}, which is not "
            f"positive; (5.4) needs a potential that lies above alpha = {alpha} and below 1 where it counts"
        )
    dim = np.shape(points)[1]
    largest = float(np.linalg.eigvalsh(_checked_D(diffusivity, dim))[-1])
    return largest * diffusion_loss(points, cells, v) / gain


def _moments(values: Array, k: int) -> Array:
    """Mean of v^k over each simplex, from the values at its corners (m, dim + 1)."""
    d = values.shape[1] - 1
    h = [np.ones(len(values))] + [np.zeros(len(values)) for _ in range(k)]  # h_0 ... h_k of no value yet
    for corner in values.T:
        for degree in range(1, k + 1):
            h[degree] = h[degree] + corner * h[degree - 1]
    return h[k] * (factorial(k) * factorial(d) / factorial(k + d))


def _gradients(edges: Array, values: Array) -> Array:
    """Grad v on each simplex (m, dim), from its edge vectors (m, dim, dim), one a row."""
    rises = values[:, 1:] - values[:, :1]
    return np.asarray(np.linalg.solve(edges, rises[..., None])[..., 0])


def _checked(
    points: ArrayLike, cells: ArrayLike, v: ArrayLike, J: ArrayLike
) -> tuple[Array, Array, Array, Array]:
    """Edge vectors (m, dim, dim), volumes (m,), corner values (m, dim + 1) and J (broadcast), or an error."""
    X, v, J = (np.asarray(value, dtype=float) for value in (points, v, J))
    nodes = np.asarray(cells)
    if X.ndim != 2 or X.shape[1] not in (1, 2, 3):
        raise ValueError(f"points have the shape {X.shape}: give (n, dim) with dim 1, 2 or 3")
    dim = X.shape[1]
    if nodes.ndim != 2 or nodes.shape[1] != dim + 1 or not len(nodes) or nodes.dtype.kind not in "iu":
        raise ValueError(
            f"cells have the shape {nodes.shape} and the type {nodes.dtype}: give the nodes of each simplex, "
            f"integers of the shape (m, {dim + 1})"
        )
    if nodes.min() < 0 or nodes.max() >= len(X):
        raise ValueError(
            f"cells name the nodes {nodes.min()} to {nodes.max()}: they must lie in 0 to {len(X) - 1}"
        )
    if v.shape != (len(X),):
        raise ValueError(f"v has the shape {v.shape}: give one value per node, ({len(X)},)")
    if J.shape not in ((), (len(nodes),)):
        raise ValueError(f"J has the shape {J.shape}: give one number, or one a cell, ({len(nodes)},)")
    for name, value in dict(points=X, v=v).items():
        _demand_finite(name, value)
    _demand_positive("J", J)
    edges = X[nodes[:, 1:]] - X[nodes[:, :1]]
    box = np.prod(np.linalg.norm(edges, axis=2), axis=1)
    determinants = np.abs(np.linalg.det(edges))
    flat = determinants <= FLAT * box
    if flat.any():
        raise ValueError(f"cell {int(np.argmax(flat))} is degenerate: it has no volume")
    return edges, determinants / factorial(dim), v[nodes], J


def _checked_F(F: ArrayLike, cells: int, dim: int) -> Array:
    F = np.asarray(F, dtype=float)
    if F.shape not in ((dim, dim), (cells, dim, dim)):
        raise ValueError(f"F has the shape {F.shape}: give ({dim}, {dim}) or ({cells}, {dim}, {dim})")
    _demand_finite("F", F)
    if not np.all(np.linalg.det(F) > 0):
        raise ValueError("det F must be positive: the body is inverted")
    return F


def _checked_D(diffusivity: ArrayLike, dim: int) -> Array:
    D = np.asarray(diffusivity, dtype=float)
    if D.shape not in ((), (dim, dim)):
        raise ValueError(f"D has the shape {D.shape}: give one number, or a tensor ({dim}, {dim})")
    D = D * np.eye(dim) if D.ndim == 0 else D
    _demand_finite("D", D)
    if not np.allclose(D, D.T) or np.linalg.eigvalsh(D)[0] <= 0:
        raise ValueError("D must be positive, a tensor symmetric and positive definite")
    return D


def _demand_finite(name: str, value: ArrayLike) -> None:
    if not np.all(np.isfinite(value)):
        raise ValueError(f"{name} must be finite")


def _demand_positive(name: str, value: ArrayLike) -> None:
    if not (np.all(np.isfinite(value)) and np.all(np.asarray(value) > 0)):
        raise ValueError(f"{name} must be positive and finite")
