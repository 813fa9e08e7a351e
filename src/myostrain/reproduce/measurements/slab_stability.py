"""A slab that is squeezed beyond the border of ellipticity, on meshes of several sizes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myostrain import build
from myostrain.activation import Fibre, FibreTension
from myostrain.engine import MPI, fem, jit_options
from myostrain.errors import ComputationError
from myostrain.geometry import Slab, UniformFibres
from myostrain.kinematics import Solid
from myostrain.mechanics import Mechanics, Supports
from myostrain.mechanics.supports import holds
from myostrain.reproduce.jobs import Found
from myostrain.reproduce.measurements.ellipticity import least, plane
from myostrain.reproduce.measurements.points import (
    Array,
    Points,
    active_tensors,
    free_stretches,
    material,
    tension_for,
)

import numpy as np
import ufl
from dolfinx.fem import assemble_matrix
from scipy.sparse.linalg import eigsh

SIZE = (1.0, 0.5, 0.5)
#: Fibres along x, sheets along z: what shortens along x grows along z, and y is held.
FIBRES = UniformFibres(direction=(1.0, 0.0, 0.0), sheet=(0.0, 0.0, 1.0))
SLIDING = ("left", "front", "back", "bottom")
#: Fibre, sheet and normal f × s, the axes of material points, in columns.
FRAME = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def supports(stretch: float) -> Supports:
    """Faces that slide, two of them moved: the slab is stretched by λ along x and 1/λ along z."""
    x, z = SIZE[0] * (stretch - 1), SIZE[2] * (1 / stretch - 1)
    return Supports(sliding=SLIDING, displacement={"right": {"x": x}, "top": {"z": z}})


class Squeezed:
    """A slab on one mesh: its least second variation around homogeneous states."""

    def __init__(self, spacing: float) -> None:
        self.body = build(Slab(size=SIZE, spacing=spacing), FIBRES, MPI.COMM_SELF)
        mesh = self.body.mesh
        self.space = fem.functionspace(mesh, ("Lagrange", 2, (3,)))
        held = np.concatenate([hold.dofs for hold in holds(self.body, self.space, supports(0.9), False)])
        size = self.space.dofmap.index_map.size_local * 3
        self.free = np.setdiff1d(np.arange(size), held)
        self._A = fem.Constant(mesh, np.zeros((3, 3, 3, 3)))
        v, w = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
        i, j, k, m = ufl.indices(4)
        dx = ufl.dx(metadata={"quadrature_degree": 2})
        second = self._A[i, j, k, m] * ufl.grad(v)[i, j] * ufl.grad(w)[k, m] * dx
        self._second = fem.form(second, jit_options=jit_options())
        norm = fem.form(ufl.inner(ufl.grad(v), ufl.grad(w)) * dx, jit_options=jit_options())
        self._norm = self._matrix(norm)

    def _matrix(self, form: Any) -> Any:
        return assemble_matrix(form).to_scipy().tocsr()[self.free][:, self.free].tocsc()

    def least(self, A: Array, bound: float) -> tuple[float, Array]:
        """The least ∫ A[∇v, ∇v] over ∫ |∇v|² of displacements v that the supports allow, and that v.

        Args:
            A: Moduli (3, 3, 3, 3) over the modulus, those of the whole slab.
            bound: A number below it.
        """
        self._A.value[:] = A
        start = np.random.default_rng(1).standard_normal(len(self.free))
        values, vectors = eigsh(
            self._matrix(self._second), 1, self._norm, sigma=bound, which="LM", v0=start, tol=1e-8
        )
        mode = np.zeros(self.space.dofmap.index_map.size_local * 3)
        mode[self.free] = vectors[:, 0]
        return float(values[0]), mode / np.abs(mode).max()


def stability(
    law: Mapping[str, Any],
    approach: str,
    gamma: float,
    spacings: Sequence[float],
    stretches: Sequence[float],
    bulk_modulus: float,
) -> Found:
    """The least second variation of a slab under λ along the fibre and 1/λ along the sheet.

    The state is homogeneous, and in equilibrium at every λ. A slab of a strongly elliptic material
    is stable in it (L. van Hove, Proc. Kon. Ned. Akad. Wet. 50 (1947) 18–23); beyond, some displacement
    of a wavelength short enough lowers the energy, and a mesh has only those that it resolves.

    Args:
        law: ``model``, a name of :mod:`myostrain.materials`, and its parameters.
        approach: "passive", "strain" with Fo = 1 + γ f⊗f, or "tension", matched as in
            :func:`~myostrain.reproduce.measurements.ellipticity.examined`.
        gamma: γ.
        spacings: Of the meshes.
        stretches: λ, descending.
        bulk_modulus: κ over the modulus.

    Returns:
        Numbers: ``border`` λ of the acoustic tensor, and ``borders`` by spacing of the slab, None where it
        stays stable; ``waves`` by spacing: how often the displacement of the mode changes its sign
        along the fibre, at the last λ. Arrays: ``acoustic`` (λ,) and ``slab`` (spacings, λ), over the
        modulus.
    """
    passive, lam = material(law), np.asarray(stretches, dtype=float)
    Fo, T = activation_of(law, approach, gamma)
    points = Points(passive, len(lam), bulk_modulus * passive.modulus)
    acoustic, _ = least(points, plane(lam), Fo, T, all_amplitudes=True)
    # From the frame of fibre, sheet and normal to the slab's.
    A = np.einsum("pijkl,ai,bj,ck,dl->pabcd", points.moduli() / points.modulus, *[FRAME] * 4)
    slab, waves = [], []
    for spacing in spacings:
        squeezed = Squeezed(spacing)
        found = [squeezed.least(one, float(low) - 0.05) for one, low in zip(A, acoustic, strict=True)]
        slab.append([value for value, _ in found])
        nodes = squeezed.space.tabulate_dof_coordinates()
        waves.append(changes_of_sign(nodes, found[-1][1].reshape(-1, 3)))
    borders = [crossing(lam, np.array(values)) for values in slab]
    numbers = {"border": crossing(lam, acoustic), "borders": borders, "waves": waves}
    return Found(numbers, {"stretch": lam, "acoustic": acoustic, "slab": np.array(slab)})


def activation_of(law: Mapping[str, Any], approach: str, gamma: float) -> tuple[Array, Array]:
    """Fo (1, 3, 3) and the tension (1,) of an approach."""
    Fo = active_tensors({"kind": "Fibre"}, np.array([gamma]))
    few = Points(material(law), 1)
    T = tension_for(few, free_stretches(few, Fo)[:, 0])
    one = np.eye(3)[None]
    return (Fo if approach == "strain" else one), (T if approach == "tension" else np.zeros(1))


def crossing(stretch: Array, values: Array) -> float | None:
    """Where values over descending stretches first fall below zero, linear between; None where nowhere."""
    lost = np.flatnonzero(values <= 0)
    if not len(lost) or lost[0] == 0:
        return None
    near = slice(lost[0] - 1, lost[0] + 1)
    return float(np.interp(0.0, values[near][::-1], stretch[near][::-1]))


def changes_of_sign(x: Array, v: Array) -> int:
    """How often the largest component of v (n, 3) at nodes x (n, 3) changes its sign along x where it is."""
    node, component = np.unravel_index(np.abs(v).argmax(), v.shape)
    line = np.flatnonzero(np.all(np.abs(x[:, 1:] - x[node, 1:]) < 1e-9, axis=1))
    along = v[line[np.argsort(x[line, 0])], component]
    along = along[np.abs(along) > 1e-3 * np.abs(along).max()]
    return int(np.sum(along[1:] * along[:-1] < 0))


def squeezed_on(
    law: Mapping[str, Any],
    approach: str,
    gamma: float,
    spacings: Sequence[float],
    stretches: Sequence[float],
    bulk_modulus: float,
    tilt: float,
) -> Found:
    """What a slab with slightly tilted fibres does when it is squeezed beyond the border, step by step.

    Args:
        law: As in :func:`stability`, like the following.
        approach: The approach.
        gamma: γ.
        spacings: Of the meshes.
        stretches: λ of the steps, descending from 1.
        bulk_modulus: κ over the modulus.
        tilt: Of the fibres towards y, in the plane of x and y, a slope.

    Returns:
        Numbers by spacing: ``reached``, the last λ at which an equilibrium was found; ``waves``, how often
        the displacement away from the affine one changes its sign along the fibre there. Arrays: ``stretch``
        (λ,) and ``away`` (spacings, λ): its largest size, where the slab is 1 long, NaN where no equilibrium
        was found.
    """
    passive, lam = material(law), np.asarray(stretches, dtype=float)
    _, T = activation_of(law, approach, gamma)
    fibres = UniformFibres(direction=(1.0, tilt, 0.0), sheet=(0.0, 0.0, 1.0))
    times = np.arange(len(lam), dtype=float)
    moved: dict[str, Any] = {
        "right": {"x": tuple(zip(times, SIZE[0] * (lam - 1), strict=True))},
        "top": {"z": tuple(zip(times, SIZE[2] * (1 / lam - 1), strict=True))},
    }
    away = np.full((len(spacings), len(lam)), np.nan)
    reached, waves = [], []
    for row, spacing in zip(away, spacings, strict=True):
        mechanics = Mechanics(
            build(Slab(size=SIZE, spacing=spacing), fibres, MPI.COMM_SELF),
            kinematics=Solid(bulk_modulus=bulk_modulus * passive.modulus),
            material=passive,
            active=FibreTension() if approach == "tension" else Fibre(),
            supports=Supports(sliding=SLIDING, displacement=moved),
        )
        value = {"passive": 0.0, "strain": gamma, "tension": float(T[0])}[approach]
        mechanics.activation.x.array[:] = value
        x = mechanics.u.function_space.tabulate_dof_coordinates()
        rest = np.zeros((len(x), 3))
        for time, stretch in zip(times, lam, strict=True):
            try:
                if time == 0:
                    mechanics.start(time)
                else:
                    mechanics.solve(time)
                    mechanics.accept(time)
            except ComputationError:
                break
            affine = np.stack([(stretch - 1) * x[:, 0], 0 * x[:, 1], (1 / stretch - 1) * x[:, 2]], axis=1)
            rest = mechanics.u.x.array.reshape(-1, 3) - affine
            row[int(time)] = np.abs(rest).max()
        reached.append(float(lam[np.isfinite(row)][-1]) if np.isfinite(row).any() else None)
        waves.append(changes_of_sign(x, rest))
    numbers = {"spacings": list(spacings), "reached": reached, "waves": waves}
    return Found(numbers, {"stretch": lam, "away": away})
