"""The energy condition (5.2) and the sufficient stretch (5.4) against closed forms and quadrature."""

from itertools import permutations

from myostrain.theory import diffusion_loss, grows, reaction_power, sufficient_stretch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

CELL = {"alpha": 0.1, "A": 100.0}


def line(n, length=1.0):
    """Interval [0, length] in n cells."""
    nodes = np.arange(n + 1)
    return nodes[:, None] * (length / n), np.stack([nodes[:-1], nodes[1:]], axis=1)


def cube(dim, n):
    """[0, 1]^dim in n^dim dim! simplices, both orientations among them."""
    axes = np.meshgrid(*[np.linspace(0, 1, n + 1)] * dim, indexing="ij")
    strides = (n + 1) ** np.arange(dim)[::-1]
    corners = (np.indices((n,) * dim).reshape(dim, -1).T * strides).sum(axis=1)
    paths = [np.cumsum([0, *strides[list(order)]]) for order in permutations(range(dim))]
    return np.stack(axes, axis=-1).reshape(-1, dim), np.concatenate([corners[:, None] + p for p in paths])


def refined(points, cells, v):
    """Every simplex cut at its centroid, v linear: the same function on a finer mesh."""
    dim = points.shape[1]
    centres = len(points) + np.arange(len(cells))
    parts = [np.where(np.arange(dim + 1) == i, centres[:, None], cells) for i in range(dim + 1)]
    more = points[cells].mean(axis=1), v[cells].mean(axis=1)
    return np.concatenate([points, more[0]]), np.concatenate(parts), np.concatenate([v, more[1]])


