"""Shared by the tests of solids: all exported parts of the mechanics in one form, and measures of a state.

A form of a solid takes many seconds to compile. Here the weights of the exported materials, active
deformations and constraints are constants of one form, so that one compilation serves each combination, a new
export included.
"""

from contextlib import contextmanager

import myostrain as ms
import myostrain.mechanics.equilibrium
from myostrain import activation, engine, materials
from myostrain.engine import compile_form, fem
from myostrain.geometry import Body
from myostrain.kinematics import Solid
from myostrain.validation import with_constants

import numpy as np
import ufl
from scipy.spatial.transform import Rotation

from mechanics_tools import Recorded, at_midpoints, described

CONSTRAINTS = ("total", "elastic")
OBLIQUE = ms.UniformFibres(direction=(1.0, 0.5, -0.3), sheet=(0.2, 1.0, 0.4))
SOLID_MATERIALS = [
    cls
    for name in materials.__all__
    if (cls := getattr(materials, name)) is not materials.Material and cls.tensor_dim == 3
]
DEFORMATIONS = [
    cls
    for name in activation.__all__
    if hasattr(cls := getattr(activation, name), "tensor") and cls is not activation.ActiveDeformation
]
TENSIONS = [
    cls
    for name in activation.__all__
    if hasattr(cls := getattr(activation, name), "energy") and cls is not activation.ActiveTension
]


class OneOf:
    """Several objects of which constants choose one."""

    def __init__(self, mesh, members):
        self.members = [with_constants(member, mesh) for member in members]
        self.names = [type(member).__name__ for member in members]
        self.weights = [fem.Constant(mesh, float(i == 0)) for i in range(len(members))]

    def choose(self, name):
        for weight, other in zip(self.weights, self.names, strict=True):
            weight.value = float(other == name)
        assert name in self.names

    def sum_of(self, method, *arguments):
        terms = [w * getattr(m, method)(*arguments) for w, m in zip(self.weights, self.members, strict=True)]
        return sum(terms[1:], terms[0])


class OneMaterial(OneOf):
    """A material that is one of several."""

    tensor_dim = 3

    def energy(self, Fe, fibres):
        return self.sum_of("energy", Fe, fibres)

    @property
    def modulus(self):
        return sum(w * m.modulus for w, m in zip(self.weights, self.members, strict=True))


class OneDeformation(OneOf):
    """An active deformation that is one of several."""

    def tensor(self, gamma, fibres):
        return self.sum_of("tensor", gamma, fibres)


class OneTension(OneOf):
    """What a tension does, one of several."""

    def energy(self, F, fibres, tension):
        return self.sum_of("energy", F, fibres, tension)


class OneConstraint(OneOf):
    """An incompressible solid of the one or the other constraint."""

    def __init__(self, mesh):
        super().__init__(mesh, [])
        self.members = [Solid(constraint=constraint, augmentation=2.0) for constraint in CONSTRAINTS]
        self.names = list(CONSTRAINTS)
        self.weights = [fem.Constant(mesh, float(i == 0)) for i in range(2)]

    def __getattr__(self, name):
        return getattr(Solid(), name)

    def constraint_residual(self, F, Jo):
        return self.sum_of("constraint_residual", F, Jo)

    def pressure_energy(self, F, Jo, p):
        return self.sum_of("pressure_energy", F, Jo, p)

    def volume_ratio(self, F, Jo):
        return self.sum_of("volume_ratio", F, Jo)

    def volume_energy(self, F, Jo):
        return self.sum_of("volume_energy", F, Jo)

    def scaled_by(self, modulus):
        return self


