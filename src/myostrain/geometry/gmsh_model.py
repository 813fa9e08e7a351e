"""Gmsh, imported only where it is used, and its model brought to DOLFINx."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from myostrain.errors import InputError
from myostrain.geometry.meshed import Meshed

import dolfinx.io.gmsh as dgmsh


@contextmanager
def session() -> Iterator[Any]:
    """A quiet gmsh, closed at the end."""
    try:
        import gmsh
    except (ImportError, OSError) as error:
        raise InputError(
            f"gmsh cannot be loaded ({error}); on a bare Debian or Ubuntu its system libraries come with "
            "`apt install libglu1-mesa libxft2 libxinerama1 libxcursor1`; the geometries 'line' and "
            "'rectangle' do without gmsh",
            "geometry.kind",
        ) from error
    started_here = not gmsh.isInitialized()
    if started_here:
        gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    try:
        yield gmsh
    finally:
        if started_here:
            gmsh.finalize()


def to_meshed(comm: Any, make: Callable[[Any], int], what: str) -> Meshed:
    """Make or read a gmsh model on the first process and spread it over all.

    Args:
        comm: MPI communicator.
        make: Called with the gmsh module on the first process; returns the dimension of the mesh.
        what: What is made, for messages.

    Raises:
        InputError: On every process, when it failed on the first.
    """
    with session() as gmsh:
        problem, dim, groups = None, 0, []
        if comm.rank == 0:
            try:
                dim = make(gmsh)
                groups = [(d, tag, _name(gmsh.model, d, tag)) for d, tag in gmsh.model.getPhysicalGroups()]
            except InputError as error:
                problem = str(error)
            except Exception as error:  # noqa: BLE001 - gmsh raises plain Exception
                says = " ".join(str(error).split())
                problem = f"geometry.path: {what}: gmsh says: {says}"
        problem, dim, groups = comm.bcast((problem, dim, groups), root=0)
        if problem is not None:
            raise InputError(problem)
        data = dgmsh.model_to_mesh(gmsh.model, comm, 0, gdim=dim)
    return Meshed(
        data.mesh,
        data.facet_tags,
        {name: tag for d, tag, name in groups if d == dim - 1},
        data.cell_tags,
        {name: tag for d, tag, name in groups if d == dim},
    )


def _name(model: Any, dim: int, tag: int) -> str:
    """Name of a physical group, or its number where it has none."""
    return model.getPhysicalName(dim, tag) or str(tag)


def readable(path: Path, key: str) -> None:
    """Refuse a path that is no readable, non-empty file.

    Raises:
        InputError: It is not.
    """
    try:
        if not path.is_file():
            raise InputError(f"there is no file {path}", key)
        if path.stat().st_size == 0:
            raise InputError(f"the file {path} is empty", key)
        with path.open("rb") as stream:
            stream.read(1)
    except OSError as error:
        raise InputError(f"the file {path} cannot be read: {error.strerror}", key) from error
