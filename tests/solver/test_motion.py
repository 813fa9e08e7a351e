"""Inertia and dampers: against closed forms, an independent generalised-α of an oscillator, and SciPy."""

import myostrain as ms
from myostrain.engine import compile_form, fem
from myostrain.kinematics import Line, PlaneStrain, PlaneStress, Solid
from myostrain.materials import NeoHookean, Spring

import numpy as np
import pytest
from scipy.integrate import solve_ivp

RHO, MU, LENGTH = 2.0, 3.0, 4.0
OMEGA = np.pi / (2 * LENGTH) * np.sqrt(MU / RHO)


def bar(radius=2 / 3, spacing=0.25, damping=None, density=RHO):
    """A linear spring, held at its left end: sin(k X) sin(ω t) is a motion."""
    body = ms.build(ms.geometry.Line(length=LENGTH, spacing=spacing))
    mechanics = ms.Mechanics(
        body,
        kinematics=Line(),
        material=Spring(mu=MU),
        supports=ms.Supports(fixed=("left",), damping=damping or {}),
        density=density,
        spectral_radius=radius,
        tolerance=1e-13,
    )
    mechanics.start(0.0)
    return mechanics


def mode(mechanics):
    X = mechanics.u.function_space.tabulate_dof_coordinates()[:, 0]
    return np.sin(np.pi / (2 * LENGTH) * X)


def advance(mechanics, step, steps, each=lambda: None):
    start = mechanics.history.times[0]
    found = []
    for i in range(1, steps + 1):
        mechanics.solve(start + i * step)
        mechanics.accept(start + i * step)
        found.append(each())
    return np.array(found)


@pytest.mark.parametrize("radius", [0.0, 2 / 3, 1.0])
def test_order_of_an_oscillating_bar(radius):
    """Second order in the step, displacement and velocity, over half a period; measured 1.97 to 2.03."""
    errors = []
    for steps in (20, 40, 80):
        mechanics = bar(radius, spacing=0.1)
        shape = mode(mechanics)
        mechanics.motion.moving.x.array[:] = shape
        step = np.pi / OMEGA / steps
        times = step * np.arange(1, steps + 1)
        u = advance(mechanics, step, steps, lambda m=mechanics: m.u.x.array.copy())
        off = np.abs(u - np.outer(np.sin(OMEGA * times) / OMEGA, shape)).max() * OMEGA
        errors.append([off, np.abs(mechanics.motion.moving.x.array + shape).max()])
    rates = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
    assert errors[-1][0] < 5e-3
    assert np.all((rates[-1] > 1.85) & (rates[-1] < 2.15)), (errors, rates)


def oscillator(omega, step, steps, radius):
    """u of ü = −ω² u, u(0) = 0, u̇(0) = 1: Chung and Hulbert's equation, mean of accelerations and mean of
    displacements, after a first implicit step; by hand, in the order of their paper."""
    alpha_m, alpha_f = (2 * radius - 1) / (radius + 1), radius / (radius + 1)
    gamma = 0.5 - alpha_m + alpha_f
    beta = (1 - alpha_m + alpha_f) ** 2 / 4
    u = step / (1 + (omega * step) ** 2)
    v, a, found = u / step, -(omega**2) * u, [u]
    for _ in range(steps - 1):
        known = u + step * v + step**2 * (0.5 - beta) * a
        right = -(omega**2) * ((1 - alpha_f) * known + alpha_f * u) - alpha_m * a
        after = right / ((1 - alpha_m) + omega**2 * (1 - alpha_f) * beta * step**2)
        u = known + step**2 * beta * after
        v += step * ((1 - gamma) * a + gamma * after)
        a = after
        found.append(u)
    return np.array(found)


