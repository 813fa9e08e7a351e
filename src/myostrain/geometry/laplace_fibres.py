"""Rule-based fibres of ventricles, by fenicsx-ldrb."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from myostrain.engine import MPI, fem, lasting
from myostrain.errors import InputError
from myostrain.geometry.fibres import Microstructure
from myostrain.geometry.meshed import Meshed
from myostrain.validation import Finite, description

import numpy as np
import ufl

#: Largest difference of the helix angles over the wall of two ventricles, in degrees, and the cosine of an
#: angle between two corners that is beyond it.
MOST_TURN, MOST_APART = 120.0, -0.7

HOW_TO_GET_IT = (
    "rule-based fibres are made by fenicsx-ldrb, which is not here. In a checkout of myostrain: "
    "`uv sync --extra ventricle`. With pip, which cannot meet its requirement on fenics-dolfinx where "
    "DOLFINx is a wheel of another name: `pip install h5py numba packaging scipy`, then `pip install "
    "--no-deps fenicsx-ldrb io4dolfinx fenicsx-compat`. On an ellipsoidal ventricle "
    'kind = "ellipsoidal" does without it'
)


@description
class RuleBasedFibres:
    """Fibres and sheets of one or two ventricles from solutions of Laplace's equation.

    The rules are those of Bayer et al. 2012 (Ann. Biomed. Eng. 40: 2243–2254, doi 10.1007/s10439-012-0593-5),
    the program is fenicsx-ldrb. Directions across the wall and from apex to base are gradients of harmonic
    functions; the fibre is at the helix angle α from the circumference (anticlockwise seen from the base)
    towards the base, the sheet direction s0 across the fibre at the angle β from the wall's outward normal
    (ldrb's ``n0``), n0 = f0 × s0. The default angles are the paper's.

    One ventricle: α and β are linear in the harmonic depth (ldrb's ``epi_only``; its composition of two
    rotations, made for the septum, would be quadratic, and jump where α turns by more than 90 degrees).
    Two ventricles: that composition, so that the helix angles may differ by 120 degrees at most; beyond 90
    the fibre jumps in the outer quarter of the wall, by 45 degrees at 120. Where it has to choose between
    equal turns, round-off does: in some cells (14 of 1,500) the fibre depends on the number of processes.

    The harmonic functions are linear in a cell. Directions are taken at its corners; between them, wherever
    they are used, they are interpolated and made orthonormal anew, to round-off. So there must be two cells
    or more across a wall in which the fibre turns by 180 degrees. Where two ventricles meet, cells whose
    corners disagree beyond any such turn take one direction, the principal one of Σ f0 ⊗ f0.

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
            InputError: fenicsx-ldrb is not there; the body is no solid or has not these boundaries; the fibre
                turns too far; or there is a cell in which the wall has no direction.
        """
        mesh = meshed.mesh
        if mesh.geometry.dim != 3:
            raise InputError("rule-based fibres are those of a solid", "fibres.kind")
        markers = self._markers(meshed)
        two = "rv" in markers
        found = _ldrb().dolfinx_ldrb(
            mesh,
            fiber_space="DG_1",
            ffun=meshed.facet_tags,
            markers=markers,
            **self._angles(two),
            epi_only=not two,
            petsc_options={
                "ksp_type": "cg",
                "pc_type": "gamg",
                "ksp_rtol": 1e-12,
                "ksp_error_if_not_converged": True,
            },
        )
        f, s = found.f0, found.n0
        _settle(f, s, MOST_APART if two else -1.0)
        _check_turn(f)
        return orthonormal(f, s)

    def _markers(self, meshed: Meshed) -> dict[str, int]:
        """What ldrb calls the boundaries, and their tags."""
        known = meshed.boundaries
        pair = "endocardium_left" in known
        left = self.endocardium or ("endocardium_left" if pair else "endocardium")
        right = self.endocardium_right or ("endocardium_right" if "endocardium_right" in known else None)
        names = {
            "lv": (left, "endocardium"),
            "epi": (self.epicardium, "epicardium"),
            "base": (self.base, "base"),
        }
        if right is not None:
            names["rv"] = (right, "endocardium_right")
        for name, key in names.values():
            meshed.facets([name], f"fibres.{key}")
        return {what: known[name] for what, (name, _) in names.items()}

    def _angles(self, two: bool) -> dict[str, float]:
        """The angles in ldrb's words; it takes a zero for an angle that is not given."""
        helix, sheet = self.helix_right or self.helix, self.sheet_right or self.sheet
        for key, (inside, outside) in {"helix": self.helix, "helix_right": helix}.items():
            if two and abs(inside - outside) > MOST_TURN:
                raise InputError(
                    f"between {inside:g} and {outside:g} the fibre turns by more than {MOST_TURN:g} degrees, "
                    "which the rules for two ventricles do not follow",
                    f"fibres.{key}",
                )
        left = dict(
            zip(("alpha_endo", "alpha_epi", "beta_endo", "beta_epi"), (*self.helix, *self.sheet), strict=True)
        )
        right = dict(zip(left, (*helix, *sheet), strict=True))
        return {
            **{f"{name}_lv": value for name, value in left.items()},
            **{f"{name}_sept": value or 1e-12 for name, value in left.items()},
            **{f"{name}_rv": value or 1e-12 for name, value in right.items()},
        }


def orthonormal(f: Any, s: Any) -> Microstructure:
    """Fibre, sheet and normal made orthonormal in every point.

    Args:
        f: Fibre, a UFL vector of any length but zero.
        s: Sheet direction, of any length; what of it is across the fibre is taken.
    """
    f0 = f / ufl.sqrt(ufl.dot(f, f))
    across = s - ufl.dot(s, f0) * f0
    s0 = across / ufl.sqrt(ufl.dot(across, across))
    # Once more: where s is mostly along f, the difference has lost digits.
    s0 -= ufl.dot(s0, f0) * f0
    s0 /= ufl.sqrt(ufl.dot(s0, s0))
    return Microstructure(f0, s0, ufl.cross(f0, s0))


def _corners(field: fem.Function) -> Any:
    """The values of a discontinuous linear vector field, (cells, 4, 3), and where they are."""
    places = field.function_space.dofmap.list
    return field.x.array.reshape(-1, 3)[places], places


def _settle(f: fem.Function, s: fem.Function, least: float) -> None:
    """Make the corners of each cell agree.

    Directions are lines here, whose senses may differ; and where two depths vanish together ldrb divides
    their round-off, so that single corners have no frame. Such cells take the principal direction of the
    corners that have one, in which neither sense nor numbering matters.

    Args:
        f: Fibre, changed.
        s: Sheet direction, changed.
        least: Cosine below which two corners are not apart by a turn of the fibre, but of opposite sense.
    """
    (one, places), (other, _) = _corners(f), _corners(s)
    wrong = np.abs((one * other).sum(axis=2))
    for values in (one, other):
        wrong = np.maximum(wrong, np.abs(np.linalg.norm(values, axis=2) - 1))
    bad = ~(wrong < 1e-6)
    _refuse(
        f.function_space.mesh,
        bad.all(axis=1),
        "in which the wall has no direction, such as those with all corners on one boundary",
    )
    for field, values in ((f, one), (s, other)):
        values[bad] = 0.0
        apart = bad.any(axis=1) | (np.einsum("cik,cjk->cij", values, values).min(axis=(1, 2)) < least)
        _, axes = np.linalg.eigh(np.einsum("cik,cil->ckl", values[apart], values[apart]))
        values[apart] = axes[:, None, :, -1]
        field.x.array.reshape(-1, 3)[places] = values


def _check_turn(f: fem.Function) -> None:
    """Refuse cells in which the fibre turns so far that there is no direction between the corners'."""
    values, _ = _corners(f)
    cosine = np.einsum("cik,cjk->cij", values, values).min(axis=(1, 2))
    _refuse(f.function_space.mesh, cosine < -0.9, "in which the fibre turns by more than 150 degrees")


def _refuse(mesh: Any, wrong: Any, what: str) -> None:
    owned = mesh.topology.index_map(3).size_local
    places = np.flatnonzero(wrong[:owned])
    comm = lasting(mesh.comm)
    number = comm.allreduce(len(places), MPI.SUM)
    if number:
        centres = mesh.geometry.x[mesh.geometry.dofmaps[0][places[:1]]].mean(axis=1).round(6).tolist()
        first = next(c[0] for c in comm.allgather(centres) if c)
        raise InputError(
            f"{number} cells {what}, one near {first}; choose a smaller spacing", "geometry.spacing"
        )


def _ldrb() -> Any:
    """The package ``ldrb``, imported where it is used."""
    try:
        with _cached():
            import ldrb
    except ImportError as missing:
        raise InputError(f"{HOW_TO_GET_IT} ({missing})", "fibres.kind") from missing
    return ldrb


@contextmanager
def _cached() -> Iterator[None]:
    """Let numba keep what it compiles: ldrb compiles for 15 s at every import, and does not keep it."""
    import numba

    plain: Any = numba.njit

    @functools.wraps(plain)
    def keeping(*arguments: Any, **options: Any) -> Any:
        if arguments and inspect.isfunction(arguments[0]):
            return plain(cache=True, **options)(*arguments)
        return plain(*arguments, cache=True, **options)

    numba.njit = keeping
    try:
        yield
    finally:
        numba.njit = plain
