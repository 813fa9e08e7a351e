"""The coupling: what is refused as ill-posed, the release of an imposed stretch, what is handed over when."""

import myostrain as ms

import numpy as np
import pytest

from coupled import TIGHT, coordinates, gaussian, line

SCHEMES = [ms.Implicit(tolerance=1e-11), ms.Staggered(), ms.SecondOrder()]
each_scheme = pytest.mark.parametrize("scheme", SCHEMES, ids=lambda s: type(s).__name__)

RIGID = dict(held=(1.0, float("inf")))


class Law:
    """A user's own activation law, any γ(v)."""

    drivers = ("potential",)

    def __init__(self, gamma):
        self._gamma = gamma

    def activation(self, states, drivers):
        return self._gamma(drivers["potential"])


def plane_stress(law, constraint, balance="conservative"):
    body = ms.build(ms.geometry.Rectangle(size=(2.0, 2.0)), ms.UniformFibres(direction=(1.0, 0.0)))
    mechanics = ms.Mechanics(
        body,
        kinematics=ms.kinematics.PlaneStress(constraint=constraint),
        material=ms.materials.NeoHookean(),
    )
    potential = ms.Potential(
        body, membrane=ms.membranes.FitzHughNagumo(), balance=balance, deformation=mechanics.deformation
    )
    return ms.Electromechanics(potential, mechanics, law=law)


@pytest.mark.parametrize("beta", [0.5, 0.55, 0.99])
def test_backward_parabolic_line_is_refused(beta):
    """Readings of the model: ∂((1 − βv)v)/∂t = (1 − 2βv) ∂v/∂t, so that "β ≥ 1/2 must be refused there with
    that reason"; the message names the key and the ways out."""
    with pytest.raises(ms.InputError, match=r"activation\.beta.*ill-posed.*advective.*relaxation_time"):
        line(beta=beta)
    data = {
        "geometry": {"kind": "line", "length": 10.0},
        "initial": {"potential": 0.9, "center": [0.0], "radius": 5.0},
        "activation": {"beta": beta},
        "mechanics": {"kinematics": "line", "fixed": ["left"]},
        "time": {"step": 1e-3, "end": 1.0},
    }
    with pytest.raises(ms.InputError, match=r"activation\.beta"):
        ms.Case.from_dict(data).build()


def test_the_limit_of_well_posedness_is_not_the_papers():
    """The paper asks αβ < 1/2 only (after (4.11)), which β = 0.55 meets at α = 0.1; below 1/2 is allowed."""
    assert 0.1 * 0.55 < 0.5
    with pytest.raises(ms.InputError):
        line(beta=0.5)
    line(ms.Implicit(), beta=0.4999)


@pytest.mark.parametrize(
    "allowed",
    [
        dict(balance="advective"),
        dict(relaxation_time=0.01),  # J does not follow v at once
        RIGID,
    ],
    ids=["advective", "viscous", "rigid"],
)
def test_strong_contraction_where_it_is_well_posed(allowed):
    """Reading 8 concerns the conservative line whose J follows v at once, and no other."""
    line(beta=0.9, **allowed)


@pytest.mark.parametrize("change", [{}, dict(held=(1.0, 0.01))], ids=["free", "released"])
def test_a_stretch_that_ends_does_not_make_it_well_posed(change):
    with pytest.raises(ms.InputError, match="ill-posed"):
        line(beta=0.6, **change)


def test_sheet_is_well_posed_where_its_volume_does_not_change():
    """Reading 2: with J = 1 nothing is added to ∂v/∂t, any β < 1 will do; with det Fe = 1, J = 1 + γ."""
    law = ms.activation.Proportional(beta=0.9)
    plane_stress(law, "total")
    plane_stress(law, "elastic", balance="advective")
    with pytest.raises(ms.InputError, match="ill-posed"):
        plane_stress(law, "elastic")


@pytest.mark.parametrize("change", [{}, dict(balance="advective"), RIGID], ids=["free", "advective", "rigid"])
def test_singular_active_deformation_is_always_refused(change):
    """(1.4): det Fo = 1 + γ has to stay positive for v in [0, 1], for a user's own law too."""
    for beta in (1.0, 1.5, -0.1):
        with pytest.raises(ValueError, match="beta"):
            ms.activation.Proportional(beta=beta)
    for gamma in (lambda v: -v, lambda v: -1.2 * v**2, lambda v: -4.4 * v * (1 - v)):
        with pytest.raises(ms.InputError, match="singular"):
            line(law=Law(gamma), **change)
    with pytest.raises(ms.InputError, match="singular"):
        plane_stress(Law(lambda v: -v), "total")


