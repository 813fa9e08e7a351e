"""The active line in equilibrium: closed forms of section 4 with every kind of support, to round-off."""

import myostrain as ms
from myostrain.kinematics import Line
from myostrain.materials import Spring

import numpy as np
import pytest
import ufl

from mechanics_tools import described, random_activation

LENGTH, MU, BETA = 8.0, 2.5, 0.4
# Stiffness of the support at the left and right end; zero is a free end, infinity a fixed one.
SUPPORTS = {
    "free": (0.0, 0.0, {}),
    "fixed left": (np.inf, 0.0, dict(fixed=["left"])),
    "fixed right": (0.0, np.inf, dict(fixed=["right"])),
    "fixed both": (np.inf, np.inf, dict(fixed=["left", "right"])),
    "robin both": (0.7, 0.7, dict(robin=0.7)),
    "robin left": (0.7, 0.0, dict(robin=0.7, robin_boundary=["left"])),
    "robin right": (0.0, 0.7, dict(robin=0.7, robin_boundary=["right"])),
    "fixed left, robin right": (np.inf, 1.3, dict(fixed=["left"], robin=1.3, robin_boundary=["right"])),
}


def make(**parts):
    body = ms.build(ms.geometry.Line(length=LENGTH, spacing=0.5))
    return ms.Mechanics(
        body,
        kinematics=Line(),
        material=Spring(mu=MU),
        **described(parts),
    )


def vertices(mechanics):
    """Positions and γ at the mesh nodes, and the index that sorts them."""
    X = mechanics.activation.function_space.tabulate_dof_coordinates()[:, 0]
    order = np.argsort(X)
    return X[order], mechanics.activation.x.array[order], order


def displacement(mechanics, X):
    """Displacement at the mesh nodes X, which are degrees of freedom of the quadratic elements."""
    x = mechanics.u.function_space.tabulate_dof_coordinates()[:, 0]
    order = np.argsort(x)
    return mechanics.u.x.array[order][::2]


@pytest.mark.parametrize("left, right, parts", SUPPORTS.values(), ids=SUPPORTS.keys())
def test_supported_line(left, right, parts):
    """(4.2), (4.3), (7.8): x′ = (1 + γ)(1 + P/μ), P the same everywhere, −P/k the displacement of a right
    end on a spring, P/k of a left one; so (1 + P/μ) ∫(1 + γ) = L − P (1/k₀ + 1/k₁). Free ends: P = 0, x′
    = 1 + γ. Isometric: P = μ (1/(1 + γ) − 1) with the mean of γ. Exact for γ linear in each
    cell.
    """
    mechanics = make(**parts)
    random_activation(mechanics, BETA)
    X, gamma, _ = vertices(mechanics)
    mechanics.start()

    active = np.concatenate([[0.0], np.cumsum(np.diff(X) * (1 + (gamma[1:] + gamma[:-1]) / 2))])
    with np.errstate(divide="ignore"):
        compliance = np.float64(1) / left + np.float64(1) / right
    P = (LENGTH - active[-1]) / (active[-1] / MU + compliance)
    x = (1 + P / MU) * active
    if left > 0:
        x += P / left
    elif right > 0:
        x += LENGTH - P / right - x[-1]
    # Measured 3e-15 at most; displacement and stress are of order one.
    np.testing.assert_allclose(displacement(mechanics, X), x - X, rtol=0, atol=1e-12)
    np.testing.assert_allclose(mechanics.stress_trace(), P, rtol=0, atol=1e-12)