def random_F(rng, dim):
    """A deformation gradient with det F > 0, far from a rotation."""
    F = rng.normal(size=(dim, dim)) + 1.5 * np.eye(dim)
    return F if np.linalg.det(F) > 0.05 else random_F(rng, dim)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_reaction_of_a_linear_potential_is_its_polynomial_integral(dim):
    """(5.2), left side: v = X on the unit cube, where the integral of v^k is 1/(k + 1).

    Measured: round-off, 1e-15 relative.
    """
    points, cells = cube(dim, 2)
    exact = 100 * (1.1 / 4 - 1 / 5 - 0.1 / 3)
    assert reaction_power(points, cells, points[:, 0], **CELL) == pytest.approx(exact, rel=1e-13)
    assert reaction_power(points, cells, points[:, 0], **CELL, J=0.7) == pytest.approx(0.7 * exact, rel=1e-13)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_reaction_matches_gauss_quadrature_on_one_simplex(dim):
    """(5.2), left side, any values at the corners: against a conical product rule, ten points an axis."""
    rng = np.random.default_rng(dim)
    corners, values = rng.normal(size=(dim + 1, dim)), rng.normal(size=dim + 1)
    # Barycentric coordinates by Duffy's map of the cube, and its Jacobian.
    nodes, weights = np.polynomial.legendre.leggauss(10)
    t = np.stack(np.meshgrid(*[(nodes + 1) / 2] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
    w = np.prod(np.stack(np.meshgrid(*[weights / 2] * dim, indexing="ij"), -1).reshape(-1, dim), axis=1)
    left, coordinates = np.ones(len(t)), []
    for i in range(dim):
        w = w * left ** (1 if i else 0)
        coordinates.append(left * t[:, i])
        left = left * (1 - t[:, i])
    barycentric = np.column_stack([left, *coordinates])
    v = barycentric @ values
    volume = abs(np.linalg.det(corners[1:] - corners[0]))
    by_quadrature = 100 * volume * np.sum(w * v**2 * (v - 0.1) * (1 - v))
    found = reaction_power(corners, [list(range(dim + 1))], values, **CELL)
    assert found == pytest.approx(by_quadrature, rel=1e-12)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_integrals_do_not_change_when_the_mesh_is_refined(dim):
    """(5.2): both sides belong to the function, not to its mesh; F, D and J given a cell are inherited."""
    rng = np.random.default_rng(7)
    points, cells = cube(dim, 2)
    v = rng.normal(size=len(points))
    F = np.array([random_F(rng, dim) for _ in cells])
    J = rng.uniform(0.5, 1.5, len(cells))
    finer = refined(points, cells, v)
    again = {"F": np.concatenate([F] * (dim + 1)), "J": np.concatenate([J] * (dim + 1))}
    assert reaction_power(*finer, **CELL, J=again["J"]) == pytest.approx(
        reaction_power(points, cells, v, **CELL, J=J), rel=1e-12
    )
    assert diffusion_loss(*finer, **again) == pytest.approx(
        diffusion_loss(points, cells, v, F=F, J=J), rel=1e-12
    )


def test_loss_of_a_linear_potential_is_that_of_its_gradient():
    """(5.2), right side: v = g . X has the loss |F^-T g|², times D in space; by hand in the plane."""
    points, cells = cube(2, 3)
    g, F = np.array([2.0, -1.0]), np.array([[1.2, 0.3], [0.0, 0.8]])
    # F^-T g by hand: solve Fᵀ y = g from above.
    y = np.array([2.0 / 1.2, (-1.0 - 0.3 * 2.0 / 1.2) / 0.8])
    D = np.array([[4.0, 1.0], [1.0, 3.0]])
    v = points @ g
    assert diffusion_loss(points, cells, v) == pytest.approx(5.0, rel=1e-13)
    assert diffusion_loss(points, cells, v, F=F, diffusivity=7.0) == pytest.approx(7 * y @ y, rel=1e-13)
    assert diffusion_loss(points, cells, v, F=F, diffusivity=D) == pytest.approx(y @ D @ y, rel=1e-13)


def test_gaussian_on_a_fine_line_has_the_closed_form():
    """(5.2) for v = a exp(−(X/L)²): the integral of v^k is a^k L sqrt(pi/k), of v'² a² sqrt(pi/2)/L.

    Measured: off by 5e-6 (reaction) and 6e-6 (loss) with cells of L/200: the interpolant's error.
    """
    a, L = 0.6, 3.0
    points, cells = line(4000, 20 * L)
    points = points - 10 * L
    v = a * np.exp(-((points[:, 0] / L) ** 2))
    moment = {k: a**k * L * np.sqrt(np.pi / k) for k in (2, 3, 4)}
    exact = 100 * (1.1 * moment[3] - moment[4] - 0.1 * moment[2])
    assert reaction_power(points, cells, v, **CELL) == pytest.approx(exact, rel=1e-5)
    loss = 100 * a**2 * np.sqrt(np.pi / 2) / L
    assert diffusion_loss(points, cells, v, diffusivity=100.0) == pytest.approx(loss, rel=1e-5)
    assert sufficient_stretch(points, cells, v, **CELL, diffusivity=100.0) == pytest.approx(
        loss / exact, rel=2e-5
    )


def test_the_bump_of_figure_2_fails_the_condition_as_the_paper_says():
    """Section 6: v = 0.6 on |X| <= 1 "does not satisfy the instability condition (5.2)"; by hand at Δx = 1.

    Half the line: 100 (0.36 · 0.5 · 0.4 + ∫ over the flank) against 100 · 0.36.
    """
    points, cells = line(60, 60.0)
    v = np.where(points[:, 0] <= 1, 0.6, 0.0)
    flank = 1.1 * 0.6**3 / 4 - 0.6**4 / 5 - 0.1 * 0.6**2 / 3
    gain = 100 * (0.072 + flank)
    assert reaction_power(points, cells, v, **CELL) == pytest.approx(gain, rel=1e-12)
    assert diffusion_loss(points, cells, v, diffusivity=100.0) == pytest.approx(36.0, rel=1e-12)
    assert not grows(points, cells, v, **CELL, diffusivity=100.0)
    least = np.sqrt(36.0 / gain)  # 1.96
    assert not grows(points, cells, v, **CELL, diffusivity=100.0, F=[[least * (1 - 1e-9)]])
    assert grows(points, cells, v, **CELL, diffusivity=100.0, F=[[least * (1 + 1e-9)]])


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), dim=st.integers(1, 3), tensor=st.booleans())
def test_the_sufficient_stretch_suffices(seed, dim, tensor):
    """(5.3), (5.4): where λ_min(C) exceeds it, (5.2) holds, for any homogeneous F; and the loss is at most
    ∫ |Grad v|² / λ_min(C)."""
    rng = np.random.default_rng(seed)
    points, cells = cube(dim, 2)
    v = rng.uniform(0.2, 0.9, len(points))  # between alpha and 1: the reaction gives something
    B = rng.normal(size=(dim, dim))
    D = B @ B.T + np.eye(dim) if tensor else 3.0
    F = random_F(rng, dim)
    least = np.linalg.eigvalsh(F.T @ F)[0]
    bound = np.max(np.linalg.eigvalsh(D)) if tensor else D
    loss = diffusion_loss(points, cells, v, F=F, diffusivity=D)
    assert loss <= bound / least * diffusion_loss(points, cells, v) * (1 + 1e-12)
    enough = sufficient_stretch(points, cells, v, **CELL, diffusivity=D)
    F = F * np.sqrt(enough / least * 1.0001)
    assert grows(points, cells, v, **CELL, diffusivity=D, F=F)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), dim=st.integers(2, 3))