@pytest.mark.parametrize("radius, per_period", [(2 / 3, 12), (0.0, 12), (1.0, 12), (2 / 3, 1 / 50)])
def test_the_method_is_that_of_chung_and_hulbert(radius, per_period):
    """A linear body takes the steps of an oscillator by their method, to round-off; also those far too long
    for its period, of which a share ρ∞ is left after each."""
    mechanics = bar(radius, spacing=2.0)
    # The first mode of the mesh, by its own matrices: of two quadratic elements.
    K, M = stiffness_and_mass(mechanics)
    values, modes = (found.real for found in np.linalg.eig(np.linalg.solve(M, K)))
    first = np.argmin(values)
    omega, shape = np.sqrt(values[first]), modes[:, first]
    mechanics.motion.moving.x.array[1:] = shape
    step, at = 2 * np.pi / omega / per_period, np.argmax(np.abs(shape))
    u = advance(mechanics, step, 12, lambda: mechanics.u.x.array[1 + at] / shape[at])
    exact = oscillator(omega, step, 12, radius)
    np.testing.assert_allclose(u, exact, rtol=0, atol=1e-9 * np.abs(exact).max())
    if per_period < 1:
        # The three roots of the step coincide at −ρ∞.
        left = np.convolve(u, [1, 3 * radius, 3 * radius**2, radius**3], "valid")
        np.testing.assert_allclose(left, 0, atol=1e-3 * np.abs(u[3:]).max())


def stiffness_and_mass(mechanics):
    """Of a line's free nodes, in their order, by NumPy: ∫ μ φ′ψ′ and ∫ ρ φψ of quadratic elements."""
    X = mechanics.u.function_space.tabulate_dof_coordinates()[:, 0]
    assert X[0] == 0.0
    K, M = np.zeros((2, len(X), len(X)))
    order = np.argsort(X)
    k = np.array([[7, -8, 1], [-8, 16, -8], [1, -8, 7]]) / 3
    m = np.array([[4, 2, -1], [2, 16, 2], [-1, 2, 4]]) / 30
    for i in range(0, len(X) - 2, 2):
        nodes = order[i : i + 3]
        h = X[nodes[2]] - X[nodes[0]]
        K[np.ix_(nodes, nodes)] += MU * k / h
        M[np.ix_(nodes, nodes)] += RHO * m * h
    return K[1:, 1:], M[1:, 1:]


def test_a_strongly_nonlinear_bar():
    """Order two where forces are far from linear: a bar whose stiffness grows fivefold, beside SciPy's
    solution of its nodal equations, with the forces by NumPy; measured 1.96."""

    class Stiffening:
        tensor_dim = 1

        def energy(self, Fe, fibres):
            e = Fe[0, 0] - 1
            return MU / 2 * e**2 * (1 + 8 * e**2)

    body = ms.build(ms.geometry.Line(length=LENGTH, spacing=LENGTH / 2))
    gauss, weights = np.array([-1, 1]) / np.sqrt(3), np.ones(2)
    errors = []
    for steps in (40, 80, 160):
        mechanics = ms.Mechanics(
            body,
            kinematics=Line(),
            material=Stiffening(),
            supports=ms.Supports(fixed=("left",)),
            density=RHO,
            tolerance=1e-12,
        )
        mechanics.start(0.0)
        order = np.argsort(mechanics.u.function_space.tabulate_dof_coordinates()[:, 0])
        slopes = np.stack([gauss - 0.5, -2 * gauss, gauss + 0.5], axis=1) / (LENGTH / 4)  # of φ at the points

        def force(u, order=order, slopes=slopes):
            whole = np.zeros_like(u)
            for i in (0, 2):
                nodes = order[i : i + 3]
                e = slopes @ u[nodes]
                whole[nodes] += slopes.T @ (weights * MU * (e + 16 * e**3)) * LENGTH / 4
            return whole

        _, M = stiffness_and_mass(mechanics)
        speed = 0.5 * mode(mechanics)
        mechanics.motion.moving.x.array[:] = speed
        n = len(speed)

        def rate(t, y, n=n, M=M, force=force):
            acceleration = np.zeros(n)
            acceleration[1:] = -np.linalg.solve(M, force(y[:n])[1:])
            return np.concatenate([y[n:], acceleration])

        end = 3.0
        begin = np.concatenate([np.zeros(n), speed])
        exact = solve_ivp(rate, (0, end), begin, "DOP853", rtol=1e-11, atol=1e-12).y[:n, -1]
        advance(mechanics, end / steps, steps)
        errors.append(np.abs(mechanics.u.x.array - exact).max())
    assert np.abs(exact).max() > 0.2
    rates = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
    assert 1.8 < rates[-1] < 2.2, (errors, rates)