class Solids:
    """A mechanics whose material, activation and constraint are chosen after it was compiled.

    Args:
        body: The body.
        materials: Materials to choose from.
        actives: Active deformations to choose from, or active tensions.
        others: What mechanics takes besides.
    """

    def __init__(self, body, materials, actives, **others):
        self.material = OneMaterial(body.mesh, materials)
        strains = hasattr(actives[0], "tensor")
        self.active = (OneDeformation if strains else OneTension)(body.mesh, actives)
        self.constraint = OneConstraint(body.mesh)
        others = {"tolerance": 1e-12} | others
        self.mechanics = recorded(
            body,
            kinematics=self.constraint,
            material=self.material,
            active=self.active,
            **others,
        )
        with quick_kernels():  # compiled once, as it takes seconds each time
            self.cauchy = at_midpoints(self.mechanics.cauchy(), body.mesh)
            self.grad_u = at_midpoints(ufl.grad(ufl.split(self.mechanics.u)[0]), body.mesh)
        self.parts = Parts(self.mechanics)

    def gradient(self):
        """F at the cells' midpoints, (cells, 3, 3)."""
        return np.eye(3) + self.grad_u()

    def choose(self, material=None, active=None, constraint=None):
        """Choose by name and return the mechanics, at rest."""
        for part, name in (
            (self.material, material),
            (self.active, active),
            (self.constraint, constraint),
        ):
            if name is not None:
                part.choose(name)
        self.mechanics.solver.forget()
        self.mechanics.u.x.array[:] = 0.0
        return self.mechanics


@contextmanager
def quick_kernels():
    """Kernels that compile in a third of the time and run slower: for bodies of a few cells."""
    flags = list(engine.NATIVE_FLAGS)
    engine.NATIVE_FLAGS[:] = ["-O0", "-g0"]
    try:
        yield
    finally:
        engine.NATIVE_FLAGS[:] = flags


def recorded(body, **parts):
    """A mechanics of a few cells whose solver remembers its residual's form."""
    usual = myostrain.mechanics.equilibrium.ChordNewton
    myostrain.mechanics.equilibrium.ChordNewton = Recorded
    try:
        with quick_kernels():
            return ms.Mechanics(
                body,
                **described(parts),
            )
    finally:
        myostrain.mechanics.equilibrium.ChordNewton = usual


def block(size=(2.0, 1.0, 1.0), spacing=1.0, fibres=OBLIQUE, distortion=0.0, seed=3):
    """A slab, its nodes moved at random by a share of the spacing."""
    body = ms.build(ms.geometry.Slab(size=size, spacing=spacing), fibres)
    x = body.mesh.geometry.x
    x += distortion * spacing * np.random.default_rng(seed).uniform(-1, 1, x.shape)
    return body


def frame(body):
    """Directions f0, s0, n0 of uniform fibres as columns."""
    return np.column_stack([d.value for d in (body.fibres.f0, body.fibres.s0, body.fibres.n0)])


def rotated(body, Q, shift=0.0):
    """The body with its uniform fibres, turned and shifted in place."""
    x = body.mesh.geometry.x
    x[:] = x @ Q.T + shift
    directions = [fem.Constant(body.mesh, Q @ d) for d in frame(body).T]
    return Body(body.meshed, type(body.fibres)(*directions))


def random_rotation(seed):
    return Rotation.random(random_state=seed).as_matrix()


class Parts:
    """Displacement (n, 3) with its nodes, and pressure, of a mixed unknown as views by numbers."""

    def __init__(self, mechanics):
        self.mechanics = mechanics
        space = mechanics.u.function_space
        displacement, self.u_dofs = space.sub(0).collapse()
        self.p_dofs = np.asarray(space.sub(1).collapse()[1])
        self.u_dofs = np.asarray(self.u_dofs).reshape(-1, 3)
        self.X = displacement.tabulate_dof_coordinates()

    @property
    def u(self):
        return self.mechanics.u.x.array[self.u_dofs]

    @property
    def p(self):
        return self.mechanics.u.x.array[self.p_dofs]

    def put(self, u, p):
        self.mechanics.u.x.array[self.u_dofs] = u
        self.mechanics.u.x.array[self.p_dofs] = p

    def forces(self):
        """Nodal forces (n, 3) and the residual of the constraint, where conditions hold the body too."""
        values = fem.assemble_vector(self.mechanics.solver._residual).array
        return values[self.u_dofs], values[self.p_dofs]


def integral(expression, degree=4):
    """Integral over a body of a few cells."""
    with quick_kernels():
        return fem.assemble_scalar(compile_form(expression * ufl.dx(metadata={"quadrature_degree": degree})))
