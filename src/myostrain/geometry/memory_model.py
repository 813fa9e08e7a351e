"""A mesh from a model that a script has in gmsh."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from myostrain.errors import InputError, nearest
from myostrain.geometry.checks import check
from myostrain.geometry.file import join_namesakes
from myostrain.geometry.gmsh_model import to_meshed
from myostrain.geometry.meshed import Meshed


@dataclass(frozen=True)
class GmshModel:
    """A meshed model of gmsh that is open in this process: the same as a file of it, without the file.

    On several processes the model is needed on the first one only. Its nodes may be numbered anew.

    Args:
        name: Name of the model; the current one unless given.
    """

    name: str | None = None

    def mesh(self, comm: Any) -> Meshed:
        """Take the mesh, and spread it over the processes of ``comm``.

        Raises:
            InputError: There is no such model, or it cannot be a body, see :class:`MeshFile`.
        """
        what = "the model in gmsh" if self.name is None else f"the gmsh model '{self.name}'"

        def make(gmsh: Any) -> int:
            if self.name is not None:
                known = [name for name in gmsh.model.list() if name]
                if self.name not in known:
                    raise InputError(f"gmsh has no model '{self.name}'; {nearest(self.name, known)}", "name")
                gmsh.model.setCurrent(self.name)
            dim = int(gmsh.model.getDimension())
            if dim < 0:
                raise InputError(
                    f"{what} is empty: make it and mesh it after gmsh.initialize(), and build the body "
                    "before gmsh.finalize()"
                )
            groups = gmsh.model.getPhysicalGroups()
            declared = {(d, tag): gmsh.model.getPhysicalName(d, tag) for d, tag in groups}
            join_namesakes(gmsh.model, dim, declared)
            tags, _, _ = gmsh.model.mesh.getNodes()
            if not len(tags):
                raise InputError(f"{what} is not meshed: call gmsh.model.mesh.generate({dim})")
            check(gmsh.model, dim, Path(what), declared)
            if tags.max() > len(tags):  # DOLFINx wants numbers without gaps
                gmsh.model.mesh.renumberNodes()
            return dim

        return to_meshed(comm, make, what, "geometry")
