"""The reference body, and fibres on it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from myostrain.engine import MPI, fem, lasting
from myostrain.errors import InputError, nearest
from myostrain.validation import Number, description

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import mesh as dmesh

#: More cells than this are refused before meshing: a misplaced decimal point must not fill the memory.
MAX_CELLS = 50_000_000


@dataclass(frozen=True)
class Meshed:
    """A mesh with named parts.

    Args:
        mesh: The mesh, whose geometry has its own dimension (1, 2 or 3).
        facet_tags: Tags of boundary facets, or None.
        boundaries: Tag of each named part of the boundary.
        cell_tags: Tags of cells, or None.
        regions: Tag of each named region.
    """

    mesh: dmesh.Mesh
    facet_tags: dmesh.MeshTags | None
    boundaries: Mapping[str, int]
    cell_tags: dmesh.MeshTags | None
    regions: Mapping[str, int]


@dataclass(frozen=True)
class Body:
    """A reference body: what solvers are made on.

    Args:
        meshed: Mesh and its named parts.
        f0: Unit fibre direction in the reference configuration, a UFL vector of the mesh's dimension.
    """

    meshed: Meshed
    f0: Any

    @property
    def mesh(self) -> dmesh.Mesh:
        """The mesh."""
        return self.meshed.mesh

    @property
    def dim(self) -> int:
        """Dimension of the mesh: 1, 2 or 3."""
        return self.mesh.geometry.dim

    @property
    def comm(self) -> Any:
        """The MPI communicator."""
        return lasting(self.mesh.comm)

    def boundary_facets(self, names: Iterable[str] | None, key: str | None = None) -> npt.NDArray[np.int32]:
        """Facets of the named parts of the boundary (local to this process); None means all of it.

        Args:
            names: The parts.
            key: Key of a case file that names them, for the message.

        Raises:
            InputError: A name is not one of the body's boundaries.
        """
        mesh, tdim = self.mesh, self.mesh.topology.dim
        mesh.topology.create_connectivity(tdim - 1, tdim)
        if names is None:
            return dmesh.exterior_facet_indices(mesh.topology)
        known = self.meshed.boundaries
        facets = [np.zeros(0, dtype=np.int32)]
        for name in names:
            if name not in known or self.meshed.facet_tags is None:
                hint = nearest(name, known) if known else "this mesh has no named boundaries"
                raise InputError(f"no boundary is called '{name}'; {hint}", key)
            facets.append(self.meshed.facet_tags.find(known[name]))
        return np.unique(np.concatenate(facets)).astype(np.int32)

    def boundary_measure(
        self, names: Iterable[str] | None, degree: int, key: str | None = None
    ) -> ufl.Measure:
        """Surface measure over the named parts of the boundary; None means all of it."""
        metadata = {"quadrature_degree": degree}
        if names is None:
            return ufl.Measure("ds", domain=self.mesh, metadata=metadata)
        facets = np.sort(self.boundary_facets(names, key))
        tags = dmesh.meshtags(self.mesh, self.mesh.topology.dim - 1, facets, np.ones_like(facets))
        return ufl.Measure("ds", domain=self.mesh, subdomain_data=tags, metadata=metadata)(1)

    def extent(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Lowest and highest coordinates of the body over all processes, each of length ``dim``."""
        return extent(self.mesh)

    @property
    def cells(self) -> int:
        """Number of cells over all processes."""
        return int(self.mesh.topology.index_map(self.mesh.topology.dim).size_global)


def extent(mesh: dmesh.Mesh) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Lowest and highest coordinates of a mesh over all processes, each as long as its dimension."""
    x = mesh.geometry.x[:, : mesh.geometry.dim]
    low, high = x.min(axis=0, initial=np.inf), x.max(axis=0, initial=-np.inf)
    mesh.comm.Allreduce(MPI.IN_PLACE, low, op=MPI.MIN)
    mesh.comm.Allreduce(MPI.IN_PLACE, high, op=MPI.MAX)
    return low, high


class Fibres(Protocol):
    """What a body asks of fibres."""

    def direction_on(self, meshed: Meshed) -> Any:
        """Unit fibre direction as a UFL vector of the mesh's dimension."""
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
        raise InputError(f"{d.tolist()} is no direction: give a finite, non-zero vector", key)
    return d / norm


@description
class UniformFibres:
    """One fibre direction in the whole body, or one in each named region.

    Args:
        direction: Fibre direction in the reference configuration; any length, made a unit vector.
        regions: Directions of named regions of the mesh that differ from ``direction``.
    """

    direction: tuple[Number, ...]
    regions: Mapping[str, tuple[Number, ...]] | None = None

    def direction_on(self, meshed: Meshed) -> Any:
        """Unit fibre direction as a UFL vector."""
        dim = meshed.mesh.geometry.dim
        n = unit(self.direction, dim, "fibres.direction")
        if not self.regions:
            return fem.Constant(meshed.mesh, n)
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
        return field


def build(geometry: Any, fibres: Fibres | None = None, comm: Any = MPI.COMM_WORLD) -> Body:
    """Mesh a geometry and lay fibres on it.

    Args:
        geometry: A description with ``mesh(comm)``.
        fibres: The fibres; may be left out on a line, where there is one direction only.
        comm: MPI communicator over which the mesh is spread.

    Raises:
        InputError: No fibres on a body of more than one dimension, or an unusable geometry.
    """
    meshed = geometry.mesh(comm)
    if fibres is None:
        if meshed.mesh.geometry.dim > 1:
            raise InputError("this body needs fibres, for example direction = [1, -1]", "fibres.direction")
        fibres = UniformFibres(direction=(1.0,))
    return Body(meshed, fibres.direction_on(meshed))


def cells_along(length: float, spacing: float) -> int:
    """Number of cells of about ``spacing`` along a length."""
    return max(1, round(length / spacing))


def check_size(cells: float, key: str = "geometry.spacing") -> None:
    """Refuse a mesh of more than :data:`MAX_CELLS` cells before it is made.

    Raises:
        InputError: There would be too many.
    """
    if cells > MAX_CELLS:
        raise InputError(
            f"this spacing gives about {cells:.2g} cells, more than {MAX_CELLS:.1g}: choose a larger one", key
        )


def tag_boundary(mesh: dmesh.Mesh, parts: Mapping[str, Any]) -> tuple[dmesh.MeshTags, dict[str, int]]:
    """Tag exterior facets by markers (functions of the coordinates (3, n)), numbered from 1."""
    tdim = mesh.topology.dim
    facets, values = [], []
    names = {name: number for number, name in enumerate(parts, start=1)}
    for name, marker in parts.items():
        found = dmesh.locate_entities_boundary(mesh, tdim - 1, marker)
        facets.append(found)
        values.append(np.full(found.shape, names[name], dtype=np.int32))
    index = np.concatenate(facets)
    order = np.argsort(index)
    return dmesh.meshtags(mesh, tdim - 1, index[order], np.concatenate(values)[order]), names