def energy(mechanics):
    """Kinetic and stored energy together."""
    equations, a = mechanics._active, mechanics.activation
    stored = compile_form(equations.stored(equations.lifted(mechanics.u, a), a) * mechanics.dx)
    return lambda: mechanics.motion.kinetic_energy() + fem.assemble_scalar(stored)


#: ρ∞, what two periods of the slow mode leave of a rough motion's energy at most, and take of the mode's.
KEPT = [(1.0, 1.0, 0.0), (0.9, 0.95, 1e-4), (2 / 3, 0.6, 1e-3), (0.0, 0.15, 0.04)]


@pytest.mark.parametrize("radius, left, taken", KEPT)
def test_energy_of_a_free_vibration(radius, left, taken):
    """A linear bar keeps its energy with ρ∞ = 1, whatever its motion, to round-off; with less it loses that
    of fast parts, and hardly any of the slow mode."""
    mechanics, step = bar(radius), 0.02 * 2 * np.pi / OMEGA
    rough = np.random.default_rng(3).standard_normal(len(mechanics.u.x.array))
    rough[0] = 0.0
    mechanics.motion.moving.x.array[:] = rough
    found = advance(mechanics, step, 100, energy(mechanics))
    slow = bar(radius)
    slow.motion.moving.x.array[:] = mode(slow)
    mild = advance(slow, step, 100, energy(slow))
    if radius == 1:
        assert max(np.ptp(found) / found[0], np.ptp(mild) / mild[0]) < 1e-10
    else:
        assert found[-1] < left * found[0]
        assert -taken < mild[-1] / mild[0] - 1 < 0


def test_a_matched_damper_swallows_a_wave():
    """d'Alembert: with c = √(ρ μ) at its free end a bar has no reflection there: after 2 L/√(μ/ρ) it is at
    rest; with no damper its energy is what it was, and with 3 c a quarter of it is left (reflection 1/2)."""
    speed, impedance = np.sqrt(MU / RHO), np.sqrt(RHO * MU)
    for factor, share in ((1.0, 0.0), (3.0, 0.25)):
        mechanics = bar(spacing=0.1, damping={"right": factor * impedance})
        X = mechanics.u.function_space.tabulate_dof_coordinates()[:, 0]
        mechanics.motion.moving.x.array[:] = np.sin(np.pi * X / LENGTH) ** 4
        begin = mechanics.motion.kinetic_energy()
        steps = 400
        advance(mechanics, 2 * LENGTH / speed / steps, steps)
        assert energy(mechanics)() / begin == pytest.approx(share, abs=2e-3)


@pytest.mark.parametrize("order, band", [(1, (0.95, 1.05)), (2, (1.9, 2.1))])
def test_a_damped_bar_without_inertia(order, band):
    """μ u/L + c u̇ = t: u = (t L/μ)(1 − exp(−μ s/(c L))); what holds it bears the rest."""
    c, pull, errors = 1.7, 0.3, []
    for steps in (60, 120):
        mechanics = ms.Mechanics(
            ms.build(ms.geometry.Line(length=LENGTH, spacing=1.0)),
            kinematics=Line(),
            material=Spring(mu=MU),
            supports=ms.Supports(fixed=("left",), damping={"right": c}),
            loads=ms.Loads(traction={"right": (pull,)}),
            tolerance=1e-13,
        )
        mechanics.start(0.0)
        assert np.abs(mechanics.u.x.array).max() == 0
        times = 3.0 * np.arange(1, steps + 1) / steps
        found = []
        for t in times:
            mechanics.solve(t, order=order)
            mechanics.accept(t)
            found.append(mechanics.u.x.array.max())
        exact = pull * LENGTH / MU * (1 - np.exp(-MU * times / (c * LENGTH)))
        errors.append(np.abs(found - exact).max())
        forces = mechanics.reactions.values()
        assert sum(forces.values()) == pytest.approx(-pull, abs=1e-10)
        assert forces["reaction_right_x"] == pytest.approx(-(pull - MU * exact[-1] / LENGTH), rel=2e-2)
    assert band[0] < np.log2(errors[0] / errors[1]) < band[1]


