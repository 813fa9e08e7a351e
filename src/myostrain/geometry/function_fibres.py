"""Fibres by a function of a script."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from myostrain.engine import fem, lasting
from myostrain.errors import InputError, shown
from myostrain.geometry.fibres import Microstructure
from myostrain.geometry.meshed import Meshed

import numpy as np
import numpy.typing as npt
import ufl

Array = npt.NDArray[np.float64]

#: The corners of a cell at which a function is asked lie within the cell by this share of the way to its
#: centre, so that directions that jump from cell to cell do.
WITHIN = 1e-6


@dataclass(frozen=True)
class FunctionFibres:
    """Fibre directions by a function of the material coordinates, of any length: they are normalized.

    A function of NumPy takes points X of shape (n, dim), one per row, and gives directions (n, dim). It is
    asked at the corners of each cell. Between them the direction is linear, made a unit vector: an error of
    second order. Directions that are opposite are the same fibre. A symbolic function takes
    ``ufl.SpatialCoordinate`` and gives a UFL vector, which holds exactly at every point.

    Args:
        fibre: The fibre.
        sheet: The sheet direction of a solid; its part across the fibre counts. None leaves it unknown.
        symbolic: Whether the functions are of UFL.

    Raises:
        InputError: What is given is not a function.
    """

    fibre: Callable[[Any], Any]
    sheet: Callable[[Any], Any] | None = None
    symbolic: bool = False

    def __post_init__(self) -> None:
        """Refuse what cannot be called."""
        for name, function in (("fibre", self.fibre), ("sheet", self.sheet)):
            if not (callable(function) or (name == "sheet" and function is None)):
                raise InputError(
                    f"give a function of points X (n, dim), such as lambda X: np.column_stack([-X[:, 1], "
                    f"X[:, 0]]), not {shown(function)}",
                    f"FunctionFibres.{name}",
                )

    def directions_on(self, meshed: Meshed) -> Microstructure:
        """Unit directions as UFL vectors (collective).

        Raises:
            InputError: A function raises, gives something of another shape, or no direction somewhere; a
                sheet is given on a body that is not a solid, or along the fibre.
        """
        mesh = meshed.mesh
        dim = mesh.geometry.dim
        if self.sheet is not None and dim != 3:
            raise InputError("a sheet direction is for a solid; leave it out", "FunctionFibres.sheet")
        make = _symbolic if self.symbolic else _nodal
        along = make(self.fibre, mesh, "FunctionFibres.fibre")
        f0 = along / ufl.sqrt(ufl.dot(along, along))
        if self.sheet is None:
            return Microstructure(f0)
        given = make(self.sheet, mesh, "FunctionFibres.sheet")
        across = given - ufl.dot(given, f0) * f0
        square = ufl.dot(across, across)
        _check_across(mesh, square / ufl.dot(given, given))
        s0 = across / ufl.sqrt(square)
        return Microstructure(f0, s0, ufl.cross(f0, s0))


def _symbolic(function: Callable[[Any], Any], mesh: Any, key: str) -> Any:
    dim = mesh.geometry.dim
    try:
        found = ufl.as_ufl(function(ufl.SpatialCoordinate(mesh)))
    except Exception as error:  # whatever the script raises
        raise InputError(
            f"raises {type(error).__name__}: {error}; symbolic=True takes UFL only", key
        ) from error
    if found.ufl_shape != (dim,):
        raise InputError(f"gives the shape {found.ufl_shape}; give a UFL vector of {dim} components", key)
    return found


def _nodal(function: Callable[[Any], Any], mesh: Any, key: str) -> fem.Function:
    """Directions at the corners of the cells, of one sense within each."""
    dim = mesh.geometry.dim
    field = fem.Function(fem.functionspace(mesh, ("DG", 1, (dim,))), name=key.rpartition(".")[2])
    corners = mesh.geometry.x[mesh.geometry.dofmaps[0]][..., :dim]
    inner = corners + WITHIN * (corners.mean(axis=1, keepdims=True) - corners)
    problem, values = "", np.empty(0)
    try:
        values = np.asarray(function(inner.reshape(-1, dim).copy()), dtype=float)
    except Exception as error:  # noqa: BLE001 - whatever the script raises
        problem = f"raises {type(error).__name__}: {error}; it is given points of shape (n, {dim})"
    points = inner.reshape(-1, dim)
    if not problem and values.shape != points.shape:
        problem = f"gives the shape {values.shape} for points {points.shape}; give one direction per point"
    elif not problem:
        lengths = np.linalg.norm(values, axis=1)
        wrong = np.flatnonzero(~((lengths > 0) & np.isfinite(lengths)))
        if len(wrong):
            where = [float(f"{x:.6g}") for x in points[wrong[0]]]
            problem = f"gives {values[wrong[0]].tolist()} at {where}; give a finite vector that is not zero"
    # All processes raise the same, or none.
    if found := next(filter(None, lasting(mesh.comm).allgather(problem)), ""):
        raise InputError(found, key)
    units = (values / lengths[:, None]).reshape(corners.shape)
    senses = np.sign(np.einsum("mci,mi->mc", units, units[:, 0]))
    units *= np.where(senses == 0, 1.0, senses)[..., None]
    nodes = field.function_space.dofmap.list
    field.x.array.reshape(-1, dim)[nodes] = units
    return field


def _check_across(mesh: Any, share: Any) -> None:
    """Refuse a sheet direction that is along the fibre in the middle of a cell (collective)."""
    cells = np.arange(mesh.topology.index_map(mesh.topology.dim).size_local, dtype=np.int32)
    middle = np.full((1, 3), 0.25)
    values = fem.Expression(share, middle).eval(mesh, cells)
    if min(lasting(mesh.comm).allgather(float(values.min(initial=1.0)))) < 1e-8:
        raise InputError("is along the fibre somewhere; give another direction", "FunctionFibres.sheet")
