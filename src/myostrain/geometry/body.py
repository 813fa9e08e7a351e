"""The reference body, and fibres on it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from myostrain.engine import MPI, lasting
from myostrain.errors import InputError
from myostrain.geometry.fibres import Fibres, Microstructure, UniformFibres
from myostrain.geometry.meshed import Meshed
from myostrain.validation import expect, shown_in_notebook

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import mesh as dmesh

Array = npt.NDArray[np.float64]

#: More cells than this are refused before meshing: a misplaced decimal point must not fill the memory.
MAX_CELLS = 50_000_000


@dataclass(frozen=True)
class Body:
    """A reference body: what solvers are made on.

    Args:
        meshed: Mesh and its named parts.
        fibres: Unit directions of fibres, sheets and sheet normals.
    """

    meshed: Meshed
    fibres: Microstructure

    def __repr__(self) -> str:
        """What it is made of, over all processes."""
        nodes = self.mesh.geometry.index_map().size_global
        parts = [f"dimension {self.dim}", f"{nodes} nodes", f"{self.cells} cells"]
        for what, names in (("boundaries", self.meshed.boundaries), ("regions", self.meshed.regions)):
            parts += [f"{what}: {', '.join(names)}"] if names else []
        return f"Body({'; '.join(parts)})"

    def _repr_html_(self) -> str:
        rows = {
            "dimension": self.dim,
            "nodes": self.mesh.geometry.index_map().size_global,
            "cells": self.cells,
            "boundaries": ", ".join(self.meshed.boundaries),
            "regions": ", ".join(self.meshed.regions),
            "processes": self.comm.size,
        }
        return shown_in_notebook("Body", rows)

    @property
    def mesh(self) -> dmesh.Mesh:
        """The mesh."""
        return self.meshed.mesh

    @property
    def f0(self) -> Any:
        """Unit fibre direction in the reference configuration, a UFL vector of the mesh's dimension."""
        return self.fibres.f0

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
            InputError: A name is not one of the body's boundaries, or some of its facets lie inside the body.
        """
        return self.meshed.facets(names, key)

    def boundary_measure(
        self, names: Iterable[str] | None, degree: int, key: str | None = None
    ) -> ufl.Measure:
        """Surface measure over the named parts of the boundary; None means all of it.

        All measures of a body share its tags, as the integrals of one form have to.
        """
        measure = ufl.Measure(
            "ds",
            domain=self.mesh,
            subdomain_data=self.meshed.facet_tags,
            metadata={"quadrature_degree": degree},
        )
        if names is None:
            return measure
        self.boundary_facets(names, key)  # says which name is wrong
        return measure(tuple(self.meshed.boundaries[name] for name in names))

    def extent(self) -> tuple[Array, Array]:
        """Lowest and highest coordinates of the body over all processes, each of length ``dim``."""
        return extent(self.mesh)

    @property
    def cells(self) -> int:
        """Number of cells over all processes."""
        return int(self.mesh.topology.index_map(self.mesh.topology.dim).size_global)


def extent(mesh: dmesh.Mesh) -> tuple[Array, Array]:
    """Lowest and highest coordinates of a mesh over all processes, each as long as its dimension."""
    return range_of(mesh.geometry.x[:, : mesh.geometry.dim], mesh.comm)


def range_of(points: Array, comm: Any) -> tuple[Array, Array]:
    """Lowest and highest coordinates (dim,) of the points (n, dim) of all processes (collective)."""
    low, high = points.min(axis=0, initial=np.inf), points.max(axis=0, initial=-np.inf)
    # By element: allreduce() compares its objects whole, which arrays are not made for.
    comm.Allreduce(MPI.IN_PLACE, low, op=MPI.MIN)
    comm.Allreduce(MPI.IN_PLACE, high, op=MPI.MAX)
    return low, high


def build(geometry: Any, fibres: Fibres | None = None, comm: Any = MPI.COMM_WORLD) -> Body:
    """Mesh a geometry and lay fibres on it.

    Args:
        geometry: A description with ``mesh(comm)``.
        fibres: The fibres; may be left out on a line, where there is one direction only.
        comm: MPI communicator over which the mesh is spread.

    Raises:
        InputError: No fibres on a body of more than one dimension, or an unusable geometry.
    """
    expect(geometry, "mesh", "geometry", "ms.geometry.Line(length=40.0)")
    meshed = geometry.mesh(comm)
    if fibres is None:
        if meshed.mesh.geometry.dim > 1:
            raise InputError("this body needs fibres, for example direction = [1, -1]", "fibres.direction")
        fibres = UniformFibres(direction=(1.0,))
    return Body(meshed, fibres.directions_on(meshed))


def cells_along(length: float, spacing: float) -> int:
    """Number of cells of about ``spacing`` along a length: the next whole one, of two the greater."""
    return max(1, math.floor(length / spacing + 0.5))


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