@pytest.mark.parametrize("kinematics", [Solid(), Solid(bulk_modulus=100.0)], ids=["mixed", "one field"])
def test_a_free_body_falls(kinematics):
    """Nothing holds a body with inertia, and nothing has to: g t²/2 + v t, without deformation."""
    body = ms.build(ms.geometry.Slab(size=(1.0, 1.0, 1.0), spacing=1.0), ms.UniformFibres((1, 0, 0)))
    g, v = np.array([0.0, 0.3, -1.0]), np.array([0.4, 0.0, 0.1])
    weight = fem.Constant(body.mesh, RHO * g)
    mechanics = ms.Mechanics(
        body, kinematics=kinematics, material=NeoHookean(), loads=ms.Loads(body_force=weight), density=RHO
    )
    mechanics.start(0.0)
    moving = mechanics.motion.moving
    part = moving.sub(0) if kinematics.has_pressure else moving
    part.interpolate(lambda x: np.outer(v, np.ones(x.shape[1])))
    advance(mechanics, 0.05, 20)
    u = mechanics.displacement().x.array.reshape(-1, 3)
    # The first step, of first order, is g h²/2 ahead.
    np.testing.assert_allclose(u, np.tile(g / 2 * (1 + 0.05**2) + v, (len(u), 1)), atol=1e-7)


def test_dampers_along_the_normal():
    """A nearly rigid block between two dampers along their normals: ρ A v̇ = −2 c H v across, and along them
    it goes on as it was."""
    body = ms.build(ms.geometry.Rectangle(size=(2.0, 1.0), spacing=1.0), ms.UniformFibres(direction=(1, 0)))
    c = 0.8
    mechanics = ms.Mechanics(
        body,
        kinematics=PlaneStress(),
        material=NeoHookean(mu=1e4),
        supports=ms.Supports(damping_normal={"left": c, "right": c}),
        density=RHO,
    )
    mechanics.start(0.0)
    mechanics.motion.moving.x.array[:] = 1.0
    advance(mechanics, 0.02, 100)
    v = mechanics.motion.moving.x.array.reshape(-1, 2)
    np.testing.assert_allclose(v[:, 0], np.exp(-2 * c * 1.0 / (RHO * 2.0) * 2.0), rtol=1e-3)
    np.testing.assert_allclose(v[:, 1], 1.0, atol=1e-5)


def test_viscosity_is_the_relaxation_time_by_another_name():
    """η = 2 λ μ: the same steps, to round-off."""
    found = []
    for given in (dict(relaxation_time=0.3), dict(viscosity=2 * 0.3 * 2.5)):
        body = ms.build(ms.geometry.Rectangle(size=(2.0, 1.0), spacing=1.0), ms.UniformFibres((1, 0)))
        mechanics = ms.Mechanics(body, kinematics=PlaneStrain(), material=NeoHookean(mu=2.5), **given)
        mechanics.start(0.0)
        mechanics.activation.x.array[:] = -0.2
        advance(mechanics, 0.1, 3)
        found.append(mechanics.u.x.array.copy())
    np.testing.assert_allclose(*found, atol=1e-12)
    assert np.abs(found[0]).max() > 0.05


WRONG = [
    (dict(density=-1.0), "mechanics.density", "greater than or equal to 0"),
    (dict(spectral_radius=1.5), "mechanics.spectral_radius", "less than or equal to 1"),
    (dict(viscosity=1.0, relaxation_time=1.0), "mechanics.viscosity", "give one of the two"),
    (dict(supports=ms.Supports(damping={"left": 1.0})), "mechanics.damping.left", "density > 0"),
    (
        dict(supports=ms.Supports(fixed=("left",), damping_normal={"top": 1.0})),
        "mechanics.damping_normal.top",
        "left",
    ),
]


@pytest.mark.parametrize("given, key, says", WRONG, ids=[key for _, key, _ in WRONG])
def test_what_does_not_fit_is_refused(given, key, says):
    """Each message names its key, and what is allowed."""
    body = ms.build(ms.geometry.Line(length=LENGTH, spacing=1.0))
    with pytest.raises(ms.InputError) as error:
        ms.Mechanics(body, kinematics=Line(), material=Spring(), **given)
    assert str(error.value).startswith(key)
    assert says in str(error.value)