def test_a_rotation_of_the_deformed_body_changes_nothing(seed, dim):
    """Objectivity of (5.2): F → Q F leaves the loss, with an isotropic D or with Q D Qᵀ."""
    rng = np.random.default_rng(seed)
    points, cells = cube(dim, 2)
    v, F = rng.normal(size=len(points)), random_F(rng, dim)
    Q = np.linalg.qr(rng.normal(size=(dim, dim)))[0]
    Q[:, 0] *= np.sign(np.linalg.det(Q))
    B = rng.normal(size=(dim, dim))
    D = B @ B.T + np.eye(dim)
    for before, after in ((2.0, 2.0), (D, Q @ D @ Q.T)):
        assert diffusion_loss(points, cells, v, F=Q @ F, diffusivity=after) == pytest.approx(
            diffusion_loss(points, cells, v, F=F, diffusivity=before), rel=1e-10
        )


def test_a_homogeneous_volume_ratio_cancels_on_a_held_line():
    """The line's form, J in front of both sides: held at a homogeneous x′ = J the condition is (5.2)."""
    points, cells = line(40, 40.0)
    for height in np.linspace(0.1, 0.9, 9):
        v = height * np.exp(-((points[:, 0] / 3) ** 2))
        for x in (0.8, 1.0, 1.5):
            arguments = dict(**CELL, diffusivity=100.0, F=[[x]])
            assert grows(points, cells, v, **arguments, J=x) == grows(points, cells, v, **arguments)


WRONG = {
    "points": ({"points": np.zeros(3)}, r"points have the shape"),
    "dimension": ({"points": np.zeros((3, 4))}, r"dim 1, 2 or 3"),
    "cells": ({"cells": [[0, 1]]}, r"cells have the shape"),
    "real cells": ({"cells": [[0.0, 1.0, 2.0]]}, r"integers"),
    "no cells": ({"cells": np.zeros((0, 3), int)}, r"cells have the shape"),
    "node": ({"cells": [[0, 1, 3]]}, r"0 to 3"),
    "negative node": ({"cells": [[0, 1, -1]]}, r"-1 to 1"),
    "v": ({"v": [0.5, 0.5]}, r"v has the shape"),
    "NaN": ({"v": [0.5, np.nan, 0.5]}, r"v must be finite"),
    "infinite": ({"points": [[0.0, 0], [np.inf, 0], [0, 1]]}, r"points must be finite"),
    "degenerate": ({"points": [[0.0, 0], [1, 1], [2, 2]]}, r"cell 0 is degenerate"),
    "twice": ({"cells": [[0, 1, 1]]}, r"cell 0 is degenerate"),
    "J": ({"J": [1.0, 1.0]}, r"J has the shape"),
    "J sign": ({"J": -1.0}, r"J must be positive"),
    "F": ({"F": np.eye(3)}, r"F has the shape"),
    "inverted": ({"F": np.diag([1.0, -1.0])}, r"det F"),
    "F NaN": ({"F": np.full((2, 2), np.nan)}, r"F must be finite"),
    "D": ({"diffusivity": [1.0, 2.0]}, r"D has the shape"),
    "D sign": ({"diffusivity": 0.0}, r"D must be positive"),
    "D asymmetric": ({"diffusivity": [[1.0, 0.5], [0.0, 1.0]]}, r"symmetric"),
    "A": ({"A": 0.0}, r"A must be positive"),
    "alpha": ({"alpha": np.nan}, r"alpha must be finite"),
}


@pytest.mark.parametrize("change, message", WRONG.values(), ids=WRONG.keys())
def test_wrong_arguments_are_refused(change, message):
    """What does not fit is named."""
    good = {"points": [[0.0, 0], [1, 0], [0, 1]], "cells": [[0, 1, 2]], "v": [0.5, 0.6, 0.7], "alpha": 0.1}
    grows(**good)
    with pytest.raises(ValueError, match=message):
        grows(**{**good, **change})


@pytest.mark.parametrize("height", [0.05, 1.4, -0.3, 0.0])
def test_where_the_reaction_gives_nothing_no_stretch_suffices(height):
    """(5.4) divides by the reaction's integral: below α, and above 1, there is no sufficient stretch."""
    points, cells = line(20, 10.0)
    with pytest.raises(ValueError, match="no stretch suffices"):
        sufficient_stretch(points, cells, np.where(points[:, 0] <= 3, height, 0.0), **CELL)
