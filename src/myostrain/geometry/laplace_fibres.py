"""Rule-based fibres of ventricles, from solutions of Laplace's equation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.engine import MPI, fem, lasting
from myostrain.errors import InputError
from myostrain.geometry.fibres import Microstructure
from myostrain.geometry.harmonic import gradients, harmonic
from myostrain.geometry.meshed import Meshed
from myostrain.validation import Finite, description

import numpy as np
import numpy.typing as npt
import ufl

Array = npt.NDArray[np.float64]
Facets = Mapping[str, npt.NDArray[np.int32]]

#: Largest difference of the helix angles over the wall of two ventricles, in degrees, and the cosine of an
#: angle between two corners that is beyond it.
MOST_TURN, MOST_APART = 120.0, -0.7

#: How little a harmonic function, which goes from 0 to 1, may vary within a cell and still have a direction.
LEAST = 1e-7

#: Frames that are the same but for the senses of two directions; what is nearer by less than this is not
#: nearer: round-off is not to decide.
SENSES, TIE = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]), 1e-9


@description
class RuleBasedFibres:
    """Fibres and sheets of one or two ventricles from solutions of Laplace's equation.

    The rules are those of Bayer et al. 2012 (Ann. Biomed. Eng. 40: 2243–2254, doi 10.1007/s10439-012-0593-5).
    Directions across the wall and from apex to base are gradients of harmonic functions; the apex is the node
    farthest from the base, where the solution of −Δu = 1 with u = 0 at the base is the largest. The fibre is
    at the helix angle α from the circumference (anticlockwise seen from the base) towards the base, the sheet
    direction s0 across the fibre at the angle β from the wall's outward normal (the paper's third axis),
    n0 = f0 × s0. The default angles are the paper's. Nothing depends on the body's position in space.

    One ventricle: α and β are linear in the harmonic depth (the paper's composition of two rotations, made
    for the septum, would be quadratic, and jump where α turns by more than 90 degrees). Two ventricles: that
    composition, so that the helix angles may differ by 120 degrees at most; beyond 90 the fibre jumps in the
    outer quarter of the wall, by 45 degrees at 120.

    The harmonic functions are linear in a cell. Directions are taken at its corners; between them, wherever
    they are used, they are interpolated and made orthonormal again, to round-off. So there must be two cells
    or more across a wall in which the fibre turns by 180 degrees, and across a septum, through which it turns
    from the helix angle at one endocardium to minus that, by way of the circumference. Where two ventricles
    meet, the corners of a cell may differ by more than any such turn; the cell then takes one direction, the
    principal one of Σ f0 ⊗ f0.

    Args:
        helix: α at the endocardium and the epicardium of the left ventricle, degrees.
        sheet: β there, degrees.
        helix_right: α of the right ventricle; that of the left one unless given.
        sheet_right: β of the right ventricle; that of the left one unless given.
        endocardium: The boundary inside the left ventricle; "endocardium", or "endocardium_left" where there
            is one, unless given.
        endocardium_right: The boundary inside the right ventricle, "endocardium_right" where there is one.
        epicardium: The outer boundary.
        base: The boundary at the base.
    """

    helix: tuple[Finite, Finite] = (40.0, -50.0)
    sheet: tuple[Finite, Finite] = (-65.0, 25.0)
    helix_right: tuple[Finite, Finite] | None = None
    sheet_right: tuple[Finite, Finite] | None = None
    endocardium: str | None = None
    endocardium_right: str | None = None
    epicardium: str = "epicardium"
    base: str = "base"

    def directions_on(self, meshed: Meshed) -> Microstructure:
        """Unit directions as UFL vectors.

        Raises:
            InputError: The body is not a solid or lacks these boundaries; the fibre turns too far; or there
                is a cell in which the wall has no direction.
        """
        mesh = meshed.mesh
        if mesh.geometry.dim != 3:
            raise InputError("rule-based fibres are those of a solid", "fibres.kind")
        facets = self._facets(meshed)
        two = "right" in facets
        if two:
            self._check_turns()
        wall = _Wall(mesh, facets)
        _refuse(
            mesh,
            wall.flat,
            "in which the wall has no direction, such as those with all corners on one boundary",
            "fibres.kind",
        )
        frames = self._of_two(wall) if two else self._of_one(wall)
        if two:
            _settle(frames, wall.septal)
        f, s = frames[..., 0], frames[..., 2]
        cosine = np.einsum("cik,cjk->cij", f, f).min(axis=(1, 2))
        _refuse(mesh, cosine < -0.9, "in which the fibre turns by more than 150 degrees", "fibres.helix")
        return orthonormal(_field(mesh, f, "f0"), _field(mesh, s, "s0"))

    def _facets(self, meshed: Meshed) -> Facets:
        """Facets of the left and the right endocardium, the epicardium and the base."""
        known = meshed.boundaries
        pair = "endocardium_left" in known
        left = self.endocardium or ("endocardium_left" if pair else "endocardium")
        right = self.endocardium_right or ("endocardium_right" if "endocardium_right" in known else None)
        names = {
            "left": (left, "endocardium"),
            "outside": (self.epicardium, "epicardium"),
            "base": (self.base, "base"),
        }
        if right is not None:
            names["right"] = (right, "endocardium_right")
        return {what: meshed.facets([name], f"fibres.{key}") for what, (name, key) in names.items()}

    def _check_turns(self) -> None:
        """Refuse angles that the rules for two ventricles do not follow."""
        for key, (inside, outside) in {
            "helix": self.helix,
            "helix_right": self.helix_right or self.helix,
        }.items():
            if abs(inside - outside) > MOST_TURN:
                raise InputError(
                    f"between {inside:g} and {outside:g} the fibre turns by more than {MOST_TURN:g} degrees, "
                    "which the rules for two ventricles do not follow",
                    f"fibres.{key}",
                )

    def _of_one(self, wall: _Wall) -> Array:
        """Frames at the corners of each cell of one ventricle, (cells, 4, 3, 3)."""
        helix, sheet = (_linear(ends, wall.outside) for ends in (self.helix, self.sheet))
        return _turned(_axes(wall.upwards, wall.to_outside), helix, sheet)

    def _of_two(self, wall: _Wall) -> Array:
        """Frames at the corners of each cell of two ventricles, (cells, 4, 3, 3)."""
        # In the septum, and around the left ventricle, the angles are the left one's.
        free, side = wall.outside > 0.5, wall.side
        is_right = np.where(free, side < 0.5, side <= 0.1)[..., None]
        helix, sheet = (
            np.where(is_right, right or left, left)
            for left, right in ((self.helix, self.helix_right), (self.sheet, self.sheet_right))
        )
        depth, out = wall.right / np.maximum(wall.left + wall.right, 1e-300), wall.outside
        depth = np.where(wall.left + wall.right < 1e-12, 0.5, depth)
        inner = [angle[..., 0] * (1 - 2 * depth) for angle in (helix, sheet)]
        outer = [angle[..., 0] * (1 - out) + angle[..., 1] * out for angle in (helix, sheet)]
        # A function without a direction in a cell has no weight there; any frame does in its place.
        left, right, outside = wall.to_left, wall.to_right, wall.to_outside
        left = np.where(wall.seen(left), -left, np.where(wall.seen(right), right, outside))
        right = np.where(wall.seen(right), right, left)
        outside = np.where(
            wall.seen(outside), outside, np.where(depth.mean(axis=1)[:, None] < 0.5, left, right)
        )
        inside, other = (_turned(_axes(wall.upwards, d), inner[0], inner[1]) for d in (left, right))
        inside = _between(inside, other, depth)
        found = _between(inside, _turned(_axes(wall.upwards, outside), *outer), out)
        # Lines so far: of their senses that which goes with the circumference, seen from outside. In the
        # right free wall the angles inside are those seen from its cavity.
        beyond = (depth > 0.5) & ((wall.to_right * wall.outwards).sum(axis=1) < 0)[:, None]
        expected = [np.where(beyond, -a, a) * (1 - out) + b * out for a, b in zip(inner, outer, strict=True)]
        sense = (found * _turned(_axes(wall.upwards, wall.outwards), *expected)).sum(axis=2)
        return found * np.where(sense < 0, -1.0, 1.0)[:, :, None, :]


class _Wall:
    """What the harmonic functions of one or two ventricles say of each cell.

    Args:
        mesh: The mesh.
        facets: Facets of the left and, if there is one, the right endocardium, the epicardium, the base.

    Attributes:
        left, right, outside: The functions that are one at the left endocardium, the right one, or the
            epicardium, and zero at the two others; at the corners (cells, 4).
        side: That which goes from zero at the right to one at the left endocardium (cells, 4).
        upwards: Gradient (cells, 3) of the function that goes from the apex to the base.
        to_left, to_right, to_outside: What of the others' gradients is across it, (cells, 3).
        outwards: Across it too: out of the left ventricle and, beyond the septum, of the heart (cells, 3).
        flat: Cells (cells,) in which there are no two such directions.
        septal: Cells (cells,) that reach from one endocardium to the other.
    """

    def __init__(self, mesh: Any, facets: Facets) -> None:
        space = fem.functionspace(mesh, ("Lagrange", 1))
        nodes = {name: fem.locate_dofs_topological(space, 2, found) for name, found in facets.items()}

        def solved(**held: float) -> tuple[Array, Array]:
            return gradients(harmonic(space, [(value, nodes[name]) for name, value in held.items()]))

        nodes["apex"] = _apex(space, nodes["base"])
        _, self.upwards = solved(apex=0.0, base=1.0)
        x = mesh.geometry.x[mesh.geometry.dofmaps[0]]
        self._size = np.linalg.norm(np.ptp(x, axis=1), axis=1)
        if "right" in nodes:
            self.left, to_left = solved(right=0.0, outside=0.0, left=1.0)
            self.right, to_right = solved(left=0.0, outside=0.0, right=1.0)
            self.outside, to_outside = solved(left=0.0, right=0.0, outside=1.0)
            self.side, _ = solved(right=0.0, left=1.0)
            self.to_left, self.to_right = self._level(to_left), self._level(to_right)
            self.outwards = self._level(-2 * to_left - to_right)
        else:
            self.outside, to_outside = solved(left=0.0, outside=1.0)
            self.outwards = self._level(to_outside)
        self.to_outside = self._level(to_outside)
        self.flat = ~(self.seen(self.upwards) & self.seen(self.outwards))[:, 0]
        self.septal = ~self.seen(to_outside)[:, 0]

    def _level(self, gradient: Array) -> Array:
        """What of a gradient (cells, 3) is across that from apex to base, zero where that is round-off."""
        up = _unit(self.upwards)
        across = gradient - (up * gradient).sum(axis=1, keepdims=True) * up
        sizes = np.linalg.norm(across, axis=1), np.linalg.norm(gradient, axis=1)
        return np.where((sizes[0] > LEAST * sizes[1])[:, None], across, 0.0)

    def seen(self, gradient: Array) -> Any:
        """Whether a function varies in a cell, (cells, 1)."""
        return (np.linalg.norm(gradient, axis=1) * self._size > LEAST)[:, None]


def _apex(space: fem.FunctionSpace, base: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """The node farthest from the base, where this process has it; of equal ones that of the least X."""
    far = harmonic(space, [(0.0, base)], source=1.0)
    owned = space.dofmap.index_map.size_local
    values, x, comm = far.x.array[:owned], space.tabulate_dof_coordinates()[:owned], lasting(space.mesh.comm)
    most = comm.allreduce(values.max(initial=0.0), MPI.MAX)
    near = np.flatnonzero(values > most * (1 - 1e-9))
    mine = [(*x[node].tolist(), comm.rank, node) for node in near.tolist()]
    *_, rank, node = min(entry for part in comm.allgather(mine) for entry in part)
    far.x.array[:] = 0.0
    if rank == comm.rank:
        far.x.array[node] = 1.0
    far.x.scatter_forward()
    return np.flatnonzero(far.x.array).astype(np.int32)


def _linear(ends: tuple[float, float], depth: Array) -> Array:
    return ends[0] + (ends[1] - ends[0]) * depth


def _unit(vectors: Array) -> Array:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)


def _axes(upwards: Array, outwards: Array) -> Array:
    """Circumference, upwards and outwards, orthonormal, in the columns of (cells, 3, 3)."""
    up = _unit(upwards)
    out = _unit(outwards - (up * outwards).sum(axis=1, keepdims=True) * up)
    return np.stack([np.cross(up, out), up, out], axis=-1)


def _turned(axes: Array, helix: Array, sheet: Array) -> Array:
    """Fibre, normal of the sheet and sheet at the corners of each cell, in the columns of (cells, 4, 3, 3).

    Args:
        axes: Axes of the cells (cells, 3, 3).
        helix: Angle of the fibre from the circumference, degrees (cells, 4).
        sheet: Angle of the sheet from the outward direction, degrees (cells, 4).
    """
    around, up, out = np.moveaxis(axes[:, None], -1, 0)
    (ca, sa), (cb, sb) = ((np.cos(a)[..., None], np.sin(a)[..., None]) for a in np.radians([helix, sheet]))
    within = ca * up - sa * around
    return np.stack([ca * around + sa * up, cb * within - sb * out, sb * within + cb * out], axis=-1)


def _between(one: Array, other: Array, share: Array) -> Array:
    """Frames between two, by the shortest turn that takes the lines of one to those of the other.

    Args:
        one: Frames (..., 3, 3), where the share is zero.
        other: Frames, where the share is one.
        share: The share (...,).
    """
    along = np.einsum("...ki,...ki->...i", one, other)
    nearest = np.argmax(along @ SENSES.T - TIE * np.arange(4), axis=-1)
    one = one * SENSES[nearest][..., None, :]
    turn = np.swapaxes(one, -1, -2) @ other
    angle = np.arccos(np.clip((np.trace(turn, axis1=-2, axis2=-1) - 1) / 2, -1, 1))[..., None, None]
    # At most 120 degrees, so that the turn has an axis wherever it is one.
    axis = (turn - np.swapaxes(turn, -1, -2)) / (2 * np.maximum(np.sin(angle), 1e-12))
    angle = angle * share[..., None, None]
    return np.asarray(one @ (np.eye(3) + np.sin(angle) * axis + (1 - np.cos(angle)) * axis @ axis))


def _settle(frames: Array, septal: Any) -> None:
    """Make the corners of cells agree that do not, where two ventricles meet.

    Such cells take the principal direction of their corners, in which neither sense nor numbering matters.

    Args:
        frames: Frames at the corners (cells, 4, 3, 3), changed.
        septal: Cells in which corners are apart because the fibre turns too far in one layer.
    """
    for column in (0, 2):
        values = frames[..., column]
        apart = (np.einsum("cik,cjk->cij", values, values).min(axis=(1, 2)) < MOST_APART) & ~septal
        _, axes = np.linalg.eigh(np.einsum("cik,cil->ckl", values[apart], values[apart]))
        values[apart] = axes[:, None, :, -1]


def _field(mesh: Any, values: Array, name: str) -> fem.Function:
    """A discontinuous linear field with these values (cells, 4, 3) at the corners."""
    field = fem.Function(fem.functionspace(mesh, ("DG", 1, (3,))), name=name)
    field.x.array.reshape(-1, 3)[field.function_space.dofmap.list] = values
    return field


def orthonormal(f: Any, s: Any) -> Microstructure:
    """Fibre, sheet and normal made orthonormal in every point.

    Args:
        f: Fibre, a UFL vector of any length but zero.
        s: Sheet direction, of any length; its part across the fibre is taken.
    """
    f0 = f / ufl.sqrt(ufl.dot(f, f))
    across = s - ufl.dot(s, f0) * f0
    s0 = across / ufl.sqrt(ufl.dot(across, across))
    # Once more: where s is mostly along f, the difference has lost digits.
    s0 -= ufl.dot(s0, f0) * f0
    s0 /= ufl.sqrt(ufl.dot(s0, s0))
    return Microstructure(f0, s0, ufl.cross(f0, s0))


def _refuse(mesh: Any, wrong: Any, what: str, key: str) -> None:
    owned = mesh.topology.index_map(3).size_local
    places = np.flatnonzero(wrong[:owned])
    comm = lasting(mesh.comm)
    number = comm.allreduce(len(places), MPI.SUM)
    if number:
        centres = mesh.geometry.x[mesh.geometry.dofmaps[0][places[:1]]].mean(axis=1).tolist()
        first = [float(f"{x:.6g}") for x in next(c[0] for c in comm.allgather(centres) if c)]
        raise InputError(
            f"{number} cells {what}, one near {first}; they need a finer mesh, with two cells or more across "
            "each wall: a smaller geometry.spacing, or a file of smaller cells",
            key,
        )