def test_isometric_line():
    """README, closed forms, on a line: P = μ (1/(1 + γ) − 1) at x′ = 1."""
    mechanics = make(fixed=["left", "right"])
    mechanics.activation.x.array[:] = -BETA * 0.5
    mechanics.start()
    np.testing.assert_allclose(mechanics.u.x.array, 0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(mechanics.stress_trace(), MU * (1 / 0.8 - 1), rtol=1e-13)


def test_hanging_line():
    """P′ + b = 0 with a dead load b: P = b (L − X), x′ = (1 + γ)(1 + P/μ), quadratic for uniform γ, hence
    exact.
    """
    body = ms.build(ms.geometry.Line(length=LENGTH, spacing=0.5))
    b = 0.2
    mechanics = ms.Mechanics(
        body,
        kinematics=Line(),
        material=Spring(mu=MU),
        supports=ms.Supports(fixed=["left"]),
        loads=ms.Loads(body_force=ufl.as_vector([b])),
    )
    mechanics.activation.x.array[:] = -BETA * 0.75
    mechanics.start()
    X = vertices(mechanics)[0]
    x = 0.7 * (X + b / MU * (LENGTH * X - X**2 / 2))
    np.testing.assert_allclose(displacement(mechanics, X), x - X, rtol=0, atol=1e-12)  # measured 1e-15


@pytest.mark.parametrize("length, spacing", [(1e-3, 1e-4), (1e3, 25.0)])
def test_units_are_free(length, spacing):
    """Interface: a case may have units; the support of a free or fixed line does not depend on their
    size.
    """
    body = ms.build(ms.geometry.Line(length=length, spacing=spacing))
    parts = dict(kinematics=Line(), material=Spring(mu=MU), fixed=["right"])
    mechanics = ms.Mechanics(
        body,
        **described(parts),
    )
    mechanics.activation.x.array[:] = -BETA
    mechanics.start()
    X = vertices(mechanics)[0]
    np.testing.assert_allclose(displacement(mechanics, X), BETA * (length - X), rtol=0, atol=1e-12 * length)


def test_start_states():
    """Readings of the model: an elastic body starts contracted, J(0) = 1 + γ(v(0)), unless the stretch is
    imposed; a viscous one starts relaxed (Mechanics.start).
    """
    elastic = make(fixed=["left"])
    viscous = make(fixed=["left"], relaxation_time=0.3)
    held = make(fixed=["left"], imposed_stretch=ms.ImposedStretch(value=1.2, until=0.5))
    for mechanics, stretch in ((elastic, 1 - BETA), (viscous, 1.0), (held, 1.2)):
        mechanics.activation.x.array[:] = -BETA
        mechanics.start()
        X = vertices(mechanics)[0]
        np.testing.assert_allclose(displacement(mechanics, X), (stretch - 1) * X, rtol=0, atol=1e-12)


def test_imposed_stretch_holds_until_its_time():
    """ImposedStretch: holds the body for t < until, no matter what is solved for; then the body is let
    go.
    """
    mechanics = make(robin=0.7, imposed_stretch=ms.ImposedStretch(value=1.0, until=0.3))
    mechanics.activation.x.array[:] = -BETA
    mechanics.start()
    assert mechanics.held(0.0)
    assert mechanics.held(0.2)
    assert not mechanics.held(3 * 0.1)  # 0.30000000000000004 and the like are the end
    assert not mechanics.held(0.3 * (1 - 1e-12))
    mechanics.solve(0.2)
    assert not mechanics.u.x.array.any()
    mechanics.solve(0.3)
    free = make(robin=0.7)
    free.activation.x.array[:] = -BETA
    free.start()
    assert np.abs(free.u.x.array).max() > 0.1
    np.testing.assert_allclose(mechanics.u.x.array, free.u.x.array, rtol=0, atol=1e-12)
    assert make(imposed_stretch=ms.ImposedStretch(), robin=1.0).held(1e300)


@pytest.mark.parametrize("gamma", [-1.0, -1.5])
@pytest.mark.parametrize("parts", [dict(fixed=["left"]), dict(robin=0.7)], ids=["fixed", "robin"])
def test_inverted_line_is_an_error(gamma, parts):
    """Mechanics.solve: ComputationError where the body is inverted; x′ = 1 + γ ≤ 0 is no deformation
    (1.1).
    """
    mechanics = make(**parts)
    mechanics.start()
    mechanics.activation.x.array[:] = gamma
    with pytest.raises(ms.ComputationError):
        mechanics.solve(1.0)


def test_accepting_what_a_start_has_accepted_changes_nothing():
    """Mechanics.accept right after start, which accepts itself: the next step is what it is without."""
    found = []
    for twice in (False, True):
        mechanics = make()
        mechanics.activation.x.array[:] = -0.1
        mechanics.start()
        if twice:
            mechanics.accept(0.0)
        mechanics.activation.x.array[:] = -0.2
        mechanics.solve(0.1)
        mechanics.accept(0.1)
        mechanics.hand_over(0.2, order=1)
        found.append(mechanics.handed.u.x.array.copy())
    np.testing.assert_array_equal(found[1], found[0])
    assert np.isfinite(found[0]).all()
