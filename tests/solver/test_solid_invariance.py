"""Solids know no frame, push themselves nowhere, and have the tangent of their residual: every export."""

import functools
import itertools

import myostrain as ms
from myostrain.activation import Fibre, FibreTension, Orthotropic
from myostrain.engine import compile_form, fem
from myostrain.geometry import Body, Microstructure
from myostrain.kinematics import Solid
from myostrain.materials import NeoHookean

import numpy as np
import pytest
import ufl
from dolfinx.fem import petsc as fem_petsc

from solid_tools import (
    CONSTRAINTS,
    DEFORMATIONS,
    SOLID_MATERIALS,
    TENSIONS,
    Parts,
    Solids,
    block,
    quick_kernels,
    random_rotation,
    recorded,
    rotated,
)

MATERIAL_NAMES = [cls.__name__ for cls in SOLID_MATERIALS]
COMBINATIONS = list(
    itertools.product(MATERIAL_NAMES, [cls.__name__ for cls in [*DEFORMATIONS, *TENSIONS]], CONSTRAINTS)
)
MU = 1.7


class Everything:
    """A body of 12 distorted tetrahedra of every material and constraint, and its forms.

    Of every active deformation, or of every active tension.
    """

    def __init__(self, actives):
        self.solids = Solids(block(distortion=0.1), [c() for c in SOLID_MATERIALS], actives)
        mechanics = self.solids.mechanics
        self.vector, self.tangent = mechanics.solver._residual, mechanics.solver._tangent
        with quick_kernels():
            equations, activation = mechanics._active, mechanics.activation
            stored = equations.stored(equations.lifted(mechanics.u, activation), activation)
            self.energy = compile_form(stored * mechanics.dx)

    def at_random(self, *combination):
        """A random state of a random activation: |Grad u| up to a fifth, p about one."""
        mechanics = self.solids.choose(*combination)
        rng = np.random.default_rng(21)
        a, parts = mechanics.activation.x.array, self.solids.parts
        a[:] = rng.uniform(0.1, 0.5, len(a)) * (-0.5 if mechanics.yields == "strain" else 1.5)
        parts.put(0.03 * rng.uniform(-1, 1, parts.u.shape), 1 + 0.3 * rng.uniform(-1, 1, parts.p.shape))
        return mechanics, parts


@functools.cache
def straining():
    return Everything([c() for c in DEFORMATIONS])


@functools.cache
def pulling():
    return Everything([c() if c is not FibreTension else c(transverse=0.3) for c in TENSIONS])


def everything(combination):
    """That which has the combination's activation."""
    return straining() if combination[1] in [cls.__name__ for cls in DEFORMATIONS] else pulling()


@pytest.mark.parametrize("combination", COMBINATIONS, ids="-".join)
def test_tangent_is_the_derivative_of_the_residual(combination):
    """Issue: "Tangents by finite differences for every material, activation and constraint": of the matrix
    that Newton factorizes, for every export, active strains and active tensions, on distorted tetrahedra;
    it is symmetric, as that of an energy is.
    """
    every = everything(combination)
    mechanics, _ = every.at_random(*combination)
    unknown = mechanics.u.x.array
    state, direction = unknown.copy(), np.random.default_rng(3).uniform(-1, 1, len(unknown))
    matrix = fem_petsc.assemble_matrix(every.tangent)
    matrix.assemble()
    product, d = matrix.createVecLeft(), matrix.createVecRight()
    d.array[:] = direction
    matrix.mult(d, product)

    def at(h):
        unknown[:] = state + h * direction
        return fem.assemble_vector(every.vector).array

    h = 1e-5
    rate = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)
    unknown[:] = state
    scale = np.abs(product.array).max()
    np.testing.assert_allclose(rate, product.array, rtol=0, atol=1e-9 * scale)  # measured 4e-11
    assert matrix.isSymmetric(1e-12 * scale)