@pytest.mark.parametrize(
    "gamma, accepted",
    [
        (lambda v: -0.45 * v, True),
        (lambda v: -0.55 * v, False),
        (lambda v: -0.3 * v**2, True),  # 1 − 3·0.3 v² > 0
        (lambda v: -0.35 * v**2, False),  # 1 − 3·0.35 v² < 0 near v = 1
        (lambda v: 0.5 * v, True),  # extends
        (lambda v: -0.6 * v * (1 - v), True),  # 1 − 0.6 (2v − 3v²) ≥ 0.8
        (lambda v: -3.3 * v * (1 - v), False),  # at v = 1/3, though neither singular nor so at v = 1
    ],
)
def test_a_users_own_law_is_checked(gamma, accepted):
    """Reading 8 for any γ(v): (1 + γ(v)) v has to grow with v."""
    v = np.linspace(0, 1, 2001)
    assert (np.diff((1 + gamma(v)) * v) > 0).all() == accepted  # the row above says what is true
    if accepted:
        line(ms.Implicit(), law=Law(gamma))
    else:
        with pytest.raises(ms.InputError, match="ill-posed"):
            line(ms.Implicit(), law=Law(gamma))


def test_a_law_in_numpy_runs():
    """A law of NumPy's functions, J = 1 + γ at the nodes."""
    model = line(law=Law(lambda v: -0.2 * np.tanh(v)), length=10.0)
    model.start()
    v = model.potential.v.x.array
    np.testing.assert_allclose(model.mechanics.activation.x.array, -0.2 * np.tanh(v), rtol=1e-14)
    np.testing.assert_allclose(model.potential.ratio, 1 - 0.2 * np.tanh(v), rtol=0, atol=1e-3)  # 2e-4


# The release of an imposed stretch.


def rigid_twin(scheme, balance, steps, h, initial):
    """The fields on the line held at x′ = 1 for ever, after some steps."""
    model = line(scheme, balance=balance, initial=initial, **RIGID)
    model.start()
    for number in range(1, steps + 1):
        model.step(number * h)
    return [values.copy() for values in model.potential.field_values().values()]


@pytest.mark.parametrize("steps", [1, 3])
@pytest.mark.parametrize("balance", ["conservative", "advective"])
@each_scheme
def test_release_is_a_jump_at_its_time(scheme, balance, steps):
    """Figure 2 and docs/model/readings.md: held at x′ = 1 for 0 < t < until, then free in no time.

    Until then the line is the rigid line.  The release conserves Jv and Jw at every point (conservative), so
    that (1 − βv) v = v_held, or keeps v and w (advective).
    """
    beta, h = 0.3, 2e-3
    initial = lambda X: gaussian(X, 0.5)  # noqa: E731
    v, w = rigid_twin(scheme, balance, steps, h, initial)
    if balance == "conservative":
        held = v
        v = 2 * held / (1 + np.sqrt(1 - 4 * beta * held))
        w = w / (1 - beta * v)
    model = line(scheme, balance=balance, held=(1.0, steps * h), initial=initial)
    model.start()
    for number in range(1, steps + 1):
        np.testing.assert_allclose(model.potential.ratio, 1.0, rtol=0, atol=1e-13)
        model.step(number * h)
    found = list(model.potential.field_values().values())
    # Measured 2e-11, from the tolerances of the fixed points (1e-11, 1e-10).
    np.testing.assert_allclose(found[0], v, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found[1], w, rtol=0, atol=1e-9)
    np.testing.assert_allclose(model.potential.ratio, 1 - beta * v, rtol=0, atol=1e-9)
    assert np.abs(model.mechanics.u.x.array).max() > 0.5


@each_scheme
def test_a_viscous_line_does_not_jump_when_released(scheme):
    """(4.14): the dashpot keeps x′ at the release, so v, w and u are those of the rigid line just then."""
    h, steps = 2e-3, 3
    initial = lambda X: gaussian(X, 0.5)  # noqa: E731
    v, w = rigid_twin(scheme, "conservative", steps, h, initial)
    model = line(scheme, relaxation_time=0.08, held=(1.0, steps * h), initial=initial)
    model.start()
    for number in range(1, steps + 1):
        model.step(number * h)
    found = list(model.potential.field_values().values())
    np.testing.assert_allclose(found[0], v, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found[1], w, rtol=0, atol=1e-9)
    np.testing.assert_allclose(model.mechanics.u.x.array, 0.0, rtol=0, atol=1e-12)
    model.step((steps + 1) * h)
    assert np.abs(model.mechanics.u.x.array).max() > 1e-3


