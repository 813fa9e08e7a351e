"""Fibres, sheets and sheet normals of a body."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from myostrain.engine import fem
from myostrain.errors import InputError, nearest
from myostrain.geometry.meshed import Meshed
from myostrain.validation import Number, description

import numpy as np
import numpy.typing as npt
import ufl


@dataclass(frozen=True)
class Microstructure:
    """Directions in the reference configuration, UFL vectors of unit length, orthogonal to each other.

    Args:
        f0: Fibre.
        s0: Sheet: across the fibre, within the sheet; None where it is not known.
        n0: Normal of the sheet; None where it is not known.
    """

    f0: Any
    s0: Any = None
    n0: Any = None

    def lifted(self, dim: int, tensor_dim: int) -> Microstructure:
        """The directions in the dimension that materials see.

        In a body of two dimensions the sheet direction lies across the fibre in its plane.
        """
        if dim == tensor_dim:
            return self
        x, y = self.f0[0], self.f0[1]
        return Microstructure(
            ufl.as_vector([x, y, 0]), ufl.as_vector([-y, x, 0]), ufl.as_vector([0.0, 0.0, 1.0])
        )


class Fibres(Protocol):
    """What a body asks of fibres."""

    def directions_on(self, meshed: Meshed) -> Microstructure:
        """Unit directions as UFL vectors of the mesh's dimension."""
        ...


def unit(direction: Iterable[float], dim: int, key: str | None = None) -> npt.NDArray[np.float64]:
    """The direction as a unit vector.

    Raises:
        InputError: It has another length than ``dim``, is zero, or is not finite.
    """
    d = np.asarray(tuple(direction), dtype=float)
    if d.shape != (dim,):
        raise InputError(f"{d.tolist()} has {d.size} components, the body has dimension {dim}", key)
    norm = np.linalg.norm(d)
    if not np.isfinite(norm) or norm == 0:
        raise InputError(f"{d.tolist()} is not a direction: give a finite, non-zero vector", key)
    return d / norm


@description
class UniformFibres:
    """One fibre direction in the whole body, or one in each named region.

    Args:
        direction: Fibre direction in the reference configuration; of any length, it is normalized.
        regions: Directions of named regions of the mesh that differ from ``direction``.
        sheet: Sheet direction of a solid; its part across the fibre counts, normalized. Only for
            fibres without ``regions``.
    """

    direction: tuple[Number, ...]
    regions: Mapping[str, tuple[Number, ...]] | None = None
    sheet: tuple[Number, ...] | None = None

    def directions_on(self, meshed: Meshed) -> Microstructure:
        """Unit directions as UFL vectors.

        Raises:
            InputError: A direction has another dimension than the body, or is zero; a region does not exist;
                or the sheet direction is along the fibre, of no solid, or beside regions.
        """
        dim = meshed.mesh.geometry.dim
        n = unit(self.direction, dim, "fibres.direction")
        if self.sheet is not None:
            return self._with_sheet(meshed, n)
        if not self.regions:
            return Microstructure(fem.Constant(meshed.mesh, n))
        field = fem.Function(fem.functionspace(meshed.mesh, ("DG", 0, (dim,))), name="fibre")
        values = field.x.array.reshape(-1, dim)
        values[:] = n
        for name, direction in self.regions.items():
            if name not in meshed.regions or meshed.cell_tags is None:
                hint = nearest(name, meshed.regions) if meshed.regions else "this mesh has no named regions"
                raise InputError(f"no region is called '{name}'; {hint}", "fibres.regions")
            values[meshed.cell_tags.find(meshed.regions[name])] = unit(
                direction, dim, f"fibres.regions.{name}"
            )
        field.x.scatter_forward()
        return Microstructure(field)

    def _with_sheet(self, meshed: Meshed, f0: npt.NDArray[np.float64]) -> Microstructure:
        assert self.sheet is not None
        if len(f0) != 3 or self.regions:
            raise InputError("a sheet direction is for a solid without regions; leave it out", "fibres.sheet")
        given = unit(self.sheet, 3, "fibres.sheet")
        across = given - (given @ f0) * f0
        if np.linalg.norm(across) < 1e-6:
            raise InputError(f"{list(self.sheet)} is along the fibre; give another direction", "fibres.sheet")
        s0 = across / np.linalg.norm(across)
        return Microstructure(*(fem.Constant(meshed.mesh, d) for d in (f0, s0, np.cross(f0, s0))))