@pytest.mark.parametrize("combination", COMBINATIONS, ids="-".join)
def test_forces_of_a_body_balance_and_turn_with_it(combination):
    """Issue: "Objectivity. Zero net force and moment on a free body". At any state, of equilibrium or not,
    the nodal forces have neither sum nor moment about the origin (x × force: a rotation of the body is among
    its displacements); and the body turned in space has the same energy, turned forces, the same volumes.
    """
    every = everything(combination)
    _, parts = every.at_random(*combination)
    u, p = parts.u, parts.p
    forces, volumes = parts.forces()
    scale, energy = np.abs(forces).max(), fem.assemble_scalar(every.energy)
    assert scale > 0.05
    np.testing.assert_allclose(forces.sum(0), 0, rtol=0, atol=1e-13 * scale)  # measured 4e-15
    np.testing.assert_allclose(np.cross(parts.X + u, forces).sum(0), 0, rtol=0, atol=1e-13 * scale)
    Q = random_rotation(5)
    parts.put((parts.X + u) @ Q.T - parts.X + [0.3, -2.0, 1.0], p)
    turned, turned_volumes = parts.forces()
    np.testing.assert_allclose(turned, forces @ Q.T, rtol=0, atol=1e-11 * scale)  # measured 3e-13
    np.testing.assert_allclose(turned_volumes, volumes, rtol=0, atol=1e-14)
    assert fem.assemble_scalar(every.energy) == pytest.approx(energy, rel=1e-11)  # measured 3e-13


def put_activation(mechanics, seed=4):
    gamma = mechanics.activation.x.array
    gamma[:] = np.random.default_rng(seed).uniform(-0.3, 0.0, len(gamma))


def test_a_rotated_problem_has_the_rotated_answer():
    """Issue: "A rotated problem gives the rotated answer": mesh, fibres, sheets and load turned and shifted,
    held at the same face and under the same follower pressure: u turns, p stays, under a varying activation
    of an orthotropic kind.
    """
    answers = []
    for Q, shift in ((np.eye(3), 0.0), (random_rotation(12), [3.0, -1.0, 0.5])):
        body = rotated(block(distortion=0.1), Q, shift)
        mechanics = recorded(
            body,
            kinematics=Solid(),
            material=NeoHookean(mu=MU),
            active=Orthotropic(),
            fixed=["left"],
            pressure={"top": 0.05},
            body_force=fem.Constant(body.mesh, Q @ np.array([0.05, -0.02, 0.03])),
            tolerance=1e-12,
        )
        put_activation(mechanics)
        mechanics.start()
        parts = Parts(mechanics)
        answers.append((parts.u @ Q, parts.p))
    (u, p), (turned_u, turned_p) = answers
    assert np.abs(u).max() > 0.1
    np.testing.assert_allclose(turned_u, u, rtol=0, atol=1e-10)
    np.testing.assert_allclose(turned_p, p, rtol=0, atol=1e-10)


def test_a_free_body_knows_no_frame():
    """The same without supports: other points are pinned, and strain, pressure and stress are the same; no
    force acts at the pins under an incompatible activation.
    """
    answers = []
    for Q in (np.eye(3), random_rotation(13)):
        solids = Solids(rotated(block(distortion=0.1), Q), [NeoHookean(mu=MU)], [Fibre()])
        put_activation(solids.mechanics)
        solids.mechanics.start()
        F = solids.gradient()
        forces, _ = solids.parts.forces()
        np.testing.assert_allclose(forces, 0, rtol=0, atol=1e-10)
        trace = np.trace(solids.cauchy(), axis1=1, axis2=2)
        answers.append((Q.T @ F.transpose(0, 2, 1) @ F @ Q, solids.parts.p, trace))
    assert np.abs(answers[0][2]).max() > 0.01  # the activation does stress the body
    for one, other in zip(*answers, strict=True):
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-10)


# Twist of a bar whose fibres wind about its axis.


def wound(mesh, handedness):
    """Fibres in the plane of the circles and the axis Z, as in the outer wall of a ventricle."""
    X = ufl.SpatialCoordinate(mesh)
    around = ufl.as_vector([0.5 - X[1], X[0] - 0.5, 0.0])
    along = ufl.as_vector([0.0, 0.0, 1.0])
    f0 = handedness * around + 0.6 * along  # along the axis on it
    return f0 / ufl.sqrt(ufl.dot(f0, f0))