def test_release_without_an_equilibrium_is_an_error():
    """(1 − βv) v = J v has no solution for 4 β x′ v > 1: the message says so, with the time."""
    model = line(ms.SecondOrder(), held=(1.0, 2e-3), initial=lambda X: np.full_like(X, 0.9))
    model.start()
    with pytest.raises(ms.ComputationError, match="4 β v x′ > 1") as caught:
        model.step(2e-3)
    assert caught.value.time == 2e-3


@pytest.mark.parametrize("value", [1.0, 1.2])
def test_a_body_held_for_ever_is_a_rigid_one(value):
    """Interface: imposed_stretch until inf; x′ = s scales lengths: D/s² in X, the balance by J cancels."""
    held = line(ms.SecondOrder(), held=(value, float("inf")))
    rigid = ms.Potential(
        held.potential.body,
        membrane=ms.membranes.FitzHughNagumo(),
        diffusivity=100.0 / value**2,
        options=TIGHT,
    )
    rigid.v.x.array[:] = gaussian(coordinates(rigid)[:, 0])
    twin = ms.Electromechanics(rigid, None, scheme=ms.SecondOrder())
    for model in (held, twin):
        model.start()
        for number in range(1, 21):
            model.step(number * 1e-3)
    twins = twin.potential.field_values()
    for name, values in held.potential.field_values().items():
        np.testing.assert_allclose(values, twins[name], rtol=0, atol=1e-12)


# The fixed point and stability.


def test_implicit_step_satisfies_the_coupled_equations():
    """Section 7: "first order implicit ... fixed-point treatment": it solves the coupled step to tolerance.

    By a residual on the nodes, written by hand: (J v − J₀v₀)/h + diffusion + A J (f(v) + w) with J = 1 − βv.
    """
    h, beta, alpha, tau = 1e-3, 0.3, 0.1, 0.2
    model = line(ms.Implicit(tolerance=1e-12), beta=beta)
    order = np.argsort(coordinates(model.potential)[:, 0])
    model.start()
    v0 = model.potential.v.x.array[order]
    model.step(h)
    v, w = (values[order] for values in model.potential.field_values().values())
    J0, J = 1 - beta * v0, 1 - beta * v
    weight = np.ones_like(v)
    weight[[0, -1]] = 0.5
    flux = 100.0 * np.diff(v) * 2 / (J[1:] + J[:-1])
    divergence = np.diff(np.concatenate([[0.0], flux, [0.0]]))
    reaction = 100.0 * J * (v * (v - alpha) * (v - 1) + w)
    residual = (J * v - J0 * v0) / h - divergence / weight + reaction
    # Of terms of size 100: measured 9e-11.
    assert np.abs(residual).max() < 1e-8
    np.testing.assert_allclose((J * w) / h - J * (v - w / tau), 0.0, rtol=0, atol=1e-11)


def test_the_fixed_point_says_when_it_does_not_converge():
    """Design: "Failure is an exception that names ... the solver's reason and what to try"."""
    model = line(ms.Implicit(tolerance=1e-13, max_iterations=2))
    model.start()
    with pytest.raises(ms.ComputationError, match=r"2 fixed-point iterations.*wanted 1e-13"):
        model.step(1e-3)


@each_scheme
def test_what_is_accepted_is_stable(scheme):
    """Where the conservative line is well-posed (reading 8) a scheme runs, or is refused with a reason.

    Close to the limit, β = 0.45: v = 1 is the excited state, and stays so.
    """
    try:
        model = line(
            scheme, beta=0.45, membrane=ms.membranes.FitzHughNagumo(recovery=False), initial=np.ones_like
        )
    except ms.InputError:
        return
    model.potential.v.x.array[:] -= 1e-6 * np.cos(coordinates(model.potential)[:, 0])
    model.start()
    for number in range(1, 201):
        model.step(number * 1e-3)
    assert np.abs(model.potential.v.x.array - 1).max() < 1e-6
