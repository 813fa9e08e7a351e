"""Gmsh, imported only where it is used, and its model brought to DOLFINx."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
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


@contextmanager
def says(what: Any, key: str, hidden: str | None = None) -> Iterator[None]:
    """Turn what gmsh raises into an :class:`InputError` of one line.

    Args:
        what: What is read or made, for the message.
        key: Key of a case file, for the message.
        hidden: A name in gmsh's words that stands for ``what``.
    """
    try:
        yield
    except InputError:
        raise
    except Exception as error:  # gmsh raises plain Exception
        words = " ".join(str(error).split())
        if hidden:
            words = words.replace(hidden, str(what))
        raise InputError(f"{what}: gmsh says: {words}", key) from error


def to_meshed(comm: Any, make: Callable[[Any], int], what: str, key: str = "geometry.spacing") -> Meshed:
    """Make or read a gmsh model on the first process and spread it over all.

    Args:
        comm: MPI communicator.
        make: Called with the gmsh module on the first process; returns the dimension of the mesh.
        what: What is made, for messages.
        key: Key of a case file that decides about it, for messages.

    Raises:
        InputError: On every process, when it failed on the first.
    """
    with session() as gmsh:
        problem, dim = None, 0
        names: list[dict[str, int]] = []
        if comm.rank == 0:
            try:
                with says(what, key):
                    dim = make(gmsh)
                    names = [_names(gmsh.model, d, what) for d in (dim - 1, dim)]
            except InputError as error:
                problem = str(error)
        problem, dim, names = comm.bcast((problem, dim, names), root=0)
        if problem is not None:
            raise InputError(problem)
        data = dgmsh.model_to_mesh(gmsh.model, comm, 0, gdim=dim)
    boundaries, regions = names
    return Meshed(data.mesh, data.facet_tags, boundaries, data.cell_tags, regions)


def _names(model: Any, dim: int, what: str) -> dict[str, int]:
    """Tags of the physical groups of a dimension by name; a group without a name is called by its number."""
    tags = [tag for _, tag in model.getPhysicalGroups(dim)]
    named = [(model.getPhysicalName(dim, tag) or str(tag), int(tag)) for tag in tags]
    for name, tag in named:
        if dict(named)[name] != tag:
            raise InputError(
                f"{what} has a physical group of number {name} without a name and another called '{name}'; "
                "give the first a name",
                "geometry.path",
            )
    return dict(named)