def bar(handedness, mirror):
    """A bar 1 × 1 × 2 along Z; its mesh, which is no mirror image of itself, mirrored across X = 1/2."""
    body = block(size=(1.0, 1.0, 2.0), spacing=0.5, fibres=ms.UniformFibres(direction=(0, 0, 1)))
    x = body.mesh.geometry.x
    x[:, :2] += 0.04 * np.random.default_rng(7).uniform(-1, 1, (len(x), 2))
    if mirror:
        x[:, 0] = 1 - x[:, 0]
    h = fem.Constant(body.mesh, float(handedness))
    return Body(body.meshed, Microstructure(wound(body.mesh, h)))


def twisted(handedness, mirror):
    """Displacements of the nodes, fixed at the bottom, and the angle by which the top turns."""
    body = bar(handedness, mirror)
    mechanics = recorded(
        body,
        kinematics=Solid(),
        material=NeoHookean(mu=MU),
        fixed=["bottom"],
        tolerance=1e-12,
    )
    mechanics.activation.x.array[:] = -0.15
    mechanics.start()
    parts = Parts(mechanics)
    top = np.isclose(parts.X[:, 2], 2.0)
    arms, moved = parts.X[top, :2] - 0.5, parts.u[top, :2]
    x = arms + moved - moved.mean(0)
    angle = np.arctan2((arms[:, 0] * x[:, 1] - arms[:, 1] * x[:, 0]).sum(), (arms * x).sum())
    return parts, np.degrees(angle)


def test_mirrored_fibres_give_mirrored_twist():
    """Issue: "mirrored fibres give mirrored twist": bar and fibres mirrored, all displacements are mirrored;
    fibres alone mirrored, on the same mesh, the twist is opposite but for what the mesh does. The twist has
    the sense of the fibres: right-handed ones that shorten turn the top backwards along them.
    """
    parts, angle = twisted(1, mirror=False)
    mirrored, opposite = twisted(-1, mirror=True)
    across = np.array([-1.0, 1.0, 1.0])
    np.testing.assert_allclose(mirrored.u, parts.u * across, rtol=0, atol=1e-10)
    assert abs(angle) > 3
    assert opposite == pytest.approx(-angle, abs=1e-8)
    _, same_mesh = twisted(-1, mirror=False)
    assert same_mesh == pytest.approx(-angle, rel=0.05)
    assert angle < 0


def test_viscous_stress_knows_no_turning_frame():
    """Issue: "Frame-indifferent Kelvin–Voigt in 3D": a rotation that changes from one time to the next turns
    the nodal forces with the present one, whatever the former; they have no sum and no moment.
    """
    solids = Solids(
        block(size=(1.0, 1.0, 1.0)), [NeoHookean(mu=MU)], [c() for c in DEFORMATIONS], relaxation_time=0.4
    )
    mechanics, parts = solids.mechanics, solids.parts
    rng = np.random.default_rng(31)
    old, new = (parts.X + 0.05 * rng.uniform(-1, 1, parts.X.shape) for _ in range(2))
    still, turning = (np.eye(3), np.eye(3)), (random_rotation(1), random_rotation(2))
    for name in solids.active.names:
        solids.choose("NeoHookean", name)
        answers = []
        for Q_old, Q_new in (still, turning):
            put_activation(mechanics, seed=1)
            mechanics.release()
            parts.put(old @ Q_old.T - parts.X, 1.0)
            mechanics.accept(0.0)
            put_activation(mechanics, seed=2)
            mechanics._rate.set(0.1, 1, mechanics.history, mechanics._past_activation)
            parts.put(new @ Q_new.T - parts.X, 1.0)
            forces, _ = parts.forces()
            moment = np.cross(new @ Q_new.T, forces).sum(0)
            scale = np.abs(forces).max()
            np.testing.assert_allclose(forces.sum(0), 0, rtol=0, atol=1e-13 * scale)
            np.testing.assert_allclose(moment, 0, rtol=0, atol=1e-13 * scale)
            answers.append(forces @ Q_new)
        for constant in mechanics._rate.weights:
            constant.value = 0.0
        elastic, _ = parts.forces()
        assert np.abs(answers[1] - elastic @ Q_new).max() > 0.3 * scale  # most of it is viscous
        np.testing.assert_allclose(answers[1], answers[0], rtol=0, atol=1e-12 * scale)
